#include "genus/io/output_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "core/io/sample_meshes.h"
#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {
namespace {

namespace fs = std::filesystem;

// A folder of its own for each test, removed at its end.
class WriteMesh : public testing::Test {
protected:
    void SetUp() override
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() /
                  (std::string("genus-") + test->name() + "-" + std::to_string(::getpid()));
        fs::create_directory(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    std::ptrdiff_t n_files() const
    {
        return std::distance(fs::directory_iterator(folder_), fs::directory_iterator());
    }

    fs::path folder_;
};

std::string content_of(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
}

std::string message_of(const std::string& path, const IndexedMesh& mesh)
{
    try {
        write_mesh(path, mesh);
    } catch (const FileError& error) {
        EXPECT_EQ(error.path(), path);
        return error.problem();
    }
    return "written";
}

TEST_F(WriteMesh, WritesTheBytesOfMeshBytes)
{
    const IndexedMesh mesh = torus_mesh(20, 30);
    for (const MeshFormat format :
         {MeshFormat::stl, MeshFormat::obj, MeshFormat::off, MeshFormat::ply}) {
        const std::string file = path(std::string("a.") + format_name(format));
        write_mesh(file, mesh);
        const std::string content = content_of(file);
        const auto bytes = mesh_bytes(mesh, format);
        EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), as_bytes(content).begin(),
                               as_bytes(content).end()));
        EXPECT_EQ(read_mesh(file), read_mesh(bytes, file));
    }
    EXPECT_EQ(n_files(), 4);
}

TEST_F(WriteMesh, ReplacesAFileAndKeepsItsPermissions)
{
    const std::string file = path("a.obj");
    std::ofstream(file) << "old";
    fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
    write_mesh(file, torus_mesh(4, 4));
    EXPECT_EQ(read_mesh(file), torus_mesh(4, 4));
    EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_EQ(n_files(), 1);
}

TEST_F(WriteMesh, FollowsASymbolicLink)
{
    fs::create_directory(path("sub"));
    std::ofstream(path("sub/real.obj")) << "old";
    fs::create_symlink("sub/real.obj", path("link.obj"));
    write_mesh(path("link.obj"), torus_mesh(4, 4));
    EXPECT_TRUE(fs::is_symlink(path("link.obj")));
    EXPECT_EQ(read_mesh(path("sub/real.obj")), torus_mesh(4, 4));
}

TEST_F(WriteMesh, NamesWhatIsWrongWithThePath)
{
    const IndexedMesh mesh = torus_mesh(4, 4);
    EXPECT_NE(message_of(path("missing/a.stl"), mesh).find("does not exist"), std::string::npos);
    EXPECT_NE(message_of(path("a.xyz"), mesh).find("no mesh format"), std::string::npos);
    EXPECT_NE(message_of(path("a"), mesh).find("no mesh format"), std::string::npos);
    fs::create_directory(path("folder.stl"));
    EXPECT_NE(message_of(path("folder.stl"), mesh).find("is a folder"), std::string::npos);
    EXPECT_NE(message_of(path("folder.stl/x/a.stl"), mesh), "written");
    EXPECT_NE(message_of("/proc/genus.stl", mesh), "written");
    EXPECT_NE(message_of(std::string("a\0.stl", 6), mesh), "written");
    EXPECT_NE(message_of(path(std::string(300, 'n') + ".stl"), mesh), "written");
    EXPECT_EQ(n_files(), 1);
}

TEST_F(WriteMesh, RefusesAMeshThatIsNoMesh)
{
    IndexedMesh mesh = torus_mesh(4, 4);
    mesh.faces[3][1] = 16;
    EXPECT_THROW(write_mesh(path("a.stl"), mesh), InvalidInput);
    mesh.faces[3][1] = -1;
    EXPECT_THROW(write_mesh(path("a.obj"), mesh), InvalidInput);
    mesh = torus_mesh(4, 4);
    mesh.vertices[5][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(write_mesh(path("a.ply"), mesh), InvalidInput);
    PolygonMesh polygons = to_polygons(torus_mesh(4, 4));
    polygons.add_face(std::vector<std::int32_t>{0, 1});
    EXPECT_THROW(write_mesh(path("a.off"), polygons), InvalidInput);
    MeshFile file{cut_cube(), {Rgba{}}, {}};
    EXPECT_THROW(write_mesh_file(path("a.off"), file), InvalidInput);
    EXPECT_EQ(n_files(), 0);
}

TEST_F(WriteMesh, RefusesACoordinateTooLargeForBinaryStl)
{
    IndexedMesh mesh = torus_mesh(4, 4);
    mesh.vertices[5][1] = 1e39;
    EXPECT_NE(message_of(path("a.stl"), mesh).find("too large"), std::string::npos);
    WriteOptions ascii;
    ascii.ascii = true;
    write_mesh(path("b.stl"), mesh, ascii);
    EXPECT_EQ(n_files(), 1);
}

// A device is written to, not replaced; this one is always full.
TEST_F(WriteMesh, ReportsAFullDevice)
{
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "this system has no device that is always full";
    WriteOptions options;
    options.format = MeshFormat::stl;
    try {
        write_mesh("/dev/full", torus_mesh(10, 10), options);
        FAIL() << "written";
    } catch (const FileError& error) {
        EXPECT_NE(error.problem().find("No space left"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// Files limited to 64 KB stand for a disk that becomes full half way.
TEST_F(WriteMesh, LeavesNothingOnAFullDisk)
{
    std::ofstream(path("a.obj")) << "old";
    struct ::rlimit old_limit = {};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old_limit), 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    const struct ::rlimit limit = {65536, old_limit.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    const std::string stl = message_of(path("a.stl"), torus_mesh(100, 100));
    const std::string obj = message_of(path("a.obj"), torus_mesh(100, 100));
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old_limit), 0);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_NE(stl.find("cannot be written"), std::string::npos) << stl;
    EXPECT_NE(obj.find("cannot be written"), std::string::npos) << obj;
    EXPECT_EQ(content_of(path("a.obj")), "old");
    EXPECT_EQ(n_files(), 1);
}

TEST_F(WriteMesh, LeavesNothingWhenCancelled)
{
    const IndexedMesh mesh = torus_mesh(500, 500);
    write_mesh(path("in.obj"), mesh);
    Progress progress;
    progress.cancel();
    const ProgressScope scope(progress);
    for (const char* name : {"a.stl", "a.obj", "a.off", "a.ply"})
        EXPECT_THROW(write_mesh(path(name), mesh), Cancelled);
    EXPECT_THROW(read_mesh(path("in.obj")), Cancelled);
    EXPECT_EQ(n_files(), 1);
}

TEST_F(WriteMesh, WritesToManyFilesAtOnce)
{
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
        threads.emplace_back([&, i] {
            for (int k = 0; k < 20; ++k) write_mesh(path("same.obj"), torus_mesh(5 + i, 5));
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(read_mesh(path("same.obj")).n_vertices() % 5, 0u);
    EXPECT_EQ(n_files(), 1);
}

// ---- reading ----

TEST_F(WriteMesh, ReadNamesWhatIsWrongWithThePath)
{
    EXPECT_THROW(read_mesh(path("missing.stl")), FileError);
    EXPECT_THROW(read_mesh(folder_.string()), FileError);
    EXPECT_THROW(read_mesh(""), FileError);
    EXPECT_THROW(read_mesh("/dev/zero"), FileError);
    std::ofstream(path("empty.stl")).close();
    EXPECT_THROW(read_mesh(path("empty.stl")), FileError);
}

TEST_F(WriteMesh, ReadsFromAPipe)
{
    const IndexedMesh mesh = torus_mesh(300, 300);
    const std::string pipe = path("pipe.obj");
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::thread writer([&] { write_mesh(pipe, mesh); });
    EXPECT_EQ(read_mesh(pipe), mesh);
    writer.join();
    EXPECT_TRUE(fs::is_fifo(pipe));
}

}  // namespace
}  // namespace genus
