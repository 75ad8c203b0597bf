// What OpenSCAD 2021.01 writes for a program is what we write.
#include <gtest/gtest.h>

#include "core/language/run_model.h"

namespace genus {
namespace {

struct Pinned {
    const char* program;
    const char* echo;
};

const Pinned kPinned[] = {
#include "core/language/pinned_cases.inc"
};

TEST(Reference, ShortProgramsSayTheSame)
{
    for (const Pinned& pinned : kPinned) {
        SCOPED_TRACE(pinned.program);
        const Said said = run_model(std::string(pinned.program) + "\n");
        EXPECT_EQ(said.error, "");
        EXPECT_EQ(said.echo, pinned.echo);
    }
}

class Programs : public testing::TestWithParam<const char*> {};

TEST_P(Programs, SayAndBuildTheSame)
{
    const auto file = [&](const char* extension) {
        return programs_folder() / (std::string(GetParam()) + extension);
    };
    const Said said = run_model(read_text(file(".scad")), {},
                                (programs_folder() / GetParam()).string() + ".scad");
    EXPECT_EQ(said.error, "");
    std::string echo = read_text(file(".echo"));
    if (!echo.empty() && echo.back() != '\n') echo += '\n';
    EXPECT_EQ(said.echo, echo);
    EXPECT_EQ(said.csg, read_text(file(".csg")));
}

INSTANTIATE_TEST_SUITE_P(Reference, Programs, testing::Values("lists", "assembly", "shapes"));

}  // namespace
}  // namespace genus
