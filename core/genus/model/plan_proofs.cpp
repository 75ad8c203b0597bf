#include "genus/model/plan_proofs.h"

#include <vector>

#include "genus/base/error.h"

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
        const Vec3 size = cell.size();
        const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
        const double middle = cell.center()[axis];
        if (!(cell.min[axis] < middle && middle < cell.max[axis])) return false;
        Box3 low = cell, high = cell;
        low.max[axis] = high.min[axis] = middle;
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

}  // namespace

FieldProof::FieldProof(const Solid& solid, std::int64_t leaves)
{
    if (leaves > kMostLeaves || has_no_small_formula(solid)) return;
    try {
        field_.emplace(solid);
    } catch (const InvalidInput&) {
        // Not a function of space: a polyhedron that is not convex. Nothing is proven of it here,
        // and it is no error of the plan.
    }
}

bool FieldProof::disjoint(std::span<const FieldProof> solids, const Box3& box)
{
    const auto outside_one = [&](const Box3& cell) {
        for (const FieldProof& solid : solids)
            if (solid.field_ && solid.field_->bound(cell).lo > 0.0) return true;
        return false;
    };
    const auto inside_all = [&](const Vec3& p) {
        for (const FieldProof& solid : solids)
            if (!solid.field_ || solid.field_->value(p) > 0.0) return false;
        return true;
    };
    return holds_everywhere(box, outside_one, inside_all);
}

bool FieldProof::inside(const FieldProof& inner, const FieldProof& outer, const Box3& box)
{
    if (!inner.field_ || !outer.field_) return false;
    return holds_everywhere(
        box,
        [&](const Box3& cell) {
            return inner.field_->bound(cell).lo > 0.0 || outer.field_->bound(cell).hi <= 0.0;
        },
        [&](const Vec3& p) {
            return inner.field_->value(p) <= 0.0 && outer.field_->value(p) > 0.0;
        });
}

bool FieldProof::fills(const Box3& box) const
{
    return field_ && holds_everywhere(
                         box, [&](const Box3& cell) { return field_->bound(cell).hi <= 0.0; },
                         [&](const Vec3& p) { return field_->value(p) > 0.0; });
}

}  // namespace genus
