#include "genus/implicit/operations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;
// Beyond this sines are not followed any more.
constexpr double kLargestAngle = 1e6;

double round_half_up(double x)
{
    return std::floor(x + 0.5);
}

double sign_of(double x)
{
    return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x;
}

// The order of comparison hands a NaN on from either side.
double smaller(double a, double b)
{
    return a < b || std::isnan(a) ? a : b;
}

double larger(double a, double b)
{
    return a > b || std::isnan(a) ? a : b;
}

// Zero has no sign here.
double real_power(double a, double b)
{
    return std::isnan(b) ? b : std::pow(a + 0.0, b);
}

// Results of the standard library, widened by what they may err.
Interval widened(double lo, double hi)
{
    constexpr double few = 4.0 * std::numeric_limits<double>::epsilon();
    constexpr double tiny = std::numeric_limits<double>::denorm_min();
    const auto margin = [](double x) { return std::fabs(x) * few + 4.0 * tiny; };
    return {std::isfinite(lo) ? lo - margin(lo) : rounding::down(lo),
            std::isfinite(hi) ? hi + margin(hi) : rounding::up(hi)};
}

template <typename F>
Interval rising(const F& f, const Interval& a)
{
    return widened(f(a.lo), f(a.hi));
}

Interval clipped(const Interval& a, double lo, double hi)
{
    return {std::max(a.lo, lo), std::min(a.hi, hi)};
}

bool has_infinity(const Interval& a)
{
    return std::isinf(a.lo) || std::isinf(a.hi);
}

// Is some offset + 2 pi k in the interval? True where rounding leaves it open.
bool may_hold_turn(const Interval& a, double offset)
{
    constexpr double slack = 1e-9;
    const double low = (a.lo - offset) / (2.0 * kPi) - slack;
    const double high = (a.hi - offset) / (2.0 * kPi) + slack;
    return std::floor(high) >= std::ceil(low);
}

// Sine where the angle is shifted by `offset`, so that it also serves as cosine.
template <typename F>
Interval wave(const F& f, const Interval& a, double top)
{
    if (!(a.magnitude() <= kLargestAngle)) return {-1.0, 1.0};
    const double p = f(a.lo), q = f(a.hi);
    Interval range = widened(std::min(p, q), std::max(p, q));
    if (may_hold_turn(a, top)) range.hi = 1.0;
    if (may_hold_turn(a, top + kPi)) range.lo = -1.0;
    return clipped(range, -1.0, 1.0);
}

Interval sine(const Interval& a)
{
    return wave([](double x) { return std::sin(x); }, a, 0.5 * kPi);
}

Interval cosine(const Interval& a)
{
    return wave([](double x) { return std::cos(x); }, a, 0.0);
}

Interval tangent(const Interval& a)
{
    if (!(a.magnitude() <= kLargestAngle) || may_hold_turn(a, 0.5 * kPi) ||
        may_hold_turn(a, -0.5 * kPi))
        return Interval::everything();
    return rising([](double x) { return std::tan(x); }, a);
}

Interval hyperbolic_cosine(const Interval& a)
{
    const Interval size = abs(a);
    const Interval range = rising([](double x) { return std::cosh(x); }, size);
    return {std::max(1.0, range.lo), range.hi};
}

Interval whole_power(const Interval& a, int n)
{
    if (n < 0) return Interval(1.0) / whole_power(a, -n);
    if (n == 0) return Interval(1.0);
    if (n % 2 == 0 && !(a.lo >= 0.0)) return whole_power(abs(a), n);
    if (a.lo < 0.0) {  // odd: rises all along
        const Interval lo = -whole_power(Interval(-a.lo), n);
        const Interval hi =
            a.hi < 0.0 ? -whole_power(Interval(-a.hi), n) : whole_power(Interval(a.hi), n);
        return {lo.lo, hi.hi};
    }
    Interval power = a, result(1.0);
    for (;; n /= 2) {
        if (n % 2 != 0) result = result * power;
        if (n < 2) return result;
        power = square(power);
    }
}

// a^b as it is evaluated, base not negative.
Interval real_power(const Interval& a, const Interval& b)
{
    double lo = kInfinity, hi = -kInfinity;
    // Monotone in each of the two: extreme at corners, and 1 where lines of monotony meet.
    for (const double x : {a.lo, a.hi})
        for (const double y : {b.lo, b.hi}) {
            const double v = real_power(x, y);
            if (std::isnan(v)) return {0.0, kInfinity};
            lo = std::min(lo, v);
            hi = std::max(hi, v);
        }
    if (a.contains(1.0) || b.contains(0.0)) {
        lo = std::min(lo, 1.0);
        hi = std::max(hi, 1.0);
    }
    const Interval range = widened(lo, hi);
    return {std::max(0.0, range.lo), range.hi};
}

Range real_power(const Range& a, const Range& b)
{
    const bool undefined = a.may_be_undefined || b.may_be_undefined || a.values.lo < 0.0;
    // Negative bases have whole powers.
    if (a.values.lo < 0.0) return {Interval::everything(), true};
    return {real_power(a.values, b.values), undefined};
}

Interval angle(const Interval& y, const Interval& x)
{
    if (x.lo <= 0.0 && y.contains(0.0)) return widened(-kPi, kPi);
    double lo = kInfinity, hi = -kInfinity;
    for (const double s : {y.lo, y.hi})
        for (const double c : {x.lo, x.hi}) {
            const double v = std::atan2(s, c);
            lo = std::min(lo, v);
            hi = std::max(hi, v);
        }
    return widened(lo, hi);
}

// The part of the domain that an interval has, and whether there is more to it.
Range domain(const Interval& a, double lo, double hi)
{
    return {clipped(a, lo, hi), a.lo < lo || a.hi > hi};
}

template <typename F>
Range on_domain(const Interval& a, double lo, double hi, const F& f)
{
    const Range part = domain(a, lo, hi);
    if (!(part.values.lo <= part.values.hi)) return {Interval::everything(), true};
    return {f(part.values), part.may_be_undefined};
}

Range one_operand(Operation operation, const Interval& a, double number)
{
    switch (operation) {
        case Operation::Negate:
            return {-a};
        case Operation::Abs:
            return {abs(a)};
        case Operation::Square:
            return {square(a)};
        case Operation::Power:
            return {whole_power(a, static_cast<int>(number)),
                    number < 0.0 && (a.contains(0.0) || has_infinity(a))};
        case Operation::Sqrt:
            return on_domain(a, 0.0, kInfinity, [](const Interval& x) { return sqrt(x); });
        case Operation::Cbrt:
            return {rising([](double x) { return std::cbrt(x); }, a)};
        case Operation::Exp: {
            const Interval range = rising([](double x) { return std::exp(x); }, a);
            return {{std::max(0.0, range.lo), range.hi}};
        }
        case Operation::Log:
            return on_domain(a, 0.0, kInfinity, [](const Interval& x) {
                return rising([](double t) { return std::log(t); }, x);
            });
        case Operation::Sin:
            return {sine(a), has_infinity(a)};
        case Operation::Cos:
            return {cosine(a), has_infinity(a)};
        case Operation::Tan:
            return {tangent(a), has_infinity(a)};
        case Operation::Asin:
            return on_domain(a, -1.0, 1.0, [](const Interval& x) {
                return rising([](double t) { return std::asin(t); }, x);
            });
        case Operation::Acos:
            return on_domain(a, -1.0, 1.0, [](const Interval& x) {
                return widened(std::acos(x.hi), std::acos(x.lo));
            });
        case Operation::Atan:
            return {rising([](double x) { return std::atan(x); }, a)};
        case Operation::Sinh:
            return {rising([](double x) { return std::sinh(x); }, a)};
        case Operation::Cosh:
            return {hyperbolic_cosine(a)};
        case Operation::Tanh:
            return {clipped(rising([](double x) { return std::tanh(x); }, a), -1.0, 1.0)};
        case Operation::Floor:
            return {{std::floor(a.lo), std::floor(a.hi)}};
        case Operation::Ceil:
            return {{std::ceil(a.lo), std::ceil(a.hi)}};
        case Operation::Round:
            return {{round_half_up(a.lo), round_half_up(a.hi)}};
        case Operation::Sign:
            return {{sign_of(a.lo), sign_of(a.hi)}};
        default:
            return {Interval::everything(), true};
    }
}

// Sums, products and quotients of what is not negative are not, before and after rounding: roots of
// them are defined at zero, too.
Interval with_sign_of(const Interval& result, const Interval& a, const Interval& b)
{
    return a.lo >= 0.0 && b.lo >= 0.0 ? Interval(std::max(0.0, result.lo), result.hi) : result;
}

// A denominator that is not negative leaves one side open; zero has no sign.
Interval quotient(const Interval& a, const Interval& b)
{
    if (b.lo > 0.0 || b.hi < 0.0) return with_sign_of(a / b, a, b);
    if (b.lo == 0.0 && b.hi > 0.0 && a.lo >= 0.0)
        return {std::max(0.0, rounding::down(a.lo / b.hi)), kInfinity};
    if (b.lo == 0.0 && b.hi > 0.0 && a.hi <= 0.0) return -quotient(-a, b);
    return Interval::everything();
}

Range two_operands(Operation operation, const Range& first, const Range& second)
{
    const Interval &a = first.values, &b = second.values;
    switch (operation) {
        // Infinity less infinity, or times zero, is not a number.
        case Operation::Add:
            return {with_sign_of(a + b, a, b), has_infinity(a) && has_infinity(b)};
        case Operation::Subtract:
            return {a - b, has_infinity(a) && has_infinity(b)};
        case Operation::Multiply:
            return {with_sign_of(a * b, a, b),
                    (has_infinity(a) && b.contains(0.0)) || (has_infinity(b) && a.contains(0.0))};
        case Operation::Divide:
            return {quotient(a, b),
                    (a.contains(0.0) && b.contains(0.0)) || (has_infinity(a) && has_infinity(b))};
        case Operation::RealPower:
            return real_power(first, second);
        case Operation::Atan2:
            return {angle(a, b)};
        case Operation::Min:
            return {min(a, b)};
        case Operation::Max:
            return {max(a, b)};
        default:
            return {Interval::everything(), true};
    }
}

constexpr Interval kAnySlope = Interval::everything();

Interval crease(const Interval& a, double below, double above)
{
    if (a.hi < 0.0) return Interval(below);
    if (a.lo > 0.0) return Interval(above);
    return {std::min(below, above), std::max(below, above)};
}

Interval step(const Interval& result)
{
    return result.lo == result.hi ? Interval(0.0) : kAnySlope;
}

}  // namespace

double whole_power(double x, int n)
{
    if (n < 0) return 1.0 / whole_power(x, -n);
    double result = 1.0;
    for (double power = x;; power *= power) {
        if (n % 2 != 0) result *= power;
        n /= 2;
        if (n == 0) return result;
    }
}

double operate(Operation operation, double a, double b, double number)
{
    switch (operation) {
        case Operation::Number:
            return number;
        case Operation::X:
        case Operation::Y:
        case Operation::Z:
            return a;
        case Operation::Negate:
            return -a;
        case Operation::Abs:
            return std::fabs(a);
        case Operation::Square:
            return a * a;
        case Operation::Power:
            return whole_power(a, static_cast<int>(number));
        case Operation::Sqrt:
            return std::sqrt(a);
        case Operation::Cbrt:
            return std::cbrt(a);
        case Operation::Exp:
            return std::exp(a);
        case Operation::Log:
            return std::log(a);
        case Operation::Sin:
            return std::sin(a);
        case Operation::Cos:
            return std::cos(a);
        case Operation::Tan:
            return std::tan(a);
        case Operation::Asin:
            return std::asin(a);
        case Operation::Acos:
            return std::acos(a);
        case Operation::Atan:
            return std::atan(a);
        case Operation::Sinh:
            return std::sinh(a);
        case Operation::Cosh:
            return std::cosh(a);
        case Operation::Tanh:
            return std::tanh(a);
        case Operation::Floor:
            return std::floor(a);
        case Operation::Ceil:
            return std::ceil(a);
        case Operation::Round:
            return round_half_up(a);
        case Operation::Sign:
            return sign_of(a);
        case Operation::Add:
            return a + b;
        case Operation::Subtract:
            return a - b;
        case Operation::Multiply:
            return a * b;
        case Operation::Divide:
            return a / (b + 0.0);  // zero has no sign here, either
        case Operation::RealPower:
            return real_power(a, b);
        case Operation::Atan2:
            return std::atan2(a + 0.0, b + 0.0);  // zero has no sign
        case Operation::Min:
            return smaller(a, b);
        case Operation::Max:
            return larger(a, b);
    }
    return a;
}

Range operate(Operation operation, const Range& a, const Range& b, double number)
{
    const int n = operand_count(operation);
    if (n == 0) {
        if (operation != Operation::Number) return a;
        return std::isnan(number) ? Range{Interval::everything(), true} : Range{Interval(number)};
    }
    Range result =
        n == 1 ? one_operand(operation, a.values, number) : two_operands(operation, a, b);
    result.may_be_undefined |= a.may_be_undefined || (n == 2 && b.may_be_undefined);
    return result;
}

std::pair<double, double> derivatives(Operation operation, double a, double b, double number,
                                      double result)
{
    switch (operation) {
        case Operation::Negate:
            return {-1.0, 0.0};
        case Operation::Abs:
            return {a < 0.0 ? -1.0 : 1.0, 0.0};
        case Operation::Square:
            return {2.0 * a, 0.0};
        case Operation::Power:
            if (number == 0.0) return {0.0, 0.0};
            return {number * whole_power(a, static_cast<int>(number) - 1), 0.0};
        case Operation::Sqrt:
            return {0.5 / result, 0.0};
        case Operation::Cbrt:
            return {1.0 / (3.0 * result * result), 0.0};
        case Operation::Exp:
            return {result, 0.0};
        case Operation::Log:
            return {1.0 / a, 0.0};
        case Operation::Sin:
            return {std::cos(a), 0.0};
        case Operation::Cos:
            return {-std::sin(a), 0.0};
        case Operation::Tan:
            return {1.0 + result * result, 0.0};
        case Operation::Asin:
            return {1.0 / std::sqrt(1.0 - a * a), 0.0};
        case Operation::Acos:
            return {-1.0 / std::sqrt(1.0 - a * a), 0.0};
        case Operation::Atan:
            return {1.0 / (1.0 + a * a), 0.0};
        case Operation::Sinh:
            return {std::cosh(a), 0.0};
        case Operation::Cosh:
            return {std::sinh(a), 0.0};
        case Operation::Tanh:
            return {1.0 - result * result, 0.0};
        case Operation::Add:
            return {1.0, 1.0};
        case Operation::Subtract:
            return {1.0, -1.0};
        case Operation::Multiply:
            return {b, a};
        case Operation::Divide:
            return {1.0 / b, -result / b};
        case Operation::RealPower:
            return {b * real_power(a, b - 1.0), result * std::log(a)};
        case Operation::Atan2: {
            const double size = a * a + b * b;
            return {b / size, -a / size};
        }
        case Operation::Min:
            return a < b || std::isnan(a) ? std::pair(1.0, 0.0) : std::pair(0.0, 1.0);
        case Operation::Max:
            return a > b || std::isnan(a) ? std::pair(1.0, 0.0) : std::pair(0.0, 1.0);
        default:
            return {0.0, 0.0};
    }
}

std::pair<Interval, Interval> derivatives(Operation operation, const Interval& a, const Interval& b,
                                          double number, const Interval& result)
{
    const Interval none(0.0), one(1.0);
    switch (operation) {
        case Operation::Negate:
            return {Interval(-1.0), none};
        case Operation::Abs:
            return {crease(a, -1.0, 1.0), none};
        case Operation::Square:
            return {Interval(2.0) * a, none};
        case Operation::Power:
            return {Interval(number) * whole_power(a, static_cast<int>(number) - 1), none};
        case Operation::Sqrt: {
            const Interval slope = Interval(0.5) / result;
            return {{std::max(0.0, slope.lo), slope.hi}, none};
        }
        case Operation::Cbrt: {
            const Interval slope = one / (Interval(3.0) * square(result));
            return {{std::max(0.0, slope.lo), slope.hi}, none};
        }
        case Operation::Exp:
            return {result, none};
        case Operation::Log: {
            const Interval slope = one / clipped(a, 0.0, kInfinity);
            return {{std::max(0.0, slope.lo), slope.hi}, none};
        }
        case Operation::Sin:
            return {cosine(a), none};
        case Operation::Cos:
            return {-sine(a), none};
        case Operation::Tan:
            return {one + square(result), none};
        case Operation::Asin:
        case Operation::Acos: {
            const Interval slope = one / sqrt(one - square(clipped(a, -1.0, 1.0)));
            const Interval rises{std::max(0.0, slope.lo), slope.hi};
            return {operation == Operation::Asin ? rises : -rises, none};
        }
        case Operation::Atan:
            return {one / (one + square(a)), none};
        case Operation::Sinh:
            return {hyperbolic_cosine(a), none};
        case Operation::Cosh:
            return {rising([](double x) { return std::sinh(x); }, a), none};
        case Operation::Tanh: {
            const Interval slope = one - square(result);
            return {{std::max(0.0, slope.lo), std::min(1.0, slope.hi)}, none};
        }
        case Operation::Floor:
        case Operation::Ceil:
        case Operation::Round:
        case Operation::Sign:
            return {step(result), none};
        case Operation::Add:
            return {one, one};
        case Operation::Subtract:
            return {one, Interval(-1.0)};
        case Operation::Multiply:
            return {b, a};
        case Operation::Divide:
            return {one / b, -(result / b)};
        case Operation::RealPower: {
            if (a.lo < 0.0) return {kAnySlope, kAnySlope};
            const Interval slope = b * real_power(a, b - one);
            const Interval rising_log =
                a.lo > 0.0 ? rising([](double x) { return std::log(x); }, a) : kAnySlope;
            return {slope, result * rising_log};
        }
        case Operation::Atan2: {
            if (b.lo <= 0.0 && a.contains(0.0)) return {kAnySlope, kAnySlope};  // may jump
            const Interval size = square(a) + square(b);
            return {b / size, -(a / size)};
        }
        case Operation::Min: {
            const Interval d = crease(a - b, 1.0, 0.0);
            return {d, {1.0 - d.hi, 1.0 - d.lo}};
        }
        case Operation::Max: {
            const Interval d = crease(a - b, 0.0, 1.0);
            return {d, {1.0 - d.hi, 1.0 - d.lo}};
        }
        default:
            return {none, none};
    }
}

SecondDerivatives second_derivatives(Operation operation, const Interval& a, const Interval& b,
                                     double number, const Interval& result)
{
    const Interval none(0.0), one(1.0), two(2.0);
    const auto not_negative = [](const Interval& x) {
        return Interval(std::max(0.0, x.lo), std::max(0.0, x.hi));
    };
    switch (operation) {
        case Operation::Negate:
        case Operation::Add:
        case Operation::Subtract:
            return {};
        case Operation::Multiply:
            return {none, one, none};
        case Operation::Square:
            return {two, none, none};
        case Operation::Power: {
            const double factor = number * (number - 1.0);
            if (factor == 0.0) return {};
            return {Interval(factor) * whole_power(a, static_cast<int>(number) - 2), none, none};
        }
        case Operation::Sqrt:
            return {-not_negative(Interval(0.25) / (result * square(result))), none, none};
        case Operation::Cbrt: {
            const Interval fifth = square(square(result)) * result;
            return {-(Interval(2.0) / (Interval(9.0) * fifth)), none, none};
        }
        case Operation::Exp:
        case Operation::Sinh:
        case Operation::Cosh:
            return {result, none, none};
        case Operation::Log:
            return {-not_negative(one / square(clipped(a, 0.0, kInfinity))), none, none};
        case Operation::Sin:
        case Operation::Cos:
            return {-result, none, none};
        case Operation::Tan:
            return {two * result * (one + square(result)), none, none};
        case Operation::Asin:
        case Operation::Acos: {
            const Interval x = clipped(a, -1.0, 1.0);
            const Interval rest = not_negative(one - square(x));
            const Interval bend = x / (rest * sqrt(rest));
            return {operation == Operation::Asin ? bend : -bend, none, none};
        }
        case Operation::Atan:
            return {-(two * a / square(one + square(a))), none, none};
        case Operation::Tanh:
            return {-(two * result * clipped(one - square(result), 0.0, 1.0)), none, none};
        case Operation::Divide: {
            const Interval over = one / b;
            return {none, -square(over), two * result * square(over)};
        }
        case Operation::RealPower: {
            if (!(a.lo > 0.0)) return {kAnySlope, kAnySlope, kAnySlope};
            const Interval log = rising([](double x) { return std::log(x); }, a);
            const Interval lower = real_power(a, b - one);
            return {b * (b - one) * real_power(a, b - two), lower * (one + b * log),
                    result * square(log)};
        }
        case Operation::Atan2: {
            const Interval size = square(a) + square(b);
            const bool may_jump = b.lo <= 0.0 && a.contains(0.0);
            if (may_jump || !(size.lo > 0.0)) return {kAnySlope, kAnySlope, kAnySlope};
            const Interval squared = square(size), twice = two * a * b / squared;
            return {-twice, (square(a) - square(b)) / squared, twice};
        }
        default:
            return {kAnySlope, kAnySlope, kAnySlope};
    }
}

}  // namespace genus
