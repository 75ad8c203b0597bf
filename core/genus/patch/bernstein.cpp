#include "genus/patch/bernstein.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/expansion.h"

namespace genus::bernstein {

double binomial(int n, int k)
{
    if (k < 0 || k > n) return 0.0;
    k = std::min(k, n - k);
    // The quotient is a whole number at every step. 128 bits hold the product while the result
    // is below 2^118, so a double is rounded once only up to there.
    __extension__ using Whole = unsigned __int128;
    Whole whole = 1;
    int i = 1;
    for (; i <= k && whole < (Whole(1) << 118); ++i)
        whole = whole * static_cast<Whole>(n - k + i) / static_cast<Whole>(i);
    double b = static_cast<double>(whole);
    for (; i <= k; ++i) b = b * (n - k + i) / i;
    return b;
}

std::vector<double> basis(int n, double t)
{
    require(n >= 0 && n <= kMaxDegree, "bernstein::basis: degree", n, "in [0, 512]");
    std::vector<double> b(static_cast<std::size_t>(n) + 1);
    b[0] = 1.0;
    for (int degree = 1; degree <= n; ++degree) {
        double carry = 0.0;
        for (int k = 0; k < degree; ++k) {
            const double old = b[k];
            b[k] = carry + (1.0 - t) * old;
            carry = t * old;
        }
        b[degree] = carry;
    }
    return b;
}

std::vector<Vec3> quotient_derivatives(std::span<const Vec4> a)
{
    std::vector<Vec3> c(a.size());
    for (std::size_t r = 0; r < a.size(); ++r) {
        Vec3 sum = {{a[r][0], a[r][1], a[r][2]}};
        for (std::size_t i = 1; i <= r; ++i)
            sum -= binomial(static_cast<int>(r), static_cast<int>(i)) * a[i][3] * c[r - i];
        c[r] = sum / a[0][3];
    }
    return c;
}

namespace {

std::vector<double> binomial_row(int n)
{
    std::vector<double> row = {1.0};
    for (int k = 1; k <= n; ++k) row.push_back(row.back() * (n - k + 1) / k);
    return row;
}

}  // namespace

std::vector<double> product(std::span<const double> a, std::span<const double> b)
{
    const int n = static_cast<int>(a.size()) - 1, m = static_cast<int>(b.size()) - 1;
    std::vector<double> sa(a.begin(), a.end()), sb(b.begin(), b.end());
    const auto row_n = binomial_row(n), row_m = binomial_row(m), row = binomial_row(n + m);
    for (int i = 0; i <= n; ++i) sa[i] *= row_n[i];
    for (int j = 0; j <= m; ++j) sb[j] *= row_m[j];
    std::vector<double> c(static_cast<std::size_t>(n + m) + 1);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= m; ++j) c[i + j] += sa[i] * sb[j];
    for (int k = 0; k <= n + m; ++k) c[k] /= row[k];
    return c;
}

namespace {

// Numbers of about 106 bits: an unevaluated sum high + low.
TwoTerms normalized(double high, double low)
{
    const double sum = high + low;
    return {sum, low - (sum - high)};
}

TwoTerms add(TwoTerms a, TwoTerms b)
{
    TwoTerms s = two_sum(a.high, b.high);
    const TwoTerms t = two_sum(a.low, b.low);
    s = normalized(s.high, s.low + t.high);
    return normalized(s.high, s.low + t.low);
}

TwoTerms multiply(TwoTerms a, TwoTerms b)
{
    const TwoTerms p = two_product(a.high, b.high);
    return normalized(p.high, p.low + (a.high * b.low + a.low * b.high));
}

TwoTerms multiply(TwoTerms a, double b)
{
    const TwoTerms p = two_product(a.high, b);
    return normalized(p.high, p.low + a.low * b);
}

TwoTerms divide(TwoTerms a, TwoTerms b)
{
    const double q = a.high / b.high;
    const TwoTerms r = add(a, multiply(b, -q));
    return normalized(q, (r.high + r.low) / b.high);
}

// A value in twice the precision, during evaluation.
template <std::size_t N>
struct Wide {
    std::array<TwoTerms, N> value;
    Vec<N> magnitude;  // sum |c_k| |B_k|, slightly above
    double largest;    // of the coefficients that went in
};

template <std::size_t N>
Wide<N> widened(const Vec<N>& c)
{
    Wide<N> w{};
    for (std::size_t i = 0; i < N; ++i) {
        w.value[i] = {c[i], 0.0};
        w.magnitude[i] = std::fabs(c[i]);
        w.largest = std::max(w.largest, w.magnitude[i]);
    }
    return w;
}

// Horner's rule in Bernstein form ([farin2002], chapter 5) for
// sum binomial(n, k) s^(n - k) t^k c_k = (.. (c_0 s + binomial(n, 1) t c_1) s + ..) s + t^n c_n.
template <std::size_t N>
Wide<N> horner(std::span<const Wide<N>> c, TwoTerms s, TwoTerms t)
{
    const int n = static_cast<int>(c.size()) - 1;
    Wide<N> r = c[0];
    TwoTerms power{1.0, 0.0}, binom{1.0, 0.0};
    const double abs_s = std::fabs(s.high);
    for (int k = 1; k <= n; ++k) {
        power = multiply(power, t);
        binom = multiply(binom, static_cast<double>(n - k + 1));
        binom = divide(binom, {static_cast<double>(k), 0.0});
        const TwoTerms factor = multiply(power, binom);
        const double abs_factor = std::fabs(factor.high);
        const Wide<N>& ck = c[static_cast<std::size_t>(k)];
        for (std::size_t i = 0; i < N; ++i) {
            r.value[i] = add(multiply(r.value[i], s), multiply(factor, ck.value[i]));
            r.magnitude[i] = r.magnitude[i] * abs_s + abs_factor * ck.magnitude[i];
        }
        r.largest = std::max(r.largest, ck.largest);
    }
    for (std::size_t i = 0; i < N; ++i) r.magnitude[i] *= 1.0 + 0x1p-40;
    return r;
}

template <std::size_t N>
Wide<N> curve_value(std::span<const Vec<N>> c, double t)
{
    std::vector<Wide<N>> wide;
    wide.reserve(c.size());
    for (const Vec<N>& p : c) wide.push_back(widened(p));
    return horner<N>(wide, two_sum(1.0, -t), {t, 0.0});
}

template <std::size_t N>
Wide<N> tensor_value(std::span<const Vec<N>> c, int m, int n, double u, double v)
{
    const auto width = static_cast<std::size_t>(n) + 1;
    std::vector<Wide<N>> rows;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(m); ++i)
        rows.push_back(curve_value<N>(c.subspan(i * width, width), v));
    return horner<N>(rows, two_sum(1.0, -u), {u, 0.0});
}

// Row i holds a form of degree n - i in w and v; the rows are summed by powers of u.
template <std::size_t N>
Wide<N> triangle_value(std::span<const Vec<N>> c, int n, double u, double v)
{
    const TwoTerms w = add(two_sum(1.0, -u), {-v, 0.0});
    std::vector<Wide<N>> rows;
    std::size_t first = 0;
    for (int i = 0; i <= n; ++i) {
        std::vector<Wide<N>> row;
        for (int j = 0; j <= n - i; ++j) row.push_back(widened(c[first++]));
        rows.push_back(horner<N>(row, w, {v, 0.0}));
    }
    Wide<N> sum = horner<N>(rows, {1.0, 0.0}, {u, 0.0});
    // The last bit of w may be lost: a move along the patch by 2^-104 of its parameter.
    for (std::size_t k = 0; k < N; ++k) sum.magnitude[k] += sum.largest;
    return sum;
}

// A term goes through at most n + 1 products and sums of Horner's rule and 3 n + 2 operations for
// its factor; none errs by more than 16 u^2 relative, u = 2^-53. Rounded up generously; nested
// evaluation adds up the degrees.
double wide_error(int degrees)
{
    return 64.0 * static_cast<double>(degrees + 3) * 0x1p-106;
}

// Each low part that underflows loses less than 2^-1070, later multiplied by at most a binomial
// (< 2^n) and a coefficient.
double underflow(double largest, int degrees)
{
    return std::ldexp(largest, degrees - 1000) + 0x1p-1000;
}

template <std::size_t N>
Bounded<N> rounded(const Wide<N>& wide, int degrees)
{
    Bounded<N> result;
    for (std::size_t i = 0; i < N; ++i) {
        result.value[i] = wide.value[i].high;
        const double lost = std::fabs(wide.value[i].low) + wide_error(degrees) * wide.magnitude[i] +
                            underflow(wide.largest, degrees);
        result.bound[i] = lost * (1.0 + 0x1p-50);
    }
    return result;
}

// Coefficients (x w, y w, z w, w) may be off by `input_error` relative themselves.
Bounded<3> rounded_quotient(const Wide<4>& wide, int degrees, double input_error)
{
    const TwoTerms w = wide.value[3];
    const double relative = wide_error(degrees) + input_error;
    const double tiny = underflow(wide.largest, degrees);
    const double w_error = relative * wide.magnitude[3] + tiny;
    const double w_least = std::fabs(w.high) * (1.0 - 0x1p-50) - w_error;
    Bounded<3> result;
    for (std::size_t i = 0; i < 3; ++i) {
        const TwoTerms q = divide(wide.value[i], w);
        result.value[i] = q.high;
        const double error = relative * wide.magnitude[i] + tiny;
        // x/w - X/W = ((x - X) - (x/w) (w - W)) / W, and the division errs by 2^-100 itself.
        const double lost = std::fabs(q.low) + (error + std::fabs(q.high) * w_error) / w_least +
                            std::fabs(q.high) * 0x1p-98 + 0x1p-1000;
        result.bound[i] =
            w_least > 0.0 ? lost * (1.0 + 0x1p-50) : std::numeric_limits<double>::infinity();
    }
    return result;
}

int degree_of(std::size_t coefficients)
{
    return static_cast<int>(coefficients) - 1;
}

}  // namespace

template <std::size_t N>
Bounded<N> value_with_bound(std::span<const Vec<N>> c, double t)
{
    return rounded(curve_value<N>(c, t), degree_of(c.size()));
}

template Bounded<1> value_with_bound<1>(std::span<const Vec<1>>, double);
template Bounded<2> value_with_bound<2>(std::span<const Vec<2>>, double);
template Bounded<3> value_with_bound<3>(std::span<const Vec<3>>, double);
template Bounded<4> value_with_bound<4>(std::span<const Vec<4>>, double);

Bounded<3> rational_value_with_bound(std::span<const Vec4> c, double t, double input_error)
{
    return rounded_quotient(curve_value<4>(c, t), degree_of(c.size()), input_error);
}

Bounded<3> tensor_value_with_bound(std::span<const Vec3> c, int m, int n, double u, double v)
{
    return rounded(tensor_value<3>(c, m, n, u, v), m + n);
}

Bounded<3> tensor_value_with_bound(std::span<const Vec4> c, int m, int n, double u, double v,
                                   double input_error)
{
    return rounded_quotient(tensor_value<4>(c, m, n, u, v), m + n, input_error);
}

Bounded<3> triangle_value_with_bound(std::span<const Vec3> c, int n, double u, double v)
{
    return rounded(triangle_value<3>(c, n, u, v), 2 * n);
}

Bounded<3> triangle_value_with_bound(std::span<const Vec4> c, int n, double u, double v,
                                     double input_error)
{
    return rounded_quotient(triangle_value<4>(c, n, u, v), 2 * n, input_error);
}

namespace {

int sign_changes(std::span<const double> c)
{
    int changes = 0;
    double last = 0.0;
    for (const double x : c) {
        if (x == 0.0) continue;
        if (last != 0.0 && (x < 0.0) != (last < 0.0)) ++changes;
        last = x;
    }
    return changes;
}

struct Range {
    double lo, hi;
};

// Where the hull of the points (k / n, c_k) meets the axis; nothing if it misses it.
std::optional<Range> hull_clip(std::span<const double> c)
{
    const std::size_t n = c.size() - 1;
    Range r{2.0, -1.0};
    for (std::size_t i = 0; i <= n; ++i) {
        const double ti = static_cast<double>(i) / static_cast<double>(n);
        if (c[i] == 0.0) r = {std::min(r.lo, ti), std::max(r.hi, ti)};
        for (std::size_t j = i + 1; j <= n; ++j) {
            if ((c[i] < 0.0) == (c[j] < 0.0) || c[i] == 0.0 || c[j] == 0.0) continue;
            const double tj = static_cast<double>(j) / static_cast<double>(n);
            const double t = ti + (tj - ti) * (c[i] / (c[i] - c[j]));
            r = {std::min(r.lo, t), std::max(r.hi, t)};
        }
    }
    if (r.lo > r.hi) return std::nullopt;
    return Range{std::max(0.0, r.lo - 0x1p-45), std::min(1.0, r.hi + 0x1p-45)};
}

// The one root of coefficients with ends of opposite sign (Illinois variant of regula falsi,
// with a bisection whenever it stalls).
double bracketed_root(std::span<const double> c, double tolerance)
{
    double a = 0.0, b = 1.0, fa = c.front(), fb = c.back();
    for (int step = 0; step < 200 && b - a > tolerance; ++step) {
        double t = step % 3 == 2 ? 0.5 * (a + b) : a + (b - a) * (fa / (fa - fb));
        t = std::clamp(t, a + 0.25 * tolerance, b - 0.25 * tolerance);
        const double f = value<double>(c, t);
        if (f == 0.0) return t;
        if ((f < 0.0) == (fa < 0.0)) {
            a = t;
            fa = f;
            fb *= 0.5;
        } else {
            b = t;
            fb = f;
            fa *= 0.5;
        }
    }
    return 0.5 * (a + b);
}

// Coefficients over [lo, hi], each known to `noise`.
struct Piece {
    std::vector<double> c;
    double lo, hi;
    double noise;
};

double largest(std::span<const double> c)
{
    double m = 0.0;
    for (const double x : c) m = std::max(m, std::fabs(x));
    return m;
}

// p = t q where c_0 = 0: the coefficients of q.
void divide_by_t(std::vector<double>& c)
{
    const double n = static_cast<double>(c.size() - 1);
    c.erase(c.begin());
    for (std::size_t k = 0; k < c.size(); ++k) c[k] *= n / static_cast<double>(k + 1);
}

void divide_by_one_minus_t(std::vector<double>& c)
{
    std::reverse(c.begin(), c.end());
    divide_by_t(c);
    std::reverse(c.begin(), c.end());
}

class RootFinder {
public:
    RootFinder(std::span<const double> c, double tolerance) : tolerance_(tolerance)
    {
        pieces_.push_back({{c.begin(), c.end()}, 0.0, 1.0, 0.0});
    }

    std::vector<Root> run()
    {
        while (!pieces_.empty()) {
            Piece piece = std::move(pieces_.back());
            pieces_.pop_back();
            treat(std::move(piece));
        }
        return merged();
    }

private:
    struct Found {
        double lo, hi;
        bool simple;
    };

    void treat(Piece piece)
    {
        auto& c = piece.c;
        for (; c.size() > 1 && c.front() == 0.0; divide_by_t(c))
            found_.push_back({piece.lo, piece.lo, true});
        for (; c.size() > 1 && c.back() == 0.0; divide_by_one_minus_t(c))
            found_.push_back({piece.hi, piece.hi, true});
        const double width = piece.hi - piece.lo;
        const int changes = sign_changes(c);
        if (largest(c) <= piece.noise) {
            found_.push_back({piece.lo, piece.hi, false});
        } else if (changes == 0) {
            return;
        } else if (changes == 1) {
            const double t = bracketed_root(c, std::min(0.5, tolerance_ / width));
            found_.push_back({piece.lo + t * width, piece.lo + t * width, true});
        } else if (width <= tolerance_) {
            found_.push_back({piece.lo, piece.hi, false});
        } else {
            cut(piece);
        }
    }

    void cut(const Piece& piece)
    {
        const auto range = hull_clip(piece.c);
        if (!range) return;
        const double width = piece.hi - piece.lo;
        const double noise = piece.noise + 2.0 * static_cast<double>(piece.c.size()) *
                                               std::numeric_limits<double>::epsilon() *
                                               largest(piece.c);
        if (range->hi - range->lo < 0.8) {
            pieces_.push_back({segment<double>(piece.c, range->lo, range->hi),
                               piece.lo + range->lo * width, piece.lo + range->hi * width, noise});
            return;
        }
        const double middle = 0.5 * (piece.lo + piece.hi);
        Piece left{{}, piece.lo, middle, noise}, right{{}, middle, piece.hi, noise};
        split<double>(piece.c, 0.5, left.c, right.c);
        // A root right at the cut is found from the right side only.
        while (left.c.size() > 1 && left.c.back() == 0.0) divide_by_one_minus_t(left.c);
        pieces_.push_back(std::move(left));
        pieces_.push_back(std::move(right));
    }

    std::vector<Root> merged()
    {
        std::sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
            return a.lo != b.lo ? a.lo < b.lo : a.hi < b.hi;
        });
        std::vector<Found> clusters;
        for (const Found& f : found_) {
            if (clusters.empty() || f.lo - clusters.back().hi > 4.0 * tolerance_) {
                clusters.push_back(f);
                continue;
            }
            clusters.back().hi = std::max(clusters.back().hi, f.hi);
            clusters.back().simple = false;
        }
        std::vector<Root> result;
        for (const Found& f : clusters) result.push_back({0.5 * (f.lo + f.hi), f.simple});
        return result;
    }

    double tolerance_;
    std::vector<Piece> pieces_;
    std::vector<Found> found_;
};

}  // namespace

std::vector<Root> roots(std::span<const double> c, double tolerance)
{
    require(!c.empty() && c.size() <= kMaxDegree * 3 + 1,
            "bernstein::roots: number of coefficients", static_cast<double>(c.size()),
            "in [1, 1537]");
    for (const double x : c)
        require(std::isfinite(x), "bernstein::roots: coefficient", x, "finite");
    require(tolerance > 0.0, "bernstein::roots: tolerance", tolerance, "positive");
    if (c.size() == 1 || std::all_of(c.begin(), c.end(), [](double x) { return x == 0.0; }))
        return {};
    return RootFinder(c, std::max(tolerance, 0x1p-50)).run();
}

}  // namespace genus::bernstein
