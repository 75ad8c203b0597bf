#pragma once

#include <array>
#include <cstdint>

#include "genus/mesh/indexed_mesh.h"
#include "genus/model/certificate.h"

namespace genus {

/// A place in a triangle: the weights of its second and third corner.
using Weights = std::array<double, 2>;

/// A place on the inner and the outer mesh of a shell.
using ShellPoints = std::array<Vec3, 2>;

/// Two meshes K- and K+ on either side of a coarse one, with its numbering: what lies between them
/// as `proven_embedded` says does not cross itself. Unlike the meshes of a sandwich they need not
/// lie inside and outside of the solid, so they may be as far apart as the mesh has room for.
struct CoarseShell {
    IndexedMesh inner, outer;

    ShellPoints at(std::int32_t v) const { return {inner.vertices[v], outer.vertices[v]}; }
};

/// The vertices move along the fibres of the sandwich: a share of the shortest edge there, or
/// beyond the sandwich where that is thicker.
CoarseShell shell_round(const SurfaceMesh& coarse, const Sandwich& sandwich);

}  // namespace genus
