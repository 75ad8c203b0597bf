#include "genus/mesh/dual.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/platonic.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"

using namespace genus;

namespace {

// Corners of each face, begun with the smallest.
std::vector<std::vector<std::int32_t>> connectivity(const PolygonMesh& mesh)
{
    std::vector<std::vector<std::int32_t>> faces;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        std::vector<std::int32_t> face(mesh.face(f).begin(), mesh.face(f).end());
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        faces.push_back(face);
    }
    return faces;
}

constexpr std::array<std::array<int, 2>, 5> kFive{{{3, 3}, {4, 3}, {3, 4}, {5, 3}, {3, 5}}};

}  // namespace

TEST(Dual, OfTheDualHasTheConnectivityOfTheMesh)
{
    std::vector<PolygonMesh> meshes{cases::box_polygons()};
    for (const IndexedMesh& mesh : {cases::octasphere(3), cases::torus(9, 7),
                                    cases::shuffled(cases::torus(12, 8), 3), cases::globe(9, 6)})
        meshes.push_back(to_polygons(mesh));
    for (const PolygonMesh& mesh : meshes) {
        const PolygonMesh once = dual(mesh), twice = dual(once);
        EXPECT_EQ(connectivity(twice), connectivity(mesh));
        const Topology a = topology(mesh), b = topology(once);
        EXPECT_EQ(a.vertices, b.faces);
        EXPECT_EQ(a.edges, b.edges);
        EXPECT_EQ(a.faces, b.vertices);
        EXPECT_EQ(a.genus, b.genus);
        EXPECT_TRUE(b.closed && b.oriented && b.manifold);
    }
}

TEST(Dual, KeepsTheOutsideOutside)
{
    EXPECT_NEAR(volume(to_triangles(dual(cases::box_polygons({{2, 2, 2}})))), 4.0 / 3, 1e-15);
    EXPECT_LT(volume(to_triangles(dual(cases::turned_inside_out(cases::octasphere(2))))), 0);
}

TEST(Dual, RefusesOpenMeshes)
{
    EXPECT_THROW(dual(cases::sheet(2, 2)), InvalidInput);
    PolygonMesh lonely = cases::box_polygons();
    lonely.vertices.push_back({});
    EXPECT_THROW(dual(lonely), InvalidInput);
}

TEST(Platonic, CountsAreThoseOfTheSymbol)
{
    for (const auto& [p, q] : kFive) {
        SCOPED_TRACE("{" + std::to_string(p) + ", " + std::to_string(q) + "}");
        const PolygonMesh mesh = platonic(p, q);
        const Topology t = topology(mesh);
        const PlatonicCounts counts = platonic_counts(p, q);
        EXPECT_EQ((PlatonicCounts{t.vertices, t.edges, t.faces}), counts);
        EXPECT_EQ(t.euler, 2);
        EXPECT_EQ(t.least_valence, q);
        EXPECT_EQ(t.greatest_valence, q);
        for (std::size_t f = 0; f < mesh.n_faces(); ++f)
            EXPECT_EQ(mesh.face(f).size(), static_cast<std::size_t>(p));
        EXPECT_TRUE(validate(to_triangles(mesh)).ok());
        // The dual has the counts of {q, p}.
        const PlatonicCounts other = platonic_counts(q, p);
        EXPECT_EQ((PlatonicCounts{counts.faces, counts.edges, counts.vertices}), other);
    }
}

TEST(Platonic, IsRegular)
{
    for (const auto& [p, q] : kFive) {
        const PolygonMesh mesh = platonic(p, q);
        double shortest = 9, longest = 0;
        for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
            const auto face = mesh.face(f);
            Vec3 middle;
            for (std::size_t i = 0; i < face.size(); ++i) {
                const double d =
                    distance(mesh.vertices[face[i]], mesh.vertices[face[(i + 1) % face.size()]]);
                shortest = std::min(shortest, d);
                longest = std::max(longest, d);
                middle += mesh.vertices[face[i]];
            }
            // Flat: all corners at the same height over the face's direction.
            middle = normalized(middle);
            for (const std::int32_t v : face)
                EXPECT_NEAR(dot(mesh.vertices[v], middle), dot(mesh.vertices[face[0]], middle),
                            1e-14);
        }
        EXPECT_NEAR(shortest, longest, 1e-14);
        for (const Vec3& v : mesh.vertices) EXPECT_NEAR(norm(v), 1, 1e-15);
    }
    // Volumes on the unit sphere.
    EXPECT_NEAR(volume(to_triangles(platonic(3, 3))), 8 * std::sqrt(3.0) / 27, 1e-14);
    EXPECT_NEAR(volume(to_triangles(platonic(4, 3))), 8 * std::sqrt(3.0) / 9, 1e-14);
    EXPECT_NEAR(volume(to_triangles(platonic(3, 4))), 4.0 / 3, 1e-14);
    const double root = std::sqrt(5.0);
    const double a = 4 / (std::sqrt(3.0) * (1 + root)), b = 4 / std::sqrt(10 + 2 * root);
    EXPECT_NEAR(volume(to_triangles(platonic(5, 3))), (15 + 7 * root) / 4 * a * a * a, 1e-14);
    EXPECT_NEAR(volume(to_triangles(platonic(3, 5))), 5 * (3 + root) / 12 * b * b * b, 1e-14);
}

TEST(Platonic, OnlyTheseFive)
{
    int accepted = 0;
    for (int p = -2; p < 12; ++p)
        for (int q = -2; q < 12; ++q) {
            try {
                platonic(p, q);
                ++accepted;
            } catch (const InvalidInput& e) {
                EXPECT_NE(std::string(e.what()).find("(p - 2)(q - 2) < 4"), std::string::npos);
            }
        }
    EXPECT_EQ(accepted, 5);
    EXPECT_THROW(platonic(2'000'000'000, 2'000'000'000), InvalidInput);
}
