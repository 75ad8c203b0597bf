#include "genus/boolean/plates.h"

#include <algorithm>
#include <cmath>

#include "genus/base/parallel.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

// Height above a plane, as a share of the lengths in question, at which rounding cannot hide it.
constexpr double kSurelyOff = 1e-10;

const Vec3& start_of(const Soup& soup, Index h)
{
    return soup.points[soup.faces[h / 3][h % 3]];
}

double sum_of_sizes(const Vec3& v)
{
    return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
}

// Do the faces at halfedge h make a strictly convex quadrangle of one plane?
bool make_quadrangle(const Soup& soup, Index h, const Vec3& normal)
{
    const Index twin = soup.twin[h];
    const Vec3& a = start_of(soup, h);
    const Vec3& d = start_of(soup, prev_in_face(twin));
    const Vec3 ad = d - a;
    if (std::abs(dot(normal, ad)) > kSurelyOff * sum_of_sizes(normal) * sum_of_sizes(ad))
        return false;
    if (!same_plane(soup, h)) return false;
    const Vec3& b = start_of(soup, twin);
    const Vec3& c = start_of(soup, prev_in_face(h));
    const int axis = dominant_axis(a, b, c);
    const int sign = turn(axis, a, b, c);
    return turn(axis, d, b, c) == sign && turn(axis, c, a, d) == sign;
}

}  // namespace

bool same_plane(const Soup& soup, Index h)
{
    const Index twin = soup.twin[h];
    const Vec3 &a = start_of(soup, h), &b = start_of(soup, twin);
    const Vec3 &c = start_of(soup, prev_in_face(h)), &d = start_of(soup, prev_in_face(twin));
    if (side_of_plane(a, b, c, d) != 0) return false;
    const int axis = dominant_axis(a, b, c);
    return turn(axis, a, b, c) == turn(axis, b, a, d);
}

Plates::Plates(const Soup& soup, const std::vector<Index>& owners)
{
    const auto n = static_cast<Index>(soup.faces.size());
    for (Index f = 0; f < n; ++f) {
        if (diagonal(f) >= 0) continue;
        const Vec3& a = start_of(soup, 3 * f);
        const Vec3 normal = cross(start_of(soup, 3 * f + 1) - a, start_of(soup, 3 * f + 2) - a);
        for (Index h = 3 * f; h < 3 * f + 3; ++h) {
            const Index twin = soup.twin[h];
            if (twin < 3 * f || owners[twin / 3] != owners[f] || diagonal(twin / 3) >= 0) continue;
            if (!make_quadrangle(soup, h, normal)) continue;
            if (diagonal_.empty()) diagonal_.assign(soup.faces.size(), -1);
            diagonal_[f] = h;
            diagonal_[twin / 3] = twin;
            break;
        }
    }
}

Outline Plates::outline(const Soup& soup, Index f) const
{
    const Index h = diagonal(f);
    if (h < 0) return {3, {3 * f, 3 * f + 1, 3 * f + 2, -1}};
    const Index twin = soup.twin[h];
    return {4, {next_in_face(h), prev_in_face(h), next_in_face(twin), prev_in_face(twin)}};
}

Corners Plates::quadrangle(const Soup& soup, Index f) const
{
    const Outline round = outline(soup, f);
    Corners c;
    c.n = round.n;
    for (int i = 0; i < c.n; ++i) {
        c.id[i] = soup.faces[round.halfedge[i] / 3][round.halfedge[i] % 3];
        c.at[i] = &soup.points[c.id[i]];
    }
    return c;
}

PlateTree::PlateTree(const Soup& soup, std::vector<Index> owners)
{
    plates_ = Plates(soup, owners);
    const bool all_sought = std::find(owners.begin(), owners.end(), kNotSought) == owners.end();
    if (!plates_.empty() || !all_sought) {
        for (Index f = 0; f < static_cast<Index>(soup.faces.size()); ++f) {
            const Index g = plates_.other(soup, f);
            if (owners[f] != kNotSought && (g < 0 || f < g)) face_.push_back(f);
        }
        if (face_.empty()) return;  // no face is sought: the tree is empty
        for (std::size_t i = 0; i < face_.size(); ++i) owners[i] = owners[face_[i]];
        owners.resize(face_.size());
    }
    tree_ = BoxTree(boxes(soup), std::move(owners));
}

PlateTree PlateTree::of_faces(const Soup& soup)
{
    PlateTree result;
    result.tree_ = BoxTree(result.boxes(soup), {});
    return result;
}

std::vector<FloatBox> PlateTree::boxes(const Soup& soup) const
{
    std::vector<FloatBox> boxes(face_.empty() ? soup.faces.size() : face_.size());
    parallel_for(boxes.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Index f = face(static_cast<Index>(i));
            const auto box = [&](Index g) {
                const Triangle& t = soup.faces[g];
                return box_of(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
            };
            boxes[i] = box(f);
            if (const Index g = plates_.other(soup, f); g >= 0) boxes[i].add(box(g));
        }
    });
    return boxes;
}

}  // namespace genus::exact
