#pragma once

// Meshes with known topology and measures, for tests of any folder. Header only.

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "genus/base/transform.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus::cases {

inline IndexedMesh tetrahedron()
{
    return {{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}},
            {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

/// The box [0, size], corner i at (i & 1, i >> 1 & 1, i >> 2 & 1) times size.
inline PolygonMesh box_polygons(const Vec3& size = {{1, 1, 1}})
{
    PolygonMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back({{size[0] * (i & 1), size[1] * (i >> 1 & 1), size[2] * (i >> 2)}});
    const std::array<std::array<std::int32_t, 4>, 6> faces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& face : faces) mesh.add_face(face);
    return mesh;
}

inline IndexedMesh box(const Vec3& size = {{1, 1, 1}})
{
    return to_triangles(box_polygons(size));
}

inline IndexedMesh octahedron()
{
    return {
        {{{1, 0, 0}}, {{-1, 0, 0}}, {{0, 1, 0}}, {{0, -1, 0}}, {{0, 0, 1}}, {{0, 0, -1}}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

/// Every face into four; new vertices in the middle of edges.
inline IndexedMesh split_in_four(const IndexedMesh& mesh)
{
    IndexedMesh out{mesh.vertices, {}};
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middle;
    const auto middle_of = [&](std::int32_t a, std::int32_t b) {
        const auto [at, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)},
                                                    static_cast<std::int32_t>(out.vertices.size()));
        if (fresh) out.vertices.push_back(0.5 * mesh.vertices[a] + 0.5 * mesh.vertices[b]);
        return at->second;
    };
    for (const auto& [a, b, c] : mesh.faces) {
        const std::int32_t ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
        for (const Triangle& t :
             {Triangle{a, ab, ca}, Triangle{b, bc, ab}, Triangle{c, ca, bc}, Triangle{ab, bc, ca}})
            out.faces.push_back(t);
    }
    return out;
}

/// Octahedron split `levels` times and thrown onto the sphere: 8 * 4^levels faces.
inline IndexedMesh octasphere(int levels, double radius = 1.0)
{
    IndexedMesh mesh = octahedron();
    for (int i = 0; i < levels; ++i) {
        mesh = split_in_four(mesh);
        for (Vec3& p : mesh.vertices) p = normalized(p);
    }
    for (Vec3& p : mesh.vertices) p *= radius;
    return mesh;
}

/// Fast sphere of any size by longitude and latitude: 2 n (m - 1) faces for n meridians and m
/// parallel bands.
inline IndexedMesh globe(std::int32_t n, std::int32_t m, double radius = 1.0)
{
    IndexedMesh mesh;
    mesh.vertices.push_back({{0, 0, -radius}});
    for (std::int32_t j = 1; j < m; ++j)
        for (std::int32_t i = 0; i < n; ++i) {
            const double u = 2 * std::numbers::pi * i / n,
                         v = std::numbers::pi * (1.0 * j / m - .5);
            mesh.vertices.push_back({{radius * std::cos(v) * std::cos(u),
                                      radius * std::cos(v) * std::sin(u), radius * std::sin(v)}});
        }
    mesh.vertices.push_back({{0, 0, radius}});
    const auto at = [&](std::int32_t i, std::int32_t j) { return 1 + (j - 1) * n + i % n; };
    const auto top = static_cast<std::int32_t>(mesh.vertices.size()) - 1;
    for (std::int32_t i = 0; i < n; ++i) {
        mesh.faces.push_back({0, at(i + 1, 1), at(i, 1)});
        for (std::int32_t j = 1; j + 1 < m; ++j) {
            mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
        mesh.faces.push_back({at(i, m - 1), at(i + 1, m - 1), top});
    }
    return mesh;
}

/// n by m quadrilaterals, cut in two: genus 1.
inline IndexedMesh torus(std::int32_t n, std::int32_t m, double R = 2.0, double r = 1.0)
{
    IndexedMesh mesh;
    for (std::int32_t i = 0; i < n; ++i)
        for (std::int32_t j = 0; j < m; ++j) {
            const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
            const double d = R + r * std::cos(v);
            mesh.vertices.push_back({{d * std::cos(u), d * std::sin(u), r * std::sin(v)}});
        }
    const auto at = [&](std::int32_t i, std::int32_t j) { return (i % n) * m + j % m; };
    for (std::int32_t i = 0; i < n; ++i)
        for (std::int32_t j = 0; j < m; ++j) {
            mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// Flat sheet of n by m unit squares in the plane z = 0, facing up: 2 n m faces, one boundary.
inline IndexedMesh sheet(std::int32_t n, std::int32_t m)
{
    IndexedMesh mesh;
    for (std::int32_t i = 0; i <= n; ++i)
        for (std::int32_t j = 0; j <= m; ++j) mesh.vertices.push_back({{1.0 * i, 1.0 * j, 0.0}});
    const auto at = [&](std::int32_t i, std::int32_t j) { return i * (m + 1) + j; };
    for (std::int32_t i = 0; i < n; ++i)
        for (std::int32_t j = 0; j < m; ++j) {
            mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return mesh;
}

/// A strip of n quadrilaterals closed with half a turn: one-sided, one boundary.
inline IndexedMesh moebius(std::int32_t n)
{
    IndexedMesh mesh;
    for (std::int32_t i = 0; i < n; ++i) {
        const double u = 2 * std::numbers::pi * i / n;
        for (const double s : {-0.4, 0.4}) {
            const double d = 1 + s * std::cos(u / 2);
            mesh.vertices.push_back({{d * std::cos(u), d * std::sin(u), s * std::sin(u / 2)}});
        }
    }
    for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t a = 2 * i, b = a + 1;
        const std::int32_t c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
        mesh.faces.push_back({a, c, d});
        mesh.faces.push_back({a, d, b});
    }
    return mesh;
}

/// Both meshes side by side in one, nothing joined.
inline IndexedMesh together(IndexedMesh a, const IndexedMesh& b)
{
    const auto n = static_cast<std::int32_t>(a.n_vertices());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const auto& [i, j, k] : b.faces) a.faces.push_back({i + n, j + n, k + n});
    return a;
}

inline IndexedMesh moved(IndexedMesh mesh, const Transform& map)
{
    for (Vec3& p : mesh.vertices) p = apply(map, p);
    return mesh;
}

inline IndexedMesh turned_inside_out(IndexedMesh mesh)
{
    for (Triangle& t : mesh.faces) std::swap(t[1], t[2]);
    return mesh;
}

/// The same surface with faces, corners and vertices in another order.
inline IndexedMesh shuffled(const IndexedMesh& mesh, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::vector<std::int32_t> place(mesh.n_vertices());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::int32_t>(i);
    const auto shuffle = [&](auto& list) {
        for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random() % i]);
    };
    shuffle(place);
    IndexedMesh out;
    out.vertices.resize(mesh.n_vertices());
    for (std::size_t i = 0; i < place.size(); ++i) out.vertices[place[i]] = mesh.vertices[i];
    for (const Triangle& t : mesh.faces) {
        const std::size_t turn = random() % 3;
        out.faces.push_back({place[t[turn]], place[t[(turn + 1) % 3]], place[t[(turn + 2) % 3]]});
    }
    shuffle(out.faces);
    return out;
}

inline double uniform(std::mt19937& random, double from, double to)
{
    return from + (to - from) * (random() * 0x1p-32);
}

inline Vec3 point_in_cube(std::mt19937& random, double from, double to)
{
    Vec3 p;
    for (double& x : p.c) x = uniform(random, from, to);
    return p;
}

inline Transform random_rotation(std::mt19937& random)
{
    return rotation(uniform(random, 0, 360), point_in_cube(random, 0.1, 1.0));
}

}  // namespace genus::cases
