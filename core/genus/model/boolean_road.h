#pragma once

#include <functional>

#include "genus/boolean/mesh_boolean.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/solid.h"

namespace genus {

/// True if every shape of the tree is a polyhedron as it stands, so that its booleans are exact.
bool is_polyhedral(const Solid& solid);

/// True if the tree is one for cells and surface functions: every shape is curved, or convex with
/// a few faces.
bool is_smooth(const Solid& solid);

/// Makes a closed mesh of a smooth solid, or of a lone freeform one, within the distance it returns
/// of the exact one.
using SmoothMesher = std::function<double(const Solid& smooth, IndexedMesh& mesh)>;

/// A tree as operands and a formula for mesh_boolean. A polyhedral leaf is one operand, with its
/// transforms applied; smooth parts of one operator are one operand together, so that their common
/// edges stay exact. Faces turn outward also under mirror images.
struct BooleanScene {
    std::vector<IndexedMesh> operands;
    BooleanFormula formula;
    /// No operand crosses itself: all are made by us from primitives.
    bool clean_operands = true;
    /// Largest distance of an operand to the exact shape that it stands for.
    double deviation = 0.0;
    /// Operands whose mesh was made once, for an equal one before them.
    std::int64_t n_shared = 0;
};

/// `box` holds the solid. Throws InvalidInput for a tree nested more than 8000 levels deep.
BooleanScene boolean_scene(const Solid& solid, const Box3& box, const SmoothMesher& mesher);

/// One exact boolean of all leaves, curved ones made into meshes before. Fills mesh, error, seconds
/// and explanation of `result`, whose `tolerance` is set.
///
/// Of polyhedra alone, the bound is what snapping to the integer grid may move; it is certified
/// where nothing had to move. Where operands stand for curved shapes the bound is an estimate:
/// their largest deviation besides, which the crossings of surfaces at a small angle can exceed.
/// `measured` is the largest distance of a corner of a face to the plane of the face that it comes
/// from. Throws as mesh_boolean does, ToleranceNotMet if the bound exceeds the tolerance.
void mesh_by_boolean(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                     MeshedSolid& result);

}  // namespace genus
