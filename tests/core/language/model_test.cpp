#include <gtest/gtest.h>

#include "genus/language/model.h"

namespace genus {
namespace {

TEST(Model, RunsOneLine)
{
    ModelOptions options;
    options.solid = false;
    const TextModel model = read_model_text("echo(1 + 2); cube(3);", "one.scad", options);
    EXPECT_EQ(echo_text(model.messages), "ECHO: 3\n");
    EXPECT_EQ(to_csg(model.tree), "cube(size = [3, 3, 3], center = false);\n\n");
}

}  // namespace
}  // namespace genus
