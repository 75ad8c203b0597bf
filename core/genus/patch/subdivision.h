#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// An edge, by its vertices in either order, that stays sharp for `sharpness` levels; fractions
/// blend, infinity is sharp for ever.
struct Crease {
    std::int32_t a, b;
    double sharpness = std::numeric_limits<double>::infinity();
};

/// A polygon mesh with creases, as subdivision takes and gives it. Vertices listed in `corners`
/// do not move.
struct SubdivisionMesh {
    PolygonMesh mesh;
    std::vector<Crease> creases;
    std::vector<std::int32_t> corners;
};

/// One step or more of Catmull-Clark: every face of n corners becomes n quadrilaterals. Old
/// vertices keep their numbers, then come edge points, then face points. Edges with one face, or
/// more than two, are sharp. A vertex with two sharp edges follows the cubic spline along them,
/// with three or more it stays.
/// Throws InvalidInput for indices out of range, a repeated corner of a face, a crease that is no
/// edge or has negative sharpness, levels outside [0, 12], or a result above 2^30 corners.
/// O(corners of the result log corners).
///
/// Implements [catmull1978]; creases as in [derose1998], section 3.
SubdivisionMesh catmull_clark(const SubdivisionMesh& mesh, int levels = 1);

/// The same by Loop's scheme: every triangle becomes four. Throws InvalidInput also for faces that
/// are not triangles.
///
/// Implements [loop1987]; creases as in [hoppe1994] with the rules above for their ends.
SubdivisionMesh loop_subdivision(const SubdivisionMesh& mesh, int levels = 1);

enum class SubdivisionScheme { CatmullClark, Loop };

/// Where the vertices of a mesh go on the limit surface, and its unit normals there. The normal is
/// zero where the surface has none of its own: on creases between two sides, at corners, and at
/// vertices whose faces form no disc.
struct LimitSurface {
    std::vector<Vec3> points;
    std::vector<Vec3> normals;
};

/// By the eigenvectors of the subdivision matrix. Edges of finite sharpness are subdivided until
/// they are smooth, at most 6 times. Throws as the schemes do.
///
/// Implements [halstead1993], and [biermann2000] for tangents at the border of Catmull-Clark; those
/// of Loop's scheme are derived in the source.
LimitSurface limit_surface(const SubdivisionMesh& mesh, SubdivisionScheme scheme);

}  // namespace genus
