#pragma once

#include "genus/model/freeform.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/solid.h"

namespace genus {

/// True for a freeform leaf below any number of transforms and colours.
bool is_lone_freeform(const Solid& solid);

/// A lone freeform leaf as a closed mesh in its place.
FreeformSource::Meshed mesh_freeform(const Solid& solid, double tolerance,
                                     const FreeformSource::Limits& limits);

/// Meshes a lone freeform leaf by itself: from its own mesh, with its own bound, for
/// MeshMethod::Auto; by marching cubes on its function for Emc and Mc, with a bound that is
/// proven where the source can.
/// Fills mesh, error and method of `result`, whose tolerance is set. False, and no change, where
/// its own mesh crosses itself and a boolean has to unite its parts.
/// Throws InvalidInput for Emc and Mc if there is no function, ToleranceNotMet.
bool mesh_freeform_alone(const Solid& solid, const MeshOptions& options, MeshedSolid& result);

}  // namespace genus
