#include "genus/implicit/quadric_form.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"

namespace genus {
namespace {

constexpr double kZero = 1e-13;  // eigenvalues below this share of the largest count as zero

using Matrix3 = std::array<Vec3, 3>;

/// Eigenvalues of a symmetric matrix on its diagonal, eigenvectors in the rows of `vectors`.
/// Cyclic Jacobi rotations; [golub2013], section 8.5.
void diagonalise(Matrix3& a, Matrix3& vectors)
{
    vectors = {Vec3{{1, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}};
    for (int sweep = 0; sweep < 30; ++sweep) {
        if (a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0) return;
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                const double diagonal = std::fabs(a[p][p]) + std::fabs(a[q][q]);
                if (diagonal + 1e-3 * std::fabs(a[p][q]) == diagonal) a[p][q] = a[q][p] = 0.0;
                if (a[p][q] == 0.0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                const double t = (theta >= 0.0 ? 1.0 : -1.0) /
                                 (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y;
                    a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y;
                    a[q][k] = s * x + c * y;
                    const double u = vectors[p][k], v = vectors[q][k];
                    vectors[p][k] = c * u - s * v;
                    vectors[q][k] = s * u + c * v;
                }
            }
    }
}

/// F = sum lambda_i y_i^2 + 2 slope y_last + constant, y being coordinates along `axes` about
/// `center`. Directions with an eigenvalue of zero come last; `slope` is along the last one.
struct Reduced {
    int rank = 0;
    Vec3 lambda;
    double slope = 0.0;
    double constant = 0.0;
    Vec3 center;
    Matrix3 axes;
};

/// Steps by powers of two that bring the greatest entry of each row near 1. Signs of eigenvalues
/// do not change (Sylvester), but small ones are no longer lost behind large ones of other axes.
Vec3 equilibration(const Matrix3& a)
{
    Vec3 d{{1, 1, 1}};
    for (int step = 0; step < 8; ++step)
        for (int i = 0; i < 3; ++i) {
            double most = 0.0;
            for (int j = 0; j < 3; ++j) most = std::max(most, std::fabs(d[i] * a[i][j] * d[j]));
            if (most > 0.0) d[i] = std::ldexp(d[i], -std::ilogb(most) / 2);
        }
    return d;
}

/// Turns two axes without squares so that F is linear along the last one only.
void gather_slope(Reduced& r, Vec3& slopes)
{
    for (int i = r.rank; i < 2; ++i) {
        const double length = std::hypot(slopes[i], slopes[2]);
        if (slopes[i] == 0.0 || length == 0.0) continue;
        const double c = slopes[2] / length, s = slopes[i] / length;
        const Vec3 along = s * r.axes[i] + c * r.axes[2];
        r.axes[i] = c * r.axes[i] - s * r.axes[2];
        r.axes[2] = along;
        slopes[i] = 0.0;
        slopes[2] = length;
    }
}

Reduced reduce(const Quadric& quadric)
{
    const std::array<double, 10>& q = quadric.local();
    Matrix3 a{Vec3{{q[0], q[1], q[2]}}, Vec3{{q[1], q[4], q[5]}}, Vec3{{q[2], q[5], q[7]}}};
    const Vec3 d = equilibration(a);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) a[i][j] *= d[i] * d[j];
    Matrix3 vectors;
    diagonalise(a, vectors);
    std::array<int, 3> order{0, 1, 2};
    std::stable_sort(order.begin(), order.end(),
                     [&](int i, int j) { return std::fabs(a[i][i]) > std::fabs(a[j][j]); });
    Reduced r;
    r.center = quadric.origin();
    Vec3 slopes;
    const double largest = std::fabs(a[order[0]][order[0]]);
    for (int i = 0; i < 3; ++i) {
        r.lambda[i] = a[order[i]][order[i]];
        if (std::fabs(r.lambda[i]) <= kZero * largest) r.lambda[i] = 0.0;
        if (r.lambda[i] != 0.0) r.rank = i + 1;
        for (int k = 0; k < 3; ++k) r.axes[i][k] = d[k] * vectors[order[i]][k];
        slopes[i] = dot(r.axes[i], Vec3{{q[3], q[6], q[8]}});
    }
    r.constant = q[9];
    double magnitude = std::fabs(q[9]), steepest = 0.0;
    for (int i = 0; i < 3; ++i) steepest = std::max(steepest, std::fabs(slopes[i]));
    for (int i = 0; i < 3; ++i) {
        if (r.lambda[i] == 0.0) continue;
        const double step = -slopes[i] / r.lambda[i];
        r.center += step * r.axes[i];
        r.constant += slopes[i] * step;
        // Slopes and eigenvalues are rounded relative to their largest: so is what they add.
        magnitude += std::fabs(step) * (steepest + std::fabs(step) * largest);
    }
    if (std::fabs(r.constant) <= kZero * magnitude) r.constant = 0.0;
    gather_slope(r, slopes);
    const bool flat = std::fabs(slopes[2]) <= kZero * (steepest + std::sqrt(largest * magnitude));
    if (r.rank < 3 && !flat) r.slope = slopes[2];
    return r;
}

QuadricKind kind_without_slope(const Reduced& r)
{
    using K = QuadricKind;
    const int positive =
        static_cast<int>((r.lambda[0] > 0) + (r.lambda[1] > 0) + (r.lambda[2] > 0));
    if (r.rank == 0) return r.constant <= 0.0 ? K::Everything : K::Nothing;
    if (positive == 0 || positive == r.rank) {
        // One sign: around a place, or nowhere.
        const bool outside_far = positive > 0;
        const double inner = outside_far ? r.constant : -r.constant;
        if (inner > 0.0) return outside_far ? K::Nothing : K::Everything;
        constexpr std::array<K, 3> around{K::ParallelPlanes, K::EllipticCylinder, K::Ellipsoid};
        constexpr std::array<K, 3> shrunk{K::DoublePlane, K::Line, K::Point};
        return inner < 0.0 ? around[r.rank - 1] : shrunk[r.rank - 1];
    }
    if (r.rank == 2) return r.constant == 0.0 ? K::PlanePair : K::HyperbolicCylinder;
    if (r.constant == 0.0) return K::Cone;
    // Two signs against one: seen with two positive, a negative constant leaves one sheet.
    const bool one_sheet = (positive == 2) == (r.constant < 0.0);
    return one_sheet ? K::OneSheetHyperboloid : K::TwoSheetHyperboloid;
}

QuadricKind kind_of(const Reduced& r)
{
    if (r.slope == 0.0) return kind_without_slope(r);
    if (r.rank == 0) return QuadricKind::HalfSpace;
    if (r.rank == 1) return QuadricKind::ParabolicCylinder;
    return (r.lambda[0] > 0.0) == (r.lambda[1] > 0.0) ? QuadricKind::EllipticParaboloid
                                                      : QuadricKind::HyperbolicParaboloid;
}

/// Puts the axis whose sign differs from the two others last; of two axes, the one in which the
/// surface does not reach the centre.
void order_axes(Reduced& r, QuadricKind kind)
{
    const auto swap = [&](int i, int j) {
        std::swap(r.lambda[i], r.lambda[j]);
        std::swap(r.axes[i], r.axes[j]);
    };
    if (r.rank == 3) {
        if ((r.lambda[0] > 0) == (r.lambda[2] > 0) && (r.lambda[1] > 0) != (r.lambda[0] > 0))
            swap(1, 2);
        if ((r.lambda[1] > 0) == (r.lambda[2] > 0) && (r.lambda[0] > 0) != (r.lambda[1] > 0))
            swap(0, 2);
    }
    // X^2 - Y^2 = 1: the first axis has the sign opposite to the constant.
    if (kind == QuadricKind::HyperbolicCylinder && (r.lambda[0] > 0) == (r.constant > 0))
        swap(0, 1);
}

}  // namespace

QuadricForm::QuadricForm(const Quadric& quadric) : quadric_(quadric)
{
    Reduced r = reduce(quadric);
    kind_ = kind_of(r);
    order_axes(r, kind_);
    center_ = r.center;
    axes_ = r.axes;
    // Lengths that bring the constant and the squares to 1; a paraboloid's slope likewise.
    const double size = r.slope == 0.0 && r.constant != 0.0 ? std::fabs(r.constant) : 1.0;
    for (int i = 0; i < r.rank; ++i) axes_[i] *= std::sqrt(size / std::fabs(r.lambda[i]));
    if (r.slope != 0.0) {
        center_ += (-r.constant / (2.0 * r.slope)) * r.axes[2];
        const double sign = r.rank > 0 && r.lambda[0] > 0.0 ? -1.0 : 1.0;
        if (r.rank > 0) axes_[2] *= sign / (2.0 * r.slope);
    }
}

int QuadricForm::n_sheets() const
{
    switch (kind_) {
        case QuadricKind::Everything:
        case QuadricKind::Nothing:
            return 0;
        case QuadricKind::PlanePair:
        case QuadricKind::ParallelPlanes:
        case QuadricKind::HyperbolicCylinder:
        case QuadricKind::TwoSheetHyperboloid:
            return 2;
        default:
            return 1;
    }
}

Vec3 QuadricForm::point(double u, double v, int sheet) const
{
    require(sheet >= 0 && sheet < n_sheets(), "quadric: sheet", sheet, "one the surface has");
    const double side = sheet == 0 ? 1.0 : -1.0;
    const auto at = [&](double x, double y, double z) {
        return center_ + x * axes_[0] + y * axes_[1] + z * axes_[2];
    };
    switch (kind_) {
        case QuadricKind::Ellipsoid:
            return at(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v));
        case QuadricKind::EllipticCylinder:
            return at(std::cos(u), std::sin(u), v);
        case QuadricKind::Cone:
            return at(v * std::cos(u), v * std::sin(u), v);
        case QuadricKind::OneSheetHyperboloid:
            return at(std::cosh(v) * std::cos(u), std::cosh(v) * std::sin(u), std::sinh(v));
        case QuadricKind::TwoSheetHyperboloid:
            return at(std::sinh(v) * std::cos(u), std::sinh(v) * std::sin(u), side * std::cosh(v));
        case QuadricKind::EllipticParaboloid:
            return at(v * std::cos(u), v * std::sin(u), v * v);
        case QuadricKind::HyperbolicParaboloid:
            return at(u, v, u * u - v * v);
        case QuadricKind::ParabolicCylinder:
            return at(v, u, v * v);
        case QuadricKind::HyperbolicCylinder:
            return at(side * std::cosh(v), std::sinh(v), u);
        case QuadricKind::PlanePair:
            return at(v, side * v, u);
        case QuadricKind::ParallelPlanes:
            return at(side, u, v);
        case QuadricKind::DoublePlane:
            return at(0.0, u, v);
        case QuadricKind::HalfSpace:
            return at(u, v, 0.0);
        case QuadricKind::Line:
            return at(0.0, 0.0, v);
        default:
            return center_;
    }
}

Vec3 QuadricForm::normal(double u, double v, int sheet) const
{
    return normalized(quadric_.gradient(point(u, v, sheet)));
}

QuadricKind classify(const Quadric& quadric)
{
    return QuadricForm(quadric).kind();
}

std::string to_string(QuadricKind kind)
{
    switch (kind) {
        case QuadricKind::Everything:
            return "everything";
        case QuadricKind::Nothing:
            return "nothing";
        case QuadricKind::HalfSpace:
            return "half-space";
        case QuadricKind::PlanePair:
            return "pair of planes";
        case QuadricKind::ParallelPlanes:
            return "parallel planes";
        case QuadricKind::DoublePlane:
            return "double plane";
        case QuadricKind::Line:
            return "line";
        case QuadricKind::Point:
            return "point";
        case QuadricKind::Ellipsoid:
            return "ellipsoid";
        case QuadricKind::EllipticCylinder:
            return "elliptic cylinder";
        case QuadricKind::HyperbolicCylinder:
            return "hyperbolic cylinder";
        case QuadricKind::ParabolicCylinder:
            return "parabolic cylinder";
        case QuadricKind::Cone:
            return "cone";
        case QuadricKind::EllipticParaboloid:
            return "elliptic paraboloid";
        case QuadricKind::HyperbolicParaboloid:
            return "hyperbolic paraboloid";
        case QuadricKind::OneSheetHyperboloid:
            return "hyperboloid of one sheet";
        case QuadricKind::TwoSheetHyperboloid:
            return "hyperboloid of two sheets";
    }
    return "unknown";
}

}  // namespace genus
