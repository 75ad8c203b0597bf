#pragma once

#include <cstdint>
#include <span>

#include "genus/base/box.h"
#include "genus/implicit/implicit.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/volume/grid.h"

namespace genus {

/// What sampling a field took.
struct SamplingReport {
    std::int64_t samples = 0;
    std::int64_t decided = 0;  // by bounds of blocks, without an evaluation
    // Of extended marching cubes: cells whose sharp feature had to stay within them, or be left
    // out, since faces would have crossed.
    std::int64_t confined = 0, left_out = 0;
};

struct MarchingCubesOptions {
    double cell_size = 0.1;  // longest edge of a cell, model units
    double level = 0.0;      // field value on the surface
    /// Close the surface along the border of the grid, as if everything beyond were outside.
    bool close_border = true;
    /// Of arrays of someone else's.
    SampleOrder order = SampleOrder::FirstFastest;
    /// Of fields: pass over blocks of samples that an interval bound decides. The mesh is the same
    /// without.
    bool skip = true;
    /// Of fields: filled in, if given.
    SamplingReport* report = nullptr;
};

/// Triangulates the level set of `field` inside `box`.
///
/// Vertices lie on cell edges, at the exact crossing of the field, so a sharp edge is cut off by
/// up to one cell; extended_marching_cubes keeps it. Triangles turn outward, towards larger
/// values; a value equal to the level counts as outside. On a face with inside and outside corners
/// on its two diagonals the bilinear interpolant of the corner values decides, exactly, so
/// neighbours agree and the mesh is manifold, and closed with `close_border`. Inside a cell two
/// sheets are joined by a tunnel where the trilinear interpolant has one, so that on a grid the
/// mesh has the topology of the interpolant. Where a vertex falls on a grid corner,
/// triangles may have no area. Time and memory grow with the surface, not with the box: boxes that
/// an interval bound of the field decides are passed over (FieldSamples), a crossing takes about
/// six evaluations.
///
/// Implements [lorensen1987]; ambiguous faces as in [nielson1991], section 3, tunnels see
/// cell_tunnel.h.
/// Throws InvalidInput if `cell_size` is not positive, `level` not finite, `box` empty or
/// unbounded, or the surface has more than 2^31 vertices.
IndexedMesh marching_cubes(const Implicit& field, const Box3& box,
                           const MarchingCubesOptions& options = {});

/// The same on samples, with linear interpolation along cell edges. `cell_size` is not used.
IndexedMesh marching_cubes(const Grid& grid, const MarchingCubesOptions& options = {});

/// The same on an array of someone else's; checks as for Grid, but values are not checked for being
/// finite: whatever is not below the level is outside. `size` counts samples along x, y, z in
/// either order.
IndexedMesh marching_cubes(std::span<const float> values, const GridSize& size,
                           const GridFrame& frame, const MarchingCubesOptions& options = {});
IndexedMesh marching_cubes(std::span<const double> values, const GridSize& size,
                           const GridFrame& frame, const MarchingCubesOptions& options = {});

}  // namespace genus
