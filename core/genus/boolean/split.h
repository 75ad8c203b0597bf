#pragma once

#include "genus/boolean/mesh_boolean.h"

namespace genus {

/// The two parts into which a plane cuts the solid inside a closed mesh, both closed: where
/// normal . p <= offset, and the rest. The faces in the plane are the same in both, and have
/// operand 1. Of a plane across one axis they lie at offset / normal exactly; any other plane is
/// that of three points of it rounded to doubles.
struct SplitMesh {
    MeshBooleanResult below;
    MeshBooleanResult above;
};

/// By mesh_boolean with a prism that has a face in the plane; cost and exceptions are its. Throws
/// InvalidInput for a normal that is zero or not finite, and for an offset that is not finite.
SplitMesh split(const IndexedMesh& mesh, const Vec3& normal, double offset);

}  // namespace genus
