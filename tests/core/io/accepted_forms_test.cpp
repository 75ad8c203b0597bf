#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <vector>

#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/io/read_mesh.h"

namespace genus {
namespace {

PolygonMesh read(std::string_view text, const std::string& name)
{
    return read_polygons(as_bytes(text), name);
}

IndexedMesh triangle()
{
    IndexedMesh mesh;
    mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    mesh.faces = {{0, 1, 2}};
    return mesh;
}

std::string with_line_ends(std::string text, const std::string& ending)
{
    for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += ending.size())
        text.replace(i, 1, ending);
    return text;
}

// ---- choice of the format ----

TEST(FormatChoice, TakesExtensionsInEitherCase)
{
    EXPECT_EQ(format_of_extension("a.b/c.STL"), MeshFormat::stl);
    EXPECT_EQ(format_of_extension("c.Obj"), MeshFormat::obj);
    EXPECT_EQ(format_of_extension("c.coff"), MeshFormat::off);
    EXPECT_EQ(format_of_extension("c.tar.ply"), MeshFormat::ply);
    EXPECT_EQ(format_of_extension("a.stl/c"), std::nullopt);
    EXPECT_EQ(format_of_extension("stl"), std::nullopt);
    EXPECT_EQ(format_of_extension("c.stl.gz"), std::nullopt);
    EXPECT_EQ(format_of_extension(""), std::nullopt);
}

TEST(FormatChoice, IsNotFooledByABinaryStlThatBeginsWithSolid)
{
    auto bytes = mesh_bytes(torus_mesh(4, 5), MeshFormat::stl);
    const IndexedMesh expected = read_mesh(bytes, "a.stl");
    const std::string comment = "solid facet endsolid " + std::string(59, ' ');
    for (std::size_t i = 0; i < 80; ++i) bytes[i] = static_cast<std::byte>(comment[i]);
    EXPECT_EQ(read_mesh(bytes, "a.stl"), expected);
    EXPECT_EQ(read_mesh(bytes, "a"), expected);
}

TEST(FormatChoice, ReadsAnObjUnderAnyName)
{
    EXPECT_EQ(read("# solid facet\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a"),
              to_polygons(triangle()));
}

TEST(FormatChoice, CanBeForced)
{
    const ReadOptions as_obj{MeshFormat::obj};
    EXPECT_EQ(read_mesh(as_bytes("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "a.stl", as_obj),
              triangle());
}

// ---- STL ----

TEST(AsciiStl, ReadsEveryWayOfSettingIt)
{
    for (const std::string ending : {"\n", "\r\n", "\r", " \t\r\n\r\n"}) {
        const std::string text = with_line_ends(
            "  SOLID name of # it, endsolid\n\tfacet  normal nan -nan(ind) 1\nOUTER loop\nvertex "
            "0 0 0\n vertex +1.0 0e5 -0\n vertex .0 1. 0\nendloop endfacet\nEndSolid name\n\n",
            ending);
        EXPECT_EQ(read(text, "a.stl"), to_polygons(triangle())) << ending;
        EXPECT_EQ(read(text, "a"), to_polygons(triangle())) << ending;
    }
}

TEST(AsciiStl, JoinsSeveralSolidsAndKeepsPolygons)
{
    const PolygonMesh mesh = read(
        "solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop "
        "endfacet\nendsolid a\nsolid b\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 0 1 0 "
        "vertex -1 1 0 vertex -1 0 0 endloop endfacet\nend solid b\nsolid\nendsolid",
        "a.stl");
    EXPECT_EQ(mesh.n_vertices(), 5u);
    ASSERT_EQ(mesh.n_faces(), 2u);
    EXPECT_EQ(mesh.face(1).size(), 4u);
    EXPECT_EQ(mesh.face(1)[1], 2);
}

TEST(BinaryStl, PassesOverAFewBytesBehindTheLastTriangle)
{
    auto bytes = mesh_bytes(triangle(), MeshFormat::stl);
    bytes.resize(bytes.size() + 49);
    EXPECT_EQ(read_mesh(bytes, "a.stl"), triangle());
}

// ---- OBJ ----

TEST(Obj, ReadsEveryWayOfSettingIt)
{
    for (const std::string ending : {"\n", "\r\n", "\r"}) {
        const std::string text = with_line_ends(
            "\xEF\xBB\xBF# comment \\\n\nmtllib a b.mtl\n  o thing\nv\t0 0 0 1.0 # first\nv 1 \\\n"
            "0 0\n\nvn 0 0 1\nvt 0.5 0.5\nv 0 1 0\ng a b\ns off\nusemtl red\nl 1 2 \\\n3\np 1\n"
            "f 1/1/1 \\\n2/1/1 3/1/1 # last",
            ending);
        EXPECT_EQ(read(text, "a.obj"), to_polygons(triangle()));
    }
}

TEST(Obj, TakesEachFormOfACorner)
{
    const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (const std::string face :
         {"f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 2/2/2 3/3/3", "f -3 -2 -1",
          "f -3/-1 2/-1 -1/-1", "f -3//-1 -2//-1 3//-1", "f 1/ 2/ 3/", "fo 1 2 3"})
        EXPECT_EQ(read(points + face, "a.obj"), to_polygons(triangle())) << face;
}

TEST(Obj, TakesFacesBeforeTheirVertices)
{
    EXPECT_EQ(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n", "a.obj"), to_polygons(triangle()));
}

TEST(Obj, ReadsColorsOfSomeVertices)
{
    const MeshFile file =
        read_mesh_file(as_bytes("v 0 0 0\nv 1 0 0 0 .5 2\nv 0 1 0 1 0 0 .2\nv 0 0 1\n"), "a.obj");
    const std::vector<Rgba> expected = {{}, {0, 128, 255, 255}, {255, 0, 0, 51}, {}};
    EXPECT_EQ(file.vertex_colors, expected);
}

// ---- OFF ----

TEST(Off, ReadsEveryWayOfSettingIt)
{
    for (const std::string text :
         {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
          "# a\n OFF # b\n\n3 1\n0 0 0 # c\n1 0 0\n\n0 1 "
          "0\n # d\n3 0 1 2",
          "OFF 3 1 3 0 0 0 1 0 0 0 1 0 3 0 1 2", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
          "OFF\n3 1 0\n0\n0 0 1\n0 0 0 1 0\n3\n0 1\n2\n",
          "NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n",
          "STOFF\n3 1 0\n0 0 0 .5 .5\n1 0 0 .5 .5\n0 1 0 .5 .5\n3 0 1 2 7\n"})
        for (const std::string ending : {"\n", "\r\n", "\r"})
            EXPECT_EQ(read(with_line_ends(text, ending), "a.off"), to_polygons(triangle())) << text;
}

TEST(Off, ReadsColorsAsIntegersAndAsFractions)
{
    const MeshFile file = read_mesh_file(
        as_bytes("STCNOFF\n3 2 0\n0 0 0 0 0 1 255 0 7 9 .5 .5\n1 0 0 0 0 1 0.2 0 1.0 .4 .5 .5\n"
                 "0 1 0 0 0 1 1 2 3 4 .5 .5\n3 0 1 2\n3 2 1 0 10 20 30\n"),
        "a.off");
    const std::vector<Rgba> vertex_colors = {{255, 0, 7, 9}, {51, 0, 255, 102}, {1, 2, 3, 4}};
    EXPECT_EQ(file.vertex_colors, vertex_colors);
    const std::vector<Rgba> face_colors = {{}, {10, 20, 30, 255}};
    EXPECT_EQ(file.face_colors, face_colors);
}

// ---- PLY ----

const std::string kAsciiPly =
    "ply\nformat ascii 1.0\ncomment made by hand\nobj_info nothing\nelement face 1\n"
    "property int flags\nproperty list uint8 int32 vertex_index\nproperty list uchar float uv\n"
    "element edge 2\nproperty int a\nproperty int b\nelement nothing 99999999999\n"
    "element vertex 3\nproperty float nx\nproperty double z\nproperty short x\n"
    "property list char int ring\nproperty float32 y\nend_header\n";

TEST(Ply, ReadsElementsAndPropertiesInAnyOrder)
{
    const std::string body =
        "77 3 0 1 2 2 0.5 nan\n1 2\n3 4\nnan 0 0 0 0\n0 0 1 3 7 8 9 0\n0 0 0 0 1\n";
    for (const std::string ending : {"\n", "\r\n", "\r"})
        EXPECT_EQ(read(with_line_ends(kAsciiPly + body, ending), "a.ply"), to_polygons(triangle()));
}

// Every number type as position, in both orders of bytes.
TEST(Ply, ReadsPositionsOfEveryType)
{
    struct Type {
        std::string name;
        std::size_t size;
        std::string one;  // the number 1, higher byte first
    };
    for (const Type& type : {Type{"char", 1, "\1"}, Type{"uint8", 1, "\1"}, Type{"short", 2, "\1"},
                             Type{"ushort", 2, "\1"}, Type{"int", 4, "\1"}, Type{"uint32", 4, "\1"},
                             Type{"int64", 8, "\1"}, Type{"uint64", 8, "\1"},
                             Type{"float", 4, "\x3F\x80"}, Type{"double", 8, "\x3F\xF0"}}) {
        for (const bool big : {true, false}) {
            const bool whole = type.one.size() == 1;
            std::string one = whole ? std::string(type.size - 1, '\0') + type.one
                                    : type.one + std::string(type.size - 2, '\0');
            if (!big) one = std::string(one.rbegin(), one.rend());
            const std::string zero(type.size, '\0');
            std::string text = "ply\nformat binary_";
            text += big ? "big" : "little";
            text += "_endian 1.0\nelement vertex 3\n";
            for (const char* axis : {"x", "y", "z"})
                text.append("property ").append(type.name).append(" ").append(axis).append("\n");
            text += "element face 1\nproperty list " + std::string(whole ? type.name : "int") + " ";
            text += std::string(whole ? type.name : "short") + " vertex_indices\nend_header\n";
            for (const std::string& number : {zero, zero, zero, one, zero, zero, zero, one, zero})
                text += number;
            const auto integer = [&](char value, std::size_t size) {
                std::string bytes(size, '\0');
                bytes[big ? size - 1 : 0] = value;
                return bytes;
            };
            text += integer(3, whole ? type.size : 4);
            for (const char v : {0, 1, 2}) text += integer(v, whole ? type.size : 2);
            EXPECT_EQ(read(text, "a.ply"), to_polygons(triangle())) << type.name << big;
        }
    }
}

TEST(Ply, TurnsTriangleStripsTheRightWay)
{
    const PolygonMesh mesh = read(
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 0 0\n9 0 1 2 3 -1 1 4 3 3\n",
        "a.ply");
    ASSERT_EQ(mesh.n_faces(), 3u);
    for (std::size_t f = 0; f < 3; ++f) {
        const auto face = mesh.face(f);
        const Vec3 normal = cross(mesh.vertices[face[1]] - mesh.vertices[face[0]],
                                  mesh.vertices[face[2]] - mesh.vertices[face[0]]);
        EXPECT_GT(normal[2], 0.0) << f;
    }
}

TEST(Ply, ReadsAPointCloud)
{
    const PolygonMesh mesh = read(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n0 0 0\n1 2 3\n",
        "a.ply");
    EXPECT_EQ(mesh.n_vertices(), 2u);
    EXPECT_EQ(mesh.n_faces(), 0u);
}

TEST(Ply, ReadsColorsOfEveryType)
{
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\n";
    const std::string end = "end_header\n0 0 0 ";
    const auto color = [&](const std::string& properties, const std::string& values) {
        return read_mesh_file(as_bytes(header + properties + end + values), "a.ply").vertex_colors;
    };
    const std::vector<Rgba> bytes = {{1, 2, 3, 255}};
    EXPECT_EQ(color("property uchar red\nproperty uchar green\nproperty uchar blue\n", "1 2 3"),
              bytes);
    const std::vector<Rgba> fractions = {{255, 0, 128, 51}};
    EXPECT_EQ(color("property float r\nproperty float g\nproperty float b\nproperty float a\n",
                    "1 0 .5 .2"),
              fractions);
    const std::vector<Rgba> wide = {{255, 0, 128, 255}};
    EXPECT_EQ(color("property ushort diffuse_red\nproperty ushort diffuse_green\n"
                    "property ushort diffuse_blue\n",
                    "65535 0 32896"),
              wide);
    EXPECT_TRUE(color("property uchar red\nproperty uchar green\n", "1 2").empty());
}

}  // namespace
}  // namespace genus

namespace genus {
namespace {

class ObjMaterials : public ::testing::Test {
protected:
    void SetUp() override
    {
        folder_ = std::filesystem::path(::testing::TempDir()) /
                  ("materials" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_ / "inner");
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string put(const std::string& name, const std::string& text) const
    {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return (folder_ / name).string();
    }

    std::filesystem::path folder_;
};

constexpr char kTwoFaces[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red paint\nf 1 2 3 4\nusemtl glass\r\nf 1 2 3\n"
    "usemtl unknown\nf 2 3 4\n";
constexpr char kLibrary[] =
    "# c\nnewmtl red paint\nKa 1 1 1\nKd 1 0 0\nNs 10\nmap_Kd x.png\r\nnewmtl glass\n"
    "Kd 0.2 .4 6e-1\nd 0.5\n\tnewmtl other\nTr 1\nKd spectral x.rfl\nd -halo 0.5\n";

}  // namespace

TEST_F(ObjMaterials, ColourFaces)
{
    put("my colours.mtl", kLibrary);
    const MeshFile file =
        read_mesh_file(put("a.obj", std::string("mtllib my colours.mtl\n") + kTwoFaces));
    const std::vector<Rgba> expected{{255, 0, 0, 255}, {51, 102, 153, 128}, {}};
    EXPECT_EQ(file.face_colors, expected);
    put("inner/b.mtl", kLibrary);
    EXPECT_EQ(read_mesh_file(put("b.obj", std::string("mtllib none.mtl inner/b.mtl\n") + kTwoFaces))
                  .face_colors,
              expected);
    // Not there, outside of the folder, or not known where the file lies: no colours.
    for (const char* library : {"none.mtl", "../my colours.mtl", "/etc/passwd", ""}) {
        const std::string text = std::string("mtllib ") + library + "\n" + kTwoFaces;
        EXPECT_TRUE(read_mesh_file(put("inner/c.obj", text)).face_colors.empty()) << library;
    }
    const std::string text = std::string("mtllib my colours.mtl\n") + kTwoFaces;
    EXPECT_TRUE(read_mesh_file(as_bytes(text), "a.obj").face_colors.empty());
}

TEST_F(ObjMaterials, FaultsNameTheLibraryAndLine)
{
    put("bad.mtl", "newmtl a\nKd 1 0 x\n");
    try {
        read_mesh_file(put("a.obj", std::string("mtllib bad.mtl\n") + kTwoFaces));
        ADD_FAILURE();
    } catch (const FileError& e) {
        EXPECT_EQ(e.place().line, 2);
        EXPECT_NE(e.path().find("bad.mtl"), std::string::npos);
    }
}

TEST_F(ObjMaterials, RoundTripOfFaceColours)
{
    MeshFile file;
    file.mesh = to_polygons(torus_mesh(40, 30));
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f)
        file.face_colors.push_back(
            {static_cast<std::uint8_t>(f / 100), 7, static_cast<std::uint8_t>(f % 3), 200});
    const std::string path = (folder_ / "t.obj").string();
    write_mesh_file(path, file);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "t.mtl"));
    EXPECT_EQ(read_mesh_file(path), file);
    // Bytes alone have no library.
    EXPECT_EQ(read_mesh_file(mesh_bytes(file, MeshFormat::obj), "t.obj").mesh, file.mesh);
    file.face_colors.clear();
    write_mesh_file((folder_ / "plain.obj").string(), file);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "plain.mtl"));
    EXPECT_THROW(write_mesh_file((folder_ / "no" / "x.obj").string(), file), FileError);
}

}  // namespace genus
