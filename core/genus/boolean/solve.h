#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/frame.h"
#include "genus/boolean/mesh_boolean.h"
#include "genus/boolean/solved.h"
#include "genus/boolean/zone.h"

namespace genus::exact {

inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

/// True if the corners are in one line. Exact.
inline bool is_flat(const Vec3& a, const Vec3& b, const Vec3& c)
{
    // Far above all rounding, an area is there for sure.
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 n = cross(ab, ac);
    if (dot(n, n) > 1e-20 * dot(ab, ab) * dot(ac, ac)) return false;
    return dominant_axis(a, b, c) < 0;
}

/// What is known of a soup before anything is cut.
struct Start {
    std::optional<Zone> zone;  // where there is one, the candidates are its
    Candidates candidates;
    std::vector<char> buried;
};

/// `most_pairs` as in find_candidates. Buried faces are looked for where there are more than two
/// operands.
Start look_over(const Soup& soup, const BooleanFormula& formula, std::int32_t n_operands,
                std::size_t most_pairs = kAnyNumber);
/// The same for the zone of a soup alone, where it has one.
Start look_over_zone(const Soup& soup, const Frame& frame, const BooleanFormula& formula,
                     std::int32_t n_operands);

/// The surface of a soup by formula, rounded to points of the frame that are triples of doubles,
/// and solved again where that makes it cross itself. Nothing if that does not help; `place` then
/// is a point where it does. Counts in `report` are added to.
std::optional<Solved> solve_whole(const Soup& soup, const Frame& frame,
                                  const BooleanFormula& formula, std::int32_t n_operands,
                                  const MeshBooleanOptions& options, Start start,
                                  MeshBooleanReport& report, Vec3& place);

}  // namespace genus::exact
