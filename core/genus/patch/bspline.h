#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "genus/patch/bezier_curve.h"

namespace genus {

/// A knot vector u_0 <= u_1 <= .. with the degree it belongs to. The domain is [u_p, u_n'] with
/// n' = size - p - 1, the number of control points.
///
/// Implements [farin2002], chapter 8; everything but evaluation goes by blossoms (its chapter 3),
/// the values f(t_1, .., t_p) of the polar form.
class KnotVector {
public:
    /// Throws InvalidInput unless 1 <= degree <= kMaxDegree, the knots are finite and ascending,
    /// at least 2 p + 2 of them, none more than p + 1 times, inside the domain none more than p
    /// times, and the domain is not empty.
    KnotVector(int degree, std::vector<double> knots);
    /// Ends p + 1 times, inner knots evenly between `from` and `to`.
    static KnotVector clamped(int degree, int n_points, double from = 0.0, double to = 1.0);
    /// 0, 1, 2, .. shifted so that the domain starts at 0.
    static KnotVector uniform(int degree, int n_points);

    int degree() const { return degree_; }
    const std::vector<double>& values() const { return knots_; }
    double operator[](std::size_t i) const { return knots_[i]; }
    int n_points() const { return static_cast<int>(knots_.size()) - degree_ - 1; }
    double begin() const { return knots_[static_cast<std::size_t>(degree_)]; }
    double end() const { return knots_[static_cast<std::size_t>(n_points())]; }
    bool operator==(const KnotVector&) const = default;

    /// The index k of the span [u_k, u_(k+1)) that holds t; outside the domain the first or last.
    int span(double t) const;
    /// All k with u_k < u_(k+1) inside the domain.
    std::vector<int> spans() const;
    /// The p + 1 basis functions that are not zero on span k, at t; they belong to the control
    /// points k - p .. k. Not negative inside the span, and summing to 1. O(p^2).
    std::vector<double> basis(int k, double t) const;
    /// Their derivatives of order 0 to `order`, one row each. O(p^3 order).
    std::vector<std::vector<double>> basis_derivatives(int k, double t, int order) const;
    /// The polar form of the piece on span k at p arguments, as weights of the same points. With
    /// all arguments equal it is the basis.
    std::vector<double> blossom_weights(int k, std::span<const double> arguments) const;
    int multiplicity(double t) const;
    /// With `t` added `times` times.
    KnotVector with(double t, int times = 1) const;
    /// One degree higher, every knot once more: the knots of the same splines elevated.
    KnotVector elevated() const;
    /// Those of both parts of a spline cut at t, and of the spline with t as often as the degree,
    /// whose control points the parts have: the first its first ones, the second its last, and both
    /// the one between. Throws InvalidInput unless t is inside the domain.
    struct Split;
    Split split(double t) const;

private:
    int degree_;
    std::vector<double> knots_;
};

struct KnotVector::Split {
    KnotVector whole, before, after;
};

/// B-spline curve, with weights a NURBS. Control points in model units.
///
/// Implements [farin2002], chapters 8 and 13; [piegl1997], chapters 5, 7 and 9.
class BSpline {
public:
    /// Throws InvalidInput unless the sizes agree, all is finite, and weights are positive.
    BSpline(std::vector<Vec3> points, KnotVector knots, std::vector<double> weights = {});
    /// Clamped and uniform.
    BSpline(std::vector<Vec3> points, int degree);
    /// Closed: the points form a ring, the knots are uniform, the ends join C^(p-1).
    static BSpline closed(const std::vector<Vec3>& ring, int degree);

    int degree() const { return knots_.degree(); }
    const std::vector<Vec3>& points() const { return points_; }
    const std::vector<double>& weights() const { return weights_; }
    const KnotVector& knots() const { return knots_; }
    bool rational() const { return !weights_.empty(); }
    std::vector<Vec4> homogeneous() const;

    /// de Boor's algorithm; outside the domain the end pieces go on. O(p^2).
    Vec3 value(double t) const;
    /// Derivatives of order 0 to `order`; at a knot those from the right. O(p^2 order).
    std::vector<Vec3> derivatives(double t, int order) const;
    Vec3 derivative(double t, int order = 1) const;
    /// Points at many parameters, clamped to the domain, in any order; O(p) each after O(n p^2).
    void evaluate(std::span<const double> t, std::span<Vec3> out) const;

    /// The same curve with the knot inserted (Boehm). Throws InvalidInput where the multiplicity
    /// would exceed the degree, or outside the domain.
    BSpline with_knot(double t, int times = 1) const;
    /// The parts before and after t, each over its share of the domain.
    std::pair<BSpline, BSpline> split(double t) const;
    /// The same curve with a knot vector that contains its own. Throws InvalidInput if not.
    BSpline refined(const KnotVector& knots) const;
    BSpline elevated() const;
    /// The polynomial (or rational) pieces, each over [0, 1], in order.
    std::vector<BezierCurve> bezier_segments() const;
    /// Polyline within `tolerance`, parameters those of the spline. See BezierCurve::flatten.
    FlattenedCurve flatten(double tolerance) const;
    CurveLength length(double tolerance) const;
    Box3 bounds() const;

private:
    std::vector<Vec3> points_;
    std::vector<double> weights_;
    KnotVector knots_;
};

BSpline transformed(const BSpline& curve, const Transform& map);

/// Control points of splines over `to` that equal those over `from`: row i of the result lists
/// the weights of the old points, first index and values. Used for curves and surfaces.
struct KnotRefinement {
    struct Row {
        int first;
        std::vector<double> weights;
    };
    std::vector<Row> rows;
};
/// `to` must contain `from`, with the same degree, or be one degree higher with every knot at
/// least once more. Throws InvalidInput if not.
KnotRefinement refinement(const KnotVector& from, const KnotVector& to);

// Interpolation and fitting.

enum class Parametrization { Uniform, ChordLength, Centripetal };
/// Parameters in [0, 1] for a row of points; [farin2002], chapter 9. For a closed row the last
/// parameter is that of the first point again. Throws InvalidInput if neighbours coincide and the
/// parametrization is not uniform.
std::vector<double> parameters(std::span<const Vec3> points, Parametrization kind,
                               bool closed = false);

enum class SplineEnds {
    NotAKnot,  ///< one polynomial over the first two, and the last two, intervals
    Natural,   ///< no second derivative at the ends
    Clamped,   ///< tangents given
    Periodic   ///< closed, C2 at the seam too
};
struct InterpolationOptions {
    SplineEnds ends = SplineEnds::NotAKnot;
    Parametrization parametrization = Parametrization::Centripetal;
    Vec3 start_tangent, end_tangent;  // derivatives by the parameter, for Clamped
};
/// The C2 cubic through the points, O(n). Two or three points give the polynomial through them,
/// unless tangents are given. Throws InvalidInput for less than 2 (closed: 3) points.
///
/// Implements [farin2002], chapter 9. Elimination without pivoting, which total
/// positivity of spline collocation allows ([deboor1977]).
BSpline interpolate(std::span<const Vec3> points, const InterpolationOptions& options = {});

struct SplineFit {
    BSpline curve;
    double largest;  // distance of a point from the curve at its parameter
    double rms;
};
/// Least-squares spline of the given degree with `n_points` control points, through the first and
/// the last point; knots as [piegl1997], section 9.4.1, so that every span holds a parameter.
/// O(points n_points^2). Throws InvalidInput unless degree < n_points <= points.
SplineFit fit(std::span<const Vec3> points, int n_points, int degree = 3,
              Parametrization kind = Parametrization::ChordLength);

// Conics, exactly.

/// center + a cos x + b sin x for x from `from` over `sweep` degrees: a circle if a and b are
/// orthogonal and of equal length, else an ellipse. Degree 2, at most 90 degrees a piece.
/// Throws InvalidInput unless 0 < |sweep| <= 360.
BSpline elliptic_arc(const Vec3& center, const Vec3& a, const Vec3& b, double from = 0.0,
                     double sweep = 360.0);
/// Conic from a to b with tangents meeting in `apex`: an ellipse for weight < 1, parabola = 1,
/// hyperbola > 1.
BezierCurve conic(const Vec3& a, const Vec3& apex, const Vec3& b, double weight);

}  // namespace genus
