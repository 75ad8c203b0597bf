#pragma once

#include <cstdint>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// What a Schläfli symbol {p, q} - faces of p sides, q of them at each vertex - says by counting:
/// V = 4 p / (2 p - p q + 2 q), E = 2 p q / (...), F = 4 q / (...).
struct PlatonicCounts {
    std::int64_t vertices, edges, faces;
    bool operator==(const PlatonicCounts&) const = default;
};

/// Throws InvalidInput unless p, q >= 3 and (p - 2)(q - 2) < 4: only five symbols are left.
PlatonicCounts platonic_counts(int p, int q);

/// The regular solid {p, q} with its vertices on the unit sphere, faces turning outward: {3,3}
/// tetrahedron, {4,3} cube, {3,4} octahedron, {5,3} dodecahedron, {3,5} icosahedron. Solids with
/// triangles come from their vertices, the others as duals. Throws as platonic_counts does.
///
/// Implements [coxeter1973], sections 1.3 to 1.7 and 3.7 (symbols, coordinates).
PolygonMesh platonic(int p, int q);

}  // namespace genus
