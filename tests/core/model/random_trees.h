#pragma once

#include <cmath>
#include <vector>

#include "core/implicit/random_shapes.h"
#include "genus/model/solid.h"

namespace genus {

/// Membership by the definition of each shape in its own coordinates, independent of quadrics and
/// of the library's own lowering: less than zero inside, greater outside, near zero undecided.
class MembershipOracle {
public:
    /// The value, and in `nearest` the least absolute value of any leaf met.
    double operator()(const Solid& solid, const Vec3& p)
    {
        nearest = 1e300;
        return at(solid, p);
    }

    double nearest = 1e300;

private:
    double at(const Solid& solid, const Vec3& p)
    {
        const Shape& shape = solid.node().shape;
        if (std::holds_alternative<Empty>(shape)) return 1e300;
        if (const auto* s = std::get_if<Colored>(&shape)) return at(s->part, p);
        if (const auto* s = std::get_if<Transformed>(&shape))
            return at(s->part, apply(inverse(s->map), p));
        if (std::holds_alternative<Union>(shape)) {
            double least = 1e300;
            for (const Solid& part : parts_of(solid.node())) least = std::fmin(least, at(part, p));
            return least;
        }
        if (std::holds_alternative<Intersection>(shape)) {
            double most = -1e300;
            for (const Solid& part : parts_of(solid.node())) most = std::fmax(most, at(part, p));
            return most;
        }
        if (std::holds_alternative<Difference>(shape)) {
            const auto parts = parts_of(solid.node());
            double most = at(parts[0], p);
            for (std::size_t i = 1; i < parts.size(); ++i) most = std::fmax(most, -at(parts[i], p));
            return most;
        }
        const double value = leaf(shape, p);
        nearest = std::fmin(nearest, std::fabs(value));
        return value;
    }

    static double slab(double x, double low, double high) { return std::fmax(x - high, low - x); }

    static double leaf(const Shape& shape, const Vec3& p)
    {
        const double from_axis = std::hypot(p[0], p[1]);
        if (const auto* s = std::get_if<Cube>(&shape)) {
            double most = -1e300;
            for (int i = 0; i < 3; ++i) {
                const double low = s->center ? -s->size[i] / 2 : 0.0;
                most = std::fmax(most, slab(p[i], low, low + s->size[i]));
            }
            return most;
        }
        if (const auto* s = std::get_if<Sphere>(&shape)) return norm(p) - s->r;
        if (const auto* s = std::get_if<Ellipsoid>(&shape))
            return std::hypot(p[0] / s->radii[0], p[1] / s->radii[1], p[2] / s->radii[2]) - 1.0;
        if (const auto* s = std::get_if<Cylinder>(&shape)) {
            const double low = s->center ? -s->h / 2 : 0.0;
            const double radius = s->r1 + (s->r2 - s->r1) * (p[2] - low) / s->h;
            return std::fmax(slab(p[2], low, low + s->h), from_axis - radius);
        }
        if (const auto* s = std::get_if<TorusShape>(&shape))
            return std::hypot(from_axis - s->R, p[2]) - s->r;
        if (const auto* s = std::get_if<HalfSpace>(&shape)) return dot(s->normal, p) - s->offset;
        return std::nan("");
    }
};

inline Solid random_leaf(RandomShapes& random, bool bounded = true)
{
    switch (random.below(bounded ? 6 : 7)) {
        case 0:
            return cube({{random.in(0.2, 2), random.in(0.2, 2), random.in(0.2, 2)}},
                        random.below(2));
        case 1:
            return sphere(random.in(0.2, 1.5));
        case 2:
            return ellipsoid({{random.in(0.2, 1.5), random.in(0.2, 1.5), random.in(0.2, 1.5)}});
        case 3: {
            const double r1 = random.below(4) == 0 ? 0.0 : random.in(0.2, 1);
            const double r2 = random.below(4) == 0 && r1 > 0 ? 0.0 : random.in(0.2, 1);
            return cylinder(random.in(0.2, 2), r1, random.below(2) || r1 == 0 ? r2 : r1,
                            random.below(2));
        }
        case 4:
            return torus(1.0, random.in(0.1, 0.6));
        case 5:
            return sphere(1.0);
        default:
            return half_space(random.point(), random.in(-1, 1));
    }
}

/// A tree with about `leaves` leaves; a few subtrees occur twice.
inline Solid random_tree(RandomShapes& random, int leaves, std::vector<Solid>& made,
                         bool bounded = true)
{
    Solid result;
    if (!made.empty() && random.below(6) == 0) {
        result = made[random.below(int(made.size()))];
    } else if (leaves <= 1) {
        result = random_leaf(random, bounded);
    } else {
        const int n = 2 + random.below(3);
        std::vector<Solid> parts;
        for (int i = 0; i < n; ++i)
            parts.push_back(random_tree(random, (leaves + n - 1) / n, made, bounded));
        const int op = random.below(4);
        result = op == 0   ? intersect(std::move(parts))
                 : op == 1 ? subtract(std::move(parts))
                           : unite(std::move(parts));
    }
    switch (random.below(5)) {
        case 0:
            result = transformed(result, translation(random.point(1.5)));
            break;
        case 1:
            result = transformed(result, random.affine(1.6, 1.0));
            break;
        case 2:
            result = transformed(result, rotation_z(90.0 * random.below(4)));
            break;
        case 3:
            result = colored(result, {{1, 0.5, 0, 1}});
            break;
        default:
            break;
    }
    made.push_back(result);
    return result;
}

inline Solid random_tree(RandomShapes& random, int leaves, bool bounded = true)
{
    std::vector<Solid> made;
    return random_tree(random, leaves, made, bounded);
}

}  // namespace genus
