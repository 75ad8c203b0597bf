#pragma once

#include <vector>

#include "genus/model/csg_field.h"

namespace genus {

/// Where the line origin + t direction crosses the surface, ascending in t, from either side; a
/// line that only touches gives two nearly equal values or none. No roots where the line lies in
/// the surface. `direction` is not zero.
///
/// Quadrics by the root formula with a compensated discriminant, about the point of the line
/// nearest to the quadric's own origin, so that nothing is lost to the distance of the viewer;
/// tori by bisection between the extremes of the quartic, these found the same way from the
/// derivatives. Every root is then polished on F itself.
///
/// Implements [hanrahan1989] (quadric and torus); discriminant as in [kahan2004].
std::vector<double> ray_roots(const Surface& surface, const Vec3& origin, const Vec3& direction);

}  // namespace genus
