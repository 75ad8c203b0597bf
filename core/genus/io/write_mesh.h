#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "genus/io/mesh_file.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct WriteOptions {
    /// Taken from the extension of the path unless given here.
    std::optional<MeshFormat> format;
    /// Text where the format also has a binary form (STL, PLY).
    bool ascii = false;
};

/// Writes a mesh as STL, OBJ, OFF, PLY, glTF, 3MF or AMF. Reading the file back gives the same
/// mesh, except that binary STL and glTF round positions to 4-byte numbers, that both join vertices
/// at one place, that they, 3MF and AMF cut faces into triangles, and that STL drops vertices
/// without a face. Colours are kept by PLY, OFF, glTF and AMF, by 3MF for faces, and by OBJ for
/// vertices (without alpha) and, in a .mtl file written beside it, for faces. glTF is in metres:
/// the mesh is scaled where its unit is known.
///
/// The file appears whole or not at all, also when the call is cancelled: it is written under
/// another name in the same folder and then renamed. Bytes do not depend on the number of threads.
///
/// Throws FileError where the format is unknown, the folder is missing or not to be written to,
/// or the disk is full; InvalidInput where a coordinate is not finite, a face names a vertex that
/// does not exist or has fewer than three corners, or a list of colours has the wrong length.
void write_mesh(const std::string& path, const IndexedMesh& mesh, const WriteOptions& options = {});
void write_mesh(const std::string& path, const PolygonMesh& mesh, const WriteOptions& options = {});
void write_mesh_file(const std::string& path, const MeshFile& file,
                     const WriteOptions& options = {});

/// The bytes of such a file.
std::vector<std::byte> mesh_bytes(const IndexedMesh& mesh, MeshFormat format, bool ascii = false);
std::vector<std::byte> mesh_bytes(const MeshFile& file, MeshFormat format, bool ascii = false);

}  // namespace genus
