#include "genus/model/solid_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/base/transform.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/topology.h"
#include "genus/model/boolean_road.h"
#include "genus/model/csg_field.h"
#include "genus/model/freeform.h"
#include "genus/model/leaf_mesh.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/queries.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kQueryTolerance = 1.0 / 4096.0;  // of the diagonal
constexpr std::size_t kDeepest = 8'000;           // nodes above a leaf

// Signed distance to a closed mesh. The pieces are the planes of the faces.
class MeshField final : public Implicit {
public:
    explicit MeshField(IndexedMesh mesh) : mesh_(std::move(mesh)), tree_(mesh_) {}

    double value(const Vec3& p) const override
    {
        const double far = tree_.nearest(p).distance;
        const auto turns = tree_.winding_number(p);
        return !turns ? 0.0 : *turns != 0 ? -far : far;
    }
    Vec3 gradient(const Vec3& p) const override
    {
        const ClosestPoint near = tree_.nearest(p);
        const auto turns = tree_.winding_number(p);
        if (near.face < 0) return {};
        if (!turns || !(near.distance > 0.0)) return normal(near.face);
        return (*turns != 0 ? -1.0 : 1.0) / near.distance * (p - near.point);
    }
    Interval bound(const Box3& box) const override
    {
        // No distance changes faster than the place.
        const double middle = value(box.center()), reach = 0.5 * box.diagonal() * (1.0 + 1e-15);
        return {middle - reach, middle + reach};
    }
    IntervalVec3 gradient_bound(const Box3&) const override
    {
        return {Interval(-1.0, 1.0), Interval(-1.0, 1.0), Interval(-1.0, 1.0)};
    }
    std::int32_t piece(const Vec3& p) const override { return tree_.nearest(p).face; }
    double piece_value(std::int32_t face, const Vec3& p) const override
    {
        return face < 0 ? kInfinity : dot(normal(face), p - mesh_.vertices[mesh_.faces[face][0]]);
    }
    Vec3 piece_gradient(std::int32_t face, const Vec3&) const override
    {
        return face < 0 ? Vec3{} : normal(face);
    }

private:
    Vec3 normal(std::int32_t face) const
    {
        const Triangle& t = mesh_.faces[face];
        return normalized(cross(mesh_.vertices[t[1]] - mesh_.vertices[t[0]],
                                mesh_.vertices[t[2]] - mesh_.vertices[t[0]]));
    }

    IndexedMesh mesh_;
    MeshTree tree_;
};

// The function of a part in the place where a map puts it.
class PlacedField final : public Implicit {
public:
    PlacedField(std::shared_ptr<const Implicit> part, const Transform& map)
        : part_(std::move(part)), back_(inverse(map))
    {
    }

    double value(const Vec3& p) const override { return part_->value(apply(back_, p)); }
    Vec3 gradient(const Vec3& p) const override { return turned(part_->gradient(apply(back_, p))); }
    Interval bound(const Box3& box) const override { return part_->bound(before(box)); }
    IntervalVec3 gradient_bound(const Box3& box) const override
    {
        const IntervalVec3 g = part_->gradient_bound(before(box));
        IntervalVec3 result;
        for (std::size_t c = 0; c < 3; ++c)
            result[c] = g[0] * Interval(back_.m[0][c]) + g[1] * Interval(back_.m[1][c]) +
                        g[2] * Interval(back_.m[2][c]);
        return result;
    }
    std::int32_t piece(const Vec3& p) const override { return part_->piece(apply(back_, p)); }
    double piece_value(std::int32_t n, const Vec3& p) const override
    {
        return part_->piece_value(n, apply(back_, p));
    }
    Vec3 piece_gradient(std::int32_t n, const Vec3& p) const override
    {
        return turned(part_->piece_gradient(n, apply(back_, p)));
    }

private:
    Vec3 turned(const Vec3& g) const
    {
        Vec3 result;
        for (std::size_t c = 0; c < 3; ++c)
            result[c] = g[0] * back_.m[0][c] + g[1] * back_.m[1][c] + g[2] * back_.m[2][c];
        return result;
    }
    Box3 before(const Box3& box) const
    {
        Box3 image;
        for (std::size_t k = 0; k < 8; ++k) image.add(apply(back_, box.corner(k)));
        return image.inflated(1e-14 * (norm(image.min) + norm(image.max)));
    }

    std::shared_ptr<const Implicit> part_;
    Transform back_;
};

// Minimum or maximum of several functions. A piece is the piece of one of them.
class JoinedField final : public Implicit {
public:
    struct Part {
        std::shared_ptr<const Implicit> field;
        bool negated;
    };
    JoinedField(bool is_max, std::vector<Part> parts) : is_max_(is_max), parts_(std::move(parts)) {}

    double value(const Vec3& p) const override { return decided(p).value; }
    Vec3 gradient(const Vec3& p) const override
    {
        const Decided d = decided(p);
        if (d.part == parts_.size()) return {};
        return sign(d.part) * parts_[d.part].field->gradient(p);
    }
    Interval bound(const Box3& box) const override
    {
        Interval range(start());
        for (const Part& part : parts_) {
            const Interval b = part.field->bound(box);
            range = is_max_ ? max(range, part.negated ? -b : b) : min(range, part.negated ? -b : b);
        }
        return range;
    }
    IntervalVec3 gradient_bound(const Box3& box) const override
    {
        IntervalVec3 range;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const IntervalVec3 g = parts_[i].field->gradient_bound(box);
            for (std::size_t c = 0; c < 3; ++c) {
                const Interval own = g[c] * Interval(sign(i));
                range[c] = i == 0 ? own : hull(range[c], own);
            }
        }
        return range;
    }
    std::int32_t piece(const Vec3& p) const override
    {
        const Decided d = decided(p);
        if (d.part == parts_.size()) return -1;
        const std::int64_t own = parts_[d.part].field->piece(p);
        const std::int64_t n = static_cast<std::int64_t>(parts_.size());
        const std::int64_t number = own * n + static_cast<std::int64_t>(d.part);
        if (own < 0) return -1;
        require(number <= std::numeric_limits<std::int32_t>::max(), "solid: too many faces");
        return static_cast<std::int32_t>(number);
    }
    double piece_value(std::int32_t number, const Vec3& p) const override
    {
        if (number < 0) return start();
        return part_of(number).field->piece_value(own_number(number), p);
    }
    Vec3 piece_gradient(std::int32_t number, const Vec3& p) const override
    {
        if (number < 0) return {};
        return part_of(number).field->piece_gradient(own_number(number), p);
    }

private:
    struct Decided {
        std::size_t part;
        double value;
    };
    double start() const { return is_max_ ? -kInfinity : kInfinity; }
    double sign(std::size_t part) const { return parts_[part].negated ? -1.0 : 1.0; }
    const Part& part_of(std::int32_t number) const
    {
        return parts_[static_cast<std::size_t>(number) % parts_.size()];
    }
    std::int32_t own_number(std::int32_t number) const
    {
        return number / static_cast<std::int32_t>(parts_.size());
    }
    Decided decided(const Vec3& p) const
    {
        Decided best{parts_.size(), start()};
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const double v = sign(i) * parts_[i].field->value(p);
            if (best.part == parts_.size() || (is_max_ ? v > best.value : v < best.value))
                best = {i, v};
        }
        return best;
    }

    bool is_max_;
    std::vector<Part> parts_;
};

std::shared_ptr<const Implicit> field_of(const Solid& solid, const Transform& map,
                                         std::size_t depth);

IndexedMesh placed(IndexedMesh mesh, const Transform& map)
{
    const Topology kind = topology(mesh);
    require(kind.closed && kind.oriented,
            "solid: a polyhedron is not closed and oriented, so it has no inside");
    for (Vec3& v : mesh.vertices) v = apply(map, v);
    if (determinant(map) < 0.0)
        for (Triangle& f : mesh.faces) std::swap(f[1], f[2]);
    return mesh;
}

std::shared_ptr<const Implicit> leaf_field(const Solid& solid, const Transform& map)
{
    const Shape& shape = solid.node().shape;
    if (const auto* leaf = std::get_if<Freeform>(&shape)) {
        if (auto own = leaf->source->field())
            return map.is_identity() ? own : std::make_shared<PlacedField>(std::move(own), map);
        const double tolerance = kQueryTolerance * leaf->source->bounds().diagonal();
        return std::make_shared<MeshField>(placed(leaf->source->mesh(tolerance, {}).mesh, map));
    }
    return std::make_shared<MeshField>(placed(to_triangles(facet_mesh(shape)), map));
}

std::shared_ptr<const Implicit> operator_field(const Solid& solid, const Transform& map,
                                               std::size_t depth)
{
    const bool subtracts = std::holds_alternative<Difference>(solid.node().shape);
    const bool unites = std::holds_alternative<Union>(solid.node().shape);
    std::vector<JoinedField::Part> parts;
    for (const Solid& part : parts_of(solid.node()))
        parts.push_back({field_of(part, map, depth + 1), subtracts && !parts.empty()});
    return std::make_shared<JoinedField>(!unites, std::move(parts));
}

std::shared_ptr<const Implicit> field_of(const Solid& solid, const Transform& map,
                                         std::size_t depth)
{
    require(depth < kDeepest, "solid: the tree is nested more than 8000 levels deep");
    current_progress().check();
    const Shape& shape = solid.node().shape;
    if (is_smooth(solid) || (parts_of(solid.node()).empty() && has_formula(solid)))
        return std::make_shared<CsgField>(transformed(solid, map));
    if (const auto* moved = std::get_if<Transformed>(&shape))
        return field_of(moved->part, map * moved->map, depth + 1);
    if (const auto* painted = std::get_if<Colored>(&shape))
        return field_of(painted->part, map, depth + 1);
    return parts_of(solid.node()).empty() ? leaf_field(solid, map)
                                          : operator_field(solid, map, depth);
}

}  // namespace

bool has_formula(const Solid& solid)
{
    if (is_smooth(solid)) return true;
    try {
        const CsgField field(solid);
        return true;
    } catch (const InvalidInput&) {
        return false;
    }
}

bool is_exact(const Solid& solid)
{
    std::vector<const Node*> open{&solid.node()};
    std::unordered_set<const Node*> seen;
    while (!open.empty()) {
        const Node* next = open.back();
        open.pop_back();
        if (!seen.insert(next).second) continue;
        const auto* leaf = std::get_if<Freeform>(&next->shape);
        if (leaf && !leaf->source->has_exact_field()) return false;
        for (const Solid& part : parts_of(*next)) open.push_back(&part.node());
    }
    return true;
}

std::shared_ptr<const Implicit> solid_field(const Solid& solid)
{
    if (has_formula(solid)) return std::make_shared<CsgField>(solid);
    return field_of(solid, Transform{}, 0);
}

std::optional<Vec3> to_zero(const Implicit& field, Vec3 x)
{
    constexpr int kSteps = 12;
    const std::int32_t piece = field.piece(x);
    if (piece < 0) return std::nullopt;
    for (int step = 0; step < kSteps; ++step) {
        const Vec3 g = field.piece_gradient(piece, x);
        const Vec3 move = field.piece_value(piece, x) / dot(g, g) * g;
        if (!is_finite(move)) return std::nullopt;
        x -= move;
        if (norm(move) <= 1e-14 * norm(x)) break;
    }
    return x;
}

struct SolidSurface::Data {
    IndexedMesh mesh;
    double bound = 0.0;
    std::optional<MeshTree> tree;
    std::shared_ptr<const Implicit> field;

    // The root of the function within `reach` of t along the ray, if it has one sign before and
    // another after it.
    double polished(const Vec3& origin, const Vec3& direction, double t, double reach) const
    {
        double low = t - reach, high = t + reach;
        const auto inside = [&](double at) { return field->value(origin + at * direction) <= 0.0; };
        const bool before = inside(low);
        if (before == inside(high)) return t;
        for (int step = 0; step < 60; ++step) {
            const double middle = 0.5 * (low + high);
            if (!(low < middle && middle < high)) break;
            (inside(middle) == before ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }
};

SolidSurface::SolidSurface(const Solid& solid)
{
    auto data = std::make_unique<Data>();
    MeshOptions options;
    options.tolerance = kQueryTolerance * require_bounded(solid).diagonal();
    options.measure = false;
    if (!solid.is_empty() && *options.tolerance > 0.0) {
        MeshedSolid made = mesh_solid(solid, options);
        data->mesh = std::move(made.mesh);
        data->bound = made.error.bound;
    }
    data->tree.emplace(data->mesh);
    data->field = solid_field(solid);
    data_ = std::move(data);
}

SolidSurface::~SolidSurface() = default;

std::vector<SolidHit> SolidSurface::ray_cast(const Vec3& origin, const Vec3& direction) const
{
    std::vector<SolidHit> hits;
    const double length = norm(direction);
    // Roots come in pairs at every face that is passed; those of one crossing are one.
    for (const RayHit& hit : data_->tree->ray_hits(origin, direction)) {
        const bool entering = !hit.leaves;
        const Triangle& f = data_->mesh.faces[hit.face];
        const Vec3& a = data_->mesh.vertices[f[0]];
        Vec3 normal =
            normalized(cross(data_->mesh.vertices[f[1]] - a, data_->mesh.vertices[f[2]] - a));
        const double slope = std::max(std::fabs(dot(normal, direction)) / length, 0.125);
        const double t =
            data_->polished(origin, direction, hit.t, 2.0 * data_->bound / (slope * length));
        if (t < 0.0) continue;
        const Vec3 p = origin + t * direction;
        const Vec3 own = data_->field->gradient(p);
        if (norm(own) > 0.0 && dot(own, normal) > 0.0) normal = normalized(own);
        hits.push_back({t, p, normal, hit.face, entering, -1});
    }
    return hits;
}

}  // namespace genus
