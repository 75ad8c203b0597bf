#include "genus/mesh/rings.h"

#include <algorithm>

#include "genus/base/error.h"
#include "genus/base/parallel.h"

namespace genus {

namespace {

// One face for both halfedge forms.
struct PolygonRings {
    const HalfedgeMesh& mesh;

    std::size_t n_vertices() const { return mesh.vertex_slots(); }
    std::size_t n_sides() const { return mesh.halfedge_slots(); }
    // The mesh turns clockwise.
    static constexpr bool kReversed = true;
    template <class Visit>
    void visit(std::size_t v, Visit&& visit) const
    {
        if (!mesh.is_alive(Vertex(v))) return;
        for (const Halfedge h : mesh.outgoing(Vertex(v))) visit(mesh.to(h).index);
    }
};

struct TriangleRings {
    const TriangleHalfedgeMesh& mesh;

    std::size_t n_vertices() const { return mesh.n_vertices(); }
    std::size_t n_sides() const { return mesh.n_halfedges(); }
    static constexpr bool kReversed = false;
    template <class Visit>
    void visit(std::size_t v, Visit&& visit) const
    {
        mesh.visit_ring(Vertex(v), [&](Vertex w) { visit(w.index); });
    }
};

template <class Rings>
OneRings one_rings_of(const Rings& rings)
{
    OneRings out;
    out.vertices.reserve(rings.n_sides());
    out.starts.reserve(rings.n_vertices() + 1);
    for (std::size_t v = 0; v < rings.n_vertices(); ++v) {
        rings.visit(v, [&](std::int32_t w) { out.vertices.push_back(w); });
        if (Rings::kReversed)
            std::reverse(out.vertices.begin() + out.starts.back(), out.vertices.end());
        out.starts.push_back(static_cast<std::int64_t>(out.vertices.size()));
    }
    return out;
}

template <std::size_t kWidth, class Rings>
void add_up(const Rings& rings, const double* values, double* sums)
{
    parallel_for(rings.n_vertices(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            Vec<kWidth> sum;
            rings.visit(v, [&](std::int32_t w) {
                const double* value = values + kWidth * static_cast<std::size_t>(w);
                for (std::size_t i = 0; i < kWidth; ++i) sum[i] += value[i];
            });
            std::copy(sum.c.begin(), sum.c.end(), sums + kWidth * v);
        }
    });
}

template <class Rings>
std::vector<double> ring_sums_of(const Rings& rings, std::span<const double> values,
                                 std::size_t width)
{
    require(values.size() == rings.n_vertices() * width,
            "ring_sums: values must have one row for each vertex");
    std::vector<double> sums(values.size());
    if (width == 1) {
        add_up<1>(rings, values.data(), sums.data());
    } else if (width == 3) {
        add_up<3>(rings, values.data(), sums.data());
    } else {
        parallel_for(rings.n_vertices(), 8192, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                rings.visit(v, [&](std::int32_t w) {
                    for (std::size_t i = 0; i < width; ++i)
                        sums[v * width + i] += values[static_cast<std::size_t>(w) * width + i];
                });
        });
    }
    return sums;
}

}  // namespace

OneRings one_rings(const HalfedgeMesh& mesh)
{
    return one_rings_of(PolygonRings{mesh});
}

OneRings one_rings(const TriangleHalfedgeMesh& mesh)
{
    return one_rings_of(TriangleRings{mesh});
}

std::vector<double> ring_sums(const HalfedgeMesh& mesh, std::span<const double> values,
                              std::size_t width)
{
    return ring_sums_of(PolygonRings{mesh}, values, width);
}

std::vector<double> ring_sums(const TriangleHalfedgeMesh& mesh, std::span<const double> values,
                              std::size_t width)
{
    return ring_sums_of(TriangleRings{mesh}, values, width);
}

}  // namespace genus
