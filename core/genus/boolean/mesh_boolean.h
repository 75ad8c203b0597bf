#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "genus/boolean/formula.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct MeshBooleanOptions {
    /// Join faces of one plane and triangulate them anew without needless corners.
    bool merge_coplanar = true;
    /// Resolve crossings of an operand with itself. Off is a promise that no operand crosses or
    /// touches itself, nor would if its corners were rounded once more, and saves about half of
    /// the time; a broken promise ends in an Error where it is noticed.
    bool operands_may_cross_themselves = true;
    /// How far the corners of operands may be moved, as a share of the size of their cluster,
    /// where faces so nearly coincide that the result could not be written in doubles.
    double most_snap = 1e-9;
    /// Unions of more operands than this, and subtractions of more, are solved in groups of
    /// neighbours first where their faces cross more than a few others each; each group exactly, on
    /// the grid of the whole. Corners between groups are rounded once a step.
    std::int32_t largest_union = 32;
};

struct MeshBooleanReport {
    /// Largest step of the integer grids used, in model units.
    double grid_step = 0.0;
    /// Largest distance, per coordinate, that an input corner was moved to reach its grid.
    double largest_snap = 0.0;
    std::int64_t n_components = 0;  // of all operands
    std::int64_t n_clusters = 0;    // of components whose boxes overlap; each is solved alone
    std::int64_t n_candidate_pairs = 0;
    std::int64_t n_contacts = 0;       // pairs of faces that meet
    std::int64_t n_passive_faces = 0;  // input faces that nothing touches
    std::int64_t n_left_alone = 0;     // of them: near none that anything touches, not looked at
    std::int64_t n_buried_faces = 0;   // that lie where they cannot matter and are not cut
    std::int64_t n_cells = 0;          // pieces of the others
    std::int64_t n_new_points = 0;
    /// Groups solved on the way, see `largest_union`; counts above are sums over them.
    std::int64_t n_steps = 0;
    /// Times that the rounded result crossed itself and was solved once more.
    std::int64_t n_mended = 0;
    /// Operands whose edges and components were known from an earlier call, and those known not to
    /// cross themselves, for which that was not looked for again.
    std::int64_t n_known = 0;
    std::int64_t n_known_clean = 0;
};

struct MeshBooleanResult {
    IndexedMesh mesh;
    /// Of each face of the result: the operand it comes from and its number there. Where faces of
    /// several operands cover each other, one of them.
    std::vector<std::int32_t> operand;
    std::vector<std::int32_t> source_face;
    MeshBooleanReport report;
    /// The mesh was seen not to touch itself, so that as an operand it need not be looked at again.
    bool clean = false;
};

/// A mesh that does not change, with what booleans find out about it: its edges and components,
/// and on which grids it does not cross itself. Copies share that, so that a chain of edits pays
/// for the import of each mesh once. Takes up to 16 bytes a face. Safe to use from many threads.
class BooleanOperand {
public:
    /// `clean` as of a result.
    explicit BooleanOperand(std::shared_ptr<const IndexedMesh> mesh, bool clean = false);

    const IndexedMesh& mesh() const;

    struct Known;  // see operand.h
    Known& known() const { return *known_; }

private:
    std::shared_ptr<Known> known_;
};

/// The set that `formula` describes, as a closed, oriented and manifold mesh; parts that only
/// touch have corners of their own. An empty set is an empty mesh.
///
/// An operand is a closed mesh of any number of components. It stands for the points that it
/// winds round a number of times other than zero, so its components may be nested, touch and
/// cross, and a mesh turned inside out means the same as before.
///
/// Coordinates are moved once to an integer grid local to each cluster of overlapping components:
/// 2^52 to 2^53 steps across the cluster, so that only coordinates much closer to zero than others
/// of their cluster move at all. From there on all decisions are exact; coplanar faces, touching
/// edges and common corners are ordinary cases. Corners made by intersection are rounded to the
/// nearest grid point that is a triple of doubles. If faces cross after that, the result is solved
/// again as an operand of its own, and if that does not end, the call throws.
///
/// We chose an arrangement of whole faces with implicit points, not a partition into convex
/// pieces: faces that nothing touches then pass through as they are, and the cost beyond finding
/// them grows with the intersections. Of large operands that meet here and there only the zones
/// where they do are arranged. Implements [cherchi2020] and [zhou2016]; see arrangement.h, zone.h
/// and winding.h.
///
/// Results do not depend on the number of threads. Throws InvalidInput naming operand and face
/// for operands that are not closed, not finite (or beyond 1e300) or with corners out of range,
/// and for a formula that is not sound or holds at infinity; Error with the place if the rounded
/// result cannot be mended.
MeshBooleanResult mesh_boolean(std::span<const IndexedMesh> operands, const BooleanFormula& formula,
                               const MeshBooleanOptions& options = {});
/// The same bits, sooner where operands come up again.
MeshBooleanResult mesh_boolean(std::span<const BooleanOperand> operands,
                               const BooleanFormula& formula,
                               const MeshBooleanOptions& options = {});

/// The mesh alone, for one operation.
IndexedMesh unite(std::span<const IndexedMesh> operands);
IndexedMesh intersect(std::span<const IndexedMesh> operands);
/// Operand 0 less all others.
IndexedMesh subtract(std::span<const IndexedMesh> operands);

}  // namespace genus
