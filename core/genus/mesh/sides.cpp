#include "genus/mesh/sides.h"

namespace genus {

std::vector<std::int32_t> twins(const EdgeTable& table, std::size_t n_sides)
{
    std::vector<std::int32_t> twin(n_sides, kNoEdge);
    parallel_for(table.n_edges(), 1 << 14, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
            const std::int32_t* side = table.sides.data() + table.starts[e];
            const std::int32_t n = table.n_faces(e);
            if (n == 2) {
                twin[side[0]] = side[1];
                twin[side[1]] = side[0];
                continue;
            }
            for (std::int32_t i = 0; i < n; ++i)
                twin[side[i]] = n == 1 ? kBoundarySide : kComplexSide;
        }
    });
    return twin;
}

}  // namespace genus
