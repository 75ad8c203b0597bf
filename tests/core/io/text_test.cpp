#include "genus/io/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include "genus/io/number_format.h"

namespace genus::io {
namespace {

double parsed(const std::string& text)
{
    double value = 0.0;
    const char* end = text.data() + text.size();
    EXPECT_EQ(parse_number(text.data(), end, value), end) << text;
    return value;
}

// The C library rounds correctly.
void expect_correctly_rounded(const std::string& text)
{
    const double expected = std::strtod(text.c_str(), nullptr);
    const double value = parsed(text);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected)) << text;
}

std::string random_digits(std::mt19937_64& random, int n)
{
    std::string digits;
    for (int i = 0; i < n; ++i) digits.push_back(static_cast<char>('0' + random() % 10));
    return digits;
}

TEST(ParseNumber, RoundsLikeTheCLibraryInEveryShape)
{
    const int rounds = std::getenv("GENUS_LONG") != nullptr ? 20'000'000 : 200'000;
    std::mt19937_64 random(20240611);
    for (int i = 0; i < rounds; ++i) {
        std::string text = random() % 2 == 0 ? "-" : "";
        text += random_digits(random, static_cast<int>(random() % 6));
        if (random() % 4 != 0)
            text.append(1, '.').append(random_digits(random, static_cast<int>(random() % 22)));
        if (text.find_first_of("0123456789") == std::string::npos) text += "7";
        if (random() % 4 == 0)
            text.append(1, 'e').append(std::to_string(static_cast<int>(random() % 60) - 30));
        expect_correctly_rounded(text);
    }
}

TEST(ParseNumber, ReadsBackEveryDoubleItWrites)
{
    std::mt19937_64 random(7);
    for (int i = 0; i < 200'000; ++i) {
        double value = std::bit_cast<double>(random());
        if (i % 2 == 0) value = std::ldexp(static_cast<double>(random() >> 11), -53);
        if (!std::isfinite(value)) continue;
        char text[kNumberChars];
        EXPECT_EQ(parsed(std::string(text, put_number(text, value))), value);
    }
}

// Texts next to the middle between two doubles, where one digit far behind decides.
TEST(ParseNumber, DecidesHalfwayCasesByTheLastDigit)
{
    for (const char* text :
         {"9007199254740993", "9007199254740993.0", "9007199254740992.9999",
          "0.5000000000000000277", "9007199254740993.00000000000000000000001",
          "1.00000000000000011102230246251565",
          "1.000000000000000111022302462515654042363166809082031250000001",
          "1.00000000000000011102230246251565404236316680908203125", "4503599627370496.5",
          "4503599627370497.5", "18446744073709551615", "1844674407370955161.5",
          "0.1844674407370955161", "1e23", "8.5e22", "9e-23", "1e22", "1e-22"})
        expect_correctly_rounded(text);
}

TEST(ParseNumber, TakesTheEdgesOfTheRange)
{
    expect_correctly_rounded("1.7976931348623157e308");
    expect_correctly_rounded("4.9406564584124654e-324");
    expect_correctly_rounded("2.2250738585072011e-308");
    EXPECT_EQ(parsed("1e-400"), 0.0);
    EXPECT_EQ(parsed("1e-99999999999999999999"), 0.0);
    EXPECT_EQ(parsed("0e99999999999999999999"), 0.0);
    EXPECT_EQ(parsed("0." + std::string(500, '0') + "1e100"), 0.0);
    EXPECT_EQ(parsed(std::string(500, '0').append("1.5")), 1.5);
    EXPECT_EQ(parsed("0." + std::string(500, '0') + "1e501"), 1.0);
    EXPECT_TRUE(std::signbit(parsed("-0")));
    EXPECT_TRUE(std::signbit(parsed("-1e-400")));
    EXPECT_EQ(parsed("+2.5"), 2.5);
    EXPECT_EQ(parsed("1."), 1.0);
    EXPECT_EQ(parsed(".5"), 0.5);
}

TEST(ParseNumber, RefusesWhatIsNoFiniteNumber)
{
    for (const std::string text :
         {"", "-", ".", "e5", "x", "nan", "NaN", "-nan(ind)", "inf", "-Infinity", "1e", "1e+",
          "1e400", "-1e400", "1e99999999999999999999", "--1", "+-1"}) {
        double value = 0.0;
        EXPECT_THROW(parse_number(text.data(), text.data() + text.size(), value), TextFault)
            << text;
    }
}

TEST(ParseNumber, StopsBeforeWhatDoesNotBelongToIt)
{
    const std::string text = "12.5,7";
    double value = 0.0;
    EXPECT_EQ(parse_number(text.data(), text.data() + text.size(), value), text.data() + 4);
    EXPECT_EQ(value, 12.5);
}

TEST(ParseInteger, RefusesWhatDoesNotFit)
{
    for (const std::string text : {"", "-", "a", "9999999999999999999999", "1234567890123456789"}) {
        std::int64_t value = 0;
        EXPECT_THROW(parse_integer(text.data(), text.data() + text.size(), value), TextFault);
    }
    const std::string text = "-123456789012345678";
    std::int64_t value = 0;
    parse_integer(text.data(), text.data() + text.size(), value);
    EXPECT_EQ(value, -123456789012345678);
}

TEST(LineNumber, CountsEachKindOfLineEnding)
{
    const std::string unix_text = "a\nb\nc";
    EXPECT_EQ(line_number(unix_text, unix_text.data()), 1);
    EXPECT_EQ(line_number(unix_text, unix_text.data() + 4), 3);
    const std::string dos_text = "a\r\nb\r\nc";
    EXPECT_EQ(line_number(dos_text, dos_text.data() + 6), 3);
    const std::string mac_text = "a\rb\rc";
    EXPECT_EQ(line_number(mac_text, mac_text.data() + 4), 3);
}

TEST(ShownWord, IsShortAndWithoutControlCharacters)
{
    const std::string text = "a\x01\xff" + std::string(100, 'b');
    EXPECT_EQ(shown_word(text.data(), text.data() + text.size()),
              "'a??" + std::string(21, 'b') + "'");
}

}  // namespace
}  // namespace genus::io
