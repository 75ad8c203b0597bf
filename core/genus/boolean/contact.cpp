#include "genus/boolean/contact.h"

#include <algorithm>
#include <cassert>

#include "genus/boolean/exact_point.h"

namespace genus::exact {

namespace {

constexpr int kOutside = -1;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

// A triangle with the axis along which its own plane is looked at.
struct Flat {
    const Corners& t;
    int axis;
    int sign;

    explicit Flat(const Corners& corners) : t(corners)
    {
        axis = dominant_axis(*t.at[0], *t.at[1], *t.at[2]);
        sign = normal_sign(axis, *t.at[0], *t.at[1], *t.at[2]);
    }
    int side_of_edge(int edge, const Vec3& p) const
    {
        return sign * turn(axis, *t.at[edge], *t.at[next(edge)], p);
    }
};

int place_of(const std::array<int, 3>& sides)
{
    int zeros = 0;
    int sum = 0;
    for (int i = 0; i < 3; ++i) {
        if (sides[i] < 0) return kOutside;
        if (sides[i] == 0) {
            ++zeros;
            sum += i;
        }
    }
    if (zeros == 0) return Contact::kInside;
    if (zeros == 1) return 3 + sum;
    // Edges i and i + 1 meet in corner i + 1; sums 1, 3, 2 stand for corners 1, 2, 0.
    return sum == 1 ? 1 : (sum == 3 ? 2 : 0);
}

int corner_with(const Corners& t, std::int32_t id)
{
    for (int i = 0; i < 3; ++i)
        if (t.id[i] == id) return i;
    return kOutside;
}

// Where point `p` of f's plane, numbered `id`, lies in f.
int locate(const Flat& f, std::int32_t id, const Vec3& p)
{
    const int corner = corner_with(f.t, id);
    if (corner != kOutside) return corner;
    std::array<int, 3> sides;
    for (int i = 0; i < 3; ++i) sides[i] = f.side_of_edge(i, p);
    return place_of(sides);
}

// Where the line from p to q, which crosses f's plane, passes it.
int pierce(const Corners& f, const Vec3& p, const Vec3& q, int side_of_q)
{
    std::array<int, 3> sides;
    for (int i = 0; i < 3; ++i)
        sides[i] = side_of_q * side_of_plane(p, q, *f.at[i], *f.at[next(i)]);
    return place_of(sides);
}

std::array<int, 3> sides_of(const Corners& f, const Corners& g)
{
    const SideOfPlane side(*f.at[0], *f.at[1], *f.at[2]);
    std::array<int, 3> sides;
    for (int i = 0; i < 3; ++i)
        sides[i] = corner_with(f, g.id[i]) != kOutside ? 0 : side.of(*g.at[i]);
    return sides;
}

// Are the corners of g that f has not all strictly on one side of f?
bool leaves_on_one_side(const Corners& f, const Corners& g)
{
    const SideOfPlane side_of_f(*f.at[0], *f.at[1], *f.at[2]);
    int side = 0;
    for (int i = 0; i < 3; ++i) {
        if (corner_with(f, g.id[i]) != kOutside) continue;
        const int here = side_of_f.of(*g.at[i]);
        if (here == 0 || here == -side) return false;
        side = here;
    }
    return side != 0;
}

bool one_sided(const std::array<int, 3>& s)
{
    return (s[0] > 0 && s[1] > 0 && s[2] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0);
}

void meet_in_plane(const Corners& f, const Corners& g, Contact& contact)
{
    const Flat flat_f(f);
    Flat flat_g(g);
    for (int i = 0; i < 3; ++i) {
        const int on_f = locate(flat_f, g.id[i], *g.at[i]);
        if (on_f != kOutside) contact.add(on_f, i);
        const int on_g = locate(flat_g, f.id[i], *f.at[i]);
        if (on_g != kOutside) contact.add(i, on_g);
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int a = flat_f.side_of_edge(i, *g.at[j]) * flat_f.side_of_edge(i, *g.at[next(j)]);
            if (a >= 0) continue;
            const int b = flat_g.side_of_edge(j, *f.at[i]) * flat_g.side_of_edge(j, *f.at[next(i)]);
            if (b < 0) contact.add(3 + i, 3 + j);
        }
    int shared = 0;
    for (int i = 0; i < 3; ++i) shared += corner_with(f, g.id[i]) != kOutside;
    contact.coplanar = shared == 3 || !contact.trivial();
}

}  // namespace

bool Contact::trivial() const
{
    return !coplanar && std::all_of(events.begin(), events.begin() + n_events,
                                    [](const Event& e) { return e.on_f < 3 && e.on_g < 3; });
}

void Contact::add(int on_f, int on_g)
{
    const Event event{static_cast<std::int8_t>(on_f), static_cast<std::int8_t>(on_g)};
    const auto end = events.begin() + n_events;
    if (std::find(events.begin(), end, event) != end) return;
    assert(n_events < static_cast<int>(events.size()));
    events[n_events++] = event;
}

void number_corners(Corners& f, Corners& g)
{
    f.id = {0, 1, 2};
    for (int j = 0; j < 3; ++j) {
        g.id[j] = 3 + j;
        for (int i = 0; i < 3; ++i)
            if (*f.at[i] == *g.at[j]) g.id[j] = i;
    }
}

bool certainly_apart(const Corners& f, const Corners& g)
{
    return leaves_on_one_side(f, g) || leaves_on_one_side(g, f);
}

Contact find_contact(const Corners& f, const Corners& g)
{
    Contact contact;
    const std::array<int, 3> g_sides = sides_of(f, g);
    if (one_sided(g_sides)) return contact;
    const std::array<int, 3> f_sides = sides_of(g, f);
    if (one_sided(f_sides)) return contact;
    if (g_sides == std::array<int, 3>{0, 0, 0}) {
        meet_in_plane(f, g, contact);
        return contact;
    }
    for (int i = 0; i < 3; ++i) {
        if (g_sides[i] == 0) {
            const int on_f = locate(Flat(f), g.id[i], *g.at[i]);
            if (on_f != kOutside) contact.add(on_f, i);
        }
        if (f_sides[i] == 0) {
            const int on_g = locate(Flat(g), f.id[i], *f.at[i]);
            if (on_g != kOutside) contact.add(i, on_g);
        }
    }
    for (int i = 0; i < 3; ++i) {
        const int j = next(i);
        if (g_sides[i] * g_sides[j] < 0) {
            const int on_f = pierce(f, *g.at[i], *g.at[j], g_sides[j]);
            if (on_f > 2) contact.add(on_f, 3 + i);  // corners of f came up above
        }
        if (f_sides[i] * f_sides[j] < 0) {
            const int on_g = pierce(g, *f.at[i], *f.at[j], f_sides[j]);
            if (on_g > 2) contact.add(3 + i, on_g);
        }
    }
    return contact;
}

}  // namespace genus::exact
