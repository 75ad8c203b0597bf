#include "genus/model/nearest.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <queue>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/local_form.h"
#include "genus/model/queries.h"
#include "genus/model/sign_formula.h"

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnit = std::numeric_limits<double>::epsilon();
constexpr double kClose = 1e-10;  // of the diagonal: what is nearer by less is not searched for
constexpr double kOn = 1e-12;     // how near to a surface is on it, in the frame
constexpr int kMostBoxes = 20'000;
// Surfaces of a box among which edges and corners are tried, and all of whose signs are.
constexpr std::size_t kMostSubsets = 6, kMostCases = 8;
constexpr int kNewtonSteps = 40;

/// Not above c + g.e + (quadratic a in e) on the box |e_k| <= 1.
double least_on_box(double c, const Vec3& g, const std::array<double, 6>& a)
{
    double sum = c, size = std::fabs(c);
    for (int k = 0; k < 3; ++k) {
        double least = a[k] - std::fabs(g[k]);
        if (a[k] > 0.0 && std::fabs(g[k]) < 2.0 * a[k]) least = -0.25 * g[k] * g[k] / a[k];
        sum += least - std::fabs(a[3 + k]);
        size += std::fabs(g[k]) + std::fabs(a[k]) + std::fabs(a[3 + k]);
    }
    return sum - 32.0 * kUnit * size;
}

/// F on the cell is a quadratic to within `rest`.
struct Quadratic {
    explicit Quadratic(const LocalForm& form)
    {
        const LocalForm::Expansion x = form.about({});
        double linear = 0.0, u = 0.0;
        for (int k = 0; k < 3; ++k) linear += std::fabs(x.sigma[k]);
        for (const double part : x.u) u += std::fabs(part);
        c = x.value;
        g = x.gradient;
        a = x.a;
        rest = form.slack(1.0) + 1.001 * (2.0 * linear * u + u * u);
    }

    double c;
    Vec3 g;
    std::array<double, 6> a;
    double rest;
};

/// Whether mu (|e - center|^2 - radius^2) + sum lambda_i F_i > 0 on the cell.
bool is_positive(std::span<const Quadratic> terms, std::span<const double> lambda, double mu,
                 const Vec3& center, double radius)
{
    const double far2 = dot(center, center);
    double c = mu * (far2 - radius * radius);
    Vec3 g = -2.0 * mu * center;
    std::array<double, 6> a{mu, mu, mu, 0.0, 0.0, 0.0};
    double rest = 16.0 * kUnit * mu * (far2 + radius * radius);
    for (std::size_t i = 0; i < terms.size(); ++i) {
        const Quadratic& t = terms[i];
        double size = std::fabs(t.c);
        c += lambda[i] * t.c;
        g += lambda[i] * t.g;
        for (std::size_t k = 0; k < 6; ++k) {
            a[k] += lambda[i] * t.a[k];
            size += std::fabs(t.a[k]);
        }
        for (int k = 0; k < 3; ++k) size += std::fabs(t.g[k]);
        rest += std::fabs(lambda[i]) * (t.rest + 8.0 * kUnit * size);
    }
    return least_on_box(c, g, a) > rest;
}

/// The sign that F has at all points of the cell nearer than `radius` to `center`, if one can be
/// told: F > 0 there if F + mu (|e - center|^2 - radius^2) > 0 on the cell for some mu >= 0.
Sign sign_near(const LocalForm& form, const Vec3& center, double radius)
{
    const Quadratic f(form);
    // Where the level sets of F are about those of the distance: on the way to the middle.
    const double away = norm(center);
    const Vec3 to = away > 0.0 ? center - (radius / away) * center : Vec3{{radius, 0, 0}};
    const double fit = 0.5 * norm(form.gradient(to)) / radius;
    for (const double mu : {0.0, fit, 0.5 * fit, 2.0 * fit})
        for (const Sign sign : {Sign{1}, Sign{-1}}) {
            const double s = sign;
            if (is_positive({&f, 1}, {&s, 1}, mu, center, radius)) return sign;
        }
    return 0;
}

/// Solves the n equations m x = b of at most six, by elimination with pivots. False if singular.
bool solve(std::array<std::array<double, 7>, 6>& m, std::size_t n, std::array<double, 6>& x)
{
    for (std::size_t k = 0; k < n; ++k) {
        std::size_t pivot = k;
        for (std::size_t i = k + 1; i < n; ++i)
            if (std::fabs(m[i][k]) > std::fabs(m[pivot][k])) pivot = i;
        if (!(std::fabs(m[pivot][k]) > 1e-300)) return false;
        std::swap(m[k], m[pivot]);
        for (std::size_t i = k + 1; i < n; ++i) {
            const double factor = m[i][k] / m[k][k];
            for (std::size_t j = k; j <= n; ++j) m[i][j] -= factor * m[k][j];
        }
    }
    for (std::size_t k = n; k-- > 0;) {
        double sum = m[k][n];
        for (std::size_t j = k + 1; j < n; ++j) sum -= m[k][j] * x[j];
        x[k] = sum / m[k][k];
    }
    return true;
}

/// The numbers lambda for which sum lambda_i grad F_i(q) comes nearest to p - q. False if the
/// gradients depend on each other.
bool multipliers(std::span<const LocalForm> forms, const Vec3& q, const Vec3& p,
                 std::span<double> lambda)
{
    const std::size_t n = forms.size();
    std::array<Vec3, 3> g;
    std::array<double, 3> length{};
    for (std::size_t i = 0; i < n; ++i) {
        g[i] = forms[i].gradient(q);
        length[i] = norm(g[i]);
        if (!(length[i] > 0.0)) return false;
        g[i] = g[i] / length[i];
    }
    std::array<std::array<double, 7>, 6> m{};
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) m[i][j] = dot(g[i], g[j]);
        m[i][n] = dot(g[i], p - q);
    }
    std::array<double, 6> solution{};
    if (!solve(m, n, solution)) return false;
    for (std::size_t i = 0; i < n; ++i) lambda[i] = solution[i] / length[i];
    return true;
}

/// The point of the common zeros of up to three forms, from `start` on, where the distance to p is
/// stationary: Newton's method for the conditions of Lagrange. Nothing if it does not settle.
std::optional<Vec3> stationary_point(std::span<const LocalForm* const> forms, const Vec3& p,
                                     const Vec3& start)
{
    const std::size_t n = forms.size();
    Vec3 q = start;
    std::array<double, 3> lambda{};
    for (int step = 0; step < kNewtonSteps; ++step) {
        std::array<std::array<double, 7>, 6> m{};
        for (int k = 0; k < 3; ++k) {
            m[k][k] = 1.0;
            m[k][3 + n] = p[k] - q[k];
        }
        for (std::size_t i = 0; i < n; ++i) {
            const LocalForm::Expansion x = forms[i]->about(q);
            const double length = norm(x.gradient);
            if (!(length > 0.0)) return std::nullopt;
            for (int k = 0; k < 3; ++k) {
                // q + dq - p + lambda g(q + dq) = 0 and F(q + dq) = 0, both linear in dq.
                m[k][3 + i] = m[3 + i][k] = x.gradient[k] / length;
                m[k][k] += lambda[i] * 2.0 * x.a[k] / length;
                for (int j = 0; j < 3; ++j)
                    if (j != k) m[k][j] += lambda[i] * x.a[mixed(j, k)] / length;
            }
            m[3 + i][3 + n] = -x.value / length;
        }
        std::array<double, 6> solution{};
        if (!solve(m, 3 + n, solution)) return std::nullopt;
        Vec3 dq{{solution[0], solution[1], solution[2]}};
        const double length = norm(dq);
        if (!(length <= 1e3)) return std::nullopt;
        if (length > 0.5) dq = (0.5 / length) * dq;  // of the size of the solid
        q += dq;
        for (std::size_t i = 0; i < n; ++i) lambda[i] = solution[3 + i];
        if (norm(dq) <= 4.0 * kUnit * (1.0 + norm(q))) return q;
    }
    return std::nullopt;
}

/// A common zero of up to three forms near `start`: Newton's method with the shortest steps.
/// Nothing if it does not settle.
std::optional<Vec3> common_zero(std::span<const LocalForm* const> forms, const Vec3& start)
{
    const std::size_t n = forms.size();
    Vec3 q = start;
    for (int step = 0; step < kNewtonSteps; ++step) {
        std::array<Vec3, 3> g;
        std::array<std::array<double, 7>, 6> m{};
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3 gradient = forms[i]->gradient(q);
            const double length = norm(gradient);
            if (!(length > 0.0)) return std::nullopt;
            g[i] = gradient / length;
            m[i][n] = -forms[i]->value(q) / length;
        }
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j < n; ++j) m[i][j] = dot(g[i], g[j]);
        std::array<double, 6> solution{};
        if (!solve(m, n, solution)) return std::nullopt;
        Vec3 dq;
        for (std::size_t i = 0; i < n; ++i) dq += solution[i] * g[i];
        if (!(norm(dq) <= 1e3)) return std::nullopt;
        q += dq;
        if (norm(dq) <= 16.0 * kUnit * (1.0 + norm(q))) return q;
    }
    return std::nullopt;
}

/// Whether q is a zero of all of them. Of equations that depend on each other a solver may give
/// anything.
bool is_on(std::span<const LocalForm* const> forms, const Vec3& q)
{
    return std::all_of(forms.begin(), forms.end(), [&](const LocalForm* form) {
        return std::fabs(form->value(q)) <= kOn * norm(form->gradient(q)) + form->slack(4.0);
    });
}

struct Box {
    double least;  // distance from the point asked for
    Vec3 center;
    double half;
    std::shared_ptr<const SignFormula> formula;
    bool operator<(const Box& other) const { return least > other.least; }
};

class Search {
public:
    explicit Search(const Solid& solid) : field_(solid)
    {
        for (const Surface& s : field_.surfaces())
            require(s.kind == Surface::Kind::Plane || s.kind == Surface::Kind::Quadric ||
                        s.kind == Surface::Kind::Torus,
                    "nearest: a leaf of the solid is no polynomial");
        const Box3 box = require_bounded(solid);
        require(!field_.instructions().empty() && !box.empty() && box.diagonal() > 0.0,
                "nearest: the solid has no surface");
        size_ = 0.5 * box.diagonal();
        frame_.o = box.center();
        for (int k = 0; k < 3; ++k) frame_.axis[k][k] = size_;
        for (const Surface& s : field_.surfaces()) {
            framed_.emplace_back(s, frame_);
            forms_.emplace_back(framed_.back(), Vec3{}, 1.0);
        }
        root_ = std::make_shared<SignFormula>(field_);
    }

    SurfacePoint operator()(const Vec3& point) const
    {
        require(is_finite(point), "nearest: a point is not finite");
        Task task{(point - frame_.o) / size_,
                  kInfinity,
                  {},
                  {-1, -1, -1},
                  std::vector<Sign>(framed_.size(), 0)};
        std::priority_queue<Box> open;
        open.push({0.0, {}, 1.0, root_});
        double least = kInfinity;  // of what was not looked at
        for (int n = 0; !open.empty(); ++n) {
            const Box box = open.top();
            open.pop();
            if (box.least >= task.best - kClose) break;
            if (n == kMostBoxes) {
                least = box.least;
                break;
            }
            look_at(box, task, open);
        }
        require(task.best < kInfinity, "nearest: the solid has no surface");
        SurfacePoint found;
        found.point = frame_.o + size_ * task.q;
        found.distance = distance(found.point, point);
        found.bound = size_ * (std::max(0.0, task.best - least) + 2.0 * kClose);
        found.surfaces = task.surfaces;
        return found;
    }

private:
    struct Task {
        Vec3 p;  // in the frame, like q
        double best;
        Vec3 q;
        std::array<std::int32_t, 3> surfaces;
        std::vector<Sign> signs;
    };

    void look_at(const Box& box, Task& task, std::priority_queue<Box>& open) const
    {
        const Vec3 from = (task.p - box.center) / box.half;
        const double radius = std::min(1e8, (task.best - kClose) / box.half);
        const std::vector<std::int32_t>& surfaces = box.formula->surfaces();
        for (const std::int32_t s : surfaces)
            task.signs[s] = sign_near(LocalForm(framed_[s], box.center, box.half), from,
                                      task.best < kInfinity ? radius : 1e8);
        auto formula = std::make_shared<SignFormula>(box.formula->simplified(task.signs));
        const bool none = formula->constant() != 0 || ruled_out(*formula, box, from, radius, task);
        for (const std::int32_t s : surfaces) task.signs[s] = 0;
        if (none) return;
        try_points(*formula, box, task);
        const double half = 0.5 * box.half;
        if (!(half > 1e-12)) return;
        for (int child = 0; child < 8; ++child) {
            Vec3 center = box.center;
            for (int k = 0; k < 3; ++k) center[k] += child >> k & 1 ? half : -half;
            const double least =
                distance(Box3{center - Box3::filled(half), center + Box3::filled(half)}, task.p);
            if (least < task.best - kClose) open.push({least, center, half, formula});
        }
    }

    /// Whether no point of the surface in the box is nearer than the best so far, q. With the
    /// multipliers of q a weighted sum of its surfaces' functions is positive wherever it is
    /// nearer, if that is so on the cell by a quadratic bound; then not all terms can be negative
    /// there, and the formula must have one sign for all other signs of its surfaces.
    bool ruled_out(const SignFormula& formula, const Box& box, const Vec3& from, double radius,
                   Task& task) const
    {
        if (!(task.best < kInfinity) || formula.surfaces().size() > kMostCases) return false;
        std::vector<LocalForm> forms;
        for (const std::int32_t s : task.surfaces)
            if (s >= 0) forms.emplace_back(framed_[s], box.center, box.half);
        std::array<double, 3> lambda{};
        const std::span<double> weights(lambda.data(), forms.size());
        if (!multipliers(forms, (task.q - box.center) / box.half, from, weights)) return false;
        const std::vector<Quadratic> terms(forms.begin(), forms.end());
        return is_positive(terms, weights, 0.5, from, radius) &&
               same_sign_unless(formula, task.surfaces, weights, task.signs);
    }

    /// Whether the formula has one sign for all signs of its surfaces but those where each of the
    /// `named` has that opposite to its weight.
    static bool same_sign_unless(const SignFormula& formula, std::span<const std::int32_t> named,
                                 std::span<const double> weights, std::vector<Sign>& signs)
    {
        const std::vector<std::int32_t>& open = formula.surfaces();
        bool inside = false, outside = false;
        for (std::uint32_t bits = 0; bits < 1u << open.size(); ++bits) {
            for (std::size_t i = 0; i < open.size(); ++i)
                signs[open[i]] = bits >> i & 1 ? Sign{1} : Sign{-1};
            bool excluded = true;
            for (std::size_t i = 0; i < weights.size(); ++i)
                excluded &= weights[i] == 0.0 || signs[named[i]] * weights[i] < 0.0;
            if (!excluded) (formula.sign(signs) < 0 ? inside : outside) = true;
        }
        for (const std::int32_t s : open) signs[s] = 0;
        return !(inside && outside);
    }

    /// Faces, edges and corners of the surfaces that decide in the box.
    void try_points(const SignFormula& formula, const Box& box, Task& task) const
    {
        const std::vector<std::int32_t>& all = formula.surfaces();
        const std::size_t n = std::min(all.size(), kMostSubsets);
        for (std::size_t i = 0; i < n; ++i) {
            try_point({all[i], -1, -1}, box, task);
            for (std::size_t j = 0; j < i; ++j) {
                try_point({all[i], all[j], -1}, box, task);
                for (std::size_t k = 0; k < j; ++k) try_point({all[i], all[j], all[k]}, box, task);
            }
        }
    }

    void try_point(const std::array<std::int32_t, 3>& surfaces, const Box& box, Task& task) const
    {
        std::array<const LocalForm*, 3> forms{};
        std::size_t n = 0;
        for (const std::int32_t s : surfaces)
            if (s >= 0) forms[n++] = &forms_[s];
        const std::span<const LocalForm* const> chosen = std::span(forms).first(n);
        auto q = stationary_point(chosen, task.p, box.center);
        // Of points at one distance none is stationary alone; any of them will do.
        if (!q) q = common_zero(chosen, box.center);
        if (!q || !(norm(*q) <= 4.0) || !is_on(chosen, *q)) return;
        const double away = distance(*q, task.p);
        // On equal terms a point of more surfaces is the better description.
        if (!(away < task.best - 1e-15)) return;
        // The signs of the others there; those that are zero to rounding are left open.
        const std::vector<std::int32_t>& known = root_->surfaces();
        for (const std::int32_t s : known) {
            const bool own = std::find(surfaces.begin(), surfaces.end(), s) != surfaces.end();
            const double value = forms_[s].value(*q);
            const bool zero = std::fabs(value) <= 4.0 * forms_[s].slack(4.0);
            task.signs[s] = own || zero ? 0 : value > 0.0 ? 1 : -1;
        }
        const SignFormula there = root_->simplified(task.signs);
        const bool counts = there.constant() == 0;
        for (const std::int32_t s : known) task.signs[s] = 0;
        if (!counts) return;
        task.best = away;
        task.q = *q;
        task.surfaces = surfaces;
        std::sort(task.surfaces.begin(), task.surfaces.begin() + static_cast<std::ptrdiff_t>(n));
    }

    CsgField field_;
    double size_ = 1.0;
    Frame frame_;
    std::vector<FramedSurface> framed_;
    std::vector<LocalForm> forms_;  // over the whole frame
    std::shared_ptr<const SignFormula> root_;
};

}  // namespace

std::vector<SurfacePoint> nearest_points(const Solid& solid, std::span<const Vec3> points)
{
    const Search search(solid);
    std::vector<SurfacePoint> found(points.size());
    parallel_for(points.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) found[i] = search(points[i]);
    });
    return found;
}

}  // namespace genus
