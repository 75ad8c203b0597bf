#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "genus/boolean/exact_point.h"

namespace genus::exact {

/// Sorts points of a plane, seen along `axis`, along a Hilbert curve: in this order each lands near
/// the one before, and few triangles are long on the way. O(n log n).
void sort_along_curve(int axis, const std::vector<PointRef>& points,
                      std::vector<std::int32_t>& which);

/// Triangulation of exact points in one plane with edges that must be kept. Every decision about
/// its topology is exact; shapes are improved by flips that an inexact circle test proposes.
///
/// Constraints carry a number, their carrier. Where two constraints cross at no vertex, the point
/// comes from the `crossing` function given the two carriers.
///
/// Implements [sloan1993] for constrained edges (flips, no cavity), [lawson1977] for the shapes.
/// Location walks from the last point inserted: cheap for points in a spatial order.
class PlanarTriangulation {
public:
    static constexpr int kNone = -1;

    /// Counterclockwise; edge i runs from v[i] to v[i + 1].
    struct Cell {
        std::array<int, 3> v;
        std::array<int, 3> neighbor;  // across edge i, or kNone
        std::array<int, 3> carrier;   // of edge i, or kNone if it is free
    };
    using Crossing = std::function<PointRef(int carrier_a, int carrier_b)>;

    /// The points' plane is seen along `axis`, from its negative end if `flipped`.
    PlanarTriangulation(int axis, bool flipped, Crossing crossing)
        : axis_(axis), sign_(flipped ? -1 : 1), crossing_(std::move(crossing))
    {
    }

    /// Starts with a convex polygon, counterclockwise; its corners become points 0, 1, ...
    void start_with_polygon(const std::vector<PointRef>& corners);
    /// Starts with a rectangle a little larger than `box` in the two axes seen; its corners become
    /// points 0 to 3.
    void start_with_rectangle(const Vec3& low, const Vec3& high);

    /// Inserts a point that is none of those inside yet and returns its number. Throws Error if it
    /// lies outside or on another point.
    int insert(const PointRef& point);
    /// Keeps the straight edge from a to b. It is cut where it passes through points.
    void constrain(int a, int b, int carrier);
    /// Flips free edges towards a Delaunay triangulation.
    void improve();
    void reserve(std::size_t n_points);

    const std::vector<Cell>& cells() const { return cells_; }
    const std::vector<PointRef>& points() const { return points_; }
    /// Cell to the left of the edge from a to b and the number of the edge in it; {kNone, 0} if
    /// there is none.
    std::array<int, 2> find_edge(int a, int b) const;

private:
    int side(int a, int b, int c) const
    {
        return sign_ * turn(axis_, points_[a], points_[b], points_[c]);
    }
    bool ahead(int a, int b, int c) const;
    int add_point(const PointRef& point);
    void set(int cell, std::array<int, 3> v, std::array<int, 3> neighbor,
             std::array<int, 3> carrier);
    void relink(int cell, int from, int to);
    void mark(int cell, int edge, int carrier);
    void split_cell(int cell, int point);
    void split_edge(int cell, int edge, int point);
    bool convex(int cell, int edge) const;
    bool badly_shaped(int cell, int edge) const;
    void flip(int cell, int edge);
    void legalize(std::size_t budget, bool is_new_point);
    int advance(int a, int b, int carrier);
    void clear_way(std::vector<std::array<int, 2>>& crossed, int a, int b);
    template <class F>
    bool round(int point, const F& visit) const;

    int axis_;
    int sign_;
    Crossing crossing_;
    std::vector<PointRef> points_;
    std::vector<Vec2> seen_;  // approximations of the points as the plane is seen
    std::vector<Cell> cells_;
    std::vector<int> cell_of_;                  // one cell at each point
    std::vector<std::array<int, 2>> doubtful_;  // cells and edges that may have to be flipped
    int last_ = 0;
    std::uint32_t random_ = 12345;
};

}  // namespace genus::exact
