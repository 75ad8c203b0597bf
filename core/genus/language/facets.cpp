#include "genus/language/facets.h"

#include <algorithm>
#include <cmath>

namespace genus::language {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kTiny = 0.00000095367431640625;  // 2^-20: smaller circles are triangles
constexpr double kMost = 100'000'000.0;

}  // namespace

int Facets::fragments(double r) const
{
    if (!(r >= kTiny) || std::isinf(fn) || std::isnan(fn)) return 3;
    if (fn > 0.0) return static_cast<int>(std::min(std::max(fn, 3.0), kMost));
    const double sides = std::max(std::min(360.0 / fa, r * 2 * kPi / fs), 5.0);
    return static_cast<int>(std::min(std::ceil(sides), kMost));
}

int Facets::round_fragments(double r) const
{
    if (tolerance > 0.0 && !(fn > 0.0)) return 0;
    return fragments(r);
}

}  // namespace genus::language
