#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "genus/base/transform.h"
#include "genus/model/solid.h"

namespace genus {

/// A primitive of a tree, and where the transforms above it put it.
struct PlacedLeaf {
    Solid leaf;
    Transform map;
};

/// The primitives of a tree as it orders them: depth first, the parts of an operator from left to
/// right. One that is shared by several operators comes once for each; empty solids are none.
/// Throws InvalidInput for more than 10^7. O(1) for each.
std::vector<PlacedLeaf> leaves_of(const Solid& solid);

/// What the user called each of them, "sphere(r = 2)". Transforms are not told.
std::vector<std::string> leaf_names(const Solid& solid);

/// Tells which primitive the border of a solid comes from.
class LeafFinder {
public:
    explicit LeafFinder(const Solid& solid);
    ~LeafFinder();

    /// The number, as leaves_of counts, of the leaf on whose border p is, in double precision, and
    /// which has the direction of this normal there; of several, as of a pin in its hole, the first
    /// without which the solid would be another one beside p. -1 if there are no leaves.
    /// O(log n), and a function of each leaf whose box holds p, made when first needed; O(n) where
    /// several share the border. Any number of threads may ask.
    std::int32_t at(const Vec3& p, const Vec3& normal) const;

private:
    struct Data;
    std::unique_ptr<Data> data_;
};

}  // namespace genus
