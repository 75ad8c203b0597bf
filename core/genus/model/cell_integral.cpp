#include "genus/model/cell_integral.h"

#include <algorithm>
#include <cmath>

#include "genus/implicit/double_double.h"

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnit = std::numeric_limits<double>::epsilon();
constexpr std::size_t kMostPoints = 20;
// Radii of discs on which integrands are looked at; the wider the fewer points a rule needs.
constexpr std::array<double, 8> kRadii{1025.0, 65.0, 17.0, 9.0, 5.0, 3.0, 2.0, 1.5};
// Errors of all sums and of nodes and weights, as a share of what is summed.
constexpr double kRounding = 512.0 * kUnit;

// ---- Gauss rules

struct GaussRule {
    std::vector<double> nodes, weights;
};

/// P_n and P_n' at x.
std::array<DoubleDouble, 2> legendre(std::size_t n, const DoubleDouble& x)
{
    DoubleDouble before(1.0), p = x;
    for (std::size_t k = 2; k <= n; ++k) {
        const double d = static_cast<double>(k);
        const DoubleDouble next =
            (DoubleDouble(2.0 * d - 1.0) * x * p - DoubleDouble(d - 1.0) * before) /
            DoubleDouble(d);
        before = p;
        p = next;
    }
    const DoubleDouble slope =
        DoubleDouble(static_cast<double>(n)) * (x * p - before) / (x * x - DoubleDouble(1.0));
    return {p, slope};
}

GaussRule make_rule(std::size_t n)
{
    if (n == 1) return {{0.0}, {2.0}};
    GaussRule rule;
    for (std::size_t i = n; i-- > 0;) {
        const double angle = 3.14159265358979323846 * (static_cast<double>(i) + 0.75) /
                             (static_cast<double>(n) + 0.5);
        DoubleDouble x(std::cos(angle));
        for (int step = 0; step < 6; ++step) {
            const auto [p, slope] = legendre(n, x);
            x = x - p / slope;
        }
        const DoubleDouble slope = legendre(n, x)[1];
        const DoubleDouble weight =
            DoubleDouble(2.0) / ((DoubleDouble(1.0) - x * x) * slope * slope);
        rule.nodes.push_back(x.rounded());
        rule.weights.push_back(weight.rounded());
    }
    return rule;
}

const GaussRule& gauss_rule(std::size_t n)
{
    static const std::vector<GaussRule> rules = [] {
        std::vector<GaussRule> all(1);
        for (std::size_t k = 1; k <= kMostPoints; ++k) all.push_back(make_rule(k));
        return all;
    }();
    return rules[n];
}

/// How many points, and what they leave at most.
struct Choice {
    std::size_t points;
    double error;
};

/// For an integral over a piece of half width `half`, of a function that is analytic and at most
/// `most` in absolute value up to a distance `reach` from the piece: the ellipse with this as its
/// short half axis reaches no farther. Chebyshev's series cut off at degree 2n - 1 errs by
/// 2 most rho^(1 - 2n) / (rho - 1), the exact integral and the rule by twice that each.
std::optional<Choice> choose_points(double half, double reach, double most, double wanted)
{
    const double ratio = std::min(reach / half, 1e8);
    const double rho = ratio + std::sqrt(1.0 + ratio * ratio);
    double error = half * 8.0 * most * rho / (rho - 1.0);
    for (std::size_t n = 1; n <= kMostPoints; ++n) {
        error /= rho * rho;
        if (error <= wanted) return Choice{n, error};
    }
    return std::nullopt;
}

// ---- The structure of a cell

/// Where two graphs meet, or one of them meets the bottom or top of the cell: the zero set of
/// D = d0 + A x + B y + (at most r), as a graph y = c(x).
struct Curve {
    static constexpr int kBottom = -1, kTop = -2;
    int i, j;
    double d0, A, B, r;
    double least_x, least_y;  // of |dD/dx|, |dD/dy| over the cell; at most 0 if not known
    Interval slope;           // of c
};

struct Place {
    double at = 0.0;
    double error = 0.0;
};

Interval linear_range(double at_zero, double slope, double lo, double hi)
{
    return Interval(at_zero) + Interval(slope) * Interval(lo, hi);
}

class CellIntegrator {
public:
    CellIntegrator(const CellSolid& solid, const std::vector<LocalForm>& forms, Quantity quantity,
                   const std::array<Vec3, 3>& columns, double wanted)
        : solid_(solid), forms_(forms), quantity_(quantity), columns_(columns), wanted_(wanted)
    {
    }

    /// Sets up the graphs over x and y. False if z will not do.
    bool find_graphs()
    {
        for (const LocalForm& form : forms_) {
            const auto z0 = zero_on_axis(form);
            if (!z0) return false;
            const auto graph = graph_over(form, *z0, 1.0);
            if (!graph) return false;
            // No other zero above a point of the base between the graph and the cell.
            const double rise = std::fabs(graph->a) + std::fabs(graph->b) + graph->r;
            Box3 column{Box3::filled(-1.0), Box3::filled(1.0)};
            column.min[2] = std::min(-1.0, *z0 - rise);
            column.max[2] = std::max(1.0, *z0 + rise);
            if (form.slope_range(2, column).contains(0.0)) return false;
            graphs_.push_back(*graph);
            slack_reach_ = std::max(slack_reach_, std::fabs(*z0) + rise);
        }
        for (const LocalForm& form : forms_) slack_.push_back(form.slack(slack_reach_));
        return true;
    }

    std::optional<CellIntegral> run()
    {
        if (!find_curves() || !find_breaks() || !find_reach()) return std::nullopt;
        for (std::size_t k = 0; k + 1 < breaks_.size(); ++k)
            if (!add_piece(breaks_[k], breaks_[k + 1])) return std::nullopt;
        result_.error += kRounding * summed_;
        return result_;
    }

private:
    static constexpr double kTiny = 64.0 * kUnit, kCoincident = 1e-12;

    struct Zero {
        double at;
        double value;  // what F is there, computed
    };

    // By Newton's method, as long as that lessens the value.
    static Zero zero_along(const AxisLine& line, double from)
    {
        Zero zero{from, line.value(from)};
        for (int step = 0; step < 8; ++step) {
            const double next = zero.at - zero.value / line.slope(zero.at);
            const double value = line.value(next);
            const bool better = std::fabs(value) < std::fabs(zero.value);
            const bool settled = std::fabs(next - zero.at) <= 2.0 * kUnit * (1.0 + std::fabs(next));
            if (better) zero = {next, value};
            if (!better || settled) break;
        }
        return zero;
    }

    // How far graph i may be from a place along z at which F was found to be so much.
    double height_error(int i, double value, double reach) const
    {
        const double slack = reach <= slack_reach_ ? slack_[i] : forms_[i].slack(reach);
        return (std::fabs(value) + slack) / graphs_[i].least_slope + 4.0 * kUnit * reach;
    }

    // The height of graph i at (x, y), or of the bottom or top of the cell.
    Place height(int i, double x, double y) const
    {
        if (i < 0) return {i == Curve::kBottom ? -1.0 : 1.0, 0.0};
        const Graph& graph = graphs_[i];
        const auto [z, value] =
            zero_along(forms_[i].along(2, {{x, y, 0.0}}), graph.z0 + graph.a * x + graph.b * y);
        const double reach = std::max({1.0, std::fabs(x), std::fabs(y), std::fabs(z)});
        return {z, height_error(i, value, reach)};
    }

    Place difference(const Curve& c, double x, double y) const
    {
        const Place a = height(c.i, x, y), b = height(c.j, x, y);
        return {a.at - b.at, a.error + b.error};
    }

    // Of graph i along y, roughly.
    double rise_along_y(int i, double x, double y) const
    {
        const Vec3 g = forms_[i].gradient({{x, y, height(i, x, y).at}});
        return -g[1] / g[2];
    }

    // c(x), where the curve is in the cell or near.
    Place on_curve(const Curve& c, double x) const
    {
        const double from = -(c.d0 + c.A * x) / c.B;
        return c.j < 0 ? on_trace(c, x, from) : on_crossing(c, x, from);
    }

    // Where a graph meets the bottom or the top: a zero of F along y.
    Place on_trace(const Curve& c, double x, double from) const
    {
        const double z = c.j == Curve::kBottom ? -1.0 : 1.0;
        const auto [y, value] = zero_along(forms_[c.i].along(1, {{x, 0.0, z}}), from);
        const double reach = std::max({1.0, std::fabs(x), std::fabs(y)});
        return {y, height_error(c.i, value, reach) / c.least_y + 2.0 * kUnit};
    }

    Place on_crossing(const Curve& c, double x, double from) const
    {
        double y = from;
        Place d = difference(c, x, y);
        for (int step = 0; step < 8; ++step) {
            const double slope = rise_along_y(c.i, x, y) - rise_along_y(c.j, x, y);
            const double next = y - d.at / slope;
            const Place at_next = difference(c, x, next);
            const bool better = std::fabs(at_next.at) < std::fabs(d.at);
            const bool settled = std::fabs(next - y) <= 2.0 * kUnit;
            if (better) y = next, d = at_next;
            if (!better || settled) break;
        }
        return {y, (std::fabs(d.at) + d.error) / c.least_y + 2.0 * kUnit};
    }

    bool find_curves()
    {
        const int n = static_cast<int>(graphs_.size());
        for (int i = 0; i < n; ++i) {
            if (!add_curve(i, Curve::kBottom) || !add_curve(i, Curve::kTop)) return false;
            for (int j = 0; j < i; ++j)
                if (!add_curve(i, j)) return false;
        }
        return true;
    }

    // False if the curve may be none over the cell.
    bool add_curve(int i, int j)
    {
        Graph flat;
        flat.z0 = j == Curve::kBottom ? -1.0 : 1.0;
        const Graph &g = graphs_[i], &h = j < 0 ? flat : graphs_[j];
        Curve c{i, j, g.z0 - h.z0, g.a - h.a, g.b - h.b, g.r + h.r, 0.0, 0.0, {}};
        const Interval unit(-1.0, 1.0);
        const Interval range =
            Interval(c.d0) + Interval(c.A) * unit + Interval(c.B) * unit + Interval(c.r) * unit;
        if (!range.contains(0.0)) return true;
        const double rounding = 4.0 * kUnit * (std::fabs(c.A) + std::fabs(c.B));
        const double ex = g.rise_x + h.rise_x + rounding, ey = g.rise_y + h.rise_y + rounding;
        c.least_x = std::fabs(c.A) - ex;
        c.least_y = std::fabs(c.B) - ey;
        if (!(c.least_y > 0.05 * std::fabs(c.B))) return false;
        c.slope = -(Interval(c.A - ex, c.A + ex) / Interval(c.B - ey, c.B + ey));
        curves_.push_back(c);
        return true;
    }

    // Finds the one sign change in [lo, hi] of a function that is monotone there with slopes of at
    // least `slope` in absolute value, if there is one.
    template <class F>
    void add_break(const F& f, double lo, double hi, double slope)
    {
        Place a = f(lo), b = f(hi);
        const auto note = [&](double x, const Place& value) {
            const double error = (std::fabs(value.at) + value.error) / slope + 2.0 * kUnit;
            cuts_.push_back({x, error});
        };
        if (std::fabs(a.at) <= a.error) return note(lo, a);
        if (std::fabs(b.at) <= b.error) return note(hi, b);
        if ((a.at < 0.0) == (b.at < 0.0)) return;
        // Regula falsi with the Illinois rule.
        double fa = a.at, fb = b.at;
        int side = 0;
        for (int step = 0; step < 100; ++step) {
            double x = (lo * fb - hi * fa) / (fb - fa);
            if (!(lo < x && x < hi)) x = 0.5 * (lo + hi);
            const Place value = f(x);
            if (std::fabs(value.at) <= value.error || hi - lo <= 4.0 * kUnit) return note(x, value);
            if ((value.at < 0.0) == (fa < 0.0)) {
                lo = x, fa = value.at;
                if (side == -1) fb *= 0.5;
                side = -1;
            } else {
                hi = x, fb = value.at;
                if (side == 1) fa *= 0.5;
                side = 1;
            }
        }
        note(0.5 * (lo + hi), f(0.5 * (lo + hi)));
    }

    // The x at which a curve enters or leaves the cell, or two curves cross.
    bool find_breaks()
    {
        breaks_ = {-1.0, 1.0};
        for (const Curve& c : curves_)
            for (const double y : {-1.0, 1.0}) {
                const Interval range = linear_range(c.d0 + c.B * y, c.A, -1.0, 1.0) +
                                       Interval(-c.r - kTiny, c.r + kTiny);
                if (!range.contains(0.0)) continue;
                if (!(c.least_x > 0.0)) return false;
                add_break([&](double x) { return difference(c, x, y); }, -1.0, 1.0, c.least_x);
            }
        settle_breaks();
        const std::vector<double> pieces = breaks_;
        for (std::size_t k = 0; k + 1 < pieces.size(); ++k)
            if (!cross_curves(pieces[k], pieces[k + 1])) return false;
        settle_breaks();
        return true;
    }

    bool cross_curves(double lo, double hi)
    {
        const std::vector<const Curve*> here = curves_between(lo, hi);
        for (std::size_t k = 0; k < here.size(); ++k)
            for (std::size_t l = 0; l < k; ++l) {
                const Curve &c = *here[k], &d = *here[l];
                const double spread = c.r / c.least_y + d.r / d.least_y;
                const Interval apart =
                    linear_range(d.d0 / d.B - c.d0 / c.B, d.A / d.B - c.A / c.B, lo, hi) +
                    Interval(-spread - kTiny, spread + kTiny);
                if (!apart.contains(0.0)) continue;
                if (apart.magnitude() <= kCoincident) {
                    // Planes through one line: about the strip between them nothing is known.
                    uncertain_strips_ += apart.magnitude() * (hi - lo);
                    continue;
                }
                const Interval turn = c.slope - d.slope;
                if (turn.contains(0.0)) return false;
                const double slope = std::min(std::fabs(turn.lo), std::fabs(turn.hi));
                add_break(
                    [&](double x) {
                        const Place a = on_curve(c, x), b = on_curve(d, x);
                        return Place{a.at - b.at, a.error + b.error};
                    },
                    lo, hi, slope);
            }
        return true;
    }

    // The curves that are in the cell between two breaks.
    std::vector<const Curve*> curves_between(double lo, double hi) const
    {
        const double x = 0.5 * (lo + hi);
        std::vector<const Curve*> here;
        for (const Curve& c : curves_)
            if ((difference(c, x, -1.0).at < 0.0) != (difference(c, x, 1.0).at < 0.0))
                here.push_back(&c);
        return here;
    }

    // Sorts the cuts found into the breaks. Between x - error and x + error nothing is known.
    void settle_breaks()
    {
        for (const Place& cut : cuts_) {
            breaks_.push_back(std::clamp(cut.at, -1.0, 1.0));
            uncertain_ += 2.0 * cut.error;
        }
        cuts_.clear();
        std::sort(breaks_.begin(), breaks_.end());
        breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
    }

    // The discs on which to look at the integrand, and how large it gets there.
    bool find_reach()
    {
        for (const double R : kRadii) {
            double most = 0.0;
            std::vector<Graph> wide;
            for (std::size_t i = 0; i < forms_.size(); ++i) {
                const auto graph = graph_over(forms_[i], graphs_[i].z0, R);
                if (!graph) break;
                const auto weight = largest_weight(forms_[i], *graph, R);
                if (!weight) break;
                most += *weight;
                wide.push_back(*graph);
            }
            if (wide.size() < forms_.size()) continue;
            most_here_ = std::min(most_here_, most);
            // From a place where it is in the cell, a curve gets no farther than R on the way.
            double reach = R - 1.0;
            for (const Curve& c : curves_) {
                double ex = wide[c.i].rise_x, ey = wide[c.i].rise_y;
                if (c.j >= 0) ex += wide[c.j].rise_x, ey += wide[c.j].rise_y;
                const double least = std::fabs(c.B) - ey;
                reach = least > 0.05 * std::fabs(c.B)
                            ? std::min(reach, (R - 1.0) * least / (std::fabs(c.A) + ex))
                            : 0.0;
            }
            if (!(reach > reach_)) continue;
            reach_ = reach;
            radius_ = R;
            most_ = most;
        }
        if (!(reach_ > 0.0)) return false;
        result_.error += (uncertain_ * 2.0 + uncertain_strips_) * most_here_;
        return true;
    }

    // Bound of what one graph adds to the integrand on the polydisc.
    std::optional<double> largest_weight(const LocalForm& form, const Graph& graph, double R) const
    {
        if (quantity_ == Quantity::Volume) {
            const double height =
                std::fabs(graph.z0) + (std::fabs(graph.a) + std::fabs(graph.b)) * R + graph.r;
            return 4.0 * std::max(1.0, height);
        }
        const Vec3 g = form.gradient({{0, 0, graph.z0}});
        const Vec3 spread = gradient_variation(form, graph, R);
        double middle = 0.0, rest = 0.0, most = 0.0;
        for (int row = 0; row < 3; ++row) {
            double m = 0.0, e = 0.0;
            for (int k = 0; k < 3; ++k) {
                m += columns_[k][row] * g[k];
                e += std::fabs(columns_[k][row]) * spread[k];
            }
            middle += m * m;
            rest += 2.0 * std::fabs(m) * e + e * e;
            most += (std::fabs(m) + e) * (std::fabs(m) + e);
        }
        // The root of the sum of squares is analytic while that keeps off zero.
        if (!(rest < 0.9 * middle)) return std::nullopt;
        return std::sqrt(most) / graph.least_slope;
    }

    bool add_piece(double lo, double hi)
    {
        const double half = 0.5 * (hi - lo);
        if (half <= kTiny) {
            result_.error += 4.0 * half * most_here_;
            return true;
        }
        std::vector<const Curve*> here = curves_between(lo, hi);
        const double middle = 0.5 * (lo + hi);
        std::sort(here.begin(), here.end(), [&](const Curve* c, const Curve* d) {
            return on_curve(*c, middle).at < on_curve(*d, middle).at;
        });
        const double n_strips = static_cast<double>(here.size() + 1);
        const double share = half / static_cast<double>(breaks_.size());
        const auto choice =
            choose_points(half, reach_, n_strips * 2.0 * radius_ * most_, wanted_ * share);
        if (!choice) return false;
        result_.error += choice->error;
        const GaussRule& rule = gauss_rule(choice->points);
        for (std::size_t p = 0; p < rule.nodes.size(); ++p) {
            const double x = middle + half * rule.nodes[p], weight = half * rule.weights[p];
            double below = -1.0;
            for (std::size_t k = 0; k <= here.size(); ++k) {
                Place top{1.0, 0.0};
                if (k < here.size()) top = on_curve(*here[k], x);
                const double y = std::clamp(top.at, below, 1.0);
                result_.error += weight * 2.0 * top.error * most_here_;
                if (!add_strip(x, below, y, weight, wanted_ * share / n_strips)) return false;
                below = y;
            }
        }
        return true;
    }

    bool add_strip(double x, double lo, double hi, double weight, double wanted)
    {
        const double half = 0.5 * (hi - lo);
        if (half <= kTiny) {
            result_.error += weight * 2.0 * half * most_here_;
            return true;
        }
        const auto choice = choose_points(half, radius_ - 1.0, most_, wanted);
        if (!choice) return false;
        result_.error += weight * choice->error;
        const GaussRule& rule = gauss_rule(choice->points);
        for (std::size_t p = 0; p < rule.nodes.size(); ++p)
            add_point(x, 0.5 * (lo + hi) + half * rule.nodes[p], weight * half * rule.weights[p]);
        return true;
    }

    void add_point(double x, double y, double weight)
    {
        struct Hit {
            Place z;
            int i;
        };
        std::array<Hit, CellSolid::kMostSurfaces> hits;
        const std::size_t n = forms_.size();
        std::uint32_t side = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const Hit hit{height(static_cast<int>(i), x, y), static_cast<int>(i)};
            std::size_t k = i;
            for (; k > 0 && hit.z.at < hits[k - 1].z.at; --k) hits[k] = hits[k - 1];
            hits[k] = hit;
            if (graphs_[i].slope < 0.0) side |= 1U << i;  // below the graph F > 0
        }
        double sum = 0.0, error = 0.0, last = -1.0;
        Place before{-kInfinity, 0.0};
        for (std::size_t k = 0; k < n; ++k) {
            const Place& z = hits[k].z;
            const bool was_inside = solid_.inside >> side & 1;
            side ^= 1U << hits[k].i;
            const bool is_inside = solid_.inside >> side & 1;
            if (quantity_ == Quantity::Volume) {
                const double at = std::clamp(z.at, -1.0, 1.0);
                if (was_inside) sum += at - last;
                last = at;
                error += 2.0 * z.error;
                continue;
            }
            const bool off = std::fabs(z.at) > 1.0 + z.error;
            const bool doubtful = !off && (z.at - before.at <= z.error + before.error ||
                                           std::fabs(z.at) >= 1.0 - z.error);
            before = z;
            const bool counts = was_inside != is_inside && z.at > -1.0 && z.at < 1.0;
            if (!doubtful && !counts) continue;
            const Place piece = area_weight(hits[k].i, {{x, y, z.at}}, z.error);
            if (counts) sum += piece.at;
            error += doubtful ? 2.0 * piece.at + piece.error : piece.error;
        }
        if (quantity_ == Quantity::Volume && (solid_.inside >> side & 1)) sum += 1.0 - last;
        result_.value += weight * sum;
        result_.error += weight * error;
        summed_ += weight * sum;
    }

    Place area_weight(int i, const Vec3& e, double off) const
    {
        const LocalForm& form = forms_[i];
        const Vec3 g = form.gradient(e);
        const Vec3 normal = g[0] * columns_[0] + g[1] * columns_[1] + g[2] * columns_[2];
        const double length = norm(normal), slope = std::fabs(g[2]);
        const double reach = std::max(1.0, std::fabs(e[2]) + off);
        const double slack = form.gradient_slack(reach) + form.bend(reach) * off;
        double spread = 0.0;
        for (const Vec3& column : columns_) spread += norm(column) * slack;
        const double relative = spread / length + slack / slope + 32.0 * kUnit;
        return {length / slope, 1.5 * relative * length / slope};
    }

    const CellSolid& solid_;
    const std::vector<LocalForm>& forms_;
    Quantity quantity_;
    const std::array<Vec3, 3>& columns_;
    double wanted_;
    std::vector<Graph> graphs_;
    double slack_reach_ = 1.0;   // how far from the middle points of the graphs are
    std::vector<double> slack_;  // of each form up to there
    std::vector<Curve> curves_;
    std::vector<double> breaks_;
    std::vector<Place> cuts_;
    double uncertain_ = 0.0;         // length of x about which nothing is known
    double uncertain_strips_ = 0.0;  // area of x and y besides
    double radius_ = 0.0, reach_ = 0.0, most_ = 0.0;
    double most_here_ = kInfinity;  // over the cell itself
    double summed_ = 0.0;
    CellIntegral result_;
};

}  // namespace

std::optional<CellIntegral> integrate_cell(const CellSolid& solid, Quantity quantity,
                                           const std::array<Vec3, 3>& columns, double error)
{
    const Box3 cell{Box3::filled(-1.0), Box3::filled(1.0)};
    for (int z = 0; z < 3; ++z) {
        const bool graphs = std::all_of(
            solid.forms.begin(), solid.forms.end(),
            [&](const LocalForm& form) { return !form.slope_range(z, cell).contains(0.0); });
        if (!graphs) continue;
        for (const int turn : {1, 2}) {
            const std::array<int, 3> order{(z + turn) % 3, (z + 3 - turn) % 3, z};
            std::vector<LocalForm> forms;
            for (const LocalForm& form : solid.forms) forms.push_back(form.permuted(order));
            const std::array<Vec3, 3> turned{columns[order[0]], columns[order[1]],
                                             columns[order[2]]};
            CellIntegrator integrator(solid, forms, quantity, turned, error);
            if (!integrator.find_graphs()) break;
            if (auto result = integrator.run()) return result;
        }
    }
    return std::nullopt;
}

}  // namespace genus
