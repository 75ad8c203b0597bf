#pragma once

#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace genus {

/// Sets of the numbers 0 .. n - 1 that grow together. The smallest number of a set stands for it,
/// so the outcome does not depend on the order of the unions. Nearly O(1) a call.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t n) : parent_(n)
    {
        std::iota(parent_.begin(), parent_.end(), 0);
    }

    std::int32_t find(std::int32_t i)
    {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }

    void unite(std::int32_t a, std::int32_t b)
    {
        a = find(a);
        b = find(b);
        if (a < b)
            parent_[b] = a;
        else
            parent_[a] = b;
    }

private:
    std::vector<std::int32_t> parent_;
};

}  // namespace genus
