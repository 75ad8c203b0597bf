#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "genus/model/cell_mesh.h"

namespace genus {

/// The vertices at each place where a mesh touches itself, by `SurfaceMesh::touch_of_vertex`.
std::vector<std::vector<std::int32_t>> vertices_by_place(std::span<const std::int32_t> touch);

/// Makes a closed surface mesh manifold where the solid touches itself: at an edge of four or more
/// faces, those that bound the same wedge of matter stay together, and a vertex with several fans
/// of faces becomes one vertex a fan. The ends of such edges get their `touch_of_vertex`. Returns
/// false, and leaves the mesh alone, if it is not closed and oriented to begin with. O(F).
bool separate_fans(SurfaceMesh& mesh);

/// The same faces with such edges taken apart the other way: those that bound the same wedge of
/// empty space stay together. Where the mesh touches itself its faces have new vertices,
/// `n_vertices() + i`, at the place of the vertex `original[i]`; elsewhere they keep theirs.
struct FansOfSpace {
    std::vector<Triangle> faces;
    std::vector<std::int32_t> original;
};
/// Nothing if faces round an edge do not alternate. O(F).
std::optional<FansOfSpace> fans_of_space(const SurfaceMesh& mesh);

}  // namespace genus
