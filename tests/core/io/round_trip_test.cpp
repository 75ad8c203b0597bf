#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/io/read_mesh.h"
#include "genus/io/write_mesh.h"

namespace genus {
namespace {

struct Form {
    MeshFormat format;
    bool ascii;
    bool keeps_shared_vertices() const { return format != MeshFormat::stl; }
    bool is_gltf() const { return format == MeshFormat::glb || format == MeshFormat::gltf; }
    bool keeps_doubles() const { return !is_gltf() && (format != MeshFormat::stl || ascii); }
    bool is_xml() const { return format == MeshFormat::three_mf || format == MeshFormat::amf; }
    bool keeps_polygons() const { return !is_gltf() && !is_xml() && format != MeshFormat::stl; }
    std::string name() const { return std::string("<mesh>.") + format_name(format); }
};

constexpr Form kForms[] = {
    {MeshFormat::stl, false},      {MeshFormat::stl, true},   {MeshFormat::obj, false},
    {MeshFormat::off, false},      {MeshFormat::ply, false},  {MeshFormat::ply, true},
    {MeshFormat::glb, false},      {MeshFormat::gltf, false},
#ifdef GENUS_XML_FORMATS
    {MeshFormat::three_mf, false}, {MeshFormat::amf, false},
#endif
};

class RoundTrip : public testing::TestWithParam<Form> {};

std::string form_name(const testing::TestParamInfo<Form>& tested)
{
    return std::string("as_") + format_name(tested.param.format) +
           (tested.param.ascii ? "_ascii" : "");
}

INSTANTIATE_TEST_SUITE_P(Forms, RoundTrip, testing::ValuesIn(kForms), form_name);

IndexedMesh expected_mesh(IndexedMesh mesh, Form form)
{
    if (!form.keeps_doubles()) mesh = rounded_to_floats(mesh);
    return form.keeps_shared_vertices() ? mesh : in_order_of_use(mesh);
}

// 90,000 vertices: several pieces for as many threads, in every format.
TEST_P(RoundTrip, GivesBackALargeMesh)
{
    const IndexedMesh mesh = torus_mesh(300, 300);
    const auto bytes = mesh_bytes(mesh, GetParam().format, GetParam().ascii);
    EXPECT_TRUE(read_mesh(bytes, GetParam().name()) == expected_mesh(mesh, GetParam()));
}

TEST_P(RoundTrip, GivesTheSameOnAnyNumberOfThreads)
{
    const IndexedMesh mesh = torus_mesh(150, 200);
    const int threads = thread_count();
    set_thread_count(1);
    const auto bytes = mesh_bytes(mesh, GetParam().format, GetParam().ascii);
    const IndexedMesh alone = read_mesh(bytes, GetParam().name());
    set_thread_count(5);
    EXPECT_TRUE(mesh_bytes(mesh, GetParam().format, GetParam().ascii) == bytes);
    EXPECT_TRUE(read_mesh(bytes, GetParam().name()) == alone);
    set_thread_count(threads);
}

TEST_P(RoundTrip, GivesBackAnEmptyMesh)
{
    const auto bytes = mesh_bytes(IndexedMesh{}, GetParam().format, GetParam().ascii);
    EXPECT_EQ(read_mesh(bytes, GetParam().name()), IndexedMesh{});
}

TEST_P(RoundTrip, NeedsNoExtension)
{
    const IndexedMesh mesh = torus_mesh(5, 7);
    const auto bytes = mesh_bytes(mesh, GetParam().format, GetParam().ascii);
    EXPECT_EQ(read_mesh(bytes, "<no extension>"), expected_mesh(mesh, GetParam()));
    // Where the content is plain it is believed, not the extension; OBJ has nothing plain.
    if (GetParam().format != MeshFormat::obj) {
        EXPECT_EQ(read_mesh(bytes, "wrong.obj"), expected_mesh(mesh, GetParam()));
        EXPECT_EQ(read_mesh(bytes, "wrong.ply"), expected_mesh(mesh, GetParam()));
    }
}

TEST_P(RoundTrip, KeepsPolygonsWhereTheFormatHasThem)
{
    const PolygonMesh mesh = cut_cube();
    const auto bytes = mesh_bytes(MeshFile{mesh, {}, {}}, GetParam().format, GetParam().ascii);
    const PolygonMesh back = read_polygons(bytes, GetParam().name());
    if (GetParam().keeps_polygons()) {
        EXPECT_EQ(back, mesh);
    } else {
        EXPECT_EQ(back.n_vertices(), 10u);
        EXPECT_EQ(back.n_faces(), 3 * 2 + 3 * 3 + 1u);
    }
}

TEST_P(RoundTrip, KeepsPositionsOfEveryMagnitude)
{
    IndexedMesh mesh;
    for (const double x : {5e-324, 1e-310, -1.0 / 3.0, 1e-30, 0.1, 1e15 / 7.0, 1e30, 3e38})
        mesh.vertices.push_back({{x, -x, 0.5 * x}});
    for (std::int32_t i = 0; i + 2 < 8; ++i) mesh.faces.push_back({i, i + 1, i + 2});
    const auto bytes = mesh_bytes(mesh, GetParam().format, GetParam().ascii);
    if (GetParam().keeps_doubles()) {
        EXPECT_EQ(read_mesh(bytes, GetParam().name()), mesh);
    } else {
        // The two smallest are no longer apart from zero.
        EXPECT_EQ(read_mesh(bytes, GetParam().name()).n_vertices(), 7u);
    }
}

std::vector<Rgba> triangle_colors(const MeshFile& file)
{
    std::vector<Rgba> colors;
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f)
        colors.insert(colors.end(), file.mesh.face(f).size() - 2, file.face_colors[f]);
    return colors;
}

TEST_P(RoundTrip, KeepsColorsWhereTheFormatHasThem)
{
    MeshFile file;
    file.mesh = cut_cube();
    for (std::size_t v = 0; v < file.mesh.n_vertices(); ++v)
        file.vertex_colors.push_back({static_cast<std::uint8_t>(25 * v), 7,
                                      static_cast<std::uint8_t>(255 - v),
                                      static_cast<std::uint8_t>(200 + v)});
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f)
        file.face_colors.push_back({0, static_cast<std::uint8_t>(40 * f), 255, 128});
    const auto bytes = mesh_bytes(file, GetParam().format, GetParam().ascii);
    const MeshFile back = read_mesh_file(bytes, GetParam().name());
    if (GetParam().format == MeshFormat::stl) return;
    if (GetParam().format == MeshFormat::obj) {
        for (Rgba& color : file.vertex_colors) color.a = 255;
        file.face_colors.clear();
    }
    if (GetParam().format == MeshFormat::three_mf) file.vertex_colors.clear();
    if (GetParam().is_gltf() || GetParam().is_xml()) {
        file.unit = GetParam().is_gltf() ? 1000.0 : 1.0;
        file.face_colors = triangle_colors(file);
        file.mesh = to_polygons(to_triangles(file.mesh));
    }
    EXPECT_EQ(back, file);
}

TEST(RoundTrip, KeepsAFaceOfThousandCorners)
{
    PolygonMesh mesh;
    std::vector<std::int32_t> face;
    for (int i = 0; i < 1000; ++i) {
        mesh.vertices.push_back({{std::cos(i * 0.006), std::sin(i * 0.006), 0.0}});
        face.push_back(i);
    }
    mesh.add_face(face);
    for (const Form form : kForms) {
        if (!form.keeps_polygons()) continue;
        const auto bytes = mesh_bytes(MeshFile{mesh, {}, {}}, form.format, form.ascii);
        EXPECT_EQ(read_polygons(bytes, form.name()), mesh);
    }
}

TEST(Weld, JoinsCornersAtExactlyOnePlaceOnly)
{
    const double next = std::nextafter(1.0, 2.0);
    const std::string text =
        "solid s\n"
        "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n"
        "facet normal 0 0 0 outer loop vertex -0 -0.0 0 vertex 0 1 0 vertex " +
        to_text(next) + " 0 0 endloop endfacet\nendsolid\n";
    const IndexedMesh mesh = read_mesh(as_bytes(text), "a.stl");
    ASSERT_EQ(mesh.n_vertices(), 4u);
    EXPECT_EQ(mesh.faces[0], (Triangle{0, 1, 2}));
    EXPECT_EQ(mesh.faces[1], (Triangle{0, 2, 3}));
    EXPECT_FALSE(std::signbit(mesh.vertices[0][0]));
}

// No two corners alike: the table has to grow far beyond what was expected.
TEST(Weld, KeepsSeparateTrianglesApart)
{
    IndexedMesh mesh;
    for (std::int32_t i = 0; i < 30'000; ++i) {
        mesh.vertices.push_back({{std::sqrt(i), 1.0 / (i + 1), 0.25 * i}});
        if (i % 3 == 2) mesh.faces.push_back({i - 2, i - 1, i});
    }
    EXPECT_TRUE(read_mesh(mesh_bytes(mesh, MeshFormat::stl, true), "a.stl") == mesh);
}

}  // namespace
}  // namespace genus
