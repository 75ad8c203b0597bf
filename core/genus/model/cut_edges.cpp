#include "genus/model/cut_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/parallel.h"
#include "genus/model/cut_face.h"

namespace genus {

namespace {

constexpr double kMostPieces = 1 << 22;  // of one edge
constexpr double kManyPieces = 64;
constexpr int kMostAtOnce = 1024;     // points that room is made for before there are any
constexpr double kLongestWay = 16.0;  // of a direction

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

}  // namespace

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

CutEdges::CutEdges(const SurfaceMesh& coarse, const CoarseShell& shell,
                   const std::vector<SurfaceForm>& forms, const std::vector<Vec3>& direction,
                   double limit)
    : m_(coarse),
      shell_(shell),
      forms_(forms),
      direction_(direction),
      limit_(limit),
      sides_(coarse.mesh),
      table_(make_edge_table(sides_, coarse.mesh.n_vertices(), [](std::size_t) { return false; }))
{
    edge_of_side_.resize(sides_.n_sides());
    for (std::size_t e = 0; e < table_.n_edges(); ++e)
        for (std::int64_t i = table_.starts[e]; i < table_.starts[e + 1]; ++i)
            edge_of_side_[table_.sides[i]] = static_cast<std::int32_t>(e);
    guess_.resize(table_.n_edges());
    for (std::size_t e = 0; e < guess_.size(); ++e) guess_[e] = first_guess(e);
}

double CutEdges::expected() const
{
    double sum = 0.0;
    for (std::int32_t s = 0; s < static_cast<std::int32_t>(sides_.n_sides()); s += 3) {
        const double p = guess_[edge(s)], q = guess_[edge(s + 1)], r = guess_[edge(s + 2)];
        sum += (p * q + q * r + r * p) / 3.0;
    }
    return sum;
}

std::vector<std::int32_t> CutEdges::run()
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

std::array<std::int32_t, 3> CutEdges::surfaces(std::size_t e) const
{
    const auto [p, q] = labels(e);
    if (p >> 1 == q >> 1) return {p >> 1, -1, -1};
    return {std::min(p, q) >> 1, std::max(p, q) >> 1, -1};
}

std::array<std::int32_t, 2> CutEdges::labels(std::size_t e) const
{
    const std::int32_t s = table_.sides[table_.starts[e]], t = table_.sides[table_.starts[e] + 1];
    return {m_.surface_of_face[s / 3], m_.surface_of_face[t / 3]};
}

std::array<BorderPoint, 2> CutEdges::ends(std::size_t e) const
{
    const std::int32_t side = table_.sides[table_.starts[e]];
    const std::int32_t a = sides_.from(side), b = sides_.to(side);
    return {at_vertex(a), at_vertex(b)};
}

double CutEdges::limit(std::size_t e) const
{
    const auto [from, to] = ends(e);
    return limit_ / std::max({1.0, norm(from.direction), norm(to.direction)});
}

// Of a chord for a piece of the edge: the larger of the distances from its surfaces. How far
// the chord is from their curve does not count: where surfaces meet at a flat angle that may be
// more, but the solid is no farther.
double CutEdges::sagitta(std::size_t e, const Vec3& p, const Vec3& q) const
{
    const auto [left, right] = labels(e);
    const double from_left = forms_[left >> 1].sagitta(p, q);
    return left >> 1 == right >> 1 ? from_left
                                   : std::max(from_left, forms_[right >> 1].sagitta(p, q));
}

double CutEdges::first_guess(std::size_t e) const
{
    const auto [from, to] = ends(e);
    return pieces_for(sagitta(e, from.at, to.at), limit(e));
}

bool CutEdges::cut(std::size_t e)
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
        points.reserve(static_cast<std::size_t>(std::min(n - 1, kMostAtOnce)));
        for (int i = 1; i < n; ++i) {
            const double t = static_cast<double>(i) / n;
            const Vec3 start = from.at + t * (to.at - from.at);
            auto p =
                crease
                    ? on_curve(start, left, right, to.at - from.at)
                    : on_surface(start, from.direction + t * (to.direction - from.direction), left);
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

std::optional<BorderPoint> CutEdges::on_surface(const Vec3& start, const Vec3& way,
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
std::optional<Vec3> CutEdges::in_plane(const Vec3& start, const Vec3& along, std::int32_t s,
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

std::optional<BorderPoint> CutEdges::on_curve(const Vec3& start, std::int32_t left,
                                              std::int32_t right, const Vec3& along) const
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

BorderPoint CutEdges::at_vertex(std::int32_t v) const
{
    return {m_.mesh.vertices[v], direction_[v], shell_.at(v), room_for(direction_[v])};
}

}  // namespace genus
