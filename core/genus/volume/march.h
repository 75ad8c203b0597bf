#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "genus/base/parallel.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/volume/cell_case.h"
#include "genus/volume/cell_tunnel.h"
#include "genus/volume/crossed_cells.h"

namespace genus {

/// The tunnel through a cell that marching cubes makes: where the trilinear interpolant has one.
template <typename Samples>
std::optional<CellTunnel> tunnel_of(const CubeCase& found, const Samples& samples,
                                    const CrossedCell& cell)
{
    if (!found.may_have_tunnel) return std::nullopt;
    std::array<double, 8> values;
    for (int c = 0; c < 8; ++c)
        values[c] =
            samples.relative(cell.i + (c & 1), cell.j + (c >> 1 & 1), cell.k + (c >> 2 & 1));
    return cell_tunnel(values);
}

/// A strip of triangles from a loop to the points of a waist, the latter in the direction and from
/// the start that make it shortest.
///
/// Both go round once, so that point n of m lies about opposite point 4 n / m of the other.
class WaistStrip {
public:
    static constexpr std::size_t kWaist = 4;

    /// The waist is passed as start, start + step, start + 2 step, ... modulo its size.
    struct Course {
        std::size_t start = 0, step = 1;
        double length = 0.0;
        std::size_t at(std::size_t n) const { return (start + n * step) % kWaist; }
    };

    WaistStrip(std::span<const Vec3> loop, std::span<const Vec3, kWaist> waist)
        : loop_(loop), waist_(waist)
    {
    }

    Course shortest(bool forwards) const
    {
        Course best;
        best.length = std::numeric_limits<double>::infinity();
        for (std::size_t start = 0; start < kWaist; ++start) {
            Course course{start, forwards ? 1 : kWaist - 1, 0.0};
            for (std::size_t n = 0; n < loop_.size(); ++n)
                course.length += distance(loop_[n], waist_[course.at(opposite(n))]);
            if (course.length < best.length) best = course;
        }
        return best;
    }

    /// Calls `add(n, m, w)` for triangles from points n and m = n + 1 of the loop to w of the
    /// waist, and `add_back(n, w, v)` for those from point n to two neighbours of the waist.
    template <typename Add, typename AddBack>
    void triangles(const Course& course, const Add& add, const AddBack& add_back) const
    {
        for (std::size_t n = 0; n < loop_.size(); ++n) {
            const std::size_t here = opposite(n), next = opposite(n + 1);
            add(n, (n + 1) % loop_.size(), course.at(here));
            for (std::size_t w = here; w < next; ++w)
                add_back((n + 1) % loop_.size(), course.at(w + 1), course.at(w));
        }
    }

private:
    std::size_t opposite(std::size_t n) const { return n * kWaist / loop_.size(); }

    std::span<const Vec3> loop_;
    std::span<const Vec3, kWaist> waist_;
};

/// Marching cubes on samples of either kind. `Crossings` gives the point on a crossed grid edge,
/// `crossings(axis, i, j, k)`, and that of a place inside a cell, `inner(cell, unit)`.
template <typename Samples, typename Crossings>
class March {
public:
    March(const Samples& samples, const Crossings& crossings)
        : samples_(samples), crossings_(crossings), cases_(cube_cases()), cells_(samples.bits())
    {
    }

    IndexedMesh run()
    {
        cells_.number([&](const CrossedCell& cell) { return count(cell); });
        mesh_.vertices.resize(cells_.n_vertices());
        mesh_.faces.resize(cells_.n_triangles());
        for_slots([&](std::size_t slot) {
            cells_.visit_edges(slot, [&](std::int64_t vertex, int axis, int i, int j, int k) {
                mesh_.vertices[vertex] = crossings_(axis, i, j, k);
            });
        });
        for_slots([&](std::size_t slot) {
            if (cells_.first_triangle(slot) == cells_.first_triangle(slot + 1)) return;
            Place place{mesh_.faces.data() + cells_.first_triangle(slot),
                        static_cast<std::int32_t>(cells_.first_inner_vertex(slot))};
            cells_.template visit_row<true>(slot,
                                            [&](const CrossedCell& cell) { fill(cell, place); });
        });
        return std::move(mesh_);
    }

private:
    // Where the next triangle and inner vertex go.
    struct Place {
        Triangle* face;
        std::int32_t inner;
    };
    using Loop = CubeCase::Loop;
    using Cells = CrossedCells<std::decay_t<decltype(std::declval<Samples>().bits())>>;
    using RowCounts = typename Cells::RowCounts;

    template <typename Body>
    void for_slots(const Body& body) const
    {
        parallel_for(cells_.n_slots(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t slot = begin; slot < end; ++slot) body(slot);
        });
    }

    RowCounts count(const CrossedCell& cell) const
    {
        const CubeCase& found = case_of(cases_, samples_, cell);
        RowCounts counts{found.n_inner_vertices, found.n_triangles};
        if (const auto tunnel = tunnel_of(found, samples_, cell)) {
            counts.inner_vertices += static_cast<std::int32_t>(WaistStrip::kWaist);
            for (const std::uint8_t edge : tunnel->edges) {
                // As a disc the loop has two triangles less than corners, or as many with a vertex
                // inside.
                const bool fan = loop_through(found, edge).triangles.empty();
                counts.inner_vertices -= fan ? 1 : 0;
                counts.triangles += static_cast<std::int32_t>(WaistStrip::kWaist) + (fan ? 0 : 2);
            }
        }
        return counts;
    }

    static const Loop& loop_through(const CubeCase& found, std::uint8_t edge)
    {
        return *std::find_if(found.loops.begin(), found.loops.end(), [&](const Loop& loop) {
            return std::find(loop.edges.begin(), loop.edges.end(), edge) != loop.edges.end();
        });
    }

    void fill(const CrossedCell& cell, Place& place)
    {
        const CubeCase& found = case_of(cases_, samples_, cell);
        const auto tunnel = tunnel_of(found, samples_, cell);
        if (found.n_inner_vertices == 0 && !tunnel) {
            for (std::size_t n = 0; n < found.n_triangles; ++n) {
                const auto& t = found.all_triangles[n];
                add(place, cell.vertex[t[0]], cell.vertex[t[1]], cell.vertex[t[2]]);
            }
            return;
        }
        const Loop* first = tunnel ? &loop_through(found, tunnel->edges[0]) : nullptr;
        const Loop* second = tunnel ? &loop_through(found, tunnel->edges[1]) : nullptr;
        for (const Loop& loop : found.loops)
            if (&loop != first && &loop != second) fill_disc(cell, loop, place);
        if (tunnel) fill_tunnel(cell, *first, *second, tunnel->waist, place);
    }

    void fill_disc(const CrossedCell& cell, const Loop& loop, Place& place)
    {
        const auto vertex = [&](std::size_t n) {
            return cell.vertex[loop.edges[n % loop.edges.size()]];
        };
        for (const auto& t : loop.triangles) add(place, vertex(t[0]), vertex(t[1]), vertex(t[2]));
        if (!loop.triangles.empty()) return;
        Vec3 sum;
        for (std::size_t n = 0; n < loop.edges.size(); ++n) {
            sum += mesh_.vertices[vertex(n)];
            add(place, vertex(n), vertex(n + 1), place.inner);
        }
        mesh_.vertices[place.inner++] = sum / static_cast<double>(loop.edges.size());
    }

    void fill_tunnel(const CrossedCell& cell, const Loop& first, const Loop& second,
                     const std::array<Vec3, WaistStrip::kWaist>& unit, Place& place)
    {
        std::array<Vec3, WaistStrip::kWaist> waist;
        for (std::size_t w = 0; w < waist.size(); ++w)
            mesh_.vertices[place.inner + w] = waist[w] = crossings_.inner(cell, unit[w]);
        std::array<std::array<Vec3, 12>, 2> points;
        const std::array<const Loop*, 2> loops{&first, &second};
        const auto strip = [&](std::size_t which) {
            const auto& edges = loops[which]->edges;
            for (std::size_t n = 0; n < edges.size(); ++n)
                points[which][n] = mesh_.vertices[cell.vertex[edges[n]]];
            return WaistStrip(std::span(points[which]).first(edges.size()), waist);
        };
        const std::array<WaistStrip, 2> strips{strip(0), strip(1)};
        // The waist is passed in opposite directions by the two.
        const bool forwards = strips[0].shortest(true).length + strips[1].shortest(false).length <=
                              strips[0].shortest(false).length + strips[1].shortest(true).length;
        for (std::size_t which = 0; which < 2; ++which) {
            const auto outer = [&](std::size_t n) { return cell.vertex[loops[which]->edges[n]]; };
            const auto inner = [&](std::size_t w) {
                return place.inner + static_cast<std::int32_t>(w);
            };
            strips[which].triangles(
                strips[which].shortest(forwards == (which == 0)),
                [&](std::size_t n, std::size_t m, std::size_t w) {
                    add(place, outer(n), outer(m), inner(w));
                },
                [&](std::size_t n, std::size_t w, std::size_t v) {
                    add(place, outer(n), inner(w), inner(v));
                });
        }
        place.inner += static_cast<std::int32_t>(WaistStrip::kWaist);
    }

    void add(Place& place, std::int32_t a, std::int32_t b, std::int32_t c) const
    {
        *place.face++ = crossings_.mirrored() ? Triangle{a, c, b} : Triangle{a, b, c};
    }

    const Samples& samples_;
    const Crossings& crossings_;
    const CubeCases& cases_;
    Cells cells_;
    IndexedMesh mesh_;
};

}  // namespace genus
