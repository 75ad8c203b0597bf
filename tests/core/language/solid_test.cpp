// From the text to the solid.
#include <gtest/gtest.h>

#include <cmath>

#include "core/language/run_model.h"

namespace genus {
namespace {

TextModel read(const std::string& text, const ModelOptions& options = {})
{
    return read_model_text(text, "case.scad", options);
}

void expect_bounds(const std::string& text, const Vec3& min, const Vec3& max)
{
    SCOPED_TRACE(text);
    const Box3 box = read(text).solid.bounds();
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(box.min[i], min[i], 1e-9);
        EXPECT_NEAR(box.max[i], max[i], 1e-9);
    }
}

TEST(Solids, HaveTheExtentTheyAreWrittenWith)
{
    expect_bounds("cube([1, 2, 3]);", {{0, 0, 0}}, {{1, 2, 3}});
    expect_bounds("cube([1, 2, 3], center = true);", {{-.5, -1, -1.5}}, {{.5, 1, 1.5}});
    expect_bounds("$tolerance = 0.1; sphere(d = 4);", {{-2, -2, -2}}, {{2, 2, 2}});
    expect_bounds("$tolerance = 0.1; cylinder(h = 3, r1 = 1, r2 = 2);", {{-2, -2, 0}}, {{2, 2, 3}});
    expect_bounds("translate([1, 2, 3]) cube(1);", {{1, 2, 3}}, {{2, 3, 4}});
    expect_bounds("rotate(90) cube([1, 2, 3]);", {{-2, 0, 0}}, {{0, 1, 3}});
    expect_bounds("rotate(a = 120, v = [1, 1, 1]) cube([1, 2, 3]);", {{0, 0, 0}}, {{3, 1, 2}});
    expect_bounds("mirror([1, 0, 0]) scale([2, 1, 1]) cube(1);", {{-2, 0, 0}}, {{0, 1, 1}});
    expect_bounds("multmatrix([[1, 0, 0, 5]]) cube(1);", {{5, 0, 0}}, {{6, 1, 1}});
    expect_bounds("torus(R = 3, r = 1);", {{-4, -4, -1}}, {{4, 4, 1}});
    expect_bounds("implicit(\"x^2 + y^2 + z^2 - 1\", [[-2, -2, -2], [2, 2, 3]]);", {{-2, -2, -2}},
                  {{2, 2, 3}});
    expect_bounds("ellipsoid(1, 2, 3);", {{-1, -2, -3}}, {{1, 2, 3}});
    expect_bounds("ellipsoid([1, 2, 3]);", {{-1, -2, -3}}, {{1, 2, 3}});
    expect_bounds("cone(h = 2, r = 1);", {{-1, -1, 0}}, {{1, 1, 2}});
    expect_bounds("cube(1); translate([4, 0, 0]) cube(1);", {{0, 0, 0}}, {{5, 1, 1}});
    expect_bounds("intersection() { cube(4); translate([1, 1, 1]) cube(9); }", {{1, 1, 1}},
                  {{4, 4, 4}});
    expect_bounds("for (i = [0:2]) translate([i, 0, 0]) cube(1);", {{0, 0, 0}}, {{3, 1, 1}});
    expect_bounds("resize([4, 0, 2]) cube(1);", {{0, 0, 0}}, {{4, 1, 2}});
    expect_bounds("resize([4, 0, 0], auto = true) cube(1);", {{0, 0, 0}}, {{4, 4, 4}});
}

TEST(Solids, ModifiersPickAndLeaveOut)
{
    expect_bounds("cube(1); %translate([9, 0, 0]) cube(1); *translate([0, 9, 0]) cube(1);",
                  {{0, 0, 0}}, {{1, 1, 1}});
    expect_bounds("cube(9); translate([5, 0, 0]) !cube(2);", {{0, 0, 0}}, {{2, 2, 2}});
    expect_bounds("#cube(3);", {{0, 0, 0}}, {{3, 3, 3}});
}

TEST(Solids, WithoutExtentAreEmpty)
{
    for (const char* text :
         {"", "cube(0);", "cube([1, 0, 1]);", "sphere(0);", "cylinder(h = 0);", "cylinder(r = 0);",
          "cube(-1);", "union() {}", "scale([1, 0, 1]) cube(1);",
          "difference() { union() {} cube(1); }", "intersection() { cube(1); union() {} }"}) {
        SCOPED_TRACE(text);
        EXPECT_TRUE(read(text).solid.is_empty());
    }
    EXPECT_EQ(read("scale([1, 0, 1]) cube(1);").messages.size(), 1u);
}

TEST(Solids, EqualTextsGiveEqualTrees)
{
    const Solid direct = subtract({sphere(2, 20), cylinder(9, 1, 1, true, 20)});
    const Solid text =
        read("$fn = 20; difference() { sphere(2); cylinder(h = 9, r = 1, center = true); }").solid;
    EXPECT_TRUE(text == direct);
    EXPECT_EQ(text.hash(), direct.hash());
}

int fragments_of(const std::string& text, const ModelOptions& options = {})
{
    const TextModel model = read_model_text(text, "case.scad", options);
    return model.tree.children.at(0).fragments;
}

TEST(Facets, FollowTheSpecialVariables)
{
    EXPECT_EQ(fragments_of("sphere(1);"), 5);
    EXPECT_EQ(fragments_of("sphere(5);"), 16);    // 2 pi 5 / 2 = 15.7
    EXPECT_EQ(fragments_of("sphere(100);"), 30);  // 360 / 12
    EXPECT_EQ(fragments_of("sphere(100, $fa = 1);"), 315);
    EXPECT_EQ(fragments_of("sphere(10, $fn = 2);"), 3);
    EXPECT_EQ(fragments_of("$fn = 7; cylinder(r1 = 1, r2 = 9);"), 7);
    EXPECT_EQ(fragments_of("cylinder(r1 = 1, r2 = 5);"), 16);
    EXPECT_EQ(fragments_of("sphere(1e-9);"), 3);
    // Too fine a wish is taken for 0.01.
    EXPECT_EQ(fragments_of("sphere(1, $fs = 0, $fa = 0);"), 629);
}

TEST(Facets, GiveWayToATolerance)
{
    ModelOptions options;
    options.tolerance = 0.05;
    EXPECT_EQ(fragments_of("sphere(5);", options), 0);
    EXPECT_EQ(fragments_of("sphere(5, $fn = 9);", options), 9);
    EXPECT_EQ(fragments_of("$fn = 9; sphere(5);", options), 9);
    EXPECT_EQ(fragments_of("$tolerance = 0.1; sphere(5);"), 0);
    EXPECT_EQ(fragments_of("$tolerance = 0; sphere(5);"), 16);
    EXPECT_EQ(read("$tolerance = 0.1; cube(1);").tolerance, std::optional(0.1));
    EXPECT_EQ(read("$tolerance = 0.1; cube(1);", options).tolerance, std::optional(0.05));
    EXPECT_EQ(read("cube(1);").tolerance, std::nullopt);
}

TEST(Polyhedron, TurnsFacesOver)
{
    // Clockwise from outside in the text, counterclockwise in the mesh: the signed volume of this
    // tetrahedron is positive.
    const TextModel model = read(
        "polyhedron(points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],"
        " faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]);");
    const PolygonMesh& mesh = *std::get<Polyhedron>(model.solid.node().shape).mesh;
    double six_volumes = 0;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        six_volumes +=
            dot(mesh.vertices[face[0]], cross(mesh.vertices[face[1]], mesh.vertices[face[2]]));
    }
    EXPECT_DOUBLE_EQ(six_volumes, 1.0);
    EXPECT_THROW(read("polyhedron([[0, 0, 0]], [[0, 1, 2]]);"), ModelError);
    EXPECT_THROW(read("polyhedron([[0, 0, 1/0]], [[0, 0, 0]]);"), ModelError);
    EXPECT_THROW(read("polyhedron([[0, 0]], [[0, 0, 0]]);"), ModelError);
}

TEST(Solids, WhatCannotBeMadeIsToldWhereItIsMade)
{
    for (const char* feature :
         {"torus(R = 1, r = 2);", "linear_extrude(2) polygon([[0, \"a\"], [1, 0], [0, 1]]);"}) {
        SCOPED_TRACE(feature);
        ModelOptions options;
        options.solid = false;
        EXPECT_NO_THROW(read(feature, options));
        // Only where it is instantiated.
        EXPECT_NO_THROW(read("if (false) " + std::string(feature)));
        EXPECT_NO_THROW(read("%" + std::string(feature)));
        try {
            read(std::string("\n  ") + feature);
            ADD_FAILURE() << "must throw";
        } catch (const ModelError& e) {
            EXPECT_EQ(e.line(), 2);
            EXPECT_FALSE(e.problem().empty());
        }
    }
    EXPECT_THROW(read("torus(R = 1, r = 2);"), ModelError);
    EXPECT_THROW(read("torus();"), ModelError);
    for (const char* wrong : {"implicit(\"x +\", [[0, 0, 0], [1, 1, 1]]);", "implicit(1, 2);",
                              "implicit(\"x\");", "implicit(\"x\", [[0, 0, 0]]);"})
        EXPECT_THROW(read(wrong), ModelError) << wrong;
}

TEST(Options, DefinesReplaceVariables)
{
    ModelOptions options;
    options.defines = {{"n", "3 + 4"}, {"s", "\"text\""}, {"fresh", "[1, 2]"}};
    const std::string text = "n = 1; m = n * 2; s = \"\"; echo(n, m, s, fresh);";
    EXPECT_EQ(run_model(text, options).echo, "ECHO: 7, 14, \"text\", [1, 2]\n");
    options.defines = {{"n", "1 +"}};
    EXPECT_NE(run_model(text, options).error, "");
    options.defines = {{"n", "1; cube(2)"}};
    EXPECT_NE(run_model(text, options).error, "");
    options.defines = {{"n m", "1"}};
    EXPECT_THROW(run_model(text, options), InvalidInput);
}

TEST(Options, LibrariesAreFoundInTheirFolders)
{
    const ScratchFolder folder;
    folder.write("lib/tools/t.scad", "include <part.scad>\nfunction f() = part; echo(\"never\");");
    folder.write("lib/tools/part.scad", "part = 5;");
    const std::string model = folder.write("model/m.scad", "use <tools/t.scad>\necho(f());");
    EXPECT_THROW(read_model(model), ModelError);
    ModelOptions options;
    options.library_paths = {folder.file("lib")};
    EXPECT_EQ(echo_text(read_model(model, options).messages), "ECHO: 5\n");
}

TEST(UsedFiles, SeeTheCallersSpecialVariables)
{
    const ScratchFolder folder;
    folder.write("lib.scad",
                 "base = 10; n = $fn * 2; function get() = n; function get_base() = base;");
    const std::string model =
        folder.write("m.scad",
                     "use <lib.scad>\nbase = 1; echo(get(), get_base());\n"
                     "module m() echo(get()); m($fn = 6); m($fn = 8); echo(let($fn = 50) get());");
    EXPECT_EQ(echo_text(read_model(model).messages),
              "ECHO: 0, 10\nECHO: 12\nECHO: 16\nECHO: 100\n");
}

TEST(Text, NumbersBeyondTheReference)
{
    EXPECT_EQ(run_model("echo(0xff, 0x10 + 1, 0XaB);").echo, "ECHO: 255, 17, 171\n");
    EXPECT_EQ(run_model("echo(1e400, 1e-400);").echo, "ECHO: inf, 0\n");
}

TEST(Text, EachClosureHasItsOwnVariables)
{
    EXPECT_EQ(run_model("f = [for (i = [0:2]) function() i]; echo([for (g = f) g()]);").echo,
              "ECHO: [0, 1, 2]\n");
    EXPECT_EQ(
        run_model("f = [for (i = 0; i < 3; i = i + 1) function() i]; echo([for (g = f) g()]);")
            .echo,
        "ECHO: [0, 1, 2]\n");
    EXPECT_EQ(run_model("f = [for (i = [0:1], j = [5:6]) let (k = i * j) function() [i, j, k]];"
                        "echo([for (g = f) g()]);")
                  .echo,
              "ECHO: [[0, 5, 0], [0, 6, 0], [1, 5, 5], [1, 6, 6]]\n");
}

TEST(Text, ArgumentsMayRunTheSameCall)
{
    // While the arguments of a call are evaluated the same call may run with another function.
    EXPECT_EQ(
        run_model("a = function(x, y) x + y; b = function(y, x) x - y;"
                  "function go(f, n) = n == 0 ? 1 : f(x = go(n % 2 == 0 ? b : a, n - 1), y = n);"
                  "echo(go(a, 3));")
            .echo,
        "ECHO: 5\n");
}

TEST(Text, RandomNumbersRepeat)
{
    const std::string text = "echo(rands(0, 1, 5)); echo(rands(0, 1, 2, 42));";
    EXPECT_EQ(run_model(text).echo, run_model(text).echo);
    EXPECT_EQ(run_model("echo(rands(0, 1, 3, 42));").echo,
              "ECHO: [0.796543, 0.183435, 0.779691]\n");
}

}  // namespace
}  // namespace genus
