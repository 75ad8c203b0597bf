#pragma once

#include <algorithm>
#include <cmath>

#include "genus/base/box.h"
#include "genus/boolean/exact_point.h"

namespace genus::exact {

inline constexpr double kCloseSteps = 8.0;  // within which coordinates are meant to be equal
inline constexpr double kCloseUnits = 4.0;  // the same in units in the last place

/// An integer grid over a box: x = origin + 2^exponent X with |X| below kGridLimit.
class Frame {
public:
    explicit Frame(const Box3& box)
    {
        const Vec3 half = 0.5 * box.max - 0.5 * box.min;
        const double reach = std::max({half[0], half[1], half[2]});
        int power = 0;
        std::frexp(reach, &power);  // reach < 2^power
        exponent_ = std::max(power - 53, -1074) - 1;
        do {
            ++exponent_;
            place_origin(box.center());
        } while (farthest(box) > kGridLimit);
        if (std::abs(exponent_) < 1000) {
            step_ = std::ldexp(1.0, exponent_);
            per_step_ = std::ldexp(1.0, -exponent_);
        }
        for (int k = 0; k < 3; ++k) {
            int digits = 0;
            std::frexp(std::max(std::abs(box.min[k]), std::abs(box.max[k])), &digits);
            unit_[k] = std::ldexp(1.0, std::max(0, digits - 53 - exponent_));
        }
    }

    bool same_grid(const Frame& o) const
    {
        return exponent_ == o.exponent_ && origin_ == o.origin_;
    }

    double step() const { return std::ldexp(1.0, exponent_); }

    /// The nearest grid point; `off` grows to the distance, in steps, where that is larger.
    Vec3 to_grid(const Vec3& p, double& off) const
    {
        Vec3 grid;
        for (int k = 0; k < 3; ++k) {
            // The difference as a sum of two doubles, exactly.
            const double d = p[k] - origin_[k];
            const double o = p[k] - d;
            const double rest = (p[k] - (d + o)) + (o - origin_[k]);
            const double scaled = in_steps(d);
            const double tail = in_steps(rest);
            double whole = std::nearbyint(scaled);
            double part = (scaled - whole) + tail;
            if (std::abs(part) > 0.5) {
                const double one = std::copysign(1.0, part);
                whole += one;
                part -= one;
            }
            grid[k] = whole + 0.0;  // no negative zero
            off = std::max(off, std::abs(part));
        }
        return grid;
    }
    Vec3 from_grid(const Vec3& grid) const
    {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = origin_[k] + in_units(grid[k]);
        return p;
    }
    /// The grid point nearest to `p` that is a triple of doubles in model units.
    Vec3 rounded(const Vec3& p) const
    {
        Vec3 whole;
        for (int k = 0; k < 3; ++k) whole[k] = std::nearbyint(p[k]);
        double off = 0.0;
        return to_grid(from_grid(whole), off);
    }
    /// The nearest point of a grid coarser by `bits` than doubles of the largest coordinate are.
    Vec3 coarsened(const Vec3& p, int bits) const
    {
        Vec3 q;
        for (int k = 0; k < 3; ++k) {
            const double unit = std::ldexp(unit_[k], bits);
            q[k] = std::clamp(std::nearbyint(p[k] / unit) * unit, -kGridLimit, kGridLimit);
        }
        return q;
    }
    /// Distances, in steps, within which coordinates are meant to be equal: a few roundings.
    Vec3 close(double most_snap) const
    {
        Vec3 reach;
        for (int k = 0; k < 3; ++k)
            reach[k] =
                std::max(kCloseSteps, std::min(kCloseUnits * unit_[k], most_snap * kGridLimit));
        return reach;
    }
    /// What `rounded` may move a coordinate by at most, in steps.
    double rounding() const { return 1.0 + std::max({unit_[0], unit_[1], unit_[2]}); }
    /// What `coarsened` may move a coordinate by, as a share of the size of the box.
    double coarseness(int bits) const
    {
        return 0.5 * std::ldexp(std::max({unit_[0], unit_[1], unit_[2]}), bits) / kGridLimit;
    }

private:
    // Products with a power of two that is a double are those of ldexp, sooner had.
    double in_steps(double x) const
    {
        return per_step_ != 0.0 ? x * per_step_ : std::ldexp(x, -exponent_);
    }
    double in_units(double x) const { return step_ != 0.0 ? x * step_ : std::ldexp(x, exponent_); }

    void place_origin(const Vec3& center)
    {
        for (int k = 0; k < 3; ++k)
            origin_[k] = std::ldexp(std::nearbyint(std::ldexp(center[k], -exponent_)), exponent_);
    }
    double farthest(const Box3& box) const
    {
        double far = 0.0;
        double off = 0.0;
        for (const Vec3& p : {to_grid(box.min, off), to_grid(box.max, off)})
            for (int k = 0; k < 3; ++k) far = std::max(far, std::abs(p[k]));
        return far;
    }

    Vec3 origin_;
    Vec3 unit_;  // unit in the last place of the largest coordinates, in steps
    int exponent_;
    double step_ = 0.0, per_step_ = 0.0;  // 2^exponent and 2^-exponent; 0 where they may be none
};

}  // namespace genus::exact
