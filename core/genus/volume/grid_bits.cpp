#include "genus/volume/grid_bits.h"

namespace genus {

TiledBits::TiledBits(const GridSize& size)
    : size_(size),
      n_tiles_{(size[0] + kWordSamples - 1) / kWordSamples, (size[1] + kSide - 1) / kSide,
               (size[2] + kSide - 1) / kSide},
      states_(number(0, 0, n_tiles_[2]), kOutside)
{
}

void TiledBits::store(std::size_t tile, const Tile& words)
{
    states_[tile] = static_cast<std::int32_t>(n_stored());
    words_.insert(words_.end(), words.begin(), words.end());
}

// Unless this tile and those behind it are all inside or all outside.
bool TiledBits::may_be_crossed(std::int32_t i, std::int32_t j, std::int32_t k) const
{
    const std::int32_t own = states_[number(i, j, k)];
    for (std::int32_t c = 0; c < 8; ++c) {
        const std::int32_t x = std::min(i + (c & 1), n_tiles_[0] - 1);
        const std::int32_t y = std::min(j + (c >> 1 & 1), n_tiles_[1] - 1);
        const std::int32_t z = std::min(k + (c >> 2 & 1), n_tiles_[2] - 1);
        const std::int32_t other = states_[number(x, y, z)];
        if (other >= 0 || other != own) return true;
    }
    return false;
}

void TiledBits::find_slots()
{
    line_.assign(line_number(0, n_tiles_[2]), -1);
    first_run_ = {0};
    first_line_ = first_slot_ = {0};
    for (std::int32_t k = 0; k < n_tiles_[2]; ++k) {
        std::size_t width = 0;
        for (std::int32_t j = 0; j < n_tiles_[1]; ++j) {
            for (std::int32_t i = 0; i < n_tiles_[0]; ++i) {
                if (!may_be_crossed(i, j, k)) continue;
                if (runs_.size() > first_run_.back() && runs_.back()[1] == i)
                    ++runs_.back()[1];
                else
                    runs_.push_back({i, i + 1});
            }
            if (runs_.size() == first_run_.back()) continue;
            line_[line_number(j, k)] = static_cast<std::int32_t>(line_j_.size());
            line_j_.push_back(j);
            first_run_.push_back(runs_.size());
            width += static_cast<std::size_t>(rows_in(j, 1));
        }
        width_.push_back(width);
        first_line_.push_back(line_j_.size());
        first_slot_.push_back(first_slot_.back() + width * rows_in(k, 2));
    }
}

// In a layer the rows of all its lines at one k come before those at the next. Only the last line
// across can have fewer than 16.
std::size_t TiledBits::row_of(std::size_t slot) const
{
    const auto after = std::upper_bound(first_slot_.begin(), first_slot_.end(), slot);
    const auto layer = static_cast<std::size_t>(after - first_slot_.begin()) - 1;
    const std::size_t within = slot - first_slot_[layer];
    const std::size_t across = within % width_[layer];
    const std::size_t k = layer * kSide + within / width_[layer];
    const std::size_t j =
        static_cast<std::size_t>(line_j_[first_line_[layer] + across / kSide]) * kSide +
        across % kSide;
    return k * size_[1] + j;
}

std::ptrdiff_t TiledBits::slot_of(std::size_t row) const
{
    const Place at = place(row);
    const std::int32_t layer = at.k / kSide, line = line_[line_number(at.j / kSide, layer)];
    if (line < 0) return -1;
    const std::size_t across =
        (static_cast<std::size_t>(line) - first_line_[layer]) * kSide + at.j % kSide;
    return static_cast<std::ptrdiff_t>(first_slot_[layer] + (at.k % kSide) * width_[layer] +
                                       across);
}

}  // namespace genus
