#pragma once

// Polygons with known area and number of triangles, for tests of any folder. Header only.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "genus/polygon/polygon.h"

namespace genus::cases {

/// Spikes of changing length round a point.
inline Ring star(int n)
{
    Ring ring;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        const double r = i % 2 ? 0.3 + 0.2 * std::sin(7 * angle) : 1.0;
        ring.push_back({{r * std::cos(angle), r * std::sin(angle)}});
    }
    return ring;
}

/// A bar with n / 2 teeth.
inline Ring comb(int n)
{
    Ring ring{{{0.5 * n, -1}}};
    for (int i = n - 2; i >= 0; --i) ring.push_back({{0.5 * i, i % 2 ? 10.0 + i % 7 : 0.0}});
    ring.push_back({{0, -1}});
    return ring;
}

/// A band wound up with n / 200 turns, at least 3.
inline Ring spiral(int n)
{
    Ring ring;
    const int half = n / 2;
    const double turns = std::max(3.0, n / 200.0);
    const auto point = [&](int i, double r) {
        const double s = 1.0 * i / half, angle = 2 * std::numbers::pi * turns * s;
        return Vec2{{(r + turns * s) * std::cos(angle), (r + turns * s) * std::sin(angle)}};
    };
    for (int i = 0; i < half; ++i) ring.push_back(point(i, 1.5));
    for (int i = half - 1; i >= 0; --i) ring.push_back(point(i, 1.0));
    return ring;
}

inline Ring circle(int n, double radius = 1.0)
{
    Ring ring;
    for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        ring.push_back({{radius * std::cos(angle), radius * std::sin(angle)}});
    }
    return ring;
}

/// The cells of a small grid that hang together with a first one by sides, some left out: rings
/// with holes that touch themselves and each other. Grid lines are moved and sheared by whole
/// numbers, so area and decisions are exact.
struct CellPolygon {
    Polygon polygon;
    double area;
    std::int64_t n_triangles;  // by Euler's formula
};

struct CellOptions {
    int size = 6;                 // cells across
    bool follow_outside = false;  // where two cells meet in a corner: holes stay apart
    bool keep_flat_corners = true;
    bool repeat_points = false;
    bool mirror = false;  // rings turn the other way
};

inline CellPolygon cell_polygon(std::mt19937& random, const CellOptions& options)
{
    const int n = options.size;
    std::vector<std::uint8_t> in((n + 2) * (n + 2), 0);
    const auto at = [&](int i, int j) -> std::uint8_t& { return in[(i + 1) * (n + 2) + j + 1]; };
    // Grow from the middle: each new cell is beside one that is in.
    at(n / 2, n / 2) = 1;
    const int wanted = 1 + static_cast<int>(random() % (n * n));
    for (int tries = 0, cells = 1; cells < wanted && tries < 40 * n * n; ++tries) {
        const int i = static_cast<int>(random() % n), j = static_cast<int>(random() % n);
        if (at(i, j) || !(at(i - 1, j) || at(i + 1, j) || at(i, j - 1) || at(i, j + 1))) continue;
        at(i, j) = 1;
        ++cells;
    }
    std::array<std::vector<std::int64_t>, 2> lines;
    for (auto& line : lines) {
        line.push_back(0);
        for (int i = 0; i < n; ++i) line.push_back(line.back() + 1 + random() % 9);
    }
    const std::int64_t shear = static_cast<std::int64_t>(random() % 5) - 2;
    const auto point = [&](int i, int j) {
        const std::int64_t y = lines[1][j] + shear * lines[0][i];
        return Vec2{{static_cast<double>(lines[0][i]), static_cast<double>(y)}};
    };

    // Directed sides, inside on the left; direction 0..3 is right, up, left, down.
    const std::array<std::array<int, 2>, 4> step{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    const auto inside_left = [&](int i, int j, int d) {  // is there a side from (i, j) along d?
        const std::array<std::array<int, 4>, 4> cells{
            {{0, 0, 0, -1}, {-1, 0, 0, 0}, {-1, -1, -1, 0}, {0, -1, -1, -1}}};
        const auto& c = cells[d];
        return at(i + c[0], j + c[1]) && !at(i + c[2], j + c[3]);
    };
    std::map<std::array<int, 3>, bool> used;
    CellPolygon out;
    std::int64_t cells = 0, grid_edges = 0, grid_points = 0, ring_points = 0, ring_edges = 0;
    std::vector<std::vector<std::array<int, 2>>> rings;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
            for (int d = 0; d < 4; ++d) {
                if (used[{i, j, d}] || !inside_left(i, j, d)) continue;
                rings.emplace_back();
                int x = i, y = j, dir = d;
                while (!used[{x, y, dir}]) {
                    used[{x, y, dir}] = true;
                    rings.back().push_back({x, y});
                    x += step[dir][0];
                    y += step[dir][1];
                    // Left first stays with the cell, right first with the outside.
                    for (const int turn :
                         {options.follow_outside ? 3 : 1, 0, options.follow_outside ? 1 : 3}) {
                        const int next = (dir + turn) % 4;
                        if (!inside_left(x, y, next)) continue;
                        dir = next;
                        break;
                    }
                }
            }
    out.area = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            if (at(i, j)) {
                ++cells;
                out.area += static_cast<double>((lines[0][i + 1] - lines[0][i]) *
                                                (lines[1][j + 1] - lines[1][j]));
            }
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            grid_points += at(i, j) || at(i - 1, j) || at(i, j - 1) || at(i - 1, j - 1);
            grid_edges += i < n && (at(i, j) || at(i, j - 1));
            grid_edges += j < n && (at(i, j) || at(i - 1, j));
        }
    std::map<std::array<int, 2>, bool> places;
    double outer_area = -1;
    for (auto& corners : rings) {
        Ring ring;
        double twice_area = 0;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const auto& b = corners[(k + corners.size() - 1) % corners.size()];
            const auto& c = corners[k];
            const auto& d = corners[(k + 1) % corners.size()];
            const Vec2 p = point(c[0], c[1]), q = point(d[0], d[1]);
            twice_area += p[0] * q[1] - p[1] * q[0];
            const bool flat = d[0] - c[0] == c[0] - b[0] && d[1] - c[1] == c[1] - b[1];
            if (flat && !options.keep_flat_corners) {
                // A flat corner stays where another ring, or another part of this one, touches.
                const bool touch = (at(c[0], c[1]) && at(c[0] - 1, c[1] - 1) &&
                                    !at(c[0] - 1, c[1]) && !at(c[0], c[1] - 1)) ||
                                   (!at(c[0], c[1]) && !at(c[0] - 1, c[1] - 1) &&
                                    at(c[0] - 1, c[1]) && at(c[0], c[1] - 1));
                if (!touch) continue;
            }
            ring.push_back(p);
            ++ring_edges;
            ring_points += !places[{c[0], c[1]}];
            places[{c[0], c[1]}] = true;
            if (options.repeat_points && random() % 4 == 0) ring.push_back(p);
        }
        if (options.mirror) std::reverse(ring.begin(), ring.end());
        const std::size_t turn = random() % ring.size();
        std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(turn), ring.end());
        if (twice_area > outer_area) {
            if (outer_area > 0) out.polygon.holes.push_back(out.polygon.outer);
            out.polygon.outer = ring;
            outer_area = twice_area;
        } else {
            out.polygon.holes.push_back(ring);
        }
    }
    // V - E + F of the region is that of its cells; 3 F = 2 E - boundary edges.
    const std::int64_t euler = grid_points - grid_edges + cells;
    out.n_triangles = 2 * ring_points - ring_edges - 2 * euler;
    return out;
}

}  // namespace genus::cases
