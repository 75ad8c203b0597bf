#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "genus/boolean/arrangement.h"
#include "genus/boolean/frame.h"
#include "genus/boolean/mesh_boolean.h"

namespace genus::exact {

inline constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();

/// True if the corners are in one line. Exact.
inline bool is_flat(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return dominant_axis(a, b, c) < 0;
}

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
};

/// What is known of a soup before anything is cut.
struct Start {
    Candidates candidates;
    std::vector<char> buried;
};

/// `most_pairs` as in find_candidates. Buried faces are looked for where there are more than two
/// operands.
Start look_over(const Soup& soup, const BooleanFormula& formula, std::int32_t n_operands,
                std::size_t most_pairs = kAnyNumber);

/// The surface of a soup by formula, rounded to points of the frame that are triples of doubles,
/// and solved again where that makes it cross itself. Nothing if that does not help; `place` then
/// is a point where it does. Counts in `report` are added to.
std::optional<Solved> solve_whole(const Soup& soup, const Frame& frame,
                                  const BooleanFormula& formula, std::int32_t n_operands,
                                  const MeshBooleanOptions& options, Start start,
                                  MeshBooleanReport& report, Vec3& place);

}  // namespace genus::exact
