// Plane shapes, and the solids that are made of them or of other solids, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/language/run_model.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/mesh_solid.h"

namespace genus {
namespace {

constexpr double kPi = 3.14159265358979323846;

MeshedSolid made(const std::string& text)
{
    const TextModel model = read_model_text(text, "case.scad");
    MeshOptions options;
    options.tolerance = model.tolerance;
    return mesh_solid(model.solid, options);
}

void expect_volume(const std::string& text, double expected, std::int64_t euler = 2)
{
    SCOPED_TRACE(text);
    const MeshedSolid solid = made(text);
    EXPECT_TRUE(validate(solid.mesh).ok());
    EXPECT_NEAR(volume(solid.mesh), expected, 1e-9 * (1.0 + expected));
    EXPECT_EQ(topology(solid.mesh).euler, euler);
}

// Area of a regular polygon with n corners on a circle of radius r.
double polygon_area(int n, double r)
{
    return 0.5 * n * r * r * std::sin(2 * kPi / n);
}

TEST(Plane, ExtrusionsHaveTheVolumeOfTheirProfile)
{
    expect_volume("linear_extrude(3) square([2, 5]);", 30);
    expect_volume("linear_extrude(height = 3, center = true) square(2, center = true);", 12);
    expect_volume("linear_extrude(2) circle(r = 3, $fn = 7);", 2 * polygon_area(7, 3));
    expect_volume("linear_extrude(2) difference() { square(4); translate([1, 1]) square(2); }", 24,
                  0);
    expect_volume("linear_extrude(2) intersection() { square(4); translate([1, 1]) square(9); }",
                  18);
    expect_volume("linear_extrude(2) { square(1); translate([5, 0]) square(1); }", 4, 4);
    expect_volume("linear_extrude(6, scale = 0) square(2, center = true);", 8);
    expect_volume("linear_extrude(2) scale([2, 1]) rotate(45) square(1);", 4);
    expect_volume("linear_extrude(1) mirror([1, 0]) polygon([[0, 0], [3, 0], [0, 4]]);", 6);
    expect_volume(
        "linear_extrude(1) polygon([[0, 0], [4, 0], [4, 4], [0, 4], [1, 1], [3, 1], [3, 3], [1, "
        "3]],"
        " [[0, 1, 2, 3], [4, 5, 6, 7]]);",
        12, 0);
    // Pappus, with 64 corners round: the way of the centre is that of a polygon.
    expect_volume("rotate_extrude($fn = 64) translate([2, 0]) square(1);",
                  polygon_area(64, 3) - polygon_area(64, 2), 0);
    expect_volume("rotate_extrude(angle = 90, $fn = 64) translate([2, 0]) square(1);",
                  (polygon_area(64, 3) - polygon_area(64, 2)) / 4);
}

TEST(Plane, OffsetGrowsAndShrinks)
{
    expect_volume("linear_extrude(1) offset(delta = 1) square(10);", 144);
    expect_volume("linear_extrude(1) offset(delta = -1) square(10);", 64);
    expect_volume("linear_extrude(1) offset(r = 1, $fn = 32) square(10);",
                  140 + polygon_area(32, 1));
}

TEST(Plane, ProjectionIsShadowOrSection)
{
    expect_volume("linear_extrude(1) projection() translate([0, 0, 5]) cube([2, 3, 4]);", 6);
    expect_volume(
        "linear_extrude(1) projection(cut = true) difference() {"
        " cube(4, center = true); cube([2, 2, 9], center = true); }",
        12, 0);
}

TEST(Hull, SpansWhatIsInIt)
{
    expect_volume("hull() { cube(1); translate([2, 0, 0]) cube(1); }", 3);
    expect_volume("linear_extrude(2) hull() { square(1); translate([3, 0]) square(1); }", 8);
    expect_volume("hull() { difference() { cube(2); translate([1, 1, 1]) cube(2); } }",
                  8 - 1.0 / 6 - 0.0);
}

TEST(Minkowski, AddsWhatIsInIt)
{
    expect_volume("minkowski() { cube([1, 2, 3]); cube([4, 5, 6]); }", 5.0 * 7 * 9);
    // An L of three cubes and a cube: each side grows by 1.
    expect_volume("minkowski() { union() { cube([3, 1, 1]); cube([1, 3, 1]); } cube(1); }",
                  2 * (4 * 2 + 4 * 2 - 2 * 2));
    expect_volume("linear_extrude(1) minkowski() { square([4, 2]); square(1); }", 15);
    // A frame whose hole closes up.
    expect_volume(
        "minkowski() { difference() { cube([5, 5, 1]); translate([2, 2, -1]) cube([1, 1, 9]); }"
        " cube(1); }",
        6 * 6 * 2);
}

TEST(Plane, UnderAToleranceRoundProfilesAreWithinIt)
{
    const MeshedSolid rod = made("$tolerance = 0.01; linear_extrude(10) circle(5);");
    EXPECT_TRUE(validate(rod.mesh).ok());
    EXPECT_LE(rod.error.bound, 0.01);
    EXPECT_GT(rod.error.bound, 0.0);
    EXPECT_FALSE(rod.error.certified);
    const double exact = 250 * kPi;
    EXPECT_LT(volume(rod.mesh), exact);
    EXPECT_GT(volume(rod.mesh), exact - 0.01 * 2 * kPi * 5 * 10);
    const MeshedSolid ring =
        made("$tolerance = 0.01; rotate_extrude() translate([5, 0]) circle(1);");
    EXPECT_EQ(topology(ring.mesh).genus, 1);
    EXPECT_NEAR(volume(ring.mesh), 2 * kPi * kPi * 5, 0.01 * 4 * kPi * kPi * 5);
}

TEST(Plane, MixingWithSolidsWarnsAndTakesTheFirstKind)
{
    const TextModel model = read_model_text("union() { cube(1); square(5); }", "case.scad");
    ASSERT_EQ(model.messages.size(), 1u);
    EXPECT_NE(model.messages[0].text.find("Mixing 2D and 3D"), std::string::npos);
    EXPECT_NEAR(volume(mesh_solid(model.solid).mesh), 1.0, 1e-12);
}

TEST(Plane, AloneIsNoSolid)
{
    try {
        read_model_text("square(2);", "case.scad");
        FAIL();
    } catch (const ModelError& error) {
        EXPECT_NE(std::string(error.what()).find("plane shape"), std::string::npos);
    }
    EXPECT_THROW(read_model_text("rotate_extrude() square(2, center = true);", "case.scad"),
                 ModelError);
    EXPECT_THROW(read_model_text("linear_extrude(1) polygon([[0, 0], [1, \"a\"]]);", "case.scad"),
                 ModelError);
}

TEST(Import, ReadsAMeshBesideTheModel)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(testing::TempDir()) / "genus_import_test";
    fs::create_directories(folder);
    std::ofstream(folder / "tetrahedron.off")
        << "OFF\n4 4 6\n0 0 0\n6 0 0\n0 6 0\n0 0 6\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
    const std::string model = (folder / "model.scad").string();
    std::ofstream(model) << "difference() { import(\"tetrahedron.off\"); cube(1); }";
    EXPECT_NEAR(volume(mesh_solid(read_model(model).solid).mesh), 35.0, 1e-12);
    std::ofstream(folder / "broken.off") << "OFF\n4 4 6\n0 0";
    std::ofstream(model) << "\n import(\"broken.off\");";
    try {
        read_model(model);
        FAIL();
    } catch (const ModelError& error) {
        EXPECT_EQ(error.line(), 2);
        EXPECT_NE(std::string(error.what()).find("broken.off"), std::string::npos);
    }
    fs::remove_all(folder);
}

// Slices of a part, turned back to where they were cut: their outlines have corners in a row up to
// rounding, which no longer are in a row then.
TEST(Plane, SlicesPutTogetherAgain)
{
    const std::string part =
        "module part() { $fa = 30; difference() { sphere(r = 25);"
        "  for (turn = [[0, 0, 0], [90, 0, 0], [0, 90, 0]])"
        "    rotate(turn) cylinder(h = 62.5, r1 = 12.5, r2 = 6.25, center = true); } }"
        "module slice(i) { rotate(-30, [1, 1, 0]) translate([0, 0, -i])"
        "  linear_extrude(center = true, height = 0.5) projection(cut = true)"
        "  translate([0, 0, i]) rotate(30, [1, 1, 0]) part(); }";
    const auto meshed = [&](const std::string& call) {
        const MeshedSolid slices = made(part + call);
        EXPECT_LE(slices.error.measured, slices.error.bound) << call;
        EXPECT_TRUE(validate(slices.mesh).ok()) << call;
        return volume(slices.mesh);
    };
    double sum = 0.0;
    for (int i = -20; i <= 20; i += 5) sum += meshed("slice(" + std::to_string(i) + ");");
    EXPECT_NEAR(meshed("for (i = [-20 : 5 : 20]) slice(i);"), sum, 1e-9);
}

}  // namespace
}  // namespace genus
