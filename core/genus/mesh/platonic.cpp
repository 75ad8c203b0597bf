#include "genus/mesh/platonic.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "genus/base/error.h"
#include "genus/mesh/dual.h"
#include "genus/mesh/hull.h"

namespace genus {

namespace {

// Vertices of {3, q}, of any size.
std::vector<Vec3> vertices_of_triangle_solid(int q)
{
    if (q == 3) return {{{1, 1, 1}}, {{1, -1, -1}}, {{-1, 1, -1}}, {{-1, -1, 1}}};
    if (q == 4)
        return {{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}};
    // Corners of three golden rectangles.
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    std::vector<Vec3> points;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double x : {1.0, -1.0})
            for (const double y : {golden, -golden}) {
                Vec3 p;
                p[(axis + 1) % 3] = x;
                p[(axis + 2) % 3] = y;
                points.push_back(p);
            }
    return points;
}

}  // namespace

PlatonicCounts platonic_counts(int p, int q)
{
    const bool regular = p >= 3 && q >= 3 && p < 6 && q < 6 && (p - 2) * (q - 2) < 4;
    if (!regular)
        throw InvalidInput("platonic: {" + std::to_string(p) + ", " + std::to_string(q) +
                           "} is no regular solid: p and q must be at least 3 with "
                           "(p - 2)(q - 2) < 4");
    const int n = 2 * p - p * q + 2 * q;
    return {4 * p / n, 2 * p * q / n, 4 * q / n};
}

PolygonMesh platonic(int p, int q)
{
    platonic_counts(p, q);
    PolygonMesh mesh = p == 3 ? convex_hull(vertices_of_triangle_solid(q)) : dual(platonic(q, p));
    for (Vec3& v : mesh.vertices) v = normalized(v);
    return mesh;
}

}  // namespace genus
