#pragma once

#include "genus/boolean/incidence.h"

namespace genus::exact {

/// Cuts all faces that are not passive and not buried: `out` gets its cells and their covers, and
/// the points where segments cross inside a plane. Faces of one plane that overlap, and those of
/// one flat, are cut as one by a constrained triangulation.
void cut_faces(const Soup& soup, const Incidence& incidence, Arrangement& out, PointTable& table);

}  // namespace genus::exact
