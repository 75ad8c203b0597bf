#include "genus/volume/marching_cubes.h"

#include <cmath>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/crossing.h"
#include "genus/volume/cube_cases.h"
#include "genus/volume/padded_samples.h"

namespace genus {

namespace {

// Bit f is set where the inside corners of the ambiguous face f are joined: where the bilinear
// interpolant is below the level at its saddle, that is v0 v2 > v1 v3 with v0, v2 inside. A tie is
// outside. Exact, hence the same from both sides of the face.
template <typename Samples>
std::uint8_t joined_faces(const Samples& samples, const CrossedCells::Cell& cell)
{
    std::uint8_t joined = 0;
    const std::uint8_t ambiguous = ambiguous_faces(cell.cube);
    for (int face = 0; face < 6; ++face) {
        if ((ambiguous >> face & 1) == 0) continue;
        const auto& corner = kCubeFaces[face];
        const int first = (cell.cube >> corner[0] & 1) != 0 ? 0 : 1;
        const auto value = [&](int n) {
            const int c = corner[(first + n) % 4];
            return samples.relative(cell.i + (c & 1), cell.j + (c >> 1 & 1), cell.k + (c >> 2 & 1));
        };
        if (orient2d({{value(0), value(1)}}, {{value(3), value(2)}}, {{0.0, 0.0}}) > 0)
            joined |= static_cast<std::uint8_t>(1 << face);
    }
    return joined;
}

template <typename Samples, typename Crossing>
IndexedMesh march(const Samples& samples, const Crossing& crossing)
{
    CrossedCells cells(samples.size(), [&](std::size_t row, std::uint64_t* bits) {
        samples.mark_inside(row, bits);
    });
    const auto case_of = [&](const CrossedCells::Cell& cell) -> const CubeCase& {
        return cube_case(cell.cube, joined_faces(samples, cell));
    };
    cells.number([&](const CrossedCells::Cell& cell) {
        const CubeCase& found = case_of(cell);
        return CrossedCells::RowCounts{found.n_inner_vertices, found.n_triangles};
    });
    IndexedMesh mesh;
    mesh.vertices.resize(cells.n_vertices());
    mesh.faces.resize(cells.n_triangles());
    parallel_for(cells.n_rows(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            cells.visit_edges(row, [&](std::int64_t vertex, int axis, int i, int j, int k) {
                mesh.vertices[vertex] = crossing(axis, i, j, k);
            });
    });
    parallel_for(cells.n_rows(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            Triangle* face = mesh.faces.data() + cells.first_triangle(row);
            std::int64_t inner = cells.first_inner_vertex(row);
            cells.visit_row<true>(row, [&](const CrossedCells::Cell& cell) {
                for (const CubeCase::Loop& loop : case_of(cell).loops) {
                    const auto vertex = [&](std::size_t n) {
                        return cell.vertex[loop.edges[n % loop.edges.size()]];
                    };
                    for (const auto& t : loop.triangles)
                        *face++ = {vertex(t[0]), vertex(t[1]), vertex(t[2])};
                    if (!loop.triangles.empty()) continue;
                    Vec3 sum;
                    for (std::size_t n = 0; n < loop.edges.size(); ++n) {
                        sum += mesh.vertices[vertex(n)];
                        *face++ = {vertex(n), vertex(n + 1), static_cast<std::int32_t>(inner)};
                    }
                    mesh.vertices[inner++] = sum / static_cast<double>(loop.edges.size());
                }
            });
        }
    });
    return mesh;
}

template <typename Value>
IndexedMesh march_samples(std::span<const Value> values, const GridSize& size,
                          const GridFrame& frame, const MarchingCubesOptions& options)
{
    const PaddedSamples<Value> samples(values, size, options.level, options.close_border);
    return march(samples, [&](int axis, int i, int j, int k) {
        return linear_crossing(samples, frame, axis, {i, j, k});
    });
}

template <typename Value>
void check(std::span<const Value> values, const GridSize& size, const GridFrame& frame)
{
    double samples = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        require(size[axis] >= 2, "marching_cubes: samples along an axis", size[axis], "2 or more");
        require(frame.spacing[axis] > 0.0, "marching_cubes: spacing", frame.spacing[axis],
                "positive");
        samples *= size[axis];
    }
    require(static_cast<double>(values.size()) == samples, "marching_cubes: number of values",
            static_cast<double>(values.size()), "the product of the sizes");
}

}  // namespace

IndexedMesh marching_cubes(const Implicit& field, const Box3& box,
                           const MarchingCubesOptions& options)
{
    const Grid grid = sample(field, box, options.cell_size);
    const PaddedSamples<double> samples(grid.values(), grid.size(), options.level,
                                        options.close_border);
    return march(samples, [&](int axis, int i, int j, int k) {
        return exact_crossing(samples, grid.frame(), field, options.level, axis, {i, j, k});
    });
}

IndexedMesh marching_cubes(const Grid& grid, const MarchingCubesOptions& options)
{
    return march_samples(grid.values(), grid.size(), grid.frame(), options);
}

IndexedMesh marching_cubes(std::span<const float> values, const GridSize& size,
                           const GridFrame& frame, const MarchingCubesOptions& options)
{
    check(values, size, frame);
    return march_samples(values, size, frame, options);
}

IndexedMesh marching_cubes(std::span<const double> values, const GridSize& size,
                           const GridFrame& frame, const MarchingCubesOptions& options)
{
    check(values, size, frame);
    return march_samples(values, size, frame, options);
}

}  // namespace genus
