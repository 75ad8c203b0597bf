#pragma once

#include <vector>

#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

/// The sign of all of a range; 0 if it has several.
inline Sign sign_of(const Interval& range)
{
    return range.lo > 0.0 ? Sign{1} : range.hi < 0.0 ? Sign{-1} : Sign{0};
}

/// The signs on a box or a simplex, by surface, of those that the formula asks for: 0 where a
/// surface is not shown to keep one.
template <class Simplex>
void find_signs(const SignFormula& formula, const std::vector<SurfaceForm>& forms,
                const Simplex& simplex, std::vector<Sign>& signs)
{
    for (const std::int32_t s : formula.surfaces()) signs[s] = sign_of(forms[s].range(simplex));
}

}  // namespace genus
