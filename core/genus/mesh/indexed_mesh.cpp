#include "genus/mesh/indexed_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/polygon/ear_clipping.h"
#include "genus/polygon/sweep.h"

namespace genus {

namespace {

Box3 bounds_of(const std::vector<Vec3>& points)
{
    Box3 box;
    for (const Vec3& p : points) box.add(p);
    return box;
}

using Face = std::span<const std::int32_t>;

// Twice the vector area (Newell), relative to the first corner so that nothing is lost far out.
Vec3 vector_area(const std::vector<Vec3>& points, Face face)
{
    Vec3 sum;
    const Vec3 origin = points[face[0]];
    Vec3 previous = points[face.back()] - origin;
    for (const std::int32_t v : face) {
        const Vec3 p = points[v] - origin;
        sum += cross(previous, p);
        previous = p;
    }
    return sum;
}

// The corners seen along the axis in which the face is widest open, so that it turns
// counterclockwise. Two of the three coordinates as they are: no rounding.
std::vector<Vec2> seen_from_above(const std::vector<Vec3>& points, Face face, const Vec3& normal)
{
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::fabs(normal[k]) > std::fabs(normal[axis])) axis = k;
    std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
    if (normal[axis] < 0.0) std::swap(i, j);
    std::vector<Vec2> plane;
    plane.reserve(face.size());
    for (const std::int32_t v : face) plane.push_back({{points[v][i], points[v][j]}});
    return plane;
}

void add_fan(Face face, std::vector<Triangle>& out)
{
    for (std::size_t i = 2; i < face.size(); ++i) out.push_back({face[0], face[i - 1], face[i]});
}

// A quadrilateral is cut along its shorter diagonal, of two equal ones along that which holds the
// smallest vertex number: the cut does not depend on the corner the face begins with.
void add_convex_quad(const std::vector<Vec3>& points, Face face, std::vector<Triangle>& out)
{
    const double even = distance(points[face[0]], points[face[2]]);
    const double odd = distance(points[face[1]], points[face[3]]);
    const bool even_holds_least = std::min(face[0], face[2]) < std::min(face[1], face[3]);
    if (even < odd || (even == odd && even_holds_least)) {
        out.push_back({face[0], face[1], face[2]});
        out.push_back({face[0], face[2], face[3]});
    } else {
        out.push_back({face[1], face[2], face[3]});
        out.push_back({face[1], face[3], face[0]});
    }
}

bool is_convex_quad(const std::vector<Vec2>& p)
{
    for (std::size_t i = 0; i < 4; ++i)
        if (orient2d(p[i], p[(i + 1) % 4], p[(i + 2) % 4]) <= 0) return false;
    return true;
}

// The corners that are apart from the one before. A corner at the same place is cut off with a
// triangle of no area, `flat`, so that every side of the face stays the side of a triangle.
std::vector<std::int32_t> without_repeats(const std::vector<Vec2>& plane, Face face,
                                          std::vector<Triangle>& flat)
{
    std::vector<std::int32_t> loop;
    for (std::size_t i = 0; i < face.size(); ++i) {
        const bool last = i + 1 == face.size();
        const std::size_t after = last ? (loop.empty() ? 0 : loop.front()) : i + 1;
        if (plane[i] == plane[after] && loop.size() + face.size() - i > 3) {
            const std::int32_t before = loop.empty() ? face.back() : face[loop.back()];
            flat.push_back({before, face[i], face[after]});
        } else {
            loop.push_back(static_cast<std::int32_t>(i));
        }
    }
    return loop;
}

// Large faces by the sweep line, in O(n log n). Not where corners share a place: it would name one
// for all of them.
bool add_swept(const std::vector<Vec2>& plane, Face face, std::vector<Triangle>& out)
{
    try {
        const std::array<OrientedRing, 1> ring{{{plane, false}}};
        const SweepTriangulation sweep = sweep_triangulation(ring);
        for (std::size_t i = 0; i < face.size(); ++i)
            if (sweep.first_at[i] != static_cast<std::int32_t>(i)) return false;
        if (sweep.triangles.size() != face.size() - 2) return false;
        for (const PolygonTriangle& t : sweep.triangles)
            out.push_back({face[t[0]], face[t[1]], face[t[2]]});
        return true;
    } catch (const InvalidInput&) {
        return false;  // no simple polygon: the fan at the end of add_cut is all that is promised
    }
}

void add_cut(const std::vector<Vec3>& points, Face face, std::vector<Triangle>& out)
{
    const std::vector<Vec2> plane = seen_from_above(points, face, vector_area(points, face));
    if (face.size() == 4 && is_convex_quad(plane)) {
        add_convex_quad(points, face, out);
        return;
    }
    constexpr std::size_t kManyCorners = 200;
    constexpr std::size_t kTooManyForEars = 20'000;
    if (face.size() > kManyCorners && add_swept(plane, face, out)) return;
    if (face.size() > kTooManyForEars) {
        add_fan(face, out);
        return;
    }
    std::vector<Triangle> flat;
    const std::vector<std::int32_t> loop = without_repeats(plane, face, flat);
    const auto cut = clip_ears(plane, loop);
    if (!cut) {
        add_fan(face, out);
        return;
    }
    out.insert(out.end(), flat.begin(), flat.end());
    for (const PolygonTriangle& t : *cut) out.push_back({face[t[0]], face[t[1]], face[t[2]]});
}

void check_indices(const PolygonMesh& mesh)
{
    const auto n = static_cast<std::int64_t>(mesh.n_vertices());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        for (const std::int32_t v : mesh.face(f))
            if (v < 0 || v >= n)
                throw InvalidInput("to_triangles: face " + std::to_string(f) + " names vertex " +
                                   std::to_string(v) + " of " + std::to_string(n));
}

}  // namespace

Box3 bounds(const IndexedMesh& mesh)
{
    return bounds_of(mesh.vertices);
}

Box3 bounds(const PolygonMesh& mesh)
{
    return bounds_of(mesh.vertices);
}

PolygonMesh to_polygons(const IndexedMesh& mesh)
{
    PolygonMesh out;
    out.vertices = mesh.vertices;
    out.starts.reserve(mesh.n_faces() + 1);
    out.corners.reserve(3 * mesh.n_faces());
    for (const Triangle& face : mesh.faces) out.add_face(face);
    return out;
}

IndexedMesh to_triangles(const PolygonMesh& mesh)
{
    check_indices(mesh);
    IndexedMesh out;
    out.vertices = mesh.vertices;
    out.faces.reserve(mesh.corners.size() - std::min(mesh.corners.size(), 2 * mesh.n_faces()));
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const Face face = mesh.face(f);
        if (face.size() < 3) continue;
        if (face.size() == 3)
            out.faces.push_back({face[0], face[1], face[2]});
        else
            add_cut(mesh.vertices, face, out.faces);
    }
    return out;
}

}  // namespace genus
