#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace genus {

/// A point of the finest lattice, each coordinate in [0, BisectionTree::kSize].
struct LatticePoint {
    std::array<std::int32_t, 3> c{};

    bool operator==(const LatticePoint&) const = default;
    /// 21 bits a coordinate: a name for the point, and an order.
    std::uint64_t code() const
    {
        return static_cast<std::uint64_t>(c[0]) | static_cast<std::uint64_t>(c[1]) << 21 |
               static_cast<std::uint64_t>(c[2]) << 42;
    }
};

/// A tetrahedron of the tree. Its edge from corner 0 to corner `k` is the next to be halved.
struct LatticeTet {
    std::array<LatticePoint, 4> corner;
    int k = 3;
};

/// A cube cut into tetrahedra by repeated halving, fine where asked, without hanging vertices.
///
/// The cube starts as the six tetrahedra round one diagonal; each step halves an edge and with it
/// every tetrahedron round that edge. Three steps give tetrahedra of the first shape at half the
/// size, so there are three shapes in all. Which edges are halved is stored as the set of their
/// midpoints; the tetrahedra themselves are found again by descent and never stored.
///
/// `split` costs O(1) amortised, a descent O(1) a tetrahedron. Reading is safe from many threads.
///
/// Implements [maubach1995], section 4; midpoints and what they presuppose as in [weiss2011],
/// section 3 (diamonds).
class BisectionTree {
public:
    static constexpr int kLevels = 20;
    static constexpr std::int32_t kSize = 1 << kLevels;

    BisectionTree();

    static std::array<LatticeTet, 6> roots();
    /// True if the tetrahedron is so small that its edge has no lattice point in the middle.
    static bool is_finest(const LatticeTet& tet);
    static LatticePoint midpoint(const LatticeTet& tet);
    static std::pair<LatticeTet, LatticeTet> children(const LatticeTet& tet);

    /// Halves the edge with this midpoint, and first whatever must be halved before it.
    void split(const LatticePoint& midpoint);
    bool is_split(const LatticeTet& tet) const;
    std::size_t n_splits() const { return count_; }

private:
    bool insert(std::uint64_t code);
    bool contains(std::uint64_t code) const;
    void grow();

    std::vector<std::uint64_t> table_;  // open addressing; kEmpty marks a free place
    std::size_t count_ = 0;
};

}  // namespace genus
