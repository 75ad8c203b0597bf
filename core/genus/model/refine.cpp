#include "genus/model/refine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/changes.h"
#include "genus/model/fans.h"
#include "genus/model/shaper.h"

namespace genus {

std::int64_t settle(SurfaceMesh& surface, const std::vector<SurfaceForm>& forms)
{
    IndexedMesh& mesh = surface.mesh;
    const std::vector<Vec3> start = mesh.vertices;
    std::vector<double> reach(mesh.n_vertices(), 0.0);
    for (const Triangle& t : mesh.faces)
        for (std::size_t i = 0; i < 3; ++i) {
            const double length = distance(start[t[i]], start[t[(i + 1) % 3]]);
            for (const std::size_t j : {i, (i + 1) % 3})
                reach[t[j]] = std::max(reach[t[j]], length);
        }
    // What touches moves as one.
    const std::vector<std::vector<std::int32_t>> touching =
        vertices_by_place(surface.touch_of_vertex);
    for (const auto& place : touching) {
        double most = 0.0;
        for (const std::int32_t v : place) most = std::max(most, reach[v]);
        for (const std::int32_t v : place) reach[v] = most;
    }
    std::vector<char> stays(mesh.n_vertices(), 0);
    parallel_for(mesh.n_vertices(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            std::array<const SurfaceForm*, 3> on{};
            std::size_t n = 0;
            for (const std::int32_t s : surface.surfaces_of_vertex[v])
                if (s >= 0) on[n++] = &forms[s];
            const auto p = project(std::span(on.data(), n), start[v], 0.5 * reach[v]);
            if (p)
                mesh.vertices[v] = *p;
            else
                stays[v] = 1;
        }
    });
    // A face keeps its normal to within 60 degrees, or its corners go back.
    constexpr double kCosine = 0.5;
    for (bool any = true; any;) {
        any = false;
        for (const Triangle& t : mesh.faces) {
            const Vec3 before = cross(start[t[1]] - start[t[0]], start[t[2]] - start[t[0]]);
            const Vec3 after = cross(mesh.vertices[t[1]] - mesh.vertices[t[0]],
                                     mesh.vertices[t[2]] - mesh.vertices[t[0]]);
            if (dot(before, after) > kCosine * norm(before) * norm(after)) continue;
            for (const std::int32_t v : t) {
                if (mesh.vertices[v] == start[v]) continue;
                mesh.vertices[v] = start[v];
                stays[v] = 1;
                any = true;
            }
        }
        for (const auto& place : touching) {
            const bool back = std::any_of(place.begin(), place.end(),
                                          [&](std::int32_t v) { return stays[v] != 0; });
            for (const std::int32_t v : place) {
                if (!back || stays[v] != 0) continue;
                mesh.vertices[v] = start[v];
                stays[v] = 1;
                any = true;
            }
        }
    }
    return std::count(stays.begin(), stays.end(), 1);
}

namespace {

constexpr double kShortEdge = 0.35;   // of the cell size
constexpr double kLeastShape = 0.02;  // a new vertex does not make faces thinner than this
constexpr int kCoarsenRounds = 8;

// Sides, one an edge, that are short beside their cells, the shortest first.
std::vector<std::int32_t> short_edges(const FlexibleMesh& m, const Shaper& shaper)
{
    std::vector<std::pair<double, std::int32_t>> found;
    for (std::int32_t s = 0; s < m.n_sides(); ++s) {
        if (!m.alive(s) || m.twin(s) < s) continue;
        const double size = std::min(m.cell_size(m.from(s)), m.cell_size(m.to(s)));
        const double ratio = shaper.length(s) / size;
        if (ratio < kShortEdge) found.emplace_back(ratio, s);
    }
    std::sort(found.begin(), found.end());
    std::vector<std::int32_t> sides;
    for (const auto& [ratio, s] : found) sides.push_back(s);
    return sides;
}

// Halves edges, the one with the largest error first.
class Subdivider : Shaper {
public:
    Subdivider(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, double max_error,
               std::vector<double>& factors, const CreaseDemand& creases)
        : Shaper(mesh, forms), max_error_(max_error), factors_(factors), creases_(creases)
    {
        factors_.resize(mesh.n_vertices(), 1.0);
        spread_.resize(mesh.n_vertices(), 1.0);
        parallel_for(mesh.n_vertices(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                if (mesh.exists(static_cast<std::int32_t>(v)))
                    spread_[v] = spread_at(static_cast<std::int32_t>(v));
        });
    }

    std::vector<Box3> run(std::int64_t max_triangles)
    {
        for (std::int32_t s = 0; s < m_.n_sides(); ++s)
            if (m_.alive(s) && s < m_.twin(s)) push(s);
        refuse_hopeless(max_triangles);
        std::int64_t steps = 0;
        while (!queue_.empty()) {
            const Entry e = queue_.top();
            queue_.pop();
            if ((++steps & 1023) == 0) current_progress().check();
            if (m_.from(e.side) != e.a || m_.to(e.side) != e.b) continue;
            if (m_.n_sides() / 3 > max_triangles)
                throw ToleranceNotMet("mesh: more than max_triangles triangles are needed",
                                      max_error_, e.error, {});
            if (halve(e.side, kMaxHelp)) continue;
            Box3 box;
            box.add(m_.point(e.a));
            box.add(m_.point(e.b));
            places_.push_back(box);
        }
        return std::move(places_);
    }

    std::int64_t halve_all(const std::vector<std::array<std::int32_t, 2>>& ends)
    {
        std::int64_t done = 0;
        for (const auto& [from, to] : ends)
            if (const std::int32_t s = m_.side(from, to); s >= 0)
                done += halve(s, kMaxHelp) ? 1 : 0;
        return done;
    }

private:
    static constexpr int kMaxHelp = 6;

    struct Entry {
        double error;
        std::int32_t side, a, b;
        bool operator<(const Entry& o) const
        {
            return error != o.error ? error < o.error : side < o.side;
        }
    };

    // The error of an edge falls with the square of its length, so faces grow in number with the
    // inverse of the error. Where that estimate is far beyond what is allowed, no time is spent.
    void refuse_hopeless(std::int64_t max_triangles) const
    {
        constexpr double kFar = 8.0;  // the estimate is trusted to this factor
        const double limit = static_cast<double>(max_triangles);
        const double needed = static_cast<double>(m_.n_sides() / 3) + expected_ / 1.5;
        if (needed <= kFar * limit) return;
        throw ToleranceNotMet("mesh: about " + to_text(std::round(needed * 1e-6)) +
                                  " million triangles are needed, max_triangles is " +
                                  std::to_string(max_triangles),
                              max_error_, max_error_ * needed / limit, {});
    }

    Vec3 outward(std::int32_t label, const Vec3& p) const
    {
        const Vec3 g = normalized(forms_[label >> 1].gradient(p));
        return (label & 1) != 0 ? -g : g;
    }

    // Length of the shortest vector along which all faces at v recede by one.
    double spread_at(std::int32_t v) const
    {
        std::vector<std::int32_t> labels;
        m_.visit_ring(v, [&](std::int32_t s) {
            if (std::find(labels.begin(), labels.end(), m_.label(s)) == labels.end())
                labels.push_back(m_.label(s));
        });
        if (labels.size() < 2) return 1.0;
        std::vector<Vec3> normals;
        for (const std::int32_t label : labels) normals.push_back(outward(label, m_.point(v)));
        const std::vector<double> ones(normals.size(), 1.0);
        const auto d = shortest_direction(normals, ones);
        return d ? std::clamp(norm(*d), 1.0, 8.0) : 8.0;
    }

    std::array<std::int32_t, 3> carriers(std::int32_t s) const
    {
        const std::int32_t p = m_.label(s) >> 1, q = m_.label(m_.twin(s)) >> 1;
        if (p == q) return {p, -1, -1};
        return {std::min(p, q), std::max(p, q), -1};
    }

    std::optional<Vec3> exact_middle(std::int32_t s) const
    {
        std::array<const SurfaceForm*, 3> on{};
        std::size_t n = 0;
        for (const std::int32_t i : carriers(s))
            if (i >= 0) on[n++] = &forms_[i];
        const Vec3 middle = 0.5 * (m_.point(m_.from(s)) + m_.point(m_.to(s)));
        return project(std::span(on.data(), n), middle, 0.5 * length(s));
    }

    // Distance of the middle from the surface or curve it stands for, to first order.
    double distance_of_middle(std::int32_t s) const
    {
        const auto on = carriers(s);
        if (!m_.is_crease(s) && forms_[on[0]].is_plane()) return 0.0;
        const Vec3 middle = 0.5 * (m_.point(m_.from(s)) + m_.point(m_.to(s)));
        return on[1] < 0 ? forms_[on[0]].distance(middle)
                         : distance_from_curve(on[0], on[1], middle);
    }

    // What counts is how far the certificate must move the corners of the faces at the edge.
    double error_of(std::int32_t s) const
    {
        const double distance = distance_of_middle(s);
        if (const double bulge = bulge_of(s, distance); bulge > max_error_) return bulge;
        if (!(distance > 0.1 * max_error_)) return distance;
        const std::array<std::int32_t, 4> v{m_.from(s), m_.to(s), m_.apex(s), m_.apex(m_.twin(s))};
        double spread = 1.0, factor = 1.0;
        for (const std::int32_t x : v) {
            spread = std::max(spread, spread_[x]);
            factor = std::min(factor, factors_[x]);
        }
        return distance * spread / factor;
    }

    double distance_from_surfaces(std::int32_t s) const
    {
        const Vec3 middle = 0.5 * (m_.point(m_.from(s)) + m_.point(m_.to(s)));
        double most = 0.0;
        for (const std::int32_t i : carriers(s))
            if (i >= 0) most = std::max(most, forms_[i].distance(middle));
        return most;
    }

    // The sagitta of a curve beside what is allowed for its faces, in units of `max_error_`.
    double bulge_of(std::int32_t s, double sagitta) const
    {
        if (creases_.crease_share == CreaseDemand::kNone || !m_.is_crease(s) ||
            distance_from_surfaces(s) <= creases_.flat_enough)
            return 0.0;
        const Vec3 &a = m_.point(m_.from(s)), &b = m_.point(m_.to(s));
        double height = std::numeric_limits<double>::infinity();
        for (const std::int32_t side : {s, m_.twin(s)})
            height = std::min(height, norm(cross(b - a, m_.point(m_.apex(side)) - a)));
        height /= distance(a, b);
        return max_error_ * sagitta / (creases_.crease_share * height);
    }

    void push(std::int32_t s)
    {
        const double error = error_of(s);
        if (!(error > max_error_)) return;
        queue_.push({error, s, m_.from(s), m_.to(s)});
        expected_ += error / max_error_;
    }

    // Halves the edge; if the new point does not fit into a face, a longer side of that face is
    // halved first.
    bool halve(std::int32_t s, int help)
    {
        const auto p = exact_middle(s);
        if (!p) return false;
        // Where the mesh touches itself all edges at one place are halved together.
        const std::vector<std::int32_t> edges = m_.coincident(s);
        std::vector<std::int32_t> sides;
        for (const std::int32_t e : edges) sides.insert(sides.end(), {e, m_.twin(e)});
        for (const std::int32_t side : sides) {
            if (fits(side, *p)) continue;
            if (help == 0) return false;
            const std::int32_t u = FlexibleMesh::next(side), w = FlexibleMesh::previous(side);
            const std::int32_t longer = length(u) >= length(w) ? u : w;
            const std::int32_t a = m_.from(s), b = m_.to(s);
            if (length(longer) < 0.5 * length(s) || !halve(longer, help - 1)) return false;
            return m_.from(s) == a && m_.to(s) == b && halve(s, help - 1);
        }
        std::vector<std::array<std::int32_t, 2>> ends;
        for (const std::int32_t e : edges) ends.push_back({m_.from(e), m_.to(e)});
        std::vector<std::int32_t> middles;
        for (const auto& [from, to] : ends) {
            const std::int32_t e = m_.side(from, to);
            if (e >= 0) middles.push_back(insert(e, *p));
        }
        m_.note_touch(middles);
        return true;
    }

    std::int32_t insert(std::int32_t s, const Vec3& p)
    {
        const std::int32_t t = m_.twin(s), a = m_.from(s), b = m_.to(s);
        const bool crease = m_.is_crease(s);
        const std::int32_t m = m_.split(s, p, carriers(s));
        factors_.push_back(std::min(factors_[a], factors_[b]));
        spread_.push_back(crease ? spread_at(m) : 1.0);
        const std::array<std::int32_t, 4> outer{m_.previous(s), m_.previous(t), m_.next(m_.twin(t)),
                                                m_.next(m_.twin(s))};
        for (const std::int32_t o : outer) try_flip(o, 1.2);
        m_.visit_ring(m, [&](std::int32_t x) {
            push(x);
            push(m_.next(x));
        });
        return m;
    }

    bool fits(std::int32_t s, const Vec3& p) const
    {
        const Vec3 &a = m_.point(m_.from(s)), &b = m_.point(m_.to(s)), &c = m_.point(m_.apex(s));
        const Shape u = shape(a, p, c, m_.label(s)), w = shape(p, b, c, m_.label(s));
        const double least = std::min(kLeastShape, 0.25 * face_shape(s).height_ratio);
        return u.faces_right && w.faces_right && std::min(u.height_ratio, w.height_ratio) >= least;
    }

    double max_error_;
    std::vector<double>& factors_;
    CreaseDemand creases_;
    std::vector<double> spread_;
    std::priority_queue<Entry> queue_;
    double expected_ = 0.0;  // sum over edges queued of error beside the one asked for
    std::vector<Box3> places_;
};

void drop_unsettled(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, double far)
{
    Shaper shaper(mesh, forms);
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(mesh.n_vertices()); ++v) {
        if (!mesh.exists(v)) continue;
        double most = 0.0;
        for (const std::int32_t s : mesh.surfaces(v))
            if (s >= 0) most = std::max(most, forms[s].distance(mesh.point(v)));
        if (most > far) shaper.try_drop(v);
    }
}

// Vertices that have come to the same place, of whatever kind, become one where topology allows.
void join_coincident(FlexibleMesh& mesh, const Shaper& shaper)
{
    constexpr double kSame = 1e-9;  // of the cell size
    for (std::int32_t s = 0; s < mesh.n_sides(); ++s)
        if (mesh.alive(s) && !mesh.touches(mesh.from(s)) &&
            shaper.length(s) <= kSame * mesh.cell_size(mesh.from(s)) && mesh.can_collapse(s))
            mesh.collapse(s);
}

// One sweep over all edges where something has changed. Returns the number of flips.
std::int64_t flip_all(FlexibleMesh& mesh, Shaper& shaper, Changes& changes)
{
    constexpr double kGain = 1.3;
    std::vector<char> right(static_cast<std::size_t>(mesh.n_sides() / 3),
                            -1);  // of faces, if known
    const auto is_right = [&](std::int32_t s) {
        char& known = right[static_cast<std::size_t>(s / 3)];
        if (known < 0) known = shaper.face_shape(s).faces_right ? 1 : 0;
        return known != 0;
    };
    std::int64_t done = 0;
    for (std::int32_t s = 0; s < mesh.n_sides(); ++s) {
        if (!mesh.alive(s) || mesh.twin(s) < s || !changes.round_edge(s)) continue;
        if (!shaper.try_flip(s, kGain, is_right)) continue;
        for (const std::int32_t side : {s, mesh.twin(s)})
            right[static_cast<std::size_t>(side / 3)] = -1;
        changes.note_flip(s);
        ++done;
    }
    return done;
}

}  // namespace

void coarsen(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms)
{
    Shaper shaper(mesh, forms);
    Changes changes(mesh);
    for (int round = 0; round < kCoarsenRounds; ++round) {
        current_progress().check();
        std::int64_t done = 0;
        for (const std::int32_t s : short_edges(mesh, shaper)) {
            if (!mesh.alive(s) || !changes.at_edge(s)) continue;
            if (shaper.length(s) >
                kShortEdge * std::min(mesh.cell_size(mesh.from(s)), mesh.cell_size(mesh.to(s))))
                continue;
            const std::int32_t a = mesh.from(s), b = mesh.to(s);
            if (!shaper.try_collapse(s) && !shaper.try_collapse(mesh.twin(s))) continue;
            changes.note_collapse(a, b);
            ++done;
        }
        done += flip_all(mesh, shaper, changes);
        if (done == 0) return;
        changes.next_round();
    }
}

void settle_all(SurfaceMesh& mesh, const std::vector<SurfaceForm>& forms, double far)
{
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds; ++round) {
        FlexibleMesh rough(std::move(mesh));
        coarsen(rough, forms);
        mesh = rough.release();
        settle(mesh, forms);
        FlexibleMesh settled(std::move(mesh));
        join_coincident(settled, Shaper(settled, forms));
        drop_unsettled(settled, forms, far);
        mesh = settled.release();
    }
}

std::vector<Box3> subdivide(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                            double max_error, std::vector<double>& factors,
                            std::int64_t max_triangles, const CreaseDemand& creases)
{
    return Subdivider(mesh, forms, max_error, factors, creases).run(max_triangles);
}

std::int64_t halve_edges(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                         const std::vector<std::array<std::int32_t, 2>>& ends)
{
    std::vector<double> factors;
    return Subdivider(mesh, forms, std::numeric_limits<double>::infinity(), factors, {})
        .halve_all(ends);
}

std::int64_t halve_faces(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms,
                         const std::vector<std::int32_t>& faces)
{
    const Shaper shaper(mesh, forms);
    std::vector<std::array<std::int32_t, 2>> ends;
    for (const std::int32_t f : faces) {
        const std::array<std::int32_t, 3> sides{3 * f, 3 * f + 1, 3 * f + 2};
        double longest = 0.0;
        for (const std::int32_t s : sides) longest = std::max(longest, shaper.length(s));
        for (const std::int32_t s : sides)
            if (shaper.length(s) > 0.5 * longest) ends.push_back({mesh.from(s), mesh.to(s)});
    }
    return halve_edges(mesh, forms, ends);
}

}  // namespace genus
