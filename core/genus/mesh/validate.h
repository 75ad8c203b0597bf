#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "genus/mesh/topology.h"

namespace genus {

/// What can be wrong with the border of a solid, in the order it is looked for.
enum class Defect {
    IndexOutOfRange,   ///< a face names a vertex that is not there; nothing else is checked then
    NonFinite,         ///< a coordinate is infinite or not a number; no geometry is checked then
    DegenerateFace,    ///< a vertex twice, or all corners on one line, exactly
    DuplicateFace,     ///< the same three vertices as an earlier face
    OpenEdge,          ///< an edge of one face
    FlippedEdge,       ///< the two faces of an edge disagree about the outside
    ComplexEdge,       ///< an edge of more than two faces
    ComplexVertex,     ///< more than one fan of faces round a vertex
    SelfIntersection,  ///< two faces meet elsewhere than in common corners or a common side
    Inverted,          ///< a closed part whose outside is the wrong one for where it lies
    TJunction          ///< a vertex of an open edge that lies within another, exactly
};
constexpr std::size_t kDefects = 11;

/// "open edge" and so on.
const char* name(Defect defect);

struct Finding {
    Defect defect;
    std::vector<std::int32_t> vertices;
    std::vector<std::int32_t> faces;
    Vec3 at;           // a point of it, model units
    std::string text;  // one line, with the numbers above
};

struct ValidateOptions {
    bool self_intersections = true;
    /// Findings listed of each kind; all are counted.
    std::size_t max_findings = 100;
};

struct Validation {
    /// In the order of Defect, then of element numbers.
    std::vector<Finding> findings;
    /// How many of each kind there are.
    std::array<std::int64_t, kDefects> counts{};
    /// False if the search for self-intersections was not made or ended early, for there are
    /// millions of them.
    bool self_intersections_complete = false;
    /// Of the faces that are not degenerate; empty if an index is out of range.
    Topology topology;

    std::int64_t count(Defect defect) const { return counts[static_cast<std::size_t>(defect)]; }
    /// No defect of any kind was found.
    bool ok() const { return findings.empty(); }
};

/// Looks for everything that keeps a mesh from being the border of a solid. Self-intersections
/// are found with a box tree and exact tests; the rest is exact too, except that the turn of a
/// closed part is taken from the sign of its rounded volume. A part must enclose matter (turn
/// outward) where no other part encloses it, and be a cavity (turn inward) where one does.
///
/// O(F log F + overlapping boxes), in parallel, the same findings at any thread count. Never
/// throws for what is wrong with the mesh; Cancelled as always.
///
/// Implements [botsch2010], section 1.3 (manifolds); self-intersection as in
/// triangle_intersection.h.
Validation validate(const IndexedMesh& mesh, const ValidateOptions& options = {});

/// Pairs of faces, the smaller number first, ascending, that meet elsewhere than in common
/// corners or a common side. Corners are common if their coordinates are equal. Faces without
/// area, and pairs with the same three vertices, are left out. Ends early past some
/// millions of pairs: `complete` is false then. Throws InvalidInput for a vertex number out of
/// range or a coordinate of a face that is not finite.
struct SelfIntersections {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    bool complete = true;
};
SelfIntersections self_intersections(const IndexedMesh& mesh);

}  // namespace genus
