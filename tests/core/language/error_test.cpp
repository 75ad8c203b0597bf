// Mistakes end in one ModelError at the right place, and nothing a text can ask for ends worse.
#include <gtest/gtest.h>

#include "core/language/run_model.h"
#include "genus/base/progress.h"

namespace genus {
namespace {

struct Mistake {
    const char* program;
    int line, column;
    const char* problem;  // how it starts
};

TEST(Errors, HaveTheirPlace)
{
    const Mistake mistakes[] = {
        {"cube(1);\nsphere(2\ncube(3);", 3, 1,
         "syntax error: unexpected 'cube', expected ',' or ')'"},
        {"x = ;", 1, 5, "syntax error: unexpected ';', expected an expression"},
        {"module m( { }", 1, 11, "syntax error"},
        {"union() {\n cube(1);\n", 3, 1, "syntax error: unexpected end of file, expected '}'"},
        {"x = 1\n  y = 2;", 2, 3, "syntax error: unexpected 'y', expected ';'"},
        {"x = [1, 2;", 1, 10, "syntax error: unexpected ';', expected ',' or ']'"},
        {"a = 1 @ 2;", 1, 7, "unexpected character '@'"},
        {"a = \"open", 1, 5, "string is not closed"},
        {"a = 1;\n /* open", 2, 2, "comment is not closed"},
        {"x = 1;\n  foo(3);", 2, 3, "unknown module 'foo'"},
        {"translate([1, 0, 0]) foo();", 1, 22, "unknown module 'foo'"},
        {"function f(x) = 1 + f(x + 1);\necho(f(1));", 1, 21, "recursion without an end in 'f'"},
        {"function f(x) = f(x + 1);\ny = f(1);", 1, 17, "recursion: more than 1000000 calls"},
        {"module m() { m(); }\nm();", 1, 14, "recursion: more than 5000 modules"},
        {"\n include <nope.scad>\n", 2, 2, "file 'nope.scad' not found"},
        {"use <nope.scad>\n", 1, 1, "file 'nope.scad' not found"},
        {"include <nope.scad\n", 1, 1, "the file name after '<' is not closed"},
        {"cube(1); import(\"nope.stl\");", 1, 10, "file 'nope.stl' not found"},
        {"surface(\"nope.dat\");", 1, 1, "file 'nope.dat' not found"},
        {"assert(1 > 2, \"no\");", 1, 1, "Assertion '(1 > 2)' failed: \"no\""},
        {"x = assert(false) 1;", 1, 5, "Assertion 'false' failed"},
        {"x = [for (i = 0; true; i = i + 1) i];", 1, 6, "for loop counter exceeded 1000000"},
    };
    for (const Mistake& m : mistakes) {
        SCOPED_TRACE(m.program);
        const Said said = run_model(m.program);
        EXPECT_EQ(said.line, m.line);
        EXPECT_EQ(said.column, m.column);
        EXPECT_EQ(said.error.substr(0, std::string(m.problem).size()), m.problem);
        EXPECT_EQ(said.error.find('\n'), std::string::npos);
    }
}

TEST(Errors, NameTheFileTheyAreIn)
{
    const ScratchFolder folder;
    folder.write("sub/broken.scad", "x = 1;\n\nmodule m() { y = ; }\n");
    const std::string model = folder.write("model.scad", "include <sub/broken.scad>\n");
    try {
        read_model(model);
        FAIL() << "a syntax error must throw";
    } catch (const ModelError& e) {
        EXPECT_EQ(e.file(), folder.file("sub/broken.scad"));
        EXPECT_EQ(e.line(), 3);
        EXPECT_EQ(e.column(), 18);
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
    EXPECT_THROW(read_model(folder.file("absent.scad")), FileError);
}

TEST(Errors, MessagesBeforeThemAreKept)
{
    const Said said = run_model("echo(\"before\"); assert(false); echo(\"after\");");
    EXPECT_EQ(said.echo, "ECHO: \"before\"\n");
    EXPECT_EQ(said.error, "Assertion 'false' failed");
}

TEST(Errors, IncludesThatTurnInACircle)
{
    const ScratchFolder folder;
    folder.write("a.scad", "include <b.scad>\n");
    folder.write("b.scad", "include <a.scad>\n");
    EXPECT_THROW(read_model(folder.file("a.scad")), ModelError);
    // Files that use each other are fine.
    folder.write("c.scad",
                 "use <d.scad>\nfunction one() = 1; function three() = two() + 1;\n"
                 "echo(three());");
    folder.write("d.scad", "use <c.scad>\nfunction two() = one() + 1;\n");
    EXPECT_EQ(echo_text(read_model(folder.file("c.scad")).messages), "ECHO: 3\n");
}

std::string repeated(const std::string& text, int n)
{
    std::string out;
    for (int i = 0; i < n; ++i) out += text;
    return out;
}

TEST(Errors, DeepNestingIsNoCrash)
{
    const int n = 20'000, more = 400'000;
    const std::string programs[] = {
        "x = " + repeated("(", more) + "1" + repeated(")", more) + ";",
        "x = " + repeated("(", n) + "1" + repeated(")", n) + ";",
        "x = " + repeated("[", n) + repeated("]", n) + "; echo(len(str(x)), x == x, -x == x);",
        "x = " + repeated("-", n) + "1;",
        "x = 1" + repeated("+1", n) + "; echo(x);",
        "x = " + repeated("1?2:", n) + "3;",
        "x = " + repeated("let(a=1) ", n) + "1;",
        "x = [" + repeated("for(i=[1]) ", n) + "1];",
        repeated("union() {", n) + repeated("}", n),
        repeated("translate([1,0,0]) ", n) + "cube(1);",
        repeated("module m() {", n) + repeated("}", n),
        repeated("{", n) + repeated("}", n),
        repeated("!", n) + "cube(1);",
        "x = " + repeated("function(a) ", n) + "1; echo(x);",
        "x = a" + repeated("[0]", n) + ";",
        "x = f" + repeated("(1)", n) + ";",
    };
    for (const std::string& program : programs) {
        SCOPED_TRACE(program.substr(0, 30));
        const Said said = run_model(program);
        EXPECT_TRUE(said.error.empty() || said.error.find("nested too deeply") != said.error.npos ||
                    said.error.find("recursion") != said.error.npos)
            << said.error;
    }
}

TEST(Errors, DeepValuesAreNoCrash)
{
    // Lists in lists, functions holding functions: made without recursion, a million deep.
    const Said lists = run_model(
        "function deep(a, n) = n == 0 ? a : deep([a], n - 1);\n"
        "x = deep(1, 900000); y = deep(1, 900000); echo(len(x)); echo(x == y, len(str(x)) > 0);");
    EXPECT_TRUE(lists.error.empty() || lists.error.find("recursion") != lists.error.npos);
    const Said points = run_model(
        "function deep(a, n) = n == 0 ? a : deep([a], n - 1);"
        "polyhedron(points = deep(1, 900000), faces = []);");
    EXPECT_LT(points.csg.size(), 1000u);
    const Said functions = run_model(
        "function wrap(f, n) = n == 0 ? f : wrap(function(x) f(x), n - 1);\n"
        "g = wrap(function(x) x, 900000); echo(is_function(g)); echo(g(1));");
    EXPECT_NE(functions.echo.find("ECHO: true"), std::string::npos);
}

TEST(Errors, MemoryIsBounded)
{
    ModelOptions options;
    options.memory = 20'000'000;
    for (const char* program :
         {"function f(a) = f(concat(a, a)); x = f([1]);",
          "function f(a) = f(str(a, a)); x = f(\"ab\");",
          "x = [for (i = [0:1000]) rands(0, 1, 10000)];", "x = rands(0, 1, 1e12);",
          "function f(a) = f([a, a, [for (i = [0:999]) i]]); x = f(0);",
          "x = [for (i = [0:999], j = [0:999], k = [0:99]) i];"}) {
        SCOPED_TRACE(program);
        EXPECT_EQ(run_model(program, options).error, "the model needs too much memory");
    }
}

TEST(Errors, EndlessRecursionEndsSoon)
{
    const double start = seconds_now();
    run_model("function f(x) = 1 + f(x + 1); y = f(1);");
    run_model("function f(x) = [for (i = [0:1]) f(x)]; y = f(1);");
    run_model("module m() { translate([1, 0, 0]) m(); } m();");
    EXPECT_LT(seconds_now() - start, 20.0);  // about 1 on an idle machine, more with sanitizers
}

TEST(Errors, DeepRecursionIsFine)
{
    EXPECT_EQ(run_model("function f(n) = n == 0 ? 0 : 1 + f(n - 1); echo(f(8000));").echo,
              "ECHO: 8000\n");
    EXPECT_EQ(run_model("function f(n) = n == 0 ? 0 : f(n - 1); echo(f(900000));").echo,
              "ECHO: 0\n");
    EXPECT_EQ(run_model("module m(n) { if (n > 0) m(n - 1); else echo(\"end\"); } m(2000);").echo,
              "ECHO: \"end\"\n");
}

TEST(Errors, CancellingStopsTheRun)
{
    int reports = 0;
    Progress progress([&](const std::string&, double) {
        if (++reports == 2) throw Cancelled();
    });
    const ProgressScope scope(progress);
    const double start = seconds_now();
    EXPECT_THROW(run_model(""
                           "function f(n) = [for (i = [0:999999]) [for (j = [0:999999]) 1]];"
                           "for (i = [0:9999]) { a = len([for (k = [0:99999]) if (k < 0) k]); }"),
                 Error);
    EXPECT_LT(seconds_now() - start, 5.0);
    EXPECT_THROW(run_model("y = [for (i = [0:99999]) [for (k = [0:99999]) if (k < 0) k]];"),
                 Cancelled);
}

TEST(Errors, WarningsAreBounded)
{
    const Said said = run_model("x = [for (i = [0:300000]) echo(i) i];");
    EXPECT_NE(said.echo.find("further messages are left out"), std::string::npos);
    EXPECT_LT(said.echo.size(), 4'000'000u);
}

}  // namespace
}  // namespace genus
