#pragma once

#include <span>
#include <string>
#include <string_view>

namespace genus::io {

struct LengthUnit {
    std::string_view name;
    double millimetres;
};

constexpr LengthUnit k3mfUnits[] = {{"millimeter", 1.0}, {"inch", 25.4},  {"meter", 1000.0},
                                    {"micron", 0.001},   {"foot", 304.8}, {"centimeter", 10.0}};
constexpr LengthUnit kAmfUnits[] = {{"millimeter", 1.0}, {"inch", 25.4},  {"meter", 1000.0},
                                    {"micron", 0.001},   {"feet", 304.8}, {"micrometer", 0.001}};

/// Its length in millimetres; throws std::string, a problem, where `units` has none of that name.
inline double unit_length(std::span<const LengthUnit> units, std::string_view name)
{
    for (const LengthUnit& unit : units)
        if (unit.name == name) return unit.millimetres;
    throw "'" + std::string(name.substr(0, 24)) + "' is not a unit of length";
}

/// How coordinates with a unit of so many millimetres are written in a format with these units:
/// under its name, or else scaled to millimetres. An unknown one, 0, counts as millimetres.
struct UnitScale {
    UnitScale(std::span<const LengthUnit> units, double millimetres)
    {
        if (millimetres <= 0.0) return;
        for (const LengthUnit& unit : units) {
            if (unit.millimetres != millimetres) continue;
            name = unit.name;
            return;
        }
        factor = millimetres;
    }

    std::string name = "millimeter";
    double factor = 1.0;
};

}  // namespace genus::io
