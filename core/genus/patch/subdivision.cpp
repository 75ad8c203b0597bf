#include "genus/patch/subdivision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::int64_t kMaxCorners = std::int64_t{1} << 30;

struct Edge {
    std::int32_t a, b;  // a < b
    int faces = 0;
    double sharpness = 0.0;
    Vec3 opposite;  // sum over its faces: of face points, or of third corners
};

std::size_t at(std::int64_t i)
{
    return static_cast<std::size_t>(i);
}

std::pair<std::int32_t, std::int32_t> ordered(std::int32_t a, std::int32_t b)
{
    return a < b ? std::pair(a, b) : std::pair(b, a);
}

// Edges in order of their vertices, and for each corner of each face the edge to the next corner.
struct EdgeList {
    std::vector<Edge> edges;
    std::vector<std::int32_t> of_corner;

    std::size_t find(std::int32_t a, std::int32_t b) const
    {
        const auto key = ordered(a, b);
        const auto e =
            std::lower_bound(edges.begin(), edges.end(), key,
                             [](const Edge& x, const auto& k) { return std::pair(x.a, x.b) < k; });
        return e != edges.end() && std::pair(e->a, e->b) == key
                   ? static_cast<std::size_t>(e - edges.begin())
                   : edges.size();
    }
};

void check_mesh(const PolygonMesh& mesh, bool triangles)
{
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        require(face.size() >= 3, "subdivision: a face has fewer than three corners");
        require(!triangles || face.size() == 3, "loop_subdivision: a face is no triangle");
        std::vector<std::int32_t> sorted(face.begin(), face.end());
        std::sort(sorted.begin(), sorted.end());
        require(sorted.front() >= 0 && at(sorted.back()) < mesh.n_vertices(),
                "subdivision: a face names a vertex that is not there");
        require(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(),
                "subdivision: a face has a vertex twice");
    }
    for (const Vec3& p : mesh.vertices)
        require(is_finite(p), "subdivision: a coordinate is not finite");
}

EdgeList edges_of(const SubdivisionMesh& m)
{
    const PolygonMesh& mesh = m.mesh;
    struct Side {
        std::int32_t a, b;
        std::size_t corner;
    };
    std::vector<Side> sides;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        for (std::size_t k = 0; k < face.size(); ++k) {
            const auto [a, b] = ordered(face[k], face[(k + 1) % face.size()]);
            sides.push_back({a, b, at(mesh.starts[f]) + k});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
        return std::array{std::int64_t{x.a}, std::int64_t{x.b},
                          static_cast<std::int64_t>(x.corner)} <
               std::array{std::int64_t{y.a}, std::int64_t{y.b},
                          static_cast<std::int64_t>(y.corner)};
    });
    EdgeList list;
    list.of_corner.resize(sides.size());
    for (const Side& s : sides) {
        if (list.edges.empty() || list.edges.back().a != s.a || list.edges.back().b != s.b)
            list.edges.push_back({s.a, s.b, 0, 0.0, {}});
        ++list.edges.back().faces;
        list.of_corner[s.corner] = static_cast<std::int32_t>(list.edges.size() - 1);
    }
    for (const Crease& c : m.creases) {
        require(c.sharpness >= 0.0, "subdivision: sharpness", c.sharpness, "not negative");
        const std::size_t e = list.find(c.a, c.b);
        require(e < list.edges.size(), "subdivision: a crease is no edge of the mesh");
        list.edges[e].sharpness = std::max(list.edges[e].sharpness, c.sharpness);
    }
    for (Edge& e : list.edges)
        if (e.faces != 2) e.sharpness = std::numeric_limits<double>::infinity();
    return list;
}

// What a vertex needs to know of its surroundings.
struct Star {
    int edges = 0, faces = 0, sharp = 0;
    Vec3 neighbours, face_points;  // sums
    double sharpness = 0.0;        // sum over sharp edges
    std::array<Vec3, 2> crease;    // far ends of the first two sharp edges
    bool corner = false;
};

std::vector<Star> stars_of(const SubdivisionMesh& m, const EdgeList& list)
{
    std::vector<Star> stars(m.mesh.n_vertices());
    for (const Edge& e : list.edges)
        for (const auto& [v, w] : {std::pair(e.a, e.b), std::pair(e.b, e.a)}) {
            Star& s = stars[at(v)];
            const Vec3& p = m.mesh.vertices[at(w)];
            ++s.edges;
            s.neighbours += p;
            if (e.sharpness > 0.0) {
                if (s.sharp < 2) s.crease[at(s.sharp)] = p;
                ++s.sharp;
                s.sharpness += e.sharpness;
            }
        }
    for (const std::int32_t c : m.corners) {
        require(c >= 0 && at(c) < stars.size(), "subdivision: a corner is no vertex of the mesh");
        stars[at(c)].corner = true;
    }
    return stars;
}

// Blends the smooth place of a vertex with its sharp one.
Vec3 vertex_place(const Vec3& v, const Star& s, const Vec3& smooth)
{
    if (s.edges == 0 || s.corner) return v;
    if (s.sharp < 2) return smooth;
    const Vec3 sharp = s.sharp == 2 ? (6.0 * v + s.crease[0] + s.crease[1]) / 8.0 : v;
    const double share = std::min(1.0, s.sharpness / s.sharp);
    return share == 1.0 ? sharp : (1.0 - share) * smooth + share * sharp;
}

Vec3 edge_place(const Edge& e, const Vec3& middle, const Vec3& smooth)
{
    if (e.sharpness == 0.0) return smooth;
    const double share = std::min(1.0, e.sharpness);
    return share == 1.0 ? middle : (1.0 - share) * smooth + share * middle;
}

// Both halves of a crease, one level less sharp.
std::vector<Crease> refined_creases(const EdgeList& list, std::size_t first_edge_point)
{
    std::vector<Crease> creases;
    for (std::size_t k = 0; k < list.edges.size(); ++k) {
        const Edge& e = list.edges[k];
        const double left = e.sharpness - 1.0;
        if (!(left > 0.0) || e.faces != 2) continue;
        const auto middle = static_cast<std::int32_t>(first_edge_point + k);
        creases.push_back({e.a, middle, left});
        creases.push_back({middle, e.b, left});
    }
    return creases;
}

void check_growth(std::size_t corners)
{
    require(static_cast<std::int64_t>(corners) <= kMaxCorners / 4,
            "subdivision: number of corners of the result", 4.0 * static_cast<double>(corners),
            "at most 2^30");
}

SubdivisionMesh catmull_clark_step(const SubdivisionMesh& m)
{
    const PolygonMesh& mesh = m.mesh;
    check_growth(mesh.corners.size());
    EdgeList list = edges_of(m);
    auto stars = stars_of(m, list);
    const std::size_t nv = mesh.n_vertices(), ne = list.edges.size();
    SubdivisionMesh out;
    out.corners = m.corners;
    out.mesh.vertices.resize(nv + ne);
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        Vec3 center;
        for (const std::int32_t v : face) center += mesh.vertices[at(v)];
        center = center / static_cast<double>(face.size());
        const auto middle = static_cast<std::int32_t>(out.mesh.vertices.size());
        out.mesh.vertices.push_back(center);
        for (std::size_t k = 0; k < face.size(); ++k) {
            Star& s = stars[at(face[k])];
            ++s.faces;
            s.face_points += center;
            const std::size_t corner = at(mesh.starts[f]) + k;
            const std::size_t before = at(mesh.starts[f]) + (k + face.size() - 1) % face.size();
            list.edges[at(list.of_corner[corner])].opposite += center;
            const auto edge_point = [&](std::size_t c) {
                return static_cast<std::int32_t>(nv) + list.of_corner[c];
            };
            out.mesh.add_face(std::array{face[k], edge_point(corner), middle, edge_point(before)});
        }
    }
    for (std::size_t k = 0; k < ne; ++k) {
        const Edge& e = list.edges[k];
        const Vec3 sum = mesh.vertices[at(e.a)] + mesh.vertices[at(e.b)];
        out.mesh.vertices[nv + k] = edge_place(e, 0.5 * sum, 0.25 * (sum + e.opposite));
    }
    for (std::size_t v = 0; v < nv; ++v) {
        const Star& s = stars[v];
        const double n = s.edges;
        const Vec3& p = mesh.vertices[v];
        const Vec3 smooth =
            n > 0 ? ((n - 2.0) / n) * p + (s.neighbours + s.face_points) / (n * n) : p;
        out.mesh.vertices[v] = vertex_place(p, s, smooth);
    }
    out.creases = refined_creases(list, nv);
    return out;
}

// Loop's weight of a neighbour.
double loop_beta(int n)
{
    const double c = 3.0 / 8.0 + std::cos(2.0 * kPi / n) / 4.0;
    return (5.0 / 8.0 - c * c) / n;
}

SubdivisionMesh loop_step(const SubdivisionMesh& m)
{
    const PolygonMesh& mesh = m.mesh;
    check_growth(mesh.corners.size());
    EdgeList list = edges_of(m);
    const auto stars = stars_of(m, list);
    const std::size_t nv = mesh.n_vertices(), ne = list.edges.size();
    SubdivisionMesh out;
    out.corners = m.corners;
    out.mesh.vertices.resize(nv + ne);
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        std::array<std::int32_t, 3> middle;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t e = list.of_corner[at(mesh.starts[f]) + k];
            middle[k] = static_cast<std::int32_t>(nv) + e;
            list.edges[at(e)].opposite += mesh.vertices[at(face[(k + 2) % 3])];
        }
        for (std::size_t k = 0; k < 3; ++k)
            out.mesh.add_face(std::array{face[k], middle[k], middle[(k + 2) % 3]});
        out.mesh.add_face(middle);
    }
    for (std::size_t k = 0; k < ne; ++k) {
        const Edge& e = list.edges[k];
        const Vec3 sum = mesh.vertices[at(e.a)] + mesh.vertices[at(e.b)];
        out.mesh.vertices[nv + k] = edge_place(e, 0.5 * sum, 0.375 * sum + 0.125 * e.opposite);
    }
    for (std::size_t v = 0; v < nv; ++v) {
        const Star& s = stars[v];
        const Vec3& p = mesh.vertices[v];
        const double beta = s.edges > 0 ? loop_beta(s.edges) : 0.0;
        out.mesh.vertices[v] = vertex_place(p, s, (1.0 - s.edges * beta) * p + beta * s.neighbours);
    }
    out.creases = refined_creases(list, nv);
    return out;
}

SubdivisionMesh subdivided(const SubdivisionMesh& mesh, int levels, SubdivisionScheme scheme)
{
    require(levels >= 0 && levels <= 12, "subdivision: levels", levels, "in [0, 12]");
    const bool loop = scheme == SubdivisionScheme::Loop;
    check_mesh(mesh.mesh, loop);
    SubdivisionMesh result = mesh;
    for (int k = 0; k < levels; ++k) {
        current_progress().check();
        result = loop ? loop_step(result) : catmull_clark_step(result);
    }
    return result;
}

}  // namespace

SubdivisionMesh catmull_clark(const SubdivisionMesh& mesh, int levels)
{
    return subdivided(mesh, levels, SubdivisionScheme::CatmullClark);
}

SubdivisionMesh loop_subdivision(const SubdivisionMesh& mesh, int levels)
{
    return subdivided(mesh, levels, SubdivisionScheme::Loop);
}

namespace {

// The faces round a vertex in counterclockwise order: neighbour i, and across face i the vertex
// opposite (of a quadrilateral). Open stars have one neighbour more than faces.
struct Ring {
    std::vector<Vec3> edge, face;
    bool closed = false;
    bool disc = false;
};

struct FaceAt {
    std::int32_t next, previous, across;
};

Ring ring_of(const std::vector<FaceAt>& faces, const std::vector<Vec3>& p)
{
    Ring ring;
    std::map<std::int32_t, std::size_t> by_next, by_previous;
    for (std::size_t k = 0; k < faces.size(); ++k) {
        by_next[faces[k].next] = k;
        by_previous[faces[k].previous] = k;
    }
    if (faces.empty() || by_next.size() != faces.size() || by_previous.size() != faces.size())
        return ring;
    // An open star starts at the neighbour that no face ends with.
    std::size_t k = 0;
    int starts = 0;
    for (std::size_t i = 0; i < faces.size(); ++i)
        if (!by_previous.contains(faces[i].next)) {
            k = i;
            ++starts;
        }
    ring.closed = starts == 0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        ring.edge.push_back(p[at(faces[k].next)]);
        ring.face.push_back(p[at(faces[k].across)]);
        const auto following = by_next.find(faces[k].previous);
        if (i + 1 == faces.size()) {
            if (!ring.closed) ring.edge.push_back(p[at(faces[k].previous)]);
            ring.disc = ring.closed ? following != by_next.end() &&
                                          p[at(faces[following->second].next)] == ring.edge[0]
                                    : following == by_next.end();
            break;
        }
        if (following == by_next.end()) return ring;
        k = following->second;
    }
    return ring;
}

Vec3 smooth_limit(const Vec3& v, const Ring& ring, SubdivisionScheme scheme)
{
    const double n = static_cast<double>(ring.edge.size());
    Vec3 edges, faces;
    for (const Vec3& e : ring.edge) edges += e;
    for (const Vec3& f : ring.face) faces += f;
    if (scheme == SubdivisionScheme::CatmullClark)
        return (n * n * v + 4.0 * edges + faces) / (n * (n + 5.0));
    const double gamma = 1.0 / (3.0 / (8.0 * loop_beta(static_cast<int>(n))) + n);
    return (1.0 - n * gamma) * v + gamma * edges;
}

// One step of the schemes round a vertex with one sharp edge, to ring.edge[sharp].
void refine_crease_end(Vec3& v, Ring& ring, std::size_t sharp, SubdivisionScheme scheme)
{
    const std::size_t n = ring.edge.size();
    const double count = static_cast<double>(n);
    const bool loop = scheme == SubdivisionScheme::Loop;
    std::vector<Vec3> edge(n), face(ring.face);
    Vec3 edges, faces;
    for (std::size_t i = 0; i < n; ++i) {
        edges += ring.edge[i];
        if (!loop) face[i] = (v + ring.edge[i] + ring.face[i] + ring.edge[(i + 1) % n]) / 4.0;
        faces += face[i];
    }
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t before = (i + n - 1) % n;
        edge[i] = i == sharp ? 0.5 * (v + ring.edge[i])
                  : loop     ? 0.375 * (v + ring.edge[i]) +
                               0.125 * (ring.edge[before] + ring.edge[(i + 1) % n])
                         : (v + ring.edge[i] + face[before] + face[i]) / 4.0;
    }
    if (loop) {
        const double beta = loop_beta(static_cast<int>(n));
        v = (1.0 - count * beta) * v + beta * edges;
    } else {
        v = (faces / count + edges / count + (count - 2.0) * v) / count;
    }
    ring.edge.swap(edge);
    ring.face.swap(face);
}

// At the end of a crease no mask is known in closed form: the ring is refined to a point.
Vec3 crease_end_limit(Vec3 v, Ring ring, const Vec3& along, SubdivisionScheme scheme)
{
    constexpr int kSteps = 160;  // rings shrink by a third a step or more
    const std::size_t sharp = static_cast<std::size_t>(
        std::find(ring.edge.begin(), ring.edge.end(), along) - ring.edge.begin());
    for (int step = 0; step < kSteps; ++step) refine_crease_end(v, ring, sharp, scheme);
    return v;
}

Vec3 smooth_normal(const Ring& ring, SubdivisionScheme scheme)
{
    const std::size_t n = ring.edge.size();
    const double angle = 2.0 * kPi / static_cast<double>(n);
    const double c = std::cos(angle);
    const double a = 1.0 + c + std::cos(0.5 * angle) * std::sqrt(2.0 * (9.0 + c));
    Vec3 t0, t1;
    for (std::size_t i = 0; i < n; ++i) {
        const double x = angle * static_cast<double>(i), y = x + angle;
        if (scheme == SubdivisionScheme::CatmullClark) {
            t0 += a * std::cos(x) * ring.edge[i] + (std::cos(x) + std::cos(y)) * ring.face[i];
            t1 += a * std::sin(x) * ring.edge[i] + (std::sin(x) + std::sin(y)) * ring.face[i];
        } else {
            t0 += std::cos(x) * ring.edge[i];
            t1 += std::sin(x) * ring.edge[i];
        }
    }
    return normalized(cross(t0, t1));
}

// On the border, from the tangent along it and the one across.
Vec3 border_normal(const Vec3& v, const Ring& ring, SubdivisionScheme scheme)
{
    const std::size_t k = ring.face.size();
    const double theta = kPi / static_cast<double>(k);
    const double c = std::cos(theta), s = std::sin(theta);
    const Vec3 along = ring.edge.front() - ring.edge.back();
    Vec3 across;
    if (scheme == SubdivisionScheme::Loop) {
        if (k == 1) {
            across = ring.edge[0] + ring.edge[1] - 2.0 * v;
        } else {
            // Left eigenvector of the border's subdivision matrix: sin(i theta) for the inner
            // neighbours, which fixes the eigenvalue, then two equations for the others.
            const double lambda = 3.0 / 8.0 + c / 4.0, l = lambda - 0.75;
            const double sum = 1.0 / std::tan(0.5 * theta);  // of all sin(i theta)
            const double outer = (3.0 * sum / (8.0 * l) + s) / (8.0 * (lambda - 0.5) - 1.0 / l);
            across = ((outer + 3.0 / 8.0 * sum) / l) * v +
                     outer * (ring.edge.front() + ring.edge.back());
            for (std::size_t i = 1; i < k; ++i)
                across += std::sin(static_cast<double>(i) * theta) * ring.edge[i];
        }
    } else if (k == 1) {
        across = -6.0 * v + 3.0 * (ring.edge[0] + ring.edge[1]);
    } else {
        const double r = (c + 1.0) / s;
        across =
            4.0 * r * (c - 1.0) * v - r * (1.0 + 2.0 * c) * (ring.edge.front() + ring.edge.back());
        for (std::size_t i = 1; i < k; ++i)
            across += 4.0 * std::sin(static_cast<double>(i) * theta) * ring.edge[i];
        for (std::size_t i = 0; i < k; ++i)
            across += (std::sin(static_cast<double>(i) * theta) +
                       std::sin(static_cast<double>(i + 1) * theta)) *
                      ring.face[i];
    }
    return normalized(cross(along, across));
}

}  // namespace

LimitSurface limit_surface(const SubdivisionMesh& mesh, SubdivisionScheme scheme)
{
    int levels = 0;
    for (const Crease& c : mesh.creases)
        if (std::isfinite(c.sharpness)) {
            require(c.sharpness <= 6.0, "limit_surface: sharpness", c.sharpness,
                    "at most 6 or infinite");
            levels = std::max(levels, static_cast<int>(std::ceil(c.sharpness)));
        }
    check_mesh(mesh.mesh, scheme == SubdivisionScheme::Loop);
    // The masks are for quadrilaterals.
    for (std::size_t f = 0; f < mesh.mesh.n_faces() && levels == 0; ++f)
        if (scheme == SubdivisionScheme::CatmullClark && mesh.mesh.face(f).size() != 4) levels = 1;
    const SubdivisionMesh fine = subdivided(mesh, levels, scheme);
    const auto& p = fine.mesh.vertices;
    const EdgeList list = edges_of(fine);
    const auto stars = stars_of(fine, list);

    std::vector<std::vector<FaceAt>> faces(mesh.mesh.n_vertices());
    for (std::size_t f = 0; f < fine.mesh.n_faces(); ++f) {
        const auto face = fine.mesh.face(f);
        const std::size_t n = face.size();
        for (std::size_t k = 0; k < n; ++k)
            if (at(face[k]) < faces.size())
                faces[at(face[k])].push_back(
                    {face[(k + 1) % n], face[(k + n - 1) % n], face[(k + 2) % n]});
    }
    LimitSurface limit;
    for (std::size_t v = 0; v < faces.size(); ++v) {
        const Star& s = stars[v];
        limit.points.push_back(p[v]);
        limit.normals.push_back({});
        if (s.edges == 0 || s.corner || s.sharp > 2) continue;
        if (s.sharp == 2) limit.points.back() = (4.0 * p[v] + s.crease[0] + s.crease[1]) / 6.0;
        const Ring ring = ring_of(faces[v], p);
        if (!ring.disc) continue;
        if (ring.closed && s.sharp < 2) {
            // At the end of a crease the masks do not hold.
            limit.points.back() = s.sharp == 0 ? smooth_limit(p[v], ring, scheme)
                                               : crease_end_limit(p[v], ring, s.crease[0], scheme);
            if (s.sharp == 0) limit.normals.back() = smooth_normal(ring, scheme);
        } else if (!ring.closed && s.sharp == 2) {
            limit.normals.back() = border_normal(p[v], ring, scheme);
        }
    }
    return limit;
}

}  // namespace genus
