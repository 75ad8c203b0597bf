#pragma once

#include <cstdint>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/fine_mesh.h"
#include "genus/model/surface_form.h"
#include "genus/model/two_lanes.h"

namespace genus {

/// Where the directions of a fine mesh are normals of a quadratic surface, but for a millionth of
/// their length of 1. An edge then hardly changes as its ends move along them, and neither does the
/// bend of the surface along it: what a face needs to clear the surface is known from its edges as
/// they are, for both sides at once.
struct NormalsOfPart {
    std::int32_t surface = -1;               ///< -1 if directions are no normals
    double outside = 1.0;                    ///< the sign of its function on the outer side
    double least_slope = 0.0;                ///< of the function at the vertices
    double longest = 0.0;                    ///< length of a direction
    double stiffness = 0.0;                  ///< most of a bend, beside the square of the step
    double turn = 0.0;                       ///< most of a normal along a step, beside its length
    double edge = 0.0, one_over_edge = 0.0;  ///< the length of some edge
};

/// Of the vertices inside face `part` of the coarse mesh. Others with normals in its faces have a
/// slope of `border_slope` at least.
NormalsOfPart normals_in(const FineMesh& fine, std::size_t part, double border_slope,
                         const std::vector<SurfaceForm>& forms);

/// The slope of the surface at a vertex if that stands on one alone and its direction is a normal
/// as above; else 0.
double slope_along_normal(const FineMesh& fine, std::int32_t vertex,
                          const std::vector<SurfaceForm>& forms);

/// At the corners of a face: the least values of the function on the outer and the inner side, each
/// times the sign it has there, the largest offset, and by how much offsets to one side differ.
struct CornersOfFace {
    Two values;
    double most, spread;
};

/// Whether two faces, with such normals at their corners, are shown to have their signs on both
/// sides. Normals n = g / |g| at the ends of an edge e differ by 2 |M e| / least_slope at most, M
/// the matrix of `bend`, as their gradients do by 2 M e; that times the offset, and the difference
/// of offsets, bound the change d of the edge as its ends move, and 2 |M e| |d| + |M| |d|^2 that of
/// its bend.
bool are_clear(const std::vector<Vec3>& vertices, const Triangle& t, const Triangle& u,
               const CornersOfFace& of_t, const CornersOfFace& of_u, const NormalsOfPart& normals,
               const SurfaceForm& form);

}  // namespace genus
