#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "genus/io/mesh_file.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct ReadOptions {
    /// Taken from the content where that is plain, else from the extension, unless given here.
    std::optional<MeshFormat> format;
};

/// Reads an STL (binary, ASCII), OBJ, OFF, PLY (ASCII, binary), glTF (text, binary), 3MF or AMF
/// file. The last two need zlib and expat; where genus was built without them, a FileError says so.
///
/// Positions come as they stand in the file, in its units, rounded to the nearest double. The
/// corners of an STL file become shared vertices where their three coordinates are equal (-0
/// equals 0), numbered in the order of first use. Faces keep their degree, order and orientation;
/// nothing is repaired and no vertex dropped. glTF, too, is welded; see gltf.h. Normals, texture
/// coordinates and lines are left out.
///
/// Throws FileError with the byte or line of the mistake where the file is missing, cut short or
/// malformed: counts that the file is too short for, indices of vertices that do not exist,
/// coordinates that are not finite numbers, faces of fewer than three corners, bytes left over.
/// Then nothing is returned. Memory: a small multiple of the size of the file. Can be cancelled.
MeshFile read_mesh_file(const std::string& path, const ReadOptions& options = {});
PolygonMesh read_polygons(const std::string& path, const ReadOptions& options = {});
/// With faces of more than three corners cut by `to_triangles`.
IndexedMesh read_mesh(const std::string& path, const ReadOptions& options = {});

/// The same from the bytes of a file; `name` stands for its path in messages, and its extension
/// is heeded.
MeshFile read_mesh_file(std::span<const std::byte> content, const std::string& name,
                        const ReadOptions& options = {});
PolygonMesh read_polygons(std::span<const std::byte> content, const std::string& name,
                          const ReadOptions& options = {});
IndexedMesh read_mesh(std::span<const std::byte> content, const std::string& name,
                      const ReadOptions& options = {});

}  // namespace genus
