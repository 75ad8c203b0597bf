#include "genus/model/leaf_mesh.h"

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

}  // namespace genus
