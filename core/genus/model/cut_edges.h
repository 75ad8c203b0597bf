#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "genus/mesh/sides.h"
#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/coarse_shell.h"
#include "genus/model/surface_form.h"

namespace genus {

/// A vertex of a fine mesh on an edge of the coarse one, or at its end; see FineMesh.
struct BorderPoint {
    Vec3 at, direction;
    ShellPoints shell;
    /// The largest offset along `direction`, as a share of what it is where that has length 1.
    double room = 1.0;
};

/// The fibre of the sandwich at each vertex of a coarse mesh, as long as its surfaces ask for.
/// Faces at vertices where a surface does not recede along it are added to `stuck`. O(faces).
std::vector<Vec3> corner_directions(const SurfaceMesh& coarse, const Sandwich& sandwich,
                                    const std::vector<SurfaceForm>& forms,
                                    std::vector<std::int32_t>& stuck);

/// The points that cut the edges of a coarse mesh, on their surface or on the curve of both, so
/// that no piece has a sagitta of more than `limit`, less where directions are long: the same for
/// the faces on both sides. References are kept.
class CutEdges {
public:
    CutEdges(const SurfaceMesh& coarse, const CoarseShell& shell,
             const std::vector<SurfaceForm>& forms, const std::vector<Vec3>& direction,
             double limit);

    /// About how many triangles it will be: a face with p, q and r pieces on its sides gets as many
    /// as the mean product of two of them.
    double expected() const;

    /// Cuts all edges. Returns the faces at edges with a point that cannot be placed or directed.
    /// O(points).
    std::vector<std::int32_t> run();

    BorderPoint at_vertex(std::int32_t v) const;
    const TriangleSides& sides() const { return sides_; }
    std::size_t n_edges() const { return points_.size(); }
    const std::vector<BorderPoint>& points(std::size_t e) const { return points_[e]; }
    /// The points are numbered edge by edge, after the vertices of the coarse mesh: the number of
    /// the first of an edge, and of all these vertices.
    std::int64_t first(std::size_t e) const { return first_[e]; }
    std::int64_t n_vertices() const { return first_.back(); }
    std::int32_t edge(std::int32_t side) const { return edge_of_side_[side]; }
    /// The edge runs the way of the first of its sides.
    bool runs_along(std::int32_t side) const
    {
        return table_.sides[table_.starts[edge(side)]] == side;
    }
    /// As SurfaceMesh::surfaces_of_vertex.
    std::array<std::int32_t, 3> surfaces(std::size_t e) const;

private:
    std::array<std::int32_t, 2> labels(std::size_t e) const;
    std::array<BorderPoint, 2> ends(std::size_t e) const;
    double limit(std::size_t e) const;
    double sagitta(std::size_t e, const Vec3& p, const Vec3& q) const;
    double first_guess(std::size_t e) const;
    bool cut(std::size_t e);
    std::optional<BorderPoint> on_surface(const Vec3& start, const Vec3& way,
                                          std::int32_t label) const;
    std::optional<Vec3> in_plane(const Vec3& start, const Vec3& along, std::int32_t s,
                                 std::int32_t t) const;
    std::optional<BorderPoint> on_curve(const Vec3& start, std::int32_t left, std::int32_t right,
                                        const Vec3& along) const;

    const SurfaceMesh& m_;
    const CoarseShell& shell_;
    const std::vector<SurfaceForm>& forms_;
    const std::vector<Vec3>& direction_;
    double limit_;
    TriangleSides sides_;
    EdgeTable table_;
    std::vector<std::int32_t> edge_of_side_;
    std::vector<double> guess_;  // of the pieces of each edge
    std::vector<std::vector<BorderPoint>> points_;
    std::vector<std::int64_t> first_;
};

}  // namespace genus
