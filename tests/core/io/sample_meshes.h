#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "genus/io/read_mesh.h"
#include "genus/io/write_mesh.h"
#include "genus/mesh/indexed_mesh.h"

namespace genus {

inline std::span<const std::byte> as_bytes(std::string_view text)
{
    return std::as_bytes(std::span(text.data(), text.size()));
}

/// A closed torus of 2 * rings * sides triangles whose coordinates use all digits of a double.
inline IndexedMesh torus_mesh(int rings, int sides)
{
    constexpr double tau = 6.283185307179586;
    IndexedMesh mesh;
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < sides; ++j) {
            const double u = tau * i / rings;
            const double v = tau * j / sides;
            const double r = 30.0 + 10.0 * std::cos(v);
            mesh.vertices.push_back({{r * std::cos(u), r * std::sin(u), 10.0 * std::sin(v)}});
        }
    }
    const auto at = [&](int i, int j) { return (i % rings) * sides + j % sides; };
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < sides; ++j) {
            mesh.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            mesh.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return mesh;
}

/// A cube of side 2 as six quads, with a corner cut into triangles: faces of degree 3, 4 and 5.
inline PolygonMesh cut_cube()
{
    PolygonMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back({{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0}});
    mesh.vertices[7] = {{0.25, 1.0, 1.0}};
    mesh.vertices.push_back({{1.0, 0.25, 1.0}});
    mesh.vertices.push_back({{1.0, 1.0, 0.25}});
    for (const std::initializer_list<std::int32_t> face :
         std::initializer_list<std::initializer_list<std::int32_t>>{{0, 2, 3, 1},
                                                                    {0, 1, 5, 4},
                                                                    {0, 4, 6, 2},
                                                                    {1, 3, 9, 8, 5},
                                                                    {2, 6, 7, 9, 3},
                                                                    {4, 5, 8, 7, 6},
                                                                    {7, 8, 9}})
        mesh.add_face(std::span(face.begin(), face.size()));
    return mesh;
}

/// The mesh with vertices in the order in which the faces first use them, unused ones left out.
inline IndexedMesh in_order_of_use(const IndexedMesh& mesh)
{
    IndexedMesh result;
    std::vector<std::int32_t> number(mesh.n_vertices(), -1);
    for (Triangle face : mesh.faces) {
        for (std::int32_t& v : face) {
            if (number[v] < 0) {
                number[v] = static_cast<std::int32_t>(result.n_vertices());
                result.vertices.push_back(mesh.vertices[v]);
            }
            v = number[v];
        }
        result.faces.push_back(face);
    }
    return result;
}

/// Positions rounded to 4-byte numbers.
inline IndexedMesh rounded_to_floats(IndexedMesh mesh)
{
    for (Vec3& v : mesh.vertices) {
        for (double& x : v.c) {
            const volatile float rounded = static_cast<float>(x);  // GCC 12 drops it otherwise
            x = rounded;
        }
    }
    return mesh;
}

}  // namespace genus
