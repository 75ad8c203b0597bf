#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/box.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

/// Finds for each halfedge, numbered 3 face + i for edge i of the face, its opposite: -1 where an
/// edge does not join exactly two faces of opposite direction. Returns the first halfedge whose
/// edge is passed more often one way than the other, -1 if there is none, that is if the faces
/// are closed as a chain. O(faces).
std::int32_t find_twins(std::size_t n_vertices, std::span<const Triangle> faces,
                        std::vector<std::int32_t>& twin);

/// An operand made ready: checked, faces without two different corners left out. Good for as long
/// as the mesh.
class ClosedOperand {
public:
    ClosedOperand() = default;
    ClosedOperand(ClosedOperand&&) = default;
    ClosedOperand& operator=(ClosedOperand&&) = default;

    std::span<const Triangle> faces;   // of the mesh, or `own_faces`
    std::vector<std::int32_t> source;  // number of each face in the mesh given; empty: the same
    std::vector<std::int32_t> twin;
    std::vector<std::int32_t> component;  // of each face; empty if there is one
    std::vector<Box3> boxes;              // of the components

    std::vector<Triangle> own_faces;  // those that differ from the mesh's

    std::int32_t n_components() const { return static_cast<std::int32_t>(boxes.size()); }
    std::int32_t component_of(std::int32_t face) const
    {
        return component.empty() ? 0 : component[face];
    }
};

/// Throws InvalidInput naming `number` and the face. A mesh that is closed only once equal corners
/// are made one is taken as that. O(faces), and a sort of vertices in that case.
ClosedOperand close_operand(const IndexedMesh& mesh, std::int32_t number);

}  // namespace genus::exact
