#include "genus/mesh/slice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

using EdgeKey = std::uint64_t;

EdgeKey key(std::int32_t a, std::int32_t b)
{
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 |
           static_cast<std::uint32_t>(std::max(a, b));
}

void check_mesh(const IndexedMesh& mesh)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v)
        if (!is_finite(mesh.vertices[v]))
            throw InvalidInput("slice: vertex " + std::to_string(v) + " is not finite");
}

class Slicer {
public:
    Slicer(const IndexedMesh& mesh, double z) : mesh_(mesh), z_(z) {}

    std::vector<Ring> run()
    {
        for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
            if (f % 65536 == 65535) current_progress().check();
            add_segment(mesh_.faces[f]);
        }
        std::vector<Ring> rings;
        for (std::size_t s = 0; s < segments_.size(); ++s)
            if (!segments_[s].used) rings.push_back(follow(static_cast<std::int32_t>(s)));
        return rings;
    }

private:
    // Through one face, from the side that leads down through the plane to the one that leads up:
    // so the inside is on the left, and the next face takes over at the same edge.
    struct Segment {
        EdgeKey from, to;
        std::int32_t other;  // segment with the same start, -1 if none
        bool used;
    };

    bool is_above(std::int32_t v) const { return mesh_.vertices[v][2] >= z_; }

    void add_segment(const Triangle& t)
    {
        if (is_above(t[0]) == is_above(t[1]) && is_above(t[1]) == is_above(t[2])) return;
        Segment segment{};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t a = t[i], b = t[(i + 1) % 3];
            if (is_above(a) && !is_above(b)) segment.from = key(a, b);
            if (!is_above(a) && is_above(b)) segment.to = key(a, b);
        }
        const auto number = static_cast<std::int32_t>(segments_.size());
        const auto [at, fresh] = start_.try_emplace(segment.from, number);
        segment.other = fresh ? -1 : at->second;
        at->second = number;
        segments_.push_back(segment);
    }

    // At an edge of more than two faces any unused segment will do: the rings touch there.
    Ring follow(std::int32_t first)
    {
        Ring ring;
        const EdgeKey begin = segments_[first].from;
        std::int32_t at = first;
        while (true) {
            Segment& segment = segments_[at];
            segment.used = true;
            const Vec2 p = crossing(segment.from);
            if (ring.empty() || ring.back() != p) ring.push_back(p);
            if (segment.to == begin) return ring;
            const auto next = start_.find(segment.to);
            at = next == start_.end() ? -1 : next->second;
            while (at >= 0 && segments_[at].used) at = segments_[at].other;
            if (at < 0) refuse(segment.to);
        }
    }

    // The same bits for all faces at the edge. A vertex in the plane is its own crossing.
    Vec2 crossing(EdgeKey edge) const
    {
        const Vec3& a = mesh_.vertices[edge >> 32];
        const Vec3& b = mesh_.vertices[edge & 0xffffffff];
        const double t = (0.5 * z_ - 0.5 * a[2]) / (0.5 * b[2] - 0.5 * a[2]);
        if (t <= 0.5) return {{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])}};
        const double u = (0.5 * z_ - 0.5 * b[2]) / (0.5 * a[2] - 0.5 * b[2]);
        return {{b[0] + u * (a[0] - b[0]), b[1] + u * (a[1] - b[1])}};
    }

    [[noreturn]] static void refuse(EdgeKey edge)
    {
        throw InvalidInput("slice: the mesh is open, or not oriented, at edge " +
                           std::to_string(edge >> 32) + "-" + std::to_string(edge & 0xffffffff));
    }

    const IndexedMesh& mesh_;
    double z_;
    std::vector<Segment> segments_;
    std::unordered_map<EdgeKey, std::int32_t> start_;  // last segment that starts at an edge
};

}  // namespace

Region slice(const IndexedMesh& mesh, double z)
{
    require(std::isfinite(z), "slice: z", z, "finite");
    check_mesh(mesh);
    return make_region(Slicer(mesh, z).run());
}

Region project(const IndexedMesh& mesh)
{
    check_mesh(mesh);
    std::vector<Ring> rings;
    for (const Triangle& t : mesh.faces) {
        Ring ring;
        for (const std::int32_t v : t) ring.push_back({{mesh.vertices[v][0], mesh.vertices[v][1]}});
        if (orient2d(ring[0], ring[1], ring[2]) > 0) rings.push_back(std::move(ring));
    }
    return make_region(rings);
}

}  // namespace genus
