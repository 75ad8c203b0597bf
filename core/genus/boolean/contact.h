#pragma once

#include <array>
#include <cstdint>

#include "genus/base/vec.h"

namespace genus::exact {

/// A triangle of grid points as `find_contact` sees it. Equal points have equal numbers.
struct Corners {
    std::array<std::int32_t, 3> id;
    std::array<const Vec3*, 3> at;
};

/// Where two triangles meet, as far as it says something about their arrangement.
struct Contact {
    /// Places in a triangle: 0 to 2 a corner, 3 to 5 the inside of the edge that starts at corner
    /// 0 to 2, 6 the inside.
    static constexpr std::int8_t kInside = 6;
    struct Event {
        std::int8_t on_f;
        std::int8_t on_g;
        bool operator==(const Event&) const = default;
    };

    /// One plane, and their insides may overlap.
    bool coplanar = false;
    /// Not coplanar: the one or two end points of what they share. Coplanar: all points where
    /// corners or edges of one meet the other. Pairs of equal corners included.
    int n_events = 0;
    std::array<Event, 16> events;

    /// Nothing beyond equal corners.
    bool trivial() const;
    void add(int on_f, int on_g);
};

/// Numbers the corners of f 0 to 2 and those of g 3 to 5, those of g at the place of one of f like
/// that.
void number_corners(Corners& f, Corners& g);

/// True only if the triangles meet in nothing but corners of equal numbers, because the other
/// corners of one lie strictly on one side of the other. Exact and cheap.
bool certainly_apart(const Corners& f, const Corners& g);

/// Exact. Both triangles must have an area.
Contact find_contact(const Corners& f, const Corners& g);

}  // namespace genus::exact
