#include "genus/deform/inverse_ffd.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr std::size_t kMaxEntries = std::size_t{1} << 27;

std::vector<std::size_t> free_points(const Lattice& lattice, int keep_border)
{
    const auto& n = lattice.counts();
    std::vector<std::size_t> free;
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k)
                if (std::min({i, j, k, n[0] - 1 - i, n[1] - 1 - j, n[2] - 1 - k}) > keep_border)
                    free.push_back(lattice.index(i, j, k));
    return free;
}

double size_of(const Lattice& lattice)
{
    const auto& a = lattice.axes();
    return norm(a[0]) + norm(a[1]) + norm(a[2]);
}

}  // namespace

InverseFfd::InverseFfd(Lattice lattice, std::vector<FfdConstraint> constraints,
                       const FfdFitOptions& options)
    : lattice_(std::move(lattice)), constraints_(std::move(constraints)), options_(options)
{
    require(!constraints_.empty(), "InverseFfd: there are no constraints");
    require(options.regularisation >= 0.0 && std::isfinite(options.regularisation),
            "InverseFfd: regularisation", options.regularisation, "not negative and finite");
    require(options.keep_border >= -1, "InverseFfd: keep_border", options.keep_border,
            "at least -1");
    free_ = free_points(lattice_, options.keep_border);
    require(!free_.empty(), "InverseFfd: keep_border leaves no control point to move");
    const std::size_t rows = constraints_.size(), cols = free_.size();
    require(rows <= kMaxEntries / cols, "InverseFfd: constraints times control points",
            static_cast<double>(rows) * static_cast<double>(cols), "at most 2^27");

    std::vector<double> a;
    a.reserve(rows * cols);
    for (const FfdConstraint& c : constraints_) {
        current_progress().check();
        require(
            is_finite(c.point) && is_finite(c.target) && (!c.direction || is_finite(*c.direction)),
            "InverseFfd: a constraint is not finite");
        require(c.weight > 0.0 && std::isfinite(c.weight), "InverseFfd: weight", c.weight,
                "positive and finite");
        require(Box3{{}, {{1, 1, 1}}}.contains(lattice_.local(c.point)),
                "InverseFfd: a constraint lies outside the lattice");
        const auto w = lattice_.weights(c.point, c.direction);
        for (const std::size_t k : free_) a.push_back(c.weight * w[k]);
    }
    plain_.emplace(rows, cols, a, options.rank_tolerance);
    if (options.regularisation == 0.0) return;
    // min |A x - b|^2 + r |x|^2. With few rows it is the least-norm solution of
    // A x + sqrt(r) y = b, otherwise the least-squares solution of the stacked system.
    const double root = std::sqrt(options.regularisation);
    wide_ = rows < cols;
    const std::size_t more = wide_ ? rows : cols;
    require((wide_ ? rows : rows + cols) <= kMaxEntries / (wide_ ? rows + cols : cols),
            "InverseFfd: the regularised system is too large");
    std::vector<double> b;
    if (wide_) {
        for (std::size_t i = 0; i < rows; ++i) {
            b.insert(b.end(), a.begin() + static_cast<std::ptrdiff_t>(i * cols),
                     a.begin() + static_cast<std::ptrdiff_t>((i + 1) * cols));
            for (std::size_t j = 0; j < more; ++j) b.push_back(i == j ? root : 0.0);
        }
        solver_rows_ = rows;
        solver_.emplace(rows, cols + more, b, options.rank_tolerance);
    } else {
        b = std::move(a);
        for (std::size_t i = 0; i < more; ++i)
            for (std::size_t j = 0; j < cols; ++j) b.push_back(i == j ? root : 0.0);
        solver_rows_ = rows + more;
        solver_.emplace(rows + more, cols, b, options.rank_tolerance);
    }
}

Vec3 InverseFfd::current(const FfdConstraint& c, const Lattice& lattice) const
{
    if (!c.direction) return lattice.apply(c.point);
    const Columns3 j = lattice.jacobian(c.point);
    const Vec3& v = *c.direction;
    return v[0] * j[0] + v[1] * j[1] + v[2] * j[2];
}

std::vector<double> InverseFfd::right_side(std::span<const Vec3> targets) const
{
    std::vector<double> b((solver_ ? solver_rows_ : constraints_.size()) * 3);
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
        const Vec3 wanted =
            constraints_[i].weight * (targets[i] - current(constraints_[i], lattice_));
        for (std::size_t k = 0; k < 3; ++k) b[3 * i + k] = wanted[k];
    }
    return b;
}

FfdFit InverseFfd::solve() const
{
    std::vector<Vec3> targets;
    for (const FfdConstraint& c : constraints_) targets.push_back(c.target);
    return solve(targets);
}

FfdFit InverseFfd::solve(std::span<const Vec3> targets) const
{
    require(targets.size() == constraints_.size(), "InverseFfd::solve: number of targets",
            static_cast<double>(targets.size()), "that of the constraints");
    for (const Vec3& t : targets)
        require(is_finite(t), "InverseFfd::solve: a target is not finite");
    const auto x = (solver_ ? *solver_ : *plain_).solve(right_side(targets), 3);
    FfdFit fit{lattice_, plain_->kind(), plain_->rank(), plain_->condition(), {}, 0.0, 0.0, {}, {}};
    auto moves = lattice_.moves();
    for (std::size_t j = 0; j < free_.size(); ++j) {
        const Vec3 move = {{x[3 * j], x[3 * j + 1], x[3 * j + 2]}};
        moves[free_[j]] += move;
        fit.moved += dot(move, move);
    }
    fit.moved = std::sqrt(fit.moved);
    fit.lattice.set_moves(std::move(moves));

    std::map<std::array<double, 3>, std::vector<std::size_t>> by_point;
    for (std::size_t i = 0; i < constraints_.size(); ++i) {
        const FfdConstraint& c = constraints_[i];
        fit.residuals.push_back(distance(current(c, fit.lattice), targets[i]));
        fit.largest_residual = std::max(fit.largest_residual, fit.residuals.back());
        if (fit.residuals.back() > options_.met * size_of(lattice_)) fit.unmet.push_back(i);
        auto& same = by_point[{c.point[0] + 0.0, c.point[1] + 0.0, c.point[2] + 0.0}];
        for (const std::size_t k : same)
            if (constraints_[k].direction == c.direction && targets[k] != targets[i]) {
                fit.contradictions.emplace_back(k, i);
                break;
            }
        same.push_back(i);
    }
    return fit;
}

std::string FfdFit::summary() const
{
    std::string text = std::string(to_text(kind)) + ", rank " + std::to_string(rank) +
                       ", condition " + to_text(condition) + ", largest residual " +
                       to_text(largest_residual);
    if (!unmet.empty())
        text += ", " + std::to_string(unmet.size()) + " of " + std::to_string(residuals.size()) +
                " constraints not met";
    if (!contradictions.empty())
        text += ", constraints " + std::to_string(contradictions[0].first) + " and " +
                std::to_string(contradictions[0].second) + " contradict";
    return text;
}

FfdFit fit_lattice(const Lattice& lattice, std::vector<FfdConstraint> constraints,
                   const FfdFitOptions& options)
{
    return InverseFfd(lattice, std::move(constraints), options).solve();
}

}  // namespace genus
