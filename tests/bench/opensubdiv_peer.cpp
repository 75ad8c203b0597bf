// OpenSubdiv beside genus, as a program of its own: `limit` reads a mesh and writes its limit
// points and normals, `bench` times the evaluation of a regular bicubic patch.
//
//     c++ -O2 -std=c++17 opensubdiv_peer.cpp -losdCPU -o opensubdiv_peer
//
// limit: scheme (catmark or loop), levels, counts of vertices, faces and creases; then the
// vertices, the faces with their count first, the creases as a b sharpness.

#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace OpenSubdiv;

struct Point {
    double x[3] = {0, 0, 0};
    void Clear(void* = nullptr) { x[0] = x[1] = x[2] = 0; }
    void AddWithWeight(const Point& p, double w)
    {
        for (int k = 0; k < 3; ++k) x[k] += w * p.x[k];
    }
};

struct Mesh {
    std::vector<Point> points;
    std::vector<int> counts, corners, crease_ends;
    std::vector<float> sharpness;
};

std::unique_ptr<Far::TopologyRefiner> refiner_of(const Mesh& mesh, bool loop)
{
    Far::TopologyDescriptor d;
    d.numVertices = static_cast<int>(mesh.points.size());
    d.numFaces = static_cast<int>(mesh.counts.size());
    d.numVertsPerFace = mesh.counts.data();
    d.vertIndicesPerFace = mesh.corners.data();
    d.numCreases = static_cast<int>(mesh.sharpness.size());
    d.creaseVertexIndexPairs = mesh.crease_ends.data();
    d.creaseWeights = mesh.sharpness.data();
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    return std::unique_ptr<Far::TopologyRefiner>(Factory::Create(
        d, Factory::Options(loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK, options)));
}

int limit()
{
    std::string scheme;
    int levels = 0, n_points = 0, n_faces = 0, n_creases = 0;
    if (!(std::cin >> scheme >> levels >> n_points >> n_faces >> n_creases)) return 2;
    Mesh mesh;
    mesh.points.resize(static_cast<std::size_t>(n_points));
    for (Point& p : mesh.points) std::cin >> p.x[0] >> p.x[1] >> p.x[2];
    for (int f = 0; f < n_faces; ++f) {
        int n = 0, v = 0;
        std::cin >> n;
        mesh.counts.push_back(n);
        for (int k = 0; k < n && std::cin >> v; ++k) mesh.corners.push_back(v);
    }
    for (int c = 0; c < n_creases; ++c) {
        int a = 0, b = 0;
        float s = 0;
        std::cin >> a >> b >> s;
        mesh.crease_ends.insert(mesh.crease_ends.end(), {a, b});
        mesh.sharpness.push_back(s);
    }
    if (!std::cin) return 2;
    const auto refiner = refiner_of(mesh, scheme == "loop");
    Far::TopologyRefiner::UniformOptions uniform(levels);
    uniform.fullTopologyInLastLevel = true;  // limits need the neighbours
    refiner->RefineUniform(uniform);
    const Far::PrimvarRefinerReal<double> primvar(*refiner);
    std::vector<Point> at = mesh.points;
    for (int level = 1; level <= levels; ++level) {
        std::vector<Point> next(
            static_cast<std::size_t>(refiner->GetLevel(level).GetNumVertices()));
        primvar.Interpolate(level, at, next);
        at.swap(next);
    }
    std::vector<Point> points(at.size()), du(at.size()), dv(at.size());
    primvar.Limit(at, points, du, dv);
    for (int v = 0; v < n_points; ++v) {
        int child = v;
        for (int level = 0; level < levels; ++level)
            child = refiner->GetLevel(level).GetVertexChildVertex(child);
        const auto c = static_cast<std::size_t>(child);
        const double *a = du[c].x, *b = dv[c].x;
        double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                       a[0] * b[1] - a[1] * b[0]};
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (double& x : n) x /= length;
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g\n", points[c].x[0], points[c].x[1],
                    points[c].x[2], n[0], n[1], n[2]);
    }
    return 0;
}

// Seconds for points and derivatives on the one regular patch of a 4 x 4 grid, and unit normals.
double bench(int count)
{
    Mesh mesh;
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<float> source;
    for (int k = 0; k < 16; ++k) {
        mesh.points.emplace_back();
        for (double& x : mesh.points.back().x) {
            x = normal(random);
            source.push_back(static_cast<float>(x));
        }
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            mesh.counts.push_back(4);
            const int v = 4 * i + j;
            mesh.corners.insert(mesh.corners.end(), {v, v + 1, v + 5, v + 4});
        }
    const auto refiner = refiner_of(mesh, false);
    Far::PatchTableFactory::Options options(0);
    refiner->RefineAdaptive(options.GetRefineAdaptiveOptions());
    const std::unique_ptr<Far::PatchTable> far(Far::PatchTableFactory::Create(*refiner, options));
    const std::unique_ptr<Osd::CpuPatchTable> table(Osd::CpuPatchTable::Create(far.get()));
    std::vector<Osd::PatchCoord> places;
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    const int patch = far->GetNumPatches(0) / 2;
    const Far::PatchTable::PatchHandle handle = {
        0, patch, patch * far->GetPatchArrayDescriptor(0).GetNumControlVertices()};
    for (int k = 0; k < count; ++k) places.emplace_back(handle, unit(random), unit(random));
    const auto n = static_cast<std::size_t>(count);
    std::vector<float> p(3 * n), u(3 * n), v(3 * n);
    const Osd::BufferDescriptor three(0, 3, 3);
    double best = 1e9;
    for (int run = 0; run < 3; ++run) {
        const std::clock_t start = std::clock();
        Osd::CpuEvaluator::EvalPatches(source.data(), three, p.data(), three, u.data(), three,
                                       v.data(), three, count, places.data(),
                                       table->GetPatchArrayBuffer(), table->GetPatchIndexBuffer(),
                                       table->GetPatchParamBuffer());
        for (std::size_t k = 0; k < 3 * n; k += 3) {
            const float *a = &u[k], *b = &v[k];
            const float x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
                        z = a[0] * b[1] - a[1] * b[0];
            const float scale = 1.0F / std::sqrt(x * x + y * y + z * z);
            u[k] = x * scale;
            u[k + 1] = y * scale;
            u[k + 2] = z * scale;
        }
        best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    }
    return best;
}

}  // namespace

int main(int argc, char** argv)
{
    const std::string what = argc > 1 ? argv[1] : "";
    if (what == "limit") return limit();
    if (what != "bench" || argc != 3) return 2;
    std::printf("%.6f\n", bench(std::atoi(argv[2])));
    return 0;
}
