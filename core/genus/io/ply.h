#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "genus/io/output_file.h"
#include "genus/io/raw_mesh.h"

namespace genus::io {

/// Reads the format of [turk1994], ASCII and binary in both orders of bytes: elements and
/// properties in any order and of any type, lists included. Used are x, y, z and colours of the
/// element vertex, the list vertex_indices (or vertex_index) and colours of the element face, and
/// the same list of the element tristrips, in which -1 ends a strip; the rest is passed over.
RawMesh read_ply(std::span<const std::byte> content, const std::string& name);

/// Binary with the lower byte first, unless `ascii`. Positions are doubles, and in ASCII the
/// shortest text that reads back the same.
void write_ply(Output& output, const MeshFile& file, bool ascii);
void write_ply(Output& output, const IndexedMesh& mesh, bool ascii);

}  // namespace genus::io
