#include "genus/polygon/box_pairs.h"

#include <algorithm>
#include <numeric>

#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr std::size_t kFewBoxes = 24;

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

class PairFinder {
public:
    PairFinder(std::span<const Box2> boxes, Pairs& pairs) : boxes_(boxes), pairs_(pairs) {}

    // Halves the cell across its longer side of centres; a box on the cut goes to both halves.
    void find(const std::vector<std::int32_t>& members)
    {
        current_progress().check();
        if (members.size() <= kFewBoxes) return compare_all(members);
        Box2 centers;
        for (const std::int32_t i : members) centers.add(boxes_[i].center());
        const int axis = centers.size()[0] >= centers.size()[1] ? 0 : 1;
        const double cut = middle(members, axis);
        std::vector<std::int32_t> low, high;
        for (const std::int32_t i : members) {
            if (boxes_[i].min[axis] <= cut) low.push_back(i);
            if (boxes_[i].max[axis] >= cut) high.push_back(i);
        }
        if (10 * std::max(low.size(), high.size()) > 9 * members.size())
            return compare_all(members);
        find(low);
        find(high);
    }

private:
    double middle(const std::vector<std::int32_t>& members, int axis) const
    {
        std::vector<double> centers;
        centers.reserve(members.size());
        for (const std::int32_t i : members) centers.push_back(boxes_[i].center()[axis]);
        const auto half = centers.begin() + static_cast<std::ptrdiff_t>(centers.size() / 2);
        std::nth_element(centers.begin(), half, centers.end());
        return *half;
    }

    // Sweep along x within the cell.
    void compare_all(std::vector<std::int32_t> members)
    {
        std::sort(members.begin(), members.end(), [&](std::int32_t i, std::int32_t j) {
            return boxes_[i].min[0] < boxes_[j].min[0];
        });
        for (std::size_t a = 0; a < members.size(); ++a)
            for (std::size_t b = a + 1; b < members.size(); ++b) {
                const Box2 &first = boxes_[members[a]], &second = boxes_[members[b]];
                if (second.min[0] > first.max[0]) break;
                if (!overlap(first, second)) continue;
                pairs_.push_back(std::minmax(members[a], members[b]));
            }
    }

    std::span<const Box2> boxes_;
    Pairs& pairs_;
};

}  // namespace

std::vector<std::pair<std::int32_t, std::int32_t>> overlapping_pairs(std::span<const Box2> boxes)
{
    Pairs pairs;
    std::vector<std::int32_t> all(boxes.size());
    std::iota(all.begin(), all.end(), 0);
    PairFinder(boxes, pairs).find(all);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

}  // namespace genus
