#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/indexed_mesh.h"
#include "genus/model/csg_field.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"
#include "genus/volume/bisection_tree.h"

namespace genus {

/// A triangle mesh of a CsgField that knows where it comes from.
struct SurfaceMesh {
    IndexedMesh mesh;
    /// The surfaces a vertex stands on, ascending, unused places -1: one inside a face, two on an
    /// edge between faces, three at a corner.
    std::vector<std::array<std::int32_t, 3>> surfaces_of_vertex;
    /// The surface of each face, 2 * number, plus 1 if the face is turned against its gradient.
    std::vector<std::int32_t> surface_of_face;
    /// Diameter of the smallest cell at a vertex.
    std::vector<double> cell_size;
    /// Where the solid touches itself along an edge, the mesh passes more than once. Vertices on
    /// such edges have a number of their place, the same for those at one point, all others -1.
    /// Empty if there is none.
    std::vector<std::int32_t> touch_of_vertex;
};

/// What the cells of a CellMesher must satisfy where the solid has its surface.
struct CellDemands {
    /// Largest distance, roughly, between a surface and its linear interpolant in a cell.
    double max_error = 0.0;
    /// Cosine of the largest angle between a normal in a cell and the mean normal, for cells with
    /// one surface and for cells with several.
    double min_cosine = 0.92, min_cosine_several = 0.98;
    /// In cells where two surfaces may touch, how far these may be from each other: their curve
    /// can take any course there.
    double touch = std::numeric_limits<double>::infinity();
    /// Cells are not cut below this size, whatever else is asked.
    double min_size = 0.0;
    /// Where more than this many cells of less than twenty times that size would be cut, cutting
    /// leads nowhere.
    std::int64_t max_small = std::numeric_limits<std::int64_t>::max();
    /// Places where curved cells, and cells with several surfaces, must not be larger than this;
    /// the smallest counts.
    std::vector<std::pair<Box3, double>> finer;
};

/// Meshes a CsgField over adaptive tetrahedra. In each tetrahedron every surface is replaced by the
/// linear function with its values at the corners, and the formula is evaluated on these: planes
/// come out exact at any cell size, as many sharp edges and corners as there are in a cell come
/// out in the right combination, and neighbours agree, because they see the same numbers on the
/// face between them. Which crossing comes first on an edge and which lines cross in a face is
/// decided exactly, ties by a shift of each surface by its own infinitesimal.
///
/// Cells in which the Bernstein bounds settle the formula are passed over, so time and memory are
/// proportional to the cells at the surface.
///
/// Implements [du2022], sections 3 and 4, with constructive solid geometry evaluated on the
/// pieces; the cells are those of [maubach1995].
class CellMesher {
public:
    /// `box` must hold the solid. References are kept.
    CellMesher(const SignFormula& formula, const std::vector<SurfaceForm>& forms, const Box3& box);

    /// Cuts cells until all meet the demands. Cells once cut stay so. Throws ToleranceNotMet if
    /// that takes more than `max_cells`, or more small ones than is said.
    void refine(const CellDemands& demands, std::int64_t max_cells);

    /// The surface in the present cells. Closed, unless rounding inside a cell with four or more
    /// surfaces near one point decided against itself; the caller checks.
    SurfaceMesh extract() const;

    const Box3& cube() const { return cube_; }
    /// The box and step of the lattice in which `refine` works.
    std::size_t n_splits() const { return tree_.n_splits(); }

private:
    Vec3 position(const LatticePoint& p) const;
    std::array<Vec3, 4> positions(const LatticeTet& tet) const;

    const SignFormula& formula_;
    const std::vector<SurfaceForm>& forms_;
    Box3 cube_;
    double step_ = 0.0;
    BisectionTree tree_;
    BoxTree finer_;  // over CellDemands::finer, for the time of a refine

    friend class CellWalk;
};

/// The cube, larger than `box` and placed askew, in which the cells live: model planes then do not
/// coincide with cell walls.
Box3 cell_cube(const Box3& box);

}  // namespace genus
