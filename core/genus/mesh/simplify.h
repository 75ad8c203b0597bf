#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct SimplifyOptions {
    /// Largest distance allowed between the surfaces, both ways, in model units.
    double tolerance = std::numeric_limits<double>::infinity();
    /// Stop at so many faces; at least one of the two limits must be given.
    std::optional<std::int64_t> max_faces;
    /// Prove the bound. Without it only points are sampled, and the tolerance is met as far as they
    /// tell.
    bool certify = true;
};

struct SimplifiedMesh {
    IndexedMesh mesh;
    /// Largest distance found between the surfaces, of vertices and sampled points, both ways.
    double measured = 0.0;
    /// No point of either surface is farther from the other: proven if `certified`, up to rounding
    /// of the distances themselves; else an estimate, `measured` itself.
    double bound = 0.0;
    bool certified = false;
    /// How many limits to the quadric error were tried.
    int attempts = 0;
};

/// Fewer faces for nearly the same surface: edges are drawn together to the points of least
/// quadric error, cheapest first (up to an eighth), until all others would err by more than a
/// limit, at first the tolerance. Then the distance of the two surfaces is measured both ways and
/// bounded as in distance.h. Where the bound exceeds the tolerance, all begins again with a smaller
/// limit; where much of the tolerance is left, with a larger one, three times at most. The mesh of
/// fewest faces that holds comes back, the given one if none does: the bound reported is at most
/// the tolerance.
///
/// Topology is kept by the link condition: components, handles and boundary loops stay, a closed
/// mesh stays closed. No face turns over by a right angle or loses its area in one step; faces may
/// cross others nevertheless, which `validate` finds. Vertices that no face names are dropped.
/// The same input gives the same output bit for bit, at any thread count.
///
/// O(F log F) an attempt, beside the distances. Throws InvalidInput for a mesh that is not
/// manifold, naming the element, coordinates that are not finite, a tolerance that is not
/// positive, max_faces below zero, or no limit at all.
///
/// Implements [garland1997] with the quadrics weighted by area and its planes through the boundary,
/// the link condition of [botsch2010], section 7.2, in place of its pairs of unconnected vertices.
SimplifiedMesh simplify(const IndexedMesh& mesh, const SimplifyOptions& options);

}  // namespace genus
