#include "genus/model/coarse_shell.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace genus {

namespace {

constexpr double kShareOfEdge = 0.15;  // of the shortest at a vertex
constexpr double kSlope = 0.125;       // most change along an edge, beside its length
constexpr int kRounds = 4;
constexpr double kBeyond = 1.0;  // of the distance from the mesh to that of the sandwich

// Of the shell, at each vertex.
std::vector<double> thicknesses(const IndexedMesh& mesh)
{
    std::vector<double> thick(mesh.n_vertices(), std::numeric_limits<double>::infinity());
    for (int round = 0; round < kRounds; ++round)
        for (const Triangle& t : mesh.faces)
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int32_t v = t[i], w = t[(i + 1) % 3];
                const double length = distance(mesh.vertices[v], mesh.vertices[w]);
                thick[v] = std::min({thick[v], kShareOfEdge * length, thick[w] + kSlope * length});
                thick[w] = std::min({thick[w], kShareOfEdge * length, thick[v] + kSlope * length});
            }
    return thick;
}

}  // namespace

CoarseShell shell_round(const SurfaceMesh& coarse, const Sandwich& sandwich)
{
    CoarseShell shell{coarse.mesh, coarse.mesh};
    const std::vector<double> thickness = thicknesses(coarse.mesh);
    for (std::size_t v = 0; v < thickness.size(); ++v) {
        const Vec3 p = coarse.mesh.vertices[v];
        const Vec3 in = sandwich.inner.vertices[v], out = sandwich.outer.vertices[v];
        const double beyond = kBeyond * std::max(distance(p, in), distance(p, out));
        const Vec3 way = std::max(thickness[v], beyond) * normalized(out - in);
        shell.inner.vertices[v] = p - way;
        shell.outer.vertices[v] = p + way;
    }
    return shell;
}

}  // namespace genus
