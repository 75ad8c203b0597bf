#pragma once

#include "genus/base/predicates.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/cube_cases.h"

namespace genus {

/// The case of a crossed cell. The inside corners of an ambiguous face are joined where the
/// bilinear interpolant is below the level at its saddle, that is v0 v2 > v1 v3 with v0, v2 inside;
/// a tie is outside. Exact, hence the same from both sides of the face.
///
/// Implements [nielson1991], section 3.
template <typename Samples>
const CubeCase& case_of(const CubeCases& cases, const Samples& samples, const CrossedCell& cell)
{
    const std::uint8_t ambiguous = kAmbiguousFaces[cell.cube];
    std::uint8_t joined = 0;
    for (int face = 0; ambiguous >> face != 0; ++face) {
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
    return cases.at(cell.cube, joined);
}

}  // namespace genus
