// Random quadric trees by the ten thousand: see quadric_trees.h.
//
//   quadric_trees [rounds = 20000] [first seed = 0] [every = 0] [tolerance = 0.01]
//
// Every `every`-th seed is meshed over a grid as well, plain and extended marching cubes in turn.
// The tolerance is in diagonals of the bounding box. Prints the seeds of what is wrong, of what was
// refused with the reason and of those whose two meshes differ in V - E + F; then the counts. Exit
// status 1 if anything is wrong.

#include "stress/quadric_trees.h"

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>

#include "genus/base/parallel.h"

namespace {

// The reason without numbers.
std::string class_of(const std::string& text)
{
    std::string kind;
    for (const char c : text.substr(0, text.find(", within"))) {
        const bool number = (c >= '0' && c <= '9') || c == '.' || c == '-';
        if (!number)
            kind += c;
        else if (kind.empty() || kind.back() != '#')
            kind += '#';
    }
    return kind;
}

struct Totals {
    std::uint32_t wrong = 0, refused = 0, empty = 0, on_surfaces = 0, on_both = 0;
    std::uint32_t touching = 0, grids = 0, proven = 0, apart = 0, other_form = 0,
                  other_form_touching = 0, other_form_of_grid = 0;
    std::vector<double> ratios;
    std::map<std::string, int> reasons;
    std::map<std::string, double> seconds;

    void add(std::uint32_t seed, const genus::quadric_trees::Outcome& outcome)
    {
        if (!outcome.wrong.empty()) {
            ++wrong;
            std::printf("seed %u wrong: %s (measured %g, bound %g, tolerance %g)\n", seed,
                        outcome.wrong.c_str(), outcome.measured, outcome.bound, outcome.tolerance);
        }
        if (!outcome.refused.empty()) {
            ++refused;
            ++reasons[class_of(outcome.refused)];
            std::printf("seed %u refused: %s\n", seed, outcome.refused.c_str());
        } else if (outcome.empty) {
            ++empty;
        } else {
            on_surfaces += outcome.off.one <= 1e-12;
            on_both += outcome.off.edge <= 1e-12;
            if (outcome.measured > 0.0) ratios.push_back(outcome.bound / outcome.measured);
        }
        for (const auto& [stage, time] : outcome.seconds) seconds[stage] += time;
        touching += outcome.touches;
        if (outcome.grid) compare(seed, outcome, *outcome.grid);
    }

    void compare(std::uint32_t seed, const genus::quadric_trees::Outcome& outcome,
                 const genus::quadric_trees::OverGrid& grid)
    {
        ++grids;
        proven += grid.certified;
        if (grid.apart > outcome.bound + grid.bound) {
            ++apart;
            std::printf("seed %u: the roads are %g apart, their bounds %g and, %s, %g\n", seed,
                        grid.apart, outcome.bound, grid.certified ? "proven" : "estimated",
                        grid.bound);
        }
        if (grid.euler == outcome.euler) return;
        const bool stays = grid.euler_finer && *grid.euler_finer == outcome.euler;
        ++(outcome.touches ? other_form_touching : stays ? other_form_of_grid : other_form);
        std::printf("seed %u: V - E + F is %lld from cells, %lld over a grid%s\n", seed,
                    static_cast<long long>(outcome.euler), static_cast<long long>(grid.euler),
                    outcome.touches ? "; it touches itself" : "");
        if (grid.euler_finer)
            std::printf("    and %lld from cells at an eighth of the tolerance\n",
                        static_cast<long long>(*grid.euler_finer));
    }

    void print(std::uint32_t rounds)
    {
        std::sort(ratios.begin(), ratios.end());
        const auto quantile = [&](double q) {
            const double last = static_cast<double>(ratios.size()) - 1.0;
            return ratios.empty() ? 0.0 : ratios[static_cast<std::size_t>(q * last)];
        };
        std::printf("%u trees: %u wrong, %u refused, %u empty\n", rounds, wrong, refused, empty);
        std::printf("bound / measured: least %.3f, median %.3f, nine in ten below %.3f\n",
                    quantile(0.0), quantile(0.5), quantile(0.9));
        std::printf("all vertices on a surface to 1e-12: %u; those at sharp edges on two: %u\n",
                    on_surfaces, on_both);
        std::printf("touch themselves: %u\n", touching);
        std::printf("over grids too: %u, %u of them proven; farther apart than both bounds %u\n",
                    grids, proven, apart);
        std::printf(
            "of another form there: %u that touch themselves, %u whose form from cells "
            "stays at an eighth of the tolerance, %u others\n",
            other_form_touching, other_form_of_grid, other_form);
        std::printf("seconds:");
        for (const auto& [stage, time] : seconds) std::printf(" %s %.1f", stage.c_str(), time);
        std::printf("\n");
        for (const auto& [kind, count] : reasons) std::printf("%8d  %s\n", count, kind.c_str());
    }
};

}  // namespace

int main(int argc, char** argv)
{
    const auto argument = [&](int i, int usual) {
        return static_cast<std::uint32_t>(argc > i ? std::atoi(argv[i]) : usual);
    };
    const std::uint32_t rounds = argument(1, 20000), first = argument(2, 0), every = argument(3, 0);
    genus::quadric_trees::Request request;
    if (argc > 4) request.tolerance = std::atof(argv[4]);
    genus::set_thread_count(1);
    Totals totals;
    for (std::uint32_t seed = first; seed < first + rounds; ++seed) {
        request.grid.reset();
        if (every > 0 && seed % every == 0)
            request.grid = seed / every % 2 == 0 ? genus::MeshMethod::Emc : genus::MeshMethod::Mc;
        const double before = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
        totals.add(seed, genus::quadric_trees::try_tree(seed, request));
        const double seconds = static_cast<double>(std::clock()) / CLOCKS_PER_SEC - before;
        if (seconds > 20.0) std::printf("seed %u took %.0f CPU seconds\n", seed, seconds);
        std::fflush(stdout);
    }
    totals.print(rounds);
    return totals.wrong == 0 ? 0 : 1;
}
