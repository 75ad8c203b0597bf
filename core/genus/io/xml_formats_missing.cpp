// Stands in for three_mf.cpp, amf.cpp, png.cpp and svg.cpp where the libraries they need were not
// found.

#include "genus/base/error.h"
#include "genus/io/png.h"
#include "genus/io/region_file.h"
#include "genus/io/xml_formats.h"

namespace genus::io {

namespace {

[[noreturn]] void fail(const std::string& name)
{
    throw FileError(name,
                    "3MF, AMF and SVG files need zlib and expat, and genus was built without them");
}

}  // namespace

RawMesh read_3mf(std::span<const std::byte>, const std::string& name)
{
    fail(name);
}

void write_3mf(Output& output, const MeshFile&)
{
    fail(output.name());
}

RawMesh read_amf(std::span<const std::byte>, const std::string& name)
{
    fail(name);
}

void write_amf(Output& output, const MeshFile&)
{
    fail(output.name());
}

Picture read_png(std::span<const std::byte>, const std::string& name)
{
    throw FileError(name, "PNG files need zlib, and genus was built without it");
}

bool is_png(std::span<const std::byte> content)
{
    return content.size() >= 4 && content[1] == std::byte{'P'} && content[2] == std::byte{'N'} &&
           content[3] == std::byte{'G'};
}

}  // namespace genus::io

namespace genus {

Region read_svg(std::string_view, const std::string& name, const RegionReadOptions&)
{
    throw FileError(name, "SVG files need expat, and genus was built without it");
}

}  // namespace genus
