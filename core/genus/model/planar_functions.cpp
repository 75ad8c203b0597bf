#include "genus/model/planar_functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "genus/implicit/function.h"
#include "genus/implicit/half_space_of.h"
#include "genus/implicit/solid_parts.h"
#include "genus/mesh/hull.h"
#include "genus/model/leaf_mesh.h"

namespace genus {

namespace {

// The sum of two doubles, if that is one.
std::optional<double> exact_sum(double a, double b)
{
    const double sum = a + b, of_b = sum - a;
    if ((a - (sum - of_b)) + (b - of_b) != 0.0) return std::nullopt;
    return sum;
}

// Half-spaces within a cube about the origin, whose corners are powers of two.
class HalfSpaceCutter {
public:
    explicit HalfSpaceCutter(const Box3& box)
    {
        double reach = 0.0;
        for (std::size_t i = 0; i < 3; ++i)
            reach = std::max({reach, std::fabs(box.min[i]), std::fabs(box.max[i])});
        reach_ = std::exp2(std::ceil(std::log2(reach)) + 1.0);
    }

    Solid everything() const { return cube({{2.0 * reach_, 2.0 * reach_, 2.0 * reach_}}, true); }

    // normal . p <= offset. Nothing if a corner is no double.
    std::optional<Solid> half_space(const Vec3& normal, double offset) const
    {
        std::vector<Vec3> corners;
        for (unsigned c = 0; c < 8; ++c) {
            Vec3 p;
            for (std::size_t i = 0; i < 3; ++i) p[i] = (c >> i & 1) != 0 ? reach_ : -reach_;
            const auto own = height(normal, offset, p);
            if (!own) return std::nullopt;
            if (*own <= 0.0) corners.push_back(p);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if ((c >> axis & 1) != 0) continue;
                Vec3 q = p;
                q[axis] = reach_;
                const auto other = height(normal, offset, q);
                if (!other) return std::nullopt;
                if (!(std::min(*own, *other) < 0.0 && std::max(*own, *other) > 0.0)) continue;
                q[axis] = 0.0;
                const auto at_zero = height(normal, offset, q);
                if (!at_zero) return std::nullopt;
                q[axis] = -*at_zero / normal[axis];
                if (std::fma(normal[axis], q[axis], *at_zero) != 0.0) return std::nullopt;
                corners.push_back(q);
            }
        }
        PolygonMesh hull = convex_hull(corners);
        if (hull.n_faces() == 0) return Solid();
        return polyhedron(std::move(hull));
    }

private:
    // normal . p - offset where the coordinates of p are zero or plus or minus the reach.
    static std::optional<double> height(const Vec3& normal, double offset, const Vec3& p)
    {
        std::optional<double> sum = -offset;
        for (std::size_t i = 0; i < 3 && sum; ++i) sum = exact_sum(*sum, normal[i] * p[i]);
        return sum;
    }

    double reach_ = 1.0;
};

std::optional<Solid> as_polyhedra(const SmoothParts& parts, const HalfSpaceCutter& cutter)
{
    if (parts.kind == SmoothParts::Kind::Leaf) {
        if (const double* number = parts.leaf.number())
            return (parts.negated ? *number >= 0.0 : *number <= 0.0) ? cutter.everything()
                                                                     : Solid();
        const auto half = half_space_of(parts.leaf);
        if (!half) return std::nullopt;
        const auto c = half->polynomial();
        const double sign = parts.negated ? -1.0 : 1.0;
        return cutter.half_space(sign * Vec3{{c[6], c[7], c[8]}}, -sign * c[9]);
    }
    std::vector<Solid> solids;
    for (const SmoothParts& part : parts.parts) {
        auto solid = as_polyhedra(part, cutter);
        if (!solid) return std::nullopt;
        solids.push_back(std::move(*solid));
    }
    return parts.kind == SmoothParts::Kind::Min ? unite(std::move(solids))
                                                : intersect(std::move(solids));
}

PolygonMesh mesh_of(const Box3& box)
{
    std::vector<Vec3> corners;
    for (unsigned c = 0; c < 8; ++c) {
        Vec3 p = box.min;
        for (std::size_t i = 0; i < 3; ++i)
            if ((c >> i & 1) != 0) p[i] = box.max[i];
        corners.push_back(p);
    }
    return convex_hull(corners);
}

std::optional<Solid> as_polyhedra(const ImplicitShape& shape)
{
    const Box3& box = shape.bounds;
    const auto parts =
        as_polyhedra(solid_parts(shape.function->expression(), box), HalfSpaceCutter(box));
    if (!parts) return std::nullopt;
    return intersect({*parts, polyhedron(mesh_of(box))});
}

// The same operator on other parts.
Solid with_parts(const Shape& shape, std::vector<Solid> parts)
{
    if (std::holds_alternative<Union>(shape)) return unite(std::move(parts));
    if (std::holds_alternative<Intersection>(shape)) return intersect(std::move(parts));
    if (std::holds_alternative<Difference>(shape)) return subtract(std::move(parts));
    if (const auto* moved = std::get_if<Transformed>(&shape))
        return transformed(parts[0], moved->map);
    return colored(parts[0], std::get<Colored>(shape).rgba);
}

}  // namespace

std::optional<Solid> as_polyhedra(const Solid& solid)
{
    bool any_function = false;
    std::unordered_map<const Node*, Solid> done;
    std::vector<const Solid*> open{&solid};
    while (!open.empty()) {
        const Solid& next = *open.back();
        const Node* node = &next.node();
        const auto parts = parts_of(*node);
        std::vector<Solid> new_parts;
        for (const Solid& part : parts) {
            const auto at = done.find(&part.node());
            if (at == done.end())
                open.push_back(&part);
            else
                new_parts.push_back(at->second);
        }
        if (new_parts.size() < parts.size()) continue;
        open.pop_back();
        if (done.contains(node)) continue;
        if (!parts.empty()) {
            done.emplace(node, with_parts(node->shape, std::move(new_parts)));
        } else if (const auto* any = std::get_if<ImplicitShape>(&node->shape)) {
            auto written_out = as_polyhedra(*any);
            if (!written_out) return std::nullopt;
            any_function = true;
            done.emplace(node, std::move(*written_out));
        } else if (is_faceted(node->shape) || std::holds_alternative<Empty>(node->shape)) {
            done.emplace(node, next);
        } else {
            return std::nullopt;
        }
    }
    if (!any_function) return std::nullopt;
    return done.at(&solid.node());
}

}  // namespace genus
