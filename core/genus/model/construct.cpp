#include "genus/model/construct.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/base/transform.h"
#include "genus/boolean/mesh_boolean.h"
#include "genus/mesh/extrude.h"
#include "genus/mesh/hull.h"
#include "genus/mesh/topology.h"
#include "genus/model/leaf_mesh.h"
#include "genus/model/mesh_solid.h"

namespace genus {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDefaultShare = 0.25e-3;     // of the diagonal, where no tolerance is given
constexpr std::size_t kMostPieces = 200'000;  // of a minkowski sum
constexpr double kMostSides = 1e6;

struct MeshedPart {
    IndexedMesh mesh;
    double deviation = 0.0;
};

// True for intersections of shapes that are convex by their kind.
bool is_convex_by_kind(const Solid& solid)
{
    std::vector<const Solid*> open{&solid};
    while (!open.empty()) {
        const Shape& shape = open.back()->node().shape;
        const Node& node = open.back()->node();
        open.pop_back();
        const bool passes = std::holds_alternative<Transformed>(shape) ||
                            std::holds_alternative<Colored>(shape) ||
                            std::holds_alternative<Intersection>(shape);
        const bool convex =
            std::holds_alternative<Cube>(shape) || std::holds_alternative<Sphere>(shape) ||
            std::holds_alternative<Ellipsoid>(shape) || std::holds_alternative<Cylinder>(shape) ||
            std::holds_alternative<HalfSpace>(shape);
        if (!passes && !convex) return false;
        if (passes)
            for (const Solid& part : parts_of(node)) open.push_back(&part);
    }
    return true;
}

// The mesh of a curved convex solid is convex but for dents below its error; its hull has none, and
// is no farther from the solid.
MeshedPart mesh_of(const Solid& solid, std::optional<double> tolerance)
{
    MeshOptions options;
    options.measure = false;
    options.tolerance = tolerance;
    MeshedSolid made = mesh_solid(solid, options);
    // Polyhedra are exact but for rounding.
    const double exact = 1e-9 * bounds(made.mesh).diagonal();
    if (is_convex_by_kind(solid)) made.mesh = to_triangles(convex_hull(made.mesh.vertices));
    return {std::move(made.mesh), made.error.bound > exact ? made.error.bound : 0.0};
}

std::optional<double> share_of_diagonal(std::span<const Solid> parts)
{
    Box3 box;
    for (const Solid& part : parts) box.add(part.bounds());
    const double tolerance = kDefaultShare * box.diagonal();
    return std::isfinite(tolerance) && tolerance > 0.0 ? std::optional(tolerance) : std::nullopt;
}

// ---- Hull

// Corners whose hull is that of solids.
class HullPoints {
public:
    explicit HullPoints(std::optional<double> tolerance) : tolerance_(tolerance) {}

    void add(const Solid& solid)
    {
        std::vector<std::pair<Solid, Transform>> open{{solid, Transform{}}};
        while (!open.empty()) {
            const auto [next, map] = open.back();
            open.pop_back();
            const Shape& shape = next.node().shape;
            if (const auto* moved = std::get_if<Transformed>(&shape)) {
                open.emplace_back(moved->part, map * moved->map);
            } else if (const auto* painted = std::get_if<Colored>(&shape)) {
                open.emplace_back(painted->part, map);
            } else if (const auto* all = std::get_if<Union>(&shape)) {
                for (std::size_t i = all->parts.size(); i-- > 0;)
                    open.emplace_back(all->parts[i], map);
            } else if (!std::holds_alternative<Empty>(shape)) {
                add_leaf(next, shape, map);
            }
        }
    }

    std::vector<Vec3> points;
    double deviation = 0.0;

private:
    // Parts that are curved, or cut from others, are meshed.
    void add_leaf(const Solid& solid, const Shape& shape, const Transform& map)
    {
        if (is_faceted(shape)) {
            if (const auto* given = std::get_if<Polyhedron>(&shape))
                deviation = std::max(deviation, given->deviation * largest_stretch(map));
            for (const Vec3& p : facet_mesh(shape).vertices) points.push_back(apply(map, p));
            return;
        }
        const MeshedPart part =
            mesh_of(map.is_identity() ? solid : transformed(solid, map), tolerance_);
        deviation = std::max(deviation, part.deviation);
        points.insert(points.end(), part.mesh.vertices.begin(), part.mesh.vertices.end());
    }

    std::optional<double> tolerance_;
};

// ---- Minkowski sum

std::vector<Vec3> corners(const IndexedMesh& mesh, const Triangle& f)
{
    return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

IndexedMesh hull_of_sums(const std::vector<Vec3>& a, const std::vector<Vec3>& b)
{
    std::vector<Vec3> sums;
    sums.reserve(a.size() * b.size());
    for (const Vec3& p : a)
        for (const Vec3& q : b) sums.push_back(p + q);
    return to_triangles(convex_hull(sums));
}

void add_piece(IndexedMesh piece, std::vector<IndexedMesh>& pieces)
{
    if (piece.n_faces() > 0) pieces.push_back(std::move(piece));
}

// One corner of every connected part of `places` serves.
void move_to_each_part(const IndexedMesh& mesh, const IndexedMesh& places,
                       std::vector<IndexedMesh>& pieces)
{
    const Topology t = topology(places);
    std::vector<char> done(t.components.size(), 0);
    for (std::size_t v = 0; v < places.n_vertices(); ++v) {
        const std::int32_t part = t.component_of_vertex[v];
        if (part < 0 || done[part] != 0) continue;
        done[part] = 1;
        IndexedMesh moved = mesh;
        for (Vec3& p : moved.vertices) p += places.vertices[v];
        pieces.push_back(std::move(moved));
    }
}

bool is_convex(const IndexedMesh& mesh)
{
    for (const Triangle& f : mesh.faces)
        for (const Vec3& p : mesh.vertices)
            if (orient3d(mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]], p) < 0)
                return false;
    return true;
}

IndexedMesh sum_of(const IndexedMesh& a, const IndexedMesh& b)
{
    const bool a_convex = is_convex(a), b_convex = is_convex(b);
    if (a_convex && b_convex) return hull_of_sums(a.vertices, b.vertices);
    // Of a convex part all corners stand for its border.
    const IndexedMesh& outer = a_convex ? b : a;
    const IndexedMesh& inner = a_convex ? a : b;
    const bool inner_convex = a_convex || b_convex;
    const std::size_t n_pieces = outer.n_faces() * (inner_convex ? 1 : inner.n_faces());
    if (n_pieces > kMostPieces)
        throw InvalidInput("minkowski(): " + std::to_string(n_pieces) +
                           " pieces are too many; at most " + std::to_string(kMostPieces));
    std::vector<IndexedMesh> pieces;
    move_to_each_part(outer, inner, pieces);
    move_to_each_part(inner, outer, pieces);
    for (const Triangle& f : outer.faces) {
        current_progress().check();
        const std::vector<Vec3> face = corners(outer, f);
        if (inner_convex) {
            add_piece(hull_of_sums(face, inner.vertices), pieces);
            continue;
        }
        for (const Triangle& g : inner.faces)
            add_piece(hull_of_sums(face, corners(inner, g)), pieces);
    }
    return unite(pieces);
}

// ---- Extrusion

// How far the triangles of a twisted or unevenly scaled extrusion of n slices are from the walls
// that they stand for, at most a / n^2 + b / n. Both are compared section by section. A corner's
// way is cut short by its chord, at most an eighth of its second derivative. The diagonal of a wall
// leaves the section by s (1 - s) times what the wall turns aside over a slice.
struct TwistError {
    double a = 0.0;
    double b = 0.0;

    TwistError(const Region& region, const ExtrudeOptions& options)
    {
        const double turn = std::fabs(options.twist) * kPi / 180.0;
        const double shrink =
            std::max(std::fabs(options.scale[0] - 1.0), std::fabs(options.scale[1] - 1.0));
        const double uneven = std::fabs(options.scale[0] - options.scale[1]);
        const double widest = std::max({1.0, options.scale[0], options.scale[1]});
        double reach = 0.0, longest = 0.0;
        for (const Ring& ring : region.rings)
            for (std::size_t i = 0; i < ring.size(); ++i) {
                reach = std::max(reach, norm(ring[i]));
                longest = std::max(longest, distance(ring[i], ring[(i + 1) % ring.size()]));
            }
        a = 0.125 * (turn * turn * widest + 2.0 * turn * shrink) * reach;
        b = 0.25 * (turn * widest + uneven) * longest;
    }

    double of(double n) const { return a / (n * n) + b / n; }
    double slices(double tolerance) const
    {
        return std::max(
            1.0, std::ceil((b + std::sqrt(b * b + 4.0 * a * tolerance)) / (2.0 * tolerance)));
    }
};

}  // namespace

Solid hull(std::span<const Solid> parts, std::optional<double> tolerance)
{
    HullPoints points(tolerance ? tolerance : share_of_diagonal(parts));
    for (const Solid& part : parts) points.add(part);
    PolygonMesh mesh = convex_hull(points.points);
    return mesh.n_faces() == 0 ? Solid() : polyhedron(std::move(mesh), points.deviation);
}

Solid minkowski(std::span<const Solid> parts, std::optional<double> tolerance)
{
    if (!tolerance) tolerance = share_of_diagonal(parts);
    std::optional<MeshedPart> sum;
    for (const Solid& part : parts) {
        if (part.is_empty()) continue;
        MeshedPart next = mesh_of(part, tolerance);
        if (!sum)
            sum = std::move(next);
        else
            sum = MeshedPart{sum_of(sum->mesh, next.mesh), sum->deviation + next.deviation};
    }
    if (!sum || sum->mesh.n_faces() == 0) return Solid();
    return polyhedron(to_polygons(sum->mesh), sum->deviation);
}

Solid extrude(const Region& region, const ExtrudeOptions& options, std::optional<double> tolerance)
{
    require(options.slices >= 0, "extrude: slices", options.slices, "zero or positive");
    require(std::isfinite(options.twist), "extrude: twist", options.twist, "finite");
    if (region.empty()) return Solid();
    LinearExtrudeOptions out;
    out.height = options.height;
    out.center = options.center;
    out.twist = options.twist;
    out.scale = options.scale;
    out.slices = std::max(options.slices, 1);
    double deviation = 0.0;
    if (options.slices == 0 && (options.twist != 0.0 || options.scale[0] != options.scale[1])) {
        const TwistError error(region, options);
        const Vec2 size = bounds(region).size();
        const double goal =
            tolerance.value_or(kDefaultShare * norm(Vec3{{size[0], size[1], options.height}}));
        require(goal > 0.0, "extrude: tolerance", goal, "positive");
        const double needed = error.slices(goal);
        if (!(needed <= kMostSides))
            throw ToleranceNotMet("extrude: the twist needs more than " + to_text(kMostSides) +
                                      " slices to be within " + to_text(goal),
                                  goal, error.of(kMostSides), {});
        out.slices = static_cast<int>(needed);
        deviation = error.of(needed);
    }
    return polyhedron(linear_extrude(region, out), deviation);
}

Solid revolve(const Region& region, const RevolveOptions& options, std::optional<double> tolerance)
{
    require(options.fragments == 0 || options.fragments >= 3, "revolve: fragments",
            options.fragments, "zero, or three or more");
    if (region.empty()) return Solid();
    const Box2 box = bounds(region);
    const double reach = std::max(std::fabs(box.min[0]), std::fabs(box.max[0]));
    int sides = options.fragments;
    double deviation = 0.0;
    if (sides == 0) {
        const double goal = tolerance.value_or(
            kDefaultShare * norm(Vec3{{2.0 * reach, 2.0 * reach, box.size()[1]}}));
        require(goal > 0.0, "revolve: tolerance", goal, "positive");
        sides = sides_within(goal, reach);
        deviation = reach * (1.0 - cos_degrees(180.0 / sides));
    }
    RotateExtrudeOptions out;
    out.angle = options.angle;
    const bool full = std::fabs(options.angle) == 360.0;
    const double share = std::fabs(options.angle) / 360.0;
    out.fragments = full ? sides : std::max(1, static_cast<int>(std::ceil(sides * share)));
    return polyhedron(rotate_extrude(region, out), deviation);
}

int sides_within(double tolerance, double r)
{
    if (!(tolerance < r)) return 5;
    // 1 - cos is twice the square of the sine of half the angle.
    const double half = std::asin(std::sqrt(0.5 * tolerance / r));
    const double needed = std::ceil(kPi / (2.0 * half));
    if (!(needed <= kMostSides)) {
        const double reached = r * (1.0 - cos_degrees(180.0 / kMostSides));
        throw ToleranceNotMet("a circle of radius " + to_text(r) + " needs more than " +
                                  to_text(kMostSides) + " sides to be within " +
                                  to_text(tolerance) + "; with these it is within " +
                                  to_text(reached),
                              tolerance, reached, {});
    }
    return static_cast<int>(std::max(needed, 5.0));
}

}  // namespace genus
