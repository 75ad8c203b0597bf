#pragma once

#include <cstdint>
#include <vector>

#include "genus/model/certificate.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

/// The faces of a sandwich in whose prisms the solid may be left and entered again.
///
/// A face gives corners o_i of M+ and i_i of M-; the segments from sum b_i i_i to sum b_i o_i, for
/// all barycentric b, are the fibres of its prism. If every surface that decides in the hull of the
/// prism grows along o_1 - i_1, o_2 - i_2 and o_3 - i_3, then along each fibre the solid, inside at
/// the end on M- and outside at the end on M+, is left exactly once. Prisms of which this is not
/// shown are cut into four, and these again, up to five times. Nor does a prism matter whose fibres
/// are no longer than `short_enough`: a mesh that meets them all is no farther from what the solid
/// has there.
///
/// Cost: hulls of six points for each surface that decides near a face.
std::vector<std::int32_t> doubtful_prisms(const SurfaceMesh& mesh, const Sandwich& sandwich,
                                          const SignFormula& formula,
                                          const std::vector<SurfaceForm>& forms,
                                          double short_enough);

}  // namespace genus
