#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "genus/io/output_file.h"
#include "genus/io/raw_mesh.h"

namespace genus::io {

/// Reads the text form of [phillips2007], section 4.2.5: the word OFF, before it any of the letters
/// ST, C and N for texture coordinates, colours and normals of vertices; without the word it is
/// OFF. Colours of faces are read, too; indices into a colour map are not. The four-dimensional
/// and the binary form are refused by name.
RawMesh read_off(std::span<const std::byte> content, const std::string& name);

/// Positions as the shortest text that reads back the same; COFF where vertices have colours.
void write_off(Output& output, const MeshFile& file);
void write_off(Output& output, const IndexedMesh& mesh);

}  // namespace genus::io
