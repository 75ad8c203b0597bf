#include "genus/model/leaf_mesh.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "genus/base/error.h"
#include "genus/base/transform.h"

namespace genus {
namespace {

constexpr std::int64_t kMostCorners = 100'000'000;

void add(PolygonMesh& mesh, std::initializer_list<std::int32_t> face)
{
    mesh.add_face(std::span(face.begin(), face.size()));
}

PolygonMesh mesh_of(const Cube& s)
{
    // Corner i is at (i & 1, i >> 1 & 1, i >> 2 & 1).
    const Vec3 low = s.center ? -0.5 * s.size : Vec3{};
    PolygonMesh mesh;
    for (int i = 0; i < 8; ++i) {
        const Vec3 pick{{(i & 1) * s.size[0], (i >> 1 & 1) * s.size[1], (i >> 2 & 1) * s.size[2]}};
        mesh.vertices.push_back(low + pick);
    }
    add(mesh, {0, 2, 3, 1});
    add(mesh, {4, 5, 7, 6});
    add(mesh, {0, 1, 5, 4});
    add(mesh, {2, 6, 7, 3});
    add(mesh, {0, 4, 6, 2});
    add(mesh, {1, 3, 7, 5});
    return mesh;
}

/// Adds n points on a circle about the z axis and returns the number of the first.
std::int32_t add_ring(PolygonMesh& mesh, int n, double r, double z)
{
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int j = 0; j < n; ++j) {
        const double angle = 360.0 * j / n;
        mesh.vertices.push_back({{r * cos_degrees(angle), r * sin_degrees(angle), z}});
    }
    return first;
}

/// The polygon of a ring, seen from above or from below.
void add_cap(PolygonMesh& mesh, std::int32_t first, int n, bool upward)
{
    for (int j = 0; j < n; ++j) mesh.corners.push_back(first + (upward ? j : n - 1 - j));
    mesh.starts.push_back(static_cast<std::int64_t>(mesh.corners.size()));
}

/// The quads between two rings of n points each.
void add_band(PolygonMesh& mesh, std::int32_t low, std::int32_t high, int n)
{
    for (int j = 0; j < n; ++j) {
        const int k = (j + 1) % n;
        add(mesh, {low + j, low + k, high + k, high + j});
    }
}

PolygonMesh mesh_of(const Sphere& s)
{
    const int n = s.fragments, rings = (n + 1) / 2;
    require(std::int64_t{4} * n * rings <= kMostCorners, "sphere: too many fragments");
    PolygonMesh mesh;
    mesh.vertices.reserve(std::size_t(n) * rings);
    // From the top down, as the language has it.
    for (int i = 0; i < rings; ++i) {
        const double polar = 180.0 * (i + 0.5) / rings;
        add_ring(mesh, n, s.r * sin_degrees(polar), s.r * cos_degrees(polar));
    }
    add_cap(mesh, 0, n, true);
    for (int i = 0; i + 1 < rings; ++i) add_band(mesh, (i + 1) * n, i * n, n);
    add_cap(mesh, (rings - 1) * n, n, false);
    return mesh;
}

PolygonMesh mesh_of(const Cylinder& s)
{
    const int n = s.fragments;
    require(std::int64_t{6} * n <= kMostCorners, "cylinder: too many fragments");
    const double low = s.center ? -0.5 * s.h : 0.0, high = low + s.h;
    PolygonMesh mesh;
    if (s.r1 > 0.0 && s.r2 > 0.0) {
        const std::int32_t bottom = add_ring(mesh, n, s.r1, low);
        const std::int32_t top = add_ring(mesh, n, s.r2, high);
        add_cap(mesh, bottom, n, false);
        add_band(mesh, bottom, top, n);
        add_cap(mesh, top, n, true);
        return mesh;
    }
    // A cone: one ring and an apex, above or below it.
    const bool up = s.r1 > 0.0;
    const std::int32_t ring = add_ring(mesh, n, up ? s.r1 : s.r2, up ? low : high);
    mesh.vertices.push_back({{0.0, 0.0, up ? high : low}});
    add_cap(mesh, ring, n, !up);
    for (int j = 0; j < n; ++j) {
        const std::int32_t a = ring + j, b = ring + (j + 1) % n;
        add(mesh, {up ? a : b, up ? b : a, ring + n});
    }
    return mesh;
}

// ---- Round shapes to a tolerance

constexpr double kPi = 3.14159265358979323846;

/// How far an inscribed regular polygon stays from its circle.
double sagitta(double r, int n)
{
    const double sine = std::sin(0.5 * kPi / n);
    return 2.0 * r * sine * sine * (1.0 + 1e-14);
}

/// Sides of a regular polygon inscribed in a circle of radius r that stays within `tolerance`:
/// r (1 - cos(pi / n)) = 2 r sin^2(pi / 2n).
int sides_for(double r, double tolerance)
{
    const double sine = std::sqrt(std::min(1.0, 0.5 * tolerance / r));
    const double n = std::ceil(0.5 * kPi / std::asin(sine));
    require(n <= 1e8, "tessellate: tolerance", tolerance, "not that small");
    int sides = std::max(3, static_cast<int>(n));
    while (sagitta(r, sides) > tolerance) ++sides;  // rounding of the above
    return sides;
}

/// Unit sphere of n meridians and n / 2 bands between the poles.
PolygonMesh unit_sphere(int n)
{
    const int bands = n / 2;
    require(std::int64_t{4} * n * bands <= kMostCorners, "tessellate: too many faces");
    PolygonMesh mesh;
    mesh.vertices.push_back({{0, 0, 1}});
    for (int i = 1; i < bands; ++i) {
        const double polar = 180.0 * i / bands;
        add_ring(mesh, n, sin_degrees(polar), cos_degrees(polar));
    }
    mesh.vertices.push_back({{0, 0, -1}});
    const auto last = static_cast<std::int32_t>(mesh.vertices.size()) - 1;
    for (int j = 0; j < n; ++j) add(mesh, {0, 1 + j, 1 + (j + 1) % n});
    for (int i = 1; i + 1 < bands; ++i) add_band(mesh, 1 + i * n, 1 + (i - 1) * n, n);
    for (int j = 0; j < n; ++j) add(mesh, {last, last - n + (j + 1) % n, last - n + j});
    return mesh;
}

/// 1 less the distance of the farthest cutting plane from the centre: one face a band will do.
double sphere_deviation(const PolygonMesh& mesh, int n)
{
    double worst = 0.0;
    for (std::size_t f = 0; f < mesh.n_faces(); f += static_cast<std::size_t>(n)) {
        const auto face = mesh.face(f);
        const Vec3& a = mesh.vertices[face[0]];
        const Vec3 normal =
            normalized(cross(mesh.vertices[face[1]] - a, mesh.vertices[face[2]] - a));
        worst = std::max(worst, 1.0 - dot(normal, a));
    }
    return worst + 1e-14;
}

/// An affine map moves points apart by at most its largest radius.
Tessellation tessellated(const Vec3& radii, double tolerance)
{
    const double largest = std::max({radii[0], radii[1], radii[2]});
    // Half the diagonal of a face spans about sqrt(2) times the angle of a side.
    int n = std::max(4, sides_for(largest, 0.5 * tolerance));
    for (;; n += std::max(2, n / 8)) {
        n += n % 2;
        Tessellation result{unit_sphere(n), 0.0};
        result.bound = largest * sphere_deviation(result.mesh, n);
        if (result.bound > tolerance) continue;
        for (Vec3& v : result.mesh.vertices)
            for (int i = 0; i < 3; ++i) v[i] *= radii[i];
        return result;
    }
}

/// First the tube's circle becomes a polygon, then the way round the axis does: each step moves
/// points by at most its own sagitta.
Tessellation tessellated(const TorusShape& s, double tolerance)
{
    const int around = sides_for(s.R + s.r, 0.5 * tolerance), n = sides_for(s.r, 0.5 * tolerance);
    require(4.0 * around * n <= kMostCorners, "tessellate: too many faces");
    PolygonMesh mesh;
    for (int i = 0; i < n; ++i) {
        const double v = 360.0 * i / n;
        add_ring(mesh, around, s.R + s.r * cos_degrees(v), s.r * sin_degrees(v));
    }
    for (int i = 0; i < n; ++i) add_band(mesh, i * around, (i + 1) % n * around, around);
    return {std::move(mesh), sagitta(s.R + s.r, around) + sagitta(s.r, n)};
}

Tessellation tessellated(Cylinder s, double tolerance)
{
    const double r = std::max(s.r1, s.r2);
    s.fragments = sides_for(r, tolerance);
    return {mesh_of(s), sagitta(r, s.fragments)};
}

}  // namespace

bool is_faceted(const Shape& shape)
{
    if (const auto* s = std::get_if<Sphere>(&shape)) return s->fragments > 0;
    if (const auto* s = std::get_if<Cylinder>(&shape)) return s->fragments > 0;
    return std::holds_alternative<Cube>(shape) || std::holds_alternative<Polyhedron>(shape);
}

PolygonMesh facet_mesh(const Shape& shape)
{
    if (!is_faceted(shape)) throw InvalidInput(describe(shape) + " is not a polyhedron");
    if (const auto* s = std::get_if<Sphere>(&shape)) return mesh_of(*s);
    if (const auto* s = std::get_if<Cylinder>(&shape)) return mesh_of(*s);
    if (const auto* s = std::get_if<Cube>(&shape)) return mesh_of(*s);
    return *std::get<Polyhedron>(shape).mesh;
}

Tessellation tessellate(const Shape& shape, double tolerance)
{
    require(tolerance > 0.0 && std::isfinite(tolerance), "tessellate: tolerance", tolerance,
            "positive and finite");
    if (!is_faceted(shape)) {
        if (const auto* s = std::get_if<Sphere>(&shape))
            return tessellated(Vec3{{s->r, s->r, s->r}}, tolerance);
        if (const auto* s = std::get_if<Ellipsoid>(&shape)) return tessellated(s->radii, tolerance);
        if (const auto* s = std::get_if<Cylinder>(&shape)) return tessellated(*s, tolerance);
        if (const auto* s = std::get_if<TorusShape>(&shape)) return tessellated(*s, tolerance);
    }
    throw InvalidInput(describe(shape) + " is not a round shape to tessellate");
}

}  // namespace genus
