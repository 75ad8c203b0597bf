#pragma once

#include <cstdint>
#include <string>

#include "genus/io/mesh_file.h"
#include "genus/io/write_mesh.h"

namespace genus {

struct StreamCounts {
    std::int64_t vertices = 0;
    std::int64_t faces = 0;
};

/// Whether `stream_mesh` can: the source is a binary STL file by its size, the target STL, PLY, OBJ
/// or OFF. Looks at the first 84 bytes. Throws FileError where the file is not to be read.
bool can_stream(const std::string& source, MeshFormat target);

/// Converts a binary STL file piece by piece, in a few megabytes of memory however long it is.
/// Every triangle keeps three vertices of its own: welding needs all of them at once. Positions are
/// multiplied by `scale`. The target appears whole or not at all.
///
/// Throws FileError as read_mesh_file and write_mesh do, also where the target could not number
/// so many vertices (2^31 - 1; none are numbered in STL), and where the source changes
/// meanwhile; InvalidInput where can_stream is false.
StreamCounts stream_mesh(const std::string& source, const std::string& target,
                         const WriteOptions& options = {}, double scale = 1.0);

}  // namespace genus
