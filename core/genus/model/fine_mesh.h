#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/coarse_shell.h"
#include "genus/model/surface_form.h"

namespace genus {

/// How far points of `FineMesh::shell` may be from what they stand for, beside the largest
/// coordinate: some roundings for each of the cuts that a face goes through.
constexpr double kShellRounding = 0x1p-41;

/// A coarse mesh cut finely, every vertex on the exact surface or curve.
struct FineMesh {
    SurfaceMesh surface;
    /// A vector at each vertex along which each surface that meets there recedes from the solid by
    /// its length of 1: the unit normal inside a face, longer on edges and in corners.
    std::vector<Vec3> direction;
    /// The points of the shell from which each vertex came: on K- and K+, at the same place of the
    /// same face, but for rounding.
    std::vector<ShellPoints> shell;
    /// How far the surface of each face may lie outside and inside of it, about.
    std::vector<std::array<double, 2>> distance;
    /// Faces `first_face[f] .. first_face[f + 1] - 1` are those of face f of the coarse mesh.
    std::vector<std::int64_t> first_face;
    /// Faces of the coarse mesh that could not be cut; if there are any, the rest is not filled.
    std::vector<std::int32_t> stuck;
};

/// Cuts a closed mesh, vertices on their surfaces, until edges are within 0.85 `tolerance` of
/// theirs, less where the vectors `direction` are long. The number of points on an edge comes from
/// its own sagitta, so neighbours agree; a face is cut from the middle of the edge with the most
/// points to the opposite corner, the new edge again gets points by its sagitta, and so on: long
/// faces where the surface is straight one way, and no more points than the curvature asks for. A
/// face that is still too far from its surface gets a vertex in the middle.
///
/// Directions at vertices of the coarse mesh are those of its sandwich. A face is stuck if a point
/// cannot be put on its surface, or if surfaces at a corner have no common way out. Throws
/// ToleranceNotMet beyond `max_triangles`. O(triangles made); independent of threads.
FineMesh cut_finely(const SurfaceMesh& coarse, const Sandwich& sandwich, const CoarseShell& shell,
                    const std::vector<SurfaceForm>& forms, double tolerance,
                    std::int64_t max_triangles);

}  // namespace genus
