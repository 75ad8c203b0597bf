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
};

/// Bit f is set if face f has its inside corners on one diagonal and its outside corners on the
/// other. Bit i of `inside` says that corner i is inside.
std::uint8_t ambiguous_faces(std::uint8_t inside);

/// The case of a pattern of inside corners; bit f of `joined` tells that on the ambiguous face f
/// the inside corners are joined through the middle. Other bits do not count.
///
/// The table is made from the rule that every face is crossed by segments with the inside on
/// their right, seen from outside the cube; they close to loops as every crossed edge starts one
/// segment and ends one.
const CubeCase& cube_case(std::uint8_t inside, std::uint8_t joined);

}  // namespace genus
