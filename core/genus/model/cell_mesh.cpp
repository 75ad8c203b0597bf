#include "genus/model/cell_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr int kTaskDepth = 8;        // bisections before the work is handed out: 6 * 2^8 tasks
constexpr std::size_t kMaxCut = 10;  // surfaces through one cell

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

// The arrangement of linear functions in one tetrahedron.

using Row = std::array<double, 4>;

int sign_of(double x)
{
    return x < 0.0 ? -1 : 1;
}
int sign3(double x)
{
    return x < 0.0 ? -1 : x > 0.0 ? 1 : 0;
}

int determinant_sign(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return orient3d(a, b, c, Vec3{});
}

struct CellVertex {
    std::uint8_t corners = 0;  // bit set
    std::uint8_t n_surfaces = 0;
    std::array<std::uint8_t, 3> surfaces{};  // local numbers, ascending
    bool operator==(const CellVertex&) const = default;
};

// A convex piece of the plane of one surface. `label[i]` names what the side from vertex i lies
// on: a local surface number, or -1 - f for the face of the cell opposite corner f.
struct Piece {
    std::vector<CellVertex> vertices;
    std::vector<int> labels;
    unsigned signs = 0;  // bit j set: outside surface j
};

class CellArrangement {
public:
    // Corners in the order of their codes; rows are the values of each surface at the corners.
    CellArrangement(std::array<Vec3, 4> corners, std::vector<Row> rows, bool positive)
        : corners_(corners), rows_(std::move(rows)), positive_(positive)
    {
    }

    // The plane of surface i cut by all surfaces in `cutters`, normals towards larger values.
    std::vector<Piece> cut_plane(std::size_t i, const std::vector<std::size_t>& cutters) const
    {
        std::vector<Piece> pieces{plane(i)}, next;
        for (const std::size_t j : cutters) {
            next.clear();
            for (const Piece& piece : pieces) cut(piece, i, j, next);
            pieces.swap(next);
        }
        return pieces;
    }

    Vec3 position(const CellVertex& v) const
    {
        const std::array<double, 4> w = weights(v);
        double sum = 0.0;
        for (const double x : w) sum += x;
        Vec3 p;
        for (std::size_t m = 0; m < 4; ++m) p += (w[m] / sum) * corners_[m];
        return p;
    }

    const Row& row(std::size_t i) const { return rows_[i]; }

private:
    CellVertex edge_vertex(int m, int n, std::size_t i) const
    {
        CellVertex v;
        v.corners = static_cast<std::uint8_t>(1 << m | 1 << n);
        v.n_surfaces = 1;
        v.surfaces[0] = static_cast<std::uint8_t>(i);
        return v;
    }

    Piece plane(std::size_t i) const
    {
        std::array<int, 4> below{}, above{};
        int n_below = 0, n_above = 0;
        for (int m = 0; m < 4; ++m) (rows_[i][m] < 0.0 ? below[n_below++] : above[n_above++]) = m;
        Piece piece;
        const auto side = [&](int m, int n, int label) {
            piece.vertices.push_back(edge_vertex(m, n, i));
            piece.labels.push_back(-1 - label);
        };
        bool flip;
        if (n_below == 2) {
            const int p = below[0], q = below[1], r = above[0], s = above[1];
            side(p, r, q);
            side(p, s, r);
            side(q, s, p);
            side(q, r, s);
            flip = !even({p, q, r, s});
        } else {
            const int s = n_below == 1 ? below[0] : above[0];
            const auto& rest = n_below == 1 ? above : below;
            side(s, rest[0], rest[2]);
            side(s, rest[1], rest[0]);
            side(s, rest[2], rest[1]);
            flip = even({s, rest[0], rest[1], rest[2]}) != (n_below == 1);
        }
        if (flip == positive_) reverse(piece);
        return piece;
    }

    static bool even(const std::array<int, 4>& order)
    {
        int inversions = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
        return inversions % 2 == 0;
    }

    static void reverse(Piece& piece)
    {
        std::reverse(piece.vertices.begin(), piece.vertices.end());
        // The side from vertex i now is the one that led to it.
        std::reverse(piece.labels.begin(), piece.labels.end());
        std::rotate(piece.labels.begin(), piece.labels.begin() + 1, piece.labels.end());
    }

    // Sign of surface j at a vertex that is not on it.
    int sign_at(const CellVertex& v, std::size_t j) const
    {
        if (v.n_surfaces == 1) return sign_on_edge(v, j);
        if (v.n_surfaces == 2) return sign_on_face(v, j);
        return sign_in_cell(v, j);
    }

    int sign_on_edge(const CellVertex& v, std::size_t j) const
    {
        int m = 0;
        while ((v.corners >> m & 1) == 0) ++m;
        int n = m + 1;
        while ((v.corners >> n & 1) == 0) ++n;
        const std::size_t i = v.surfaces[0];
        const std::size_t lo = std::min(i, j), hi = std::max(i, j);
        const Row &a = rows_[lo], &b = rows_[hi];
        int d = orient2d({{a[m], a[n]}}, {{b[m], b[n]}}, Vec2{});
        if (d == 0) d = sign3(b[n] - b[m]);
        if (d == 0) d = sign3(a[m] - a[n]);
        if (i > j) d = -d;
        return -d * sign_of(rows_[i][n]) >= 0 ? 1 : -1;
    }

    int sign_on_face(const CellVertex& v, std::size_t j) const
    {
        std::array<std::size_t, 3> at{};
        for (std::size_t m = 0, n = 0; m < 4; ++m)
            if ((v.corners >> m & 1) != 0) at[n++] = m;
        const auto row = [&](std::size_t s) {
            return Vec3{{rows_[s][at[0]], rows_[s][at[1]], rows_[s][at[2]]}};
        };
        constexpr Vec3 ones{{1.0, 1.0, 1.0}};
        const std::size_t p = v.surfaces[0], q = v.surfaces[1];
        // Rows in the order of surface numbers; moving row j to the end costs this many swaps.
        std::array<std::size_t, 3> order{p, q, j};
        const bool odd = (j < p) != (j < q);
        std::sort(order.begin(), order.end());
        const Vec3 a = row(order[0]), b = row(order[1]), c = row(order[2]);
        int d = determinant_sign(a, b, c);
        if (d == 0) d = determinant_sign(ones, b, c);
        if (d == 0) d = determinant_sign(a, ones, c);
        if (d == 0) d = determinant_sign(a, b, ones);
        if (odd) d = -d;
        return d * determinant_sign(row(p), row(q), ones) >= 0 ? 1 : -1;
    }

    int sign_in_cell(const CellVertex& v, std::size_t j) const
    {
        const std::array<double, 4> w = weights(v);
        double sum = 0.0, value = 0.0;
        for (std::size_t m = 0; m < 4; ++m) {
            sum += w[m];
            value += w[m] * rows_[j][m];
        }
        return (value < 0.0) != (sum < 0.0) ? -1 : 1;
    }

    // Barycentric coordinates up to a factor: where all surfaces of the vertex vanish.
    std::array<double, 4> weights(const CellVertex& v) const
    {
        std::array<double, 4> w{};
        std::array<std::size_t, 4> at{};
        std::size_t n = 0;
        for (std::size_t m = 0; m < 4; ++m)
            if ((v.corners >> m & 1) != 0) at[n++] = m;
        const Row& a = rows_[v.surfaces[0]];
        if (n == 2) {
            w[at[0]] = a[at[1]];
            w[at[1]] = -a[at[0]];
            if (w[at[0]] == 0.0 && w[at[1]] == 0.0) w[at[0]] = w[at[1]] = 1.0;
        } else if (n == 3) {
            const Row& b = rows_[v.surfaces[1]];
            const Vec3 x =
                cross({{a[at[0]], a[at[1]], a[at[2]]}}, {{b[at[0]], b[at[1]], b[at[2]]}});
            for (std::size_t m = 0; m < 3; ++m) w[at[m]] = x[m];
        } else {
            const Row &b = rows_[v.surfaces[1]], &c = rows_[v.surfaces[2]];
            for (std::size_t m = 0; m < 4; ++m) {
                std::array<std::size_t, 3> k{};
                for (std::size_t i = 0, next = 0; i < 4; ++i)
                    if (i != m) k[next++] = i;
                const double minor =
                    dot(Vec3{{a[k[0]], a[k[1]], a[k[2]]}},
                        cross({{b[k[0]], b[k[1]], b[k[2]]}}, {{c[k[0]], c[k[1]], c[k[2]]}}));
                w[m] = m % 2 == 0 ? minor : -minor;
            }
        }
        // Rounding can leave the cell by a hair; a vertex must not.
        double sum = 0.0;
        for (const double x : w) sum += x;
        bool any = false;
        for (double& x : w) {
            if ((x < 0.0) != (sum < 0.0)) x = 0.0;
            any = any || x != 0.0;
        }
        if (!any)
            for (std::size_t m = 0; m < n; ++m) w[at[m]] = 1.0;
        return w;
    }

    // The vertex where surface j crosses the side `label` of a piece of plane i.
    CellVertex crossing(std::size_t i, std::size_t j, int label) const
    {
        CellVertex v;
        v.surfaces[0] = static_cast<std::uint8_t>(std::min(i, j));
        v.surfaces[1] = static_cast<std::uint8_t>(std::max(i, j));
        v.n_surfaces = 2;
        v.corners = 15;
        if (label < 0) {
            v.corners = static_cast<std::uint8_t>(15 & ~(1 << (-1 - label)));
            return v;
        }
        v.surfaces[2] = static_cast<std::uint8_t>(label);
        v.n_surfaces = 3;
        std::sort(v.surfaces.begin(), v.surfaces.end());
        return v;
    }

    void cut(const Piece& piece, std::size_t i, std::size_t j, std::vector<Piece>& out) const
    {
        const std::size_t n = piece.vertices.size();
        std::vector<int> sign(n);
        int changes = 0;
        for (std::size_t k = 0; k < n; ++k) sign[k] = sign_at(piece.vertices[k], j);
        for (std::size_t k = 0; k < n; ++k) changes += sign[k] != sign[(k + 1) % n];
        if (changes != 2) {
            // None, or rounding that contradicts itself inside the cell: keep it whole, the
            // closedness check outside sees what comes of it.
            out.push_back(piece);
            if (sign[0] > 0) out.back().signs |= 1u << j;
            return;
        }
        for (const int keep : {-1, 1}) {
            Piece part;
            part.signs = piece.signs | (keep > 0 ? 1u << j : 0u);
            for (std::size_t k = 0; k < n; ++k) {
                if (sign[k] == keep) {
                    part.vertices.push_back(piece.vertices[k]);
                    part.labels.push_back(piece.labels[k]);
                }
                if (sign[k] == sign[(k + 1) % n]) continue;
                part.vertices.push_back(crossing(i, j, piece.labels[k]));
                part.labels.push_back(sign[k] == keep ? static_cast<int>(j) : piece.labels[k]);
            }
            out.push_back(std::move(part));
        }
    }

    std::array<Vec3, 4> corners_;
    std::vector<Row> rows_;
    bool positive_;
};

// Joins pieces of one plane and one orientation into loops: sides between two pieces vanish, and
// so do vertices in the middle of a straight side, which a neighbouring cell may not have.
std::vector<std::vector<CellVertex>> join(const std::vector<Piece>& pieces)
{
    struct Side {
        CellVertex from, to;
        int label;
        std::size_t piece;
        bool used = false;
    };
    std::vector<Side> sides;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const auto& v = pieces[p].vertices;
        for (std::size_t k = 0; k < v.size(); ++k)
            sides.push_back({v[k], v[(k + 1) % v.size()], pieces[p].labels[k], p});
    }
    for (std::size_t a = 0; a < sides.size(); ++a)
        for (std::size_t b = a + 1; b < sides.size(); ++b)
            if (!sides[a].used && !sides[b].used && sides[a].from == sides[b].to &&
                sides[a].to == sides[b].from)
                sides[a].used = sides[b].used = true;

    std::vector<std::vector<CellVertex>> loops;
    for (std::size_t start = 0; start < sides.size(); ++start) {
        if (sides[start].used) continue;
        std::vector<std::size_t> chain;
        for (std::size_t at = start; !sides[at].used;) {
            sides[at].used = true;
            chain.push_back(at);
            std::size_t next = at;
            for (std::size_t b = 0; b < sides.size(); ++b) {
                if (sides[b].used || !(sides[b].from == sides[at].to)) continue;
                // Where two pieces touch at a corner only, each keeps its own loop.
                if (next == at || sides[b].piece == sides[at].piece) next = b;
            }
            at = next;
        }
        std::vector<CellVertex> loop;
        for (std::size_t k = 0; k < chain.size(); ++k) {
            const std::size_t before = chain[(k + chain.size() - 1) % chain.size()];
            if (sides[before].label != sides[chain[k]].label) loop.push_back(sides[chain[k]].from);
        }
        if (loop.size() >= 3) loops.push_back(std::move(loop));
    }
    return loops;
}

// Cuts a loop in the plane with this normal into triangles, the best-shaped ear first.
std::vector<Triangle> cut_ears(const std::vector<Vec3>& points, const Vec3& normal)
{
    std::vector<std::int32_t> ring(points.size());
    for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<std::int32_t>(i);
    const auto area = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
        return dot(cross(points[b] - points[a], points[c] - points[a]), normal);
    };
    std::vector<Triangle> triangles;
    while (ring.size() > 3) {
        std::size_t best = 0;
        double best_shape = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::int32_t a = ring[(i + ring.size() - 1) % ring.size()], b = ring[i],
                               c = ring[(i + 1) % ring.size()];
            const double size = area(a, b, c);
            const double longest = std::max({dot(points[b] - points[a], points[b] - points[a]),
                                             dot(points[c] - points[b], points[c] - points[b]),
                                             dot(points[a] - points[c], points[a] - points[c])});
            double shape = longest > 0.0 ? size / longest : 0.0;
            if (ring.size() > 4 || size <= 0.0)
                for (const std::int32_t d : ring)
                    if (d != a && d != b && d != c && area(a, b, d) >= 0.0 &&
                        area(b, c, d) >= 0.0 && area(c, a, d) >= 0.0)
                        shape = std::min(shape, 0.0) - 1.0;
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
    return triangles;
}

double diameter(const std::array<Vec3, 4>& p)
{
    double most = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) most = std::max(most, distance(p[i], p[j]));
    return most;
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
    void find_splits(const LatticeTet& tet, const SignFormula& formula, const CellDemands& demands,
                     std::vector<LatticePoint>& splits)
    {
        descend(tet, formula,
                [&](const LatticeTet& t, const std::array<Vec3, 4>& p, const SignFormula& f) {
                    if (BisectionTree::is_finest(t) || !too_coarse(p, f, demands)) return false;
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
    // Calls visit(tet, corners, formula) where the formula is open, and goes on where it says so.
    template <class Visit>
    void descend(const LatticeTet& tet, const SignFormula& formula, const Visit& visit)
    {
        const std::array<Vec3, 4> p = m_.positions(tet);
        bool known = false;
        for (const std::int32_t s : formula.surfaces()) {
            const Interval range = m_.forms_[s].range(p);
            signs_[s] = range.lo > 0.0 ? Sign{1} : range.hi < 0.0 ? Sign{-1} : Sign{0};
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
        const double turn = dot(ga, gb) < 0.0 ? -1.0 : 1.0;
        double vary = 0.0, far = 0.0;
        for (const Vec3& v : p) {
            vary =
                std::max(vary, norm((a.gradient(v) - ga) / na) + norm((b.gradient(v) - gb) / nb));
            far = std::max(far, std::fabs(a.value(v) / na - turn * b.value(v) / nb));
        }
        return far > most && norm(ga / na - turn * gb / nb) <= vary;
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
        return form.linear_error(p) > max_error * least;
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
        std::vector<Row> values;
        bool known = false;
        for (const std::int32_t s : formula.surfaces()) {
            Row& row = values.emplace_back();
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
            std::vector<Row> kept;
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
              const std::array<std::uint64_t, 4>& codes, std::vector<Row> rows, Part& part)
    {
        const std::vector<std::int32_t>& surfaces = f.surfaces();
        const std::size_t n = surfaces.size();
        if (n > kMaxCut)
            throw ToleranceNotMet("more than ten surfaces meet in one cell", 0.0,
                                  std::numeric_limits<double>::infinity(), {box_of(corners)});
        // inside[bits]: the formula where bit j says "outside surface j".
        std::vector<bool> inside(std::size_t{1} << n);
        for (std::size_t bits = 0; bits < inside.size(); ++bits) {
            for (std::size_t j = 0; j < n; ++j)
                signs_[surfaces[j]] = (bits >> j & 1) != 0 ? Sign{1} : Sign{-1};
            inside[bits] = f.sign(signs_) < 0;
        }
        const bool positive = dot(cross(corners[1] - corners[0], corners[2] - corners[0]),
                                  corners[3] - corners[0]) > 0.0;
        const CellArrangement cell(corners, std::move(rows), positive);
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
            std::vector<Piece> pieces = cell.cut_plane(i, cutters);
            if (cutters.empty()) {
                if (const int b = border(pieces[0].signs); b != 0)
                    add_loop(cell, pieces[0].vertices, b < 0, i, surfaces, codes, corners, part);
                continue;
            }
            std::array<std::vector<Piece>, 2> kept;  // outward along, against the gradient
            for (Piece& piece : pieces)
                if (const int b = border(piece.signs); b != 0)
                    kept[b > 0 ? 0 : 1].push_back(std::move(piece));
            for (const int turned : {0, 1})
                for (const auto& loop : join(kept[turned]))
                    add_loop(cell, loop, turned != 0, i, surfaces, codes, corners, part);
        }
    }

    void add_loop(const CellArrangement& cell, const std::vector<CellVertex>& loop, bool turned,
                  std::size_t own, const std::vector<std::int32_t>& surfaces,
                  const std::array<std::uint64_t, 4>& codes, const std::array<Vec3, 4>& corners,
                  Part& part)
    {
        std::vector<Vec3> points;
        std::vector<std::int32_t> numbers;
        for (const CellVertex& v : loop) {
            points.push_back(cell.position(v));
            VertexKey key{{kNoCorner, kNoCorner, kNoCorner, kNoCorner}, {-1, -1, -1}};
            for (std::size_t m = 0, k = 0; m < 4; ++m)
                if ((v.corners >> m & 1) != 0) key.corners[k++] = codes[m];
            for (std::size_t k = 0; k < v.n_surfaces; ++k)
                key.surfaces[k] = surfaces[v.surfaces[k]];
            const auto [number, is_new] = part.keys.number(key);
            if (is_new) {
                part.points.push_back(points.back());
                part.cell_size.push_back(diameter(corners));
            } else {
                part.cell_size[number] = std::min(part.cell_size[number], diameter(corners));
            }
            numbers.push_back(number);
        }
        for (Triangle t : cut_ears(points, gradient_of(cell.row(own), corners))) {
            for (std::int32_t& v : t) v = numbers[v];
            if (turned) std::swap(t[1], t[2]);
            part.faces.push_back(t);
            part.surface_of_face.push_back(2 * surfaces[own] + (turned ? 1 : 0));
        }
    }

    // Gradient of the linear function with these values at the corners, times a positive factor.
    static Vec3 gradient_of(const Row& row, const std::array<Vec3, 4>& c)
    {
        const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], e3 = c[3] - c[0];
        const double det = dot(e1, cross(e2, e3));
        const Vec3 g = (row[1] - row[0]) * cross(e2, e3) + (row[2] - row[0]) * cross(e3, e1) +
                       (row[3] - row[0]) * cross(e1, e2);
        return det < 0.0 ? -g : g;
    }

    const CellMesher& m_;
    std::vector<Sign> signs_;
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
    parallel_for(tasks.size(), 4, [&](std::size_t begin, std::size_t end) {
        CellWalk walk(*this);
        for (std::size_t i = begin; i < end; ++i) {
            current_progress().check();
            walk.find_splits(tasks[i], formula_, demands, splits[i]);
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
    const std::vector<LatticeTet> tasks = task_roots();
    std::vector<Part> parts(tasks.size());
    parallel_for(tasks.size(), 4, [&](std::size_t begin, std::size_t end) {
        CellWalk walk(*this);
        for (std::size_t i = begin; i < end; ++i) {
            current_progress().check();
            walk.extract(tasks[i], formula_, parts[i]);
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
