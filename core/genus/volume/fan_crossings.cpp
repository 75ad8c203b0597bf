#include "genus/volume/fan_crossings.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "genus/base/box.h"
#include "genus/base/parallel.h"
#include "genus/mesh/validate.h"

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
    Search(const IndexedMesh& mesh, const std::vector<std::int32_t>& doubtful,
           const GridFrame& frame)
        : mesh_(mesh), doubtful_(doubtful), frame_(frame)
    {
    }

    std::vector<std::pair<std::int32_t, std::int32_t>> run() const
    {
        const std::vector<std::int32_t>& own = doubtful_;
        CellMarks marks(8 * own.size());
        for (const std::int32_t f : own) mark_cells(mesh_.faces[f], marks);
        std::vector<std::pair<std::int32_t, std::int32_t>> found;
        for (const std::int32_t f : own)
            if (is_line(mesh_.faces[f])) found.emplace_back(f, f);
        const std::vector<std::int32_t> near = faces_in(marks);
        for (const auto& [a, b] : self_intersections(part_of(near)).pairs)
            found.emplace_back(near[a], near[b]);
        std::sort(found.begin(), found.end());
        return found;
    }

private:
    static constexpr double kRounding = 1e-9;  // of a cell
    static constexpr std::size_t kGrain = 1 << 14;

    const Vec3& at(std::int32_t v) const { return mesh_.vertices[v]; }
    bool is_line(const Triangle& t) const
    {
        return cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])) == Vec3{};
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
    }
    // A face of a cell without doubt has its middle there.
    std::vector<std::int32_t> faces_in(const CellMarks& marks) const
    {
        std::vector<std::vector<std::int32_t>> found((mesh_.n_faces() + kGrain - 1) / kGrain);
        parallel_for(mesh_.n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const Triangle& t = mesh_.faces[f];
                const Vec3 middle = (1.0 / 3.0) * (at(t[0]) + at(t[1]) + at(t[2]));
                if (marks.has(cell_of(middle, frame_, 0.0)))
                    found[begin / kGrain].push_back(static_cast<std::int32_t>(f));
            }
        });
        std::vector<std::int32_t> faces = doubtful_;
        for (const auto& some : found) faces.insert(faces.end(), some.begin(), some.end());
        std::sort(faces.begin(), faces.end());
        faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
        return faces;
    }
    IndexedMesh part_of(const std::vector<std::int32_t>& faces) const
    {
        IndexedMesh part;
        std::vector<std::int32_t> number(mesh_.n_vertices(), -1);
        for (const std::int32_t f : faces) {
            Triangle t = mesh_.faces[f];
            for (std::int32_t& v : t) {
                if (number[v] < 0) {
                    number[v] = static_cast<std::int32_t>(part.vertices.size());
                    part.vertices.push_back(at(v));
                }
                v = number[v];
            }
            part.faces.push_back(t);
        }
        return part;
    }

    const IndexedMesh& mesh_;
    const std::vector<std::int32_t>& doubtful_;
    const GridFrame& frame_;
};

}  // namespace

std::vector<std::pair<std::int32_t, std::int32_t>> fan_crossings(
    const IndexedMesh& mesh, const std::vector<std::int32_t>& doubtful, const GridFrame& frame)
{
    if (doubtful.empty()) return {};
    return Search(mesh, doubtful, frame).run();
}

}  // namespace genus
