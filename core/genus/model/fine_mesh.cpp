#include "genus/model/fine_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/sides.h"
#include "genus/model/cut_face.h"

namespace genus {

namespace {

constexpr double kEdgeShare = 0.75;      // of the tolerance, for the sagitta of an edge
constexpr double kFaceShare = 0.99;      // the same for a face
constexpr double kMostPieces = 1 << 22;  // of one edge
constexpr double kManyPieces = 64;
constexpr double kLongestWay = 16.0;  // of a direction

// A vertex on an edge of the coarse mesh, or at its end.
struct BorderPoint {
    Vec3 at, direction;
    ShellPoints shell;
    double room = 1.0;
};

// The points from which a point between two others came: affine along the way.
ShellPoints between(const ShellPoints& a, const ShellPoints& b, double t)
{
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
}

double room_for(const Vec3& direction)
{
    return std::min(1.0, 1.0 / norm(direction));
}

Vec3 outward(const std::vector<SurfaceForm>& forms, std::int32_t label, const Vec3& p)
{
    const Vec3 g = normalized(forms[label >> 1].gradient(p));
    return (label & 1) != 0 ? -g : g;
}

// The points between the ends of the edges of the coarse mesh.
class CutEdges {
public:
    CutEdges(const SurfaceMesh& coarse, const CoarseShell& shell,
             const std::vector<SurfaceForm>& forms, const std::vector<Vec3>& direction,
             double limit)
        : m_(coarse),
          shell_(shell),
          forms_(forms),
          direction_(direction),
          limit_(limit),
          sides_(coarse.mesh),
          table_(
              make_edge_table(sides_, coarse.mesh.n_vertices(), [](std::size_t) { return false; }))
    {
        edge_of_side_.resize(sides_.n_sides());
        for (std::size_t e = 0; e < table_.n_edges(); ++e)
            for (std::int64_t i = table_.starts[e]; i < table_.starts[e + 1]; ++i)
                edge_of_side_[table_.sides[i]] = static_cast<std::int32_t>(e);
        guess_.resize(table_.n_edges());
        for (std::size_t e = 0; e < guess_.size(); ++e) guess_[e] = first_guess(e);
    }

    // About how many triangles it will be: a face with p, q and r pieces on its sides gets as many
    // as the mean product of two of them.
    double expected() const
    {
        double sum = 0.0;
        for (std::int32_t s = 0; s < static_cast<std::int32_t>(sides_.n_sides()); s += 3) {
            const double p = guess_[edge(s)], q = guess_[edge(s + 1)], r = guess_[edge(s + 2)];
            sum += (p * q + q * r + r * p) / 3.0;
        }
        return sum;
    }

    // Returns the faces at edges with a point that cannot be placed or directed.
    std::vector<std::int32_t> run()
    {
        points_.resize(table_.n_edges());
        std::vector<char> bad(table_.n_edges(), 0);
        parallel_for(table_.n_edges(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t e = begin; e < end; ++e) bad[e] = cut(e) ? 0 : 1;
        });
        std::vector<std::int32_t> stuck;
        for (std::size_t e = 0; e < bad.size(); ++e)
            for (std::int64_t i = table_.starts[e]; bad[e] != 0 && i < table_.starts[e + 1]; ++i)
                stuck.push_back(table_.sides[i] / 3);
        first_.resize(points_.size() + 1);
        first_[0] = static_cast<std::int64_t>(m_.mesh.n_vertices());
        for (std::size_t e = 0; e < points_.size(); ++e)
            first_[e + 1] = first_[e] + static_cast<std::int64_t>(points_[e].size());
        return stuck;
    }

    BorderPoint at_vertex(std::int32_t v) const
    {
        return {m_.mesh.vertices[v], direction_[v], shell_.at(v), room_for(direction_[v])};
    }
    std::int64_t n_vertices() const { return first_.back(); }
    std::size_t n_edges() const { return points_.size(); }
    const std::vector<BorderPoint>& points(std::size_t e) const { return points_[e]; }
    std::int64_t first(std::size_t e) const { return first_[e]; }
    std::int32_t edge(std::int32_t side) const { return edge_of_side_[side]; }
    // The edge runs the way of the first of its sides.
    bool runs_along(std::int32_t side) const
    {
        return table_.sides[table_.starts[edge(side)]] == side;
    }
    std::array<std::int32_t, 3> surfaces(std::size_t e) const
    {
        const auto [p, q] = labels(e);
        if (p >> 1 == q >> 1) return {p >> 1, -1, -1};
        return {std::min(p, q) >> 1, std::max(p, q) >> 1, -1};
    }

private:
    std::array<std::int32_t, 2> labels(std::size_t e) const
    {
        const std::int32_t s = table_.sides[table_.starts[e]],
                           t = table_.sides[table_.starts[e] + 1];
        return {m_.surface_of_face[s / 3], m_.surface_of_face[t / 3]};
    }

    std::array<BorderPoint, 2> ends(std::size_t e) const
    {
        const std::int32_t side = table_.sides[table_.starts[e]];
        const std::int32_t a = sides_.from(side), b = sides_.to(side);
        return {at_vertex(a), at_vertex(b)};
    }

    double limit(std::size_t e) const
    {
        const auto [from, to] = ends(e);
        return limit_ / std::max({1.0, norm(from.direction), norm(to.direction)});
    }

    // Of a chord for a piece of the edge: the larger of the distances from its surfaces. How far
    // the chord is from their curve does not count: where surfaces meet at a flat angle that may be
    // more, but the solid is no farther.
    double sagitta(std::size_t e, const Vec3& p, const Vec3& q) const
    {
        const auto [left, right] = labels(e);
        const double from_left = sagitta_from(left >> 1, p, q);
        return left >> 1 == right >> 1 ? from_left
                                       : std::max(from_left, sagitta_from(right >> 1, p, q));
    }

    // Of a chord with its ends on the surface: a quadratic is off in its middle by a quarter of its
    // bend.
    double sagitta_from(std::int32_t s, const Vec3& p, const Vec3& q) const
    {
        const SurfaceForm& form = forms_[s];
        if (form.is_plane()) return 0.0;
        const Vec3 middle = 0.5 * (p + q);
        return form.is_quadratic()
                   ? 0.25 * std::fabs(form.bend(q - p)) / norm(form.gradient(middle))
                   : form.distance(middle);
    }

    double first_guess(std::size_t e) const
    {
        const auto [from, to] = ends(e);
        return pieces_for(sagitta(e, from.at, to.at), limit(e));
    }

    bool cut(std::size_t e)
    {
        const auto [left, right] = labels(e);
        const bool crease = left != right;
        if (left >> 1 == right >> 1 && crease) return false;  // matter on both sides of a surface
        const auto [from, to] = ends(e);
        const double most_allowed = limit(e);
        double pieces = guess_[e];
        std::vector<BorderPoint>& points = points_[e];
        double before = std::numeric_limits<double>::infinity();
        for (int attempt = 0; attempt < 12; ++attempt) {
            if (!(pieces <= kMostPieces)) return false;
            const int n = static_cast<int>(pieces);
            points.clear();
            points.reserve(static_cast<std::size_t>(n) - 1);
            for (int i = 1; i < n; ++i) {
                const double t = static_cast<double>(i) / n;
                const Vec3 start = from.at + t * (to.at - from.at);
                auto p =
                    crease ? on_curve(start, left, right, to.at - from.at)
                           : on_surface(start, from.direction + t * (to.direction - from.direction),
                                        left);
                if (!p) return false;
                p->shell = between(from.shell, to.shell, t);
                points.push_back(*p);
            }
            double most = 0.0;
            for (int i = 0; i < n; ++i)
                most = std::max(most, sagitta(e, i == 0 ? from.at : points[i - 1].at,
                                              i == n - 1 ? to.at : points[i].at));
            if (most <= most_allowed * 1.001) return true;
            // Sagittas fall with the square of their chords, but next to an apex.
            const double beside_square = most * pieces * pieces;
            if (pieces > kManyPieces && beside_square > 2.0 * before) return false;
            before = beside_square;
            pieces = std::max(pieces + 1.0, std::ceil(pieces * std::sqrt(most / most_allowed)));
        }
        return false;
    }

    std::optional<BorderPoint> on_surface(const Vec3& start, const Vec3& way,
                                          std::int32_t label) const
    {
        const SurfaceForm& form = forms_[label >> 1];
        const auto t = form.root_along(start, way);
        if (!t) return std::nullopt;
        const Vec3 p = form.straightened(start + *t * way);
        return BorderPoint{p, outward(forms_, label, p), {}, 1.0};
    }

    // Newton's method for the point of both surfaces in the plane through `start` across `along`:
    // points stay in order on the curve, and off its other branches.
    std::optional<Vec3> in_plane(const Vec3& start, const Vec3& along, std::int32_t s,
                                 std::int32_t t) const
    {
        Vec3 p = start;
        for (int step = 0; step < 30; ++step) {
            const double u = forms_[s].value(p), v = forms_[t].value(p);
            if (std::fabs(u) <= 0.0625 * forms_[s].slack() &&
                std::fabs(v) <= 0.0625 * forms_[t].slack())
                return p;
            const Vec3 g = forms_[s].gradient(p), h = forms_[t].gradient(p);
            const Vec3 across = cross(along, g);
            const double det = dot(across, h);
            // Moves along x = cross(along, h) keep t, those along y = cross(along, g) keep s.
            const Vec3 move = (u / dot(cross(along, h), g)) * cross(along, h) + (v / det) * across;
            p -= move;
            if (!(distance(p, start) <= 0.5 * norm(along))) return std::nullopt;
        }
        if (std::fabs(forms_[s].value(p)) <= forms_[s].slack() &&
            std::fabs(forms_[t].value(p)) <= forms_[t].slack())
            return p;
        return std::nullopt;
    }

    std::optional<BorderPoint> on_curve(const Vec3& start, std::int32_t left, std::int32_t right,
                                        const Vec3& along) const
    {
        auto p = in_plane(start, along, left >> 1, right >> 1);
        if (!p) return std::nullopt;
        for (const std::int32_t label : {left, right}) *p = forms_[label >> 1].straightened(*p);
        const Vec3 m = outward(forms_, left, *p), n = outward(forms_, right, *p);
        const double together = 1.0 + dot(m, n);
        if (!(together * kLongestWay > 1.0)) return std::nullopt;
        const Vec3 way = (m + n) / together;
        return BorderPoint{*p, way, {}, room_for(way)};
    }

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

// The fibre of the sandwich at each vertex, as long as its surfaces ask for; faces at vertices
// where a surface does not recede along it are stuck.
std::vector<Vec3> corner_directions(const SurfaceMesh& m, const Sandwich& sandwich,
                                    const std::vector<SurfaceForm>& forms,
                                    std::vector<std::int32_t>& stuck)
{
    std::vector<std::vector<std::int32_t>> labels(m.mesh.n_vertices());
    for (std::size_t f = 0; f < m.mesh.n_faces(); ++f)
        for (const std::int32_t v : m.mesh.faces[f])
            if (std::find(labels[v].begin(), labels[v].end(), m.surface_of_face[f]) ==
                labels[v].end())
                labels[v].push_back(m.surface_of_face[f]);
    std::vector<Vec3> directions(labels.size());
    for (std::size_t v = 0; v < labels.size(); ++v) {
        const Vec3 fibre = normalized(sandwich.outer.vertices[v] - sandwich.inner.vertices[v]);
        double least = 1.0;
        for (const std::int32_t label : labels[v])
            least = std::min(least, dot(outward(forms, label, m.mesh.vertices[v]), fibre));
        if (least * kLongestWay > 1.0) directions[v] = fibre / least;
    }
    for (std::size_t f = 0; f < m.mesh.n_faces(); ++f)
        for (const std::int32_t v : m.mesh.faces[f])
            if (directions[v] == Vec3{}) {
                stuck.push_back(static_cast<std::int32_t>(f));
                break;
            }
    return directions;
}

}  // namespace

FineMesh cut_finely(const SurfaceMesh& coarse, const Sandwich& sandwich, const CoarseShell& shell,
                    const std::vector<SurfaceForm>& forms, double tolerance,
                    std::int64_t max_triangles)
{
    const double limit = kEdgeShare * tolerance;
    FineMesh fine;
    const std::vector<Vec3> directions = corner_directions(coarse, sandwich, forms, fine.stuck);
    if (!fine.stuck.empty()) return fine;
    CutEdges edges(coarse, shell, forms, directions, limit);
    constexpr double kFar = 8.0;  // the guess is trusted to this factor
    if (const double expected = edges.expected(), most = static_cast<double>(max_triangles);
        !(expected <= kFar * most))
        throw ToleranceNotMet("mesh: about " + to_text(std::round(expected * 1e-6)) +
                                  " million triangles are needed, max_triangles is " +
                                  std::to_string(max_triangles),
                              tolerance, tolerance * expected / most, {});
    fine.stuck = edges.run();
    if (!fine.stuck.empty()) return fine;

    const TriangleSides sides(coarse.mesh);
    const std::size_t n = coarse.mesh.n_faces();
    struct Part {
        std::vector<FinePoint> inner;
        std::vector<Triangle> faces;
        std::vector<std::array<double, 2>> reaches;  // of the border first
    };
    std::vector<Part> parts(n);
    std::vector<char> bad(n, 0);
    std::atomic<std::int64_t> n_triangles{0};
    const auto border_of = [&](std::size_t f, auto&& take) {
        for (std::int32_t i = 0; i < 3; ++i) {
            const std::int32_t side = sides.first(f) + i;
            const std::size_t e = static_cast<std::size_t>(edges.edge(side));
            const auto count = static_cast<std::int32_t>(edges.points(e).size());
            const auto place = [&](std::int32_t k) {
                const double t = static_cast<double>(k) / (count + 1);
                return i == 0   ? Weights{t, 0.0}
                       : i == 1 ? Weights{1.0 - t, t}
                                : Weights{0.0, 1.0 - t};
            };
            take(sides.from(side), edges.at_vertex(sides.from(side)), place(0));
            for (std::int32_t k = 0; k < count; ++k) {
                const std::int32_t at = edges.runs_along(side) ? k : count - 1 - k;
                take(static_cast<std::int32_t>(edges.first(e)) + at, edges.points(e)[at],
                     place(k + 1));
            }
        }
    };
    parallel_for(n, 16, [&](std::size_t begin, std::size_t end) {
        CutFace cut(kFaceShare * tolerance, max_triangles);
        std::vector<FinePoint> border;
        for (std::size_t f = begin; f < end; ++f) {
            current_progress().check();
            border.clear();
            border_of(f, [&](std::int32_t, const BorderPoint& p, const Weights& place) {
                border.push_back({p.at, p.direction, place, p.room});
            });
            std::array<std::int32_t, 3> pieces;
            for (std::int32_t i = 0; i < 3; ++i)
                pieces[i] = 1 + static_cast<std::int32_t>(
                                    edges.points(edges.edge(sides.first(f) + i)).size());
            const std::int32_t label = coarse.surface_of_face[f];
            bool any_curve = false;
            for (std::int32_t i = 0; i < 3; ++i)
                any_curve = any_curve || edges.surfaces(edges.edge(sides.first(f) + i))[1] >= 0;
            if (!cut.run(forms[label >> 1], (label & 1) != 0, border, pieces, any_curve)) {
                bad[f] = 1;
                continue;
            }
            parts[f].inner.assign(cut.points().begin() + cut.n_border(), cut.points().end());
            parts[f].faces = cut.faces();
            parts[f].reaches = cut.reaches();
            n_triangles += static_cast<std::int64_t>(parts[f].faces.size());
            if (n_triangles > max_triangles)
                throw ToleranceNotMet("mesh: more than max_triangles triangles are needed",
                                      tolerance, std::numeric_limits<double>::infinity(), {});
        }
    });
    for (std::size_t f = 0; f < n; ++f)
        if (bad[f] != 0) fine.stuck.push_back(static_cast<std::int32_t>(f));
    if (!fine.stuck.empty()) return fine;

    fine.first_face.assign(n + 1, 0);
    fine.first_vertex.assign(n + 1, edges.n_vertices());
    for (std::size_t f = 0; f < n; ++f) {
        fine.first_vertex[f + 1] =
            fine.first_vertex[f] + static_cast<std::int64_t>(parts[f].inner.size());
        fine.first_face[f + 1] =
            fine.first_face[f] + static_cast<std::int64_t>(parts[f].faces.size());
    }
    const std::int64_t n_vertices = fine.first_vertex[n];
    require(n_vertices <= std::numeric_limits<std::int32_t>::max(), "mesh: too many vertices");
    SurfaceMesh& s = fine.surface;
    s.mesh.vertices.resize(n_vertices);
    fine.direction.resize(n_vertices);
    fine.border_shell.resize(edges.n_vertices());
    fine.place.resize(n_vertices - edges.n_vertices());
    s.surfaces_of_vertex.resize(n_vertices);
    s.cell_size.resize(n_vertices);
    s.mesh.faces.resize(fine.first_face[n]);
    s.surface_of_face.resize(fine.first_face[n]);
    fine.reach.resize(n_vertices);
    const auto put = [&](std::int64_t v, const BorderPoint& p,
                         const std::array<std::int32_t, 3>& on) {
        s.mesh.vertices[v] = p.at;
        fine.direction[v] = p.direction;
        fine.border_shell[v] = p.shell;
        s.surfaces_of_vertex[v] = on;
    };
    std::vector<double> cell_size(n, std::numeric_limits<double>::infinity());
    for (std::size_t f = 0; f < n; ++f)
        for (const std::int32_t v : coarse.mesh.faces[f])
            cell_size[f] = std::min(cell_size[f], coarse.cell_size[v]);
    std::copy(coarse.cell_size.begin(), coarse.cell_size.end(), s.cell_size.begin());
    for (std::size_t v = 0; v < coarse.mesh.n_vertices(); ++v)
        put(static_cast<std::int64_t>(v), edges.at_vertex(static_cast<std::int32_t>(v)),
            coarse.surfaces_of_vertex[v]);
    for (std::size_t e = 0; e < edges.n_edges(); ++e)
        for (std::size_t k = 0; k < edges.points(e).size(); ++k)
            put(edges.first(e) + static_cast<std::int64_t>(k), edges.points(e)[k],
                edges.surfaces(e));
    for (std::size_t f = 0; f < n; ++f)
        for (std::int32_t i = 0; i < 3; ++i) {
            const auto e = static_cast<std::size_t>(edges.edge(sides.first(f) + i));
            for (std::size_t k = 0; k < edges.points(e).size(); ++k)
                s.cell_size[edges.first(e) + static_cast<std::int64_t>(k)] = cell_size[f];
        }
    for (std::size_t f = 0; f < n; ++f) {
        std::size_t k = 0;
        border_of(f, [&](std::int32_t v, const BorderPoint&, const Weights&) {
            for (const std::size_t side : {0u, 1u})
                fine.reach[v][side] = std::max(fine.reach[v][side], parts[f].reaches[k][side]);
            ++k;
        });
    }
    parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
        std::vector<std::int32_t> number;
        for (std::size_t f = begin; f < end; ++f) {
            const Part& part = parts[f];
            const std::int32_t label = coarse.surface_of_face[f];
            number.clear();
            border_of(f, [&](std::int32_t v, const BorderPoint&, const Weights&) {
                number.push_back(v);
            });
            for (std::size_t k = 0; k < part.inner.size(); ++k) {
                const std::int64_t v = fine.first_vertex[f] + static_cast<std::int64_t>(k);
                number.push_back(static_cast<std::int32_t>(v));
                s.mesh.vertices[v] = part.inner[k].at;
                fine.direction[v] = part.inner[k].direction;
                fine.place[v - edges.n_vertices()] = part.inner[k].place;
                s.surfaces_of_vertex[v] = {label >> 1, -1, -1};
                fine.reach[v] = part.reaches[number.size() - 1];
                s.cell_size[v] = cell_size[f];
            }
            for (std::size_t k = 0; k < part.faces.size(); ++k) {
                const Triangle& t = part.faces[k];
                s.mesh.faces[fine.first_face[f] + k] = {number[t[0]], number[t[1]], number[t[2]]};
                s.surface_of_face[fine.first_face[f] + k] = label;
            }
        }
    });
    return fine;
}

}  // namespace genus
