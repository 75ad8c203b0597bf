#include "genus/io/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace genus::io {

namespace {

__extension__ using Uint128 = unsigned __int128;

constexpr int kExactPower = 22;    // 10^22 is the largest power of ten that is a double
constexpr int kIntegerPower = 19;  // 10^19 is the largest that is a 64-bit integer
constexpr int kMaxDigits = 19;     // so many digits fit a 64-bit integer

constexpr std::array<double, kExactPower + 1> kPowers = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

constexpr std::array<std::uint64_t, kIntegerPower + 1> integer_powers()
{
    std::array<std::uint64_t, kIntegerPower + 1> powers{};
    std::uint64_t power = 1;
    for (std::uint64_t& entry : powers) {
        entry = power;
        power *= 10;
    }
    return powers;
}
constexpr auto kIntegerPowers = integer_powers();

std::uint64_t load_8(const char* p)
{
    std::uint64_t word;
    std::memcpy(&word, p, 8);
    if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
    return word;
}

// Whether all eight bytes are '0' to '9': the high halves are 3, and stay 3 when 6 is added.
bool eight_digits(std::uint64_t word)
{
    constexpr std::uint64_t high = 0xF0F0F0F0F0F0F0F0;
    constexpr std::uint64_t threes = 0x3030303030303030;
    constexpr std::uint64_t sixes = 0x0606060606060606;
    return ((word & high) == threes) && (((word + sixes) & high) == threes);
}

// The number that eight digits spell, the first in the lowest byte: digits are joined to pairs,
// pairs to fours, fours to the whole.
std::uint64_t eight_digit_value(std::uint64_t word)
{
    word = (word & 0x0F0F0F0F0F0F0F0F) * (10 * 0x100 + 1) >> 8;
    word = (word & 0x00FF00FF00FF00FF) * (100 * 0x10000 + 1) >> 16;
    return (word & 0x0000FFFF0000FFFF) * (10000 * 0x100000000 + 1) >> 32;
}

// digits / 10^k, rounded to nearest, for digits > 0 and 1 <= k <= 19. Both sides are shifted to
// full 64 bits, the quotient has 63 bits or more, and its lowest bit is set where a remainder is
// left: rounding that to 53 bits is rounding the true quotient.
double divided_by_power(std::uint64_t digits, int k)
{
    const int shift = std::countl_zero(digits);
    const int power_shift = std::countl_zero(kIntegerPowers[k]);
    const Uint128 numerator = static_cast<Uint128>(digits << shift) << 63;
    const std::uint64_t divisor = kIntegerPowers[k] << power_shift;
    const auto quotient = static_cast<std::uint64_t>(numerator / divisor);
    const bool exact = static_cast<Uint128>(quotient) * divisor == numerator;
    const auto rounded = static_cast<double>(quotient | (exact ? 0 : 1));
    const auto exponent = static_cast<std::uint64_t>(1023 + power_shift - shift - 63);
    return rounded * std::bit_cast<double>(exponent << 52);
}

[[noreturn]] void throw_not_a_number(const char* p, const char* end)
{
    throw TextFault{p, shown_word(p, end) + " is not a number"};
}

[[noreturn]] void throw_not_finite(const char* p, const char* end)
{
    throw TextFault{p, shown_word(p, end) + " is not a finite number"};
}

[[noreturn]] void throw_no_digits(const char* start, const char* p, const char* end)
{
    std::string word(p, std::min(end, p + 3));
    for (char& c : word) c = to_lower(c);
    if (word == "nan" || word == "inf") throw_not_finite(start, end);
    throw_not_a_number(start, end);
}

// Whether the first digit of [p, stop) other than 0 stands for 1 or more, `exponent` being what
// follows the letter e.
bool at_least_one(const char* p, const char* stop, std::int64_t exponent)
{
    const char* point =
        std::find_if(p, stop, [](char c) { return c == '.' || to_lower(c) == 'e'; });
    const char* first = std::find_if(p, stop, [](char c) { return c >= '1' && c <= '9'; });
    return exponent + (first < point ? point - first : point - first + 1) > 0;
}

// The number in [p, stop). std::from_chars does not say whether it is too large or too small.
double parse_slowly(const char* p, const char* stop, std::int64_t exponent)
{
    if (*p == '+') ++p;
    double value = 0.0;
    const std::from_chars_result result = std::from_chars(p, stop, value);
    if (result.ec == std::errc::result_out_of_range) {
        if (at_least_one(p, stop, exponent)) throw_not_finite(p, stop);
        return *p == '-' ? -0.0 : 0.0;
    }
    if (result.ec != std::errc{} || result.ptr != stop) throw_not_a_number(p, stop);
    return value;
}

const char* parse_exponent(const char* start, const char* p, const char* end,
                           std::int64_t& exponent)
{
    const bool negative = p != end && *p == '-';
    if (p != end && (*p == '-' || *p == '+')) ++p;
    if (p == end || !is_digit(*p)) throw_not_a_number(start, end);
    std::int64_t value = 0;
    for (; p != end && is_digit(*p); ++p)
        if (value < 1'000'000'000) value = 10 * value + (*p - '0');
    exponent += negative ? -value : value;
    return p;
}

}  // namespace

std::int64_t line_number(std::string_view text, const char* at)
{
    const char* begin = text.data();
    const char* end = begin + text.size();
    const char separator = text.find('\n') == std::string_view::npos ? '\r' : '\n';
    return 1 + std::count(begin, std::min(at, end), separator);
}

std::string_view first_word(std::string_view text)
{
    return TextCursor(text).word();
}

std::string shown_word(const char* p, const char* end)
{
    constexpr std::ptrdiff_t longest = 24;
    const char* stop = std::min(end, p + std::min(end - p, longest));
    std::string word(1, '\'');
    word.append(p, std::find_if(p, stop, is_space));
    for (char& c : word)
        if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
    word.push_back('\'');
    return word;
}

const char* parse_number(const char* p, const char* end, double& value)
{
    const char* start = p;
    const bool negative = p != end && *p == '-';
    if (p != end && (*p == '-' || *p == '+')) ++p;

    std::uint64_t digits = 0;
    const char* whole = p;
    for (; p != end && is_digit(*p); ++p) digits = 10 * digits + (*p - '0');
    std::int64_t n_whole = p - whole;
    const bool whole_is_zero = digits == 0 && n_whole <= kMaxDigits;
    std::int64_t n_fraction = 0;
    if (p != end && *p == '.') {
        const char* fraction = ++p;
        for (std::uint64_t word; end - p >= 8 && eight_digits(word = load_8(p)); p += 8)
            digits = 100'000'000 * digits + eight_digit_value(word);
        for (; p != end && is_digit(*p); ++p) digits = 10 * digits + (*p - '0');
        n_fraction = p - fraction;
    }
    if (n_whole + n_fraction == 0) throw_no_digits(start, whole, end);
    std::int64_t exponent = -n_fraction;
    if (p != end && (*p == 'e' || *p == 'E')) p = parse_exponent(start, p + 1, end, exponent);

    const std::int64_t n_digits = (whole_is_zero ? 0 : n_whole) + n_fraction;
    constexpr std::uint64_t exact_integers = std::uint64_t{1} << 53;
    if (n_digits > kMaxDigits) {
        value = parse_slowly(start, p, exponent + n_fraction);
    } else if (digits <= exact_integers && -kExactPower <= exponent && exponent <= kExactPower) {
        const auto whole_number = static_cast<double>(digits);
        value = exponent < 0 ? whole_number / kPowers[-exponent] : whole_number * kPowers[exponent];
        value = negative ? -value : value;
    } else if (-kIntegerPower <= exponent && exponent < 0) {
        value = divided_by_power(digits, static_cast<int>(-exponent));
        value = negative ? -value : value;
    } else {
        value = parse_slowly(start, p, exponent + n_fraction);
    }
    return p;
}

const char* parse_integer(const char* p, const char* end, std::int64_t& value)
{
    const char* start = p;
    const bool negative = p != end && *p == '-';
    if (p != end && (*p == '-' || *p == '+')) ++p;
    const char* first = p;
    std::int64_t magnitude = 0;
    for (; p != end && is_digit(*p) && p - first < 18; ++p) magnitude = 10 * magnitude + (*p - '0');
    if (p == first) throw TextFault{start, shown_word(start, end) + " is not an integer"};
    if (p != end && is_digit(*p))
        throw TextFault{start, "the integer " + shown_word(start, end) + " is too large"};
    value = negative ? -magnitude : magnitude;
    return p;
}

}  // namespace genus::io
