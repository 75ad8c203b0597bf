#pragma once

#include <span>
#include <vector>

#include "genus/patch/bspline.h"

namespace genus {

/// How a uniform cubic spline ends.
enum class CubicEnds {
    Natural,  ///< it runs from the first to the last A-frame point, without curvature there
    Free,     ///< the A-frame points as they are: the curve stops short of the outer ones
    Closed    ///< the A-frame points form a ring
};

/// Uniform C2 cubic spline given by its A-frame points d_i, the apexes of the A-frames at its
/// joints. The joint at d_i is (d_(i-1) + 4 d_i + d_(i+1)) / 6, and the two inner Bezier points of
/// the piece from d_i to d_(i+1) divide that leg into three. Parameter t runs from 0 to the number
/// of pieces.
///
/// Implements [farin2002], chapters 8 and 9 (uniform case).
class CubicSpline {
public:
    /// Throws InvalidInput for fewer than 2 (Natural), 4 (Free), 3 (Closed) points, or if one is
    /// not finite.
    explicit CubicSpline(std::vector<Vec3> a_frame_points, CubicEnds ends = CubicEnds::Natural);

    const std::vector<Vec3>& a_frame_points() const { return points_; }
    CubicEnds ends() const { return ends_; }
    std::size_t n_pieces() const { return all_.size() - 3; }

    /// All Bezier points in order, 3 n_pieces() + 1 of them; joints are shared.
    std::vector<Vec3> bezier_points() const;
    std::vector<BezierCurve> bezier_segments() const;
    Vec3 value(double t) const;
    Vec3 derivative(double t, int order = 1) const;
    void evaluate(std::span<const double> t, std::span<Vec3> out) const;
    FlattenedCurve flatten(double tolerance) const;
    /// The same curve with knots 0, 1, 2, ..
    BSpline to_bspline() const;

private:
    std::vector<Vec3> points_;
    CubicEnds ends_;
    std::vector<Vec3> all_;  // the points with those beyond the ends
};

/// The A-frame points of the spline through the given points, one joint at each: natural ends, or
/// closed. O(n). Throws InvalidInput for Free ends, or as CubicSpline.
CubicSpline cubic_spline_through(std::span<const Vec3> points, CubicEnds ends = CubicEnds::Natural);

}  // namespace genus
