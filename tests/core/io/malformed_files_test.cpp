#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/io/read_mesh.h"

namespace genus {
namespace {

struct Mistake {
    std::string file;
    std::string content;
    std::string problem;    // a part of the message
    std::int64_t line = 0;  // 0 where a byte is named
    std::int64_t byte = -1;
};

void expect_error(const Mistake& mistake)
{
    SCOPED_TRACE(mistake.file + ": " + mistake.problem);
    try {
        read_mesh_file(as_bytes(mistake.content), mistake.file);
        ADD_FAILURE() << "no error";
    } catch (const FileError& error) {
        EXPECT_EQ(error.path(), mistake.file);
        EXPECT_NE(error.problem().find(mistake.problem), std::string::npos) << error.what();
        EXPECT_EQ(error.place().line.value_or(0), mistake.line) << error.what();
        EXPECT_EQ(error.place().byte.value_or(-1), mistake.byte) << error.what();
    }
}

std::string binary_stl(std::uint32_t count, std::size_t triangles, std::string_view comment = "")
{
    std::string file(84 + 50 * triangles, '\0');
    comment.copy(file.data(), 80);
    for (int i = 0; i < 4; ++i) file[80 + i] = static_cast<char>(count >> 8 * i & 0xFF);
    return file;
}

std::string with_float(std::string file, std::size_t at, std::uint32_t bits)
{
    for (int i = 0; i < 4; ++i) file[at + i] = static_cast<char>(bits >> 8 * i & 0xFF);
    return file;
}

const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
const std::string kOffPoints = "0 0 0\n1 0 0\n0 1 0\n";
const std::string kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

TEST(MalformedFiles, NoFormat)
{
    expect_error({"a.obj", "", "is empty"});
    expect_error({"a.xyz", "hello", "no mesh format"});
    expect_error({"a", std::string(100, '\0'), "no mesh format"});
}

TEST(MalformedFiles, BinaryStl)
{
    expect_error({"a.stl", "too short", "too short", 0, 9});
    expect_error({"a.stl", std::string(83, 'x'), "too short", 0, 83});
    expect_error({"a.stl", binary_stl(3, 2), "counts 3 triangles", 0, 80});
    expect_error({"a.stl", binary_stl(1, 2), "counts 1 triangles", 0, 80});
    expect_error({"a.stl", binary_stl(0xFFFFFFFF, 2), "counts 4294967295", 0, 80});
    expect_error({"a.stl", binary_stl(5, 2, "solid but binary"), "counts 5", 0, 80});
    expect_error({"a.stl", with_float(binary_stl(2, 2), 84 + 50 + 12 + 16, 0x7FC00000),
                  "not a finite number", 0, 84 + 50 + 12 + 12});
    expect_error({"a.stl", with_float(binary_stl(2, 2), 84 + 12, 0xFF800000), "not a finite number",
                  0, 84 + 12});
}

TEST(MalformedFiles, AsciiStl)
{
    expect_error({"a.stl", "solid a\n" + kFacet, "ends before 'endsolid'", 9});
    expect_error({"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0\nvertex 1",
                  "'vertex' is not a number", 5});
    expect_error({"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n",
                  "'nan' is not a finite number", 4});
    expect_error({"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1e999\n",
                  "'1e999' is not a finite number", 4});
    expect_error({"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0,5\n",
                  "unexpected ',5'", 4});
    expect_error({"a.stl", "solid a\nfacet normal 0 0\nouter loop\n", "expected 'outer'", 3});
    expect_error({"a.stl",
                  "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
                  "a facet with 2 vertices", 6});
    expect_error(
        {"a.stl", "solid a\n" + kFacet + "endsolid a\n" + kFacet, "outside of a solid", 10});
    expect_error({"a.stl", "solid a\n" + kFacet + "solid b\n", "before the last solid", 9});
    expect_error({"a.stl", "solid a\nendsolid a\nendsolid b\n", "without 'solid'", 3});
    expect_error({"a.stl", "solid a\nfacett normal\nendsolid", "expected 'facet'", 2});
}

TEST(MalformedFiles, Obj)
{
    expect_error({"a.obj", kPoints + "f 1 2 4\n", "there is no vertex '4'", 4});
    expect_error({"a.obj", kPoints + "f 1 2 -4\n", "there is no vertex '-4'", 4});
    expect_error({"a.obj", kPoints + "f 0 1 2\n", "count from 1", 4});
    expect_error({"a.obj", kPoints + "f 1 2 1152921504606846976\n", "there is no vertex", 4});
    expect_error({"a.obj", kPoints + "f 1 2 2147483648\n", "there is no vertex", 4});
    expect_error({"a.obj", kPoints + "\n\nf 1 2\n", "needs three corners", 6});
    expect_error({"a.obj", kPoints + "f 1 2 3x\n", "'3x' is not a corner", 4});
    expect_error({"a.obj", kPoints + "f 1 2 3/1/1/1\n", "is not a corner", 4});
    expect_error({"a.obj", kPoints + "f 1 2 /3\n", "'/3' is not a corner", 4});
    expect_error({"a.obj", kPoints + "f 1 2 3.5\n", "is not a corner", 4});
    expect_error({"a.obj", "v 0 0 0\r\nv 1 nan 0\r\n", "'nan' is not a finite number", 2});
    expect_error({"a.obj", "v 0 0 0\nv 1 0\n", "needs three coordinates", 2});
    expect_error({"a.obj", "v 0 0 0 0 0 0 0 0 0\n", "more than 8", 1});
    expect_error({"a.obj", "v 0 0 zero\n", "'zero' is not a number", 1});
    expect_error({"a.obj", "v 0 0 0\nw 1 2 3\n", "'w' is not an OBJ statement", 2});
    expect_error({"a.obj", "v 0 0 0 \\", "'\\' is not a number", 1});
}

// The index is wrong in the second piece of the text, and known to be only after the last.
TEST(MalformedFiles, ObjOfSeveralPieces)
{
    std::string text;
    const int n = 100'000;
    for (int i = 0; i < n; ++i) text += "v " + std::to_string(i) + ".25 -0.123456789 7\n";
    const std::string good = text + "f 1 2 " + std::to_string(n) + "\nf -1 -2 -3\n";
    EXPECT_EQ(read_mesh(as_bytes(good), "a.obj").faces[1], (Triangle{n - 1, n - 2, n - 3}));
    expect_error({"a.obj", good + "f 1 2 " + std::to_string(n + 1) + "\nv 1\n",
                  "needs three coordinates", n + 4});
    expect_error(
        {"a.obj", good + "\nf 1 2 " + std::to_string(n + 1) + "\n", "there is no vertex", n + 4});
    expect_error(
        {"a.obj", good + "f 1 2 -" + std::to_string(n + 1) + "\n", "there is no vertex", n + 3});
}

TEST(MalformedFiles, Off)
{
    expect_error({"a.off", "OFF\n3 1 0\n" + kOffPoints + "3 0 1 3\n", "there is no vertex '3'", 6});
    expect_error(
        {"a.off", "OFF\n3 1 0\n" + kOffPoints + "3 0 1 -1\n", "there is no vertex '-1'", 6});
    expect_error({"a.off", "OFF\n3 1 0\n" + kOffPoints + "2 0 1\n # a comment\n", "2 corners", 6});
    expect_error({"a.off", "OFF\n3 1 0\n" + kOffPoints + "999999999 0 1 2\n", "too short", 6});
    expect_error({"a.off", "OFF\n3 2 0\n" + kOffPoints + "3 0 1 2   \n\n\n\n", "ends before", 10});
    expect_error(
        {"a.off", "OFF\n3 1 0\n" + kOffPoints + "3 0 1 2\n3 0 1 2\n", "after the last", 7});
    expect_error({"a.off", "OFF\n1152921504606846976 1 0\n0 0 0\n", "too large", 2});
    expect_error({"a.off", "OFF\n115292150460684697 1 0\n0 0 0\n", "too short", 2});
    expect_error({"a.off", "OFF\n3 115292150460684697 0\n" + kOffPoints, "too short", 2});
    expect_error({"a.off", "OFF\n-3 1 0\n0 0 0\n", "is negative", 2});
    expect_error({"a.off", "OFF\n3 1 0\n0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n", "not a finite", 4});
    expect_error({"a.off", "OFF\n", "ends before the number of vertices", 2});
    expect_error({"a.off", "4OFF\n1 0 0\n0 0 0 1\n", "three dimensions", 1});
    expect_error({"a.off", "OFF BINARY\n1 0 0\n", "binary OFF", 1});
    expect_error({"a.off", "OOFF\n1 0 0\n", "no OFF header", 1});
    expect_error({"a.off", "COFF\n1 0 0\n0 0 0 7 7\n", "three or four numbers", 3});
    expect_error({"a.off", "hello\n", "is not an integer", 1});
}

std::string ply(const std::string& header, const std::string& body,
                const std::string& format = "ascii")
{
    return "ply\nformat " + format + " 1.0\n" + header + "end_header\n" + body;
}

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kList = "property list uchar int vertex_indices\n";

TEST(MalformedFiles, PlyHeader)
{
    expect_error({"a.ply", "plyx\n", "does not begin", 1});
    expect_error({"a.ply", "ply\nformat ascii 1.0\n", "before 'end_header'", 3});
    expect_error({"a.ply", "ply\nend_header\n", "has no format", 2});
    expect_error({"a.ply", "ply\nformat binary 1.0\nend_header\n", "is not a PLY format", 2});
    expect_error({"a.ply", "ply\nformat ascii 2.0\nend_header\n", "version '2.0'", 2});
    expect_error({"a.ply", ply("property float x\n", ""), "before the first element", 3});
    expect_error({"a.ply", ply("element vertex many\n", ""), "'many' is not", 3});
    expect_error({"a.ply", ply("element vertex -1\n", ""), "'-1' is not", 3});
    expect_error({"a.ply", ply("element vertex\n", ""), "needs a name and a count", 3});
    expect_error({"a.ply", ply("element vertex 0\nproperty real x\n", ""), "'real' is not", 4});
    expect_error({"a.ply", ply("element vertex 0\nelement vertex 0\n", ""), "second element", 4});
    expect_error({"a.ply", ply("element vertex 0\n" + kXyz + kXyz, ""), "second property 'x'", 7});
    expect_error({"a.ply", ply("element face 0\nproperty list float int vertex_indices\n", ""),
                  "not an integer type", 4});
    expect_error({"a.ply", ply("elements vertex 0\n", ""), "not a PLY header statement", 3});
}

TEST(MalformedFiles, PlyRows)
{
    const std::string three = "element vertex 3\n" + kXyz + "element face 1\n" + kList;
    expect_error({"a.ply", ply(three, kOffPoints + "3 0 1 3\n"), "there is no vertex 3", 13});
    expect_error({"a.ply", ply(three, kOffPoints + "3 0 1 -1\n"), "there is no vertex -1", 13});
    expect_error({"a.ply", ply(three, kOffPoints + "2 0 1\n \n"), "2 corners", 13});
    expect_error({"a.ply", ply(three, kOffPoints + "-3 0 1 2\n"), "negative count", 13});
    expect_error({"a.ply", ply(three, kOffPoints + "3 0 1.5 2\n"), "unexpected '.5'", 13});
    expect_error({"a.ply", ply(three, kOffPoints + "3 0 1 2\n5\n"), "left over", 14});
    expect_error({"a.ply", ply(three, "0 0 nan\n" + kOffPoints), "'nan' is not a finite", 10});
    expect_error({"a.ply", ply(three, kOffPoints + "9999 0 1 2\n"), "too short for a list", 13});
    expect_error({"a.ply", ply("element vertex 115292150460684697\n" + kXyz, kOffPoints),
                  "too short for 115292150460684697 rows of the element vertex", 8});
    expect_error({"a.ply",
                  ply("element vertex 3\nproperty float x\nproperty float y\n", "0 0\n0 0\n0 0\n"),
                  "no coordinate z", 7});
    expect_error({"a.ply",
                  ply("element vertex 1\nproperty float x\nproperty float y\n"
                      "property list uchar float z\n",
                      "0 0 1 0\n"),
                  "no coordinate z", 8});
    expect_error(
        {"a.ply", ply("element face 1\nproperty int a\n", "1\n"), "has no vertex_indices", 6});
    expect_error({"a.ply",
                  ply("element face 1\nproperty list uchar float vertex_indices\n", "1 0\n"),
                  "not a list of integers", 6});
    expect_error({"a.ply", ply("element face 1\nproperty int vertex_indices\n", "1 0\n"),
                  "not a list of integers", 6});
}

TEST(MalformedFiles, BinaryPly)
{
    const std::string header = "element vertex 1\n" + kXyz + "element face 1\n" + kList;
    for (const std::string order : {"binary_little_endian", "binary_big_endian"}) {
        const std::string start = ply(header, "", order);
        const auto body = static_cast<std::int64_t>(start.size());
        const std::string vertex(12, '\0');
        const std::string face = std::string(1, '\3').append(vertex);
        EXPECT_EQ(read_mesh(as_bytes(start + vertex + face), "a.ply").n_faces(), 1u);
        expect_error({"a.ply", start, "too short", 0, body});
        expect_error({"a.ply", start + vertex, "too short", 0, body});
        expect_error({"a.ply", start + vertex + "\3", "too short for a list", 0, body + 12});
        expect_error({"a.ply", start + vertex + face + "x", "left over", 0, body + 25});
        expect_error({"a.ply", start + vertex + "\2" + vertex, "2 corners", 0, body + 12});
        const std::string bad_face("\3\0\0\0\0\0\0\0\0\1\1\1\1", 13);
        expect_error(
            {"a.ply", start + vertex + bad_face, "there is no vertex 16843009", 0, body + 21});
        const std::string infinite = order == "binary_big_endian" ? std::string("\x7F\x80\0\0", 4)
                                                                  : std::string("\0\0\x80\x7F", 4);
        expect_error({"a.ply", start + vertex.substr(4) + infinite + face, "not a finite number", 0,
                      body + 8});
    }
}

}  // namespace
}  // namespace genus
