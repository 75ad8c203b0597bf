#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

struct MeshBound {
    std::optional<double> bound;
    /// So far from the mesh is a point of the surface that was found, if that is more than `most`.
    double exceeded = 0.0;
};

/// How far a closed mesh and the surface S of the solid {F <= 0} are from each other, proven with
/// nothing but boxes and places in and out of the solid, so that edges and thin tips that a mesh
/// cuts off do no harm. For meshes whose distance is of the order of their faces; where it is much
/// less `certify` is the way.
///
/// *From surface to mesh.* A box in which interval bounds decide the formula has no point of S. Of
/// any other no point is farther from the mesh than its middle is, and half its diagonal. Boxes of
/// more than `enough` are halved.
///
/// *From mesh to surface.* Between a place in the solid and one outside there is a point of S. They
/// are looked for on both sides of the corners of a face; its points are no farther from one of
/// them than its longest side over the square root of 3, from each than that side. Faces of more
/// than `enough` are quartered.
///
/// The bound is at most `most`, about `enough` where both come to an end; nothing if it cannot be
/// shown, or not with `max_boxes` boxes. `box` must hold the solid and be within the one
/// the forms were made for. Cost: boxes and parts of faces as there are squares of side `enough` on
/// the surface, each a look into a tree.
MeshBound bound_by_boxes(const IndexedMesh& mesh, const SignFormula& formula,
                         const std::vector<SurfaceForm>& forms, const Box3& box, double enough,
                         double most, std::int64_t max_boxes);

}  // namespace genus
