#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/coarse_shell.h"
#include "genus/model/surface_form.h"

namespace genus {

/// How far points of `FineMesh::border_shell` may be from what they stand for, beside the largest
/// coordinate: some roundings for each of the cuts that a face goes through.
constexpr double kShellRounding = 0x1p-41;

/// A coarse mesh cut finely, every vertex on the exact surface or curve.
struct FineMesh {
    SurfaceMesh surface;
    /// A vector at each vertex along which each surface that meets there recedes from the solid by
    /// its length of 1: the unit normal inside a face, longer on edges and in corners.
    std::vector<Vec3> direction;
    /// The points of the shell from which each vertex on an edge of the coarse mesh came: on K- and
    /// K+, at the same place of the same edge, but for rounding.
    std::vector<ShellPoints> border_shell;
    /// The places from which the others came, in the face of K- and K+ that they were cut from.
    std::vector<Weights> place;
    /// How far each vertex is to move outward and inward for its faces to clear their surfaces,
    /// about; one with a long `direction` has room for less.
    std::vector<std::array<double, 2>> reach;
    /// Faces `first_face[f] .. first_face[f + 1] - 1` are those of face f of the coarse mesh.
    std::vector<std::int64_t> first_face;
    /// Vertices `first_vertex[f] .. first_vertex[f + 1] - 1` are those inside face f of the coarse
    /// mesh; those on its edges and in its corners come before all of them.
    std::vector<std::int64_t> first_vertex;
    /// Faces of the coarse mesh that could not be cut; if there are any, the rest is not filled.
    std::vector<std::int32_t> stuck;
};

/// Cuts a closed mesh, vertices on their surfaces, so finely that its faces clear their surfaces
/// when vertices move by almost `tolerance` (see CutFace). The number of points on an edge comes
/// from its own sagitta, at most 0.75 `tolerance`, less where the vectors `direction` are long; so
/// neighbours agree. On a sphere there are about 1.4 times as many faces as equilateral triangles
/// with their corners on it would be.
///
/// Directions at vertices of the coarse mesh are those of its sandwich. A face is stuck if a point
/// cannot be put on its surface, or if surfaces at a corner have no common way out. Throws
/// ToleranceNotMet beyond `max_triangles`. O(triangles made); independent of threads.
FineMesh cut_finely(const SurfaceMesh& coarse, const Sandwich& sandwich, const CoarseShell& shell,
                    const std::vector<SurfaceForm>& forms, double tolerance,
                    std::int64_t max_triangles);

}  // namespace genus
