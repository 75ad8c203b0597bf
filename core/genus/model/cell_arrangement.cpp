#include "genus/model/cell_arrangement.h"

#include <algorithm>

#include "genus/base/predicates.h"

namespace genus {

namespace {

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

}  // namespace

std::vector<CellPiece> CellArrangement::cut_plane(std::size_t i,
                                                  const std::vector<std::size_t>& cutters) const
{
    std::vector<CellPiece> pieces{plane(i)}, next;
    for (const std::size_t j : cutters) {
        next.clear();
        for (const CellPiece& piece : pieces) cut(piece, i, j, next);
        pieces.swap(next);
    }
    return pieces;
}

Vec3 CellArrangement::position(const CellVertex& v) const
{
    const std::array<double, 4> w = weights(v);
    double sum = 0.0;
    for (const double x : w) sum += x;
    Vec3 p;
    for (std::size_t m = 0; m < 4; ++m) p += (w[m] / sum) * corners_[m];
    return p;
}

CellVertex CellArrangement::edge_vertex(int m, int n, std::size_t i) const
{
    CellVertex v;
    v.corners = static_cast<std::uint8_t>(1 << m | 1 << n);
    v.n_surfaces = 1;
    v.surfaces[0] = static_cast<std::uint8_t>(i);
    return v;
}

CellPiece CellArrangement::plane(std::size_t i) const
{
    std::array<int, 4> below{}, above{};
    int n_below = 0, n_above = 0;
    for (int m = 0; m < 4; ++m) (rows_[i][m] < 0.0 ? below[n_below++] : above[n_above++]) = m;
    CellPiece piece;
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

bool CellArrangement::even(const std::array<int, 4>& order)
{
    int inversions = 0;
    for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) inversions += order[i] > order[j];
    return inversions % 2 == 0;
}

void CellArrangement::reverse(CellPiece& piece)
{
    std::reverse(piece.vertices.begin(), piece.vertices.end());
    // The side from vertex i now is the one that led to it.
    std::reverse(piece.labels.begin(), piece.labels.end());
    std::rotate(piece.labels.begin(), piece.labels.begin() + 1, piece.labels.end());
}

int CellArrangement::sign_at(const CellVertex& v, std::size_t j) const
{
    if (v.n_surfaces == 1) return sign_on_edge(v, j);
    if (v.n_surfaces == 2) return sign_on_face(v, j);
    return sign_in_cell(v, j);
}

int CellArrangement::sign_on_edge(const CellVertex& v, std::size_t j) const
{
    int m = 0;
    while ((v.corners >> m & 1) == 0) ++m;
    int n = m + 1;
    while ((v.corners >> n & 1) == 0) ++n;
    const std::size_t i = v.surfaces[0];
    const std::size_t lo = std::min(i, j), hi = std::max(i, j);
    const CellRow &a = rows_[lo], &b = rows_[hi];
    int d = orient2d({{a[m], a[n]}}, {{b[m], b[n]}}, Vec2{});
    if (d == 0) d = sign3(b[n] - b[m]);
    if (d == 0) d = sign3(a[m] - a[n]);
    if (i > j) d = -d;
    return -d * sign_of(rows_[i][n]) >= 0 ? 1 : -1;
}

int CellArrangement::sign_on_face(const CellVertex& v, std::size_t j) const
{
    std::array<std::size_t, 3> at{};
    for (std::size_t m = 0, n = 0; m < 4; ++m)
        if ((v.corners >> m & 1) != 0) at[n++] = m;
    const auto row = [&](std::size_t s) {
        return Vec3{{rows_[s][at[0]], rows_[s][at[1]], rows_[s][at[2]]}};
    };
    constexpr Vec3 ones{{1.0, 1.0, 1.0}};
    const std::size_t p = v.surfaces[0], q = v.surfaces[1];
    // CellRows in the order of surface numbers; moving row j to the end costs this many swaps.
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

int CellArrangement::sign_in_cell(const CellVertex& v, std::size_t j) const
{
    const std::array<double, 4> w = weights(v);
    double sum = 0.0, value = 0.0;
    for (std::size_t m = 0; m < 4; ++m) {
        sum += w[m];
        value += w[m] * rows_[j][m];
    }
    return (value < 0.0) != (sum < 0.0) ? -1 : 1;
}

std::array<double, 4> CellArrangement::weights(const CellVertex& v) const
{
    std::array<double, 4> w{};
    std::array<std::size_t, 4> at{};
    std::size_t n = 0;
    for (std::size_t m = 0; m < 4; ++m)
        if ((v.corners >> m & 1) != 0) at[n++] = m;
    const CellRow& a = rows_[v.surfaces[0]];
    if (n == 2) {
        w[at[0]] = a[at[1]];
        w[at[1]] = -a[at[0]];
        if (w[at[0]] == 0.0 && w[at[1]] == 0.0) w[at[0]] = w[at[1]] = 1.0;
    } else if (n == 3) {
        const CellRow& b = rows_[v.surfaces[1]];
        const Vec3 x = cross({{a[at[0]], a[at[1]], a[at[2]]}}, {{b[at[0]], b[at[1]], b[at[2]]}});
        for (std::size_t m = 0; m < 3; ++m) w[at[m]] = x[m];
    } else {
        const CellRow &b = rows_[v.surfaces[1]], &c = rows_[v.surfaces[2]];
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

CellVertex CellArrangement::crossing(std::size_t i, std::size_t j, int label) const
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

void CellArrangement::cut(const CellPiece& piece, std::size_t i, std::size_t j,
                          std::vector<CellPiece>& out) const
{
    const std::size_t n = piece.vertices.size();
    std::array<int, CellPiece::kMostSides> sign{};
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
        CellPiece part;
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

CellLoop border_of(const CellPiece& piece)
{
    return {{piece.vertices.begin(), piece.vertices.end()},
            std::vector<char>(piece.vertices.size(), 0)};
}

std::vector<CellLoop> join(const std::vector<CellPiece>& pieces)
{
    struct Side {
        CellVertex from, to;
        int label;
        std::size_t next;  // in its piece
        std::ptrdiff_t across = -1;
        bool used = false;
    };
    std::vector<Side> sides;
    for (const CellPiece& piece : pieces) {
        const std::size_t n = piece.vertices.size(), first = sides.size();
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t next = (k + 1) % n;
            sides.push_back(
                {piece.vertices[k], piece.vertices[next], piece.labels[k], first + next});
        }
    }
    for (std::size_t a = 0; a < sides.size(); ++a)
        for (std::size_t b = a + 1; b < sides.size(); ++b)
            if (sides[a].across < 0 && sides[b].across < 0 && sides[a].from == sides[b].to &&
                sides[a].to == sides[b].from) {
                sides[a].across = static_cast<std::ptrdiff_t>(b);
                sides[b].across = static_cast<std::ptrdiff_t>(a);
            }

    std::vector<CellLoop> loops;
    for (std::size_t start = 0; start < sides.size(); ++start) {
        if (sides[start].across >= 0 || sides[start].used) continue;
        // On round a vertex from piece to piece: pieces that touch at a corner only each keep
        // their own loop.
        std::vector<std::size_t> chain;
        for (std::size_t at = start; !sides[at].used;) {
            sides[at].used = true;
            chain.push_back(at);
            at = sides[at].next;
            while (sides[at].across >= 0) at = sides[sides[at].across].next;
        }
        CellLoop loop;
        int corners = 0;
        for (std::size_t k = 0; k < chain.size(); ++k) {
            const std::size_t before = chain[(k + chain.size() - 1) % chain.size()];
            const bool straight = sides[before].label == sides[chain[k]].label;
            loop.vertices.push_back(sides[chain[k]].from);
            loop.is_straight.push_back(straight ? 1 : 0);
            corners += straight ? 0 : 1;
        }
        if (corners >= 3) loops.push_back(std::move(loop));
    }
    return loops;
}

}  // namespace genus
