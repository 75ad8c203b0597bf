#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/io/sample_meshes.h"
#include "fuzz/mesh_mutations.h"

namespace genus {
namespace {

FileBytes bytes_of(std::string_view text)
{
    const auto bytes = as_bytes(text);
    return FileBytes(bytes.begin(), bytes.end());
}

MeshFile colored_cube()
{
    MeshFile file;
    file.mesh = cut_cube();
    file.vertex_colors.assign(file.mesh.n_vertices(), {1, 2, 3, 4});
    file.face_colors.assign(file.mesh.n_faces(), {250, 251, 252, 253});
    return file;
}

// A PLY file with everything in it: lists among scalars, further elements, the higher byte first.
FileBytes elaborate_ply()
{
    std::string text =
        "ply\nformat binary_big_endian 1.0\ncomment c\nobj_info o\nelement extra 2\n"
        "property list ushort float values\nproperty short s\nelement vertex 3\n"
        "property uchar red\nproperty float x\nproperty double y\nproperty int z\n"
        "property uchar green\nproperty uchar blue\nelement face 1\nproperty double quality\n"
        "property list uint uint vertex_indices\nelement tristrips 1\n"
        "property list int int vertex_indices\nend_header\n";
    text += std::string("\0\1\0\0\0\0\0\1\0\0\0\2", 12);
    for (int v = 0; v < 3; ++v) text += std::string(1, 'r') + std::string(16, '\0') + "gb";
    text += std::string(8, '\0');
    text += std::string("\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2", 16);
    text += std::string("\0\0\0\4\0\0\0\0\0\0\0\1\0\0\0\2\xFF\xFF\xFF\xFF", 20);
    return bytes_of(text);
}

struct Seed {
    std::string name;
    FileBytes file;
};

std::vector<Seed> seeds()
{
    std::vector<Seed> list;
    const MeshFile cube = colored_cube();
    const IndexedMesh torus = torus_mesh(6, 8);
    for (const bool ascii : {false, true}) {
        list.push_back({"cube.stl", mesh_bytes(cube, MeshFormat::stl, ascii)});
        list.push_back({"cube.ply", mesh_bytes(cube, MeshFormat::ply, ascii)});
        list.push_back({"torus.stl", mesh_bytes(torus, MeshFormat::stl, ascii)});
        list.push_back({"torus.ply", mesh_bytes(torus, MeshFormat::ply, ascii)});
    }
    list.push_back({"elaborate.ply", elaborate_ply()});
    for (const MeshFormat format : {MeshFormat::obj, MeshFormat::off}) {
        list.push_back({std::string("cube.") + format_name(format), mesh_bytes(cube, format)});
        list.push_back({std::string("torus.") + format_name(format), mesh_bytes(torus, format)});
    }
    for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf})
        list.push_back({std::string("cube.") + format_name(format), mesh_bytes(cube, format)});
#ifdef GENUS_XML_FORMATS
    for (const MeshFormat format : {MeshFormat::three_mf, MeshFormat::amf})
        list.push_back({std::string("cube.") + format_name(format), mesh_bytes(cube, format)});
#endif
    list.push_back({"forms.obj", bytes_of("# c\nv 0 0 0 1\nv 1 0 \\\n 0\nv 0 1 0 .1 .2 .3\nvt 0 0\n"
                                          "vn 0 0 1\no a\ng b\ns 1\nusemtl m\nl 1 2\n"
                                          "f 1/1 2/1 3/1\nf -3//-1 -2//-1 -1//-1\n"
                                          "f 1/1/1 2/1/1 3/1/1\n")});
    list.push_back({"forms.off", bytes_of("CNOFF # c\n3 2 0\n0 0 0 0 0 1 255 0 0\n"
                                          "1 0 0 0 0 1 0 255 0\n0 1 0 0 0 1 .1 .2 .3 .4\n"
                                          "3 0 1 2 9\n3 2 1 0 1 2 3\n")});
    return list;
}

std::uint64_t rounds()
{
    return std::getenv("GENUS_LONG") != nullptr ? 200'000 : 200;
}

template <class Spoil>
void expect_mesh_or_error(const Spoil& spoil)
{
    int errors = 0;
    for (const Seed& seed : seeds()) {
        ASSERT_EQ(outcome_of(seed.file, seed.name), Outcome::mesh) << seed.name;
        for (std::uint64_t i = 0; i < rounds(); ++i) {
            Spoiler spoiler(i);
            const Outcome outcome = outcome_of(spoil(spoiler, seed.file), seed.name);
            ASSERT_NE(outcome, Outcome::broken) << seed.name << ", seed " << i;
            errors += outcome == Outcome::file_error;
        }
    }
    EXPECT_GT(errors, 0);
}

TEST(HostileFiles, CutShortIsAMeshOrAnError)
{
    expect_mesh_or_error([](Spoiler& s, const FileBytes& file) { return s.cut_short(file); });
}

TEST(HostileFiles, WithFlippedBitsIsAMeshOrAnError)
{
    expect_mesh_or_error([](Spoiler& s, const FileBytes& file) { return s.flip_bits(file); });
}

TEST(HostileFiles, SpoiledAgainAndAgainIsAMeshOrAnError)
{
    expect_mesh_or_error([](Spoiler& s, FileBytes file) {
        for (int i = 0; i < 3; ++i) file = s.spoil(std::move(file));
        return file;
    });
}

TEST(HostileFiles, ReadAsAnyFormatIsAMeshOrAnError)
{
    for (const Seed& seed : seeds()) {
        for (const MeshFormat format :
             {MeshFormat::stl, MeshFormat::obj, MeshFormat::off, MeshFormat::ply, MeshFormat::glb,
              MeshFormat::three_mf, MeshFormat::amf}) {
            ASSERT_NE(outcome_of(seed.file, seed.name, {format}), Outcome::broken);
            for (std::uint64_t i = 0; i < rounds() / 8; ++i)
                ASSERT_NE(outcome_of(Spoiler(i).spoil(seed.file), seed.name, {format}),
                          Outcome::broken)
                    << seed.name << " as " << format_name(format) << ", seed " << i;
        }
    }
}

// Every one of the lengths, not some: no prefix of a binary file is another file, no prefix of a
// text that ends within a face is a mesh with that face.
TEST(HostileFiles, NoPrefixOfABinaryFileIsAMesh)
{
    for (const Seed& seed : seeds()) {
        const bool binary = seed.name == "elaborate.ply" || seed.name.ends_with(".stl");
        if (!binary) continue;
        for (std::size_t n = 0; n + 8 < seed.file.size(); ++n) {
            const FileBytes prefix(seed.file.begin(),
                                   seed.file.begin() + static_cast<std::ptrdiff_t>(n));
            ASSERT_EQ(outcome_of(prefix, seed.name), Outcome::file_error) << seed.name << " " << n;
        }
    }
}

TEST(HostileFiles, NoiseIsAnError)
{
    std::mt19937_64 random(99);
    for (const std::string name : {"n.stl", "n.ply", "n.obj", "n.off", "n"}) {
        for (int i = 0; i < 200; ++i) {
            FileBytes noise(1 + random() % 300);
            for (std::byte& b : noise) b = static_cast<std::byte>(random());
            ASSERT_NE(outcome_of(noise, name), Outcome::broken);
        }
    }
}

}  // namespace
}  // namespace genus
