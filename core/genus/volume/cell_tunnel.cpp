#include "genus/volume/cell_tunnel.h"

#include <algorithm>
#include <cmath>

#include "genus/base/expansion.h"
#include "genus/base/interval.h"

namespace genus {

namespace {

// A corner of the slice: its values at t = 0 and t = 1.
struct Column {
    double low, high;
    bool inside(bool at_top) const { return (at_top ? high : low) < 0.0; }
    bool changes() const { return inside(false) != inside(true); }
};
using Columns = std::array<Column, 4>;  // a, b, c, d round the slice

// Corners of the cube below and above; edges along z, and to a neighbour in the slice below and
// above.
constexpr std::array<std::uint8_t, 4> kBelow{0, 1, 3, 2}, kAbove{4, 5, 7, 6};
constexpr std::array<std::uint8_t, 4> kUpright{8, 9, 11, 10}, kLow{0, 0, 1, 1}, kHigh{2, 2, 3, 3};

// The sign of f(number), where f computes with what `number` makes of a double.
template <typename F>
int exact_sign(const F& f)
{
    const Interval rough = f([](double x) { return Interval(x); });
    if (rough.lo > 0.0) return 1;
    if (rough.hi < 0.0) return -1;
    return f([](double x) { return Expansion<2>(TwoTerms{x, 0.0}); }).sign();
}

// The sign for values raised by a positive amount smaller than any number, so that a zero counts as
// outside and no tie depends on the way of asking: that of the first coefficient of its powers that
// is not zero.
template <typename... Coefficients>
int sign_when_raised(const Coefficients&... coefficients)
{
    int sign = 0;
    static_cast<void>(((sign = exact_sign(coefficients)) || ...));
    return sign;
}

// a c - b d = low (1 - t)^2 + middle t (1 - t) + high t^2; and `_rise`, how fast these grow when
// all values are raised. They grow linearly, the middle one as fast as the others together.
template <typename N>
auto low_of(const N& n, const Columns& s)
{
    return n(s[0].low) * n(s[2].low) - n(s[1].low) * n(s[3].low);
}
template <typename N>
auto high_of(const N& n, const Columns& s)
{
    return n(s[0].high) * n(s[2].high) - n(s[1].high) * n(s[3].high);
}
template <typename N>
auto middle_of(const N& n, const Columns& s)
{
    return (n(s[0].low) * n(s[2].high) + n(s[0].high) * n(s[2].low)) -
           (n(s[1].low) * n(s[3].high) + n(s[1].high) * n(s[3].low));
}
template <typename N>
auto low_rise(const N& n, const Columns& s)
{
    return (n(s[0].low) + n(s[2].low)) - (n(s[1].low) + n(s[3].low));
}
template <typename N>
auto high_rise(const N& n, const Columns& s)
{
    return (n(s[0].high) + n(s[2].high)) - (n(s[1].high) + n(s[3].high));
}

// The sign of the middle coefficient if there are two roots inside (0, 1), else 0.
int middle_if_two_roots(const Columns& s)
{
    const int middle =
        sign_when_raised([&](const auto& n) { return middle_of(n, s); },
                         [&](const auto& n) { return low_rise(n, s) + high_rise(n, s); });
    const auto opposed = [&](const auto& value, const auto& rise) {
        return sign_when_raised(value, rise) == -middle;
    };
    if (middle == 0 ||
        !opposed([&](const auto& n) { return low_of(n, s); },
                 [&](const auto& n) { return low_rise(n, s); }) ||
        !opposed([&](const auto& n) { return high_of(n, s); },
                 [&](const auto& n) { return high_rise(n, s); }))
        return 0;
    const int discriminant = sign_when_raised(
        [&](const auto& n) {
            const auto m = middle_of(n, s);
            return m * m - n(4.0) * (low_of(n, s) * high_of(n, s));
        },
        [&](const auto& n) {
            const auto l = low_rise(n, s), h = high_rise(n, s);
            return middle_of(n, s) * (l + h) - n(2.0) * (low_of(n, s) * h + high_of(n, s) * l);
        },
        [&](const auto& n) {
            const auto d = low_rise(n, s) - high_rise(n, s);
            return d * d;
        });
    return discriminant > 0 ? middle : 0;
}

// Where column k changes sign, is a c - b d on the same side as at the ends?
bool changes_outside_roots(const Columns& s, std::size_t k, int middle)
{
    const Column& c = s[k];
    const auto neighbour = [&](const Column& d) {
        return sign_when_raised(
            [&](const auto& n) { return n(c.low) * n(d.high) - n(c.high) * n(d.low); },
            [&](const auto& n) { return (n(c.low) + n(d.high)) - (n(c.high) + n(d.low)); });
    };
    // There the product with the opposite column is zero; the common factor, low - high of the
    // column, enters squared.
    const int product = neighbour(s[(k + 1) % 4]) * neighbour(s[(k + 3) % 4]);
    return (k % 2 == 0 ? -product : product) * middle <= 0;
}

// Does column k change sign above the middle between the roots?
bool changes_above_middle(const Columns& s, std::size_t k, int middle)
{
    const Column& c = s[k];
    const int side = sign_when_raised(
        [&](const auto& n) {
            const auto m = middle_of(n, s);
            return n(c.low) * (n(2.0) * high_of(n, s) - m) +
                   n(c.high) * (n(2.0) * low_of(n, s) - m);
        },
        [&](const auto& n) {
            return n(2.0) * ((low_of(n, s) + high_of(n, s)) - middle_of(n, s)) +
                   (n(c.low) - n(c.high)) * (high_rise(n, s) - low_rise(n, s));
        });
    // Divided by low - high of the column and by the leading coefficient, whose sign is that of
    // -middle.
    return side * (c.low > c.high ? 1 : -1) * -middle > 0;
}

// Values scaled by a power of two, so that products neither overflow nor vanish.
std::optional<Columns> scaled_columns(const std::array<double, 8>& values)
{
    double most = 0.0;
    for (const double v : values) {
        if (!std::isfinite(v)) return std::nullopt;
        most = std::max(most, std::fabs(v));
    }
    int exponent = 0;
    std::frexp(most, &exponent);
    Columns s;
    for (std::size_t k = 0; k < 4; ++k)
        s[k] = {std::ldexp(values[kBelow[k]], -exponent), std::ldexp(values[kAbove[k]], -exponent)};
    return s;
}

// The waist passes the saddles of the slices at both roots, and between them the two vertices of
// the hyperbola, which lie towards the corners that the joined pair leaves aside.
std::array<Vec3, 4> waist(const Columns& s, std::size_t first)
{
    const auto number = [](double x) { return x; };
    const double low = low_of(number, s), high = high_of(number, s);
    const double middle = middle_of(number, s);
    const double root = std::sqrt(std::max(0.0, middle * middle - 4.0 * low * high));
    // Ties may leave 0 / 0, and then any place of the slice is right.
    const auto within = [](double x) { return x > 0.0 ? std::min(x, 1.0) : 0.0; };
    // With u = t / (1 - t): high u^2 + middle u + low = 0, the stable way.
    const double sum = -0.5 * (middle + std::copysign(root, middle));
    const auto height = [&](double top, double bottom) { return within(top / (top + bottom)); };
    const double t0 = height(sum, high), t1 = height(low, sum);
    const auto saddle = [&](double t) {
        std::array<double, 4> v;
        for (std::size_t k = 0; k < 4; ++k) v[k] = s[k].low * (1.0 - t) + s[k].high * t;
        const double twist = v[0] - v[1] + v[2] - v[3];
        return std::pair{Vec3{{within((v[0] - v[3]) / twist), within((v[0] - v[1]) / twist), t}},
                         (v[0] * v[2] - v[1] * v[3]) / (twist * twist)};
    };
    const auto [centre, depth] = saddle(0.5 * (t0 + t1));
    const auto towards = [&, middle_point = centre, area = std::fabs(depth)](std::size_t k) {
        const Vec3 corner{{k == 1 || k == 2 ? 1.0 : 0.0, k >= 2 ? 1.0 : 0.0, middle_point[2]}};
        const Vec3 way = corner - middle_point;
        return middle_point + way * within(std::sqrt(area / std::fabs(way[0] * way[1])));
    };
    return {saddle(t0).first, towards((first + 1) % 4), saddle(t1).first, towards((first + 3) % 4)};
}

}  // namespace

std::optional<CellTunnel> cell_tunnel(const std::array<double, 8>& values)
{
    const auto scaled = scaled_columns(values);
    if (!scaled) return std::nullopt;
    const Columns& s = *scaled;
    const int middle = middle_if_two_roots(s);
    if (middle == 0) return std::nullopt;
    std::array<bool, 4> inside{}, above{};
    for (std::size_t k = 0; k < 4; ++k) {
        if (s[k].changes()) {
            if (!changes_outside_roots(s, k, middle)) return std::nullopt;
            above[k] = changes_above_middle(s, k, middle);
        }
        inside[k] = s[k].inside(!above[k]);
    }
    if (inside[0] != inside[2] || inside[1] != inside[3] || inside[0] == inside[1])
        return std::nullopt;
    const std::size_t first = middle > 0 ? 0 : 1, second = first + 2;
    // Past the roots the sheets are apart up to where the first of the two columns changes sign; if
    // none does, up to the face, which tells them apart.
    const auto changes = [&](bool upwards) {
        return (s[first].changes() && above[first] == upwards) ||
               (s[second].changes() && above[second] == upwards);
    };
    const auto& edges = !changes(false) ? kLow : !changes(true) ? kHigh : kUpright;
    return CellTunnel{{edges[first], edges[second]}, waist(s, first)};
}

}  // namespace genus
