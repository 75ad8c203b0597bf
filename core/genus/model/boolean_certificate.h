#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/boolean/mesh_boolean.h"

namespace genus {

/// What is proven of a boolean of meshes that stand for curved solids.
struct BooleanCertificate {
    bool proven = false;
    /// No point of the result is farther than this from the surface of the boolean of the exact
    /// solids, nor the other way round. Means something only if `proven`.
    double bound = 0.0;
    /// Where it is not shown: surfaces that nearly touch, or cross at a small angle. A few.
    std::vector<Box3> doubtful;
    std::int64_t n_pieces = 0;  // of faces looked at
};

/// Bounds the distance between the boolean P = f(P_1, .., P_n) of meshes and X = f(X_1, .., X_n) of
/// the solids that they stand for, where the surface of X_i and that of P_i are within e_i of each
/// other, both ways, and every point farther than e_i from P_i is inside of both or outside of
/// both.
///
/// Over a ball whose points are farther than e_j from P_j, X_j is known: all or nothing of it.
///
/// *From P to X.* Over a piece of a face of P that comes from P_i, widened by e_i, let all other
/// solids be known, or not matter, so that f is X_i or its complement there: then the point of the
/// surface of X_i within e_i of any point of the piece is on that of X. Pieces that are not clear
/// in this sense lie near where surfaces cross; they are divided until each has a clear piece near
/// enough. That is (e_i + e_j) / sin(angle) + e_i away, about.
///
/// *From X to P.* The surface of X lies within e_i of some face of some P_i. Such a face is done if
/// it is near P, all of it, or if f is known over it, widened by e_i, whatever X_i is; it is
/// divided until one of the two holds.
///
/// Where all that is not known is exact, e_i = 0, there is nothing to show: X is P.
///
/// `rounding` is how far corners of operands and result may be from where they belong; it is not
/// in the bound. `tolerance` is the largest bound of interest. It presumes that X_i has the surface
/// that P_i was bounded against: no surface of patches that crosses itself. Deterministic. O(faces
/// log faces), more where surfaces cross.
BooleanCertificate certify_boolean(std::span<const IndexedMesh> operands,
                                   const BooleanFormula& formula,
                                   std::span<const double> deviations, double rounding,
                                   const MeshBooleanResult& made, double tolerance);

}  // namespace genus
