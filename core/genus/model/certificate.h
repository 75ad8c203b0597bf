#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "genus/model/cell_mesh.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

/// What is proven about the distance between a mesh and the exact solid.
struct Certificate {
    /// No point of the mesh is farther than this from the surface of the solid, and no point of
    /// that surface farther from the mesh. Means something only if `failed` is empty.
    double bound = 0.0;
    /// The largest share of `bound` by cause: between vertices of curved faces, where several
    /// surfaces meet, rounding.
    double faces = 0.0, creases = 0.0, rounding = 0.0;
    /// Where the proof did not succeed, with the number of places that had to be left out of the
    /// list because it is long enough.
    static constexpr std::int64_t kMostListed = 256;
    std::vector<Box3> failed;
    std::int64_t n_failed = 0;
    /// Faces that are not shown to be near the surface, or whose share of the bound is more than
    /// the tolerance: the mesh is too coarse there, or wrong. Counted in `n_failed`.
    std::vector<std::int32_t> failed_faces;
    /// Boxes looked at for the way from surface to mesh.
    std::int64_t n_boxes = 0;

    /// The shares with their names, the largest first.
    std::vector<std::pair<std::string, double>> parts() const;
};

/// The meshes M+ and M- of a certificate that succeeded, with the numbering of the mesh itself.
struct Sandwich {
    /// How far they are to be from the mesh at least, as a share of the tolerance; less where
    /// edges are short.
    double thickness = 0.0;
    IndexedMesh outer, inner;
};

/// Bounds the two-sided distance between a closed mesh and the surface S of the solid {F <= 0}.
///
/// Each vertex p_v gets a direction d_v along which all surface functions that meet near it grow,
/// and two lengths. M+ and M- are the meshes with vertices p_v + a_v d_v and p_v - b_v d_v.
///
/// *From mesh to surface.* If F > 0 on all of M+ and F < 0 on all of M-, then the broken line from
/// a point of M- over the point of M with the same barycentric coordinates to that of M+ crosses S,
/// so each point of M has a point of S within max(a_v |d_v|, b_v |d_v|). The signs are shown for
/// each triangle by the range of each surface function over it (Bernstein coefficients, with all
/// rounding covered) put into the formula of the solid.
///
/// *From surface to mesh.* Let w+ and w- be the winding numbers of M+ and M-. If q lies on S and
/// w+(q) = 1, w-(q) = 0, then the surfaces between M- and M+ sweep over q, and q is within the
/// bound of M. To see w+(q) = 1 walk from q to a place s where it is counted exactly: while F <= 0
/// the way cannot cross M+, on which F > 0. Likewise to s' with w-(s') = 0 while F >= 0. An octree
/// finds the ways for all q at once: boxes in which interval bounds show no surface are done; in
/// a box where every surface that decides there grows along c + Hd - q for every q of the box B
/// (interval gradients over the hull of B and c +- Hd), s = c - Hd and s' = c + Hd serve the whole
/// box; a box not larger than the tolerance is done if it is near the mesh; others are divided.
///
/// *Where the solid touches itself along an edge*, faces of one wedge of matter cannot move out of
/// it at the edge: behind it lies the other wedge. So M+ has the same faces with other neighbours
/// there, those round one wedge of empty space together, and M- has them as the mesh does. Both are
/// closed; all of the above stands as it is.
///
/// *Where no direction will do*, as at a point where surfaces touch, a face may stay without signs
/// if it is so small, and so near a face with signs, that all of it is within the tolerance by way
/// of that; ways then keep clear of it, so that the search there ends in boxes near the mesh.
///
/// Nothing is presumed of the mesh but that it is closed and oriented; that it does not cross
/// itself is for others to check. The cost of the second part depends on the solid, hardly on the
/// mesh.
///
/// `tolerance` is the largest bound of interest: where more is needed the proof fails. `cube` must
/// hold the solid and be the box the forms were made for.
///
/// With `sandwich` all faces must have signs, however small they are, and a box is done if it has
/// ways or lies between M- and M+, not for being near the mesh; M- and M+ are kept apart by its
/// thickness for that. So all of S is shown to lie between them, and they are
/// handed out.
Certificate certify(const SurfaceMesh& mesh, const SignFormula& formula,
                    const std::vector<SurfaceForm>& forms, const Box3& cube, double tolerance,
                    Sandwich* sandwich = nullptr);

}  // namespace genus
