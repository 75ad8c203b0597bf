#include "genus/io/stream.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/io/mend_file.h"
#include "genus/io/read_mesh.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/repair.h"

namespace genus {
namespace {

namespace fs = std::filesystem;

class Streamed : public ::testing::Test {
protected:
    void SetUp() override
    {
        folder_ = fs::path(::testing::TempDir()) / ("stream" + std::to_string(::getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    static std::string content(const std::string& name)
    {
        std::ifstream file(name, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }
    std::size_t n_files() const
    {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }

    fs::path folder_;
};

// More than one block.
IndexedMesh large_torus()
{
    return torus_mesh(300, 115);
}

}  // namespace

TEST_F(Streamed, GivesWhatTheWholeFileGives)
{
    const IndexedMesh torus = large_torus();
    write_mesh(path("a.stl"), torus);
    const IndexedMesh whole = read_mesh(path("a.stl"));
    for (const char* name : {"b.stl", "b.ply", "b.obj", "b.off"}) {
        for (const bool ascii : {false, true}) {
            SCOPED_TRACE(std::string(name) + (ascii ? " text" : ""));
            WriteOptions options;
            options.ascii = ascii;
            ASSERT_TRUE(can_stream(path("a.stl"), *format_of_extension(name)));
            const StreamCounts n = stream_mesh(path("a.stl"), path(name), options);
            EXPECT_EQ(n.faces, static_cast<std::int64_t>(torus.n_faces()));
            const IndexedMesh back = weld(read_mesh(path(name)));
            EXPECT_EQ(back, whole);
        }
    }
    write_mesh(path("c.stl"), whole);
    stream_mesh(path("a.stl"), path("d.stl"));
    EXPECT_EQ(content(path("d.stl")), content(path("c.stl")));  // to the byte
}

TEST_F(Streamed, ScalesAndReplacesTheSourceItself)
{
    write_mesh(path("a.stl"), torus_mesh(12, 9));
    const double before = volume(read_mesh(path("a.stl")));
    stream_mesh(path("a.stl"), path("a.stl"), {}, 2.0);
    EXPECT_NEAR(volume(read_mesh(path("a.stl"))), 8 * before, 1e-5 * before);
    EXPECT_THROW(stream_mesh(path("a.stl"), path("b.stl"), {}, 0.0), InvalidInput);
    EXPECT_THROW(stream_mesh(path("a.stl"), path("b.stl"), {}, 1e39), FileError);
    EXPECT_EQ(n_files(), 1u);
}

TEST_F(Streamed, RefusesWhatItCannot)
{
    write_mesh(path("a.stl"), torus_mesh(12, 9));
    EXPECT_FALSE(can_stream(path("a.stl"), MeshFormat::glb));
    EXPECT_THROW(stream_mesh(path("a.stl"), path("b.glb")), InvalidInput);
    EXPECT_THROW(stream_mesh(path("a.stl"), path("b.xyz")), FileError);
    EXPECT_THROW(stream_mesh(path("none.stl"), path("b.stl")), FileError);
    EXPECT_THROW(stream_mesh(path("a.stl"), path("no/b.stl")), FileError);
    WriteOptions ascii;
    ascii.ascii = true;
    write_mesh(path("t.stl"), torus_mesh(12, 9), ascii);
    EXPECT_FALSE(can_stream(path("t.stl"), MeshFormat::stl));
    // Cut short, and a coordinate that is no number: no file, the place named.
    std::string bytes = content(path("a.stl"));
    std::ofstream(path("cut.stl"), std::ios::binary) << bytes.substr(0, bytes.size() - 7);
    EXPECT_THROW(stream_mesh(path("cut.stl"), path("b.stl")), InvalidInput);
    for (std::size_t i = 0; i < 4; ++i) bytes[84 + 50 * 7 + 12 + 8 + i] = '\xFF';
    std::ofstream(path("nan.stl"), std::ios::binary) << bytes;
    try {
        stream_mesh(path("nan.stl"), path("b.ply"));
        ADD_FAILURE();
    } catch (const FileError& e) {
        EXPECT_EQ(e.place().byte, 84 + 50 * 7 + 12 + 8);
    }
    EXPECT_FALSE(fs::exists(path("b.ply")));
    EXPECT_EQ(n_files(), 4u);
}

TEST(MendFile, WeldsPolygonsAndKeepsColours)
{
    MeshFile file;
    // Two squares side by side, with vertices of their own, and one that falls together.
    file.mesh.vertices = {{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}},
                          {{1, 0, 0}}, {{2, 0, 0}}, {{2, 1, 0}}, {{1.001, 1, 0}},
                          {{5, 5, 5}}, {{5, 5, 5}}, {{6, 5, 5}}, {{9, 9, 9}}};
    file.mesh.add_face(std::vector<std::int32_t>{0, 1, 2, 3});
    file.mesh.add_face(std::vector<std::int32_t>{8, 9, 10});
    file.mesh.add_face(std::vector<std::int32_t>{4, 5, 6, 7});
    for (std::uint8_t v = 0; v < 12; ++v) file.vertex_colors.push_back({v, 0, 0, 255});
    file.face_colors = {{1, 1, 1, 1}, {2, 2, 2, 2}, {3, 3, 3, 3}};
    MeshFile exact = file;
    EXPECT_EQ(weld_file(exact, 0.0), 5);
    EXPECT_EQ(exact.mesh.n_faces(), 2u);
    EXPECT_EQ(exact.mesh.n_vertices(), 7u);
    EXPECT_EQ(weld_file(file, 0.01), 6);
    EXPECT_EQ(file.mesh.n_vertices(), 6u);
    EXPECT_EQ(file.mesh.corners, (std::vector<std::int32_t>{0, 1, 2, 3, 1, 4, 5, 2}));
    EXPECT_EQ(file.face_colors, (std::vector<Rgba>{{1, 1, 1, 1}, {3, 3, 3, 3}}));
    EXPECT_EQ(file.vertex_colors[4], (Rgba{5, 0, 0, 255}));
    EXPECT_EQ(file.vertex_colors[2], (Rgba{2, 0, 0, 255}));
}

TEST(MendFile, RepairKeepsColoursOfWhatStays)
{
    MeshFile file;
    file.mesh = cut_cube();
    const std::size_t n = file.mesh.n_faces();
    for (std::size_t f = 0; f < n; ++f)
        file.face_colors.push_back({static_cast<std::uint8_t>(f), 7, 7, 255});
    file.vertex_colors.assign(file.mesh.n_vertices(), {9, 9, 9, 9});
    // The first face goes: a hole, closed again in white.
    PolygonMesh open;
    open.vertices = file.mesh.vertices;
    for (std::size_t f = 1; f < n; ++f) open.add_face(file.mesh.face(f));
    const double whole = volume(to_triangles(file.mesh));
    file.mesh = open;
    file.face_colors.erase(file.face_colors.begin());
    const RepairReport report = repair_file(file, {});
    EXPECT_EQ(report.closed_holes, 1);
    EXPECT_EQ(report.open_edges, 0);
    EXPECT_NEAR(volume(to_triangles(file.mesh)), whole, 1e-12);
    ASSERT_EQ(file.face_colors.size(), file.mesh.n_faces());
    EXPECT_EQ(file.face_colors.front(), (Rgba{1, 7, 7, 255}));
    EXPECT_EQ(file.face_colors.back(), Rgba{});
    EXPECT_EQ(file.vertex_colors.size(), file.mesh.n_vertices());
}

TEST(MendFile, KnowsUnits)
{
    EXPECT_EQ(unit_millimetres("in"), 25.4);
    EXPECT_EQ(unit_millimetres("meter"), 1000);
    EXPECT_THROW(unit_millimetres("parsec"), InvalidInput);
    MeshFile file;
    file.mesh = cut_cube();
    const double before = bounds(file.mesh).diagonal();
    scale_file(file, 25.4);
    EXPECT_NEAR(bounds(file.mesh).diagonal(), 25.4 * before, 1e-12 * before);
}

}  // namespace genus
