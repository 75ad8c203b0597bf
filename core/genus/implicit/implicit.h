#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "genus/base/interval.h"
#include "genus/base/vec.h"

namespace genus {

/// A function F on space that describes a solid: inside where F <= 0, outside where F > 0.
class Implicit {
public:
    virtual ~Implicit() = default;

    virtual double value(const Vec3& p) const = 0;
    /// Of many points at once, the same numbers; `out` has as many places as there are points.
    virtual void values(std::span<const Vec3> points, std::span<double> out) const
    {
        for (std::size_t i = 0; i < points.size(); ++i) out[i] = value(points[i]);
    }
    /// Gradient; where F has a crease, that of one of its branches.
    virtual Vec3 gradient(const Vec3& p) const = 0;
    /// Holds F(p) for every p of the box.
    virtual Interval bound(const Box3& box) const = 0;
    /// Holds the gradient of every branch that is active somewhere in the box.
    virtual IntervalVec3 gradient_bound(const Box3& box) const = 0;

    /// The same function for points of the box only, quicker to evaluate there: same values and
    /// gradients, bounds at least as tight. Null if it would not be quicker. Refers to this one.
    virtual std::shared_ptr<const Implicit> within(const Box3&) const { return nullptr; }

    // A function with creases is made of smooth pieces: at every point F is one of them or its
    // negative. A smooth function is its own only piece.

    /// The number of the piece that gives the value at p.
    virtual std::int32_t piece(const Vec3&) const { return 0; }
    virtual double piece_value(std::int32_t, const Vec3& p) const { return value(p); }
    virtual Vec3 piece_gradient(std::int32_t, const Vec3& p) const { return gradient(p); }
};

}  // namespace genus
