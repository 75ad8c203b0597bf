#include "genus/volume/bisection_tree.h"

namespace genus {

namespace {

constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

std::uint64_t scramble(std::uint64_t x)
{
    x ^= x >> 31;
    x *= 0x9e3779b97f4a7c15ull;
    x ^= x >> 29;
    x *= 0xbf58476d1ce4e5b9ull;
    return x ^ x >> 32;
}

// The midpoints that must be split before `m`: those whose splitting makes the tetrahedra round
// the edge of m. Let s be the lowest bit set in any coordinate. The number of coordinates that are
// odd multiples of s tells which edge m halves: 3 a diagonal of a cube of side 2s, 2 one of a
// square, 1 a side.
int presupposed(const LatticePoint& m, std::array<LatticePoint, 4>& out)
{
    const std::int32_t bits = m.c[0] | m.c[1] | m.c[2];
    const std::int32_t s = bits & -bits;
    int n_odd = 0;
    for (const std::int32_t x : m.c) n_odd += (x & s) != 0;

    int n = 0;
    const auto add = [&](LatticePoint p) {
        for (const std::int32_t x : p.c)
            if (x < 0 || x > BisectionTree::kSize) return;
        out[n++] = p;
    };
    if (n_odd == 3) {
        if (2 * s >= BisectionTree::kSize) return 0;
        // The diagonal runs from the corner that is oldest (all coordinates multiples of 4s) to
        // the centre of the next larger cube; that cube's sides at the old corner come first.
        LatticePoint old = m;
        for (std::int32_t& x : old.c) x = ((x - s) & (2 * s)) == 0 ? x - s : x + s;
        for (int a = 0; a < 3; ++a) {
            LatticePoint p = old;
            p.c[a] = 2 * m.c[a] - old.c[a];
            add(p);
        }
        return n;
    }
    for (int a = 0; a < 3; ++a) {
        if ((m.c[a] & s) != 0) continue;
        for (const std::int32_t step : {-s, s}) {
            LatticePoint p = m;
            p.c[a] += step;
            add(p);
        }
    }
    return n;
}

}  // namespace

BisectionTree::BisectionTree() : table_(1024, kEmpty) {}

std::array<LatticeTet, 6> BisectionTree::roots()
{
    constexpr std::array<std::array<int, 3>, 6> orders{
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    std::array<LatticeTet, 6> tets;
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            tets[i].corner[j + 1] = tets[i].corner[j];
            tets[i].corner[j + 1].c[orders[i][j]] = kSize;
        }
    return tets;
}

bool BisectionTree::is_finest(const LatticeTet& tet)
{
    const auto& a = tet.corner[0].c;
    const auto& b = tet.corner[tet.k].c;
    for (int i = 0; i < 3; ++i)
        if (((a[i] ^ b[i]) & 1) != 0) return true;
    return false;
}

LatticePoint BisectionTree::midpoint(const LatticeTet& tet)
{
    LatticePoint m;
    for (int i = 0; i < 3; ++i) m.c[i] = (tet.corner[0].c[i] + tet.corner[tet.k].c[i]) / 2;
    return m;
}

std::pair<LatticeTet, LatticeTet> BisectionTree::children(const LatticeTet& tet)
{
    LatticeTet first = tet, second = tet;
    first.k = second.k = tet.k == 1 ? 3 : tet.k - 1;
    first.corner[tet.k] = midpoint(tet);
    for (int i = 0; i < tet.k; ++i) second.corner[i] = tet.corner[i + 1];
    second.corner[tet.k] = first.corner[tet.k];
    return {first, second};
}

void BisectionTree::split(const LatticePoint& midpoint)
{
    std::vector<LatticePoint> stack{midpoint};
    std::array<LatticePoint, 4> before;
    while (!stack.empty()) {
        const LatticePoint m = stack.back();
        stack.pop_back();
        if (!insert(m.code())) continue;
        const int n = presupposed(m, before);
        stack.insert(stack.end(), before.begin(), before.begin() + n);
    }
}

bool BisectionTree::is_split(const LatticeTet& tet) const
{
    return !is_finest(tet) && contains(midpoint(tet).code());
}

bool BisectionTree::insert(std::uint64_t code)
{
    if (2 * (count_ + 1) > table_.size()) grow();
    const std::size_t mask = table_.size() - 1;
    std::size_t i = scramble(code) & mask;
    for (; table_[i] != kEmpty; i = (i + 1) & mask)
        if (table_[i] == code) return false;
    table_[i] = code;
    ++count_;
    return true;
}

bool BisectionTree::contains(std::uint64_t code) const
{
    const std::size_t mask = table_.size() - 1;
    for (std::size_t i = scramble(code) & mask; table_[i] != kEmpty; i = (i + 1) & mask)
        if (table_[i] == code) return true;
    return false;
}

void BisectionTree::grow()
{
    std::vector<std::uint64_t> old(table_.size() * 2, kEmpty);
    old.swap(table_);
    const std::size_t mask = table_.size() - 1;
    for (const std::uint64_t code : old) {
        if (code == kEmpty) continue;
        std::size_t i = scramble(code) & mask;
        while (table_[i] != kEmpty) i = (i + 1) & mask;
        table_[i] = code;
    }
}

}  // namespace genus
