#pragma once

// Random trees of quadrics and tori, and what is promised of each: a closed mesh, what was measured
// within what is proven, that within what was asked for, every vertex on the exact surfaces.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/random_quadrics.h"
#include "genus/base/error.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/distance.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/csg_field.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/queries.h"

namespace genus::quadric_trees {

/// 1 to 12 leaves of all kinds, or some more where an intersection brings its own.
inline Solid tree_of(std::uint32_t seed)
{
    RandomShapes random(seed);
    return random_quadric_tree(random, 1 + static_cast<int>(seed % 12));
}

/// How far from the surfaces that it should be on a vertex is, at most: any to the nearest, one at
/// a sharp edge to the second nearest.
struct OffSurface {
    double one = 0.0, edge = 0.0;
};

inline OffSurface off_surface(const IndexedMesh& mesh, const CsgField& field)
{
    // The normals of the faces at each vertex: a sharp edge has two far apart.
    std::vector<Vec3> first(mesh.n_vertices());
    std::vector<char> sharp(mesh.n_vertices(), 0);
    for (const Triangle& t : mesh.faces) {
        const Vec3 normal = normalized(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                             mesh.vertices[t[2]] - mesh.vertices[t[0]]));
        for (const std::int32_t v : t) {
            if (first[v] == Vec3{}) first[v] = normal;
            if (dot(first[v], normal) < 0.2) sharp[v] = 1;
        }
    }
    OffSurface off;
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v) {
        std::vector<double> distances;
        for (const Surface& s : field.surfaces()) {
            const double slope = norm(s.gradient(mesh.vertices[v]));
            const double value = std::fabs(s.value(mesh.vertices[v]));
            // At an apex F grows with the square of the distance.
            distances.push_back(std::min(value / slope, std::sqrt(value)));
        }
        std::sort(distances.begin(), distances.end());
        off.one = std::max(off.one, distances[0]);
        if (sharp[v] && distances.size() > 1) off.edge = std::max(off.edge, distances[1]);
    }
    return off;
}

/// What the road over a grid says. Every vertex of plain marching cubes lies on the exact surface,
/// which no step of the other road has a part in; its proof by boxes is another one as well.
struct OverGrid {
    std::int64_t euler = 0;
    /// Where it differs from that of the cells: that of cells at an eighth of the tolerance.
    std::optional<std::int64_t> euler_finer;
    double farthest_vertex = 0.0;  // from the mesh of cells
    double apart = 0.0;            // the two meshes, by sampling both ways
    double bound = 0.0;            // of the grid road
    bool certified = false;        // else it is estimated
};

struct Outcome {
    std::string wrong;    // what was promised and does not hold
    std::string refused;  // in the words of the error
    bool empty = false;
    double tolerance = 0.0, bound = 0.0, measured = 0.0;
    std::int64_t faces = 0, euler = 0;
    bool touches = false;
    OffSurface off;  // beside the size of the mesh
    std::vector<std::pair<std::string, double>> seconds;
    /// The other road, where it was gone as well.
    std::optional<OverGrid> grid;
};

/// Nothing if no grid in reach meets the tolerance.
inline std::optional<OverGrid> go_by_grid(const Solid& tree, MeshMethod method, double tolerance,
                                          const IndexedMesh& mesh)
{
    MeshOptions options;
    options.tolerance = tolerance;
    options.method = method;
    options.max_triangles = 1'000'000;
    MeshedSolid other;
    try {
        other = mesh_solid(tree, options);
    } catch (const ToleranceNotMet&) {
        return std::nullopt;
    }
    OverGrid result;
    result.euler = topology(other.mesh).euler;
    result.bound = other.error.bound;
    result.certified = other.error.certified;
    if (other.mesh.faces.empty()) return result;
    DistanceOptions fast;
    fast.precision = 0.0;
    fast.mean = false;
    result.apart = mesh_distance(mesh, other.mesh, fast).max;
    const MeshTree faces(mesh);
    for (const Vec3& v : other.mesh.vertices)
        result.farthest_vertex = std::max(result.farthest_vertex, faces.nearest(v).distance);
    return result;
}

/// Where edges or corners of a mesh touch, its form hangs on a hair.
inline bool touches_itself(const IndexedMesh& mesh)
{
    std::vector<Vec3> points = mesh.vertices;
    std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
        return std::array{a[0], a[1], a[2]} < std::array{b[0], b[1], b[2]};
    });
    return std::adjacent_find(points.begin(), points.end()) != points.end();
}

struct Request {
    double tolerance = 0.01;  // of the diagonal of the box
    std::optional<MeshMethod> grid;
};

inline Outcome try_tree(std::uint32_t seed, const Request& request)
{
    Outcome outcome;
    const Solid tree = tree_of(seed);
    const Box3 box = tight_bounds(tree, 0.05);
    outcome.empty = box.empty();
    if (outcome.empty) return outcome;
    MeshOptions options;
    options.tolerance = outcome.tolerance = request.tolerance * box.diagonal();
    MeshedSolid made;
    try {
        made = mesh_solid(tree, options);
    } catch (const ToleranceNotMet& error) {
        outcome.refused = error.what();
        return outcome;
    }
    outcome.faces = static_cast<std::int64_t>(made.mesh.n_faces());
    outcome.empty = outcome.faces == 0;
    if (outcome.empty) return outcome;
    outcome.bound = made.error.bound;
    outcome.measured = made.error.measured;
    outcome.seconds = made.seconds;
    const Validation validation = validate(made.mesh);
    outcome.euler = validation.topology.euler;
    if (!validation.ok()) outcome.wrong = validation.findings[0].text;
    if (!made.error.certified) outcome.wrong = "no certificate";
    if (!(outcome.measured <= outcome.bound)) outcome.wrong = "measured above the bound";
    if (!(outcome.bound <= outcome.tolerance)) outcome.wrong = "bound above the tolerance";
    const double size = bounds(made.mesh).diagonal();
    outcome.off = off_surface(made.mesh, CsgField(tree));
    outcome.off.one /= size;
    outcome.off.edge /= size;
    outcome.touches = touches_itself(made.mesh);
    if (request.grid) {
        outcome.grid = go_by_grid(tree, *request.grid, outcome.tolerance, made.mesh);
        if (outcome.grid && *request.grid == MeshMethod::Mc &&
            outcome.grid->farthest_vertex > outcome.bound)
            outcome.wrong = "a point of the surface is farther from the mesh than the bound";
        if (outcome.grid && outcome.grid->certified &&
            outcome.grid->apart > outcome.bound + outcome.grid->bound)
            outcome.wrong = "the two roads are farther apart than both bounds";
        if (outcome.grid && outcome.grid->euler != outcome.euler && !outcome.touches) {
            *options.tolerance /= 8.0;
            options.measure = false;
            try {
                outcome.grid->euler_finer = topology(mesh_solid(tree, options).mesh).euler;
            } catch (const ToleranceNotMet&) {  // then it stays without
            }
        }
    }
    return outcome;
}

}  // namespace genus::quadric_trees
