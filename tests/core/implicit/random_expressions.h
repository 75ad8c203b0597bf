#pragma once

#include <array>
#include <cstdlib>
#include <random>
#include <string>

#include "genus/implicit/function.h"
#include "genus/implicit/parse_expression.h"

namespace genus {

inline Function compiled(const std::string& text)
{
    return Function(parse_expression(text));
}

inline Vec3 random_point(std::mt19937& random, double reach = 2.0)
{
    std::uniform_real_distribution<double> number(-reach, reach);
    return {{number(random), number(random), number(random)}};
}

// Any tree of any operations, numbers among them nice and odd ones.
inline Expression random_expression(std::mt19937& random, int depth)
{
    std::uniform_int_distribution<int> choice(0, 99);
    if (depth == 0 || choice(random) < 15) {
        constexpr std::array<double, 6> numbers{0.0, 1.0, -2.0, 0.5, 3.0, 1e-3};
        switch (choice(random) % 4) {
            case 0:
                return Expression::x();
            case 1:
                return Expression::y();
            case 2:
                return Expression::z();
            default:
                return numbers[static_cast<std::size_t>(choice(random)) % numbers.size()];
        }
    }
    std::uniform_int_distribution<int> which(static_cast<int>(Operation::Negate),
                                             static_cast<int>(Operation::Max));
    const auto operation = static_cast<Operation>(which(random));
    const Expression a = random_expression(random, depth - 1);
    if (operation == Operation::Power) return pow(a, choice(random) % 9 - 4);
    if (operand_count(operation) == 1) return Expression::apply(operation, a);
    return Expression::apply(operation, a, random_expression(random, depth - 1));
}

inline int trials(int few, int many)
{
    return std::getenv("GENUS_LONG") ? many : few;
}

}  // namespace genus
