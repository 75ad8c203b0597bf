#include "genus/volume/marching_cubes.h"

#include <cmath>

#include "genus/base/error.h"
#include "genus/volume/crossing.h"
#include "genus/volume/march.h"

namespace genus {

namespace {

template <typename Value>
IndexedMesh march_samples(std::span<const Value> values, GridSize size, const GridFrame& frame,
                          const MarchingCubesOptions& options)
{
    require(std::isfinite(options.level), "marching_cubes: level", options.level, "finite");
    if (options.order == SampleOrder::LastFastest) std::swap(size[0], size[2]);
    const PaddedSamples<Value> samples(values, size, options.level, options.close_border);
    const LinearCrossings crossings(samples, frame, options.order);
    return March(samples, crossings).run();
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
    require(std::isfinite(options.level), "marching_cubes: level", options.level, "finite");
    const FieldSamples samples(field, cover(box, options.cell_size), options.level,
                               options.close_border, options.skip);
    const ExactCrossings crossings(samples);
    March march(samples, crossings);
    if (options.report) *options.report = {samples.n_samples(), samples.decided()};
    return march.run();
}

IndexedMesh marching_cubes(const Grid& grid, const MarchingCubesOptions& options)
{
    MarchingCubesOptions own = options;
    own.order = SampleOrder::FirstFastest;
    return march_samples(grid.values(), grid.size(), grid.frame(), own);
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
