// Random boolean formulas by the hundred thousand: see random_formulas.h.
//
//   boolean_formulas [rounds = 100000] [first seed = 0] [every = 10]
//
// Every `every`-th seed is solved on 2 and 8 threads as well, and a crowd of operands with it.
// Prints seeds of what is wrong and of what was refused with the reason, then the counts by reason.
// Exit status 1 if anything is wrong.

#include <cstdio>
#include <cstdlib>
#include <map>

#include "stress/random_formulas.h"

namespace {

// The reason without the place.
std::string class_of(const std::string& text)
{
    std::string kind;
    for (const char c : text.substr(0, text.find(" near "))) kind += c >= '0' && c <= '9' ? '#' : c;
    return kind;
}

}  // namespace

int main(int argc, char** argv)
{
    const auto argument = [&](int i, int usual) {
        return static_cast<std::uint32_t>(argc > i ? std::atoi(argv[i]) : usual);
    };
    const std::uint32_t rounds = argument(1, 100000);
    const std::uint32_t first = argument(2, 0);
    const std::uint32_t every = std::max(1u, argument(3, 10));
    genus::set_thread_count(1);
    std::map<std::string, int> refused;
    int n_crowds = 0;
    int n_refused = 0;
    int n_wrong = 0;
    int n_mended = 0;
    const auto tally = [&](const char* what, std::uint32_t seed,
                           const genus::random_formulas::Outcome& outcome) {
        n_mended += outcome.n_mended > 0;
        if (!outcome.wrong.empty()) {
            ++n_wrong;
            std::printf("%s %u wrong: %s\n", what, seed, outcome.wrong.c_str());
        }
        if (!outcome.refused.empty()) {
            ++n_refused;
            ++refused[class_of(outcome.refused)];
            std::printf("%s %u refused: %s\n", what, seed, outcome.refused.c_str());
        }
        std::fflush(stdout);
    };
    for (std::uint32_t seed = first; seed < first + rounds; ++seed) {
        tally("seed", seed, genus::random_formulas::try_formula(seed, seed % every == 0));
        if (seed % every != 0) continue;
        ++n_crowds;
        tally("crowd", seed, genus::random_formulas::try_crowd(seed, seed % (10 * every) == 0));
    }
    std::printf(
        "%u formulas, 4 results each, and %d crowds: %d wrong, %d refused, %d mended on the "
        "way\n",
        rounds, n_crowds, n_wrong, n_refused, n_mended);
    for (const auto& [kind, count] : refused) std::printf("%8d  %s\n", count, kind.c_str());
    return n_wrong == 0 ? 0 : 1;
}
