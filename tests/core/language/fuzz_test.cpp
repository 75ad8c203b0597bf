// Programs cut, spliced and scrambled: a result or a named error every time.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "core/language/run_model.h"

namespace genus {
namespace {

int rounds(int usual)
{
    return std::getenv("GENUS_LONG") ? usual * 100 : usual;
}

std::vector<std::string> seeds()
{
    std::vector<std::string> out;
    for (const char* name : {"lists.scad", "assembly.scad", "shapes.scad", "parts.scad"})
        out.push_back(read_text(programs_folder() / name));
    return out;
}

// Pieces of the language to put anywhere.
const char* const kPieces[] = {"(",
                               ")",
                               "[",
                               "]",
                               "{",
                               "}",
                               ";",
                               ",",
                               "=",
                               "==",
                               "?",
                               ":",
                               ".",
                               "^",
                               "%",
                               "!",
                               "#",
                               "*",
                               "-",
                               "\"",
                               "\\",
                               "//",
                               "/*",
                               "*/",
                               "$",
                               "$fn",
                               "$children",
                               "for",
                               "if",
                               "else",
                               "let",
                               "each",
                               "function",
                               "module",
                               "assert",
                               "echo",
                               "true",
                               "undef",
                               "children()",
                               "1e309",
                               "0x",
                               "-1",
                               "[for(i=[0:3])i]",
                               "[for(i=0;i<3;i=i+1)i]",
                               "function(x)x",
                               "f(",
                               "x",
                               "[0:1:9]",
                               "\xff",
                               "\0x",
                               "include <a>",
                               "use <b>",
                               "let(a=a)",
                               "each each",
                               "rands(0,1,3)",
                               "1/0",
                               "0/0"};

std::string mutate(std::string text, std::mt19937& random)
{
    const auto below = [&](std::size_t n) { return n ? random() % n : 0; };
    const std::size_t changes = 1 + below(6);
    for (std::size_t i = 0; i < changes; ++i) {
        const std::size_t at = below(text.size() + 1);
        switch (below(6)) {
            case 0:
                text.resize(at);
                break;
            case 1:
                text.erase(at, below(20));
                break;
            case 2:
                text.insert(at, kPieces[below(std::size(kPieces))]);
                break;
            case 3:
                text.insert(at, text.substr(below(text.size() + 1), below(60)));
                break;
            case 4:
                if (at < text.size()) text[at] = static_cast<char>(below(256));
                break;
            default:
                if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        }
    }
    return text;
}

TEST(Fuzz, MutatedProgramsEndWell)
{
    const std::vector<std::string> texts = seeds();
    int good = 0, bad = 0;
    for (int round = 0; round < rounds(400); ++round) {
        const unsigned seed = 7'000'000u + static_cast<unsigned>(round);
        std::mt19937 random(seed);
        std::string text = texts[random() % texts.size()];
        // Short pieces keep the runs short and reach further than whole programs.
        const std::size_t from = text.find('\n', random() % text.size());
        if (from != text.npos && random() % 4) text = text.substr(from, 600);
        text = mutate(text, random);
        SCOPED_TRACE("seed " + std::to_string(seed));
        ModelOptions options;
        options.memory = 50'000'000;
        try {
            read_model_text(text, (programs_folder() / "mutant.scad").string(), options);
            ++good;
        } catch (const ModelError& e) {
            ++bad;
            EXPECT_GE(e.line(), 1);
            EXPECT_GE(e.column(), 1);
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
        } catch (const std::exception& e) {
            FAIL() << e.what() << " of\n" << text;
        }
    }
    EXPECT_GT(good, 0);
    EXPECT_GT(bad, 0);
}

TEST(Fuzz, RandomExpressionsEndWell)
{
    for (int round = 0; round < rounds(1500); ++round) {
        const unsigned seed = 9'000'000u + static_cast<unsigned>(round);
        std::mt19937 random(seed);
        std::string text = "x = 3; function f(x, y) = x; echo(";
        const std::size_t n = random() % 12;
        for (std::size_t i = 0; i < n; ++i)
            text += std::string(" ") + kPieces[random() % std::size(kPieces)];
        text += "); cube(1);";
        SCOPED_TRACE("seed " + std::to_string(seed) + ": " + text);
        ModelOptions options;
        options.memory = 50'000'000;
        try {
            read_model_text(text, "fuzz.scad", options);
        } catch (const ModelError& e) {
            EXPECT_GE(e.line(), 1);
        } catch (const std::exception& e) {
            FAIL() << e.what();
        }
    }
}

}  // namespace
}  // namespace genus
