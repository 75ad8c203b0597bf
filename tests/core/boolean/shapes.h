#pragma once

// Solids with known measures and the checks that every result of a boolean must pass.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "genus/boolean/mesh_boolean.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

namespace genus::shapes {

inline IndexedMesh box(const Vec3& low, const Vec3& high)
{
    IndexedMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back(
            {{i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]}});
    mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                  {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

inline IndexedMesh cube(double side, const Vec3& at = {})
{
    return box(at, at + Vec3{{side, side, side}});
}

inline IndexedMesh tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d)
{
    IndexedMesh mesh{{a, b, c, d}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    if (volume(mesh) < 0.0)
        for (Triangle& t : mesh.faces) std::swap(t[1], t[2]);
    return mesh;
}

/// Prism or frustum along z over a regular polygon, corner 0 at angle 0.
inline IndexedMesh prism(int sides, double r_low, double r_high, double z_low, double z_high)
{
    IndexedMesh mesh;
    for (int level = 0; level < 2; ++level)
        for (int i = 0; i < sides; ++i) {
            const double t = 2.0 * std::numbers::pi * i / sides;
            const double r = level ? r_high : r_low;
            mesh.vertices.push_back({{r * std::cos(t), r * std::sin(t), level ? z_high : z_low}});
        }
    for (int i = 0; i < sides; ++i) {
        const int j = (i + 1) % sides;
        mesh.faces.push_back({i, j, sides + i});
        mesh.faces.push_back({j, sides + j, sides + i});
    }
    for (int i = 1; i + 1 < sides; ++i) {
        mesh.faces.push_back({0, i + 1, i});
        mesh.faces.push_back({sides, sides + i, sides + i + 1});
    }
    return mesh;
}

inline IndexedMesh sphere(int rings, int around, double r)
{
    IndexedMesh mesh;
    mesh.vertices.push_back({{0, 0, -r}});
    for (int i = 1; i < rings; ++i)
        for (int j = 0; j < around; ++j) {
            const double p = std::numbers::pi * (static_cast<double>(i) / rings - 0.5);
            const double t = 2.0 * std::numbers::pi * j / around;
            mesh.vertices.push_back(
                {{r * std::cos(p) * std::cos(t), r * std::cos(p) * std::sin(t), r * std::sin(p)}});
        }
    mesh.vertices.push_back({{0, 0, r}});
    const auto at = [&](int ring, int j) { return 1 + (ring - 1) * around + j % around; };
    const int top = static_cast<int>(mesh.vertices.size()) - 1;
    for (int j = 0; j < around; ++j) {
        mesh.faces.push_back({0, at(1, j + 1), at(1, j)});
        mesh.faces.push_back({top, at(rings - 1, j), at(rings - 1, j + 1)});
        for (int i = 1; i + 1 < rings; ++i) {
            mesh.faces.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            mesh.faces.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
        }
    }
    return mesh;
}

inline IndexedMesh torus(int around, int across, double R, double r)
{
    IndexedMesh mesh;
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) {
            const double t = 2.0 * std::numbers::pi * i / around;
            const double p = 2.0 * std::numbers::pi * j / across;
            const double d = R + r * std::cos(p);
            mesh.vertices.push_back({{d * std::cos(t), d * std::sin(t), r * std::sin(p)}});
        }
    const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) {
            mesh.faces.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            mesh.faces.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

inline IndexedMesh moved(IndexedMesh mesh, const Vec3& by)
{
    for (Vec3& p : mesh.vertices) p += by;
    return mesh;
}

inline IndexedMesh scaled(IndexedMesh mesh, double by)
{
    for (Vec3& p : mesh.vertices) p *= by;
    return mesh;
}

/// Turned about `axis` by `degrees`, right-handed.
inline IndexedMesh turned(IndexedMesh mesh, const Vec3& axis, double degrees)
{
    const Vec3 u = normalized(axis);
    const double t = degrees * std::numbers::pi / 180.0;
    const double c = std::cos(t);
    const double s = std::sin(t);
    const double versine = 2.0 * std::sin(t / 2.0) * std::sin(t / 2.0);
    for (Vec3& p : mesh.vertices) {
        const Vec3 side = cross(u, p);
        const Vec3 along = u * dot(u, p);
        p = c == 1.0 ? p + s * side + versine * (along - p) : along + c * (p - along) + s * side;
    }
    return mesh;
}

inline IndexedMesh inside_out(IndexedMesh mesh)
{
    for (Triangle& t : mesh.faces) std::swap(t[1], t[2]);
    return mesh;
}

/// Both meshes as one, nothing made common.
inline IndexedMesh joined(IndexedMesh a, const IndexedMesh& b)
{
    const auto base = static_cast<std::int32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const Triangle& t : b.faces) a.faces.push_back({t[0] + base, t[1] + base, t[2] + base});
    return a;
}

/// Closed, oriented, manifold, no crossings, outside on the right side of every part.
inline void expect_sound(const IndexedMesh& mesh)
{
    const Validation v = validate(mesh);
    for (const Finding& finding : v.findings) ADD_FAILURE() << finding.text;
    EXPECT_TRUE(v.topology.closed);
    EXPECT_TRUE(v.topology.manifold);
}

inline std::int64_t genus_of(const IndexedMesh& mesh)
{
    return topology(mesh).genus.value_or(-1000);
}

inline std::int64_t parts_of(const IndexedMesh& mesh)
{
    return static_cast<std::int64_t>(topology(mesh).components.size());
}

inline IndexedMesh unite(const IndexedMesh& a, const IndexedMesh& b)
{
    return genus::unite(std::vector<IndexedMesh>{a, b});
}
inline IndexedMesh intersect(const IndexedMesh& a, const IndexedMesh& b)
{
    return genus::intersect(std::vector<IndexedMesh>{a, b});
}
inline IndexedMesh subtract(const IndexedMesh& a, const IndexedMesh& b)
{
    return genus::subtract(std::vector<IndexedMesh>{a, b});
}

}  // namespace genus::shapes
