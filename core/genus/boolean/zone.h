#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "genus/boolean/beyond.h"
#include "genus/boolean/soup.h"

namespace genus::exact {

/// The part of a soup in which anything can happen, as a soup of its own. Large operands that meet
/// here and there are left alone elsewhere: neither compared nor cut, and copied in the end.
///
/// The whole is laid out in cells, about one a face. Faces that share a cell with one of another
/// owner (see charts.h) may meet it; these, with what continues their planes, are what may be cut
/// or joined. Faces that share a cell with any of them, moved by no more than `reach`, come along:
/// whatever is made of those by cutting and rounding touches no others. What is left makes tracts,
/// connected across edges, and the faces of the zone next to them are passive.
struct Zone {
    Soup soup;
    std::vector<std::int32_t> owners;  // of its faces: kNotSought for those that come along
    std::unique_ptr<Beyond> beyond;    // the rest
};

/// Nothing where it would save little; whether it would is told by the operands alone, whatever
/// their owners, if `by_operands`. `reach` is in steps of the grid. O(faces).
std::optional<Zone> find_zone(const Soup& whole, const std::vector<std::int32_t>& owners,
                              double reach, bool by_operands);

}  // namespace genus::exact
