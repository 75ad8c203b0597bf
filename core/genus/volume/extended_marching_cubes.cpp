#include "genus/volume/extended_marching_cubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/volume/cell_case.h"
#include "genus/volume/crossed_cells.h"
#include "genus/volume/crossing.h"
#include "genus/volume/fan_crossings.h"
#include "genus/volume/field_samples.h"

namespace genus {

namespace {

constexpr std::size_t kRowsPerTask = 16;
// Rows whose faces are held a second time, before they are put in order: little enough for a cache.
constexpr std::size_t kRowsPerBatch = 64 * kRowsPerTask;

// A fan triangle lies over the rim edge from corner 0 to corner 1 and has its apex in corner 2.
struct Fan {
    std::int64_t face;
    std::uint64_t rim;  // its two vertices, the smaller one first
};

// The vertex of a cell's feature. If it is strictly inside, the fan crosses nothing in its cell,
// nor does what flips make of it: these pass from cell to cell through the face between them, and
// there is one loop a face. Else that is to be looked at.
struct Feature {
    std::int64_t cell;
    std::int32_t vertex;
    bool is_doubtful;
};

// How the surface lies at a vertex on a grid edge: enough to see whether an edge passes between
// two, in half the memory of what is exact. That is asked for again in the few cells with a
// feature.
struct Slope {
    std::array<float, 3> normal;
    bool on_border;

    friend double dot(const Slope& a, const Slope& b)
    {
        double sum = 0.0;
        for (std::size_t i = 0; i < 3; ++i) sum += double{a.normal[i]} * double{b.normal[i]};
        return sum;
    }
};

// What a cell may do with its feature: it takes the next step where faces cross.
enum class Step : std::uint8_t { Near, Inside, None };

// What the cells of some rows give. Vertices inside cells are counted from 0 here and written as
// -1 - n in the faces, until it is known how many the tasks before have.
struct Part {
    std::vector<Vec3> inner;
    std::vector<Triangle> faces;
    std::vector<Fan> fans;
    std::vector<Feature> features;
    std::vector<std::size_t> ends;  // of the faces of each row
};

std::uint64_t rim_key(std::int32_t a, std::int32_t b)
{
    const auto [low, high] = std::minmax(a, b);
    return static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
}

class Extractor {
public:
    Extractor(const FieldSamples& samples, const FeatureOptions& features)
        : samples_(samples), features_(features), cells_(samples.bits())
    {
        cells_.number();
    }

    IndexedMesh extract()
    {
        cross_edges();
        do {
            make_faces();
        } while (step_back());
        return std::move(mesh_);
    }

    std::int64_t count(Step step) const
    {
        return std::count_if(steps_.begin(), steps_.end(),
                             [&](const auto& taken) { return taken.second == step; });
    }

private:
    void make_faces();
    bool step_back();
    Step step_of(std::int64_t cell) const
    {
        const auto at = steps_.find(cell);
        return at == steps_.end() ? Step::Near : at->second;
    }
    std::int64_t number(const CrossedCell& cell) const
    {
        const GridSize& n = samples_.size();
        return (static_cast<std::int64_t>(cell.k) * n[1] + cell.j) * n[0] + cell.i;
    }

    void cross_edges();
    TangentElement tangent_element(int axis, const GridIndex& at) const;
    void fill_cell(const CrossedCell& cell, Part& part) const;
    Box3 box_of(const CrossedCell& cell) const
    {
        return {samples_.point(cell.i, cell.j, cell.k),
                samples_.point(cell.i + 1, cell.j + 1, cell.k + 1)};
    }
    bool is_sharp(std::span<const std::int32_t> rim) const;
    std::optional<Vec3> feature_of(std::span<const std::int32_t> rim, const CrossedCell& cell,
                                   Step step) const;
    bool is_within(const Vec3& p, const CrossedCell& cell) const;
    void add_fan(std::span<const std::int32_t> rim, const Vec3& apex, bool feature,
                 Part& part) const;
    void append(Part& part, std::size_t first_slot);
    void flip_across_features();
    bool feature_between(std::int32_t a, std::int32_t b) const;

    const FieldSamples& samples_;
    const FeatureOptions& features_;
    // The cosine of a little less than half the angle of theta_sharp; beyond 1 there is none.
    double half_theta_ = std::sqrt(std::clamp(0.5 + 0.5 * features_.theta_sharp, 0.0, 1.0)) + 1e-9;
    CrossedCells<TiledBits> cells_;
    std::vector<Slope> slopes_;                     // of the vertices on grid edges
    std::unordered_map<std::int64_t, Step> steps_;  // of cells that took one
    std::vector<Feature> features_of_cells_;
    std::vector<Fan> fans_;
    std::vector<RowFaces> rows_;
    IndexedMesh mesh_;
};

void Extractor::cross_edges()
{
    slopes_.resize(cells_.n_vertices());
    // Twice as many faces as vertices, as on any closed surface, and few vertices inside cells:
    // more would be made room for, less is not touched.
    mesh_.vertices.reserve(slopes_.size() + slopes_.size() / 8);
    mesh_.faces.reserve(2 * mesh_.vertices.capacity());
    mesh_.vertices.resize(slopes_.size());
    parallel_for(cells_.n_slots(), kRowsPerTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t slot = begin; slot < end; ++slot)
            cells_.visit_edges(slot, [&](std::int64_t vertex, int axis, int i, int j, int k) {
                const TangentElement e = tangent_element(axis, {i, j, k});
                mesh_.vertices[vertex] = e.point;
                for (std::size_t c = 0; c < 3; ++c)
                    slopes_[vertex].normal[c] = static_cast<float>(e.normal[c]);
                slopes_[vertex].on_border = e.on_border;
            });
    });
}

void Extractor::make_faces()
{
    mesh_.vertices.resize(slopes_.size());
    mesh_.faces.clear();
    features_of_cells_.clear();
    fans_.clear();
    rows_.clear();
    std::vector<Part> parts(kRowsPerBatch / kRowsPerTask);
    for (std::size_t first = 0; first < cells_.n_slots(); first += kRowsPerBatch) {
        const std::size_t n = std::min(kRowsPerBatch, cells_.n_slots() - first);
        parallel_for(n, kRowsPerTask, [&](std::size_t begin, std::size_t end) {
            Part& part = parts[begin / kRowsPerTask];
            for (std::size_t row = begin; row < end; ++row) {
                cells_.visit_row<true>(first + row,
                                       [&](const CrossedCell& cell) { fill_cell(cell, part); });
                part.ends.push_back(part.faces.size());
            }
        });
        for (std::size_t task = 0; task * kRowsPerTask < n; ++task)
            append(parts[task], first + task * kRowsPerTask);
    }
    flip_across_features();
}

TangentElement Extractor::tangent_element(int axis, const GridIndex& at) const
{
    GridIndex end = at;
    ++end[axis];
    const Vec3 p = ExactCrossings(samples_)(axis, at[0], at[1], at[2]);
    // On the border of the grid the surface is the border.
    Vec3 border;
    if (!samples_.is_true(at[0], at[1], at[2])) border[axis] = -1.0;
    if (!samples_.is_true(end[0], end[1], end[2])) border[axis] = 1.0;
    if (border != Vec3{}) return {p, border, true};
    return {p, normalized(samples_.field_at(at[0], at[1], at[2]).gradient(p))};
}

void Extractor::fill_cell(const CrossedCell& cell, Part& part) const
{
    const CubeCase& found_case = case_of(cube_cases(), samples_, cell);
    const Step step = steps_.empty() ? Step::Near : step_of(number(cell));
    for (const CubeCase::Loop& loop : found_case.loops) {
        std::array<std::int32_t, 12> vertices;
        const std::size_t n = loop.edges.size();
        for (std::size_t i = 0; i < n; ++i) vertices[i] = cell.vertex[loop.edges[i]];
        const std::span<const std::int32_t> rim = std::span(vertices).first(n);
        const std::optional<Vec3> feature =
            step != Step::None && is_sharp(rim) ? feature_of(rim, cell, step) : std::nullopt;
        if (feature) {
            const bool shares = found_case.loops.size() > 1 || kAmbiguousFaces[cell.cube] != 0;
            part.features.push_back({number(cell), static_cast<std::int32_t>(part.inner.size()),
                                     shares || !is_within(*feature, cell)});
            add_fan(rim, *feature, true, part);
        } else if (loop.triangles.empty()) {
            Vec3 sum;
            for (const std::int32_t v : rim) sum += mesh_.vertices[v];
            add_fan(rim, sum / static_cast<double>(rim.size()), false, part);
        } else {
            for (const auto& t : loop.triangles)
                part.faces.push_back({rim[t[0]], rim[t[1]], rim[t[2]]});
        }
    }
}

// Has a loop a feature? The first question of feature_vertex, asked for every cell.
bool Extractor::is_sharp(std::span<const std::int32_t> rim) const
{
    // All so near to one that no two are far apart.
    const Slope& first = slopes_[rim[0]];
    bool narrow = true;
    for (std::size_t i = 1; i < rim.size(); ++i)
        narrow = narrow && dot(first, slopes_[rim[i]]) > half_theta_;
    if (narrow) return false;
    for (std::size_t i = 1; i < rim.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (feature_between(rim[i], rim[j])) return true;
    return false;
}

// None if the exact normals lie in one cone after all.
std::optional<Vec3> Extractor::feature_of(std::span<const std::int32_t> rim,
                                          const CrossedCell& cell, Step step) const
{
    const Implicit& field = samples_.field_at(cell.i, cell.j, cell.k);
    std::array<TangentElement, 12> found;
    for (std::size_t i = 0; i < rim.size(); ++i) {
        const Slope& slope = slopes_[rim[i]];
        const Vec3& p = mesh_.vertices[rim[i]];
        // On the border a normal is an axis.
        const auto [x, y, z] = slope.normal;
        found[i] = {p, slope.on_border ? Vec3{{x, y, z}} : normalized(field.gradient(p)),
                    slope.on_border};
    }
    return feature_vertex(samples_.field(), samples_.level(), std::span(found).first(rim.size()),
                          box_of(cell), features_,
                          step == Step::Near ? FeatureRoom::Near : FeatureRoom::Inside);
}

// Strictly, and the cell is one of the grid: those of the layer round it have their rims in one
// plane.
bool Extractor::is_within(const Vec3& p, const CrossedCell& cell) const
{
    const Box3 box = box_of(cell);
    for (std::size_t i = 0; i < 3; ++i)
        if (!(p[i] > box.min[i] && p[i] < box.max[i])) return false;
    return samples_.is_true(cell.i, cell.j, cell.k) &&
           samples_.is_true(cell.i + 1, cell.j + 1, cell.k + 1);
}

void Extractor::add_fan(std::span<const std::int32_t> rim, const Vec3& apex, bool feature,
                        Part& part) const
{
    const auto number = -1 - static_cast<std::int32_t>(part.inner.size());
    part.inner.push_back(apex);
    for (std::size_t n = 0; n < rim.size(); ++n) {
        const std::int32_t a = rim[n], b = rim[(n + 1) % rim.size()];
        if (feature)
            part.fans.push_back({static_cast<std::int64_t>(part.faces.size()), rim_key(a, b)});
        part.faces.push_back({a, b, number});
    }
}

// Empties the part.
void Extractor::append(Part& part, std::size_t first_slot)
{
    const auto first_inner = static_cast<std::int32_t>(mesh_.vertices.size());
    const std::size_t first_face = mesh_.faces.size();
    mesh_.vertices.insert(mesh_.vertices.end(), part.inner.begin(), part.inner.end());
    for (Triangle face : part.faces) {
        if (face[2] < 0) face[2] = first_inner - 1 - face[2];
        mesh_.faces.push_back(face);
    }
    for (const Fan& fan : part.fans)
        fans_.push_back({fan.face + static_cast<std::int64_t>(first_face), fan.rim});
    for (const Feature& f : part.features)
        features_of_cells_.push_back({f.cell, f.vertex + first_inner, f.is_doubtful});
    for (std::size_t n = 0; n < part.ends.size(); ++n) {
        if (part.ends[n] == (n > 0 ? part.ends[n - 1] : 0)) continue;
        const auto row = static_cast<std::int64_t>(samples_.bits().row_of(first_slot + n));
        const std::int64_t length = samples_.size()[1];
        rows_.push_back({row % length - samples_.pad(), row / length - samples_.pad(),
                         first_face + part.ends[n]});
    }
    part.inner.clear();
    part.faces.clear();
    part.fans.clear();
    part.features.clear();
    part.ends.clear();
}

// Looks for faces that cross. The cells of features that are in doubt take a step, or else all
// whose fans cross: without them the cells are those of marching cubes, which do not. False if
// there is nothing to be done.
bool Extractor::step_back()
{
    if (std::none_of(features_of_cells_.begin(), features_of_cells_.end(),
                     [](const Feature& f) { return f.is_doubtful; }))
        return false;
    std::vector<std::int32_t> feature_at(mesh_.n_vertices() - slopes_.size(), -1);
    for (std::size_t n = 0; n < features_of_cells_.size(); ++n)
        feature_at[features_of_cells_[n].vertex - slopes_.size()] = static_cast<std::int32_t>(n);
    const auto visit_features = [&](std::int64_t face, const auto& visit) {
        for (const std::int32_t v : mesh_.faces[face]) {
            if (v < static_cast<std::int32_t>(slopes_.size())) continue;
            const std::int32_t n = feature_at[v - slopes_.size()];
            if (n >= 0) visit(features_of_cells_[n]);
        }
    };
    std::vector<std::int32_t> doubtful;
    for (const Fan& fan : fans_) {
        bool any = false;
        visit_features(fan.face, [&](const Feature& f) { any = any || f.is_doubtful; });
        if (any) doubtful.push_back(static_cast<std::int32_t>(fan.face));
    }
    std::unordered_set<std::int64_t> cells;
    for (const auto& [a, b] : fan_crossings(mesh_, rows_, doubtful, samples_.frame())) {
        std::vector<std::int64_t> in_doubt, all;
        for (const std::int32_t face : {a, b})
            visit_features(face, [&](const Feature& f) {
                all.push_back(f.cell);
                if (f.is_doubtful) in_doubt.push_back(f.cell);
            });
        const auto& chosen = in_doubt.empty() ? all : in_doubt;
        cells.insert(chosen.begin(), chosen.end());
    }
    for (const std::int64_t cell : cells)
        steps_[cell] = step_of(cell) == Step::Near ? Step::Inside : Step::None;
    return !cells.empty();
}

// Does the sharp edge pass between two neighbouring crossings?
bool Extractor::feature_between(std::int32_t a, std::int32_t b) const
{
    return dot(slopes_[a], slopes_[b]) < features_.theta_sharp;
}

// Two fans over one rim edge: join their apexes instead, unless they are joined already.
//
//       b                 b
//     / | \             /   \        each fan triangle has one rim edge, so flips do not
//    f  |  g    -->    f --- g       touch each other
//     \ | /             \   /
//       a                 a
void Extractor::flip_across_features()
{
    std::vector<Fan>& fans = fans_;
    std::sort(fans.begin(), fans.end(), [](const Fan& x, const Fan& y) {
        return x.rim != y.rim ? x.rim < y.rim : x.face < y.face;
    });
    struct Flip {
        std::uint64_t apexes;
        std::int64_t first, second;
    };
    std::vector<Flip> flips;
    for (std::size_t n = 0; n + 1 < fans.size(); ++n) {
        if (fans[n].rim != fans[n + 1].rim) continue;
        const Triangle &x = mesh_.faces[fans[n].face], &y = mesh_.faces[fans[n + 1].face];
        if (x[2] != y[2] && feature_between(x[0], x[1]))
            flips.push_back({rim_key(x[2], y[2]), fans[n].face, fans[n + 1].face});
    }
    std::sort(flips.begin(), flips.end(), [](const Flip& x, const Flip& y) {
        return x.apexes != y.apexes ? x.apexes < y.apexes : x.first < y.first;
    });
    for (std::size_t n = 0; n < flips.size(); ++n) {
        if (n > 0 && flips[n].apexes == flips[n - 1].apexes) continue;
        Triangle &x = mesh_.faces[flips[n].first], &y = mesh_.faces[flips[n].second];
        const auto [a, b, f] = x;
        const std::int32_t g = y[2];
        x = {a, g, f};
        y = {b, f, g};
    }
}

}  // namespace

IndexedMesh extended_marching_cubes(const Implicit& field, const Box3& box,
                                    const ExtendedMarchingCubesOptions& options)
{
    require(std::isfinite(options.level), "extended_marching_cubes: level", options.level,
            "finite");
    const FieldSamples samples(field, cover(box, options.cell_size), options.level,
                               options.close_border, options.skip);
    Extractor extractor(samples, options.features);
    IndexedMesh mesh = extractor.extract();
    if (options.report)
        *options.report = {samples.n_samples(), samples.decided(), extractor.count(Step::Inside),
                           extractor.count(Step::None)};
    return mesh;
}

}  // namespace genus
