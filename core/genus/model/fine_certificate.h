#pragma once

#include "genus/model/certificate.h"
#include "genus/model/fine_mesh.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

/// What is proven about the distance between a fine mesh and the exact solid {F <= 0}, given a
/// coarse mesh of it whose sandwich M-, M+ holds all of the surface S, F < 0 on M- and F > 0 on M+,
/// with no doubtful prism but for fibres of length `short_fibre` at most.
///
/// *From mesh to surface.* As in `certify`: each vertex moves by a_v outward and b_v inward along
/// its direction, to meshes N+ with F > 0 and N- with F < 0, shown for each triangle by the range
/// of each surface function over it.
///
/// *From surface to mesh.* Let q lie on S, so that the sweep of M- to M+ passes over q: q lies on
/// a fibre, which leaves the solid once, at q. From q inward along the fibre F <= 0, so the way to
/// M- does not cross N+, and N+ winds round q as often as round the end of the way on M-. As M-
/// does not meet N+ either, that number is the same all over a component of M-; it is counted at
/// one point of each. Where it is 1, and that of N- round M+ likewise 0, the sweep of N- to N+
/// passes over q, and q is within the bound of the fine mesh. A short fibre has
/// a point that is swept, or lies on N-: where N- winds no longer round it, between the end on M-,
/// round which N+ winds, and that on M+, round which N- does not. So q there is within the bound
/// and the length of the fibre, which is added.
///
/// `failed_faces` are those faces of the coarse mesh in which signs are not shown within
/// `tolerance`, or all if a number of turns is wrong; then nothing is proven. That the fine mesh
/// does not cross itself is for others to check. O(faces), for each face the surfaces that decide
/// near it.
Certificate certify_within(const Sandwich& sandwich, const SurfaceMesh& coarse,
                           const FineMesh& fine, const SignFormula& formula,
                           const std::vector<SurfaceForm>& forms, double tolerance,
                           double short_fibre);

}  // namespace genus
