#include "genus/io/patch_file.h"

#include <gtest/gtest.h>

#include <random>

#include "genus/base/error.h"
#include "genus/patch/patch_model.h"

namespace genus {
namespace {

const std::string kGood =
    "2\n1 1\n0 0 0\n0 1 0\n1 0 0\n1 1 1e0\n# a triangle\n1\n0 0 0 1\n0 1 0 2\n1 0 0 0.5\n";

TEST(PatchFile, ReadsBothKinds)
{
    const auto patches = parse_patches(kGood, "good");
    ASSERT_EQ(patches.size(), 2u);
    EXPECT_EQ(std::get<TensorPatch>(patches[0]).point(1, 1), (Vec3{{1, 1, 1}}));
    EXPECT_EQ(std::get<BezierTriangle>(patches[1]).weights(), (std::vector<double>{1, 2, 0.5}));
}

TEST(PatchFile, NamesTheLineOfEveryFault)
{
    struct Fault {
        std::string from, to;
        int line;
    };
    for (const Fault& f : std::initializer_list<Fault>{{"2\n1 1", "3\n1 1", 12},
                                                       {"2\n1 1", "x\n1 1", 1},
                                                       {"2\n1 1", "-2\n1 1", 1},
                                                       {"1 1\n", "1 1 1\n", 2},
                                                       {"1 1\n", "1 513\n", 2},
                                                       {"1 1\n", "1.5 1\n", 2},
                                                       {"0 1 0\n", "0 1\n", 4},
                                                       {"0 1 0\n", "0 1 nan\n", 4},
                                                       {"0 1 0\n", "0 1 0 1\n", 4},
                                                       {"0 1 0\n", "0 1 0 1 1\n", 4},
                                                       {"0 1 0 2", "0 1 0 -2", 10},
                                                       {"0.5\n", "0.5\n7\n", 12}}) {
        std::string text = kGood;
        text.replace(text.find(f.from), f.from.size(), f.to);
        try {
            parse_patches(text, "bad");
            FAIL() << text;
        } catch (const FileError& error) {
            ASSERT_TRUE(error.place().line) << error.what();
            EXPECT_EQ(*error.place().line, f.line) << error.what();
        }
    }
    // A number of points that no file of this size holds.
    EXPECT_THROW(parse_patches("1\n512 512\n0 0 0\n", "short"), FileError);
    EXPECT_THROW(parse_patches("100000000\n", "short"), FileError);
}

TEST(PatchFile, SurvivesRandomDamage)
{
    std::mt19937_64 random(301);
    int read = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        std::string text = kGood;
        for (int k = 0; k < 3; ++k)
            text[random() % text.size()] = "0123456789 .-#e\nx"[random() % 17];
        try {
            parse_patches(text, "damaged");
            ++read;
        } catch (const FileError& error) {
            EXPECT_TRUE(error.place().line);
        }
    }
    EXPECT_GT(read, 0);
}

TEST(PatchFile, TheTeapotIsClosed)
{
    const auto patches = read_patches(std::string(GENUS_MODELS_DIR) + "/patches/teapot.bpt");
    const PatchModel model(patches);
    EXPECT_EQ(patches.size(), 42u);
    EXPECT_TRUE(model.is_closed());
    EXPECT_TRUE(model.is_oriented());
}

}  // namespace
}  // namespace genus
