#include "genus/boolean/chords.h"

#include <algorithm>

#include "genus/base/error.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;
using Polygon = std::vector<Index>;

class ChordCutter {
public:
    ChordCutter(int axis, bool flipped, std::span<const PointRef> points)
        : axis_(axis), sign_(flipped ? -1 : 1), points_(points)
    {
    }

    std::optional<PolygonCells> run(std::span<const Chord> chords)
    {
        Polygon whole(points_.size());
        for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = static_cast<Index>(i);
        std::vector<Polygon> pieces{std::move(whole)};
        for (const Chord& chord : chords)
            if (!cut(pieces, chord)) return std::nullopt;
        for (const Polygon& piece : pieces) fill(piece, {});
        return std::move(result_);
    }

private:
    // A cell that waits for the one across its edge.
    struct Edge {
        Index cell = -1;
        int edge = 0;
    };

    int side(Index a, Index b, Index c) const
    {
        return sign_ * turn(axis_, points_[a], points_[b], points_[c]);
    }

    // Cuts the piece that both ends belong to. False if there is none, for then another chord
    // crosses, or if the chord lies along a side.
    bool cut(std::vector<Polygon>& pieces, Chord chord) const
    {
        const auto [low, high] = std::minmax(chord[0], chord[1]);
        for (std::size_t k = 0; k < pieces.size(); ++k) {
            Polygon& piece = pieces[k];
            // Places go up along a piece.
            const auto from = std::lower_bound(piece.begin(), piece.end(), low);
            const auto to = std::lower_bound(from, piece.end(), high);
            if (to == piece.end() || *from != low || *to != high) continue;
            if (to == from + 1 || (from == piece.begin() && to + 1 == piece.end())) return true;
            const Index beyond = to + 1 == piece.end() ? piece.front() : to[1];
            if (side(low, from[1], high) <= 0 || side(high, beyond, low) <= 0) return false;
            const Polygon between(from, to + 1);
            piece.erase(from + 1, to);
            pieces.push_back(between);
            return true;
        }
        return false;
    }

    // Fills a polygon with cells, one of them at the edge from its last to its first corner, across
    // from `waiting`.
    void fill(std::span<const Index> polygon, Edge waiting)
    {
        if (polygon.size() < 3) return;
        const Index first = polygon.front(), last = polygon.back();
        std::size_t best = 0;
        for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
            if (leaves_no_flat_piece(polygon, k) &&
                (best == 0 || lies_in_circle(last, first, polygon[best], polygon[k])))
                best = k;
        if (best == 0) throw Error("mesh_boolean: a polygon is not convex");
        const auto cell = static_cast<Index>(result_.corners.size());
        result_.corners.push_back({last, first, polygon[best]});
        result_.across.push_back({waiting.cell, -1, -1});
        if (waiting.cell >= 0) result_.across[waiting.cell][waiting.edge] = cell;
        fill(polygon.first(best + 1), {cell, 1});
        fill(polygon.subspan(best), {cell, 2});
    }

    // Has the cell at corner k an area, and so have the polygons on either side of it, if any? A
    // convex polygon without has all corners on one line, so that the second tells.
    bool leaves_no_flat_piece(std::span<const Index> polygon, std::size_t k) const
    {
        const Index first = polygon.front(), last = polygon.back();
        return side(last, first, polygon[k]) > 0 &&
               (k == 1 || side(first, polygon[1], polygon[k]) > 0) &&
               (k + 2 == polygon.size() || side(polygon[k], polygon[k + 1], last) > 0);
    }

    // Does d lie in the circle through a, b and c, counterclockwise? Not exact.
    bool lies_in_circle(Index a, Index b, Index c, Index d) const
    {
        const auto seen = [&](Index p) {
            const Vec3 v = points_[p].approx - points_[d].approx;
            return Vec2{{v[(axis_ + 1) % 3], v[(axis_ + 2) % 3]}};
        };
        const std::array<Vec2, 3> p{seen(a), seen(b), seen(c)};
        double det = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec2 &q = p[(i + 1) % 3], &r = p[(i + 2) % 3];
            det += dot(p[i], p[i]) * (q[0] * r[1] - r[0] * q[1]);
        }
        return sign_ * det > 0.0;
    }

    int axis_;
    int sign_;
    std::span<const PointRef> points_;
    PolygonCells result_;
};

}  // namespace

std::optional<PolygonCells> cut_by_chords(int axis, bool flipped, std::span<const PointRef> points,
                                          std::span<const Chord> chords)
{
    return ChordCutter(axis, flipped, points).run(chords);
}

}  // namespace genus::exact
