// Entry for a coverage-guided fuzzer: any bytes are a mesh or a FileError. Built by hand with
//   clang++ -std=c++20 -fsanitize=fuzzer,address,undefined -Icore -Itests
//       tests/fuzz/read_mesh_fuzz.cpp core/genus/{io,mesh,polygon,base}/*.cpp -lz -lexpat

#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "fuzz/mesh_mutations.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using genus::MeshFormat;
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    const genus::FileBytes file(bytes, bytes + size);
    if (genus::outcome_of(file, "fuzz") == genus::Outcome::broken) std::abort();
    for (const MeshFormat format :
         {MeshFormat::stl, MeshFormat::obj, MeshFormat::off, MeshFormat::ply, MeshFormat::glb,
          MeshFormat::three_mf, MeshFormat::amf})
        if (genus::outcome_of(file, "fuzz", {format}) == genus::Outcome::broken) std::abort();
    return 0;
}
