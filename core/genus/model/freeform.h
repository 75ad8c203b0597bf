#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "genus/base/box.h"
#include "genus/implicit/implicit.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// A solid that is no formula: it knows how to make a closed mesh of itself within a tolerance. The
/// leaf of a tree that stands for patches, or for a deformed solid.
class FreeformSource {
public:
    virtual ~FreeformSource() = default;

    struct Limits {
        std::int64_t max_triangles = 20'000'000;
        bool measure = false;
        bool to_surface = false;  // make that of the result
    };
    /// A point of the exact surface near one of the mesh, not always the nearest; nothing where
    /// none is found.
    using ToSurface = std::function<std::optional<Vec3>(const Vec3&)>;
    struct Meshed {
        IndexedMesh mesh;
        double bound = 0.0;  // distance to the exact surface, both ways
        bool certified = false;
        double measured = 0.0;  // found by sampling, where asked for
        ToSurface to_surface;   // where asked for, if there is one
        std::string doubt;      // what is not proven, unless it is certified
    };

    /// Holds the solid.
    virtual Box3 bounds() const = 0;
    virtual std::string describe() const = 0;
    /// Equal sources hash alike.
    virtual std::uint64_t hash() const = 0;
    virtual bool equals(const FreeformSource& other) const = 0;
    /// Closed and oriented; parts of it may cross each other, then all that they hold is meant.
    /// Throws InvalidInput where there is no closed surface, ToleranceNotMet.
    virtual Meshed mesh(double tolerance, const Limits& limits) const = 0;
    /// A function that is negative inside; from it, meshes by marching cubes as an independent
    /// second way. Null where there is none.
    virtual std::shared_ptr<const Implicit> field() const { return nullptr; }
    /// True if it vanishes on the surface itself, not on a mesh near it.
    virtual bool has_exact_field() const { return false; }
    /// Of a mesh made from that function: a distance, not above `tolerance`, beyond which no point
    /// of either surface is from the other. Nothing where that is not proven.
    virtual std::optional<double> proven_distance(const IndexedMesh&, double /*tolerance*/) const
    {
        return std::nullopt;
    }
    /// Of such a mesh: largest distance found by sampling, both ways.
    virtual double sampled_distance(const IndexedMesh&) const { return 0.0; }
};

}  // namespace genus
