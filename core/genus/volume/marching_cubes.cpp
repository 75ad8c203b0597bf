#include "genus/volume/marching_cubes.h"

#include <cmath>

#include "genus/base/error.h"
#include "genus/volume/cell_case.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/crossing.h"
#include "genus/volume/field_samples.h"
#include "genus/volume/padded_samples.h"

namespace genus {

namespace {

template <typename Samples, typename Crossing>
IndexedMesh march(const Samples& samples, const Crossing& crossing)
{
    CrossedCells cells(samples.size(), [&](std::uint64_t* bits, std::size_t words) {
        samples.mark_inside(bits, words);
    });
    cells.number([&](const CrossedCells::Cell& cell) {
        const CubeCase& found = case_of(samples, cell);
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
                for (const CubeCase::Loop& loop : case_of(samples, cell).loops) {
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
    const FieldSamples samples(field, cover(box, options.cell_size), options.level,
                               options.close_border);
    return march(samples, [&](int axis, int i, int j, int k) {
        return exact_crossing(samples, axis, {i, j, k});
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
