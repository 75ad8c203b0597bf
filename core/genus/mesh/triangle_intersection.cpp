#include "genus/mesh/triangle_intersection.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "genus/base/predicates.h"

namespace genus {

namespace {

using Signs = std::array<int, 3>;

// A view along one axis, chosen so that `t` does not shrink to a segment; exact, for it only
// leaves out a coordinate.
class View {
public:
    // False if the triangle has no area.
    bool choose(const TrianglePoints& t)
    {
        const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
        std::array<std::size_t, 3> axes{0, 1, 2};
        std::sort(axes.begin(), axes.end(), [&](std::size_t i, std::size_t j) {
            const double p = std::fabs(n[i]), q = std::fabs(n[j]);
            return p != q ? p > q : i < j;
        });
        for (const std::size_t axis : axes) {
            x_ = (axis + 1) % 3;
            y_ = (axis + 2) % 3;
            if (orient(t[0], t[1], t[2]) != 0) return true;
        }
        return false;
    }

    int orient(const Vec3& a, const Vec3& b, const Vec3& c) const
    {
        return orient2d(flat(a), flat(b), flat(c));
    }

private:
    Vec2 flat(const Vec3& p) const { return {{p[x_], p[y_]}}; }

    std::size_t x_ = 0, y_ = 1;
};

Signs sides_of_plane(const TrianglePoints& plane, const TrianglePoints& t)
{
    Signs signs;
    for (std::size_t i = 0; i < 3; ++i) signs[i] = orient3d(plane[0], plane[1], plane[2], t[i]);
    return signs;
}

bool all_on_one_side(const Signs& s)
{
    return (s[0] > 0 && s[1] > 0 && s[2] > 0) || (s[0] < 0 && s[1] < 0 && s[2] < 0);
}

bool all_zero(const Signs& s)
{
    return s[0] == 0 && s[1] == 0 && s[2] == 0;
}

// ---- in one plane ---------------------------------------------------------------------------

bool in_triangle(const View& view, const Vec3& p, const TrianglePoints& t)
{
    const int a = view.orient(t[0], t[1], p), b = view.orient(t[1], t[2], p);
    const int c = view.orient(t[2], t[0], p);
    return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

// p on the line of the segment: between its ends?
bool between(const Vec3& p, const Vec3& a, const Vec3& b)
{
    for (std::size_t i = 0; i < 3; ++i)
        if (p[i] < std::min(a[i], b[i]) || p[i] > std::max(a[i], b[i])) return false;
    return true;
}

bool segments_meet(const View& view, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    const int abc = view.orient(a, b, c), abd = view.orient(a, b, d);
    const int cda = view.orient(c, d, a), cdb = view.orient(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && between(c, a, b)) || (abd == 0 && between(d, a, b)) ||
           (cda == 0 && between(a, c, d)) || (cdb == 0 && between(b, c, d));
}

bool segment_meets_flat(const View& view, const Vec3& p, const Vec3& q, const TrianglePoints& t)
{
    if (in_triangle(view, p, t) || in_triangle(view, q, t)) return true;
    for (std::size_t i = 0; i < 3; ++i)
        if (segments_meet(view, p, q, t[i], t[(i + 1) % 3])) return true;
    return false;
}

bool flat_triangles_meet(const View& view, const TrianglePoints& a, const TrianglePoints& b)
{
    for (std::size_t i = 0; i < 3; ++i)
        if (segment_meets_flat(view, a[i], a[(i + 1) % 3], b)) return true;
    return in_triangle(view, b[0], a);
}

// Does the direction from apex to p lie in the closed angle of the triangle apex, u, w?
bool in_angle(const View& view, const Vec3& apex, const Vec3& p, const Vec3& u, const Vec3& w)
{
    const int turn = view.orient(apex, u, w);
    const int from_u = view.orient(apex, u, p), to_w = view.orient(apex, p, w);
    // Opposite to a leg one of the two is zero and the other has the wrong sign.
    return from_u * turn >= 0 && to_w * turn >= 0;
}

// ---- across planes --------------------------------------------------------------------------

// Side p q against triangle t, where `sp`, `sq` tell on which side of its plane p and q are.
bool segment_meets(const View& view, const Vec3& p, const Vec3& q, int sp, int sq,
                   const TrianglePoints& t)
{
    if (sp * sq > 0) return false;
    if (sp == 0 && sq == 0) return segment_meets_flat(view, p, q, t);
    if (sp == 0) return in_triangle(view, p, t);
    if (sq == 0) return in_triangle(view, q, t);
    const int a = orient3d(p, q, t[0], t[1]), b = orient3d(p, q, t[1], t[2]);
    const int c = orient3d(p, q, t[2], t[0]);
    return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool any_side_meets(const TrianglePoints& a, const Signs& signs, const View& view_of_b,
                    const TrianglePoints& b)
{
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        if (segment_meets(view_of_b, a[i], a[j], signs[i], signs[j], b)) return true;
    }
    return false;
}

// ---- by the number of shared corners ----------------------------------------------------------

struct PairData {
    const TrianglePoints& a;
    const TrianglePoints& b;
    Signs a_signs;  // corners of a against the plane of b
    Signs b_signs;
    View a_view, b_view;
};

TriangleContact none_shared(const PairData& pair)
{
    const bool meet = all_zero(pair.a_signs)
                          ? flat_triangles_meet(pair.a_view, pair.a, pair.b)
                          : any_side_meets(pair.a, pair.a_signs, pair.b_view, pair.b) ||
                                any_side_meets(pair.b, pair.b_signs, pair.a_view, pair.a);
    return meet ? TriangleContact::Crossing : TriangleContact::Disjoint;
}

// What two triangles have in common is convex. If it is more than the shared corner v it reaches
// from v to the side opposite in one of them, or runs along a side at v that lies in the other's
// plane.
bool more_than_corner(const TrianglePoints& a, const Signs& signs, const View& view_of_b,
                      const TrianglePoints& b, std::size_t i, std::size_t j)
{
    const std::size_t p = (i + 1) % 3, q = (i + 2) % 3;
    const Vec3 &u = b[(j + 1) % 3], &w = b[(j + 2) % 3];
    if (signs[p] == 0 && in_angle(view_of_b, b[j], a[p], u, w)) return true;
    if (signs[q] == 0 && in_angle(view_of_b, b[j], a[q], u, w)) return true;
    return signs[p] * signs[q] < 0 && segment_meets(view_of_b, a[p], a[q], signs[p], signs[q], b);
}

TriangleContact one_shared(const PairData& pair, std::size_t i, std::size_t j)
{
    const bool more = more_than_corner(pair.a, pair.a_signs, pair.b_view, pair.b, i, j) ||
                      more_than_corner(pair.b, pair.b_signs, pair.a_view, pair.a, j, i);
    return more ? TriangleContact::Crossing : TriangleContact::SharedCorner;
}

// `p` and `q` are the shared corners, `r` and `s` the others. Only in one plane, with r and s on
// the same side, is there more than the side.
TriangleContact two_shared(const TrianglePoints& a, const Vec3& p, const Vec3& q, const Vec3& r,
                           const Vec3& s)
{
    if (orient3d(p, q, r, s) != 0) return TriangleContact::SharedSide;
    View view;
    if (!view.choose(a)) return TriangleContact::Degenerate;
    const int r_side = view.orient(p, q, r), s_side = view.orient(p, q, s);
    if (s_side == 0) return TriangleContact::Degenerate;
    return r_side == s_side ? TriangleContact::Crossing : TriangleContact::SharedSide;
}

struct SharedCorners {
    std::size_t n = 0;
    std::array<std::array<std::size_t, 2>, 3> pairs{};
};

SharedCorners shared_corners(const TrianglePoints& a, const TrianglePoints& b)
{
    SharedCorners shared;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            if (a[i] == b[j] && shared.n < 3) shared.pairs[shared.n++] = {i, j};
    return shared;
}

bool repeats_a_corner(const TrianglePoints& t)
{
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

}  // namespace

bool has_no_area(const TrianglePoints& t)
{
    return !View().choose(t);
}

TriangleContact triangle_contact(const TrianglePoints& a, const TrianglePoints& b)
{
    if (repeats_a_corner(a) || repeats_a_corner(b)) return TriangleContact::Degenerate;
    const SharedCorners shared = shared_corners(a, b);
    if (shared.n == 3)
        return has_no_area(a) ? TriangleContact::Degenerate : TriangleContact::Crossing;
    const auto [i, j] = shared.pairs[0];
    if (shared.n == 2) {
        const auto [k, l] = shared.pairs[1];
        return two_shared(a, a[i], a[k], a[3 - i - k], b[3 - j - l]);
    }
    PairData pair{a, b, sides_of_plane(b, a), {}, {}, {}};
    if (shared.n == 0 && all_on_one_side(pair.a_signs)) return TriangleContact::Disjoint;
    // With one corner on the plane and the others on one side of it, no more than that corner
    // can be common.
    if (shared.n == 1 && pair.a_signs[(i + 1) % 3] * pair.a_signs[(i + 2) % 3] > 0)
        return TriangleContact::SharedCorner;
    pair.b_signs = sides_of_plane(a, b);
    if (shared.n == 0 && all_on_one_side(pair.b_signs)) return TriangleContact::Disjoint;
    if (shared.n == 1 && pair.b_signs[(j + 1) % 3] * pair.b_signs[(j + 2) % 3] > 0)
        return TriangleContact::SharedCorner;
    if (!pair.a_view.choose(a) || !pair.b_view.choose(b)) return TriangleContact::Degenerate;
    return shared.n == 0 ? none_shared(pair) : one_shared(pair, i, j);
}

}  // namespace genus
