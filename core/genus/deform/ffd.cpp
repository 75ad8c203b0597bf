#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/deform/ffd_bulk.h"
#include "genus/deform/lattice_net.h"

namespace genus {

using namespace lattice;

Lattice::Lattice(const Vec3& origin, const Columns3& axes, const std::array<int, 3>& counts,
                 std::vector<KnotVector> knots)
    : origin_(origin), axes_(axes), counts_(counts), knots_(std::move(knots))
{
    require(is_finite(origin), "Lattice: the origin is not finite");
    double lengths = 1.0;
    for (const Vec3& a : axes) {
        require(is_finite(a), "Lattice: an axis is not finite");
        lengths *= norm(a);
    }
    require(lengths > 0.0 && std::fabs(determinant(axes)) > 1e-12 * lengths,
            "Lattice: the axes must be independent");
    std::size_t count = 1;
    for (const int n : counts) {
        require(n >= 2 && n <= (1 << 20), "Lattice: number of control points along an axis", n,
                "at least 2");
        count *= at(n);
        require(count <= (std::size_t{1} << 22), "Lattice: more than 2^22 control points");
    }
    inverse_axes_ = inverted(axes_);
    double reach = norm(origin_);
    for (const Vec3& a : axes_) reach += norm(a);
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
            slack_[r] += 4.0 * kEpsilon * reach * std::fabs(inverse_axes_[c][r]);
    moves_.resize(count);
}

Lattice::Lattice(const Vec3& origin, const Columns3& axes, const std::array<int, 3>& degree)
    : Lattice(origin, axes, {degree[0] + 1, degree[1] + 1, degree[2] + 1},
              std::vector<KnotVector>())
{
    for (const int d : degree)
        require(d >= 1 && d <= bulk::kMaxFfdDegree, "Lattice: degree", d, "in [1, 64]");
}

Lattice Lattice::bspline(const Vec3& origin, const Columns3& axes, const std::array<int, 3>& counts,
                         int degree)
{
    require(degree >= 1 && degree <= 15, "Lattice::bspline: degree", degree, "in [1, 15]");
    double count = 1.0;
    for (const int n : counts) {
        require(n > degree, "Lattice::bspline: number of control points", n, "above the degree");
        count *= n;
    }
    require(count <= 0x1p22, "Lattice::bspline: number of control points", count, "at most 2^22");
    std::vector<KnotVector> knots;
    for (const int n : counts) knots.push_back(KnotVector::clamped(degree, n));
    return Lattice(origin, axes, counts, std::move(knots));
}

Lattice Lattice::over(const Box3& box, const std::array<int, 3>& degree)
{
    require(!box.empty() && box.bounded(), "Lattice::over: the box is empty or unbounded");
    const Vec3 s = box.size();
    return Lattice(box.min, {Vec3{{s[0], 0, 0}}, Vec3{{0, s[1], 0}}, Vec3{{0, 0, s[2]}}}, degree);
}

int Lattice::degree(int axis) const
{
    return is_bspline() ? knots_[at(axis)].degree() : counts_[at(axis)] - 1;
}

Vec3 Lattice::rest(int i, int j, int k) const
{
    const std::array<int, 3> index = {i, j, k};
    Vec3 s;
    for (std::size_t a = 0; a < 3; ++a) {
        if (!is_bspline()) {
            s[a] = static_cast<double>(index[a]) / (counts_[a] - 1);
            continue;
        }
        // Greville's abscissa: with these a spline reproduces the identity.
        const int p = knots_[a].degree();
        for (int r = 1; r <= p; ++r) s[a] += knots_[a][at(index[a] + r)];
        s[a] /= p;
    }
    return global(s);
}

void Lattice::set_point(int i, int j, int k, const Vec3& p)
{
    const bool inside =
        i >= 0 && i < counts_[0] && j >= 0 && j < counts_[1] && k >= 0 && k < counts_[2];
    require(inside, "Lattice::set_point: there is no such control point");
    require(is_finite(p), "Lattice::set_point: a coordinate is not finite");
    moves_[index(i, j, k)] = p - rest(i, j, k);
}

std::vector<Vec3> Lattice::points() const
{
    std::vector<Vec3> all;
    all.reserve(moves_.size());
    for (int i = 0; i < counts_[0]; ++i)
        for (int j = 0; j < counts_[1]; ++j)
            for (int k = 0; k < counts_[2]; ++k) all.push_back(point(i, j, k));
    return all;
}

void Lattice::set_points(std::span<const Vec3> points)
{
    require(points.size() == moves_.size(), "Lattice::set_points: number of points",
            static_cast<double>(points.size()), "that of the lattice");
    std::vector<Vec3> moves;
    std::size_t next = 0;
    for (int i = 0; i < counts_[0]; ++i)
        for (int j = 0; j < counts_[1]; ++j)
            for (int k = 0; k < counts_[2]; ++k) moves.push_back(points[next++] - rest(i, j, k));
    set_moves(std::move(moves));
}

void Lattice::set_moves(std::vector<Vec3> moves)
{
    require(moves.size() == moves_.size(), "Lattice::set_moves: number of moves",
            static_cast<double>(moves.size()), "that of the control points");
    for (const Vec3& d : moves) require(is_finite(d), "Lattice::set_moves: a move is not finite");
    moves_ = std::move(moves);
}

void Lattice::keep_border(int k)
{
    for (int i = 0; i < counts_[0]; ++i)
        for (int j = 0; j < counts_[1]; ++j)
            for (int l = 0; l < counts_[2]; ++l) {
                const int layer =
                    std::min({i, j, l, counts_[0] - 1 - i, counts_[1] - 1 - j, counts_[2] - 1 - l});
                if (layer <= k) moves_[index(i, j, l)] = {};
            }
}

int Lattice::border_continuity() const
{
    int least = std::max({counts_[0], counts_[1], counts_[2]});
    for (int i = 0; i < counts_[0]; ++i)
        for (int j = 0; j < counts_[1]; ++j)
            for (int l = 0; l < counts_[2]; ++l)
                if (moves_[index(i, j, l)] != Vec3{})
                    least = std::min({least, i, j, l, counts_[0] - 1 - i, counts_[1] - 1 - j,
                                      counts_[2] - 1 - l});
    return least - 1;
}

Vec3 Lattice::local(const Vec3& x) const
{
    // Rows of the inverse against x - origin, in the order of the bulk loop.
    const Vec3 e = x - origin_;
    Vec3 s;
    for (std::size_t r = 0; r < 3; ++r) {
        s[r] = e[0] * inverse_axes_[0][r] + e[1] * inverse_axes_[1][r] + e[2] * inverse_axes_[2][r];
        if (s[r] < 0.0 && s[r] >= -slack_[r]) s[r] = 0.0;
        if (s[r] > 1.0 && s[r] <= 1.0 + slack_[r]) s[r] = 1.0;
    }
    return s;
}

Vec3 Lattice::global(const Vec3& stu) const
{
    return origin_ + times(axes_, stu);
}

Lattice::AxisBasis Lattice::axis_basis(int axis, double t, bool with_slope) const
{
    if (is_bspline()) {
        const KnotVector& knots = knots_[at(axis)];
        const int k = knots.span(t);
        auto rows = knots.basis_derivatives(k, t, with_slope ? 1 : 0);
        return {k - knots.degree(), std::move(rows[0]),
                with_slope ? std::move(rows[1]) : std::vector<double>()};
    }
    const int n = counts_[at(axis)] - 1;
    AxisBasis b{0, bernstein::basis(n, t), {}};
    if (!with_slope) return b;
    const auto lower = bernstein::basis(n - 1, t);
    for (int i = 0; i <= n; ++i)
        b.slope.push_back(n * ((i > 0 ? lower[at(i) - 1] : 0.0) - (i < n ? lower[at(i)] : 0.0)));
    return b;
}

Vec3 Lattice::apply(const Vec3& x) const
{
    Vec3 y;
    apply(std::span(&x, 1), std::span(&y, 1));
    return y;
}

namespace {

// Values of the basis functions of a spline of degree p that act on span k, by Cox and de Boor.
void spline_basis(const KnotVector& knots, int k, double t, double* b)
{
    b[0] = 1.0;
    for (int d = 1; d <= knots.degree(); ++d) {
        double carry = 0.0;
        for (int i = 0; i < d; ++i) {
            const double lo = knots[at(k + 1 - d + i)], hi = knots[at(k + 1 + i)];
            const double share = b[i] / (hi - lo);
            b[i] = carry + (hi - t) * share;
            carry = (t - lo) * share;
        }
        b[d] = carry;
    }
}

}  // namespace

void Lattice::apply(std::span<const Vec3> x, std::span<Vec3> out) const
{
    require(x.size() == out.size(), "Lattice::apply: out must be as long as x");
    if (is_bspline()) {
        parallel_for(x.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
            double b[3][16];
            for (std::size_t p = begin; p < end; ++p) {
                const Vec3 s = local(x[p]);
                out[p] = x[p];
                if (!in_unit_cube(s)) continue;
                int first[3];
                for (std::size_t a = 0; a < 3; ++a) {
                    const int k = knots_[a].span(s[a]);
                    first[a] = k - knots_[a].degree();
                    spline_basis(knots_[a], k, s[a], b[a]);
                }
                Vec3 sum;
                for (int i = 0; i <= degree(0); ++i)
                    for (int j = 0; j <= degree(1); ++j) {
                        const Vec3* row = &moves_[index(first[0] + i, first[1] + j, first[2])];
                        Vec3 line;
                        for (int k = 0; k <= degree(2); ++k) line += b[2][k] * row[k];
                        sum += (b[0][i] * b[1][j]) * line;
                    }
                out[p] += sum;
            }
        });
        return;
    }
    bulk::FfdData f{};
    std::array<std::vector<double>, 3> choose;
    for (std::size_t a = 0; a < 3; ++a) {
        f.degree[a] = counts_[a] - 1;
        for (int k = 0; k < counts_[a]; ++k)
            choose[a].push_back(bernstein::binomial(counts_[a] - 1, k));
        f.choose[a] = choose[a].data();
        f.origin[a] = origin_[a];
        f.slack[a] = slack_[a];
        for (std::size_t r = 0; r < 3; ++r) f.inverse[r][a] = inverse_axes_[a][r];
    }
    f.moves = moves_[0].c.data();
    parallel_for(x.size(), 1 << 13, [&](std::size_t begin, std::size_t end) {
        bulk::deform(f, x[begin].c.data(), end - begin, out[begin].c.data());
    });
}

double Lattice::rounding() const
{
    double largest = 0.0, size = norm(origin_);
    for (const Vec3& d : moves_) largest = std::max(largest, norm(d));
    for (const Vec3& a : axes_) size += norm(a);
    double stretch = 1.0;
    for (std::size_t a = 0; a < 3; ++a) {
        // (s, t, u) err by the rounding of x - origin and of three products, magnified by the
        // inverse axes; the moves change at most by twice the degree times that.
        double row = 0.0;
        for (std::size_t c = 0; c < 3; ++c) row += std::fabs(inverse_axes_[c][a]);
        stretch += 2.0 * degree(static_cast<int>(a)) * row * size * 4.0;
    }
    double roundings = 8.0;
    for (int a = 0; a < 3; ++a) roundings += 4.0 * degree(a) + 4.0;
    return kEpsilon * (size + largest * (roundings + stretch));
}

std::vector<double> Lattice::weights(const Vec3& x, const std::optional<Vec3>& direction) const
{
    std::vector<double> w(moves_.size());
    const Vec3 s = local(x);
    if (!in_unit_cube(s)) return w;
    std::array<AxisBasis, 3> b;
    for (int a = 0; a < 3; ++a) b[at(a)] = axis_basis(a, s[at(a)], direction.has_value());
    const Vec3 v = direction ? times(inverse_axes_, *direction) : Vec3{};
    for (std::size_t i = 0; i < b[0].value.size(); ++i)
        for (std::size_t j = 0; j < b[1].value.size(); ++j)
            for (std::size_t k = 0; k < b[2].value.size(); ++k) {
                double& entry =
                    w[index(b[0].first + static_cast<int>(i), b[1].first + static_cast<int>(j),
                            b[2].first + static_cast<int>(k))];
                if (!direction) {
                    entry = b[0].value[i] * b[1].value[j] * b[2].value[k];
                    continue;
                }
                entry = v[0] * b[0].slope[i] * b[1].value[j] * b[2].value[k] +
                        v[1] * b[0].value[i] * b[1].slope[j] * b[2].value[k] +
                        v[2] * b[0].value[i] * b[1].value[j] * b[2].slope[k];
            }
    return w;
}

// Derivative of the map by (s, t, u): the axes and that of the moves.
Columns3 Lattice::local_derivative(const Vec3& s) const
{
    std::array<AxisBasis, 3> b;
    for (int a = 0; a < 3; ++a) b[at(a)] = axis_basis(a, s[at(a)], true);
    Columns3 d = axes_;
    for (std::size_t i = 0; i < b[0].value.size(); ++i)
        for (std::size_t j = 0; j < b[1].value.size(); ++j) {
            Vec3 value, slope;
            const Vec3* row = &moves_[index(b[0].first + static_cast<int>(i),
                                            b[1].first + static_cast<int>(j), b[2].first)];
            for (std::size_t k = 0; k < b[2].value.size(); ++k) {
                value += b[2].value[k] * row[k];
                slope += b[2].slope[k] * row[k];
            }
            d[0] += (b[0].slope[i] * b[1].value[j]) * value;
            d[1] += (b[0].value[i] * b[1].slope[j]) * value;
            d[2] += (b[0].value[i] * b[1].value[j]) * slope;
        }
    return d;
}

Columns3 Lattice::jacobian(const Vec3& x) const
{
    const Vec3 s = local(x);
    if (!in_unit_cube(s)) return {Vec3{{1, 0, 0}}, Vec3{{0, 1, 0}}, Vec3{{0, 0, 1}}};
    const Columns3 d = local_derivative(s);
    return {times(d, inverse_axes_[0]), times(d, inverse_axes_[1]), times(d, inverse_axes_[2])};
}

IndexedMesh deformed(IndexedMesh mesh, const Lattice& lattice)
{
    lattice.apply(mesh.vertices, mesh.vertices);
    return mesh;
}

PolygonMesh deformed(PolygonMesh mesh, const Lattice& lattice)
{
    lattice.apply(mesh.vertices, mesh.vertices);
    return mesh;
}

namespace {

std::vector<Vec3> images(const std::vector<Vec3>& points, const Lattice& lattice)
{
    std::vector<Vec3> result(points.size());
    lattice.apply(points, result);
    return result;
}

}  // namespace

BezierCurve deformed(const BezierCurve& curve, const Lattice& lattice)
{
    return BezierCurve(images(curve.points(), lattice), curve.weights());
}

BSpline deformed(const BSpline& curve, const Lattice& lattice)
{
    return BSpline(images(curve.points(), lattice), curve.knots(), curve.weights());
}

TensorPatch deformed(const TensorPatch& patch, const Lattice& lattice)
{
    return TensorPatch(patch.degree_u(), patch.degree_v(), images(patch.points(), lattice),
                       patch.weights());
}

BezierTriangle deformed(const BezierTriangle& patch, const Lattice& lattice)
{
    return BezierTriangle(patch.degree(), images(patch.points(), lattice), patch.weights());
}

BSplineSurface deformed(const BSplineSurface& surface, const Lattice& lattice)
{
    return BSplineSurface(surface.knots_u(), surface.knots_v(), images(surface.points(), lattice),
                          surface.weights());
}

}  // namespace genus
