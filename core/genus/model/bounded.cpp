// require_bounded and tight_bounds: what a solid reaches, proven by interval bounds.

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/model/plan.h"
#include "genus/model/queries.h"

namespace genus {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- Towards infinity
//
// A point far out is p = d / w with d on the faces of the cube [-1, 1]^3 and 0 < w <= 1 / size.
// Times w^2 (w for a plane) a quadric becomes a form in (d, w) that is harmless at w = 0, so
// cells in d and w, closed at infinity, can be bounded as any others. Factors differ from surface
// to surface, but they are positive: signs go through the formula as they are.

/// Signs a surface or instruction may have: -1, 0 and 1 in order.
struct Signs {
    int low, high;
};

Signs signs_of(const Interval& x)
{
    return {x.lo > 0.0 ? 1 : x.lo == 0.0 ? 0 : -1, x.hi < 0.0 ? -1 : x.hi == 0.0 ? 0 : 1};
}

/// A patch of directions with a range of w.
struct FarCell {
    int axis;       // this coordinate of d is fixed
    double side;    // at 1 or -1
    Interval u, v;  // the two others, in cyclic order
    double w;       // 0 < w <= this
    int depth;

    IntervalVec3 direction() const
    {
        IntervalVec3 d;
        d[axis] = Interval(side);
        d[(axis + 1) % 3] = u;
        d[(axis + 2) % 3] = v;
        return d;
    }
    Vec3 middle() const
    {
        Vec3 d;
        for (int i = 0; i < 3; ++i) d[i] = direction()[i].mid();
        return d;
    }
};

/// factor * x; a bound that is zero stays zero, so that squares that vanish keep their sign.
Interval weighted(double factor, const Interval& x)
{
    if (factor == 0.0) return Interval(0.0);
    Interval product = factor == 1.0 ? x : Interval(factor) * x;
    if (factor > 0.0 ? x.lo >= 0.0 : x.hi <= 0.0) product.lo = std::max(product.lo, 0.0);
    if (factor > 0.0 ? x.hi <= 0.0 : x.lo >= 0.0) product.hi = std::min(product.hi, 0.0);
    return product;
}

/// a + b; sums of what is not negative are not negative.
Interval plus(const Interval& a, const Interval& b)
{
    if (a == Interval(0.0)) return b;
    if (b == Interval(0.0)) return a;
    Interval sum = a + b;
    if (a.lo >= 0.0 && b.lo >= 0.0) sum.lo = std::max(sum.lo, 0.0);
    if (a.hi <= 0.0 && b.hi <= 0.0) sum.hi = std::min(sum.hi, 0.0);
    return sum;
}

Signs signs_far_out(const Surface& surface, const FarCell& cell)
{
    if (surface.kind == Surface::Kind::Torus) return {1, 1};  // the start lies outside all tori
    if (surface.kind == Surface::Kind::Function) return {-1, 1};
    const std::array<double, 10> q = surface.quadric.upper_triangle();
    const IntervalVec3 d = cell.direction();
    const Interval slope = plus(plus(weighted(2.0 * q[3], d[0]), weighted(2.0 * q[6], d[1])),
                                weighted(2.0 * q[8], d[2]));
    const Interval w(0.0, cell.w);
    const Interval below = plus(slope, weighted(q[9], w));  // times w
    if (surface.kind == Surface::Kind::Plane) return signs_of(below);
    Interval leading = plus(plus(weighted(q[0], square(d[0])), weighted(q[4], square(d[1]))),
                            weighted(q[7], square(d[2])));
    leading = plus(leading, weighted(2.0 * q[1], d[0] * d[1]));
    leading = plus(leading, weighted(2.0 * q[2], d[0] * d[2]));
    leading = plus(leading, weighted(2.0 * q[5], d[1] * d[2]));
    // leading + w below with w > 0: where the leading part has one sign or none, the rest may
    // still decide.
    if (leading.lo >= 0.0 && below.lo > 0.0) return {1, 1};
    if (leading.hi <= 0.0 && below.hi < 0.0) return {-1, -1};
    return signs_of(plus(leading, w * below));
}

Signs signs_far_out(const CsgField& field, const FarCell& cell)
{
    std::vector<Signs> results;
    for (const CsgField::Instruction& op : field.instructions()) {
        Signs result = op.is_max ? Signs{-1, -1} : Signs{1, 1};
        for (const CsgField::Term& term : op.terms) {
            Signs s = term.is_surface ? signs_far_out(field.surfaces()[term.index], cell)
                                      : results[term.index];
            if (term.negated) s = {-s.high, -s.low};
            result = op.is_max ? Signs{std::max(result.low, s.low), std::max(result.high, s.high)}
                               : Signs{std::min(result.low, s.low), std::min(result.high, s.high)};
        }
        results.push_back(result);
    }
    return results.empty() ? Signs{1, 1} : results.back();
}

/// A direction in which the solid could not be shown to end within a cube of half size `size`, or
/// none if it was shown. A direction along which it is seen to go on is preferred.
std::optional<Vec3> way_out(const CsgField& field, double size)
{
    constexpr int kMostCells = 20000, kMostDepth = 24;
    std::vector<FarCell> open;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {1.0, -1.0})
            open.push_back({axis, side, {-1.0, 1.0}, {-1.0, 1.0}, 1.0 / size, 0});
    for (int cells = 0; !open.empty(); ++cells) {
        const FarCell cell = open.back();
        open.pop_back();
        if (signs_far_out(field, cell).low > 0) continue;
        const Vec3 d = cell.middle();
        const bool goes_on =
            field.value(1e3 * size * d) <= 0.0 && field.value(1e6 * size * d) <= 0.0;
        if (goes_on || cells >= kMostCells || cell.depth >= kMostDepth) return d;
        for (int quarter = 0; quarter < 4; ++quarter) {
            FarCell part = cell;
            const double u = cell.u.mid(), v = cell.v.mid();
            part.u = quarter & 1 ? Interval(u, cell.u.hi) : Interval(cell.u.lo, u);
            part.v = quarter & 2 ? Interval(v, cell.v.hi) : Interval(cell.v.lo, v);
            ++part.depth;
            open.push_back(part);
        }
    }
    return std::nullopt;
}

/// A size beyond everything the leaves have: radii, offsets, places.
double size_of_parts(const CsgField& field)
{
    double size = 1e-3;
    for (const Surface& surface : field.surfaces()) {
        if (surface.kind == Surface::Kind::Torus) {
            const Torus& torus = *surface.torus;
            for (const auto& row : torus.placement().m)
                size = std::max(size, std::fabs(row[3]) + (torus.R() + torus.r()) *
                                                              norm(Vec3{{row[0], row[1], row[2]}}));
            continue;
        }
        const std::array<double, 10> q = surface.quadric.local();
        double squares = 0.0;
        for (int i : {0, 1, 2, 4, 5, 7}) squares = std::max(squares, std::fabs(q[i]));
        const double slope = norm(Vec3{{q[3], q[6], q[8]}});
        size = std::max(size, norm(surface.quadric.origin()));
        if (squares > 0.0) {
            size = std::max({size, slope / squares, std::sqrt(std::fabs(q[9]) / squares)});
        } else if (slope > 0.0) {
            size = std::max(size, 0.5 * std::fabs(q[9]) / slope);
        }
    }
    return size;
}

/// The leaf to blame: among surfaces that let the ray in the direction `d` stay inside, one whose
/// leaf reaches to infinity there.
std::string leaf_without_end(const CsgField& field, double size, const Vec3& d)
{
    const CsgField::Active active = field.active(1e6 * size * d);
    return active.surface < 0 ? "a part" : field.surfaces()[active.surface].leaf;
}

std::string direction_text(const Vec3& d)
{
    Vec3 unit = normalized(d);
    for (double& c : unit.c) c = std::round(c * 1000.0) / 1000.0 + 0.0;
    return "[" + to_text(unit[0]) + ", " + to_text(unit[1]) + ", " + to_text(unit[2]) + "]";
}

// ---- Tight boxes

/// A cell still in question, `reach` being how far it goes in the direction asked for.
struct Candidate {
    double reach;
    int depth;
    Box3 box;
    CsgField::Pruned field;

    /// Of cells that reach as far the smallest is looked at first: a flat side of the solid is
    /// settled at one place, not all over.
    bool operator<(const Candidate& other) const
    {
        return reach != other.reach ? reach < other.reach : depth < other.depth;
    }
};

/// Where to cut a side: off the middle, so that cuts do not fall onto walls of the model, where
/// nothing can be decided.
double cut_of(double low, double high)
{
    return low + 0.4871 * (high - low);
}

/// How far the solid goes along `axis` (to higher values for side 1, to lower for -1), from above
/// to within `tolerance`; -infinity if it is empty.
class ReachSearch {
public:
    ReachSearch(const CsgField& field, int axis, int side) : field_(field), axis_(axis), side_(side)
    {
    }

    double run(const Box3& box, double tolerance)
    {
        constexpr int kMostCells = 20000;
        push(box, field_.prune(box), 0);
        for (int cells = 0; !open_.empty(); ++cells) {
            const Candidate cell = open_.top();
            if (cell.reach - seen_ <= tolerance || cells >= kMostCells) return cell.reach;
            open_.pop();
            if (cells % 256 == 0) current_progress().check();
            if (!shorten(cell) && !split_across(cell)) return cell.reach;
        }
        return seen_;
    }

private:
    double reach_of(const Box3& b) const { return side_ > 0 ? b.max[axis_] : -b.min[axis_]; }

    void push(const Box3& box, CsgField::Pruned&& field, int depth)
    {
        if (field.constant_sign <= 0) open_.push({reach_of(box), depth, box, std::move(field)});
    }

    /// Bisection along the axis, as far as it goes: the far part is empty, or it is the only one
    /// that matters because a point of the solid is seen where it begins.
    bool shorten(const Candidate& cell)
    {
        const double cut = cut_of(cell.box.min[axis_], cell.box.max[axis_]);
        if (!(cell.box.min[axis_] < cut && cut < cell.box.max[axis_])) return false;
        Box3 far = cell.box, near = cell.box;
        (side_ > 0 ? far.min : far.max)[axis_] = cut;
        (side_ > 0 ? near.max : near.min)[axis_] = cut;
        CsgField::Pruned beyond = field_.prune(cell.field, far);
        if (beyond.constant_sign > 0) {
            push(near, field_.prune(cell.field, near), cell.depth + 1);
            return true;
        }
        Vec3 p = cell.box.center();
        p[axis_] = cut;
        if (field_.value(cell.field, p) > 0.0) return false;
        seen_ = std::max(seen_, side_ * cut);
        push(far, std::move(beyond), cell.depth + 1);
        return true;
    }

    /// Halves the longer of the two other sides, or the axis itself where it is far longer.
    bool split_across(const Candidate& cell)
    {
        const Vec3 size = cell.box.size();
        int cut = (axis_ + 1) % 3;
        if (size[(axis_ + 2) % 3] > size[cut]) cut = (axis_ + 2) % 3;
        if (size[axis_] > 2.0 * size[cut]) cut = axis_;
        const double at = cut_of(cell.box.min[cut], cell.box.max[cut]);
        if (!(cell.box.min[cut] < at && at < cell.box.max[cut])) return false;
        for (const bool upper : {false, true}) {
            Box3 half = cell.box;
            (upper ? half.min : half.max)[cut] = at;
            push(half, field_.prune(cell.field, half), cell.depth + 1);
        }
        return true;
    }

    const CsgField& field_;
    int axis_, side_;
    double seen_ = -kInfinity;
    std::priority_queue<Candidate> open_;
};

}  // namespace

Box3 require_bounded(const Solid& solid)
{
    if (solid.bounds().bounded()) return solid.bounds();
    const Solid planned = plan(solid).solid;
    if (planned.bounds().bounded()) return planned.bounds();
    const CsgField field(planned);
    const double size = size_of_parts(field);
    std::optional<Vec3> out;
    for (const double factor : {2.0, 64.0, 1e4, 1e8}) {
        out = way_out(field, factor * size);
        if (out) continue;
        const double reach = factor * size;
        const Box3 cube{{{-reach, -reach, -reach}}, {{reach, reach, reach}}};
        return intersection(cube, planned.bounds());
    }
    throw UnboundedSolid("the solid reaches to infinity along " + direction_text(*out) + ": " +
                         leaf_without_end(field, size, *out));
}

Box3 tight_bounds(const Solid& solid, double tolerance)
{
    require(tolerance > 0.0, "bounds: tolerance", tolerance, "positive");
    const Solid planned = plan(solid).solid;
    Box3 box = require_bounded(planned);
    if (box.empty()) return {};
    const CsgField field(planned);
    for (int axis = 0; axis < 3; ++axis) {
        box.max[axis] = std::min(box.max[axis], ReachSearch(field, axis, 1).run(box, tolerance));
        if (box.empty()) return {};
        box.min[axis] = std::max(box.min[axis], -ReachSearch(field, axis, -1).run(box, tolerance));
        if (box.empty()) return {};
    }
    return box;
}

}  // namespace genus
