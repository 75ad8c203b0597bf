#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "genus/base/progress.h"
#include "genus/deform/lattice_net.h"

namespace genus {

using namespace lattice;

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

// What the products of a determinant cost, in multiplications.
double work_of(const Net3<Vec3>& f)
{
    double work = 8.0;
    for (const int n : f.n) work *= static_cast<double>(n) * n;
    return work;
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

// Where a coefficient at a corner, which is a value, is below zero: a point slightly inside, so
// that rounding does not carry it over the border.
template <class F>
std::optional<Vec3> negative_corner(const SignBox& b, double noise, const F& determinant_at)
{
    for (int corner = 0; corner < 8; ++corner) {
        std::size_t i = 0;
        Vec3 s;
        for (std::size_t a = 0; a < 3; ++a) {
            const bool high = (corner >> a & 1) != 0;
            i += high ? b.net.stride(static_cast<int>(a)) * at(b.net.n[a] - 1) : 0;
            s[a] = high ? b.box.max[a] : b.box.min[a];
        }
        if (b.net.c[i] >= -noise) continue;
        const Vec3 inside = bernstein::mix(s, b.box.center(), 0x1p-30);
        if (determinant_at(inside) < 0.0) return inside;
    }
    return std::nullopt;
}

}  // namespace

double Lattice::local_determinant(const Vec3& stu) const
{
    return determinant(local_derivative(stu));
}

FoldReport Lattice::folds(int max_boxes) const
{
    const double orientation = determinant(axes_);
    FoldReport report = folds_in(Box3{{}, {{1, 1, 1}}}, orientation > 0.0 ? 1.0 : -1.0, max_boxes);
    report.determinant /= std::fabs(orientation);
    return report;
}

FoldReport Lattice::folds_in(const Box3& stu, double sign, int max_boxes) const
{
    constexpr double kMostWork = 1e9;
    FoldReport report;
    report.determinant = std::numeric_limits<double>::infinity();
    const std::vector<Piece> all = pieces();
    for (const Piece& piece : all) {
        const Box3 box = intersection(piece.box, stu);
        if (box.empty() || !(volume(box) > 0.0)) continue;
        const bool by_coefficients = work_of(piece.net) <= kMostWork;
        const bool done = by_coefficients
                              ? folds_by_coefficients(piece, box, sign, max_boxes, report)
                              : folds_by_slopes(all, box, sign, max_boxes, report);
        if (!done) break;
    }
    return report;
}

// False once it is known that there are folds, or that it will not be known.
bool Lattice::folds_by_coefficients(const Piece& piece, const Box3& box, double sign,
                                    int& max_boxes, FoldReport& report) const
{
    const Net3<Vec3> part = part_of(piece.net, piece.relative(box));
    // Derivatives by the part's own parameters are smaller by this.
    const double scale = sign * volume(box);
    const Determinant det = determinant_of(part);
    const double noise = det.noise / std::fabs(scale);
    std::vector<SignBox> stack = {{det.net, box}};
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
        const auto value = [&](const Vec3& s) { return sign * local_determinant(s); };
        if (const auto s = negative_corner(b, noise, value)) {
            report = {FoldReport::Kind::Folded, global(*s), value(*s)};
            return false;
        }
        if (--max_boxes < 0) {
            report = {FoldReport::Kind::Undecided, global(b.box.center()), least};
            return false;
        }
        const std::size_t axis = longest_axis(b.box.size());
        auto nets = halves(b.net, axis);
        const auto boxes = halves(b.box, axis);
        for (const std::size_t k : {0u, 1u}) stack.push_back({std::move(nets[k]), boxes[k]});
    }
    return true;
}

// The same where the products would cost too much: all derivatives over a box are matrices about
// one that can be inverted. Less is decided in this way.
bool Lattice::folds_by_slopes(const std::vector<Piece>& all, const Box3& box, double sign,
                              int& max_boxes, FoldReport& report) const
{
    constexpr int kCost = 64;  // of a box, in boxes of the other way
    std::vector<Box3> stack = {box};
    while (!stack.empty()) {
        current_progress().check();
        const Box3 b = stack.back();
        stack.pop_back();
        const double there = sign * local_determinant(b.center());
        if (there < 0.0) {
            report = {FoldReport::Kind::Folded, global(b.center()), there};
            return false;
        }
        const double least = least_determinant(all, b);
        if (least > 0.0) {
            report.determinant = std::min(report.determinant, least);
            continue;
        }
        if ((max_boxes -= kCost) < 0) {
            report = {FoldReport::Kind::Undecided, global(b.center()), there};
            return false;
        }
        for (const Box3& half : halves(b)) stack.push_back(half);
    }
    return true;
}

namespace {

// The inverse of the matrix in the middle of the bounds, if there is one. Along axes with no width
// the derivative does not matter: there it is one across the others.
std::optional<Columns3> middle_inverse(const std::array<IntervalVec3, 3>& columns,
                                       const std::array<bool, 3>& is_flat)
{
    Columns3 middle;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t c = 0; c < 3; ++c) middle[a][c] = columns[a][c].mid();
    for (std::size_t a = 0; a < 3; ++a)
        if (is_flat[a]) middle[a] = normalized(cross(middle[(a + 1) % 3], middle[(a + 2) % 3]));
    if (determinant(middle) == 0.0) return std::nullopt;
    const Columns3 y = inverted(middle);
    return is_finite(y[0]) && is_finite(y[1]) && is_finite(y[2]) ? std::optional(y) : std::nullopt;
}

// Bound of |I - M| in the norm of the largest row, for every M between the bounds, without the rows
// and columns of axes with no width.
double distance_from_identity(const std::array<IntervalVec3, 3>& columns,
                              const std::array<bool, 3>& is_flat)
{
    double largest = 0.0;
    for (std::size_t r = 0; r < 3; ++r) {
        if (is_flat[r]) continue;
        Interval sum(0.0);
        for (std::size_t a = 0; a < 3; ++a)
            if (!is_flat[a])
                sum = sum + Interval((Interval(r == a ? 1.0 : 0.0) - columns[a][r]).magnitude());
        largest = std::max(largest, sum.hi);
    }
    return largest;
}

}  // namespace

// With the inverse Y of a matrix in the middle, |I - Y F'| < 1 all over the box. Y goes to the
// control points first, so that what their moves have in common stays together. No eigenvalue of
// Y F' is then below 1 less that norm.
double Lattice::least_determinant(const std::vector<Piece>& pieces, const Box3& stu) const
{
    const Vec3 width = stu.size();
    const std::array<bool, 3> is_flat = {width[0] == 0.0, width[1] == 0.0, width[2] == 0.0};
    const auto y = middle_inverse(derivative_bounds(pieces, stu), is_flat);
    if (!y) return 0.0;
    std::vector<Piece> turned;
    double noise = 0.0;
    for (const Piece& piece : pieces) {
        if (pieces.size() > 1 && !overlap(piece.box, stu)) continue;
        turned.push_back(piece);
        const Vec3 start = piece.net.c[0];
        double largest = 0.0;
        for (Vec3& p : turned.back().net.c) {
            largest = std::max(largest, norm(p - start));
            p = times(*y, p - start);
        }
        const double stretch = norm((*y)[0]) + norm((*y)[1]) + norm((*y)[2]);
        for (int a = 0; a < 3; ++a)
            if (!is_flat[at(a)])
                noise =
                    std::max(noise, 64.0 * kEpsilon * degree(a) * stretch * largest / width[at(a)]);
    }
    const double least =
        1.0 - (distance_from_identity(derivative_bounds(turned, stu), is_flat) + 3.0 * noise);
    return least > 0.0 ? least * least * least / std::fabs(determinant(*y)) * (1.0 - 0x1p-40) : 0.0;
}

}  // namespace genus
