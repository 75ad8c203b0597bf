#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/deform/ffd_bulk.h"

namespace genus {

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

double determinant(const Columns3& m)
{
    return dot(m[0], cross(m[1], m[2]));
}

Vec3 times(const Columns3& m, const Vec3& v)
{
    return v[0] * m[0] + v[1] * m[1] + v[2] * m[2];
}

// Columns of the inverse.
Columns3 inverted(const Columns3& m)
{
    const double d = determinant(m);
    const Vec3 r0 = cross(m[1], m[2]) / d, r1 = cross(m[2], m[0]) / d, r2 = cross(m[0], m[1]) / d;
    return {Vec3{{r0[0], r1[0], r2[0]}}, Vec3{{r0[1], r1[1], r2[1]}}, Vec3{{r0[2], r1[2], r2[2]}}};
}

bool in_unit_cube(const Vec3& s)
{
    return Box3{{}, {{1, 1, 1}}}.contains(s);
}

// Coefficients c_ijk of three variables, the last index running fastest.
template <class V>
struct Net3 {
    std::array<int, 3> n;  // numbers of coefficients, degree + 1
    std::vector<V> c;

    std::size_t stride(int axis) const
    {
        return axis == 2 ? 1 : axis == 1 ? at(n[2]) : at(n[1]) * at(n[2]);
    }
    // First coefficients of all lines along an axis.
    template <class F>
    void for_lines(int axis, const F& f) const
    {
        const std::size_t step = stride(axis), length = step * at(n[at(axis)]);
        for (std::size_t block = 0; block < c.size(); block += length)
            for (std::size_t k = 0; k < step; ++k) f(block + k);
    }
};

// Applies f, which maps the coefficients of a line to those of another, to all lines.
template <class V, class F>
Net3<V> by_lines(const Net3<V>& net, int axis, const F& f)
{
    const std::size_t step = net.stride(axis);
    std::vector<V> line(at(net.n[at(axis)]));
    Net3<V> result{net.n, {}};
    net.for_lines(axis, [&](std::size_t first) {
        for (std::size_t k = 0; k < line.size(); ++k) line[k] = net.c[first + k * step];
        const std::vector<V> image = f(line);
        if (result.c.empty()) {
            result.n[at(axis)] = static_cast<int>(image.size());
            result.c.resize(net.c.size() / line.size() * image.size());
        }
        // The same line in the new net: only the count along the axis has changed.
        const std::size_t outer = first / (step * line.size()), inner = first % step;
        const std::size_t new_first = outer * step * image.size() + inner;
        for (std::size_t k = 0; k < image.size(); ++k) result.c[new_first + k * step] = image[k];
    });
    return result;
}

template <class V>
Net3<V> part_of(Net3<V> net, const Box3& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double a = box.min[at(axis)], b = box.max[at(axis)];
        if (a == 0.0 && b == 1.0) continue;
        net = by_lines(net, axis, [&](const std::vector<V>& line) {
            return bernstein::segment<V>(line, a, b);
        });
    }
    return net;
}

template <class V>
Net3<V> derivative_of(const Net3<V>& net, int axis)
{
    return by_lines(net, axis,
                    [](const std::vector<V>& line) { return bernstein::derivative<V>(line); });
}

}  // namespace

// A part of the lattice on which the map is one polynomial: its box in (s, t, u), and the image as
// Bernstein coefficients over that box.
struct Lattice::Piece {
    Box3 box;
    Net3<Vec3> net;

    /// (s, t, u) relative to the box.
    Box3 relative(const Box3& b) const
    {
        Box3 r;
        for (std::size_t k = 0; k < 3; ++k) {
            r.min[k] = (b.min[k] - box.min[k]) / (box.max[k] - box.min[k]);
            r.max[k] = (b.max[k] - box.min[k]) / (box.max[k] - box.min[k]);
        }
        return r;
    }
};

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

std::vector<Lattice::Piece> Lattice::pieces() const
{
    Net3<Vec3> net{counts_, points()};
    if (!is_bspline()) return {Piece{Box3{{}, {{1, 1, 1}}}, std::move(net)}};
    std::array<std::vector<double>, 3> cuts;
    for (int a = 0; a < 3; ++a) {
        const KnotVector& from = knots_[at(a)];
        KnotVector to = from;
        for (const int k : from.spans()) {
            cuts[at(a)].push_back(from[at(k)]);
            if (from[at(k)] > from.begin())
                to = to.with(from[at(k)], from.degree() - from.multiplicity(from[at(k)]));
        }
        cuts[at(a)].push_back(from.end());
        const KnotRefinement r = refinement(from, to);
        net = by_lines(net, a, [&](const std::vector<Vec3>& line) {
            std::vector<Vec3> image;
            for (const auto& row : r.rows) {
                Vec3 sum;
                for (std::size_t j = 0; j < row.weights.size(); ++j)
                    sum += row.weights[j] * line[at(row.first) + j];
                image.push_back(sum);
            }
            return image;
        });
    }
    std::vector<Piece> all;
    const int p = degree(0);
    for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i)
        for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j)
            for (std::size_t k = 0; k + 1 < cuts[2].size(); ++k) {
                Piece piece{{{{cuts[0][i], cuts[1][j], cuts[2][k]}},
                             {{cuts[0][i + 1], cuts[1][j + 1], cuts[2][k + 1]}}},
                            {{p + 1, p + 1, p + 1}, {}}};
                const auto first = std::array{i * at(p), j * at(p), k * at(p)};
                for (std::size_t a = 0; a <= at(p); ++a)
                    for (std::size_t b = 0; b <= at(p); ++b)
                        for (std::size_t c = 0; c <= at(p); ++c)
                            piece.net.c.push_back(
                                net.c[((first[0] + a) * at(net.n[1]) + first[1] + b) *
                                          at(net.n[2]) +
                                      first[2] + c]);
                all.push_back(std::move(piece));
            }
    return all;
}

namespace {

// Coefficients times binomials: products of polynomials are then plain convolutions.
Net3<double> scaled(Net3<double> net, bool back)
{
    std::array<std::vector<double>, 3> b;
    for (std::size_t a = 0; a < 3; ++a)
        for (int k = 0; k < net.n[a]; ++k) b[a].push_back(bernstein::binomial(net.n[a] - 1, k));
    std::size_t next = 0;
    for (const double x : b[0])
        for (const double y : b[1])
            for (const double z : b[2]) {
                const double factor = x * y * z;
                net.c[next] = back ? net.c[next] / factor : net.c[next] * factor;
                ++next;
            }
    return net;
}

// a b added to the product; all scaled. Also the sum of magnitudes, for the rounding.
void add_product(const Net3<double>& a, const Net3<double>& b, double sign, Net3<double>& product)
{
    for (int i = 0; i < a.n[0]; ++i)
        for (int j = 0; j < a.n[1]; ++j)
            for (int k = 0; k < a.n[2]; ++k) {
                const double x = sign * a.c[(at(i) * at(a.n[1]) + at(j)) * at(a.n[2]) + at(k)];
                if (x == 0.0) continue;
                for (int l = 0; l < b.n[0]; ++l)
                    for (int m = 0; m < b.n[1]; ++m) {
                        const double* from = &b.c[(at(l) * at(b.n[1]) + at(m)) * at(b.n[2])];
                        double* to =
                            &product
                                 .c[(at(i + l) * at(product.n[1]) + at(j + m)) * at(product.n[2]) +
                                    at(k)];
                        for (int n = 0; n < b.n[2]; ++n) to[n] += x * from[n];
                    }
            }
}

Net3<double> empty_product(const Net3<double>& a, const Net3<double>& b)
{
    Net3<double> p{{a.n[0] + b.n[0] - 1, a.n[1] + b.n[1] - 1, a.n[2] + b.n[2] - 1}, {}};
    p.c.resize(at(p.n[0]) * at(p.n[1]) * at(p.n[2]));
    return p;
}

double work_of(const Net3<double>& a, const Net3<double>& b)
{
    return static_cast<double>(a.c.size()) * static_cast<double>(b.c.size());
}

struct Determinant {
    Net3<double> net;  // Bernstein coefficients
    double noise;      // what rounding may have added to one
};

// det (F_s, F_t, F_u) over the piece.
Determinant determinant_of(const Net3<Vec3>& f)
{
    std::array<std::array<Net3<double>, 3>, 3> d;  // [variable][coordinate], scaled
    double magnitude = 6.0;
    for (int a = 0; a < 3; ++a) {
        const auto slope = derivative_of(f, a);
        double largest = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            Net3<double> part{slope.n, {}};
            for (const Vec3& v : slope.c) part.c.push_back(v[c]);
            for (const double x : part.c) largest = std::max(largest, std::fabs(x));
            d[at(a)][c] = scaled(std::move(part), false);
        }
        magnitude *= largest;
    }
    const auto first = empty_product(d[1][0], d[2][0]);
    require(work_of(d[0][0], first) <= 2e9, "Lattice::folds: the degree is too high");
    Net3<double> sum = empty_product(d[0][0], first);
    for (std::size_t c = 0; c < 3; ++c) {
        current_progress().check();
        Net3<double> minor = first;
        const std::size_t p = (c + 1) % 3, q = (c + 2) % 3;
        add_product(d[1][p], d[2][q], 1.0, minor);
        add_product(d[1][q], d[2][p], -1.0, minor);
        add_product(d[0][c], minor, 1.0, sum);
    }
    // Every coefficient is a mean of products, so its rounding is relative to the largest ones.
    const double terms = f.n[0] + f.n[1] + f.n[2];
    return {scaled(std::move(sum), true), 8.0 * kEpsilon * terms * magnitude};
}

struct SignBox {
    Net3<double> net;
    Box3 box;
};

}  // namespace

FoldReport Lattice::folds(int max_boxes) const
{
    const double orientation = determinant(axes_);
    FoldReport report;
    report.determinant = std::numeric_limits<double>::infinity();
    int boxes = 0;
    for (const Piece& piece : pieces()) {
        double cell = 1.0;  // derivatives by the piece's own parameters are smaller by this
        for (std::size_t k = 0; k < 3; ++k) cell *= piece.box.max[k] - piece.box.min[k];
        const double scale = orientation * cell;
        const Determinant det = determinant_of(piece.net);
        const double noise = det.noise / std::fabs(scale);
        std::vector<SignBox> stack = {{det.net, piece.box}};
        for (double& x : stack[0].net.c) x /= scale;
        while (!stack.empty()) {
            current_progress().check();
            SignBox b = std::move(stack.back());
            stack.pop_back();
            const double least = *std::min_element(b.net.c.begin(), b.net.c.end());
            if (least > noise) {
                report.determinant = std::min(report.determinant, least - noise);
                continue;
            }
            // Corner coefficients are values.
            for (int corner = 0; corner < 8; ++corner) {
                std::size_t i = 0;
                Vec3 s;
                for (std::size_t a = 0; a < 3; ++a) {
                    const bool high = (corner >> a & 1) != 0;
                    i += high ? b.net.stride(static_cast<int>(a)) * at(b.net.n[a] - 1) : 0;
                    s[a] = high ? b.box.max[a] : b.box.min[a];
                }
                if (b.net.c[i] >= -noise) continue;
                // Slightly inside, so that rounding does not carry the place over the border.
                const Vec3 inside = bernstein::mix(s, b.box.center(), 0x1p-30);
                const double there = determinant(local_derivative(inside)) / orientation;
                if (there < 0.0) return {FoldReport::Kind::Folded, global(inside), there};
            }
            if (++boxes > max_boxes) {
                report.kind = FoldReport::Kind::Undecided;
                report.where = global(b.box.center());
                report.determinant = least;
                return report;
            }
            const Vec3 size = b.box.size();
            const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0
                             : size[1] >= size[2]                     ? 1
                                                                      : 2;
            for (const bool upper : {false, true}) {
                SignBox half{{}, b.box};
                (upper ? half.box.min : half.box.max)[at(axis)] = b.box.center()[at(axis)];
                half.net = by_lines(b.net, axis, [&](const std::vector<double>& line) {
                    std::vector<double> low, high;
                    bernstein::split<double>(line, 0.5, low, high);
                    return upper ? high : low;
                });
                stack.push_back(std::move(half));
            }
        }
    }
    return report;
}

std::optional<Vec3> Lattice::newton(const Vec3& y, Vec3 s, int& steps) const
{
    const double goal = std::max(rounding(), 4.0 * kEpsilon * norm(y));
    // Inside the lattice only, with steps cut where they would leave it or make things worse.
    const auto clamped = [](Vec3 p) {
        for (std::size_t k = 0; k < 3; ++k) p[k] = std::clamp(p[k], 0.0, 1.0);
        return p;
    };
    const auto image = [&](const Vec3& p) {
        Vec3 sum = global(p);
        std::array<AxisBasis, 3> b;
        for (int a = 0; a < 3; ++a) b[at(a)] = axis_basis(a, p[at(a)], false);
        for (std::size_t i = 0; i < b[0].value.size(); ++i)
            for (std::size_t j = 0; j < b[1].value.size(); ++j) {
                const Vec3* row = &moves_[index(b[0].first + static_cast<int>(i),
                                                b[1].first + static_cast<int>(j), b[2].first)];
                Vec3 line;
                for (std::size_t k = 0; k < b[2].value.size(); ++k) line += b[2].value[k] * row[k];
                sum += (b[0].value[i] * b[1].value[j]) * line;
            }
        return sum;
    };
    s = clamped(s);
    Vec3 e = image(s) - y;
    for (int step = 0; step < 50; ++step) {
        const Columns3 d = local_derivative(s);
        if (determinant(d) == 0.0) return std::nullopt;
        const Vec3 move = times(inverted(d), e);
        if (!is_finite(move)) return std::nullopt;
        ++steps;
        Vec3 next, there;
        bool better = false;
        for (double share = 1.0; share > 1e-3 && !better; share *= 0.5) {
            next = clamped(s - share * move);
            there = image(next) - y;
            better = norm(there) < norm(e);
        }
        if (!better) break;
        s = next;
        e = there;
        if (norm(e) <= 0.25 * goal) break;
    }
    if (norm(e) <= 4.0 * goal) return s;
    return std::nullopt;
}

std::array<IntervalVec3, 3> Lattice::derivative_bounds(const std::vector<Piece>& all,
                                                       const Box3& box) const
{
    std::array<IntervalVec3, 3> result;
    bool any = false;
    for (const Piece& piece : all) {
        if (is_bspline() && !overlap(piece.box, box)) continue;
        const Net3<Vec3> net = part_of(piece.net, piece.relative(box));
        for (int a = 0; a < 3; ++a) {
            const auto slope = derivative_of(net, a);
            const double width = box.max[at(a)] - box.min[at(a)];
            for (std::size_t c = 0; c < 3; ++c) {
                Interval range(slope.c[0][c]);
                double largest = 0.0;
                for (const Vec3& v : slope.c) range = hull(range, Interval(v[c]));
                for (const Vec3& v : net.c) largest = std::max(largest, std::fabs(v[c]));
                // Cutting out the part rounds its coefficients; a difference feels that divided
                // by the width.
                const double slack = 16.0 * kEpsilon * (net.n[0] + net.n[1] + net.n[2]) * largest *
                                     (net.n[at(a)] - 1);
                range = Interval((range.lo - slack) / width, (range.hi + slack) / width);
                result[at(a)][c] = any ? hull(result[at(a)][c], range) : range;
            }
        }
        any = true;
    }
    return result;
}

// Krawczyk: x - Y (F(x) - y) + (I - Y F'(X)) (X - x) inside X proves one solution in X. Returns
// the radius of X in (s, t, u), or infinity.
double Lattice::certify(const Vec3& y, const Vec3& s) const
{
    const Columns3 inverse_slope = inverted(local_derivative(s));
    const Vec3 x = global(s);
    const Vec3 e = apply(x) - y;
    const double slack = 2.0 * rounding() + 4.0 * kEpsilon * norm(y);
    Vec3 step;  // bound of |Y (F(x) - y)| by coordinates
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c)
            step[r] += std::fabs(inverse_slope[c][r]) * (std::fabs(e[c]) + slack);
    const double least = std::max({step[0], step[1], step[2]}) * 2.0 + 1e-12;
    const std::vector<Piece> all = pieces();
    for (double radius = least; radius <= 1e3 * least && radius < 0.25; radius *= 10.0) {
        const Box3 box = Box3{s, s}.inflated(radius);
        const auto d = derivative_bounds(all, box);
        bool inside = true;
        for (std::size_t r = 0; r < 3 && inside; ++r) {
            Interval reach;
            for (std::size_t c = 0; c < 3; ++c) {
                Interval entry(r == c ? 1.0 : 0.0);
                for (std::size_t k = 0; k < 3; ++k)
                    entry = entry - Interval(inverse_slope[k][r]) * d[c][k];
                reach = reach + Interval(entry.magnitude()) * Interval(radius);
            }
            inside = (reach + Interval(step[r])).hi < radius;
        }
        if (inside) return radius;
    }
    return std::numeric_limits<double>::infinity();
}

std::optional<Vec3> Lattice::solve(const Vec3& y, const Vec3& x) const
{
    int steps = 0;
    const auto s = newton(y, local(x), steps);
    return s ? std::optional(global(*s)) : std::nullopt;
}

// The part of the lattice that a box of space may meet.
Box3 Lattice::local_box(const Box3& x) const
{
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1) != 0 ? x.max[k] : x.min[k];
        box.add(local(p));
    }
    return intersection(box.inflated(16.0 * kEpsilon), Box3{{}, {{1, 1, 1}}});
}

Box3 Lattice::image_bounds(const Box3& x) const
{
    Box3 image;
    bool whole = true;  // the box lies in the lattice
    for (int corner = 0; corner < 8; ++corner) {
        Vec3 p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1) != 0 ? x.max[k] : x.min[k];
        whole = whole && in_unit_cube(local(p));
    }
    if (!whole) image.add(x);
    const Box3 inside = local_box(x);
    if (!inside.empty()) image.add(image_of_local(inside));
    return image;
}

Box3 Lattice::image_of_local(const Box3& stu) const
{
    Box3 image;
    for (const Piece& piece : pieces()) {
        const Box3 common = intersection(piece.box, stu);
        if (common.empty()) continue;
        // A box that only touches a piece is widened a little into it.
        const Box3 wide = intersection(common.inflated(1e-6), piece.box);
        for (const Vec3& p : part_of(piece.net, piece.relative(wide)).c) image.add(p);
    }
    return image.empty() ? image : image.inflated(rounding());
}

namespace {

// At least the largest singular value.
double largest_stretch(const Columns3& m)
{
    double rows = 0.0, columns = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        double row = 0.0, column = 0.0;
        for (std::size_t j = 0; j < 3; ++j) {
            row += std::fabs(m[j][i]);
            column += std::fabs(m[i][j]);
            squares += m[i][j] * m[i][j];
        }
        rows = std::max(rows, row);
        columns = std::max(columns, column);
    }
    return std::min(std::sqrt(rows * columns), std::sqrt(squares)) * (1.0 + 8.0 * kEpsilon);
}

// Of a matrix somewhere between those with entries `d` times `inverse`.
double largest_stretch(const std::array<IntervalVec3, 3>& d, const Columns3& inverse)
{
    Columns3 middle, radius;
    for (std::size_t column = 0; column < 3; ++column)
        for (std::size_t c = 0; c < 3; ++c) {
            Interval sum(0.0);
            for (std::size_t a = 0; a < 3; ++a) sum = sum + d[a][c] * Interval(inverse[column][a]);
            middle[column][c] = sum.mid();
            radius[column][c] = 0.5 * (sum.hi - sum.lo);
        }
    return largest_stretch(middle) + largest_stretch(radius);
}

}  // namespace

double Lattice::stretch(const Box3& x) const
{
    constexpr int kParts = 4;  // along each axis: bounds over small boxes are tight
    const Box3 inside = local_box(x);
    if (inside.empty()) return 1.0;
    const Vec3 size = inside.size() / kParts;
    const std::vector<Piece> all = pieces();
    double largest = in_unit_cube(local(x.min)) && in_unit_cube(local(x.max)) ? 0.0 : 1.0;
    for (int part = 0; part < kParts * kParts * kParts; ++part) {
        const std::array<int, 3> at = {part / (kParts * kParts), part / kParts % kParts,
                                       part % kParts};
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::clamp(inside.min[k] + at[k] * size[k] - 1e-9, 0.0, 1.0 - 1e-6);
            box.max[k] = std::clamp(inside.min[k] + (at[k] + 1) * size[k] + 1e-9, 1e-6, 1.0);
        }
        largest = std::max(largest, largest_stretch(derivative_bounds(all, box), inverse_axes_));
    }
    return largest;
}

std::vector<std::array<double, 6>> Lattice::second_bounds(int n) const
{
    require(n >= 1 && n <= 256, "Lattice::second_bounds: boxes an axis", n, "in [1, 256]");
    constexpr std::array<std::array<int, 2>, 6> kPairs = {
        {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};
    const std::vector<Piece> all = pieces();
    std::vector<std::array<double, 6>> result(at(n) * at(n) * at(n));
    for (std::size_t i = 0; i < result.size(); ++i) {
        current_progress().check();
        const std::array<std::size_t, 3> place = {i / (at(n) * at(n)), i / at(n) % at(n),
                                                  i % at(n)};
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = static_cast<double>(place[k]) / n;
            box.max[k] = static_cast<double>(place[k] + 1) / n;
        }
        for (const Piece& piece : all) {
            const Box3 common = intersection(piece.box, box);
            if (common.empty()) continue;
            // A box that only touches a piece is widened a little into it.
            Box3 wide = intersection(common.inflated(0.5e-3 / n), piece.box);
            const Net3<Vec3> net = part_of(piece.net, piece.relative(wide));
            double coordinates = 0.0;
            for (const Vec3& p : net.c) coordinates = std::max(coordinates, norm(p));
            for (std::size_t pair = 0; pair < 6; ++pair) {
                const auto [a, b] = kPairs[pair];
                const double width = wide.size()[at(a)] * wide.size()[at(b)];
                double largest = 0.0;
                for (const Vec3& d : derivative_of(derivative_of(net, a), b).c)
                    largest = std::max(largest, norm(d));
                // Second differences of rounded coefficients.
                const double noise = 64.0 * kEpsilon * (net.n[0] + net.n[1] + net.n[2]) *
                                     coordinates * net.n[at(a)] * net.n[at(b)];
                result[i][pair] = std::max(result[i][pair], (largest + noise) / width);
            }
        }
    }
    return result;
}

std::vector<double> Lattice::kinks(int axis) const
{
    std::vector<double> places;
    if (!is_bspline()) return places;
    const KnotVector& knots = knots_[at(axis)];
    for (const int k : knots.spans()) {
        const double t = knots[at(k)];
        if (t > 0.0 && knots.multiplicity(t) >= knots.degree()) places.push_back(t);
    }
    return places;
}

InversePoint Lattice::inverse(const Vec3& y) const
{
    require(is_finite(y), "Lattice::inverse: the point is not finite");
    InversePoint result;
    const auto accept = [&](const Vec3& s) {
        result.point = global(s);
        result.found = true;
        const double radius = certify(y, s);
        result.certified = std::isfinite(radius);
        double size = 0.0;
        for (const Vec3& a : axes_) size += norm(a);
        result.bound = result.certified ? radius * size : std::numeric_limits<double>::infinity();
        return result;
    };
    if (const auto s = newton(y, local(y), result.steps)) return accept(*s);
    // Boxes of the lattice whose image may hold y, the largest first.
    struct Candidate {
        Net3<Vec3> net;
        Box3 box;
    };
    std::vector<Candidate> queue;
    for (Piece& piece : pieces()) queue.push_back({std::move(piece.net), piece.box});
    constexpr std::size_t kMaxCandidates = 4000;
    const double slack = rounding() + 4.0 * kEpsilon * norm(y);
    for (std::size_t next = 0; next < queue.size() && next < kMaxCandidates; ++next) {
        current_progress().check();
        const Candidate c = std::move(queue[next]);
        Box3 image;
        for (const Vec3& p : c.net.c) image.add(p);
        if (!image.inflated(slack).contains(y)) continue;
        if (const auto s = newton(y, c.box.center(), result.steps)) return accept(*s);
        const Vec3 size = c.box.size();
        const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
        if (size[at(axis)] < 0x1p-20) continue;
        for (const bool upper : {false, true}) {
            Candidate half{{}, c.box};
            (upper ? half.box.min : half.box.max)[at(axis)] = c.box.center()[at(axis)];
            half.net = by_lines(c.net, axis, [&](const std::vector<Vec3>& line) {
                std::vector<Vec3> low, high;
                bernstein::split<Vec3>(line, 0.5, low, high);
                return upper ? high : low;
            });
            queue.push_back(std::move(half));
        }
    }
    // Nothing in the lattice goes there; outside, every point is its own image.
    result.found = !in_unit_cube(local(y));
    result.certified = result.found && queue.size() < kMaxCandidates;
    result.point = y;
    return result;
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
