#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "genus/base/box.h"
#include "genus/base/transform.h"
#include "genus/implicit/function.h"
#include "genus/implicit/quadric.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

struct Node;
class FreeformSource;

/// A solid: a shared, immutable tree of primitives, transforms and operators. Copies share; a
/// constructor only checks its arguments and notes bounds and hash, no geometry is made. The
/// default solid is empty. Closed: its border belongs to it.
class Solid {
public:
    Solid();
    explicit Solid(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

    const Node& node() const { return *node_; }
    bool is_empty() const;
    /// A box that holds the solid, with infinite sides where the tree shows no bound. Not always
    /// the tightest: a difference has the bounds of its first operand.
    const Box3& bounds() const;
    /// Equal trees hash alike.
    std::uint64_t hash() const;
    bool shares_node_with(const Solid& other) const { return node_ == other.node_; }

private:
    std::shared_ptr<const Node> node_;
};

/// Equal trees: same shapes, numbers and order. O(nodes that are not shared).
bool operator==(const Solid& a, const Solid& b);

// Shapes. `fragments` is 0 for the exact round shape, else the number of sides of the polyhedron
// that the text language builds for it.

struct Empty {
    bool operator==(const Empty&) const = default;
};
struct Cube {
    Vec3 size;
    bool center = false;
    bool operator==(const Cube&) const = default;
};
struct Sphere {
    double r;
    int fragments = 0;
    bool operator==(const Sphere&) const = default;
};
struct Ellipsoid {
    Vec3 radii;
    bool operator==(const Ellipsoid&) const = default;
};
/// Cylinder, frustum or cone along z, radius r1 at the bottom, r2 at the top.
struct Cylinder {
    double h, r1, r2;
    bool center = false;
    int fragments = 0;
    bool operator==(const Cylinder&) const = default;
};
struct TorusShape {
    double R, r;  // centre circle in the xy plane; 0 < r < R
    bool operator==(const TorusShape&) const = default;
};
/// normal . p <= offset.
struct HalfSpace {
    Vec3 normal;
    double offset;
    bool operator==(const HalfSpace&) const = default;
};
/// Any quadric, cut to `bounds` where given.
struct QuadricShape {
    Quadric surface;
    std::optional<Box3> bounds;
    bool operator==(const QuadricShape&) const = default;
};
/// Where any function is not positive, cut to `bounds`.
struct ImplicitShape {
    std::shared_ptr<const Function> function;
    Box3 bounds;
    bool operator==(const ImplicitShape& o) const
    {
        return bounds == o.bounds && (function == o.function || *function == *o.function);
    }
};
struct Polyhedron {
    std::shared_ptr<const PolygonMesh> mesh;
    /// How far the mesh may be from a curved shape that it stands for.
    double deviation = 0.0;
    bool operator==(const Polyhedron& o) const
    {
        return deviation == o.deviation && (mesh == o.mesh || *mesh == *o.mesh);
    }
};

/// Patches, a deformed solid: see freeform.h.
struct Freeform {
    std::shared_ptr<const FreeformSource> source;
    bool operator==(const Freeform& o) const;
};

struct Union {
    std::vector<Solid> parts;
    bool operator==(const Union&) const = default;
};
struct Intersection {
    std::vector<Solid> parts;
    bool operator==(const Intersection&) const = default;
};
/// The first part less all others.
struct Difference {
    std::vector<Solid> parts;
    bool operator==(const Difference&) const = default;
};
struct Transformed {
    Solid part;
    Transform map;
    bool operator==(const Transformed&) const = default;
};
struct Colored {
    Solid part;
    Vec4 rgba;  // each in [0, 1]
    bool operator==(const Colored&) const = default;
};

using Shape = std::variant<Empty, Cube, Sphere, Ellipsoid, Cylinder, TorusShape, HalfSpace,
                           QuadricShape, ImplicitShape, Polyhedron, Freeform, Union, Intersection,
                           Difference, Transformed, Colored>;

struct Node {
    Shape shape;
    Box3 bounds;
    std::uint64_t hash;

    Node(Shape shape_, const Box3& bounds_, std::uint64_t hash_)
        : shape(std::move(shape_)), bounds(bounds_), hash(hash_)
    {
    }
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;
    /// Takes the tree below it apart without recursion, so that no depth overflows the stack.
    ~Node();
};

/// The parts of an operator, the one part of a transform or colour; none for a primitive. Shares
/// the node's life.
std::span<const Solid> parts_of(const Node& node);

/// Box that holds the image of the solid under an affine map, rounded outward: tight for
/// primitives, the image of the box for operators.
Box3 image_bounds(const Solid& solid, const Transform& map);

/// What the user called a primitive, with its numbers: "cylinder(h = 30, r = 3)". For messages.
std::string describe(const Shape& shape);

// Constructors. Lengths are model units, angles degrees. All throw InvalidInput, naming function,
// argument and value, for numbers that are not finite or out of range.

Solid cube(const Vec3& size, bool center = false);
Solid sphere(double r, int fragments = 0);
Solid ellipsoid(const Vec3& radii);
/// One of the radii may be zero (a cone).
Solid cylinder(double h, double r1, double r2, bool center = false, int fragments = 0);
Solid torus(double R, double r);
Solid half_space(const Vec3& normal, double offset);
Solid quadric(const Quadric& surface, const std::optional<Box3>& bounds = std::nullopt);
/// All points of the box where the expression is not positive; what is undefined is outside.
Solid implicit(const Expression& expression, const Box3& bounds);
/// A closed mesh as a solid. Checks indices and finiteness only; whether it is closed and oriented
/// is checked by whoever needs it, with the face named.
/// `deviation`, if not zero, is the distance to the curved shape that the mesh stands for; it goes
/// into the error of what is made of it.
Solid polyhedron(PolygonMesh mesh, double deviation = 0.0);

/// The leaf of a source; patch_solid.h and deformed.h make such.
Solid freeform(std::shared_ptr<const FreeformSource> source);

/// Empty parts are dropped; the union of none is empty.
Solid unite(std::vector<Solid> parts);
/// The intersection of none is empty.
Solid intersect(std::vector<Solid> parts);
/// `parts[0]` less the rest. The difference of none is empty.
Solid subtract(std::vector<Solid> parts);

/// Throws InvalidInput if `map` is singular, not affine or not finite.
Solid transformed(const Solid& part, const Transform& map);
Solid colored(const Solid& part, const Vec4& rgba);

}  // namespace genus
