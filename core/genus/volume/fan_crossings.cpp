#include "genus/volume/fan_crossings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "genus/base/box.h"
#include "genus/base/parallel.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/triangle_intersection.h"

namespace genus {

namespace {

using Cell = std::array<std::int64_t, 3>;

Cell cell_of(const Vec3& p, const GridFrame& frame, double rounding)
{
    Cell cell;
    for (std::size_t i = 0; i < 3; ++i)
        cell[i] = static_cast<std::int64_t>(
            std::floor((p[i] - frame.origin[i]) / frame.spacing[i] + rounding));
    return cell;
}

// Cells, some of them by mistake.
class CellMarks {
public:
    explicit CellMarks(std::size_t n) : bits_(std::bit_ceil(std::max<std::size_t>(n / 2, 1))) {}

    void mark(const Cell& cell)
    {
        const std::uint64_t h = hash(cell);
        bits_[h & (bits_.size() - 1)] |= bit(h);
    }
    bool has(const Cell& cell) const
    {
        const std::uint64_t h = hash(cell);
        return (bits_[h & (bits_.size() - 1)] & bit(h)) != 0;
    }

private:
    static std::uint64_t hash(const Cell& cell)
    {
        std::uint64_t h = 0;
        for (const std::int64_t i : cell)
            h = (h ^ static_cast<std::uint64_t>(i)) * 0x9e3779b97f4a7c15ull;
        return h ^ h >> 29;
    }
    static std::uint64_t bit(std::uint64_t h) { return std::uint64_t{1} << (h >> 58); }

    std::vector<std::uint64_t> bits_;
};

class Search {
public:
    Search(const IndexedMesh& mesh, const std::vector<RowFaces>& rows,
           const std::vector<std::int32_t>& doubtful, const GridFrame& frame)
        : mesh_(mesh), rows_(rows), doubtful_(doubtful), frame_(frame)
    {
    }

    using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

    Pairs run() const
    {
        CellMarks marks(8 * doubtful_.size());
        std::vector<Box3> boxes;
        Pairs found;
        for (const std::int32_t f : doubtful_) {
            mark_cells(mesh_.faces[f], marks);
            boxes.push_back(box_of(f));
            if (has_no_area(points_of(f))) found.emplace_back(f, f);
        }
        const BoxTree tree(boxes);
        const std::vector<std::int32_t> near = faces_in(marks);
        constexpr std::size_t kFew = 512;
        std::vector<Pairs> parts(near.size() / kFew + 1);
        parallel_for(near.size(), kFew, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) add_crossings(near[n], tree, parts[n / kFew]);
        });
        for (const Pairs& part : parts) found.insert(found.end(), part.begin(), part.end());
        std::sort(found.begin(), found.end());
        found.erase(std::unique(found.begin(), found.end()), found.end());
        return found;
    }

private:
    static constexpr double kRounding = 1e-9;  // of a cell
    static constexpr std::size_t kRows = 64;
    static constexpr std::int64_t kWholeRow = std::numeric_limits<std::int64_t>::min();

    const Vec3& at(std::int32_t v) const { return mesh_.vertices[v]; }
    TrianglePoints points_of(std::int32_t f) const
    {
        const Triangle& t = mesh_.faces[f];
        return {at(t[0]), at(t[1]), at(t[2])};
    }
    Box3 box_of(std::int32_t f) const
    {
        Box3 box;
        for (const std::int32_t v : mesh_.faces[f]) box.add(at(v));
        return box;
    }
    void add_crossings(std::int32_t f, const BoxTree& tree, Pairs& found) const
    {
        const TrianglePoints points = points_of(f);
        tree.visit_overlapping(box_of(f), [&](std::int32_t n) {
            const std::int32_t g = doubtful_[n];
            if (f != g && triangle_contact(points, points_of(g)) == TriangleContact::Crossing)
                found.emplace_back(std::min(f, g), std::max(f, g));
        });
    }
    void mark_cells(const Triangle& t, CellMarks& marks) const
    {
        Box3 box;
        for (const std::int32_t v : t) box.add(at(v));
        const Cell low = cell_of(box.min, frame_, -kRounding);
        const Cell high = cell_of(box.max, frame_, kRounding);
        for (std::int64_t k = low[2]; k <= high[2]; ++k)
            for (std::int64_t j = low[1]; j <= high[1]; ++j)
                for (std::int64_t i = low[0]; i <= high[0]; ++i) marks.mark({i, j, k});
        for (std::int64_t k = low[2] - 1; k <= high[2] + 1; ++k)
            for (std::int64_t j = low[1] - 1; j <= high[1] + 1; ++j) marks.mark({kWholeRow, j, k});
    }
    // A face without doubt has its middle in its cell or, once flipped, in one beside it.
    std::vector<std::int32_t> faces_in(const CellMarks& marks) const
    {
        std::vector<std::vector<std::int32_t>> found((rows_.size() + kRows - 1) / kRows);
        parallel_for(rows_.size(), kRows, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                if (!marks.has({kWholeRow, rows_[r].j, rows_[r].k})) continue;
                for (std::size_t f = r > 0 ? rows_[r - 1].end : 0; f < rows_[r].end; ++f) {
                    const Triangle& t = mesh_.faces[f];
                    const Vec3 middle = (1.0 / 3.0) * (at(t[0]) + at(t[1]) + at(t[2]));
                    if (marks.has(cell_of(middle, frame_, 0.0)))
                        found[begin / kRows].push_back(static_cast<std::int32_t>(f));
                }
            }
        });
        std::vector<std::int32_t> faces = doubtful_;
        for (const auto& some : found) faces.insert(faces.end(), some.begin(), some.end());
        std::sort(faces.begin(), faces.end());
        faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
        return faces;
    }
    const IndexedMesh& mesh_;
    const std::vector<RowFaces>& rows_;
    const std::vector<std::int32_t>& doubtful_;
    const GridFrame& frame_;
};

}  // namespace

std::vector<std::pair<std::int32_t, std::int32_t>> fan_crossings(
    const IndexedMesh& mesh, const std::vector<RowFaces>& rows,
    const std::vector<std::int32_t>& doubtful, const GridFrame& frame)
{
    if (doubtful.empty()) return {};
    return Search(mesh, rows, doubtful, frame).run();
}

}  // namespace genus
