#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/io/base64.h"
#include "genus/io/json.h"
#include "genus/io/read_mesh.h"
#include "genus/io/text.h"

namespace genus {
namespace {

using io::JsonText;
using io::TextFault;

// ---- JSON ----

TEST(Json, FindsMembersAndElements)
{
    const JsonText json(
        R"( {"a": [1, -2.5e1, {"b": "x\"\u00e4\uD83D\uDE00\n"}, [], {}], "c": true} )");
    const auto elements = json.root()["a"].elements();
    ASSERT_EQ(elements.size(), 5u);
    EXPECT_EQ(elements[0].index(), 1u);
    EXPECT_EQ(elements[1].number(), -25.0);
    EXPECT_EQ(elements[2]["b"].string(), "x\"\xC3\xA4\xF0\x9F\x98\x80\n");
    EXPECT_TRUE(elements[3].elements().empty());
    EXPECT_TRUE(json.root()["c"].boolean());
    EXPECT_FALSE(json.root()["d"]);
    EXPECT_FALSE(json.root()["d"]["e"]["f"]);
    EXPECT_THROW(elements[1].index(), TextFault);
    EXPECT_THROW(elements[2].number(), TextFault);
    EXPECT_THROW(elements[0].string(), TextFault);
}

TEST(Json, RefusesWhatIsNot)
{
    for (const std::string text :
         {"",       "{",   "[",   "[1,]", "{\"a\":}", "{\"a\" 1}", "{a:1}",   "[1 2]",
          "01",     "1.",  "-",   "1e",   "tru",      "\"",        "\"\\x\"", "\"\\u12\"",
          "\"\t\"", "[]]", "nan", "+1",   ".5",       "{\"a\":1,}"})
        EXPECT_THROW(JsonText{text}, TextFault) << text;
    EXPECT_THROW(JsonText{std::string(100'000, '[')}, TextFault);
    const std::string deep = std::string(50, '[') + std::string(50, ']');
    EXPECT_NO_THROW(JsonText{deep});
}

TEST(Base64, GivesBackWhatWentIn)
{
    for (std::size_t n = 0; n < 40; ++n) {
        std::string text;
        for (std::size_t i = 0; i < n; ++i) text.push_back(static_cast<char>(37 * i * i + n));
        const auto decoded = io::base64_decoded(io::base64_encoded(text));
        ASSERT_TRUE(decoded);
        EXPECT_TRUE(std::equal(decoded->begin(), decoded->end(), as_bytes(text).begin(),
                               as_bytes(text).end()));
    }
    EXPECT_EQ(io::base64_encoded(std::string_view("any carnal pleas")), "YW55IGNhcm5hbCBwbGVhcw==");
    EXPECT_FALSE(io::base64_decoded("A"));
    EXPECT_FALSE(io::base64_decoded("AA=A"));
    EXPECT_EQ(io::percent_decoded("a%20b%2Fc%zz%"), "a b/c%zz%");
}

// ---- glTF ----

std::string floats(std::initializer_list<float> values)
{
    std::string bytes;
    for (const float value : values) {
        char four[4];
        std::memcpy(four, &value, 4);
        bytes.append(four, 4);
    }
    return bytes;
}

const std::string kSquare = floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});

// A glTF file with these bytes as its data, four positions at their begin, and the given members.
std::string gltf(const std::string& members, const std::string& data = kSquare,
                 const std::string& accessors = "")
{
    return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" + std::to_string(data.size()) +
           R"(,"uri":"data:application/octet-stream;base64,)" + io::base64_encoded(data) +
           R"("}],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(data.size()) +
           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"})" +
           accessors + "]," + members + "}";
}

std::string one_primitive(const std::string& members)
{
    return R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0})" +
           members + "}]}]";
}

IndexedMesh read(const std::string& text)
{
    return read_mesh(as_bytes(text), "a.gltf");
}

void expect_error(const std::string& text, const std::string& problem)
{
    SCOPED_TRACE(problem);
    try {
        read(text);
        ADD_FAILURE() << "no error";
    } catch (const FileError& error) {
        EXPECT_NE(error.problem().find(problem), std::string::npos) << error.what();
        EXPECT_EQ(error.place().line, 1);
    }
}

TEST(Gltf, ReadsStripsAndFans)
{
    const std::vector<Triangle> strip = {{0, 1, 2}, {1, 3, 2}};
    EXPECT_EQ(read(gltf(one_primitive(R"(,"mode":5)"))).faces, strip);
    const std::vector<Triangle> fan = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_EQ(read(gltf(one_primitive(R"(,"mode":6)"))).faces, fan);
    EXPECT_TRUE(read(gltf(one_primitive(R"(,"mode":0)"))).faces.empty());
}

TEST(Gltf, ReadsIndicesOfEveryType)
{
    const std::vector<Triangle> faces = {{3, 2, 1}};
    for (const auto& [type, bytes] : {std::pair<int, std::string>{5121, std::string("\3\2\1", 3)},
                                      {5123, std::string("\3\0\2\0\1\0", 6)},
                                      {5125, std::string("\3\0\0\0\2\0\0\0\1\0\0\0", 12)}}) {
        const std::string accessor = R"(,{"bufferView":0,"byteOffset":48,"componentType":)" +
                                     std::to_string(type) + R"(,"count":3,"type":"SCALAR"})";
        EXPECT_EQ(read(gltf(one_primitive(R"(,"indices":1)"), kSquare + bytes, accessor)).faces,
                  faces)
            << type;
    }
}

TEST(Gltf, ReadsSparseAccessors)
{
    // Point 3 is moved; the same on zeros, of which three points remain.
    const std::string data = kSquare + std::string("\3\0\0\0", 4) + floats({5, 6, 7});
    const std::string members =
        R"("componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,"indices":{)"
        R"("bufferView":0,"byteOffset":48,"componentType":5121},"values":{"bufferView":0,)"
        R"("byteOffset":52}}})";
    const std::string strip =
        R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)"
        R"({"attributes":{"POSITION":1},"mode":5}]}])";
    const IndexedMesh moved = read(gltf(strip, data, R"(,{"bufferView":0,)" + members));
    ASSERT_EQ(moved.n_vertices(), 4u);
    EXPECT_EQ(moved.vertices[2], (Vec3{{0, 1, 0}}));
    EXPECT_EQ(moved.vertices[3], (Vec3{{5, 6, 7}}));
    const IndexedMesh on_zeros = read(gltf(strip, data, ",{" + members));
    ASSERT_EQ(on_zeros.n_vertices(), 2u);
    EXPECT_EQ(on_zeros.vertices[1], (Vec3{{5, 6, 7}}));
}

TEST(Gltf, ReadsQuantizedPositionsOneBehindTheOther)
{
    // Three vectors of three, each padded to a multiple of four bytes.
    struct Case {
        int type, stride;
        bool normalized;
        std::string bytes;
        Vec3 second;
    };
    const std::string none(8, '\0');
    for (const Case& c :
         {Case{5120, 4, false, std::string("\0\0\0\0\x80\x7f\1\0\1\0\0\0", 12), {{-128, 127, 1}}},
          Case{5120, 4, true, std::string("\0\0\0\0\x80\x7f\0\0\1\0\0\0", 12), {{-1, 1, 0}}},
          Case{5121, 4, true, std::string("\0\0\0\0\xff\0\x33\0\1\0\0\0", 12), {{1, 0, 0.2}}},
          Case{5122,
               8,
               true,
               none + std::string("\1\x80\xff\x7f\0\0\0\0\1\0\0\0\0\0\0\0", 16),
               {{-1, 1, 0}}},
          Case{5123,
               8,
               false,
               none + std::string("\0\1\2\0\xff\xff\0\0\1\0\0\0\0\0\0\0", 16),
               {{256, 2, 65535}}}}) {
        SCOPED_TRACE(c.type);
        const std::string text =
            R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],)"
            R"("buffers":[{"byteLength":)" +
            std::to_string(c.bytes.size()) + R"(,"uri":"data:;base64,)" +
            io::base64_encoded(c.bytes) + R"("}],"bufferViews":[{"buffer":0,"byteLength":)" +
            std::to_string(c.bytes.size()) + R"(,"byteStride":)" + std::to_string(c.stride) +
            R"(}],"accessors":[{"bufferView":0,"componentType":)" + std::to_string(c.type) +
            R"(,"normalized":)" + (c.normalized ? "true" : "false") +
            R"(,"count":3,"type":"VEC3"}],)" + one_primitive("") + "}";
        const IndexedMesh mesh = read(text);
        ASSERT_EQ(mesh.n_vertices(), 3u);
        EXPECT_EQ(mesh.vertices[1], c.second);
    }
}

TEST(Gltf, PlacesNodesByTheirMaps)
{
    // A quarter turn about z, then to twice the size, moved by (5, 0, 0), all of it mirrored.
    const IndexedMesh mesh = read(
        gltf(R"("scenes":[{"nodes":[1]}],"nodes":[{"mesh":0,"translation":[5,0,0],"scale":[2,2,2],)"
             R"("rotation":[0,0,0.7071067811865476,0.7071067811865476]},)"
             R"({"children":[0],"matrix":[1,0,0,0, 0,1,0,0, 0,0,-1,0, 0,0,7,1]}],)"
             R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5}]}])"));
    ASSERT_EQ(mesh.n_vertices(), 4u);
    const Vec3 expected[] = {{{5, 0, 7}}, {{5, 2, 7}}, {{3, 0, 7}}, {{3, 2, 7}}};
    for (std::size_t v = 0; v < 4; ++v)
        EXPECT_LT(distance(mesh.vertices[v], expected[v]), 1e-14) << v;
    EXPECT_EQ(mesh.faces[0], (Triangle{0, 2, 1}));
}

TEST(Gltf, WeldsWhereColorsAllow)
{
    // Two triangles with separate corners, two of which lie at the same places.
    const std::string data =
        floats({0, 0, 0, 1, 0, 0, 0, 1, 0}) + floats({1, 0, 0, 1, 1, 0, 0, 1, 0});
    const std::string colors = floats({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0});
    const std::string other = floats({1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 0});
    const auto file = [&](const std::string& bytes) {
        return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":144,"uri":"data:x;base64,)" +
               io::base64_encoded(bytes) +
               R"("}],"bufferViews":[{"buffer":0,"byteLength":144}],"accessors":[)"
               R"({"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"},)"
               R"({"bufferView":0,"byteOffset":72,"componentType":5126,"count":6,"type":"VEC3"}],)"
               R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)"
               R"({"attributes":{"POSITION":0,"COLOR_0":1}}]}]})";
    };
    EXPECT_EQ(read(file(data + colors)).n_vertices(), 4u);
    const std::string text = file(data + other);
    const MeshFile separate = read_mesh_file(as_bytes(text), "a.gltf");
    EXPECT_EQ(separate.mesh.n_vertices(), 6u);
    EXPECT_EQ(separate.vertex_colors[3], (Rgba{0, 0, 255, 255}));
}

TEST(Gltf, ReadsDataBesideTheFileAndNowhereElse)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / "genus-gltf-test";
    fs::create_directories(folder / "sub");
    std::ofstream(folder / "sub/my data.bin", std::ios::binary) << kSquare;
    const auto with_uri = [&](const std::string& uri) {
        return R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":48,"uri":")" + uri +
               R"("}],"bufferViews":[{"buffer":0,"byteLength":48}],"accessors":[)"
               R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}],)" +
               one_primitive(R"(,"mode":5)") + "}";
    };
    const std::string path = (folder / "a.gltf").string();
    std::ofstream(path) << with_uri("sub/my%20data.bin");
    EXPECT_EQ(read_mesh(path).n_faces(), 2u);
    const std::string text = with_uri("sub/my%20data.bin");
    EXPECT_THROW(read_mesh(as_bytes(text), path), FileError);
    for (const std::string uri :
         {"../genus-gltf-test/sub/my%20data.bin", "/etc/passwd", "sub/../../x",
          "file:///etc/passwd", "missing.bin", "sub", "%2e%2e/x", ""}) {
        std::ofstream(path) << with_uri(uri);
        EXPECT_THROW(read_mesh(path), FileError) << uri;
    }
    fs::remove_all(folder);
}

TEST(Gltf, RefusesCyclesAndSharedNodes)
{
    const std::string mesh = R"("meshes":[],)";
    expect_error(gltf(mesh + R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[0]}])"),
                 "comes twice");
    expect_error(
        gltf(mesh + R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}])"),
        "comes twice");
    expect_error(gltf(mesh + R"("scenes":[{"nodes":[0,1]}],"nodes":[{"children":[1]},{}])"),
                 "comes twice");
    expect_error(gltf(mesh + R"("scenes":[{"nodes":[1]}],"nodes":[{}])"), "there is no node 1");
}

TEST(Gltf, BoundsWhatASmallFileCanAskFor)
{
    // 100,000 nodes that place the same 9999 points.
    std::string nodes = "{\"mesh\":0}";
    std::string roots = "0";
    for (int i = 1; i < 100'000; ++i) {
        nodes += ",{\"mesh\":0}";
        roots += ',';
        roots += std::to_string(i);
    }
    const std::string members = R"("scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" + nodes +
                                R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":1}}]}])";
    const std::string data(120'000, '\0');
    const std::string many = R"(,{"bufferView":0,"componentType":5126,"count":9999,"type":"VEC3"})";
    expect_error(gltf(members, data, many), "too often");
}

TEST(Gltf, NamesMistakes)
{
    expect_error("{}  {\"asset\"", "unexpected");
    expect_error(R"({"asset":{"version":"1.0"}})", "version 1.0");
    expect_error(R"({"asset":{}})", "asset.version is missing");
    expect_error(
        R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_draco_mesh_compression"]})",
        "KHR_draco_mesh_compression");
    const auto accessor = [&](const std::string& members) {
        return gltf(one_primitive(R"(,"indices":1)"), kSquare, ",{" + members + "}");
    };
    const std::string usual = R"("bufferView":0,"componentType":5125,"type":"SCALAR","count":)";
    expect_error(accessor(usual + R"(3,"byteOffset":12)"),
                 "there is no vertex");  // bits of a float
    expect_error(accessor(usual + "13"), "beyond its data");
    expect_error(accessor(usual + "1152921504606846976"), "whole number");
    expect_error(accessor(usual + "4503599627370496"), "beyond its data");
    expect_error(accessor(usual + R"(3,"byteOffset":9007199254740992)"), "beyond its data");
    expect_error(accessor(usual + "-3"), "whole number");
    expect_error(accessor(usual + R"(1,"sparse":{})"), "'indices' is missing");
    const auto sparse = [&](const std::string& members, const std::string& count) {
        return accessor(R"("componentType":5125,"type":"SCALAR","count":)" + count +
                        R"(,"sparse":{"values":{"bufferView":0},"indices":{"bufferView":0,)" +
                        members + "}");
    };
    expect_error(sparse(R"("componentType":5125},"count":2)", "3"), "ascend");
    expect_error(sparse(R"("componentType":5121},"count":13)", "3"), "beyond its data");
    expect_error(sparse(R"("componentType":5126},"count":1)", "3"), "whole numbers");
    expect_error(sparse(R"("componentType":5125},"count":1)", "3000000"), "longer than the file");
    expect_error(accessor(usual + "1"), "no multiple of three");
    expect_error(accessor(R"("bufferView":0,"componentType":5126,"type":"SCALAR","count":3)"),
                 "single whole numbers");
    expect_error(accessor(R"("bufferView":7,"componentType":5125,"type":"SCALAR","count":3)"),
                 "there is no bufferView 7");
    expect_error(accessor(R"("componentType":5125,"type":"SCALAR","count":3)"),
                 "'bufferView' is missing");
    expect_error(accessor(R"("bufferView":0,"componentType":7,"type":"SCALAR","count":3)"),
                 "componentType");
    expect_error(gltf(one_primitive(""), floats({NAN, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0})),
                 "not a finite number");
    expect_error(gltf(one_primitive(R"(,"material":0)")), "there is no material 0");
    expect_error(gltf(one_primitive(R"(,"mode":9)")), "no such kind");
}

TEST(Gltf, ScalesKnownUnitsToMetres)
{
    MeshFile file;
    file.mesh = cut_cube();
    file.unit = 25.4;
    const auto bytes = mesh_bytes(file, MeshFormat::glb);
    const MeshFile back = read_mesh_file(bytes, "a.glb");
    EXPECT_EQ(back.unit, 1000.0);
    EXPECT_NEAR(back.mesh.vertices[0][0], -0.0254, 1e-9);
}

TEST(Gltf, NamesTheByteInABinaryFile)
{
    auto bytes = mesh_bytes(torus_mesh(4, 5), MeshFormat::glb);
    const auto place = [&](std::size_t at, char value) {
        auto spoiled = bytes;
        spoiled[at] = static_cast<std::byte>(value);
        try {
            read_mesh(spoiled, "a.glb");
        } catch (const FileError& error) {
            return error.place().byte.value_or(-1);
        }
        return std::int64_t{-2};
    };
    EXPECT_EQ(place(4, 3), 4);      // version
    EXPECT_EQ(place(8, 1), 8);      // length
    EXPECT_EQ(place(15, 1), 12);    // length of the first chunk
    EXPECT_EQ(place(16, 'X'), 12);  // its kind
    EXPECT_EQ(place(20, 'X'), 20);  // the JSON text
}

}  // namespace
}  // namespace genus
