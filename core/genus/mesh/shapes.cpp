#include "genus/mesh/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/platonic.h"

namespace genus {

namespace {

constexpr std::int64_t kMaxFaces = 100'000'000;

void require_size(double size, const char* what)
{
    require(std::isfinite(size) && size > 0.0, what, size, "positive and finite");
}

void require_count(std::int64_t n, std::int64_t least, std::int64_t most, const char* what)
{
    const std::string demand = "between " + std::to_string(least) + " and " + std::to_string(most);
    require(n >= least && n <= most, what, static_cast<double>(n), demand.c_str());
}

Vec2 on_circle(std::int64_t i, std::int64_t n)
{
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    return {{std::cos(angle), std::sin(angle)}};
}

// The points on the edges of the icosahedron are shared by two of its faces: they are numbered
// edge by edge, those inside a face by face.
class Icosphere {
public:
    Icosphere(std::int32_t parts, double radius)
        : corners_(to_triangles(platonic(3, 5))), n_(parts), radius_(radius)
    {
        const std::size_t n = static_cast<std::size_t>(parts);
        mesh_.vertices.reserve(10 * n * n + 2);
        mesh_.faces.reserve(20 * n * n);
        for (const Vec3& corner : corners_.vertices) mesh_.vertices.push_back(corner * radius_);
    }

    IndexedMesh run()
    {
        for (const Triangle& face : corners_.faces) cut(face);
        return std::move(mesh_);
    }

private:
    // Point (i, j) of a face lies i steps from corner 0 towards 1 and j towards 2.
    void cut(const Triangle& face)
    {
        std::vector<std::int32_t> below = row(face, 0), above;
        for (std::int32_t j = 0; j < n_; ++j) {
            current_progress().check();
            above = row(face, j + 1);
            for (std::int32_t i = 0; i + j < n_; ++i) {
                mesh_.faces.push_back({below[i], below[i + 1], above[i]});
                if (i + j + 1 < n_) mesh_.faces.push_back({below[i + 1], above[i + 1], above[i]});
            }
            below.swap(above);
        }
    }

    std::vector<std::int32_t> row(const Triangle& face, std::int32_t j)
    {
        std::vector<std::int32_t> numbers;
        for (std::int32_t i = 0; i + j <= n_; ++i) numbers.push_back(vertex(face, i, j));
        return numbers;
    }

    std::int32_t vertex(const Triangle& face, std::int32_t i, std::int32_t j)
    {
        const std::int32_t k = n_ - i - j;
        if (k == n_) return face[0];
        if (i == n_) return face[1];
        if (j == n_) return face[2];
        if (j == 0) return on_edge(face[0], face[1], i);
        if (k == 0) return on_edge(face[1], face[2], j);
        if (i == 0) return on_edge(face[2], face[0], k);
        return add({face[0], face[1], face[2]}, {k, i, j});
    }

    std::int32_t on_edge(std::int32_t a, std::int32_t b, std::int32_t steps)
    {
        if (a > b) return on_edge(b, a, n_ - steps);
        const auto key = static_cast<std::int32_t>(corners_.n_vertices()) * a + b;
        const auto [at, fresh] =
            first_on_edge_.try_emplace(key, static_cast<std::int32_t>(mesh_.n_vertices()));
        if (fresh)
            for (std::int32_t s = 1; s < n_; ++s) add({a, b, a}, {n_ - s, s, 0});
        return at->second + steps - 1;
    }

    std::int32_t add(const Triangle& corners, const std::array<std::int32_t, 3>& weights)
    {
        Vec3 sum;
        for (std::size_t i = 0; i < 3; ++i)
            sum += static_cast<double>(weights[i]) * corners_.vertices[corners[i]];
        mesh_.vertices.push_back(normalized(sum) * radius_);
        return static_cast<std::int32_t>(mesh_.n_vertices()) - 1;
    }

    IndexedMesh corners_;
    std::int32_t n_;
    double radius_;
    IndexedMesh mesh_;
    std::unordered_map<std::int32_t, std::int32_t> first_on_edge_;
};

}  // namespace

IndexedMesh icosphere(std::int32_t parts, double radius)
{
    require_count(parts, 1, 5000, "icosphere: parts");
    require_size(radius, "icosphere: radius");
    return Icosphere(parts, radius).run();
}

PolygonMesh grid_mesh(std::int32_t nx, std::int32_t ny, double width, double depth)
{
    require_count(nx, 1, kMaxFaces, "grid_mesh: nx");
    require_count(ny, 1, kMaxFaces / nx, "grid_mesh: ny");
    require_size(width, "grid_mesh: width");
    require_size(depth, "grid_mesh: depth");
    PolygonMesh mesh;
    for (std::int32_t j = 0; j <= ny; ++j)
        for (std::int32_t i = 0; i <= nx; ++i)
            mesh.vertices.push_back(
                {{i < nx ? width / nx * i : width, j < ny ? depth / ny * j : depth, 0.0}});
    for (std::int32_t j = 0; j < ny; ++j)
        for (std::int32_t i = 0; i < nx; ++i) {
            const std::int32_t v = j * (nx + 1) + i;
            mesh.add_face(std::array{v, v + 1, v + nx + 2, v + nx + 1});
        }
    return mesh;
}

PolygonMesh prism(std::int32_t n, double h, double r, bool center)
{
    require_count(n, 3, 10'000'000, "prism: n");
    require_size(h, "prism: h");
    require_size(r, "prism: r");
    PolygonMesh mesh;
    std::vector<std::int32_t> bottom, top;
    for (const double z : {center ? -0.5 * h : 0.0, center ? 0.5 * h : h})
        for (std::int32_t i = 0; i < n; ++i) {
            const Vec2 p = r * on_circle(i, n);
            mesh.vertices.push_back({{p[0], p[1], z}});
        }
    for (std::int32_t i = 0; i < n; ++i) {
        bottom.push_back(n - 1 - i);
        top.push_back(n + i);
    }
    mesh.add_face(bottom);
    mesh.add_face(top);
    for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t next = i + 1 < n ? i + 1 : 0;
        mesh.add_face(std::array{i, next, n + next, n + i});
    }
    return mesh;
}

PolygonMesh torus_mesh(double R, double r, std::int32_t nu, std::int32_t nv)
{
    require_count(nu, 3, kMaxFaces / 3, "torus_mesh: nu");
    require_count(nv, 3, std::max<std::int64_t>(3, kMaxFaces / nu), "torus_mesh: nv");
    require_size(r, "torus_mesh: r");
    require(std::isfinite(R) && R > r, "torus_mesh: R", R, "larger than r and finite");
    PolygonMesh mesh;
    for (std::int32_t i = 0; i < nu; ++i) {
        const Vec2 u = on_circle(i, nu);
        for (std::int32_t j = 0; j < nv; ++j) {
            const Vec2 v = on_circle(j, nv);
            const double d = R + r * v[0];
            mesh.vertices.push_back({{d * u[0], d * u[1], r * v[1]}});
        }
    }
    const auto at = [&](std::int32_t i, std::int32_t j) { return i % nu * nv + j % nv; };
    for (std::int32_t i = 0; i < nu; ++i)
        for (std::int32_t j = 0; j < nv; ++j)
            mesh.add_face(std::array{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    return mesh;
}

}  // namespace genus
