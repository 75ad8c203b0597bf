#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "genus/implicit/implicit.h"
#include "genus/implicit/quadric.h"
#include "genus/implicit/torus.h"
#include "genus/model/solid.h"

namespace genus {

/// A surface of the tree with transforms folded in: where F = 0. Gradients point outward.
struct Surface {
    enum class Kind { Plane, Quadric, Torus };
    Kind kind;
    Quadric quadric;                 // Plane and Quadric
    std::optional<Torus> torus;      // Torus: a placed torus
    std::string leaf;                // what the user called it, for messages: "cylinder 3"

    double value(const Vec3& p) const;
    Vec3 gradient(const Vec3& p) const;
    Interval bound(const Box3& box) const;
    IntervalVec3 gradient_bound(const Box3& box) const;
};

/// A tree of quadrics, tori and convex polyhedra as one function: union is min, intersection max,
/// complement the negative. Surfaces that bound the same set are kept once, so a pin and its hole
/// share one surface.
///
/// The formula is a list of instructions in order of evaluation; the last one is the result. A
/// term names a surface or an earlier instruction, negated or not.
///
/// Implements [ricci1973] (min and max); pruning by box as in [keeter2020], section 3.
class CsgField final : public Implicit {
public:
    struct Term {
        std::int32_t index;   // surface or instruction number
        bool is_surface;
        bool negated;
    };
    struct Instruction {
        bool is_max;          // max of the terms, else min
        std::vector<Term> terms;
    };

    /// Throws InvalidInput if a leaf cannot be written as a function: a polyhedron that is not
    /// convex. The text names it.
    explicit CsgField(const Solid& solid);

    const std::vector<Surface>& surfaces() const { return surfaces_; }
    const std::vector<Instruction>& instructions() const { return instructions_; }

    double value(const Vec3& p) const override;
    Vec3 gradient(const Vec3& p) const override;
    Interval bound(const Box3& box) const override;
    IntervalVec3 gradient_bound(const Box3& box) const override;

    /// Which surface gives the value at p, and with which sign.
    struct Active {
        std::int32_t surface;
        double sign;   // +1, or -1 where the surface enters negated
        double value;  // signed
    };
    Active active(const Vec3& p) const;

    /// The field cut down to what matters inside `box`: terms that the interval bounds prove never
    /// to decide are left out. Surface numbers stay those of this field. A field that is positive
    /// or negative throughout has no instructions left; `constant_sign` tells which.
    struct Pruned {
        std::vector<Instruction> instructions;
        int constant_sign = 0;  // -1 inside throughout, 1 outside throughout, 0 undecided
    };
    Pruned prune(const Box3& box) const;
    Pruned prune(const Pruned& coarser, const Box3& box) const;

private:
    std::vector<Surface> surfaces_;
    std::vector<Instruction> instructions_;
};

}  // namespace genus
