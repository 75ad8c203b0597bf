#pragma once

#include "genus/model/coarse_shell.h"
#include "genus/model/fine_mesh.h"

namespace genus {

/// Whether the fine mesh X is shown not to cross or touch itself, to be closed, and to turn
/// outward: what `validate` would find, for a tenth of its cost.
///
/// Let both meshes K- and K+ of the shell be valid, so that they wind round any point 0 or 1
/// times, w- and w+. The vertices of a face of X came from a triangle on K- and one on K+. The
/// prisms from the triangles on K- to those of X map X times [0, 1] into space, by segments; so do
/// those from X to K+. Where the determinants of all these maps are positive, a point of space has
/// as many preimages as the winding numbers at their ends differ: w(X) - w- of the first, w+ - w(X)
/// of the second, neither of them negative, w+ - w- <= 1 in all. Two places of X in one point would
/// have points with two preimages near them. So there are none, and w(X) is 0 or 1.
///
/// Over a prism with triangles (p_i), (q_i) the determinant is the quadratic in s, linear in
/// barycentric b, with Bernstein coefficients n_k . (q_i - p_i), where n_0 and n_2 are the normals
/// of the two triangles and n_1 is their mixed product: nine signs, each with its rounding and
/// that of `FineMesh::border_shell` covered.
///
/// Where some determinants are not shown to be positive, the above holds for all points outside
/// of boxes round the prisms in question; the few faces that meet these boxes are tested pair by
/// pair, and each part of the mesh must have a vertex of the coarse mesh outside of them.
///
/// False means only that it is not shown. O(faces), and `validate` of two coarse meshes.
bool proven_embedded(const CoarseShell& shell, const FineMesh& fine);

}  // namespace genus
