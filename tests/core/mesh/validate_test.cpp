#include "genus/mesh/validate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "cases/meshes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"

using namespace genus;

namespace {

// All findings are of this one kind, and there are `count` of them.
void expect_only(const Validation& v, Defect defect, std::int64_t count)
{
    for (std::size_t k = 0; k < kDefects; ++k)
        EXPECT_EQ(v.counts[k], k == static_cast<std::size_t>(defect) ? count : 0)
            << name(static_cast<Defect>(k));
}

IndexedMesh good()
{
    return cases::octasphere(3);
}

}  // namespace

TEST(Validate, FindsNothingInGoodMeshes)
{
    for (const IndexedMesh& mesh :
         {good(), cases::box(), cases::tetrahedron(), cases::torus(20, 12), IndexedMesh{},
          cases::together(cases::box(), cases::moved(cases::box(), translation({{3, 0, 0}})))}) {
        const Validation v = validate(mesh);
        EXPECT_TRUE(v.ok()) << v.findings.front().text;
        EXPECT_TRUE(v.self_intersections_complete);
        EXPECT_TRUE(v.topology.closed);
    }
}

TEST(Validate, NamesAnIndexOutOfRange)
{
    IndexedMesh mesh = good();
    mesh.faces[17][2] = 1'000'000;
    const Validation v = validate(mesh);
    expect_only(v, Defect::IndexOutOfRange, 1);
    EXPECT_EQ(v.findings[0].faces, std::vector<std::int32_t>{17});
    EXPECT_NE(v.findings[0].text.find("1000000"), std::string::npos);
}

TEST(Validate, NamesANonFiniteCoordinate)
{
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        IndexedMesh mesh = good();
        mesh.vertices[21][1] = bad;
        const Validation v = validate(mesh);
        expect_only(v, Defect::NonFinite, 1);
        EXPECT_EQ(v.findings[0].vertices, std::vector<std::int32_t>{21});
        EXPECT_FALSE(v.self_intersections_complete);
    }
}

TEST(Validate, NamesDegenerateFaces)
{
    IndexedMesh mesh = good();
    mesh.faces.push_back({3, 3, 5});
    const Validation twice = validate(mesh);
    expect_only(twice, Defect::DegenerateFace, 1);
    EXPECT_EQ(twice.findings[0].faces[0], static_cast<std::int32_t>(mesh.n_faces() - 1));

    // A box with a vertex in the middle of one diagonal, joined to its neighbour by a face without
    // area: the halves touch that neighbour along a part of its side.
    IndexedMesh box = cases::box();
    const Triangle t = box.faces[0];
    box.vertices.push_back(0.5 * box.vertices[t[0]] + 0.5 * box.vertices[t[1]]);
    box.faces[0] = {t[0], 8, t[2]};
    box.faces.push_back({8, t[1], t[2]});
    box.faces.push_back({t[1], 8, t[0]});
    const Validation flat = validate(box);
    EXPECT_EQ(flat.count(Defect::DegenerateFace), 1);
    EXPECT_EQ(flat.count(Defect::SelfIntersection), 2);
    EXPECT_EQ(flat.findings.size(), 3u);
    EXPECT_EQ(flat.findings[0].faces, std::vector<std::int32_t>{13});
}

TEST(Validate, NamesADuplicateFace)
{
    IndexedMesh mesh = good();
    const Triangle t = mesh.faces[40];
    mesh.faces.push_back({t[1], t[2], t[0]});
    const Validation v = validate(mesh);
    EXPECT_EQ(v.count(Defect::DuplicateFace), 1);
    EXPECT_EQ(v.count(Defect::ComplexEdge), 3);
    EXPECT_EQ(v.count(Defect::SelfIntersection), 0);
    EXPECT_EQ(v.findings[0].faces,
              (std::vector<std::int32_t>{40, static_cast<std::int32_t>(mesh.n_faces() - 1)}));
}

TEST(Validate, NamesOpenEdges)
{
    IndexedMesh mesh = good();
    const Triangle gone = mesh.faces[99];
    mesh.faces.erase(mesh.faces.begin() + 99);
    const Validation v = validate(mesh);
    expect_only(v, Defect::OpenEdge, 3);
    for (const Finding& f : v.findings)
        for (const std::int32_t vertex : f.vertices)
            EXPECT_NE(std::find(gone.begin(), gone.end(), vertex), gone.end());
}

TEST(Validate, NamesAFlippedFace)
{
    IndexedMesh mesh = good();
    std::swap(mesh.faces[12][1], mesh.faces[12][2]);
    const Validation v = validate(mesh);
    expect_only(v, Defect::FlippedEdge, 3);
    for (const Finding& f : v.findings) EXPECT_TRUE(f.faces[0] == 12 || f.faces[1] == 12);
}

TEST(Validate, NamesATJunction)
{
    // One of the two faces at an edge is cut in the middle of it, the other is not.
    IndexedMesh mesh = cases::box({{2, 2, 2}});
    const Triangle t = mesh.faces[5];
    mesh.vertices.push_back(0.5 * mesh.vertices[t[0]] + 0.5 * mesh.vertices[t[1]]);
    const auto middle = static_cast<std::int32_t>(mesh.n_vertices() - 1);
    mesh.faces[5] = {t[0], middle, t[2]};
    mesh.faces.push_back({middle, t[1], t[2]});
    const Validation v = validate(mesh);
    EXPECT_EQ(v.count(Defect::OpenEdge), 3);
    ASSERT_EQ(v.count(Defect::TJunction), 1);
    const Finding& finding = v.findings.back();
    EXPECT_EQ(finding.defect, Defect::TJunction);
    EXPECT_EQ(finding.vertices[0], middle);
    EXPECT_EQ(finding.at, mesh.vertices[middle]);
    std::vector<std::int32_t> edge{finding.vertices[1], finding.vertices[2]}, cut{t[0], t[1]};
    std::sort(edge.begin(), edge.end());
    std::sort(cut.begin(), cut.end());
    EXPECT_EQ(edge, cut);
    const Triangle& across = mesh.faces[finding.faces[0]];
    EXPECT_EQ(std::count(across.begin(), across.end(), middle), 0);
    EXPECT_NE(finding.text.find("lies within the open edge"), std::string::npos);
}

TEST(Validate, NamesAComplexEdgeAndItsOpenEnds)
{
    IndexedMesh mesh = good();
    const Triangle t = mesh.faces[0];
    mesh.vertices.push_back({{5, 5, 5}});
    const auto apex = static_cast<std::int32_t>(mesh.n_vertices() - 1);
    mesh.faces.push_back({t[0], t[1], apex});
    const Validation v = validate(mesh);
    EXPECT_EQ(v.count(Defect::ComplexEdge), 1);
    EXPECT_EQ(v.count(Defect::OpenEdge), 2);
    EXPECT_EQ(v.count(Defect::ComplexVertex), 0);
}

TEST(Validate, NamesAComplexVertex)
{
    // Two boxes joined at a corner.
    IndexedMesh mesh = cases::box();
    const IndexedMesh other = cases::moved(cases::box(), translation({{1, 1, 1}}));
    for (Triangle t : other.faces) {
        for (std::int32_t& v : t) v = v == 0 ? 7 : v + 7;
        mesh.faces.push_back(t);
    }
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin() + 1, other.vertices.end());
    const Validation v = validate(mesh);
    expect_only(v, Defect::ComplexVertex, 1);
    EXPECT_EQ(v.findings[0].vertices, std::vector<std::int32_t>{7});
    EXPECT_EQ(v.findings[0].at, (Vec3{{1, 1, 1}}));
}

TEST(Validate, AllowsPartsThatTouchInCommonVertices)
{
    // The same two boxes with a vertex each, and two boxes along a common edge.
    for (const Vec3& by : {Vec3{{1, 1, 1}}, Vec3{{1, 1, 0}}}) {
        const IndexedMesh mesh =
            cases::together(cases::box(), cases::moved(cases::box(), translation(by)));
        EXPECT_TRUE(validate(mesh).ok());
    }
}

TEST(Validate, NamesFacesThatMeet)
{
    // A vertex pulled through the opposite side of a sphere.
    IndexedMesh mesh = good();
    mesh.vertices[4] = {{0, 0, -1.5}};
    const Validation v = validate(mesh);
    EXPECT_GT(v.count(Defect::SelfIntersection), 0);
    for (const Finding& f : v.findings)
        if (f.defect == Defect::SelfIntersection) {
            EXPECT_EQ(f.faces.size(), 2u);
        }

    ValidateOptions options;
    options.self_intersections = false;
    const Validation skipped = validate(mesh, options);
    EXPECT_TRUE(skipped.ok());
    EXPECT_FALSE(skipped.self_intersections_complete);
}

TEST(Validate, CountsTheCrossingsOfTwoBoxes)
{
    // A rod through the middle of a plate: four sides through two faces, none near an edge.
    const IndexedMesh plate = cases::moved(cases::box({{8, 8, 1}}), translation({{-4, -4, 0}}));
    const IndexedMesh rod =
        cases::moved(cases::box({{1, 1, 4}}), translation({{1.25, -0.375, -1.5}}));
    const auto found = self_intersections(cases::together(plate, rod));
    EXPECT_TRUE(found.complete);
    EXPECT_GE(found.pairs.size(), 16u);
    for (const auto& [f, g] : found.pairs) {
        EXPECT_LT(f, 12);
        EXPECT_GE(g, 12);
    }
}

TEST(Validate, FindsFoldsAmongNeighbours)
{
    // Faces with a common vertex or edge only: a folded fan and a coplanar flap.
    const IndexedMesh flap{{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0.25, 0.25, 0}}},
                           {{0, 1, 2}, {1, 0, 3}}};
    EXPECT_EQ(self_intersections(flap).pairs.size(), 1u);
}

TEST(Validate, AgreesWithAllPairsOnRandomSoup)
{
    std::mt19937 random(31);
    for (int i = 0; i < 5; ++i) {
        IndexedMesh mesh;
        for (int f = 0; f < 1500; ++f) {
            const Vec3 p = cases::point_in_cube(random, 0, 1);
            const auto n = static_cast<std::int32_t>(mesh.n_vertices());
            for (int k = 0; k < 3; ++k)
                mesh.vertices.push_back(p + cases::point_in_cube(random, 0, 0.1));
            mesh.faces.push_back({n, n + 1, n + 2});
        }
        const auto found = self_intersections(mesh);
        set_thread_count(1);
        EXPECT_EQ(found.pairs, self_intersections(mesh).pairs);
        set_thread_count(2);
        // Triangles cross if a side of one passes through the other: counted with volumes.
        const auto passes = [&](const Triangle& s, const Triangle& t) {
            const auto volume = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
                return dot(b - a, cross(c - a, d - a));
            };
            const auto& v = mesh.vertices;
            for (int k = 0; k < 3; ++k) {
                const Vec3 &p = v[s[k]], &q = v[s[(k + 1) % 3]];
                const Vec3 &a = v[t[0]], &b = v[t[1]], &c = v[t[2]];
                const double x = volume(p, q, a, b), y = volume(p, q, b, c), z = volume(p, q, c, a);
                if (volume(a, b, c, p) * volume(a, b, c, q) < 0 && x * y > 0 && y * z > 0)
                    return true;
            }
            return false;
        };
        std::vector<std::pair<std::int32_t, std::int32_t>> expected;
        for (std::int32_t f = 0; f < 1500; ++f)
            for (std::int32_t g = f + 1; g < 1500; ++g)
                if (passes(mesh.faces[f], mesh.faces[g]) || passes(mesh.faces[g], mesh.faces[f]))
                    expected.push_back({f, g});
        EXPECT_EQ(found.pairs, expected);
        EXPECT_GT(expected.size(), 100u);
    }
}

TEST(Validate, KnowsCavitiesFromInvertedParts)
{
    const IndexedMesh shell = cases::octasphere(2, 3), core = cases::octasphere(2, 1);
    expect_only(validate(cases::turned_inside_out(shell)), Defect::Inverted, 1);
    EXPECT_TRUE(validate(cases::together(shell, cases::turned_inside_out(core))).ok());
    // Matter within matter, and a cavity in nothing.
    expect_only(validate(cases::together(shell, core)), Defect::Inverted, 1);
    expect_only(validate(cases::together(cases::turned_inside_out(shell), core)), Defect::Inverted,
                2);
    // A stone in the cavity of a shell.
    const IndexedMesh hollow =
        cases::together(shell, cases::turned_inside_out(cases::octasphere(2, 2)));
    EXPECT_TRUE(validate(cases::together(hollow, core)).ok());
}

TEST(Validate, ListsNoMoreThanAskedButCountsAll)
{
    ValidateOptions options;
    options.max_findings = 5;
    const Validation v = validate(cases::sheet(20, 20), options);
    EXPECT_EQ(v.findings.size(), 5u);
    EXPECT_EQ(v.count(Defect::OpenEdge), 80);
    EXPECT_FALSE(v.ok());
}

TEST(Validate, EndsEarlyWhereEverythingMeetsEverything)
{
    // All pairs of 1,500 triangles cross: more than a million.
    IndexedMesh mesh;
    std::mt19937 random(3);
    for (int f = 0; f < 1'500; ++f) {
        const auto n = static_cast<std::int32_t>(mesh.n_vertices());
        for (int k = 0; k < 3; ++k) {
            Vec3 p = cases::point_in_cube(random, -0.01, 0.01);
            p[k] += 10;
            mesh.vertices.push_back(p);
        }
        mesh.faces.push_back({n, n + 1, n + 2});
    }
    const auto found = self_intersections(mesh);
    EXPECT_FALSE(found.complete);
    EXPECT_GT(found.pairs.size(), 2'000u);
}

TEST(Validate, CanBeCancelled)
{
    Progress progress;
    progress.cancel();
    const ProgressScope scope(progress);
    EXPECT_THROW(validate(cases::octasphere(4)), Cancelled);
}

TEST(Validate, LargeMeshes)
{
    const bool full = std::getenv("GENUS_LONG") != nullptr;
    const IndexedMesh mesh =
        full ? cases::shuffled(cases::globe(1000, 501), 1) : cases::globe(200, 101);
    const double start = seconds_now();
    const Validation v = validate(mesh);
    RecordProperty("seconds", std::to_string(seconds_now() - start));
    EXPECT_TRUE(v.ok()) << v.findings.front().text;
    EXPECT_EQ(v.topology.genus, 0);
}
