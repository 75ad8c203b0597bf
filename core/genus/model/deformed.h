#pragma once

#include "genus/deform/ffd.h"
#include "genus/model/solid.h"

namespace genus {

/// The image of a solid under a free-form deformation.
///
/// It is meshed in two ways that share nothing but the lattice. Through the mesh (method auto and
/// in booleans): a mesh of the solid within a part of the tolerance, its triangles halved until
/// their images are flat enough, see deformed_within. Through the inverse map (methods emc and mc):
/// the function of the solid at the place that the map takes to a point, by Newton's method from
/// boxes of the lattice whose image may hold the point; marching cubes on that. The vertices of
/// the mesh so found are taken back, where they are shown to be near the solid, both ways, as any
/// mesh of it is (see certify; for solids without a formula beside a certified mesh of them); what
/// the map does to that distance, and between vertices, is bounded from its control points.
///
/// Either bound is called certified if the proofs for the solid itself succeed, the Jacobian is
/// positive, and no two points of the solid are taken to one place (see Lattice::one_to_one).
///
/// Meshing throws InvalidInput with the place if the lattice turns space inside out, or if the
/// solid reaches over a border that it tears; an image that runs into itself is united.
/// Throws InvalidInput if the solid is unbounded.
///
/// Implements [sederberg1986]; the inverse map by Newton and, for its cells, the hull of their
/// control points.
Solid deformed(const Solid& solid, const Lattice& lattice);

}  // namespace genus
