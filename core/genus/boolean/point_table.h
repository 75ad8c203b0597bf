#pragma once

#include "genus/boolean/arrangement.h"
#include "genus/boolean/lists.h"

namespace genus::exact {

/// Numbers the points of an arrangement so that equal points get one number. Open addressing: no
/// allocation a point.
class PointTable {
public:
    explicit PointTable(Arrangement& arrangement) : out_(arrangement) {}

    /// The first grid point equal to point `index`, which may be itself.
    std::int32_t add_grid_point(std::int32_t index)
    {
        const PointRef& p = out_.points[index];
        std::array<std::int64_t, 3> fixed;
        for (int k = 0; k < 3; ++k) fixed[k] = static_cast<std::int64_t>(p.approx[k]) * 1024;
        return find_or_add(fixed, p, index);
    }
    /// The point of the arrangement equal to `point`, which is added if there is none.
    std::int32_t add(const ExactPoint& point)
    {
        const auto number = static_cast<std::int32_t>(out_.points.size());
        PointRef p{point.approximate(), point.on_grid ? nullptr : &point};
        const std::int32_t found = find_or_add(point.fixed, p, number);
        if (found == number) {
            if (p.exact) p.exact = &out_.exact.emplace_back(point);
            out_.points.push_back(p);
        }
        return found;
    }

private:
    struct Slot {
        std::uint32_t hash = 0;
        std::int32_t point = -1;
    };

    std::int32_t find_or_add(const std::array<std::int64_t, 3>& fixed, const PointRef& p,
                             std::int32_t number)
    {
        if (2 * n_used_ >= slots_.size()) grow();
        std::uint64_t mix = 0;
        for (const std::int64_t c : fixed) mix = mixed(mix + static_cast<std::uint64_t>(c) + 0x51u);
        const auto h = static_cast<std::uint32_t>(mix >> 32);
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = h & mask;; at = (at + 1) & mask) {
            Slot& slot = slots_[at];
            if (slot.point < 0) {
                slot = {h, number};
                ++n_used_;
                return number;
            }
            if (slot.hash == h && same_point(out_.points[slot.point], p)) return slot.point;
        }
    }
    void grow()
    {
        const std::vector<Slot> old = std::move(slots_);
        slots_.assign(std::max<std::size_t>(64, 2 * old.size()), {});
        const std::size_t mask = slots_.size() - 1;
        for (const Slot& slot : old) {
            if (slot.point < 0) continue;
            std::size_t at = slot.hash & mask;
            while (slots_[at].point >= 0) at = (at + 1) & mask;
            slots_[at] = slot;
        }
    }

    Arrangement& out_;
    std::vector<Slot> slots_;
    std::size_t n_used_ = 0;
};

}  // namespace genus::exact
