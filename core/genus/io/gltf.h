#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "genus/io/output_file.h"
#include "genus/io/raw_mesh.h"

namespace genus::io {

/// Reads glTF 2.0 [khronos2021], the text form and the binary one (GLB): the triangles, strips and
/// fans of the default scene, placed by their nodes, colours of vertices, and base colours of
/// materials as colours of faces. Vertices are welded where positions are equal: the format has to
/// split them where normals differ. If such vertices differ in colour none are welded. A unit is
/// a metre by definition; axes stay as they are in the file.
///
/// Data lie in the file itself or in files of `folder`; without a folder only in the file itself.
/// Sparse accessors, compressed and quantised meshes are refused by name.
RawMesh read_gltf(std::span<const std::byte> content, const std::string& name,
                  const std::optional<std::string>& folder);

/// Positions become 4-byte numbers; where the unit is known they are scaled to metres. Faces are
/// grouped by colour into materials. The text form holds its data within.
void write_gltf(Output& output, const MeshFile& file, bool binary);

}  // namespace genus::io
