#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace genus::exact {

inline std::uint64_t mixed(std::uint64_t h)
{
    h ^= h >> 31;
    h *= 0x9E3779B97F4A7C15ull;
    h ^= h >> 29;
    return h;
}

/// Lists of items, one for each key below a number, stored one after the other. Keys without items
/// cost four bytes.
template <class T>
class Lists {
public:
    using Keyed = std::pair<std::int32_t, T>;

    Lists() = default;
    /// Items of one key stay in order. O(keys + items).
    Lists(std::size_t n_keys, const std::vector<Keyed>& keyed)
        : place_(n_keys, 0), items_(keyed.size())
    {
        for (const Keyed& k : keyed) ++place_[k.first];
        std::size_t sum = 0;
        for (std::int32_t& place : place_) {
            const std::int32_t n =
                std::exchange(place, place == 0 ? -1 : static_cast<std::int32_t>(ranges_.size()));
            if (n == 0) continue;
            ranges_.push_back({sum, sum});
            sum += static_cast<std::size_t>(n);
        }
        for (const Keyed& k : keyed) items_[ranges_[place_[k.first]].end++] = k.second;
    }

    std::size_t n_keys() const { return place_.size(); }
    std::span<T> operator[](std::size_t key)
    {
        if (place_[key] < 0) return {};
        const Range& range = ranges_[place_[key]];
        return {items_.data() + range.begin, items_.data() + range.end};
    }
    std::span<const T> operator[](std::size_t key) const { return const_cast<Lists&>(*this)[key]; }
    /// Keeps the first `n` items of a list.
    void shorten(std::size_t key, std::size_t n)
    {
        if (place_[key] >= 0) shorten(ranges_[place_[key]], n);
    }

    void sort_and_make_unique()
    {
        for (Range& range : ranges_) {
            const std::span<T> list(items_.data() + range.begin, items_.data() + range.end);
            if (list.size() < 2) continue;
            std::sort(list.begin(), list.end());
            const auto end = std::unique(list.begin(), list.end());
            shorten(range, static_cast<std::size_t>(end - list.begin()));
        }
    }

private:
    struct Range {
        std::size_t begin, end;
    };
    static void shorten(Range& range, std::size_t n) { range.end = range.begin + n; }

    std::vector<std::int32_t> place_;  // by key: of its range, or -1
    std::vector<Range> ranges_;
    std::vector<T> items_;
};

/// Numbers keys 0, 1, ... as they come, equal ones alike. Open addressing: no allocation a key.
class Numbering {
public:
    std::int32_t number_of(std::uint64_t key)
    {
        if (2 * keys_.size() >= slots_.size()) grow();
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = mixed(key) >> 16 & mask;; at = (at + 1) & mask) {
            Slot& slot = slots_[at];
            if (slot.number < 0) {
                slot = {key, static_cast<std::int32_t>(keys_.size())};
                keys_.push_back(key);
                return slot.number;
            }
            if (slot.key == key) return slot.number;
        }
    }
    const std::vector<std::uint64_t>& keys() const { return keys_; }

private:
    struct Slot {
        std::uint64_t key = 0;
        std::int32_t number = -1;
    };

    void grow()
    {
        slots_.assign(std::max<std::size_t>(64, 4 * slots_.size()), {});
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            std::size_t at = mixed(keys_[i]) >> 16 & mask;
            while (slots_[at].number >= 0) at = (at + 1) & mask;
            slots_[at] = {keys_[i], static_cast<std::int32_t>(i)};
        }
    }

    std::vector<Slot> slots_;
    std::vector<std::uint64_t> keys_;
};

}  // namespace genus::exact
