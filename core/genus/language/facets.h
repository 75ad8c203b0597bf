#pragma once

namespace genus::language {

/// How round shapes are cut: the special variables $fn, $fa, $fs and $tolerance.
struct Facets {
    /// Below it, $fs and $fa are taken for this.
    static constexpr double kSmallest = 0.01;

    double fn = 0.0;         // sides, where above 0
    double fa = 12.0;        // least angle of a side, degrees
    double fs = 2.0;         // least length of a side
    double tolerance = 0.0;  // above 0: round shapes without $fn stay exact

    /// Sides of a circle of radius r: $fn, but at least 3; without it as many as $fa and $fs
    /// allow, but at least 5.
    int fragments(double r) const;
    /// The same, but 0, the exact shape, where a tolerance asks for it.
    int round_fragments(double r) const;
};

}  // namespace genus::language
