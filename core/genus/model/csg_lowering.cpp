#include "genus/model/csg_lowering.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/implicit/half_space_of.h"
#include "genus/implicit/quadric_form.h"
#include "genus/implicit/solid_parts.h"
#include "genus/model/convex.h"
#include "genus/model/leaf_mesh.h"

namespace genus {
namespace {

using Term = CsgField::Term;
using Instruction = CsgField::Instruction;

constexpr std::size_t kMostLeaves = 10'000'000;
constexpr double kEps = std::numeric_limits<double>::epsilon();

// ---- Leaves as surfaces

/// The power of two that brings `length` to between 0.7 and 1.5; 1 for zero.
double power_of_two_scale(double length)
{
    if (!(length > 0.0) || !std::isfinite(length)) return 1.0;
    int exponent = 0;
    const double mantissa = std::frexp(length, &exponent);  // in [0.5, 1)
    return std::ldexp(1.0, std::clamp(mantissa < 0.75 ? 1 - exponent : -exponent, -1000, 1000));
}

/// How long gradients get where no box says where the surface is: from its size about its own
/// origin, |gradient| ~ 2 sqrt(|J| greatest square) for a surface around it.
double typical_gradient(const Quadric& quadric)
{
    const std::array<double, 10>& q = quadric.local();
    double squares = 0.0;
    for (int i : {0, 1, 2, 4, 5, 7}) squares = std::max(squares, std::fabs(q[i]));
    const double slope = 2.0 * norm(Vec3{{q[3], q[6], q[8]}});
    const double size = 2.0 * std::sqrt(std::fabs(q[9])) * std::sqrt(squares);
    const double length = std::max(slope, size);
    return length > 0.0 ? length : squares;
}

/// Collects the surfaces of one leaf.
class LeafWriter {
public:
    LeafWriter(const Shape& shape, const Transform& map) : map_(map), leaf_(describe(shape)) {}

    void plane(const Vec3& normal, double offset)
    {
        const Quadric q = transformed(Quadric::half_space(normal, offset), map_);
        const double scale = power_of_two_scale(norm(q.gradient({})));
        surfaces.push_back({Surface::Kind::Plane, q.scaled(scale), std::nullopt, 1.0, leaf_});
    }

    /// `box` is where the leaf is, in its own coordinates.
    void quadric(const Quadric& own, const std::optional<Box3>& box)
    {
        const Quadric q = transformed(own, map_);
        double longest = 0.0;
        for (int corner = 0; box && corner < 8; ++corner)
            longest = std::max(longest, norm(q.gradient(apply(map_, box->corner(corner)))));
        if (!box) longest = typical_gradient(q);
        const auto kind = q.is_linear() ? Surface::Kind::Plane : Surface::Kind::Quadric;
        surfaces.push_back({kind, q.scaled(power_of_two_scale(longest)), std::nullopt, 1.0, leaf_});
    }

    void torus(double R, double r)
    {
        const Torus torus(R, r, map_);
        double longest = 0.0;
        for (int i = 0; i < 8; ++i)
            longest = std::max(longest, norm(torus.gradient(torus.point(0.785398163 * i, 0.0))));
        surfaces.push_back(
            {Surface::Kind::Torus, Quadric({}), torus, power_of_two_scale(longest), leaf_});
    }

    /// In the coordinates of the caller, and scaled, as new instructions.
    void function(const Expression& own, const Box3& box)
    {
        const Transform back = inverse(map_);
        std::array<Expression, 3> local;
        const std::array<Expression, 3> at{Expression::x(), Expression::y(), Expression::z()};
        for (std::size_t i = 0; i < 3; ++i) {
            local[i] = back.m[i][3];
            for (std::size_t j = 0; j < 3; ++j) {
                if (back.m[i][j] == 0.0) continue;
                const Expression term = back.m[i][j] * at[j];
                local[i] = back.m[i][3] == 0.0 && local[i].number() ? term : local[i] + term;
            }
        }
        const Expression moved = substituted(own, local);
        const Function unscaled(moved);
        Box3 placed;
        for (std::size_t corner = 0; corner < 8; ++corner)
            placed.add(apply(map_, box.corner(corner)));
        const double scale = power_of_two_scale(middle_slope(unscaled, placed));
        surfaces.push_back({Surface::Kind::Function, Quadric({}), std::nullopt, 1.0, leaf_,
                            std::make_shared<const Function>(Expression(scale) * moved), placed});
    }

    void box_sides(const Box3& box)
    {
        for (int i = 0; i < 3; ++i) {
            Vec3 n;
            n[i] = 1.0;
            plane(n, box.max[i]);
            plane(-n, -box.min[i]);
        }
    }

    std::vector<Surface> surfaces;

private:
    /// The median length of gradients next to the surface.
    static double middle_slope(const Function& function, const Box3& box)
    {
        constexpr int kSteps = 8;
        std::vector<std::pair<double, double>> found;  // distance to first order, length
        for (int n = 0; n < kSteps * kSteps * kSteps; ++n) {
            Vec3 p;
            const std::array<int, 3> at{n % kSteps, n / kSteps % kSteps, n / (kSteps * kSteps)};
            for (std::size_t i = 0; i < 3; ++i)
                p[i] = box.min[i] + (at[i] + 0.5) / kSteps * (box.max[i] - box.min[i]);
            const double length = norm(function.gradient(p));
            const double away = std::fabs(function.value(p)) / length;
            if (length > 0.0 && std::isfinite(length) && std::isfinite(away))
                found.emplace_back(away, length);
        }
        if (found.empty()) return 1.0;
        std::sort(found.begin(), found.end());
        found.resize((found.size() + 7) / 8);
        std::sort(found.begin(), found.end(),
                  [](const auto& a, const auto& b) { return a.second < b.second; });
        return found[found.size() / 2].second;
    }

    const Transform& map_;
    std::string leaf_;
};

void write(LeafWriter& out, const Cylinder& s)
{
    const double low = s.center ? -0.5 * s.h : 0.0, high = low + s.h;
    const double r = std::max(s.r1, s.r2);
    Box3 box{{{-r, -r, low}}, {{r, r, high}}};
    if (s.r1 == s.r2) {
        out.quadric(Quadric::cylinder(r), box);
    } else {
        // About the narrow end, so that the apex never gets between the two planes by rounding:
        // it stays at z = -r0 / slope or, for a cone, exactly where the plane is.
        const double slope = (s.r2 - s.r1) / s.h;
        const Quadric cone = Quadric::cone(std::min(s.r1, s.r2), slope);
        const double narrow = s.r1 < s.r2 ? low : high;
        out.quadric(Quadric(cone.local(), {{0.0, 0.0, narrow}}), box);
    }
    out.plane({{0, 0, 1}}, high);
    out.plane({{0, 0, -1}}, -low);
}

void write_planes(LeafWriter& out, const std::vector<FacePlane>& planes)
{
    require(!planes.empty(), "every face is degenerate");
    for (const FacePlane& plane : planes) out.plane(plane.normal, plane.offset);
}

void write_leaf(LeafWriter& out, const Shape& shape)
{
    if (const auto* s = std::get_if<Cube>(&shape)) {
        const Vec3 low = s->center ? -0.5 * s->size : Vec3{};
        out.box_sides({low, low + s->size});
    } else if (const auto* p = std::get_if<Polyhedron>(&shape)) {
        write_planes(out, convex_face_planes(*p->mesh, describe(shape)));
    } else if (is_faceted(shape)) {
        write_planes(out, face_planes(facet_mesh(shape)));
    } else if (const auto* ball = std::get_if<Sphere>(&shape)) {
        out.quadric(Quadric::sphere(ball->r), std::nullopt);
    } else if (const auto* egg = std::get_if<Ellipsoid>(&shape)) {
        out.quadric(Quadric::ellipsoid(egg->radii), std::nullopt);
    } else if (const auto* round = std::get_if<Cylinder>(&shape)) {
        write(out, *round);
    } else if (const auto* ring = std::get_if<TorusShape>(&shape)) {
        out.torus(ring->R, ring->r);
    } else if (const auto* half = std::get_if<HalfSpace>(&shape)) {
        out.plane(half->normal, half->offset);
    } else if (const auto* any = std::get_if<QuadricShape>(&shape)) {
        out.quadric(any->surface, any->bounds);
        if (any->bounds) out.box_sides(*any->bounds);
    } else if (const auto* any_function = std::get_if<ImplicitShape>(&shape)) {
        // The rest is not all of them or any of them: TreeWriter::function.
        out.box_sides(any_function->bounds);
    } else if (std::holds_alternative<Freeform>(shape)) {
        throw InvalidInput("there is no formula for it, only a mesh");
    }
}

// ---- Equal surfaces

/// Largest absolute value among the entries `places` of q.
double largest(const std::array<double, 10>& q, std::initializer_list<int> places)
{
    double most = 0.0;
    for (int i : places) most = std::max(most, std::fabs(q[i]));
    return most;
}

/// How q relates to `to`: the factor between them, or 0 if they are not multiples of each other
/// up to rounding of coordinates of size `reach`.
double factor_between(const std::array<double, 10>& to, const std::array<double, 10>& q,
                      double reach)
{
    // Compare at the greatest entry of the leading part: squares, or the normal of a plane.
    const bool linear = largest(to, {0, 1, 2, 4, 5, 7}) == 0.0;
    if (linear != (largest(q, {0, 1, 2, 4, 5, 7}) == 0.0)) return 0.0;
    std::size_t at = 0;
    double most = 0.0;
    for (std::size_t i = 0; i < 9; ++i) {
        const bool leading = linear || (i != 3 && i != 6 && i != 8);
        if (leading && std::fabs(to[i]) > most) most = std::fabs(to[at = i]);
    }
    if (most == 0.0) return 0.0;
    const double factor = q[at] / to[at];
    if (factor == 0.0 || !std::isfinite(factor)) return 0.0;
    const double size =
        std::max(linear ? std::fabs(to[9]) / most : std::sqrt(std::fabs(to[9]) / most), reach);
    for (std::size_t i = 0; i < 10; ++i) {
        const bool slope = i == 3 || i == 6 || i == 8;
        // A square counts by itself, a slope times the size, the constant by its square.
        double weight = i == 9 ? size * size : slope ? size : 1.0;
        if (linear) weight = i == 9 ? size : 1.0;
        if (std::fabs(q[i] / factor - to[i]) > 8.0 * kEps * most * weight) return 0.0;
    }
    return factor;
}

/// Finds surfaces that bound the same set, by a number that equal surfaces nearly share.
class SurfaceIndex {
public:
    explicit SurfaceIndex(std::vector<Surface>& surfaces) : surfaces_(surfaces) {}

    /// The number of `surface` among those kept, and whether it is that one's negative.
    std::pair<std::int32_t, bool> add(Surface surface, double reach)
    {
        const double key = key_of(surface), width = 1e-9 * (1.0 + std::fabs(key));
        for (auto it = by_key_.lower_bound(key - width);
             it != by_key_.end() && it->first <= key + width; ++it) {
            const double factor = compare(surfaces_[it->second], surface, reach);
            if (factor != 0.0) return {it->second, factor < 0.0};
        }
        const auto number = static_cast<std::int32_t>(surfaces_.size());
        surfaces_.push_back(std::move(surface));
        by_key_.emplace(key, number);
        return {number, false};
    }

private:
    static double compare(const Surface& kept, const Surface& surface, double reach)
    {
        if ((kept.kind == Surface::Kind::Torus) != (surface.kind == Surface::Kind::Torus) ||
            (kept.kind == Surface::Kind::Function) != (surface.kind == Surface::Kind::Function))
            return 0.0;
        if (kept.kind == Surface::Kind::Function)
            return *kept.function == *surface.function ? 1.0 : 0.0;
        if (kept.kind == Surface::Kind::Torus) return *kept.torus == *surface.torus ? 1.0 : 0.0;
        return factor_between(kept.quadric.local(),
                              surface.quadric.about(kept.quadric.origin()).local(), reach);
    }

    /// The same for multiples of one function; nearly the same for nearly equal ones.
    static double key_of(const Surface& surface)
    {
        if (surface.kind == Surface::Kind::Function)
            return static_cast<double>(surface.function->hash() >> 32);
        if (surface.kind == Surface::Kind::Torus) {
            const auto& m = surface.torus->placement().m;
            return surface.torus->R() + m[0][3] + 0.7 * m[1][3] + 0.6 * m[2][3];
        }
        const std::array<double, 10> q = surface.quadric.upper_triangle();
        const bool linear = surface.kind == Surface::Kind::Plane;
        double length = 0.0;
        for (int i : {0, 1, 2, 3, 4, 5, 6, 7, 8})
            if (linear || (i != 3 && i != 6 && i != 8)) length = std::hypot(length, q[i]);
        double key = linear ? q[9] : 0.0;
        constexpr std::array<double, 9> weights{0.31, 0.47, 0.59, 1.0, 0.73,
                                                0.87, 0.81, 0.97, 0.64};
        for (std::size_t i = 0; i < 9; ++i) key += weights[i] * q[i];
        return length > 0.0 ? std::fabs(key / length) : 0.0;
    }

    std::vector<Surface>& surfaces_;
    std::multimap<double, std::int32_t> by_key_;
};

// ---- Pairs of planes

/// Two planes that cross, as half-spaces: along their common line the quadric has no gradient, so
/// it would be no surface there. Nothing for other shapes.
std::optional<Solid> as_half_spaces(const Shape& shape)
{
    const auto* any = std::get_if<QuadricShape>(&shape);
    if (!any || any->surface.is_linear()) return std::nullopt;
    const QuadricForm form(any->surface);
    if (form.kind() != QuadricKind::PlanePair) return std::nullopt;
    const std::array<Vec3, 3>& axes = form.axes();
    const Vec3 first = normalized(cross(axes[2], axes[0] + axes[1]));
    const Vec3 second = normalized(cross(axes[2], axes[0] - axes[1]));
    const auto side = [&](const Vec3& normal, double sign) {
        return half_space(sign * normal, sign * dot(normal, form.center()));
    };
    // F is the product of the two distances, or its negative.
    const double product = dot(first, axes[0]) * dot(second, axes[0]);
    const double sign = product * any->surface.value(form.center() + axes[0]) > 0.0 ? 1.0 : -1.0;
    Solid pair = unite({intersect({side(first, 1.0), side(second, -sign)}),
                        intersect({side(first, -1.0), side(second, sign)})});
    if (!any->bounds) return pair;
    const Solid box = transformed(cube(any->bounds->size()), translation(any->bounds->min));
    return intersect({pair, box});
}

// ---- The tree as instructions

/// A part of the formula under way: one term, or an operator on several. No terms: the constant
/// "outside everywhere" for a min, "inside everywhere" for a max.
struct Gathered {
    bool is_max = false;
    std::vector<Term> terms;
};

/// An operator of the tree whose parts are being written.
struct Frame {
    const Node* node;
    Transform map;
    bool negated;
    std::size_t next = 0;
    Gathered gathered;
};

class TreeWriter {
public:
    /// `by_leaf`: terms name leaves, not surfaces.
    explicit TreeWriter(bool by_leaf) : by_leaf_(by_leaf) {}

    bool any_function() const { return any_function_; }

    TreeOfLeaves write(const Solid& solid)
    {
        open(&solid.node(), Transform{}, false);
        Gathered result;
        while (!stack_.empty()) {
            Frame& top = stack_.back();
            const auto parts = parts_of(*top.node);
            if (top.next < parts.size()) {
                const bool flip =
                    std::holds_alternative<Difference>(top.node->shape) && top.next > 0;
                const Node* part = &parts[top.next++].node();
                const Transform map = top.map;
                open(part, map, top.negated != flip);
                continue;
            }
            Gathered done = std::move(top.gathered);
            stack_.pop_back();
            if (stack_.empty()) {
                result = std::move(done);
            } else {
                append(stack_.back().gathered, std::move(done));
            }
        }
        if (!result.terms.empty()) emit(std::move(result));
        return std::move(out_);
    }

private:
    /// Starts on a node; transforms and colours are passed through on the way.
    void open(const Node* top, const Transform& above, bool negated)
    {
        if (++leaves_ % 1024 == 0) current_progress().check();
        require(leaves_ <= kMostLeaves, "solid: more than 10^7 leaves");
        const auto [node, map] = below_transforms(*top, above);
        if (auto planes = as_half_spaces(node->shape)) {
            out_.expanded.push_back(std::move(*planes));
            open(&out_.expanded.back().node(), map, negated);
            return;
        }
        const bool is_union = std::holds_alternative<Union>(node->shape) ||
                              std::holds_alternative<Empty>(node->shape);
        stack_.push_back({node, map, negated, 0, {is_union == negated, {}}});
        if (parts_of(*node).empty() && !std::holds_alternative<Empty>(node->shape))
            stack_.back().gathered =
                by_leaf_ ? named_leaf(*node, map, negated) : leaf(node->shape, map, negated);
    }

    Gathered named_leaf(const Node& node, const Transform& map, bool negated)
    {
        any_function_ = any_function_ || std::holds_alternative<ImplicitShape>(node.shape);
        if (any_function_) return {!negated, {}};
        const auto number = static_cast<std::int32_t>(out_.leaves.size());
        out_.leaves.push_back({&node, map, leaf(node.shape, map, false).terms});
        return {!negated, {{number, true, negated}}};
    }

    Gathered leaf(const Shape& shape, const Transform& map, bool negated)
    {
        Gathered result{!negated, {}};
        if (const auto* any = std::get_if<ImplicitShape>(&shape))
            append(result, function(solid_parts(any->function->expression(), any->bounds), shape,
                                    map, negated));
        for (Surface& surface : leaf_surfaces(shape, map)) {
            const auto [number, flipped] = index_.add(std::move(surface), reach_of(shape, map));
            result.terms.push_back({number, true, negated != flipped});
        }
        return result;
    }

    /// A function as the union and intersection of its smooth parts.
    Gathered function(const SmoothParts& parts, const Shape& shape, const Transform& map,
                      bool negated)
    {
        Gathered result{(parts.kind == SmoothParts::Kind::Max) != negated, {}};
        for (const SmoothParts& part : parts.parts)
            append(result, function(part, shape, map, negated));
        if (parts.kind == SmoothParts::Kind::Leaf) {
            LeafWriter out(shape, map);
            const Box3& bounds = std::get<ImplicitShape>(shape).bounds;
            if (const auto half = half_space_of(parts.leaf))
                out.quadric(*half, bounds);
            else
                out.function(parts.leaf, bounds);
            const auto [number, flipped] = index_.add(std::move(out.surfaces[0]), 0.0);
            result.terms.push_back({number, true, (negated != flipped) != parts.negated});
        }
        return result;
    }

    /// How large coordinates get on the leaf: what lies closer than their rounding is the same.
    static double reach_of(const Shape& shape, const Transform& map)
    {
        double reach = norm(Vec3{{map.m[0][3], map.m[1][3], map.m[2][3]}});
        if (const auto* s = std::get_if<Cube>(&shape)) reach = std::max(reach, norm(s->size));
        if (const auto* s = std::get_if<Cylinder>(&shape)) reach = std::max(reach, s->h);
        return reach;
    }

    /// Adds a finished part to the operator above it.
    void append(Gathered& to, Gathered&& part)
    {
        if (part.terms.size() == 1 || part.is_max == to.is_max) {
            for (const Term& term : part.terms) to.terms.push_back(term);
            return;
        }
        to.terms.push_back({emit(std::move(part)), false, false});
    }

    std::int32_t emit(Gathered&& part)
    {
        // A set keeps the first of equal terms, in order.
        std::set<std::pair<std::int32_t, int>> seen;
        std::vector<Term> terms;
        for (const Term& t : part.terms)
            if (seen.emplace(t.index, 2 * t.is_surface + t.negated).second) terms.push_back(t);
        out_.instructions.push_back({part.is_max, std::move(terms)});
        return static_cast<std::int32_t>(out_.instructions.size()) - 1;
    }

    bool by_leaf_;
    bool any_function_ = false;  // among the leaves named
    TreeOfLeaves out_;
    SurfaceIndex index_{out_.surfaces};
    std::vector<Frame> stack_;
    std::size_t leaves_ = 0;
};

}  // namespace

PlacedNode below_transforms(const Node& top, const Transform& map)
{
    PlacedNode at{&top, map};
    for (;;) {
        if (const auto* moved = std::get_if<Transformed>(&at.node->shape)) {
            at.map = at.map * moved->map;
            at.node = &moved->part.node();
        } else if (const auto* colored = std::get_if<Colored>(&at.node->shape)) {
            at.node = &colored->part.node();
        } else {
            return at;
        }
    }
}

std::vector<Surface> leaf_surfaces(const Shape& shape, const Transform& map)
{
    LeafWriter out(shape, map);
    try {
        write_leaf(out, shape);
    } catch (const InvalidInput& error) {
        const std::string name = describe(shape), text = error.what();
        if (text.compare(0, name.size(), name) == 0) throw;
        throw InvalidInput(name + ": " + text);
    }
    return std::move(out.surfaces);
}

LoweredTree lower(const Solid& solid)
{
    TreeOfLeaves tree = TreeWriter(false).write(solid);
    return {std::move(tree.surfaces), std::move(tree.instructions)};
}

std::optional<TreeOfLeaves> lower_to_leaves(const Solid& solid)
{
    TreeWriter writer(true);
    TreeOfLeaves tree = writer.write(solid);
    if (writer.any_function()) return std::nullopt;
    return tree;
}

}  // namespace genus
