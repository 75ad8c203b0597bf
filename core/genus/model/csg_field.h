#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "genus/implicit/function.h"
#include "genus/implicit/implicit.h"
#include "genus/implicit/quadric.h"
#include "genus/implicit/torus.h"
#include "genus/model/solid.h"

namespace genus {

/// A surface of the tree with transforms folded in: where F = 0. Gradients point outward.
///
/// F is scaled by a power of two, which changes no rounding, so that the longest gradient on the
/// leaf is between 0.7 and 1.5: values of different leaves then compare like distances.
struct Surface {
    enum class Kind { Plane, Quadric, Torus, Function };
    Kind kind;
    Quadric quadric;             // Plane and Quadric
    std::optional<Torus> torus;  // Torus: a placed torus
    double torus_scale = 1.0;    // F is this times the torus' own function
    std::string leaf;            // what the user called it, for messages: "cylinder(h = 3, r = 1)"
    std::shared_ptr<const Function> function{};  // Function: scaled already
    Box3 function_box{};                         // and where it is looked at: its leaf is within

    double value(const Vec3& p) const
    {
        if (kind == Kind::Function) return function->value(p);
        return kind == Kind::Torus ? torus_scale * torus->value(p) : quadric.value(p);
    }
    Vec3 gradient(const Vec3& p) const
    {
        if (kind == Kind::Function) return function->gradient(p);
        return kind == Kind::Torus ? torus_scale * torus->gradient(p) : quadric.gradient(p);
    }
    Interval bound(const Box3& box) const;
    IntervalVec3 gradient_bound(const Box3& box) const;
};

/// A tree of quadrics, tori, functions and convex polyhedra as one function: union is min,
/// intersection max, complement the negative. Surfaces that bound the same set are kept once, so a
/// pin and its hole share one surface, and so do the faces of two cubes side by side: their
/// coefficients may differ in the last few bits that rounding of the coordinates leaves open.
///
/// The formula is a list of instructions in order of evaluation; the last one is the result. A
/// term names a surface or an earlier instruction, negated or not. Nested instructions of one kind
/// are flattened. The empty solid has no instructions and the value +infinity.
///
/// Implements [ricci1973] (min and max); pruning by box as in [keeter2020], section 3.
class CsgField final : public Implicit {
public:
    struct Term {
        std::int32_t index;  // surface or instruction number
        bool is_surface;
        bool negated;
        bool operator==(const Term&) const = default;
    };
    struct Instruction {
        bool is_max;  // max of the terms, else min
        std::vector<Term> terms;
    };

    /// Throws InvalidInput if a leaf cannot be written as a function: a polyhedron that is not
    /// convex, or numbers whose squares overflow. The text names it. O(n log n) for n leaves.
    explicit CsgField(const Solid& solid);

    const std::vector<Surface>& surfaces() const { return surfaces_; }
    const std::vector<Instruction>& instructions() const { return instructions_; }

    double value(const Vec3& p) const override;
    Vec3 gradient(const Vec3& p) const override;
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;

    /// What is left of the field in the box, if that is less, and does not have one sign
    /// throughout.
    std::shared_ptr<const Implicit> within(const Box3& box) const override;

    /// The pieces are the surfaces, and of functions with creases their pieces; -1 where the field
    /// is constant or too many pieces are.
    std::int32_t piece(const Vec3& p) const override;
    double piece_value(std::int32_t piece, const Vec3& p) const override;
    Vec3 piece_gradient(std::int32_t piece, const Vec3& p) const override;

    /// Which surface gives the value at p, and with which sign. The surface is -1, the sign 0 and
    /// the value infinite where the field is constant.
    struct Active {
        std::int32_t surface;
        double sign;   // +1, or -1 where the surface enters negated
        double value;  // signed
    };
    Active active(const Vec3& p) const;

    /// The field cut down to what matters inside `box`: terms that the interval bounds prove never
    /// to decide are left out, so inside the box it has the same values, bit for bit. Surface
    /// numbers stay those of this field. A field that is positive or negative throughout has no
    /// instructions left; `constant_sign` tells which.
    struct Pruned {
        std::vector<Instruction> instructions;
        int constant_sign = 0;  // -1 inside throughout, 1 outside throughout, 0 undecided
    };
    Pruned prune(const Box3& box) const;
    Pruned prune(const Pruned& coarser, const Box3& box) const;

    // The same questions to a pruned field, inside its box. Without instructions the value is
    // infinite, of the sign that `constant_sign` says.
    double value(const Pruned& pruned, const Vec3& p) const;
    Vec3 gradient(const Pruned& pruned, const Vec3& p) const;
    Active active(const Pruned& pruned, const Vec3& p) const;
    Interval bound(const Pruned& pruned, const Box3& box) const;
    IntervalVec3 gradient_bound(const Pruned& pruned, const Box3& box) const;

    /// The surfaces that the instructions of `pruned` name, each once, ascending.
    static std::vector<std::int32_t> surfaces_of(const Pruned& pruned);

private:
    std::vector<Surface> surfaces_;
    std::vector<Instruction> instructions_;
};

}  // namespace genus
