#pragma once

#include "genus/boolean/mesh_boolean.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/solid.h"

namespace genus {

/// True if every shape of the tree is a polyhedron as it stands, so that its booleans are exact.
bool is_polyhedral(const Solid& solid);

/// A tree as operands and a formula for mesh_boolean. Each leaf is one operand, with its transforms
/// applied; faces turn outward also under mirror images.
struct BooleanScene {
    std::vector<IndexedMesh> operands;
    BooleanFormula formula;
    /// No operand crosses itself: all are made by us from primitives.
    bool clean_operands = true;
};

/// Throws InvalidInput for a tree that is not polyhedral.
BooleanScene boolean_scene(const Solid& solid);

/// The road for polyhedral trees: one exact boolean of all leaves. Fills mesh, error, seconds and
/// explanation of `result`, whose `tolerance` is set.
///
/// The bound is what snapping to the integer grid may move; it is certified where nothing had to
/// move. `measured` is the largest distance of a corner of a face to the plane of the face that it
/// comes from. Throws as mesh_boolean does, ToleranceNotMet if the bound exceeds the tolerance.
void mesh_by_boolean(const Solid& solid, MeshedSolid& result);

}  // namespace genus
