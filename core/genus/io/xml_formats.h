#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "genus/io/output_file.h"
#include "genus/io/pack.h"
#include "genus/io/raw_mesh.h"

// 3MF and AMF need the libraries zlib and expat. Where genus was built without them, every function
// here that reads or writes throws a FileError that says so.

namespace genus::io {

/// Whether these bytes begin like a ZIP archive.
inline bool is_zip(std::span<const std::byte> content)
{
    return content.size() >= 4 &&
           load<std::uint32_t>(content.data(), std::endian::little) == 0x04034B50;
}

/// Reads the 3D Manufacturing Format [consortium2018], with models in several parts (production
/// extension): the objects of the build, components included, placed by their maps. Colours of
/// triangles come from base materials and colour groups, of which the first corner's is taken.
/// Vertices are kept as they are, in the unit of the file.
RawMesh read_3mf(std::span<const std::byte> content, const std::string& name);

/// Colours of faces become base materials; those of vertices are left out. The unit is the
/// file's where the format knows it; any other known unit is scaled to millimetres.
void write_3mf(Output& output, const MeshFile& file);

/// Reads the Additive Manufacturing File Format [astm52915], plain or in a ZIP archive: all
/// objects, those of constellations placed by them. Curved triangles are read as flat ones, colours
/// given by formulas are left out.
RawMesh read_amf(std::span<const std::byte> content, const std::string& name);

/// Plain text, with colours of vertices and faces. Units as for 3MF.
void write_amf(Output& output, const MeshFile& file);

}  // namespace genus::io
