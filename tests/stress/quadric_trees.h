#pragma once

// Random trees of quadrics and tori, and what is promised of each: a closed mesh, what was measured
// within what is proven, that within what was asked for, every vertex on the exact surfaces.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/model/random_quadrics.h"
#include "genus/base/error.h"
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

struct Outcome {
    std::string wrong;    // what was promised and does not hold
    std::string refused;  // in the words of the error
    bool empty = false;
    double tolerance = 0.0, bound = 0.0, measured = 0.0;
    std::int64_t faces = 0, euler = 0;
    OffSurface off;  // beside the size of the mesh
    /// V - E + F over a grid, where that road was gone as well, and the distance between the two.
    std::optional<std::int64_t> euler_on_grid;
    std::string no_grid;
    double roads_apart = 0.0, roads_allowed = 0.0;
};

/// The other road as the witness of the first.
inline void go_by_grid(const Solid& tree, MeshMethod method, const MeshedSolid& made,
                       Outcome& outcome)
{
    MeshOptions options;
    options.tolerance = outcome.tolerance;
    options.method = method;
    MeshedSolid other;
    try {
        other = mesh_solid(tree, options);
    } catch (const ToleranceNotMet& error) {
        outcome.no_grid = error.what();
        return;
    }
    outcome.euler_on_grid = topology(other.mesh).euler;
    outcome.roads_allowed = made.error.bound + other.error.bound;
    if (other.mesh.faces.empty()) return;
    DistanceOptions fast;
    fast.precision = 0.0;
    fast.mean = false;
    outcome.roads_apart = mesh_distance(made.mesh, other.mesh, fast).max;
    if (outcome.roads_apart > outcome.roads_allowed) outcome.wrong = "the roads disagree";
}

struct Request {
    double tolerance = 0.02;  // of the diagonal of the box
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
    if (request.grid) go_by_grid(tree, *request.grid, made, outcome);
    return outcome;
}

}  // namespace genus::quadric_trees
