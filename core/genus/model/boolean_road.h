#pragma once

#include <functional>

#include "genus/boolean/mesh_boolean.h"
#include "genus/model/freeform.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/solid.h"

namespace genus {

/// True if every shape of the tree is a polyhedron as it stands, so that its booleans are exact.
bool is_polyhedral(const Solid& solid);

/// True if the tree is one for cells and surface functions: every shape is curved, or convex with
/// a few faces.
bool is_smooth(const Solid& solid);

/// A closed mesh within `bound` of the exact solid, both ways; proven if `certified`.
struct SmoothMesh {
    IndexedMesh mesh;
    double bound = 0.0;
    bool certified = false;
    FreeformSource::ToSurface to_surface;  // none where the surface is not known
    std::string doubt;                     // what is not proven, unless it is certified
};
/// Makes such a mesh of a smooth solid, or of a lone freeform one, to a tolerance.
using SmoothMesher = std::function<SmoothMesh(const Solid& smooth, double tolerance)>;

/// What a boolean had no need to do.
Explanation explain_boolean(const MeshBooleanReport& report);

/// A tree as operands and a formula for mesh_boolean. A polyhedral leaf is one operand, with its
/// transforms applied; smooth parts of one operator are one operand together, so that their common
/// edges stay exact. The closed surfaces of a freeform part are an operand each, united. Faces turn
/// outward also under mirror images.
struct BooleanScene {
    std::vector<IndexedMesh> operands;
    BooleanFormula formula;
    /// No operand crosses itself: all are made by us from primitives.
    bool clean_operands = true;
    /// Distance of each operand to the exact shape that it stands for, 0 for itself, and what takes
    /// points to its surface.
    std::vector<double> deviations;
    std::vector<FreeformSource::ToSurface> to_surface;
    /// All deviations are proven; if not, which one is not.
    bool certified = true;
    std::string doubt;
    /// Operands whose mesh was made once, for an equal one before them.
    std::int64_t n_shared = 0;
};

/// `box` holds the solid, `tolerance` is for smooth parts. Throws InvalidInput for a tree nested
/// more than 8000 levels deep.
BooleanScene boolean_scene(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                           double tolerance);

/// One exact boolean of all leaves, curved ones made into meshes before. Fills mesh, error, seconds
/// and explanation of `result`, whose `tolerance` is set.
///
/// Of polyhedra alone, the bound is what snapping to the integer grid may move; it is certified
/// where nothing had to move. Where operands stand for curved shapes they are made to .15 of the
/// tolerance, and if that proves nothing about the result (see certify_boolean) to .07 of it. If
/// that does not help either, surfaces touch or cross at a small angle: the bound is an estimate,
/// the deviation of the operands, which the place where they do may exceed; `error.doubt` tells
/// where. `measured` is the largest distance, of those sampled, from the result to the exact
/// surfaces it comes from, at edges to both. Throws as mesh_boolean does, ToleranceNotMet if the
/// bound exceeds the tolerance.
void mesh_by_boolean(const Solid& solid, const Box3& box, const SmoothMesher& mesher,
                     MeshedSolid& result);

}  // namespace genus
