#pragma once

#include <array>
#include <cstdint>

#include "genus/base/vec.h"

namespace genus::exact {

/// A triangle or a strictly convex quadrangle of grid points in one plane, as `find_contact` sees
/// it. Equal points have equal numbers.
struct Corners {
    int n = 3;
    std::array<std::int32_t, 4> id;
    std::array<const Vec3*, 4> at;

    int next(int i) const { return i + 1 == n ? 0 : i + 1; }
};

/// Where two such pieces of planes meet, as far as it says something about their arrangement.
struct Contact {
    /// Places in a piece: 0 to 3 a corner, 4 to 7 the inside of the edge that starts at corner
    /// 0 to 3, 8 the inside.
    static constexpr std::int8_t kEdge = 4;
    static constexpr std::int8_t kInside = 8;
    static bool is_corner(int place) { return place < kEdge; }
    static bool is_edge(int place) { return place >= kEdge && place < kInside; }
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

/// Numbers the corners of f 0 to 3 and those of g 4 to 7, those of g at the place of one of f like
/// that.
void number_corners(Corners& f, Corners& g);

/// The edge of a piece on which, ends included, both places lie; -1 if there is none.
int edge_along(const Corners& piece, int a, int b);

/// True only if the pieces meet in nothing but corners of equal numbers, because the other
/// corners of one lie strictly on one side of the other. Exact and cheap.
bool certainly_apart(const Corners& f, const Corners& g);

/// Exact. Both must have an area.
Contact find_contact(const Corners& f, const Corners& g);

}  // namespace genus::exact
