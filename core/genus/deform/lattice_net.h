#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "genus/base/halves.h"
#include "genus/deform/ffd.h"

// Nets of coefficients in three variables, internal to the sources of Lattice.
namespace genus {
namespace lattice {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

inline std::size_t at(int i)
{
    return static_cast<std::size_t>(i);
}

inline double determinant(const Columns3& m)
{
    return dot(m[0], cross(m[1], m[2]));
}

inline Vec3 times(const Columns3& m, const Vec3& v)
{
    return v[0] * m[0] + v[1] * m[1] + v[2] * m[2];
}

// Columns of the inverse.
inline Columns3 inverted(const Columns3& m)
{
    const double d = determinant(m);
    const Vec3 r0 = cross(m[1], m[2]) / d, r1 = cross(m[2], m[0]) / d, r2 = cross(m[0], m[1]) / d;
    return {Vec3{{r0[0], r1[0], r2[0]}}, Vec3{{r0[1], r1[1], r2[1]}}, Vec3{{r0[2], r1[2], r2[2]}}};
}

inline bool in_unit_cube(const Vec3& s)
{
    return Box3{{}, {{1, 1, 1}}}.contains(s);
}

inline double volume(const Box3& box)
{
    const Vec3 size = box.size();
    return size[0] * size[1] * size[2];
}

// Coefficients c_ijk of three variables, the last index running fastest.
template <class V>
struct Net3 {
    std::array<int, 3> n;  // numbers of coefficients, degree + 1
    std::vector<V> c;

    std::size_t stride(int axis) const
    {
        return axis == 2 ? 1 : axis == 1 ? at(n[2]) : at(n[1]) * at(n[2]);
    }
    // First coefficients of all lines along an axis.
    template <class F>
    void for_lines(int axis, const F& f) const
    {
        const std::size_t step = stride(axis), length = step * at(n[at(axis)]);
        for (std::size_t block = 0; block < c.size(); block += length)
            for (std::size_t k = 0; k < step; ++k) f(block + k);
    }
};

// Applies f, which maps the coefficients of a line to those of another, to all lines.
template <class V, class F>
Net3<V> by_lines(const Net3<V>& net, int axis, const F& f)
{
    const std::size_t step = net.stride(axis);
    std::vector<V> line(at(net.n[at(axis)]));
    Net3<V> result{net.n, {}};
    net.for_lines(axis, [&](std::size_t first) {
        for (std::size_t k = 0; k < line.size(); ++k) line[k] = net.c[first + k * step];
        const std::vector<V> image = f(line);
        if (result.c.empty()) {
            result.n[at(axis)] = static_cast<int>(image.size());
            result.c.resize(net.c.size() / line.size() * image.size());
        }
        // The same line in the new net: only the count along the axis has changed.
        const std::size_t outer = first / (step * line.size()), inner = first % step;
        const std::size_t new_first = outer * step * image.size() + inner;
        for (std::size_t k = 0; k < image.size(); ++k) result.c[new_first + k * step] = image[k];
    });
    return result;
}

// Coefficients over the halves along an axis.
template <class V>
std::array<Net3<V>, 2> halves(const Net3<V>& net, std::size_t axis)
{
    std::array<Net3<V>, 2> parts;
    for (const std::size_t upper : {0u, 1u})
        parts[upper] = by_lines(net, static_cast<int>(axis), [&](const std::vector<V>& line) {
            std::vector<V> low, high;
            bernstein::split<V>(line, 0.5, low, high);
            return upper != 0 ? high : low;
        });
    return parts;
}

template <class V>
Net3<V> part_of(Net3<V> net, const Box3& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        const double a = box.min[at(axis)], b = box.max[at(axis)];
        if (a == 0.0 && b == 1.0) continue;
        net = by_lines(net, axis, [&](const std::vector<V>& line) {
            return bernstein::segment<V>(line, a, b);
        });
    }
    return net;
}

template <class V>
Net3<V> derivative_of(const Net3<V>& net, int axis)
{
    return by_lines(net, axis,
                    [](const std::vector<V>& line) { return bernstein::derivative<V>(line); });
}

}  // namespace lattice

// A part of the lattice on which the map is one polynomial: its box in (s, t, u), and the image as
// Bernstein coefficients over that box.
struct Lattice::Piece {
    Box3 box;
    lattice::Net3<Vec3> net;

    /// (s, t, u) relative to the box.
    Box3 relative(const Box3& b) const
    {
        Box3 r;
        for (std::size_t k = 0; k < 3; ++k) {
            r.min[k] = (b.min[k] - box.min[k]) / (box.max[k] - box.min[k]);
            r.max[k] = (b.max[k] - box.min[k]) / (box.max[k] - box.min[k]);
        }
        return r;
    }
};

}  // namespace genus
