#pragma once

#include <cstdint>
#include <vector>

#include "genus/boolean/contact.h"
#include "genus/boolean/exact_point.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::exact {

class Beyond;

/// Faces of several operands on one grid. Faces have three different corners and an area.
struct Soup {
    std::vector<Vec3> points;  // grid points, see exact_point.h
    std::vector<Triangle> faces;
    std::vector<std::int32_t> operand;  // of each face
    /// Of each face: the operand that the caller gave and its number there.
    struct Given {
        std::int32_t operand;
        std::int32_t face;
    };
    std::vector<Given> given;
    /// Three a face: the halfedge across edge i, numbered 3 face + i, or -1 where the edge does not
    /// join exactly two faces. At the rim of a zone, across_rim of the tract beyond.
    std::vector<std::int32_t> twin;
    /// Operands that may cross or touch themselves; empty for none.
    std::vector<char> crosses_itself;

    // Of a zone, see zone.h; empty and zero for a soup that is a whole.
    std::vector<char> on_rim;  // by point: faces of tracts end there
    std::int32_t n_tracts = 0;
    Beyond* beyond = nullptr;  // not owned

    /// Tracts as twins: -2 and below.
    static constexpr std::int32_t across_rim(std::int32_t tract) { return -2 - tract; }
    static constexpr std::int32_t tract_across(std::int32_t twin) { return -2 - twin; }
    bool is_on_rim(std::int32_t point) const
    {
        return point < static_cast<std::int32_t>(on_rim.size()) && on_rim[point] != 0;
    }
};

inline std::int32_t next_in_face(std::int32_t h)
{
    return h % 3 == 2 ? h - 2 : h + 1;
}

inline std::int32_t prev_in_face(std::int32_t h)
{
    return h % 3 == 0 ? h + 2 : h - 1;
}

inline Plane plane_of(const Soup& soup, std::int32_t f)
{
    const Triangle& t = soup.faces[f];
    return plane_through(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
}

/// With corners numbered as in the soup.
inline Corners corners_of(const Soup& soup, std::int32_t f)
{
    Corners c;
    for (int i = 0; i < 3; ++i) {
        c.id[i] = soup.faces[f][i];
        c.at[i] = &soup.points[c.id[i]];
    }
    return c;
}

}  // namespace genus::exact
