#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/transform.h"
#include "genus/base/vec.h"
#include "genus/patch/bernstein.h"

namespace genus {

/// A polyline that stands for a curve.
struct FlattenedCurve {
    std::vector<double> parameters;  // ascending, from 0 to 1
    std::vector<Vec3> points;        // on the curve, up to rounding
    double bound = 0.0;              // distance between polyline and curve, both ways
};

struct CurveLength {
    double length = 0.0;
    double bound = 0.0;  // the true length is within this
};

struct NearestOnCurve {
    double parameter = 0.0;
    Vec3 point;
    double distance = 0.0;
    double bound = 0.0;  // no point of the curve is nearer than distance - bound
};

/// Bezier curve of degree 0 to kMaxDegree over [0, 1] in space; a plane curve has z = 0. With
/// weights it is rational. Coordinates in model units, below 1e150.
///
/// Implements [farin2002], chapters 5, 6 and 13.
class BezierCurve {
public:
    /// Throws InvalidInput unless there are 1 to kMaxDegree + 1 finite points, and no weights or
    /// as many, all positive and finite.
    explicit BezierCurve(std::vector<Vec3> points, std::vector<double> weights = {});
    /// From (x w, y w, z w, w). Throws as above.
    static BezierCurve from_homogeneous(std::span<const Vec4> points);

    int degree() const { return static_cast<int>(points_.size()) - 1; }
    bool rational() const { return !weights_.empty(); }
    const std::vector<Vec3>& points() const { return points_; }
    /// Empty for a polynomial curve.
    const std::vector<double>& weights() const { return weights_; }
    /// (x w, y w, z w, w), with w = 1 for a polynomial curve.
    std::vector<Vec4> homogeneous() const;
    bool operator==(const BezierCurve&) const = default;

    /// Point at t by de Casteljau. Any t; inside the hull of the points for t in [0, 1]. O(n^2).
    Vec3 value(double t) const;
    /// The same with a bound on the rounding error of each coordinate, correct to the last bit in
    /// nearly all cases, see bernstein::value_with_bound. O(n).
    Bounded<3> value_with_bound(double t) const;
    /// Derivatives of order 0 to `order` by the parameter. O(n^2 order).
    std::vector<Vec3> derivatives(double t, int order) const;
    Vec3 derivative(double t, int order = 1) const;
    /// Curvature, 1 / model units; infinity at a cusp with zero speed.
    double curvature(double t) const;

    /// Points at many parameters in [0, 1], O(n) each, vectorised; rounding errors below
    /// `bulk_bound()`. `out` must be as long as `t`, else InvalidInput.
    void evaluate(std::span<const double> t, std::span<Vec3> out) const;
    /// Largest rounding error of a point from `evaluate`, as a distance.
    double bulk_bound() const;

    std::pair<BezierCurve, BezierCurve> split(double t) const;
    /// The part from a to b, run through from 0 to 1; may reach out of [0, 1], where it extends
    /// the curve. Throws InvalidInput if a == b, or if a weight ceases to be positive.
    BezierCurve segment(double a, double b) const;
    BezierCurve reversed() const;
    /// The same curve with a degree higher by `by`.
    BezierCurve elevated(int by = 1) const;
    /// A curve of lower degree with the same ends, and how far it may be away at equal parameters.
    /// The control points are the least-squares choice, which [lutterkort1999] shows to be best in
    /// the L2 norm (there without fixed ends). Throws InvalidInput unless 1 <= degree <= n.
    std::pair<BezierCurve, double> reduced(int degree) const;

    /// Polyline within `tolerance`, by halving where needed; each piece is held by the hull of its
    /// control points, and by [filip1986] for polynomial curves. The number of points grows like
    /// tolerance^(-1/2). Throws InvalidInput for a tolerance that is not positive, ToleranceNotMet
    /// below rounding.
    FlattenedCurve flatten(double tolerance) const;
    /// Length of the part from a to b. Throws as `flatten`.
    ///
    /// Gauss's rule with 12 points on pieces where the speed is analytic on a Bernstein ellipse,
    /// with the error bound that follows; chord and control polygon bracket the rest (cusps).
    CurveLength length(double tolerance, double a = 0.0, double b = 1.0) const;
    /// Nearest point of the curve over [0, 1], by branch and bound on the squared distance in
    /// Bernstein form, then Newton. The distance is the least up to `tolerance`.
    NearestOnCurve nearest(const Vec3& p, double tolerance) const;

    /// Box of the control points, which holds the curve over [0, 1].
    Box3 bounds() const;

private:
    std::vector<Vec3> points_;
    std::vector<double> weights_;
};

/// Image under an affine map, exact up to rounding. Throws InvalidInput for a projection.
BezierCurve transformed(const BezierCurve& curve, const Transform& map);

/// Parameters at which the curve meets the plane normal . p = offset, see bernstein::roots. A
/// curve that lies in the plane gives none. Throws InvalidInput if the normal is zero.
std::vector<bernstein::Root> intersect_plane(const BezierCurve& curve, const Vec3& normal,
                                             double offset);

struct CurveCrossing {
    double s, t;      // parameters on the first and the second curve
    Vec3 point;       // midway between both
    double distance;  // between both curves there
};
struct CurveCrossings {
    std::vector<CurveCrossing> crossings;  // ascending in s
    /// True if the curves run together for a stretch: then only some of its points are listed.
    bool overlap = false;
};

/// Where two curves come as close as `tolerance`; one entry for each place. Meant for curves that
/// cross or touch: plane curves, or curves on a common surface.
///
/// Implements [sederberg1990] with two fat planes round the chord in place of one fat line, since
/// the curves lie in space. Throws InvalidInput for a tolerance that is not positive.
CurveCrossings intersect(const BezierCurve& a, const BezierCurve& b, double tolerance);

/// How two curves join: the last point of `a` against the first of `b`, and the jumps of first and
/// second derivative by a common parameter, in which `a` lasts 1 and `b` lasts `ratio`.
struct CurveJoin {
    double gap;        // C0: distance, model units
    double kink;       // C1: length of the jump of the first derivative
    double bend;       // C2: of the second
    double turn;       // G1: angle between the tangents, radians
    double curvature;  // G2: length of the jump of the curvature vector, 1 / model units

    bool continuous(int order, double tolerance) const
    {
        return gap <= tolerance && (order < 1 || kink <= tolerance) &&
               (order < 2 || bend <= tolerance);
    }
};
CurveJoin join(const BezierCurve& a, const BezierCurve& b, double ratio = 1.0);

/// First `order` + 1 control points of a curve that continues `a` with C^order continuity, both
/// of a's degree and lasting `ratio` times as long. For order 2 this is the A-frame: the outer legs
/// of b_(n-2) b_(n-1) and c_1 c_2 meet in its apex.
/// Throws InvalidInput unless 0 <= order <= degree, ratio > 0 and `a` is polynomial.
///
/// Implements [farin2002], chapters 5 and 8.
std::vector<Vec3> continuation(const BezierCurve& a, int order, double ratio = 1.0);

/// Apex of the A-frame at the end of `a`: b_(n-1) + ratio (b_(n-1) - b_(n-2)). Two curves that
/// are C1 are C2 if the apex of the first is the apex of the second reversed (ratio inverted).
Vec3 a_frame_apex(const BezierCurve& a, double ratio = 1.0);

}  // namespace genus
