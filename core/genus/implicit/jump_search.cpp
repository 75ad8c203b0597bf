// Where functions jump: may_jump and jump_at_border of jump_parts.h.
#include <cmath>
#include <utility>

#include "genus/implicit/equal_parts.h"
#include "genus/implicit/jump_parts.h"
#include "genus/implicit/visit_nodes.h"

namespace genus {

namespace {

using Node = Expression::Node;

bool may_jump(Operation o)
{
    switch (o) {
        case Operation::Power:
        case Operation::Sqrt:
        case Operation::Log:
        case Operation::Tan:
        case Operation::Asin:
        case Operation::Acos:
        case Operation::Divide:
        case Operation::RealPower:
        case Operation::Atan2:
            return true;
        default:
            return is_step(o);
    }
}

struct Sample {
    Vec3 at;
    double value;
};

// Where between two samples the sign changes without a zero, if so.
std::optional<Vec3> gap(const Implicit& field, Sample a, Sample b)
{
    constexpr int kHalvings = 52;
    constexpr double kGap = 2e-5;  // of the difference before: less is left of a cube root
    const bool inside = a.value <= 0.0;
    if (inside == (b.value <= 0.0)) return std::nullopt;
    const double before = std::fabs(b.value - a.value);
    for (int step = 0; step < kHalvings; ++step) {
        const Vec3 middle = 0.5 * (a.at + b.at);
        const double value = field.value(middle);
        ((value <= 0.0) == inside ? a : b) = {middle, value};
    }
    const double left = std::fabs(b.value - a.value);
    if (std::isfinite(left) && left <= kGap * before) return std::nullopt;
    return 0.5 * (a.at + b.at);
}

}  // namespace

bool may_jump(const Expression& expression)
{
    bool may = false;
    visit_nodes(expression, [&](const Node& n) { may = may || may_jump(n.operation); });
    return may;
}

std::optional<Vec3> jump_at_border(const Implicit& field, const Box3& box)
{
    constexpr std::size_t kSamples = 17;
    // Off the middle, where planes of symmetry are.
    constexpr Vec3 kShift{{0.4142, 0.5858, 0.3660}};
    std::vector<Vec3> points;
    points.reserve(kSamples * kSamples * kSamples);
    for (std::size_t k = 0; k < kSamples; ++k)
        for (std::size_t j = 0; j < kSamples; ++j)
            for (std::size_t i = 0; i < kSamples; ++i) {
                const Vec3 at{
                    {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}};
                Vec3 p = box.min;
                for (std::size_t c = 0; c < 3; ++c)
                    p[c] += (at[c] + kShift[c]) / kSamples * (box.max[c] - box.min[c]);
                points.push_back(p);
            }
    std::vector<double> values(points.size());
    field.values(points, values);
    for (std::size_t n = 0; n < points.size(); ++n) {
        std::size_t rest = n, step = 1;
        for (int axis = 0; axis < 3; ++axis, rest /= kSamples, step *= kSamples) {
            if (rest % kSamples + 1 == kSamples) continue;
            const std::size_t m = n + step;
            if (auto place = gap(field, {points[n], values[n]}, {points[m], values[m]}))
                return place;
        }
    }
    return std::nullopt;
}

}  // namespace genus
