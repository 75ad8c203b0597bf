#pragma once

#include <algorithm>
#include <limits>

#include "genus/base/vec.h"

namespace genus {

/// Axis-parallel box, closed. A new one is empty: `min` is above `max` in every axis.
template <std::size_t N>
struct Box {
    Vec<N> min = filled(std::numeric_limits<double>::infinity());
    Vec<N> max = filled(-std::numeric_limits<double>::infinity());

    static constexpr Vec<N> filled(double value)
    {
        Vec<N> v;
        for (std::size_t i = 0; i < N; ++i) v[i] = value;
        return v;
    }
    /// The box that holds all of space.
    static constexpr Box everything()
    {
        Box box;
        std::swap(box.min, box.max);
        return box;
    }

    constexpr bool operator==(const Box&) const = default;

    constexpr bool empty() const
    {
        for (std::size_t i = 0; i < N; ++i)
            if (!(min[i] <= max[i])) return true;
        return false;
    }
    bool bounded() const { return empty() || (is_finite(min) && is_finite(max)); }

    constexpr void add(const Vec<N>& p)
    {
        for (std::size_t i = 0; i < N; ++i) {
            min[i] = std::min(min[i], p[i]);
            max[i] = std::max(max[i], p[i]);
        }
    }
    constexpr void add(const Box& other)
    {
        for (std::size_t i = 0; i < N; ++i) {
            min[i] = std::min(min[i], other.min[i]);
            max[i] = std::max(max[i], other.max[i]);
        }
    }
    constexpr bool contains(const Vec<N>& p) const
    {
        for (std::size_t i = 0; i < N; ++i)
            if (!(min[i] <= p[i] && p[i] <= max[i])) return false;
        return true;
    }
    constexpr bool contains(const Box& b) const { return contains(b.min) && contains(b.max); }

    /// The corner that lies high in the axes whose bits of `k` are set, k < 2^N.
    constexpr Vec<N> corner(std::size_t k) const
    {
        Vec<N> p;
        for (std::size_t i = 0; i < N; ++i) p[i] = (k >> i & 1) != 0 ? max[i] : min[i];
        return p;
    }
    constexpr Vec<N> center() const { return 0.5 * min + 0.5 * max; }
    constexpr Vec<N> size() const { return max - min; }
    double diagonal() const { return empty() ? 0.0 : norm(size()); }

    /// Grown by `margin` to all sides.
    constexpr Box inflated(double margin) const
    {
        return {min - filled(margin), max + filled(margin)};
    }
};

using Box2 = Box<2>;
using Box3 = Box<3>;

/// Boxes that only touch do overlap.
template <std::size_t N>
constexpr bool overlap(const Box<N>& a, const Box<N>& b)
{
    for (std::size_t i = 0; i < N; ++i)
        if (!(a.min[i] <= b.max[i] && b.min[i] <= a.max[i])) return false;
    return true;
}

template <std::size_t N>
constexpr Box<N> intersection(const Box<N>& a, const Box<N>& b)
{
    Box<N> box;
    for (std::size_t i = 0; i < N; ++i) {
        box.min[i] = std::max(a.min[i], b.min[i]);
        box.max[i] = std::min(a.max[i], b.max[i]);
    }
    return box;
}

/// Distance from `p` to the box, zero inside.
template <std::size_t N>
double distance(const Box<N>& box, const Vec<N>& p)
{
    Vec<N> d;
    for (std::size_t i = 0; i < N; ++i)
        d[i] = std::max({box.min[i] - p[i], 0.0, p[i] - box.max[i]});
    return norm(d);
}

}  // namespace genus
