#include "genus/model/fine_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/cut_edges.h"
#include "genus/model/cut_face.h"

namespace genus {

namespace {

constexpr double kEdgeShare = 0.75;  // of the tolerance, for the sagitta of an edge
constexpr double kFaceShare = 0.99;  // the same for a face
constexpr double kFar = 8.0;         // the guessed number of triangles is trusted to this factor

// Cuts the faces, the points on their edges given, and puts all in one mesh.
class CutFaces {
public:
    CutFaces(const SurfaceMesh& coarse, const CutEdges& edges,
             const std::vector<SurfaceForm>& forms, double tolerance, std::int64_t max_triangles)
        : coarse_(coarse),
          edges_(edges),
          forms_(forms),
          tolerance_(tolerance),
          max_triangles_(max_triangles),
          parts_(coarse.mesh.n_faces())
    {
    }

    // Returns the faces that could not be cut.
    std::vector<std::int32_t> run()
    {
        parallel_for(parts_.size(), 16, [&](std::size_t begin, std::size_t end) {
            CutFace cut(kFaceShare * tolerance_, max_triangles_);
            std::vector<FinePoint> border;
            for (std::size_t f = begin; f < end; ++f) {
                current_progress().check();
                parts_[f].is_cut = cut_face(f, cut, border);
            }
        });
        std::vector<std::int32_t> stuck;
        for (std::size_t f = 0; f < parts_.size(); ++f)
            if (!parts_[f].is_cut) stuck.push_back(static_cast<std::int32_t>(f));
        return stuck;
    }

    void put_into(FineMesh& fine) const
    {
        make_room(fine);
        put_border(fine);
        reach_over_border(fine);
        parallel_for(parts_.size(), 64, [&](std::size_t begin, std::size_t end) {
            std::vector<std::int32_t> number;
            for (std::size_t f = begin; f < end; ++f) put_part(f, fine, number);
        });
    }

private:
    struct Part {
        std::vector<FinePoint> inner;
        std::vector<Triangle> faces;
        std::vector<std::array<double, 2>> reaches;  // of the border first
        bool is_cut = false;
    };

    // Calls take(number, point, place) for the vertices on the border of a face, in its order.
    template <class Take>
    void visit_border(std::size_t f, Take&& take) const
    {
        for (std::int32_t i = 0; i < 3; ++i) {
            const std::int32_t side = edges_.sides().first(f) + i;
            const std::int32_t corner = edges_.sides().from(side);
            const auto e = static_cast<std::size_t>(edges_.edge(side));
            const std::vector<BorderPoint>& points = edges_.points(e);
            const auto count = static_cast<std::int32_t>(points.size());
            const auto place = [&](std::int32_t k) {
                const double t = static_cast<double>(k) / (count + 1);
                return i == 0   ? Weights{t, 0.0}
                       : i == 1 ? Weights{1.0 - t, t}
                                : Weights{0.0, 1.0 - t};
            };
            take(corner, edges_.at_vertex(corner), place(0));
            for (std::int32_t k = 0; k < count; ++k) {
                const std::int32_t at = edges_.runs_along(side) ? k : count - 1 - k;
                take(static_cast<std::int32_t>(edges_.first(e)) + at, points[at], place(k + 1));
            }
        }
    }

    bool cut_face(std::size_t f, CutFace& cut, std::vector<FinePoint>& border)
    {
        border.clear();
        visit_border(f, [&](std::int32_t, const BorderPoint& p, const Weights& place) {
            border.push_back({p.at, p.direction, place, p.room});
        });
        std::array<std::int32_t, 3> pieces;
        bool any_curve = false;
        for (std::int32_t i = 0; i < 3; ++i) {
            const auto e = static_cast<std::size_t>(edges_.edge(edges_.sides().first(f) + i));
            pieces[i] = 1 + static_cast<std::int32_t>(edges_.points(e).size());
            any_curve = any_curve || edges_.surfaces(e)[1] >= 0;
        }
        const std::int32_t label = coarse_.surface_of_face[f];
        if (!cut.run(forms_[label >> 1], (label & 1) != 0, border, pieces, any_curve)) return false;
        Part& part = parts_[f];
        part.inner.assign(cut.points().begin() + cut.n_border(), cut.points().end());
        part.faces = cut.faces();
        part.reaches = cut.reaches();
        n_triangles_ += static_cast<std::int64_t>(part.faces.size());
        if (n_triangles_ > max_triangles_)
            throw ToleranceNotMet("mesh: more than max_triangles triangles are needed", tolerance_,
                                  std::numeric_limits<double>::infinity(), {});
        return true;
    }

    void make_room(FineMesh& fine) const
    {
        const std::size_t n = parts_.size();
        fine.first_face.assign(n + 1, 0);
        fine.first_vertex.assign(n + 1, edges_.n_vertices());
        for (std::size_t f = 0; f < n; ++f) {
            fine.first_vertex[f + 1] =
                fine.first_vertex[f] + static_cast<std::int64_t>(parts_[f].inner.size());
            fine.first_face[f + 1] =
                fine.first_face[f] + static_cast<std::int64_t>(parts_[f].faces.size());
        }
        const std::int64_t n_vertices = fine.first_vertex[n];
        require(n_vertices <= std::numeric_limits<std::int32_t>::max(), "mesh: too many vertices");
        SurfaceMesh& s = fine.surface;
        s.mesh.vertices.resize(n_vertices);
        fine.direction.resize(n_vertices);
        fine.border_shell.resize(edges_.n_vertices());
        fine.place.resize(n_vertices - edges_.n_vertices());
        s.surfaces_of_vertex.resize(n_vertices);
        s.cell_size.resize(n_vertices);
        s.mesh.faces.resize(fine.first_face[n]);
        s.surface_of_face.resize(fine.first_face[n]);
        fine.reach.resize(n_vertices);
    }

    double cell_size(std::size_t f) const
    {
        const Triangle& t = coarse_.mesh.faces[f];
        return std::min(
            {coarse_.cell_size[t[0]], coarse_.cell_size[t[1]], coarse_.cell_size[t[2]]});
    }

    void put_border(FineMesh& fine) const
    {
        const auto put = [&](std::int64_t v, const BorderPoint& p,
                             const std::array<std::int32_t, 3>& on) {
            fine.surface.mesh.vertices[v] = p.at;
            fine.surface.surfaces_of_vertex[v] = on;
            fine.direction[v] = p.direction;
            fine.border_shell[v] = p.shell;
        };
        std::vector<double>& size = fine.surface.cell_size;
        std::copy(coarse_.cell_size.begin(), coarse_.cell_size.end(), size.begin());
        for (std::size_t v = 0; v < coarse_.mesh.n_vertices(); ++v)
            put(static_cast<std::int64_t>(v), edges_.at_vertex(static_cast<std::int32_t>(v)),
                coarse_.surfaces_of_vertex[v]);
        for (std::size_t e = 0; e < edges_.n_edges(); ++e)
            for (std::size_t k = 0; k < edges_.points(e).size(); ++k)
                put(edges_.first(e) + static_cast<std::int64_t>(k), edges_.points(e)[k],
                    edges_.surfaces(e));
    }

    // What must be known of all faces at an edge.
    void reach_over_border(FineMesh& fine) const
    {
        const auto n_coarse = static_cast<std::int32_t>(coarse_.mesh.n_vertices());
        for (std::size_t f = 0; f < parts_.size(); ++f) {
            const double size = cell_size(f);
            const std::array<double, 2>* reach = parts_[f].reaches.data();
            visit_border(f, [&](std::int32_t v, const BorderPoint&, const Weights&) {
                for (const std::size_t side : {0u, 1u})
                    fine.reach[v][side] = std::max(fine.reach[v][side], (*reach)[side]);
                ++reach;
                if (v >= n_coarse) fine.surface.cell_size[v] = size;
            });
        }
    }

    void put_part(std::size_t f, FineMesh& fine, std::vector<std::int32_t>& number) const
    {
        const Part& part = parts_[f];
        SurfaceMesh& s = fine.surface;
        const std::int32_t label = coarse_.surface_of_face[f];
        const double size = cell_size(f);
        number.clear();
        visit_border(
            f, [&](std::int32_t v, const BorderPoint&, const Weights&) { number.push_back(v); });
        std::int64_t v = fine.first_vertex[f];
        for (const FinePoint& p : part.inner) {
            s.mesh.vertices[v] = p.at;
            s.surfaces_of_vertex[v] = {label >> 1, -1, -1};
            s.cell_size[v] = size;
            fine.direction[v] = p.direction;
            fine.place[v - edges_.n_vertices()] = p.place;
            fine.reach[v] = part.reaches[number.size()];
            number.push_back(static_cast<std::int32_t>(v));
            ++v;
        }
        std::int64_t face = fine.first_face[f];
        for (const Triangle& t : part.faces) {
            s.mesh.faces[face] = {number[t[0]], number[t[1]], number[t[2]]};
            s.surface_of_face[face] = label;
            ++face;
        }
    }

    const SurfaceMesh& coarse_;
    const CutEdges& edges_;
    const std::vector<SurfaceForm>& forms_;
    double tolerance_;
    std::int64_t max_triangles_;
    std::vector<Part> parts_;  // one a face of the coarse mesh
    std::atomic<std::int64_t> n_triangles_{0};
};

}  // namespace

FineMesh cut_finely(const SurfaceMesh& coarse, const Sandwich& sandwich, const CoarseShell& shell,
                    const std::vector<SurfaceForm>& forms, double tolerance,
                    std::int64_t max_triangles)
{
    FineMesh fine;
    const std::vector<Vec3> directions = corner_directions(coarse, sandwich, forms, fine.stuck);
    if (!fine.stuck.empty()) return fine;
    CutEdges edges(coarse, shell, forms, directions, kEdgeShare * tolerance);
    if (const double expected = edges.expected(), most = static_cast<double>(max_triangles);
        !(expected <= kFar * most))
        throw ToleranceNotMet("mesh: about " + to_text(std::round(expected * 1e-6)) +
                                  " million triangles are needed, max_triangles is " +
                                  std::to_string(max_triangles),
                              tolerance, tolerance * expected / most, {});
    fine.stuck = edges.run();
    if (!fine.stuck.empty()) return fine;
    CutFaces faces(coarse, edges, forms, tolerance, max_triangles);
    fine.stuck = faces.run();
    if (fine.stuck.empty()) faces.put_into(fine);
    return fine;
}

}  // namespace genus
