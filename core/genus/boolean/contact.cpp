#include "genus/boolean/contact.h"

#include <algorithm>
#include <cassert>

#include "genus/boolean/exact_point.h"

namespace genus::exact {

namespace {

constexpr int kOutside = -1;

// A piece with the axis along which its own plane is looked at.
struct Flat {
    const Corners& t;
    int axis;
    int sign;

    explicit Flat(const Corners& corners) : t(corners)
    {
        axis = dominant_axis(*t.at[0], *t.at[1], *t.at[2]);
        sign = turn(axis, *t.at[0], *t.at[1], *t.at[2]);
    }
    int side_of_edge(int edge, const Vec3& p) const
    {
        return sign * turn(axis, *t.at[edge], *t.at[t.next(edge)], p);
    }
};

using Sides = std::array<int, 4>;  // by corner, or by edge

// Where something lies that is on these sides of the edges of f.
int place_of(const Corners& f, const Sides& sides)
{
    int zeros = 0;
    int edge = 0;
    for (int i = 0; i < f.n; ++i) {
        if (sides[i] < 0) return kOutside;
        if (sides[i] != 0) continue;
        // Two edges meet in the corner where the second starts, which is the first corner only if
        // these are the last edge and the first.
        edge = zeros == 1 && edge == 0 && i == f.n - 1 ? 0 : i;
        ++zeros;
    }
    if (zeros == 0) return Contact::kInside;
    return zeros == 1 ? Contact::kEdge + edge : edge;
}

int corner_with(const Corners& t, std::int32_t id)
{
    for (int i = 0; i < t.n; ++i)
        if (t.id[i] == id) return i;
    return kOutside;
}

// Where point `p` of f's plane, numbered `id`, lies in f.
int locate(const Flat& f, std::int32_t id, const Vec3& p)
{
    const int corner = corner_with(f.t, id);
    if (corner != kOutside) return corner;
    Sides sides{};
    for (int i = 0; i < f.t.n; ++i) sides[i] = f.side_of_edge(i, p);
    return place_of(f.t, sides);
}

// Where the line from p to q, which crosses f's plane, passes it.
int pierce(const Corners& f, const Vec3& p, const Vec3& q, int side_of_q)
{
    Sides sides{};
    for (int i = 0; i < f.n; ++i)
        sides[i] = side_of_q * side_of_plane(p, q, *f.at[i], *f.at[f.next(i)]);
    return place_of(f, sides);
}

// The sides of the plane of f on which the corners of g lie.
Sides sides_of(const Corners& f, const Corners& g)
{
    const SideOfPlane side(*f.at[0], *f.at[1], *f.at[2]);
    Sides sides{};
    for (int i = 0; i < g.n; ++i)
        sides[i] = corner_with(f, g.id[i]) != kOutside ? 0 : side.of(*g.at[i]);
    return sides;
}

// Do the pieces have two opposite corners of f, a quadrangle, in common?
bool share_diagonal(const Corners& f, const Corners& g)
{
    if (f.n < 4) return false;
    const auto shared = [&](int i) { return corner_with(g, f.id[i]) != kOutside; };
    return (shared(0) && shared(2)) || (shared(1) && shared(3));
}

// Are the corners of g that f has not all strictly on one side of f?
bool leaves_on_one_side(const Corners& f, const Corners& g)
{
    const SideOfPlane side_of_f(*f.at[0], *f.at[1], *f.at[2]);
    int side = 0;
    for (int i = 0; i < g.n; ++i) {
        if (corner_with(f, g.id[i]) != kOutside) continue;
        const int here = side_of_f.of(*g.at[i]);
        if (here == 0 || here == -side) return false;
        side = here;
    }
    return side != 0;
}

bool one_sided(const Corners& f, const Sides& s)
{
    for (int i = 0; i < f.n; ++i)
        if (s[i] == 0 || s[i] != s[0]) return false;
    return true;
}

void meet_in_plane(const Corners& f, const Corners& g, Contact& contact)
{
    const Flat flat_f(f);
    const Flat flat_g(g);
    int shared = 0;
    for (int i = 0; i < g.n; ++i) {
        const int on_f = locate(flat_f, g.id[i], *g.at[i]);
        if (on_f != kOutside) contact.add(on_f, i);
        shared += corner_with(f, g.id[i]) != kOutside;
    }
    for (int i = 0; i < f.n; ++i) {
        const int on_g = locate(flat_g, f.id[i], *f.at[i]);
        if (on_g != kOutside) contact.add(i, on_g);
    }
    for (int i = 0; i < f.n; ++i)
        for (int j = 0; j < g.n; ++j) {
            const int a =
                flat_f.side_of_edge(i, *g.at[j]) * flat_f.side_of_edge(i, *g.at[g.next(j)]);
            if (a >= 0) continue;
            const int b =
                flat_g.side_of_edge(j, *f.at[i]) * flat_g.side_of_edge(j, *f.at[f.next(i)]);
            if (b < 0) contact.add(Contact::kEdge + i, Contact::kEdge + j);
        }
    contact.coplanar = shared >= 3 || !contact.trivial();
}

}  // namespace

bool Contact::trivial() const
{
    return !coplanar && std::all_of(events.begin(), events.begin() + n_events, [](const Event& e) {
        return is_corner(e.on_f) && is_corner(e.on_g);
    });
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
    f.id = {0, 1, 2, 3};
    for (int j = 0; j < g.n; ++j) {
        g.id[j] = 4 + j;
        for (int i = 0; i < f.n; ++i)
            if (*f.at[i] == *g.at[j]) g.id[j] = i;
    }
}

int edge_along(const Corners& piece, int a, int b)
{
    for (int i = 0; i < piece.n; ++i) {
        const auto on = [&](int place) {
            return place == i || place == piece.next(i) || place == Contact::kEdge + i;
        };
        if (on(a) && on(b)) return i;
    }
    return -1;
}

bool certainly_apart(const Corners& f, const Corners& g)
{
    return (leaves_on_one_side(f, g) || leaves_on_one_side(g, f)) && !share_diagonal(f, g) &&
           !share_diagonal(g, f);
}

Contact find_contact(const Corners& f, const Corners& g)
{
    Contact contact;
    const Sides g_sides = sides_of(f, g);
    if (one_sided(g, g_sides)) return contact;
    const Sides f_sides = sides_of(g, f);
    if (one_sided(f, f_sides)) return contact;
    if (g_sides == Sides{}) {
        meet_in_plane(f, g, contact);
        return contact;
    }
    for (int i = 0; i < g.n; ++i)
        if (g_sides[i] == 0) {
            const int on_f = locate(Flat(f), g.id[i], *g.at[i]);
            if (on_f != kOutside) contact.add(on_f, i);
        }
    for (int i = 0; i < f.n; ++i)
        if (f_sides[i] == 0) {
            const int on_g = locate(Flat(g), f.id[i], *f.at[i]);
            if (on_g != kOutside) contact.add(i, on_g);
        }
    for (int i = 0; i < g.n; ++i) {
        const int j = g.next(i);
        if (g_sides[i] * g_sides[j] >= 0) continue;
        const int on_f = pierce(f, *g.at[i], *g.at[j], g_sides[j]);
        if (on_f >= Contact::kEdge) contact.add(on_f, Contact::kEdge + i);  // corners came up above
    }
    for (int i = 0; i < f.n; ++i) {
        const int j = f.next(i);
        if (f_sides[i] * f_sides[j] >= 0) continue;
        const int on_g = pierce(g, *f.at[i], *f.at[j], f_sides[j]);
        if (on_g >= Contact::kEdge) contact.add(Contact::kEdge + i, on_g);
    }
    return contact;
}

}  // namespace genus::exact
