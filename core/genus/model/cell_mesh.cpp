#include "genus/model/cell_mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/model/cell_arrangement.h"
#include "genus/model/form_signs.h"

namespace genus {

namespace {

constexpr int kTaskDepth = 8;        // bisections before the work is handed out: 6 * 2^8 tasks
constexpr std::size_t kMaxCut = 10;  // surfaces through one cell
constexpr double kSmall = 20.0;      // beside the smallest cells
constexpr double kOnLine = 1e-12;    // area beside that of a triangle

// Name of a vertex, the same in all cells that share it: the corners of the edge, face or cell it
// lies in and the surfaces that meet there.
struct VertexKey {
    std::array<std::uint64_t, 4> corners;
    std::array<std::int32_t, 3> surfaces;
    bool operator==(const VertexKey&) const = default;
};

constexpr std::uint64_t kNoCorner = ~std::uint64_t{0};

std::size_t hash_of(const VertexKey& key)
{
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    const auto mix = [&h](std::uint64_t x) {
        h = (h ^ x) * 0xbf58476d1ce4e5b9ull;
        h ^= h >> 31;
    };
    for (const std::uint64_t c : key.corners) mix(c);
    for (const std::int32_t s : key.surfaces) mix(static_cast<std::uint32_t>(s));
    return h;
}

// Numbers keys in the order of their first appearance.
class KeyTable {
public:
    std::pair<std::int32_t, bool> number(const VertexKey& key)
    {
        if (2 * (keys_.size() + 1) > slots_.size()) grow();
        std::size_t& slot = find(key);
        const bool is_new = slot == 0;
        if (is_new) {
            keys_.push_back(key);
            slot = keys_.size();
        }
        return {static_cast<std::int32_t>(slot - 1), is_new};
    }
    const std::vector<VertexKey>& keys() const { return keys_; }

private:
    std::size_t& find(const VertexKey& key)
    {
        const std::size_t mask = slots_.size() - 1;
        std::size_t i = hash_of(key) & mask;
        while (slots_[i] != 0 && !(keys_[slots_[i] - 1] == key)) i = (i + 1) & mask;
        return slots_[i];
    }
    void grow()
    {
        slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), 0);
        for (std::size_t k = 0; k < keys_.size(); ++k) find(keys_[k]) = k + 1;
    }

    std::vector<VertexKey> keys_;
    std::vector<std::size_t> slots_;  // number + 1, 0 where free
};

// What one task finds.
struct Part {
    KeyTable keys;
    std::vector<Vec3> points;
    std::vector<double> cell_size;
    std::vector<Triangle> faces;
    std::vector<std::int32_t> surface_of_face;
};

// Cuts a loop in the plane with this normal into triangles, the best-shaped ear first. It may pass
// through a point twice, where pieces touch that hang together elsewhere.
void cut_ears(const std::vector<Vec3>& points, const Vec3& normal, std::vector<Triangle>& triangles)
{
    triangles.clear();
    if (points.size() == 3) {
        triangles.push_back({0, 1, 2});
        return;
    }
    std::vector<std::int32_t> ring(points.size());
    for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<std::int32_t>(i);
    const auto area = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
        return dot(cross(points[b] - points[a], points[c] - points[a]), normal);
    };
    while (ring.size() > 3) {
        std::size_t best = 0;
        double best_shape = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::int32_t a = ring[(i + ring.size() - 1) % ring.size()], b = ring[i],
                               c = ring[(i + 1) % ring.size()];
            if (points[a] == points[c]) continue;
            const double size = area(a, b, c);
            const double longest = std::max({dot(points[b] - points[a], points[b] - points[a]),
                                             dot(points[c] - points[b], points[c] - points[b]),
                                             dot(points[a] - points[c], points[a] - points[c])});
            double shape = longest > 0.0 ? size / longest : 0.0;
            // Vertices in the middle of straight sides are on the border but for rounding.
            const double least = -kOnLine * std::fabs(size);
            if (ring.size() > 4 || size <= 0.0)
                for (const std::int32_t d : ring) {
                    const Vec3& p = points[d];
                    if (p != points[a] && p != points[b] && p != points[c] &&
                        area(a, b, d) >= least && area(b, c, d) >= least && area(c, a, d) >= least)
                        shape = std::min(shape, 0.0) - 1.0;
                }
            // For four corners both halves count.
            if (ring.size() == 4) {
                const std::int32_t d = ring[(i + 2) % 4];
                const double other = area(a, c, d);
                const double span = std::max({dot(points[c] - points[a], points[c] - points[a]),
                                              dot(points[d] - points[c], points[d] - points[c]),
                                              dot(points[a] - points[d], points[a] - points[d])});
                shape = std::min(shape, span > 0.0 ? other / span : 0.0);
            }
            if (shape > best_shape) {
                best_shape = shape;
                best = i;
            }
        }
        triangles.push_back({ring[(best + ring.size() - 1) % ring.size()], ring[best],
                             ring[(best + 1) % ring.size()]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(best));
    }
    triangles.push_back({ring[0], ring[1], ring[2]});
}

double diameter(const std::array<Vec3, 4>& p)
{
    double most = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j)
            most = std::max(most, dot(p[j] - p[i], p[j] - p[i]));
    return std::sqrt(most);
}

Box3 box_of(const std::array<Vec3, 4>& p)
{
    Box3 box;
    for (const Vec3& v : p) box.add(v);
    return box;
}

}  // namespace

// One walk down from a root of the tree; each task has its own.
class CellWalk {
public:
    explicit CellWalk(const CellMesher& mesher) : m_(mesher), signs_(mesher.forms_.size(), Sign{0})
    {
    }

    // The midpoints that must be split below `tet`, as far as nobody else asks for more.
    // `n_small` counts the small cells of all walks.
    void find_splits(const LatticeTet& tet, const SignFormula& formula, const CellDemands& demands,
                     std::vector<LatticePoint>& splits, std::atomic<std::int64_t>& n_small)
    {
        descend(tet, formula,
                [&](const LatticeTet& t, const std::array<Vec3, 4>& p, const SignFormula& f) {
                    if (BisectionTree::is_finest(t) || !too_coarse(p, f, demands)) return false;
                    if (diameter(p) < kSmall * demands.min_size && ++n_small >= demands.max_small)
                        give_up();
                    splits.push_back(BisectionTree::midpoint(t));
                    return true;
                });
    }

    void extract(const LatticeTet& tet, const SignFormula& formula, Part& part)
    {
        descend(tet, formula,
                [&](const LatticeTet& t, const std::array<Vec3, 4>& p, const SignFormula& f) {
                    if (m_.tree_.is_split(t)) return true;
                    contour(t, p, f, part);
                    return false;
                });
    }

private:
    // Without a place: which walk comes here first depends on threads.
    [[noreturn]] static void give_up()
    {
        throw ToleranceNotMet("the budget of cells is spent", 0.0,
                              std::numeric_limits<double>::infinity(), {});
    }

    // Calls visit(tet, corners, formula) where the formula is open, and goes on where it says so.
    template <class Visit>
    void descend(const LatticeTet& tet, const SignFormula& formula, const Visit& visit)
    {
        const std::array<Vec3, 4> p = m_.positions(tet);
        bool known = false;
        for (const std::int32_t s : formula.surfaces()) {
            signs_[s] = sign_of(m_.forms_[s].range(p));
            known = known || signs_[s] != 0;
        }
        const auto go_on = [&](const SignFormula& f) {
            if (f.constant() != 0 || !visit(tet, p, f)) return;
            current_progress().check();  // one root alone can hold minutes of work
            const auto [first, second] = BisectionTree::children(tet);
            descend(first, f, visit);
            descend(second, f, visit);
        };
        if (known)
            go_on(formula.simplified(signs_));
        else
            go_on(formula);
    }

    bool too_coarse(const std::array<Vec3, 4>& p, const SignFormula& f,
                    const CellDemands& demands) const
    {
        const double size = diameter(p);
        if (size <= demands.min_size) return false;
        if (f.surfaces().size() > kMaxCut) return true;
        if (!demands.finer.empty()) {
            bool finer = false;
            m_.finer_.visit_overlapping(box_of(p), [&](std::int32_t i) {
                finer = finer || size > demands.finer[static_cast<std::size_t>(i)].second;
            });
            if (finer) return true;
        }
        const double cosine =
            f.surfaces().size() > 1 ? demands.min_cosine_several : demands.min_cosine;
        for (const std::int32_t s : f.surfaces())
            if (!m_.forms_[s].is_plane() &&
                bends_too_much(m_.forms_[s], p, demands.max_error, cosine))
                return true;
        for (const std::int32_t s : f.surfaces())
            for (const std::int32_t t : f.surfaces())
                if (s < t && touch_too_far(m_.forms_[s], m_.forms_[t], p, demands.touch))
                    return true;
        return false;
    }

    // True if the normals of two surfaces agree somewhere in the cell, up to their sign, and yet
    // the surfaces, as linear functions of equal slope, differ by more than `most`.
    static bool touch_too_far(const SurfaceForm& a, const SurfaceForm& b,
                              const std::array<Vec3, 4>& p, double most)
    {
        const Vec3 c = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        const Vec3 ga = a.gradient(c), gb = b.gradient(c);
        const double na = norm(ga), nb = norm(gb);
        if (!(na > 0.0) || !(nb > 0.0)) return false;
        // The difference of the two, of equal slope in the middle: where it is linear to speak of,
        // or keeps its sign, they cross as their interpolants do, or not at all.
        const double of_a = 1.0 / na, of_b = (dot(ga, gb) < 0.0 ? 1.0 : -1.0) / nb;
        const Vec3 slope = of_a * ga + of_b * gb;
        std::array<double, 4> apart;
        double vary = 0.0, far = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            vary = std::max(vary, norm(of_a * a.gradient(p[i]) + of_b * b.gradient(p[i]) - slope));
            apart[i] = of_a * a.value(p[i]) + of_b * b.value(p[i]);
            far = std::max(far, std::fabs(apart[i]));
        }
        if (far <= most || norm(slope) > vary) return false;
        if (!a.is_quadratic() || !b.is_quadratic()) return true;
        const bool above = apart[0] > 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
            if ((apart[i] > 0.0) != above) return true;
            for (std::size_t j = i + 1; j < 4; ++j) {
                const Vec3 e = p[j] - p[i];
                const double between = apart[i] + apart[j] - (of_a * a.bend(e) + of_b * b.bend(e));
                if ((between > 0.0) != above) return true;
            }
        }
        return false;
    }

    static bool bends_too_much(const SurfaceForm& form, const std::array<Vec3, 4>& p,
                               double max_error, double min_cosine)
    {
        std::array<Vec3, 4> g;
        Vec3 mean;
        for (std::size_t i = 0; i < 4; ++i) {
            g[i] = form.gradient(p[i]);
            mean += g[i];
        }
        const Vec3 d = normalized(mean);
        double least = std::numeric_limits<double>::infinity();
        for (const Vec3& v : g) {
            const double along = dot(v, d);
            if (!(along > min_cosine * norm(v))) return true;
            least = std::min(least, along);
        }
        // Where there is no bound at any size, as at the end of a root, it says nothing.
        const double error = form.linear_error(p);
        return std::isfinite(error) && error > max_error * least;
    }

    void contour(const LatticeTet& tet, const std::array<Vec3, 4>& p, const SignFormula& formula,
                 Part& part)
    {
        std::array<std::size_t, 4> order{0, 1, 2, 3};
        std::array<std::uint64_t, 4> codes;
        for (std::size_t i = 0; i < 4; ++i) codes[i] = tet.corner[i].code();
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return codes[a] < codes[b]; });
        std::array<Vec3, 4> corners;
        for (std::size_t i = 0; i < 4; ++i) corners[i] = p[order[i]];
        std::sort(codes.begin(), codes.end());

        // Surfaces without a change of sign among the corners do not cut the cell.
        std::vector<CellRow> values;
        bool known = false;
        for (const std::int32_t s : formula.surfaces()) {
            CellRow& row = values.emplace_back();
            int n_below = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                row[i] = m_.forms_[s].value(corners[i]);
                n_below += row[i] < 0.0;
            }
            signs_[s] = n_below == 0 ? Sign{1} : n_below == 4 ? Sign{-1} : Sign{0};
            known = known || signs_[s] != 0;
        }
        if (known) {
            const SignFormula f = formula.simplified(signs_);
            if (f.constant() != 0) return;
            std::vector<CellRow> kept;
            for (std::size_t i = 0; i < values.size(); ++i)
                if (std::binary_search(f.surfaces().begin(), f.surfaces().end(),
                                       formula.surfaces()[i]))
                    kept.push_back(values[i]);
            emit(f, corners, codes, std::move(kept), part);
        } else {
            emit(formula, corners, codes, std::move(values), part);
        }
    }

    void emit(const SignFormula& f, const std::array<Vec3, 4>& corners,
              const std::array<std::uint64_t, 4>& codes, std::vector<CellRow> rows, Part& part)
    {
        const std::vector<std::int32_t>& surfaces = f.surfaces();
        const std::size_t n = surfaces.size();
        if (n > kMaxCut)
            throw ToleranceNotMet("more than ten surfaces meet in one cell", 0.0,
                                  std::numeric_limits<double>::infinity(), {box_of(corners)});
        const bool positive = dot(cross(corners[1] - corners[0], corners[2] - corners[0]),
                                  corners[3] - corners[0]) > 0.0;
        const CellArrangement cell(corners, std::move(rows), positive);
        if (n == 1) {
            signs_[surfaces[0]] = 1;
            const Sign outside = f.sign(signs_);
            signs_[surfaces[0]] = -1;
            const bool turned = f.sign(signs_) > 0;
            if (f.sign(signs_) == outside) return;
            add_loop(cell, cell.plane(0).vertices, turned, 0, surfaces, codes, corners, part);
            return;
        }
        // inside[bits]: the formula where bit j says "outside surface j".
        std::vector<bool> inside(std::size_t{1} << n);
        for (std::size_t bits = 0; bits < inside.size(); ++bits) {
            for (std::size_t j = 0; j < n; ++j)
                signs_[surfaces[j]] = (bits >> j & 1) != 0 ? Sign{1} : Sign{-1};
            inside[bits] = f.sign(signs_) < 0;
        }
        std::vector<OwnLoop> loops;
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t own = std::size_t{1} << i;
            // 0: both sides alike, 1: matter where the surface is negative, -1: the other way.
            const auto border = [&](std::size_t bits) {
                return static_cast<int>(inside[bits & ~own]) - static_cast<int>(inside[bits | own]);
            };
            std::vector<std::size_t> cutters;
            for (std::size_t j = 0; j < n; ++j)
                for (std::size_t bits = 0; j != i && bits < inside.size(); ++bits)
                    if (border(bits) != border(bits ^ (std::size_t{1} << j))) {
                        cutters.push_back(j);
                        break;
                    }
            std::vector<CellPiece> pieces = cell.cut_plane(i, cutters);
            if (cutters.empty()) {
                if (const int b = border(pieces[0].signs); b != 0)
                    loops.push_back({border_of(pieces[0]), i, b < 0, true});
                continue;
            }
            std::array<std::vector<CellPiece>, 2> kept;  // outward along, against the gradient
            for (CellPiece& piece : pieces)
                if (const int b = border(piece.signs); b != 0)
                    kept[b > 0 ? 0 : 1].push_back(std::move(piece));
            for (const int turned : {0, 1}) {
                if (kept[turned].size() == 1) {
                    loops.push_back({border_of(kept[turned][0]), i, turned != 0, true});
                    continue;
                }
                for (CellLoop& loop : join(kept[turned]))
                    loops.push_back({std::move(loop), i, turned != 0, false});
            }
        }
        drop_straight(loops);
        for (const OwnLoop& loop : loops)
            if (loop.loop.vertices.size() >= 3)
                add_loop(cell, loop.loop.vertices, loop.turned, loop.own, surfaces, codes, corners,
                         part);
    }

    // A loop on the plane of a surface, turned against its gradient or not.
    struct OwnLoop {
        CellLoop loop;
        std::size_t own;
        bool turned;
        bool is_piece;  // convex, so that it has neither straight corners nor spikes
    };

    // Where the solid touches itself along an edge, what is straight for one loop may be the corner
    // of another: then it stays for both.
    static void drop_straight(std::vector<OwnLoop>& loops)
    {
        if (std::all_of(loops.begin(), loops.end(), [](const OwnLoop& l) { return l.is_piece; }))
            return;
        std::vector<CellVertex> corners;
        for (const OwnLoop& l : loops)
            for (std::size_t k = 0; k < l.loop.vertices.size(); ++k)
                if (l.loop.is_straight[k] == 0 && l.loop.vertices[k].n_surfaces == 3)
                    corners.push_back(l.loop.vertices[k]);
        for (OwnLoop& l : loops) {
            std::vector<CellVertex> kept;
            for (std::size_t k = 0; k < l.loop.vertices.size(); ++k) {
                const CellVertex& v = l.loop.vertices[k];
                if (l.loop.is_straight[k] == 0 ||
                    std::find(corners.begin(), corners.end(), v) != corners.end())
                    kept.push_back(v);
            }
            l.loop.vertices = without_spikes(kept);
        }
    }

    // A way to a vertex and straight back bounds nothing.
    static std::vector<CellVertex> without_spikes(const std::vector<CellVertex>& loop)
    {
        std::vector<CellVertex> kept;
        for (const CellVertex& v : loop) {
            kept.push_back(v);
            const std::size_t n = kept.size();
            if (n >= 3 && kept[n - 1] == kept[n - 3]) kept.resize(n - 2);
        }
        while (kept.size() >= 3 && kept[kept.size() - 2] == kept[0]) kept.resize(kept.size() - 2);
        while (kept.size() >= 3 && kept[1] == kept.back())
            kept.erase(kept.begin(), kept.begin() + 2);
        return kept;
    }

    void add_loop(const CellArrangement& cell, std::span<const CellVertex> loop, bool turned,
                  std::size_t own, const std::vector<std::int32_t>& surfaces,
                  const std::array<std::uint64_t, 4>& codes, const std::array<Vec3, 4>& corners,
                  Part& part)
    {
        points_.clear();
        numbers_.clear();
        const double size = diameter(corners);
        for (const CellVertex& v : loop) {
            points_.push_back(cell.position(v));
            VertexKey key{{kNoCorner, kNoCorner, kNoCorner, kNoCorner}, {-1, -1, -1}};
            for (std::size_t m = 0, k = 0; m < 4; ++m)
                if ((v.corners >> m & 1) != 0) key.corners[k++] = codes[m];
            for (std::size_t k = 0; k < v.n_surfaces; ++k)
                key.surfaces[k] = surfaces[v.surfaces[k]];
            const auto [number, is_new] = part.keys.number(key);
            if (is_new) {
                part.points.push_back(points_.back());
                part.cell_size.push_back(size);
            } else {
                part.cell_size[number] = std::min(part.cell_size[number], size);
            }
            numbers_.push_back(number);
        }
        cut_ears(points_, gradient_of(cell.row(own), corners), triangles_);
        for (Triangle t : triangles_) {
            for (std::int32_t& v : t) v = numbers_[v];
            if (turned) std::swap(t[1], t[2]);
            part.faces.push_back(t);
            part.surface_of_face.push_back(2 * surfaces[own] + (turned ? 1 : 0));
        }
    }

    // Gradient of the linear function with these values at the corners, times a positive factor.
    static Vec3 gradient_of(const CellRow& row, const std::array<Vec3, 4>& c)
    {
        const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], e3 = c[3] - c[0];
        const double det = dot(e1, cross(e2, e3));
        const Vec3 g = (row[1] - row[0]) * cross(e2, e3) + (row[2] - row[0]) * cross(e3, e1) +
                       (row[3] - row[0]) * cross(e1, e2);
        return det < 0.0 ? -g : g;
    }

    const CellMesher& m_;
    std::vector<Sign> signs_;
    // Of the loop at hand.
    std::vector<Vec3> points_;
    std::vector<std::int32_t> numbers_;
    std::vector<Triangle> triangles_;
};

namespace {

std::vector<LatticeTet> task_roots()
{
    std::vector<LatticeTet> tets;
    for (const LatticeTet& root : BisectionTree::roots()) tets.push_back(root);
    for (int depth = 0; depth < kTaskDepth; ++depth) {
        std::vector<LatticeTet> next;
        next.reserve(2 * tets.size());
        for (const LatticeTet& t : tets) {
            const auto [first, second] = BisectionTree::children(t);
            next.push_back(first);
            next.push_back(second);
        }
        tets.swap(next);
    }
    return tets;
}

}  // namespace

Box3 cell_cube(const Box3& box)
{
    const Vec3 size = box.size();
    const double side = 1.1379 * std::max({size[0], size[1], size[2]});
    const Vec3 c = box.center();
    const Vec3 shift{{0.0173205 * side, -0.0141421 * side, 0.0223607 * side}};
    Box3 cube{c + shift - Box3::filled(0.5 * side), c + shift + Box3::filled(0.5 * side)};
    return cube;
}

CellMesher::CellMesher(const SignFormula& formula, const std::vector<SurfaceForm>& forms,
                       const Box3& box)
    : formula_(formula),
      forms_(forms),
      cube_(box),
      step_((box.max[0] - box.min[0]) / BisectionTree::kSize)
{
    // All tasks exist from the start, so that each is independent of the others.
    std::vector<LatticeTet> tets(6);
    for (std::size_t i = 0; i < 6; ++i) tets[i] = BisectionTree::roots()[i];
    for (int depth = 0; depth < kTaskDepth; ++depth) {
        std::vector<LatticeTet> next;
        for (const LatticeTet& t : tets) {
            tree_.split(BisectionTree::midpoint(t));
            const auto [first, second] = BisectionTree::children(t);
            next.push_back(first);
            next.push_back(second);
        }
        tets.swap(next);
    }
}

Vec3 CellMesher::position(const LatticePoint& p) const
{
    Vec3 x = cube_.min;
    for (std::size_t i = 0; i < 3; ++i) x[i] += step_ * p.c[i];
    return x;
}

std::array<Vec3, 4> CellMesher::positions(const LatticeTet& tet) const
{
    return {position(tet.corner[0]), position(tet.corner[1]), position(tet.corner[2]),
            position(tet.corner[3])};
}

void CellMesher::refine(const CellDemands& demands, std::int64_t max_cells)
{
    std::vector<Box3> places;
    for (const auto& [place, size] : demands.finer) places.push_back(place);
    finer_ = BoxTree(places);
    const std::vector<LatticeTet> tasks = task_roots();
    std::vector<std::vector<LatticePoint>> splits(tasks.size());
    std::atomic<std::int64_t> n_small{0};
    parallel_for(tasks.size(), 4, [&](std::size_t begin, std::size_t end) {
        CellWalk walk(*this);
        for (std::size_t i = begin; i < end; ++i) {
            current_progress().check();
            walk.find_splits(tasks[i], formula_, demands, splits[i], n_small);
        }
    });
    for (const auto& list : splits)
        for (const LatticePoint& m : list) {
            tree_.split(m);
            if (static_cast<std::int64_t>(tree_.n_splits()) > max_cells)
                throw ToleranceNotMet("the budget of cells is spent", demands.max_error,
                                      std::numeric_limits<double>::infinity(), {cube_});
        }
}

SurfaceMesh CellMesher::extract() const
{
    constexpr std::size_t kGrain = 16;
    const std::vector<LatticeTet> tasks = task_roots();
    std::vector<Part> parts((tasks.size() + kGrain - 1) / kGrain);
    parallel_for(tasks.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        CellWalk walk(*this);
        for (std::size_t i = begin; i < end; ++i) {
            current_progress().check();
            walk.extract(tasks[i], formula_, parts[begin / kGrain]);
        }
    });
    SurfaceMesh result;
    KeyTable all;
    std::vector<std::int32_t> number;
    for (const Part& part : parts) {
        number.clear();
        for (std::size_t v = 0; v < part.points.size(); ++v) {
            const VertexKey& key = part.keys.keys()[v];
            const auto [n, is_new] = all.number(key);
            number.push_back(n);
            if (!is_new) {
                result.cell_size[n] = std::min(result.cell_size[n], part.cell_size[v]);
                continue;
            }
            result.cell_size.push_back(part.cell_size[v]);
            result.mesh.vertices.push_back(part.points[v]);
            result.surfaces_of_vertex.push_back(key.surfaces);
        }
        for (const Triangle& t : part.faces)
            result.mesh.faces.push_back({number[t[0]], number[t[1]], number[t[2]]});
        result.surface_of_face.insert(result.surface_of_face.end(), part.surface_of_face.begin(),
                                      part.surface_of_face.end());
    }
    return result;
}

}  // namespace genus
