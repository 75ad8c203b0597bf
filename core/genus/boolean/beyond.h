#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "genus/boolean/box_tree.h"
#include "genus/boolean/cell_grid.h"
#include "genus/boolean/ray.h"
#include "genus/boolean/solved.h"

namespace genus::exact {

/// The faces of a soup that are not in its zone, see zone.h.
class Beyond {
public:
    /// Of faces of the zone in place of the number of a tract: that are sought when faces meet,
    /// and that come along.
    static constexpr std::int32_t kSought = -1, kAround = -2;

    /// `tract` is by face of `whole`; `face` and `point` are the numbers in the whole of those of
    /// the zone, in order.
    Beyond(const Soup& whole, CellGrid grid, std::vector<std::int32_t> tract,
           std::vector<std::int32_t> face, std::vector<std::int32_t> point)
        : whole_(whole),
          grid_(std::move(grid)),
          tract_(std::move(tract)),
          face_(std::move(face)),
          point_(std::move(point))
    {
    }

    /// Adds to `hits`, as operand and sign, the faces that the ray meets and that are not sought.
    /// O(faces), less once it was asked often. For one thread at a time.
    void add_hits(const Ray& ray, std::vector<std::pair<std::int32_t, std::int32_t>>& hits);

    /// Adds to what a zone was solved to what is kept of the tracts: all in the order that the
    /// whole would have come out in. False if a point joins faces beyond the rim that have no edge
    /// there in common, one after the other: one number would not do then, and `solved` is no
    /// longer good for anything. O(faces).
    bool add_to(Solved& solved, Rounding& rounding) const;

private:
    static constexpr int kRaysOneByOne = 8;

    void add_hit(const Ray& ray, std::int32_t f,
                 std::vector<std::pair<std::int32_t, std::int32_t>>& hits) const;
    void grow_tree();

    const Soup& whole_;
    CellGrid grid_;
    std::vector<std::int32_t> tract_;
    std::vector<std::int32_t> face_;
    std::vector<std::int32_t> point_;
    int n_rays_ = 0;
    BoxTree tree_;
    std::vector<std::int32_t> item_;  // of the tree: a face
};

}  // namespace genus::exact
