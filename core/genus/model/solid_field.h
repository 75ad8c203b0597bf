#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "genus/implicit/implicit.h"
#include "genus/model/solid.h"

namespace genus {

struct SolidHit;

/// A function that is negative inside any bounded solid: a CsgField where the tree is one, else
/// the minimum or maximum of those of its parts. A deformed solid has the function of what was
/// deformed, at the place that the inverse map finds; a polyhedron that is not convex has the
/// signed distance, exact; a solid of patches the signed distance to a mesh within 1/4096 of the
/// diagonal of its box, so that points closer to the surface than that may be told to lie on the
/// wrong side.
///
/// Throws InvalidInput where a shape is no closed solid.
std::shared_ptr<const Implicit> solid_field(const Solid& solid);

/// True if CsgField takes the tree as it stands.
bool has_formula(const Solid& solid);
/// True if the function is that of the solid itself, not of a mesh near it.
bool is_exact(const Solid& solid);

/// The place where the piece that is active at x vanishes, by Newton's steps along its gradient;
/// nothing if they fail.
std::optional<Vec3> to_zero(const Implicit& field, Vec3 x);

/// A solid without a formula, for rays: a certified mesh within 1/4096 of the diagonal of its box
/// finds the place, the function of the solid then settles the last digits.
/// What is thinner than that may be missed.
class SolidSurface {
public:
    explicit SolidSurface(const Solid& solid);
    ~SolidSurface();

    /// As ray_cast of queries.h; `surface` of a hit is the number of a face of the mesh.
    std::vector<SolidHit> ray_cast(const Vec3& origin, const Vec3& direction) const;

private:
    struct Data;
    std::unique_ptr<const Data> data_;
};

}  // namespace genus
