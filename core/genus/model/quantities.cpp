#include "genus/model/quantities.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/implicit/double_double.h"
#include "genus/mesh/measure.h"
#include "genus/model/boolean_road.h"
#include "genus/model/cell_integral.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/plan.h"
#include "genus/model/queries.h"
#include "genus/model/sign_formula.h"

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDefaultRelative = 1e-6, kLeastShare = 1e-6;
constexpr int kMaxLevel = 45;
// From this level on the cells that are not settled grow in number like their level at most.
constexpr int kFewCells = 5;
constexpr int kSmallCells = 8;
constexpr double kTooMuch = 4.0, kFloor = 3e-10;
// Where open cells hold no more than this share of what is wanted, the rest is not their fault.
constexpr double kOpenShare = 1e-2;
constexpr std::size_t kMaxPlaces = 64;
constexpr double kFirst = 1e-3;  // of the frame, for the first run
constexpr int kMaxRounds = 5;
constexpr double kFlat = 1.5;            // sides of a box
constexpr std::size_t kManyPlanes = 64;  // a polyhedron of more is measured on its mesh

/// Sums without the error of adding many.
class Sum {
public:
    void add(double x) { sum_ = sum_ + DoubleDouble(x); }
    double value() const { return sum_.rounded(); }

private:
    DoubleDouble sum_;
};

/// A frame round the box of this half size that no usual direction of a model is parallel to.
Frame frame_around(const Box3& box, const Vec3& half)
{
    const Transform turn = rotation(Vec3{{23.7, -31.3, 17.9}});
    double reach = 0.0;
    for (int k = 0; k < 3; ++k) {
        double row = 0.0;
        for (int i = 0; i < 3; ++i) row += std::fabs(turn.m[i][k]);
        reach = std::max(reach, row);
    }
    Frame frame;
    // Off the middle by a little, so that centres and planes of symmetry are on no cell wall.
    const Vec3 middle = box.center();
    for (int i = 0; i < 3; ++i) frame.o[i] = middle[i] + half[i] * (0.0131 - 0.0047 * i);
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) frame.axis[k][i] = 1.03 * reach * half[i] * turn.m[i][k];
    return frame;
}

struct Cell {
    std::array<std::uint64_t, 3> at;
    std::shared_ptr<const SignFormula> formula;
};

struct Outcome {
    double value = 0.0, error = 0.0;
    double open = 0.0;  // the most that an unsettled cell may hold
    std::shared_ptr<const SignFormula> formula;
};

/// One run over ever smaller cells, to a given error.
class Integration {
public:
    Integration(const CsgField& field, const Frame& frame, Quantity quantity, double wanted,
                std::int64_t max_cells)
        : quantity_(quantity), wanted_(wanted), max_cells_(max_cells), frame_(frame)
    {
        for (const Surface& surface : field.surfaces()) surfaces_.emplace_back(surface, frame_);
        for (int k = 0; k < 3; ++k)
            columns_[k] = cross(frame_.axis[(k + 1) % 3], frame_.axis[(k + 2) % 3]);
        stretch_ = std::fabs(dot(frame_.axis[0], columns_[0]));
        for (const Vec3& column : columns_) columns_size_ += norm(column);
        cells_ = {{{0, 0, 0}, std::make_shared<SignFormula>(field)}};
    }

    /// Volume, or a bound of area, of what a solid in the frame may have.
    double scale() const
    {
        return quantity_ == Quantity::Volume ? 8.0 * stretch_ : 8.0 * columns_size_;
    }

    const Frame& frame() const { return frame_; }
    const BoundedValue& result() const { return result_; }
    bool is_done() const { return done_; }
    /// True if it would take too many cells to be done.
    bool is_exhausted() const { return exhausted_; }
    /// Cells looked at, with those of the next step.
    std::int64_t n_cells() const { return n_cells_; }

    /// Looks at the cells of the next level.
    void step()
    {
        current_progress().report(quantity_ == Quantity::Volume ? "volume" : "area", 0.0);
        std::vector<Outcome> outcomes(cells_.size());
        parallel_for(cells_.size(), 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(surfaces_.size(), 0);
            for (std::size_t i = begin; i < end; ++i) outcomes[i] = look_at(cells_[i], signs);
        });
        double open = 0.0;
        std::vector<Cell> next;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            settled_.add(outcomes[i].value);
            error_.add(outcomes[i].error);
            if (outcomes[i].open == 0.0) continue;
            open += outcomes[i].open;
            next.push_back({cells_[i].at, std::move(outcomes[i].formula)});
        }
        result_ = {settled_.value() + 0.5 * open, error_.value() + 0.5 * open, true};
        // What rounds in the frame's own size and in the sums.
        result_.bound += 1e-14 * result_.value;
        cells_ = std::move(next);
        const auto n = static_cast<std::int64_t>(cells_.size());
        done_ = cells_.empty() || result_.bound <= wanted_ || level_ == kMaxLevel ||
                0.5 * open <= kOpenShare * wanted_;
        exhausted_ = !done_ && n_cells_ + 8 * n > max_cells_;
        if (!done_ && !exhausted_) split();
    }

    /// True if what is missing comes from settled cells, so that less may be wanted of them.
    bool is_rounding() const
    {
        return result_.bound - error_.value() <= 2.0 * kOpenShare * wanted_;
    }

    std::vector<Box3> open_places() const
    {
        std::vector<Box3> places;
        const double half = std::ldexp(1.0, -level_);
        for (const Cell& cell : cells_) {
            if (places.size() == kMaxPlaces) break;
            const Vec3 center = center_of(cell);
            Box3 box;
            for (int corner = 0; corner < 8; ++corner) {
                Vec3 p = frame_.o;
                for (int k = 0; k < 3; ++k)
                    p += (center[k] + (corner >> k & 1 ? half : -half)) * frame_.axis[k];
                box.add(p);
            }
            places.push_back(box);
        }
        return places;
    }

private:
    Vec3 center_of(const Cell& cell) const
    {
        const double half = std::ldexp(1.0, -level_);
        Vec3 center;
        for (int k = 0; k < 3; ++k)
            center[k] = half * static_cast<double>(2 * cell.at[k] + 1) - 1.0;
        return center;
    }

    void split()
    {
        std::vector<Cell> finer;
        finer.reserve(8 * cells_.size());
        for (const Cell& cell : cells_)
            for (std::uint64_t child = 0; child < 8; ++child)
                finer.push_back({{2 * cell.at[0] + (child & 1), 2 * cell.at[1] + (child >> 1 & 1),
                                  2 * cell.at[2] + (child >> 2 & 1)},
                                 cell.formula});
        cells_ = std::move(finer);
        n_cells_ += static_cast<std::int64_t>(cells_.size());
        ++level_;
    }

    Outcome look_at(const Cell& cell, std::vector<Sign>& signs) const
    {
        const double half = std::ldexp(1.0, -level_);
        const Vec3 center = center_of(cell);
        std::vector<std::pair<std::int32_t, LocalForm>> forms;
        for (const std::int32_t s : cell.formula->surfaces()) {
            forms.emplace_back(s, LocalForm(surfaces_[s], center, half));
            const Interval range = forms.back().second.range();
            signs[s] = range.lo > 0.0 ? 1 : range.hi < 0.0 ? -1 : 0;
        }
        Outcome outcome;
        outcome.formula = std::make_shared<SignFormula>(cell.formula->simplified(signs));
        for (const std::int32_t s : cell.formula->surfaces()) signs[s] = 0;
        const double volume = 8.0 * stretch_ * half * half * half;
        if (const Sign sign = outcome.formula->constant()) {
            if (quantity_ == Quantity::Volume && sign < 0) outcome.value = volume;
            return outcome;
        }
        const std::vector<std::int32_t>& deciding = outcome.formula->surfaces();
        std::erase_if(forms, [&](const auto& form) {
            return !std::binary_search(deciding.begin(), deciding.end(), form.first);
        });
        if (forms.size() <= CellSolid::kMostSurfaces) {
            CellSolid solid;
            for (auto& [s, form] : forms) solid.forms.push_back(form);
            solid.inside = inside_table(*outcome.formula, deciding, signs);
            // The cells together have the volume of the frame; those at a surface, a few times the
            // area of its sides, at each size. Small cells are few, so they may err by more.
            const bool by_volume = quantity_ == Quantity::Volume;
            const double unit = by_volume ? volume / 8.0 : half * half;
            const double wanted = std::ldexp(by_volume ? wanted_ / scale() : wanted_ / 256.0,
                                             std::max(0, level_ - kFewCells));
            const auto part = integrate_cell(solid, quantity_, columns_, wanted);
            // A large cell with a large error, as from curves that meet at a small angle, is cut.
            const double most = level_ < kSmallCells ? kTooMuch * wanted + kFloor : kInfinity;
            if (part && part->error <= most) {
                outcome.value = unit * part->value;
                outcome.error = unit * part->error;
                return outcome;
            }
        }
        outcome.open = volume;
        if (quantity_ == Quantity::Area) {
            int hits = 0;
            for (const auto& [s, form] : forms)
                hits += form.is_quartic() ? 4 : form.is_linear() ? 1 : 2;
            outcome.open = hits * 4.0 * half * half * columns_size_;
        }
        return outcome;
    }

    static std::uint64_t inside_table(const SignFormula& formula,
                                      const std::vector<std::int32_t>& surfaces,
                                      std::vector<Sign>& signs)
    {
        std::uint64_t table = 0;
        for (std::uint32_t sides = 0; sides >> surfaces.size() == 0; ++sides) {
            for (std::size_t i = 0; i < surfaces.size(); ++i)
                signs[surfaces[i]] = sides >> i & 1 ? 1 : -1;
            if (formula.sign(signs) < 0) table |= std::uint64_t{1} << sides;
        }
        for (const std::int32_t s : surfaces) signs[s] = 0;
        return table;
    }

    Quantity quantity_;
    double wanted_;
    std::int64_t max_cells_;
    Frame frame_;
    std::vector<FramedSurface> surfaces_;
    std::array<Vec3, 3> columns_;  // of the matrix of cofactors of the frame
    double stretch_ = 0.0, columns_size_ = 0.0;
    std::vector<Cell> cells_;
    int level_ = 0;
    std::int64_t n_cells_ = 1;
    bool done_ = false, exhausted_ = false;
    Sum settled_, error_;
    BoundedValue result_;
};

const char* name_of(Quantity quantity)
{
    return quantity == Quantity::Volume ? "volume" : "area";
}

/// The largest bound that will do for a value.
double allowed(const QuantityOptions& options, double value, double scale)
{
    double most = options.tolerance.value_or(kInfinity);
    if (options.relative || !options.tolerance)
        most = std::min(most, options.relative.value_or(kDefaultRelative) *
                                  std::max(value, kLeastShare * scale));
    return most;
}

[[noreturn]] void give_up(Quantity quantity, double asked, const BoundedValue& reached,
                          std::vector<Box3> places)
{
    throw ToleranceNotMet(std::string(name_of(quantity)) + ": " + to_text(reached.value) +
                              " within " + to_text(reached.bound) + ", asked for " + to_text(asked),
                          asked, reached.bound, std::move(places));
}

/// Two frames to try: of the shape of the box, in which a needle is a ball, and if that is far from
/// a cube one, in which a thin ring stays round.
std::vector<Frame> frames_to_try(const Box3& box)
{
    const Vec3 half = 0.5 * box.size();
    const auto [least, most] = std::minmax({half[0], half[1], half[2]});
    std::vector<Frame> frames{frame_around(box, half)};
    if (most > kFlat * least) frames.push_back(frame_around(box, Box3::filled(most)));
    return frames;
}

/// Runs them level by level side by side, always the one that has the fewest cells so far, until
/// one is done or all are exhausted: this costs no more than twice what the better of two does.
Integration first_done(std::vector<Integration>&& runs)
{
    for (;;) {
        const auto next = std::min_element(runs.begin(), runs.end(),
                                           [](const Integration& a, const Integration& b) {
                                               return std::pair(a.is_exhausted(), a.n_cells()) <
                                                      std::pair(b.is_exhausted(), b.n_cells());
                                           });
        if (next->is_done() || next->is_exhausted()) return std::move(*next);
        next->step();
    }
}

BoundedValue by_cells(const Solid& solid, const Box3& box, Quantity quantity,
                      const QuantityOptions& options)
{
    const CsgField field(solid);
    std::vector<Frame> frames = frames_to_try(box);
    // First roughly: what is asked for may depend on the value.
    const double scale = Integration(field, frames[0], quantity, 1.0, 1).scale();
    double most = allowed(options, kInfinity, scale);
    double wanted = std::min(most, kFirst * scale);
    for (int round = 0;; ++round) {
        std::vector<Integration> runs;
        for (const Frame& frame : frames)
            runs.emplace_back(field, frame, quantity, wanted, options.max_cells);
        const Integration integration = first_done(std::move(runs));
        const BoundedValue& result = integration.result();
        most = allowed(options, result.value - result.bound, scale);
        if (result.bound <= most) return result;
        const bool met = result.bound <= wanted;
        if (round == kMaxRounds || (!met && !integration.is_rounding()))
            give_up(quantity, most, result, integration.open_places());
        frames = {integration.frame()};
        // The sum of many small errors may exceed what was wanted.
        wanted = met ? 0.5 * most : 0.1 * wanted;
    }
}

BoundedValue measured_on(const IndexedMesh& mesh, Quantity quantity, double deviation,
                         bool certified)
{
    const Measures m = measure(mesh);
    const double rounding = 1e-13 * (quantity == Quantity::Volume
                                         ? std::fabs(m.volume) + m.area * bounds(mesh).diagonal()
                                         : m.area);
    if (quantity == Quantity::Volume) return {m.volume, m.area * deviation + rounding, certified};
    // How much area a small move takes or gives no bound tells; a share like that of the size.
    const double share = deviation == 0.0 ? 0.0 : 8.0 * deviation / bounds(mesh).diagonal();
    return {m.area, m.area * share + rounding, certified && deviation == 0.0};
}

BoundedValue by_mesh(const Solid& solid, const Box3& box, Quantity quantity,
                     const QuantityOptions& options)
{
    const bool exact = is_polyhedral(solid);
    MeshOptions mesh_options;
    mesh_options.measure = false;
    double tolerance = 1e-3 * box.diagonal();
    BoundedValue result;
    for (int round = 0; round < 8; ++round) {
        mesh_options.tolerance = tolerance;
        const MeshedSolid made = mesh_solid(solid, mesh_options);
        result = measured_on(made.mesh, quantity, made.error.bound, exact && made.error.certified);
        const double most = allowed(options, result.value, 0.0);
        if (result.bound <= most) return result;
        if (exact) break;
        tolerance *= std::clamp(0.5 * most / result.bound, 1e-4, 0.5);
    }
    give_up(quantity, allowed(options, result.value, 0.0), result, {box});
}

/// True if the tree is a formula over polynomials.
bool is_algebraic(const Solid& solid)
{
    try {
        const CsgField field(solid);
        return std::all_of(field.surfaces().begin(), field.surfaces().end(), [](const Surface& s) {
            return s.kind == Surface::Kind::Plane || s.kind == Surface::Kind::Quadric ||
                   s.kind == Surface::Kind::Torus;
        });
    } catch (const InvalidInput&) {
        return false;  // a polyhedron that is not convex, or freeform
    }
}

BoundedValue quantity_of(const Solid& solid, Quantity quantity, const QuantityOptions& options)
{
    const std::string name = name_of(quantity);
    if (options.tolerance)
        require(*options.tolerance > 0.0 && std::isfinite(*options.tolerance),
                (name + ": tolerance").c_str(), *options.tolerance, "positive");
    if (options.relative)
        require(*options.relative > 0.0 && std::isfinite(*options.relative),
                (name + ": relative").c_str(), *options.relative, "positive");
    require(options.max_cells > 0, (name + ": max_cells must be positive").c_str());
    const Solid planned = plan(solid).solid;
    const Box3 box = require_bounded(planned);
    if (planned.is_empty() || box.empty()) return {};
    const Vec3 size = box.size();
    if (!(size[0] > 0.0 && size[1] > 0.0 && size[2] > 0.0)) return {};
    if (!is_algebraic(planned)) return by_mesh(planned, box, quantity, options);
    if (is_polyhedral(planned) && CsgField(planned).surfaces().size() > kManyPlanes)
        return by_mesh(planned, box, quantity, options);
    return by_cells(planned, box, quantity, options);
}

}  // namespace

BoundedValue volume(const Solid& solid, const QuantityOptions& options)
{
    return quantity_of(solid, Quantity::Volume, options);
}

BoundedValue area(const Solid& solid, const QuantityOptions& options)
{
    return quantity_of(solid, Quantity::Area, options);
}

}  // namespace genus
