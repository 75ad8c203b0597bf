#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace genus {

// The cube of all cell methods.
//
//   6---7      corner i is at (i & 1, i >> 1 & 1, i >> 2 & 1)
//  /|  /|      edges 0-3 run along x, 4-7 along y, 8-11 along z,
// 4---5 |      in the order of their smaller corner
// | 2-|-3      faces 0, 1 are x = 0, 1; 2, 3 are y = 0, 1; 4, 5 are z = 0, 1
// |/  |/
// 0---1

struct CubeEdge {
    std::uint8_t from, to;  // corners, from the smaller coordinate to the larger
};

inline constexpr std::array<CubeEdge, 12> kCubeEdges{{{0, 1},
                                                      {2, 3},
                                                      {4, 5},
                                                      {6, 7},
                                                      {0, 2},
                                                      {1, 3},
                                                      {4, 6},
                                                      {5, 7},
                                                      {0, 4},
                                                      {1, 5},
                                                      {2, 6},
                                                      {3, 7}}};

/// Corners of each face, counterclockwise seen from outside the cube.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kCubeFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

/// How the surface runs through a cell: closed loops over cube edges, each the rim of a disc.
/// Counterclockwise seen from outside the solid.
struct CubeCase {
    struct Loop {
        std::vector<std::uint8_t> edges;
        /// Triangles of positions in `edges`, without a diagonal in a face of the cube, where the
        /// neighbour could have the same one. Empty if there is no such choice: then a vertex
        /// inside the cell is joined to all edges.
        std::vector<std::array<std::uint8_t, 3>> triangles;
    };
    std::vector<Loop> loops;
    std::uint8_t n_triangles = 0;  // with inner vertices
    std::uint8_t n_inner_vertices = 0;
    /// Some values at corners of this pattern give two of the loops a tunnel; see cell_tunnel.h.
    bool may_have_tunnel = false;
    /// The triangles of all loops as cube edges, if there are no inner vertices.
    static constexpr std::size_t kMostTriangles = 10;
    std::array<std::array<std::uint8_t, 3>, kMostTriangles> all_triangles{};
};

namespace detail {

constexpr std::array<std::uint8_t, 256> find_ambiguous_faces()
{
    std::array<std::uint8_t, 256> found{};
    for (unsigned inside = 0; inside < 256; ++inside)
        for (unsigned face = 0; face < 6; ++face) {
            const auto& c = kCubeFaces[face];
            const auto bit = [&](unsigned k) { return inside >> c[k] & 1; };
            if (bit(0) == bit(2) && bit(1) == bit(3) && bit(0) != bit(1))
                found[inside] = static_cast<std::uint8_t>(found[inside] | 1U << face);
        }
    return found;
}

}  // namespace detail

/// Bit f of entry `inside` is set if face f has its inside corners on one diagonal and its outside
/// corners on the other. Bit i of `inside` says that corner i is inside.
inline constexpr std::array<std::uint8_t, 256> kAmbiguousFaces = detail::find_ambiguous_faces();

/// The cases of all patterns of inside corners.
///
/// The table is made from the rule that every face is crossed by segments with the inside on
/// their right, seen from outside the cube; they close to loops as every crossed edge starts one
/// segment and ends one.
class CubeCases {
public:
    CubeCases();
    /// Bit f of `joined` tells that on the ambiguous face f the inside corners are joined through
    /// the middle. Other bits do not count.
    const CubeCase& at(std::uint8_t inside, std::uint8_t joined) const
    {
        return cases_[inside * 64U + (joined & kAmbiguousFaces[inside])];
    }

private:
    std::vector<CubeCase> cases_;
};

/// Made when first asked for.
const CubeCases& cube_cases();

}  // namespace genus
