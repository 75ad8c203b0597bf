#pragma once

#include <cstdint>
#include <vector>

#include "genus/model/certificate.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

struct DoubtfulPrisms {
    /// The faces in whose prisms the solid may be left and entered again.
    std::vector<std::int32_t> faces;
    /// The longest fibre, of those let pass for being short.
    double longest_short = 0.0;
};

/// Whether along each fibre of a sandwich the solid is left once.
///
/// A face gives corners o_i of M+ and i_i of M-; the segments from sum b_i i_i to sum b_i o_i, for
/// all barycentric b, are the fibres of its prism. If every surface that decides in the hull of the
/// prism grows along o_1 - i_1, o_2 - i_2 and o_3 - i_3, then along each fibre the solid, inside at
/// the end on M- and outside at the end on M+, is left exactly once. Prisms of which this is not
/// shown are cut into four, and these again, up to five times. One whose fibres are no longer
/// than `short_enough` passes all the same: what the solid has there is no farther from its ends.
///
/// Cost: hulls of six points for each surface that decides near a face.
DoubtfulPrisms doubtful_prisms(const SurfaceMesh& mesh, const Sandwich& sandwich,
                               const SignFormula& formula, const std::vector<SurfaceForm>& forms,
                               double short_enough);

}  // namespace genus
