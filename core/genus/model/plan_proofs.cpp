#include "genus/model/plan_proofs.h"

#include <vector>

#include "genus/base/error.h"
#include "genus/base/halves.h"
#include "genus/model/csg_lowering.h"

namespace genus {
namespace {

constexpr int kMostCells = 256;
constexpr std::int64_t kMostLeaves = 64;
constexpr std::size_t kMostFaces = 256;

/// True if `holds` says so for every cell of a subdivision of `box`, found by halving the longest
/// side of cells for which it does not, as long as there are few of them. `fails_at` knows points
/// that disprove it.
template <class Holds, class Fails>
bool holds_everywhere(const Box3& box, Holds holds, Fails fails_at)
{
    if (box.empty()) return true;
    if (!box.bounded()) return holds(box);
    std::vector<Box3> open{box};
    for (int cells = 0; !open.empty(); ++cells) {
        if (cells == kMostCells) return false;
        const Box3 cell = open.back();
        open.pop_back();
        if (holds(cell)) continue;
        if (fails_at(cell.center())) return false;
        const std::size_t axis = longest_axis(cell.size());
        const double middle = cell.center()[axis];
        if (!(cell.min[axis] < middle && middle < cell.max[axis])) return false;
        const auto [low, high] = halves(cell, axis);
        open.push_back(high);
        open.push_back(low);
    }
    return true;
}

bool has_no_small_formula(const Solid& solid)
{
    std::vector<const Node*> open{&solid.node()};
    while (!open.empty()) {
        const Node* node = open.back();
        open.pop_back();
        if (std::holds_alternative<Freeform>(node->shape)) return true;
        if (const auto* s = std::get_if<Polyhedron>(&node->shape))
            if (s->mesh->n_faces() > kMostFaces) return true;
        if (const auto* s = std::get_if<Sphere>(&node->shape))
            if (s->fragments > 24) return true;
        if (const auto* s = std::get_if<Cylinder>(&node->shape))
            if (s->fragments > 250) return true;
        for (const Solid& part : parts_of(*node)) open.push_back(&part.node());
    }
    return false;
}

/// A point inside the solid, where one is known without work: the middle of a convex leaf.
std::optional<Vec3> middle_of(const Solid& solid)
{
    const auto [node, map] = below_transforms(solid.node());
    if (const auto* s = std::get_if<Cube>(&node->shape))
        return apply(map, s->center ? Vec3{} : 0.5 * s->size);
    if (const auto* s = std::get_if<Cylinder>(&node->shape))
        return apply(map, Vec3{{0.0, 0.0, s->center ? 0.0 : 0.5 * s->h}});
    if (std::holds_alternative<Sphere>(node->shape)) return apply(map, Vec3{});
    return std::nullopt;
}

}  // namespace

const CsgField* FieldProof::field()
{
    if (!tried_) {
        tried_ = true;
        if (leaves_ > kMostLeaves || has_no_small_formula(solid_)) return nullptr;
        try {
            field_.emplace(solid_);
        } catch (const InvalidInput&) {
            // Not a function of space: a polyhedron that is not convex. Nothing is proven of it
            // here, and it is no error of the plan.
        }
    }
    return field_ ? &*field_ : nullptr;
}

bool FieldProof::disjoint(std::span<FieldProof> solids, const Box3& box)
{
    // The middle of one, if no other is known to keep away from it, disproves it before the field
    // of that one is made.
    for (std::size_t k = solids.size(); k-- > 0;) {
        const std::optional<Vec3> middle = middle_of(solids[k].solid_);
        if (!middle || !box.contains(*middle)) continue;
        bool alone = false;
        for (std::size_t i = 0; i < solids.size() && !alone; ++i)
            alone = i != k && solids[i].field() && solids[i].field()->value(*middle) > 0.0;
        if (!alone) return false;
    }
    const auto outside_one = [&](const Box3& cell) {
        for (FieldProof& solid : solids)
            if (solid.field() && solid.field()->bound(cell).lo > 0.0) return true;
        return false;
    };
    const auto inside_all = [&](const Vec3& p) {
        for (FieldProof& solid : solids)
            if (!solid.field() || solid.field()->value(p) > 0.0) return false;
        return true;
    };
    return holds_everywhere(box, outside_one, inside_all);
}

bool FieldProof::inside(FieldProof& inner, FieldProof& outer, const Box3& box)
{
    const CsgField *in = inner.field(), *out = in ? outer.field() : nullptr;
    if (!in || !out) return false;
    return holds_everywhere(
        box,
        [&](const Box3& cell) { return in->bound(cell).lo > 0.0 || out->bound(cell).hi <= 0.0; },
        [&](const Vec3& p) { return in->value(p) <= 0.0 && out->value(p) > 0.0; });
}

bool FieldProof::fills(const Box3& box)
{
    const CsgField* own = field();
    return own && holds_everywhere(
                      box, [&](const Box3& cell) { return own->bound(cell).hi <= 0.0; },
                      [&](const Vec3& p) { return own->value(p) > 0.0; });
}

}  // namespace genus
