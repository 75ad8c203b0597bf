#pragma once

#include <vector>

#include "genus/model/certificate.h"

namespace genus {

/// Where a surface is sought and what is known there.
struct SearchScene {
    const IndexedMesh& mesh;
    const IndexedMesh& outer;  // M+ and M- of a certificate
    const IndexedMesh& inner;
    std::vector<Box3> open;  // boxes of those of their faces that no way may come near
    const std::vector<SurfaceForm>& forms;
    double tolerance;
    bool strict;  // being near the mesh is not enough
};

/// The other half of a certificate: no point of the surface in the cube is far from the mesh. Boxes
/// are halved until each is off the surface, or has a way along which the formula changes its sign
/// between M- and M+, or lies near the mesh. Adds to the counts, what failed and the bound of `c`.
/// O(boxes log faces).
void find_surface_near(const SearchScene& scene, const Box3& cube, const SignFormula& formula,
                       Certificate& c);

}  // namespace genus
