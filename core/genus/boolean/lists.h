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

/// Lists of items, one for each key below a number, stored one after the other.
template <class T>
class Lists {
public:
    using Keyed = std::pair<std::int32_t, T>;

    Lists() = default;
    /// Items of one key stay in order. O(keys + items).
    Lists(std::size_t n_keys, const std::vector<Keyed>& keyed)
        : begin_(n_keys, 0), end_(n_keys, 0), items_(keyed.size())
    {
        for (const Keyed& k : keyed) ++end_[k.first];
        std::size_t sum = 0;
        for (std::size_t key = 0; key < n_keys; ++key) {
            begin_[key] = sum;
            sum += end_[key];
            end_[key] = begin_[key];
        }
        for (const Keyed& k : keyed) items_[end_[k.first]++] = k.second;
    }

    std::size_t n_keys() const { return begin_.size(); }
    std::span<T> operator[](std::size_t key)
    {
        return {items_.data() + begin_[key], items_.data() + end_[key]};
    }
    std::span<const T> operator[](std::size_t key) const
    {
        return {items_.data() + begin_[key], items_.data() + end_[key]};
    }
    /// Keeps the first `n` items of a list.
    void shorten(std::size_t key, std::size_t n) { end_[key] = begin_[key] + n; }

    void sort_and_make_unique()
    {
        for (std::size_t key = 0; key < n_keys(); ++key) {
            const std::span<T> list = (*this)[key];
            if (list.size() < 2) continue;
            std::sort(list.begin(), list.end());
            shorten(key,
                    static_cast<std::size_t>(std::unique(list.begin(), list.end()) - list.begin()));
        }
    }

private:
    std::vector<std::size_t> begin_;
    std::vector<std::size_t> end_;
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
