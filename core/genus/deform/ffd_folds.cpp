#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "genus/base/error.h"
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

namespace {

// The inverse of the matrix in the middle of the bounds, if there is one.
std::optional<Columns3> middle_inverse(const std::array<IntervalVec3, 3>& columns)
{
    Columns3 middle;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t c = 0; c < 3; ++c) middle[a][c] = columns[a][c].mid();
    if (determinant(middle) == 0.0) return std::nullopt;
    const Columns3 y = inverted(middle);
    return is_finite(y[0]) && is_finite(y[1]) && is_finite(y[2]) ? std::optional(y) : std::nullopt;
}

// Bound of |I - M| in the norm of the largest row, for every M between the bounds.
double distance_from_identity(const std::array<IntervalVec3, 3>& columns)
{
    double largest = 0.0;
    for (std::size_t r = 0; r < 3; ++r) {
        Interval sum(0.0);
        for (std::size_t a = 0; a < 3; ++a)
            sum = sum + Interval((Interval(r == a ? 1.0 : 0.0) - columns[a][r]).magnitude());
        largest = std::max(largest, sum.hi);
    }
    return largest;
}

std::array<Box3, 2> halves(const Box3& box)
{
    const Vec3 size = box.size();
    const std::size_t axis = size[0] >= size[1] && size[0] >= size[2] ? 0
                             : size[1] >= size[2]                     ? 1
                                                                      : 2;
    std::array<Box3, 2> parts{box, box};
    parts[0].max[axis] = parts[1].min[axis] = box.center()[axis];
    return parts;
}

}  // namespace

// With the inverse Y of a matrix in the middle, |I - Y F'| < 1 all over the box. Y goes to the
// control points first, so that what their moves have in common stays together.
bool Lattice::regular(const std::vector<Piece>& pieces, const Box3& stu) const
{
    const auto y = middle_inverse(derivative_bounds(pieces, stu));
    if (!y) return false;
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
        const Vec3 width = stu.size();
        const double stretch = norm((*y)[0]) + norm((*y)[1]) + norm((*y)[2]);
        for (int a = 0; a < 3; ++a)
            noise = std::max(noise, 64.0 * kEpsilon * degree(a) * stretch * largest / width[at(a)]);
    }
    return distance_from_identity(derivative_bounds(turned, stu)) + 3.0 * noise < 1.0;
}

bool Lattice::one_to_one(const Box3& x, int max_pairs) const
{
    const Box3 inside = local_box(x);
    if (inside.empty()) return true;
    struct Part {
        Box3 box, image;
    };
    const std::vector<Piece> all = pieces();
    const auto part = [&](const Box3& box) { return Part{box, image_of_local(box)}; };
    std::vector<std::array<Part, 2>> stack{{part(inside), part(inside)}};
    for (int n = 0; !stack.empty(); ++n) {
        current_progress().check();
        if (n == max_pairs) return false;
        const auto [a, b] = std::move(stack.back());
        stack.pop_back();
        const bool same = a.box == b.box;
        if (!same && !overlap(a.image, b.image)) continue;
        // The difference of two images is the mean of the derivative between the points, times
        // their difference.
        Box3 both = a.box;
        both.add(b.box.min);
        both.add(b.box.max);
        if (regular(all, both)) continue;
        const bool first = a.box.diagonal() >= b.box.diagonal();
        const std::array<Box3, 2> boxes = halves(first ? a.box : b.box);
        if (boxes[0].diagonal() < 0x1p-20) return false;
        const Part low = part(boxes[0]), high = part(boxes[1]);
        if (same) {
            stack.push_back({low, low});
            stack.push_back({high, high});
            stack.push_back({low, high});
        } else {
            stack.push_back({first ? low : a, first ? b : low});
            stack.push_back({first ? high : a, first ? b : high});
        }
    }
    return true;
}

}  // namespace genus
