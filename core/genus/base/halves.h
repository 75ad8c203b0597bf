#pragma once

#include <array>
#include <cstddef>

#include "genus/base/box.h"

namespace genus {

/// The first of those along which it is longest.
inline std::size_t longest_axis(const Vec3& size)
{
    return size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
}

inline std::array<Box3, 2> halves(const Box3& box, std::size_t axis)
{
    std::array<Box3, 2> parts{box, box};
    parts[0].max[axis] = parts[1].min[axis] = box.center()[axis];
    return parts;
}

inline std::array<Box3, 2> halves(const Box3& box)
{
    return halves(box, longest_axis(box.size()));
}

}  // namespace genus
