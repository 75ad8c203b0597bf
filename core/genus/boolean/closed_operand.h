#pragma once

#include <cstdint>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

/// Finds for each halfedge, numbered 3 face + i for edge i of the face, its opposite: -1 where an
/// edge does not join exactly two faces of opposite direction. Returns the first halfedge whose
/// edge is passed more often one way than the other, -1 if there is none, that is if the faces
/// are closed as a chain. O(faces).
std::int32_t find_twins(std::size_t n_vertices, const std::vector<Triangle>& faces,
                        std::vector<std::int32_t>& twin);

/// An operand made ready: checked, faces without two different corners left out.
struct ClosedOperand {
    std::vector<Triangle> faces;
    std::vector<std::int32_t> source;  // number of each face in the mesh given; empty: the same
    std::vector<std::int32_t> twin;
    std::vector<std::int32_t> component;  // of each face
    std::int32_t n_components = 0;
};

/// Throws InvalidInput naming `number` and the face. A mesh that is closed only once equal corners
/// are made one is taken as that.
ClosedOperand close_operand(const IndexedMesh& mesh, std::int32_t number);

}  // namespace genus::exact
