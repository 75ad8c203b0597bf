// OpenMesh and CGAL at the work of tests/bench/mesh.py, which compiles this where their headers
// are. Comparisons only: nothing of the core links it.
//
//     mesh_peers mesh FILE              halfedges, one-ring sums, bytes a vertex
//     mesh_peers polygon FILE           constrained Delaunay triangulation of one ring
//     mesh_peers write FILE OUT ASCII   a mesh file, by extension
//     mesh_peers read IN                reading one
//
// Prints lines "peer what number": CPU seconds (best of three), bytes, triangles. FILE holds two
// 64-bit counts, then so many points (three doubles, of a polygon two), then so many triangles.

#include <malloc.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <new>
#include <string>
#include <vector>

#if __has_include(<OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>)
#define HAVE_OPENMESH
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#endif

#if __has_include(<CGAL/Surface_mesh.h>)
#define HAVE_CGAL
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#endif

static std::size_t live_bytes = 0;

void* operator new(std::size_t n)
{
    void* p = std::malloc(n);
    if (!p) throw std::bad_alloc();
    live_bytes += malloc_usable_size(p);
    return p;
}

void operator delete(void* p) noexcept
{
    live_bytes -= malloc_usable_size(p);
    std::free(p);
}

void operator delete(void* p, std::size_t) noexcept
{
    operator delete(p);
}

namespace {

struct Soup {
    std::vector<std::array<double, 3>> points;
    std::vector<std::array<std::int32_t, 3>> faces;
};

Soup read_soup(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    std::array<std::int64_t, 2> counts{};
    in.read(reinterpret_cast<char*>(counts.data()), sizeof counts);
    Soup soup;
    soup.points.resize(counts[0]);
    soup.faces.resize(counts[1]);
    in.read(reinterpret_cast<char*>(soup.points.data()), 24 * counts[0]);
    in.read(reinterpret_cast<char*>(soup.faces.data()), 12 * counts[1]);
    return soup;
}

void report(const std::string& peer, const std::string& what, double number)
{
    std::cout << peer << ' ' << what << ' ' << number << std::endl;
}

void time_it(const std::string& peer, const std::string& what, const std::function<void()>& work)
{
    double best = std::numeric_limits<double>::infinity(), sum = 0;
    for (int i = 0; i < 3 && sum < 20; ++i) {
        const std::clock_t start = std::clock();
        work();
        const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        best = std::min(best, seconds);
        sum += seconds;
    }
    report(peer, what, best);
}

#ifdef HAVE_OPENMESH

struct DoubleTraits : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
};
using OpenMeshMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

OpenMeshMesh openmesh_of(const Soup& soup)
{
    OpenMeshMesh mesh;
    mesh.reserve(soup.points.size(), 3 * soup.faces.size() / 2, soup.faces.size());
    for (const auto& [x, y, z] : soup.points) mesh.add_vertex({x, y, z});
    for (const auto& [a, b, c] : soup.faces)
        mesh.add_face(mesh.vertex_handle(a), mesh.vertex_handle(b), mesh.vertex_handle(c));
    return mesh;
}

void openmesh_structure(const Soup& soup)
{
    const std::size_t before = live_bytes;
    const OpenMeshMesh mesh = openmesh_of(soup);
    report("openmesh", "bytes", static_cast<double>(live_bytes - before) / soup.points.size());
    time_it("openmesh", "halfedges", [&] { openmesh_of(soup); });
    time_it("openmesh", "rings", [&] {
        std::vector<OpenMesh::Vec3d> sums(soup.points.size());
        for (const auto v : mesh.vertices()) {
            OpenMesh::Vec3d sum(0, 0, 0);
            for (auto w = mesh.cvv_iter(v); w.is_valid(); ++w) sum += mesh.point(*w);
            sums[v.idx()] = sum;
        }
    });
}

OpenMesh::IO::Options::Flag binary_if(bool ascii)
{
    return ascii ? OpenMesh::IO::Options::Default : OpenMesh::IO::Options::Binary;
}

void openmesh_write(const Soup& soup, const std::string& path, bool ascii)
{
    const OpenMeshMesh mesh = openmesh_of(soup);
    time_it("openmesh", "write",
            [&] { OpenMesh::IO::write_mesh(mesh, path, binary_if(ascii), 9); });
}

void openmesh_read(const std::string& path)
{
    std::size_t faces = 0;
    time_it("openmesh", "read", [&] {
        OpenMeshMesh mesh;
        OpenMesh::IO::read_mesh(mesh, path);
        faces = mesh.n_faces();
    });
    report("openmesh", "faces", static_cast<double>(faces));
}

#endif

#ifdef HAVE_CGAL

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

SurfaceMesh cgal_of(const Soup& soup)
{
    SurfaceMesh mesh;
    mesh.reserve(soup.points.size(), 3 * soup.faces.size() / 2, soup.faces.size());
    for (const auto& [x, y, z] : soup.points) mesh.add_vertex({x, y, z});
    using V = SurfaceMesh::Vertex_index;
    for (const auto& [a, b, c] : soup.faces)
        mesh.add_face(V(static_cast<unsigned>(a)), V(static_cast<unsigned>(b)),
                      V(static_cast<unsigned>(c)));
    return mesh;
}

void cgal_structure(const Soup& soup)
{
    const std::size_t before = live_bytes;
    const SurfaceMesh mesh = cgal_of(soup);
    report("cgal", "bytes", static_cast<double>(live_bytes - before) / soup.points.size());
    time_it("cgal", "halfedges", [&] { cgal_of(soup); });
    time_it("cgal", "rings", [&] {
        std::vector<Kernel::Vector_3> sums(soup.points.size());
        for (const auto v : mesh.vertices()) {
            Kernel::Vector_3 sum = CGAL::NULL_VECTOR;
            for (const auto w : mesh.vertices_around_target(mesh.halfedge(v)))
                sum += mesh.point(w) - CGAL::ORIGIN;
            sums[v] = sum;
        }
    });
}

using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<int, Kernel,
                                              CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Structure =
    CGAL::Triangulation_data_structure_2<CGAL::Triangulation_vertex_base_2<Kernel>, FaceBase>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure>;

// Faces within an odd number of constraints from outside.
std::size_t faces_inside(Cdt& cdt)
{
    for (const auto face : cdt.all_face_handles()) face->info() = -1;
    std::vector<Cdt::Face_handle> now{cdt.infinite_face()}, beyond;
    std::size_t inside = 0;
    for (int level = 0; !now.empty(); ++level, now.swap(beyond), beyond.clear())
        while (!now.empty()) {
            const Cdt::Face_handle face = now.back();
            now.pop_back();
            if (face->info() != -1) continue;
            face->info() = level;
            inside += level % 2;
            for (int i = 0; i < 3; ++i)
                if (face->neighbor(i)->info() == -1)
                    (face->is_constrained(i) ? beyond : now).push_back(face->neighbor(i));
        }
    return inside;
}

void cgal_polygon(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    std::array<std::int64_t, 2> counts{};
    in.read(reinterpret_cast<char*>(counts.data()), sizeof counts);
    std::vector<double> numbers(2 * counts[0]);
    in.read(reinterpret_cast<char*>(numbers.data()), 16 * counts[0]);
    std::vector<Kernel::Point_2> ring;
    for (std::size_t i = 0; i < numbers.size(); i += 2)
        ring.emplace_back(numbers[i], numbers[i + 1]);
    std::size_t triangles = 0;
    time_it("cgal", "polygon", [&] {
        Cdt cdt;
        cdt.insert_constraint(ring.begin(), ring.end(), true);
        triangles = faces_inside(cdt);
    });
    report("cgal", "triangles", static_cast<double>(triangles));
}

#endif

}  // namespace

int main(int argc, char** argv)
{
    const std::vector<std::string> args(argv + 1, argv + argc);
    if (args.size() < 2) return 2;
#ifdef HAVE_OPENMESH
    if (args[0] == "mesh") openmesh_structure(read_soup(args[1]));
    if (args[0] == "write" && args.size() == 4)
        openmesh_write(read_soup(args[1]), args[2], args[3] == "1");
    if (args[0] == "read") openmesh_read(args[1]);
#endif
#ifdef HAVE_CGAL
    if (args[0] == "mesh") cgal_structure(read_soup(args[1]));
    if (args[0] == "polygon") cgal_polygon(args[1]);
#endif
    return 0;
}
