#pragma once

#include <cstdint>

#include "genus/implicit/implicit.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// Leaves out of a mesh over a grid the small closed parts that the grid has made: where the solid,
/// or the space in it, ends in a thin wedge, single samples in it stand for all of it, and each
/// becomes a part of its own.
///
/// A part goes if its box has a diagonal of at most twice `most`, if its vertices are within `most`
/// of what stays, and if no box a little larger is shown by bounds of the function to have all its
/// sides on one side of the surface: parts of which that can be shown are parts of the solid. The
/// largest part stays. Returns how many went; the order of what stays is as it was. O(faces), and
/// for small parts some hundreds of bounds and a look into a tree for each vertex.
std::int64_t leave_out_specks(IndexedMesh& mesh, const Implicit& field, double cell, double most);

}  // namespace genus
