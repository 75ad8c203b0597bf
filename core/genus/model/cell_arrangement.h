#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "genus/base/vec.h"

namespace genus {

/// Values of one surface at the corners of a cell.
using CellRow = std::array<double, 4>;

/// Where surfaces meet in an edge or face of a cell, or inside it.
struct CellVertex {
    std::uint8_t corners = 0;  // bit set
    std::uint8_t n_surfaces = 0;
    std::array<std::uint8_t, 3> surfaces{};  // local numbers, ascending
    bool operator==(const CellVertex&) const = default;
};

/// Up to N items, in place.
template <class T, std::size_t N>
class FewItems {
public:
    void push_back(const T& item) { items_.at(n_++) = item; }
    std::size_t size() const { return n_; }
    const T& operator[](std::size_t i) const { return items_[i]; }
    T* begin() { return items_.data(); }
    T* end() { return items_.data() + n_; }
    const T* begin() const { return items_.data(); }
    const T* end() const { return items_.data() + n_; }

private:
    std::array<T, N> items_{};
    std::size_t n_ = 0;
};

/// A convex piece of the plane of one surface. `label[i]` names what the side from vertex i lies
/// on: a local surface number, or -1 - f for the face of the cell opposite corner f.
struct CellPiece {
    // Each of nine other surfaces adds one to the four sides a plane has at most.
    static constexpr std::size_t kMostSides = 16;
    FewItems<CellVertex, kMostSides> vertices;
    FewItems<int, kMostSides> labels;
    unsigned signs = 0;  // bit j set: outside surface j
};

/// The planes on which linear functions vanish in one tetrahedron, cut by each other. Which
/// crossing comes first on an edge and which lines cross in a face is decided exactly, ties by a
/// shift of each function by its own infinitesimal, so that cells agree on the faces they share;
/// what happens inside the cell alone is decided in rounded numbers.
class CellArrangement {
public:
    /// Corners in the order of their codes; rows are the values of each surface at the corners.
    CellArrangement(std::array<Vec3, 4> corners, std::vector<CellRow> rows, bool positive)
        : corners_(corners), rows_(std::move(rows)), positive_(positive)
    {
    }

    /// The plane of surface i cut by all surfaces in `cutters`, normals towards larger values.
    std::vector<CellPiece> cut_plane(std::size_t i, const std::vector<std::size_t>& cutters) const;

    /// The same without cuts.
    CellPiece plane(std::size_t i) const;

    Vec3 position(const CellVertex& v) const;

    const CellRow& row(std::size_t i) const { return rows_[i]; }

private:
    CellVertex edge_vertex(int m, int n, std::size_t i) const;

    static bool even(const std::array<int, 4>& order);

    static void reverse(CellPiece& piece);

    // Sign of surface j at a vertex that is not on it.
    int sign_at(const CellVertex& v, std::size_t j) const;

    int sign_on_edge(const CellVertex& v, std::size_t j) const;

    int sign_on_face(const CellVertex& v, std::size_t j) const;

    int sign_in_cell(const CellVertex& v, std::size_t j) const;

    // Barycentric coordinates up to a factor: where all surfaces of the vertex vanish.
    std::array<double, 4> weights(const CellVertex& v) const;

    // The vertex where surface j crosses the side `label` of a piece of plane i.
    CellVertex crossing(std::size_t i, std::size_t j, int label) const;

    void cut(const CellPiece& piece, std::size_t i, std::size_t j,
             std::vector<CellPiece>& out) const;

    std::array<Vec3, 4> corners_;
    std::vector<CellRow> rows_;
    bool positive_;
};

/// The border of some pieces. Vertices in the middle of a straight side, which a neighbouring cell
/// may not have, are marked.
struct CellLoop {
    std::vector<CellVertex> vertices;
    std::vector<char> is_straight;
};

/// The border of one piece.
CellLoop border_of(const CellPiece& piece);

/// Joins pieces of one plane and one orientation into loops: sides between two pieces vanish.
std::vector<CellLoop> join(const std::vector<CellPiece>& pieces);

}  // namespace genus
