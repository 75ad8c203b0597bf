#pragma once

#include <cmath>
#include <string>

#include "core/implicit/random_shapes.h"
#include "genus/model/solid.h"

namespace genus {

/// A leaf of any kind that a tree may have, bounded, of size about 1, under a random affine map.
inline Solid random_quadric_leaf(RandomShapes& random)
{
    const Box3 cut{Box3::filled(-1.0), Box3::filled(1.0)};
    const auto polynomial = [&](const std::array<double, 10>& c) {
        return quadric(Quadric::from_polynomial(c), cut);
    };
    const auto size = [&] { return random.in(0.3, 1.2); };
    Solid leaf;
    switch (random.below(13)) {
        case 0:
            leaf = sphere(size());
            break;
        case 1:
            leaf = ellipsoid({{size(), size(), size()}});
            break;
        case 2: {
            const double r = size();
            leaf = cylinder(random.in(0.5, 2.0), r, r, true);
            break;
        }
        case 3:
            leaf = cylinder(random.in(0.5, 2.0), size(), 0.0, true);  // cone
            break;
        case 4:
            leaf = cylinder(random.in(0.5, 2.0), size(), size(), true);  // frustum
            break;
        case 5:
            leaf = polynomial({1, random.in(0.5, 2), 0, 0, 0, 0, 0, 0, -1, -0.5});  // paraboloid
            break;
        case 6:
            leaf = polynomial({1, 1, -random.in(0.3, 1), 0, 0, 0, 0, 0, 0, -random.in(0.1, 0.4)});
            break;  // one sheet
        case 7:
            leaf = polynomial({1, 1, -random.in(1, 2), 0, 0, 0, 0, 0, 0, random.in(0.05, 0.2)});
            break;  // two sheets
        case 8:
            leaf = polynomial({1, -random.in(0.5, 2), 0, 0, 0, 0, 0, 0, -1, 0});  // saddle
            break;
        case 9:
            leaf = intersect({sphere(1.2), half_space(random.point(), random.in(-0.5, 0.5))});
            break;
        case 10:
            leaf = polynomial({1, -random.in(0.3, 3), 0, 0, 0, 0, 0, 0, 0, 0});  // plane pair
            break;
        case 11: {
            std::array<double, 10> ten;
            for (double& c : ten) c = random.in(-1, 1);
            leaf = polynomial(ten);
            break;
        }
        default: {
            const double r = random.in(0.1, 0.4);
            leaf = torus(random.in(1.5, 3.0) * r, r);
        }
    }
    return transformed(leaf, random.affine(1.6, 0.8));
}

/// A tree of `leaves` of them.
inline Solid random_quadric_tree(RandomShapes& random, int leaves)
{
    Solid tree = random_quadric_leaf(random);
    for (int i = 1; i < leaves; ++i) {
        const Solid leaf = random_quadric_leaf(random);
        const int op = random.below(5);
        tree = op < 2    ? unite({tree, leaf})
               : op == 2 ? intersect({tree, unite({leaf, random_quadric_leaf(random)})})
                         : subtract({tree, leaf});
    }
    return tree;
}

}  // namespace genus
