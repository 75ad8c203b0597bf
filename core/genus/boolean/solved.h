#pragma once

#include <cstdint>
#include <vector>

#include "genus/boolean/soup.h"

namespace genus::exact {

/// A solved cluster, on its grid.
struct Solved {
    std::vector<Vec3> points;
    std::vector<Triangle> faces;
    std::vector<Soup::Given> given;

    /// All pairs of faces were looked at, those of operands that promise not to cross themselves
    /// excepted.
    bool saw_all = false;
    std::vector<std::int32_t> touch_themselves;  // operands of which that was seen; repeated
    bool parts_touch = false;                    // corners at one place with numbers of their own

    /// Of a zone, what joins it to the rest.
    struct Rim {
        std::vector<std::int8_t> tracts;  // which are kept, see Selection
        std::vector<std::int32_t>
            sources;  // of the first faces, left as they were: faces of the soup
        /// Of the first points, at which nothing else ends: the point of the soup if it is on the
        /// rim, else -1.
        std::vector<std::int32_t> on_rim;
    } rim;
};

/// What the rounding of a result did.
struct Rounding {
    std::vector<char> moved;           // by point
    std::vector<std::int32_t> turned;  // faces that now turn the other way
};

}  // namespace genus::exact
