#include "genus/model/solid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_set>

#include "genus/base/error.h"
#include "genus/model/directed.h"
#include "genus/model/freeform.h"

namespace genus {
namespace {

// ---- Hash: numbers are mixed in one after the other; equal numbers (0 and -0) hash alike.

class Hasher {
public:
    explicit Hasher(std::uint64_t kind) : state_(0x9e3779b97f4a7c15U + kind) {}

    void add(std::uint64_t word)
    {
        // The finaliser of a 64-bit mixing generator (Stafford's variant 13).
        state_ = (state_ ^ word) + 0x9e3779b97f4a7c15U;
        state_ = (state_ ^ (state_ >> 30U)) * 0xbf58476d1ce4e5b9U;
        state_ = (state_ ^ (state_ >> 27U)) * 0x94d049bb133111ebU;
        state_ ^= state_ >> 31U;
    }
    void add(double value) { add(std::bit_cast<std::uint64_t>(value + 0.0)); }
    void add(bool value) { add(std::uint64_t{value}); }
    void add(int value) { add(static_cast<std::uint64_t>(value)); }
    template <std::size_t N>
    void add(const Vec<N>& v)
    {
        for (double c : v.c) add(c);
    }
    void add(const std::vector<Solid>& parts)
    {
        add(std::uint64_t{parts.size()});
        for (const Solid& part : parts) add(part.hash());
    }
    std::uint64_t result() const { return state_; }

private:
    std::uint64_t state_;
};

struct HashShape {
    Hasher& h;
    void operator()(const Empty&) const {}
    void operator()(const Cube& s) const { h.add(s.size), h.add(s.center); }
    void operator()(const Sphere& s) const { h.add(s.r), h.add(s.fragments); }
    void operator()(const Ellipsoid& s) const { h.add(s.radii); }
    void operator()(const Cylinder& s) const
    {
        h.add(s.h), h.add(s.r1), h.add(s.r2), h.add(s.center), h.add(s.fragments);
    }
    void operator()(const TorusShape& s) const { h.add(s.R), h.add(s.r); }
    void operator()(const HalfSpace& s) const { h.add(s.normal), h.add(s.offset); }
    void operator()(const QuadricShape& s) const
    {
        for (double c : s.surface.local()) h.add(c);
        h.add(s.surface.origin());
        h.add(s.bounds.has_value());
        if (s.bounds) h.add(s.bounds->min), h.add(s.bounds->max);
    }
    void operator()(const ImplicitShape& s) const
    {
        h.add(s.function->hash());
        h.add(s.bounds.min), h.add(s.bounds.max);
    }
    void operator()(const Polyhedron& s) const
    {
        h.add(s.deviation);
        h.add(std::uint64_t{s.mesh->n_vertices()});
        for (const Vec3& v : s.mesh->vertices) h.add(v);
        for (std::int64_t start : s.mesh->starts) h.add(static_cast<std::uint64_t>(start));
        for (std::int32_t corner : s.mesh->corners) h.add(corner);
    }
    void operator()(const Freeform& s) const { h.add(s.source->hash()); }
    void operator()(const Union& s) const { h.add(s.parts); }
    void operator()(const Intersection& s) const { h.add(s.parts); }
    void operator()(const Difference& s) const { h.add(s.parts); }
    void operator()(const Transformed& s) const
    {
        h.add(s.part.hash());
        for (const auto& row : s.map.m)
            for (double c : row) h.add(c);
    }
    void operator()(const Colored& s) const { h.add(s.part.hash()), h.add(s.rgba); }
};

std::uint64_t hash_of(const Shape& shape)
{
    Hasher hasher(shape.index());
    std::visit(HashShape{hasher}, shape);
    return hasher.result();
}

// ---- Bounds: the box of a shape's image under an affine map, from its width along each axis,
// every operation rounded outward.

using directed::add;
using directed::length_up;
using directed::multiply;
using directed::multiply_up;

Interval about_zero(double reach)
{
    return {-reach, reach};
}

/// The corners of a faceted shape that reach farthest one way, found from the angle of that way:
/// the nearest corner and its neighbours, for a rounded angle may lie just beyond half-way. The
/// corners are those of facet_mesh, bit for bit.
struct FacetReach {
    const std::array<double, 4>& row;
    double sign;  // 1 for the upper end of the range, -1 for the lower

    /// a x + b y + c z with the last bit on the side of the sign.
    double outer(double x, double y, double z) const
    {
        const Interval sum = add(add(multiply(row[0], Interval(x)), multiply(row[1], Interval(y))),
                                 multiply(row[2], Interval(z)));
        return sign > 0.0 ? sum.hi : sum.lo;
    }
    /// Number of the corner of n that is nearest to the way, seen from above.
    long nearest(int n) const
    {
        const double angle = std::atan2(sign * row[1], sign * row[0]);
        return std::lround(angle / kTurn * n) + n;
    }
    double of_ring(int n, double r, double z) const
    {
        double best = -sign * directed::kInf;
        for (long j = nearest(n) - 1; j <= nearest(n) + 1; ++j) {
            const double angle = 360.0 * static_cast<double>(j % n) / n;
            const double at = outer(r * cos_degrees(angle), r * sin_degrees(angle), z);
            if (sign * at > sign * best) best = at;
        }
        return best;
    }
    double of_sphere(const Sphere& s) const
    {
        const int n = s.fragments, rings = (n + 1) / 2;
        // On the meridian of the nearest corner the reach is sine and cosine of the polar angle.
        const double flat = std::fabs(of_ring(n, 1.0, 0.0));
        const double polar = std::atan2(flat, sign * row[2]);
        const long middle = std::lround(polar / (0.5 * kTurn) * rings - 0.5);
        double best = -sign * directed::kInf;
        for (long i = std::max(middle - 1, 0L); i <= std::min(middle + 1, rings - 1L); ++i) {
            const double angle = 180.0 * (static_cast<double>(i) + 0.5) / rings;
            const double at = of_ring(n, s.r * sin_degrees(angle), s.r * cos_degrees(angle));
            if (sign * at > sign * best) best = at;
        }
        return best;
    }

    static constexpr double kTurn = 6.283185307179586;
};

/// Range of one coordinate of the image: `row` is a row of the map, the last entry the step.
struct AxisRange {
    const std::array<double, 4>& row;

    Interval with_step(const Interval& range) const { return add(range, Interval(row[3])); }

    Interval operator()(const Cube& s) const
    {
        Interval range(0.0);
        for (int i = 0; i < 3; ++i) {
            const Interval side = s.center ? about_zero(0.5 * s.size[i]) : Interval(0, s.size[i]);
            range = add(range, multiply(row[i], side));
        }
        return with_step(range);
    }
    Interval operator()(const Box3& s) const
    {
        Interval range(0.0);
        for (int i = 0; i < 3; ++i)
            range = add(range, multiply(row[i], Interval(s.min[i], s.max[i])));
        return with_step(range);
    }
    Interval operator()(const Sphere& s) const
    {
        if (s.fragments > 0)
            return with_step(
                {FacetReach{row, -1.0}.of_sphere(s), FacetReach{row, 1.0}.of_sphere(s)});
        return with_step(about_zero(multiply_up(s.r, length_up(row[0], row[1], row[2]))));
    }
    Interval operator()(const Ellipsoid& s) const
    {
        const double a = multiply_up(std::fabs(row[0]), s.radii[0]);
        const double b = multiply_up(std::fabs(row[1]), s.radii[1]);
        const double c = multiply_up(std::fabs(row[2]), s.radii[2]);
        return with_step(about_zero(length_up(a, b, c)));
    }
    Interval operator()(const Cylinder& s) const
    {
        const double flat = length_up(row[0], row[1]);
        const auto disc = [&](double z, double r) {
            if (s.fragments > 0)
                return Interval(FacetReach{row, -1.0}.of_ring(s.fragments, r, z),
                                FacetReach{row, 1.0}.of_ring(s.fragments, r, z));
            return add(multiply(row[2], Interval(z)), about_zero(multiply_up(r, flat)));
        };
        const double low = s.center ? -0.5 * s.h : 0.0;
        return with_step(hull(disc(low, s.r1), disc(low + s.h, s.r2)));
    }
    Interval operator()(const TorusShape& s) const
    {
        const double circle = multiply_up(s.R, length_up(row[0], row[1]));
        const double tube = multiply_up(s.r, length_up(row[0], row[1], row[2]));
        return with_step(add(about_zero(circle), about_zero(tube)));
    }
    Interval operator()(const Polyhedron& s) const
    {
        Interval range(directed::kInf, -directed::kInf);
        for (const Vec3& v : s.mesh->vertices) {
            Interval at(0.0);
            for (int i = 0; i < 3; ++i) at = add(at, multiply(row[i], Interval(v[i])));
            range = hull(range, at);
        }
        return s.mesh->vertices.empty() ? range : with_step(range);
    }
};

template <class S>
Box3 axis_box(const S& shape, const Transform& t)
{
    Box3 box;
    for (int i = 0; i < 3; ++i) {
        const Interval range = AxisRange{t.m[i]}(shape);
        box.min[i] = range.lo;
        box.max[i] = range.hi;
    }
    return box;
}

Box3 half_space_box(const HalfSpace& s, const Transform& t)
{
    const Quadric plane = transformed(Quadric::half_space(s.normal, s.offset), t);
    const std::array<double, 10> q = plane.local();
    const Vec3 n{{2.0 * q[3], 2.0 * q[6], 2.0 * q[8]}};
    Box3 box = Box3::everything();
    for (int i = 0; i < 3; ++i) {
        if (n[i] == 0.0 || n[(i + 1) % 3] != 0.0 || n[(i + 2) % 3] != 0.0) continue;
        const double side = -q[9] / n[i];
        // The quotient is exact for normals of length 1; else one step outward covers it.
        const bool exact = std::fma(side, n[i], q[9]) == 0.0;
        if (n[i] > 0.0) box.max[i] = exact ? side : std::nextafter(side, directed::kInf);
        if (n[i] < 0.0) box.min[i] = exact ? side : std::nextafter(side, -directed::kInf);
    }
    return box;
}

/// Half the size of {x : x^T A x <= 1} along axis i is the root of the (i, i) entry of A^-1.
std::optional<Box3> ellipsoid_box(const Quadric& quadric)
{
    const std::array<double, 10>& q = quadric.local();
    if (q[1] != 0.0 || q[2] != 0.0 || q[5] != 0.0) return std::nullopt;
    const std::array<double, 3> a{q[0], q[4], q[7]}, b{q[3], q[6], q[8]};
    if (!(a[0] >= 0.0 && a[1] >= 0.0 && a[2] >= 0.0)) return std::nullopt;
    // F = sum a_i (x_i + b_i / a_i)^2 - K; a variable without a square is free, but if it enters
    // linearly, K is not constant and nothing is bounded.
    Interval k(-q[9]);
    for (int i = 0; i < 3; ++i) {
        if (b[i] != 0.0 && a[i] > 0.0) k = k + square(Interval(b[i])) / Interval(a[i]);
        if (a[i] == 0.0 && b[i] != 0.0) return std::nullopt;
    }
    if (k.hi < 0.0) return Box3{};
    Box3 box = Box3::everything();
    for (int i = 0; i < 3; ++i) {
        if (a[i] == 0.0) continue;
        const Interval reach = b[i] == 0.0 && a[i] == 1.0 ? Interval(0.0, directed::root_up(k.hi))
                                                          : sqrt(k / Interval(a[i]));
        const Interval middle = add(-(Interval(b[i]) / Interval(a[i])), quadric.origin()[i]);
        const bool centred = b[i] == 0.0;
        box.min[i] = add(centred ? Interval(quadric.origin()[i]) : middle, -reach.hi).lo;
        box.max[i] = add(centred ? Interval(quadric.origin()[i]) : middle, reach.hi).hi;
    }
    return box;
}

Box3 quadric_box(const QuadricShape& s, const Transform& t)
{
    Box3 box = s.bounds ? axis_box(*s.bounds, t) : Box3::everything();
    if (const auto image = ellipsoid_box(t.is_identity() ? s.surface : transformed(s.surface, t)))
        box = intersection(box, *image);
    return box.empty() ? Box3{} : box;
}

Box3 bounds_of(const std::vector<Solid>& parts)
{
    Box3 box;
    for (const Solid& part : parts) box.add(part.bounds());
    return box;
}

Box3 common_box(const std::vector<Solid>& parts)
{
    Box3 box = Box3::everything();
    for (const Solid& part : parts) box = intersection(box, part.bounds());
    return box.empty() ? Box3{} : box;
}

/// Box of the solid's image under `t`, tight where a primitive is met within a few steps.
Box3 image_box(const Solid& solid, const Transform& t, int steps = 16)
{
    const Shape& shape = solid.node().shape;
    if (solid.bounds().empty()) return {};
    if (const auto* moved = std::get_if<Transformed>(&shape); moved && steps > 0)
        return image_box(moved->part, t * moved->map, steps - 1);
    if (const auto* colored = std::get_if<Colored>(&shape); colored && steps > 0)
        return image_box(colored->part, t, steps - 1);
    if (const auto* s = std::get_if<Cube>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<Sphere>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<Ellipsoid>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<Cylinder>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<TorusShape>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<Polyhedron>(&shape)) return axis_box(*s, t);
    if (const auto* s = std::get_if<HalfSpace>(&shape)) return half_space_box(*s, t);
    if (const auto* s = std::get_if<QuadricShape>(&shape)) return quadric_box(*s, t);
    if (const auto* s = std::get_if<ImplicitShape>(&shape)) return axis_box(s->bounds, t);
    return axis_box(solid.bounds(), t);
}

// ---- Making nodes

Solid make(Shape shape, const Box3& bounds)
{
    const std::uint64_t hash = hash_of(shape);
    return Solid(std::make_shared<const Node>(std::move(shape), bounds, hash));
}

template <class S>
Solid primitive(const S& shape)
{
    return make(shape, axis_box(shape, Transform{}));
}

void require_length(const char* argument, double value)
{
    require(std::isfinite(value) && value > 0.0, argument, value, "positive and finite");
}

void require_fragments(const char* argument, int fragments)
{
    require(fragments == 0 || fragments >= 3, argument, fragments, "0 (exact) or at least 3");
}

std::vector<Solid> without_empty(std::vector<Solid> parts)
{
    std::erase_if(parts, [](const Solid& part) { return part.is_empty(); });
    return parts;
}

std::vector<Solid> take_parts(Shape& shape)
{
    if (auto* s = std::get_if<Union>(&shape)) return std::move(s->parts);
    if (auto* s = std::get_if<Intersection>(&shape)) return std::move(s->parts);
    if (auto* s = std::get_if<Difference>(&shape)) return std::move(s->parts);
    if (auto* s = std::get_if<Transformed>(&shape)) return {std::move(s->part)};
    if (auto* s = std::get_if<Colored>(&shape)) return {std::move(s->part)};
    return {};
}

/// Same kind and numbers, leaving the parts of operators aside.
bool same_shape_without_parts(const Node& a, const Node& b)
{
    if (a.shape.index() != b.shape.index() || a.hash != b.hash) return false;
    if (parts_of(a).size() != parts_of(b).size()) return false;
    if (const auto* s = std::get_if<Transformed>(&a.shape))
        return s->map == std::get<Transformed>(b.shape).map;
    if (const auto* s = std::get_if<Colored>(&a.shape))
        return s->rgba == std::get<Colored>(b.shape).rgba;
    return !parts_of(a).empty() || a.shape == b.shape;
}

std::string numbers(std::span<const double> values)
{
    std::string text = "[";
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i > 0) text += ", ";
        text += to_text(values[i]);
    }
    text += "]";
    return text;
}

struct Describe {
    std::string operator()(const Empty&) const { return "empty solid"; }
    std::string operator()(const Cube& s) const { return "cube(" + numbers(s.size.c) + ")"; }
    std::string operator()(const Sphere& s) const { return "sphere(r = " + to_text(s.r) + ")"; }
    std::string operator()(const Ellipsoid& s) const
    {
        return "ellipsoid(" + numbers(s.radii.c) + ")";
    }
    std::string operator()(const Cylinder& s) const
    {
        const std::string radii = s.r1 == s.r2
                                      ? "r = " + to_text(s.r1)
                                      : "r1 = " + to_text(s.r1) + ", r2 = " + to_text(s.r2);
        return "cylinder(h = " + to_text(s.h) + ", " + radii + ")";
    }
    std::string operator()(const TorusShape& s) const
    {
        return "torus(R = " + to_text(s.R) + ", r = " + to_text(s.r) + ")";
    }
    std::string operator()(const HalfSpace& s) const
    {
        return "half_space(" + numbers(s.normal.c) + ", " + to_text(s.offset) + ")";
    }
    std::string operator()(const QuadricShape& s) const
    {
        return "quadric(" + numbers(s.surface.upper_triangle()) + ")";
    }
    std::string operator()(const ImplicitShape& s) const
    {
        return "implicit(" + to_text(s.function->expression(), 60) + ")";
    }
    std::string operator()(const Polyhedron& s) const
    {
        return "polyhedron with " + std::to_string(s.mesh->n_faces()) + " faces";
    }
    std::string operator()(const Freeform& s) const { return s.source->describe(); }
    std::string operator()(const Union&) const { return "union"; }
    std::string operator()(const Intersection&) const { return "intersection"; }
    std::string operator()(const Difference&) const { return "difference"; }
    std::string operator()(const Transformed&) const { return "transform"; }
    std::string operator()(const Colored&) const { return "color"; }
};

}  // namespace

Node::~Node()
{
    // The parts of nodes that end while another one does wait in its queue: no recursion.
    static thread_local std::vector<Solid>* queue = nullptr;
    std::vector<Solid> parts = take_parts(shape);
    if (parts.empty()) return;
    if (queue) {
        std::move(parts.begin(), parts.end(), std::back_inserter(*queue));
        return;
    }
    queue = &parts;
    while (!parts.empty()) {
        [[maybe_unused]] const Solid ends_here = std::move(parts.back());
        parts.pop_back();
    }
    queue = nullptr;
}

bool Freeform::operator==(const Freeform& o) const
{
    return source == o.source || source->equals(*o.source);
}

std::span<const Solid> parts_of(const Node& node)
{
    if (const auto* s = std::get_if<Union>(&node.shape)) return s->parts;
    if (const auto* s = std::get_if<Intersection>(&node.shape)) return s->parts;
    if (const auto* s = std::get_if<Difference>(&node.shape)) return s->parts;
    if (const auto* s = std::get_if<Transformed>(&node.shape)) return {&s->part, 1};
    if (const auto* s = std::get_if<Colored>(&node.shape)) return {&s->part, 1};
    return {};
}

std::string describe(const Shape& shape)
{
    return std::visit(Describe{}, shape);
}

Solid::Solid()
{
    static const Solid empty = make(Empty{}, Box3{});
    node_ = empty.node_;
}

bool Solid::is_empty() const
{
    return std::holds_alternative<Empty>(node_->shape);
}

const Box3& Solid::bounds() const
{
    return node_->bounds;
}

std::uint64_t Solid::hash() const
{
    return node_->hash;
}

bool operator==(const Solid& a, const Solid& b)
{
    std::vector<std::pair<const Solid*, const Solid*>> waiting{{&a, &b}};
    // Shared subtrees are compared once.
    std::unordered_set<const Node*> seen;
    while (!waiting.empty()) {
        const auto [x, y] = waiting.back();
        waiting.pop_back();
        if (x->shares_node_with(*y)) continue;
        if (!same_shape_without_parts(x->node(), y->node())) return false;
        const auto parts_x = parts_of(x->node()), parts_y = parts_of(y->node());
        if (parts_x.empty() || !seen.insert(&x->node()).second) continue;
        for (std::size_t i = 0; i < parts_x.size(); ++i)
            waiting.emplace_back(&parts_x[i], &parts_y[i]);
    }
    return true;
}

Box3 image_bounds(const Solid& solid, const Transform& map)
{
    return image_box(solid, map);
}

Solid cube(const Vec3& size, bool center)
{
    for (int i = 0; i < 3; ++i) require_length("cube: size", size[i]);
    return primitive(Cube{size, center});
}

Solid sphere(double r, int fragments)
{
    require_length("sphere: r", r);
    require_fragments("sphere: fragments", fragments);
    return primitive(Sphere{r, fragments});
}

Solid ellipsoid(const Vec3& radii)
{
    for (int i = 0; i < 3; ++i) require_length("ellipsoid: radius", radii[i]);
    return primitive(Ellipsoid{radii});
}

Solid cylinder(double h, double r1, double r2, bool center, int fragments)
{
    require_length("cylinder: h", h);
    require(std::isfinite(r1) && r1 >= 0.0, "cylinder: r1", r1, "finite and not negative");
    require(std::isfinite(r2) && r2 >= 0.0, "cylinder: r2", r2, "finite and not negative");
    require(r1 > 0.0 || r2 > 0.0, "cylinder: r1 and r2 are both zero");
    require_fragments("cylinder: fragments", fragments);
    return primitive(Cylinder{h, r1, r2, center, fragments});
}

Solid torus(double R, double r)
{
    require_length("torus: R", R);
    require(r > 0.0 && r < R, "torus: r", r, "positive and less than R");
    return primitive(TorusShape{R, r});
}

Solid half_space(const Vec3& normal, double offset)
{
    require(is_finite(normal) && normal != Vec3{}, "half_space: the normal is zero or not finite");
    require(std::isfinite(offset), "half_space: offset", offset, "finite");
    const HalfSpace shape{normal, offset};
    return make(shape, half_space_box(shape, Transform{}));
}

Solid quadric(const Quadric& surface, const std::optional<Box3>& bounds)
{
    if (bounds) require(!bounds->empty() && bounds->bounded(), "quadric: bounds empty or infinite");
    const QuadricShape shape{surface, bounds};
    return make(shape, quadric_box(shape, Transform{}));
}

Solid implicit(const Expression& expression, const Box3& bounds)
{
    require(!bounds.empty() && bounds.bounded(), "implicit: bounds empty or infinite");
    const auto function = std::make_shared<const Function>(expression);
    const Interval range = function->bound(bounds);
    if (range.lo > 0.0) return Solid();
    const Vec3 size = bounds.size();
    if (range.hi <= 0.0 && size[0] > 0.0 && size[1] > 0.0 && size[2] > 0.0)
        return transformed(cube(size), translation(bounds.min));
    return make(ImplicitShape{function, bounds}, bounds);
}

Solid polyhedron(PolygonMesh mesh, double deviation)
{
    for (const Vec3& v : mesh.vertices)
        require(is_finite(v), "polyhedron: a coordinate is not finite");
    const auto n = static_cast<std::int64_t>(mesh.n_vertices());
    for (std::int32_t corner : mesh.corners)
        require(corner >= 0 && corner < n, "polyhedron: vertex number", corner,
                "in the list of points");
    require(!mesh.starts.empty() && mesh.starts.front() == 0 &&
                mesh.starts.back() == static_cast<std::int64_t>(mesh.corners.size()) &&
                std::is_sorted(mesh.starts.begin(), mesh.starts.end()),
            "polyhedron: face table is broken");
    if (mesh.n_faces() == 0) return Solid();
    require(deviation >= 0.0 && std::isfinite(deviation), "polyhedron: deviation", deviation,
            "zero or positive");
    return primitive(Polyhedron{std::make_shared<const PolygonMesh>(std::move(mesh)), deviation});
}

Solid freeform(std::shared_ptr<const FreeformSource> source)
{
    const Box3 bounds = source->bounds();
    if (bounds.empty()) return Solid();
    return make(Freeform{std::move(source)}, bounds);
}

Solid unite(std::vector<Solid> parts)
{
    parts = without_empty(std::move(parts));
    if (parts.empty()) return {};
    if (parts.size() == 1) return parts[0];
    const Box3 box = bounds_of(parts);
    return make(Union{std::move(parts)}, box);
}

Solid intersect(std::vector<Solid> parts)
{
    if (parts.empty()) return {};
    for (const Solid& part : parts)
        if (part.is_empty()) return {};
    if (parts.size() == 1) return parts[0];
    const Box3 box = common_box(parts);
    return make(Intersection{std::move(parts)}, box);
}

Solid subtract(std::vector<Solid> parts)
{
    if (parts.empty() || parts[0].is_empty()) return {};
    parts = without_empty(std::move(parts));
    if (parts.size() == 1) return parts[0];
    const Box3 box = parts[0].bounds();
    return make(Difference{std::move(parts)}, box);
}

Solid transformed(const Solid& part, const Transform& map)
{
    for (const auto& row : map.m)
        for (double c : row) require(std::isfinite(c), "transform: matrix entry", c, "finite");
    require(map.is_affine(), "transform: the last row is not 0, 0, 0, 1");
    inverse(map);  // refuses singular maps
    if (part.is_empty()) return part;
    return make(Transformed{part, map}, image_box(part, map));
}

Solid colored(const Solid& part, const Vec4& rgba)
{
    for (double c : rgba.c) require(c >= 0.0 && c <= 1.0, "color: component", c, "from 0 to 1");
    if (part.is_empty()) return part;
    return make(Colored{part, rgba}, part.bounds());
}

}  // namespace genus
