#include "genus/model/normal_offsets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace genus {

namespace {

// Of directions that are taken for normals: of two of them together, at most. What each may have by
// its angle, its length and the rounding of the gradient is less than half of that.
constexpr double kSlant = 1e-6;
constexpr double kCosine2 = 1.0 - kSlant * kSlant / 64.0, kLength = 0.125 * kSlant,
                 kRounding = kSlant / 32.0;
constexpr double kThird = 0.34;

}  // namespace

double slope_along_normal(const FineMesh& fine, std::int32_t vertex,
                          const std::vector<SurfaceForm>& forms)
{
    const auto& surfaces = fine.surface.surfaces_of_vertex[vertex];
    const SurfaceForm& form = forms[surfaces[0]];
    if (surfaces[1] >= 0 || !form.is_quadratic()) return 0.0;
    const Vec3 g = form.gradient(fine.surface.mesh.vertices[vertex]), d = fine.direction[vertex];
    const double gg = dot(g, g), dd = dot(d, d), gd = dot(g, d);
    const bool is_normal = gd * gd >= kCosine2 * gg * dd && std::fabs(dd - 1.0) <= kLength;
    return is_normal ? std::sqrt(gg) : 0.0;
}

NormalsOfPart normals_in(const FineMesh& fine, std::size_t part, double border_slope,
                         const std::vector<SurfaceForm>& forms)
{
    const std::int64_t begin = fine.first_vertex[part], end = fine.first_vertex[part + 1];
    if (begin == end) return {};
    const std::vector<Vec3>& at = fine.surface.mesh.vertices;
    const Triangle& some_face = fine.surface.mesh.faces[fine.first_face[part]];
    const std::int32_t label = fine.surface.surface_of_face[fine.first_face[part]];
    const SurfaceForm& form = forms[label >> 1];
    if (!form.is_quadratic()) return {};
    NormalsOfPart n;
    n.outside = (label & 1) != 0 ? -1.0 : 1.0;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Two least = both(kInfinity), longest = both(0.0), shortest = both(kInfinity),
        in_line = both(kInfinity);
    bool all_on = true;
    for (std::int64_t v = begin; v < end; v += 2) {
        const std::int64_t w = std::min(v + 1, end - 1);
        for (const std::int64_t i : {v, w})
            all_on = all_on && fine.surface.surfaces_of_vertex[i][0] == label >> 1;
        const TwoVec g = form.gradient({at[v], at[w]});
        const TwoVec d(fine.direction[v], fine.direction[w]);
        const Two gg = dot(g, g), dd = dot(d, d), gd = n.outside * dot(g, d);
        // Square of the cosine, less what it has to be, with the sign of the cosine.
        in_line = lesser(in_line, gd * greater(gd, both(0.0)) - kCosine2 * gg * dd);
        least = lesser(least, gg);
        longest = greater(longest, dd);
        shortest = lesser(shortest, dd);
    }
    n.least_slope = std::min(std::sqrt(std::min(least[0], least[1])), border_slope) -
                    2.0 * form.gradient_slack();
    n.longest = std::sqrt(std::max(longest[0], longest[1]));
    n.stiffness = form.most_bend();
    n.turn = 2.0 * n.stiffness / n.least_slope;
    n.edge = distance(at[some_face[0]], at[some_face[1]]);
    n.one_over_edge = 1.0 / n.edge;
    if (all_on && std::min(in_line[0], in_line[1]) >= 0.0 &&
        std::max(longest[0], longest[1]) <= 1.0 + kLength &&
        std::min(shortest[0], shortest[1]) >= 1.0 - kLength &&
        form.gradient_slack() <= kRounding * n.least_slope)
        n.surface = label >> 1;
    return n;
}

// The third edge is no longer than twice the longer of the others, and twice the length of an edge
// is no more than that of any other and the third proportional to both.
bool are_clear(const std::vector<Vec3>& vertices, const Triangle& t, const Triangle& u,
               const CornersOfFace& of_t, const CornersOfFace& of_u, const NormalsOfPart& normals,
               const SurfaceForm& form)
{
    const auto corner = [&](std::size_t k) { return TwoVec(vertices[t[k]], vertices[u[k]]); };
    const TwoVec a = corner(0), b = corner(1), c = corner(2), ab = b - a, ca = a - c;
    const std::array<Two, 3> k{normals.outside * form.bend(ab), normals.outside * form.bend(c - b),
                               normals.outside * form.bend(ca)};
    const Two square = greater(dot(ab, ab), dot(ca, ca));
    const Two edge = normals.edge + square * normals.one_over_edge;
    const Two moves =
        Two{of_t.most, of_u.most} * (normals.turn * edge + kSlant) + Two{of_t.spread, of_u.spread};
    const Two change = normals.stiffness * moves * (2.0 * edge + moves);
    const auto clears = [&](const Two& values, const std::array<Two, 3>& bends) {
        const Two largest = greater(bends[0], greater(bends[1], bends[2])) + change;
        const Two room = values - 2.0 * form.slack();
        if (largest[0] <= 0.0 && largest[1] <= 0.0) return room[0] > 0.0 && room[1] > 0.0;
        const Two over = room - kThird * change - most_between(bends);
        return over[0] > 0.0 && over[1] > 0.0;
    };
    return clears(Two{of_t.values[0], of_u.values[0]}, k) &&
           clears(Two{of_t.values[1], of_u.values[1]}, {-k[0], -k[1], -k[2]});
}

}  // namespace genus
