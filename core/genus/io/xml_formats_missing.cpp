// Stands in for three_mf.cpp and amf.cpp where the libraries they need were not found.

#include "genus/base/error.h"
#include "genus/io/xml_formats.h"

namespace genus::io {

namespace {

[[noreturn]] void fail(const std::string& name)
{
    throw FileError(name,
                    "3MF and AMF files need zlib and expat, and genus was built without them");
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

}  // namespace genus::io
