#include "genus/boolean/groups.h"

#include <algorithm>

#include "genus/base/parallel.h"
#include "genus/boolean/closed_operand.h"
#include "genus/boolean/surviving.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

class InGroups {
public:
    InGroups(const Frame& frame, const MeshBooleanOptions& options, MeshBooleanReport& report,
             Vec3& place)
        : frame_(frame), options_(options), report_(report), place_(place)
    {
    }

    std::optional<Solved> solve(const Soup& soup, const BooleanFormula& formula, Index n_operands)
    {
        find_long_lists(soup, formula, n_operands);
        if (lists_.empty())
            return solve_whole(soup, frame_, formula, n_operands, options_,
                               look_over_zone(soup, frame_, formula, n_operands), report_, place_);
        Start start = look_over(soup, formula, n_operands, kPairsToLookAt * soup.faces.size());
        bool at_once = few_pairs(start, soup);
        if (!at_once &&
            surviving_share(soup, start.candidates.tree, in_lists(n_operands)) > kMuchSurvives) {
            at_once = true;
            if (!start.candidates.complete) start = look_over(soup, formula, n_operands);
        }
        if (!at_once) {
            start = {};
            if (auto solved = solve_lists(soup, formula, n_operands)) return solved;
            // What groups round on the way may be what cannot be written.
            start = look_over(soup, formula, n_operands, kMostPairsAfterGroups);
            if (!start.candidates.complete) return std::nullopt;
        }
        return solve_whole(soup, frame_, formula, n_operands, options_, std::move(start), report_,
                           place_);
    }

private:
    static constexpr std::size_t kGroup = 4;
    // More pairs a face than this are not even listed; with fewer than that all is solved at once.
    static constexpr std::size_t kPairsToLookAt = 16;
    static constexpr std::size_t kPairsToCut = 3;
    static constexpr std::size_t kMostPairsAfterGroups = 50'000'000;
    // If of what crosses more than this share is left in the end, groups save nothing.
    static constexpr double kMuchSurvives = 0.25;

    // The operands of one instruction that can be united first.
    struct LongList {
        std::size_t instruction;
        std::vector<Index> operands;
        std::vector<BooleanFormula::Term> others;
    };

    void find_long_lists(const Soup& soup, const BooleanFormula& formula, Index n_operands)
    {
        std::vector<char> present(n_operands, 0);
        for (const Index i : soup.operand) present[i] = 1;
        std::vector<Index> uses(n_operands, 0);
        for (const auto& instruction : formula.instructions)
            for (const auto& term : instruction.terms)
                if (term.is_operand) ++uses[term.index];
        for (std::size_t i = 0; i < formula.instructions.size(); ++i) {
            const auto& instruction = formula.instructions[i];
            LongList list{i, {}, {}};
            for (const auto& term : instruction.terms) {
                if (term.is_operand && uses[term.index] == 1 && present[term.index] &&
                    term.negated == instruction.is_intersection)
                    list.operands.push_back(term.index);
                else
                    list.others.push_back(term);
            }
            if (static_cast<Index>(list.operands.size()) > options_.largest_union)
                lists_.push_back(std::move(list));
        }
    }

    std::vector<char> in_lists(Index n_operands) const
    {
        std::vector<char> listed(n_operands, 0);
        for (const LongList& list : lists_)
            for (const Index i : list.operands) listed[i] = 1;
        return listed;
    }

    static bool few_pairs(const Start& start, const Soup& soup)
    {
        if (!start.candidates.complete) return false;
        const auto& pairs = start.candidates.pairs;
        const auto is_left = [&](const auto& pair) {
            return soup.operand[pair.first] != soup.operand[pair.second] &&
                   (start.buried.empty() ||
                    (!start.buried[pair.first] && !start.buried[pair.second]));
        };
        return static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), is_left)) <=
               kPairsToCut * soup.faces.size();
    }

    std::optional<Solved> solve_lists(const Soup& soup, BooleanFormula formula, Index n_operands)
    {
        split_by_operand(soup, n_operands);
        for (auto& [instruction, list, others] : lists_) {
            if (!unite(list)) return std::nullopt;
            auto& terms = formula.instructions[instruction].terms;
            const bool negated = formula.instructions[instruction].is_intersection;
            terms = std::move(others);
            for (const Index i : list) terms.push_back({i, true, negated});
        }
        ++report_.n_steps;
        std::vector<Index> named;
        renumber_operands(formula, named);
        std::optional<Solved> solved = solve_together(named, formula, report_, place_);
        if (solved) solved->saw_all = false;
        return solved;
    }

    std::optional<Solved> solve_together(const std::vector<Index>& numbers,
                                         const BooleanFormula& formula, MeshBooleanReport& report,
                                         Vec3& place) const
    {
        const Soup soup = together(numbers);
        const auto n = static_cast<Index>(numbers.size());
        return solve_whole(soup, frame_, formula, n, options_, look_over(soup, formula, n), report,
                           place);
    }

    void split_by_operand(const Soup& soup, Index n_operands)
    {
        pieces_.resize(n_operands);
        std::vector<Index> point(soup.points.size(), -1);
        std::vector<Index> face(soup.faces.size());
        for (std::size_t f = 0; f < soup.faces.size(); ++f) {
            Soup& piece = pieces_[soup.operand[f]];
            face[f] = static_cast<Index>(piece.faces.size());
            Triangle t = soup.faces[f];
            for (Index& v : t) {
                if (point[v] < 0) {
                    point[v] = static_cast<Index>(piece.points.size());
                    piece.points.push_back(soup.points[v]);
                }
                v = point[v];
            }
            piece.faces.push_back(t);
            piece.given.push_back(soup.given[f]);
        }
        for (std::size_t f = 0; f < soup.faces.size(); ++f)
            for (int i = 0; i < 3; ++i) {
                const Index h = soup.twin[3 * f + i];
                pieces_[soup.operand[f]].twin.push_back(h < 0 ? -1 : 3 * face[h / 3] + h % 3);
            }
        for (Index i = 0; i < n_operands; ++i) pieces_[i].crosses_itself = {soup.crosses_itself[i]};
    }

    // The pieces named, each an operand.
    Soup together(const std::vector<Index>& numbers) const
    {
        Soup soup;
        for (std::size_t n = 0; n < numbers.size(); ++n) {
            const Soup& piece = pieces_[numbers[n]];
            const auto first_point = static_cast<Index>(soup.points.size());
            const auto first_face = static_cast<Index>(soup.faces.size());
            soup.points.insert(soup.points.end(), piece.points.begin(), piece.points.end());
            for (const Triangle& t : piece.faces)
                soup.faces.push_back({t[0] + first_point, t[1] + first_point, t[2] + first_point});
            for (const Index h : piece.twin) soup.twin.push_back(h < 0 ? -1 : h + 3 * first_face);
            soup.given.insert(soup.given.end(), piece.given.begin(), piece.given.end());
            soup.operand.resize(soup.faces.size(), static_cast<Index>(n));
            soup.crosses_itself.push_back(piece.crosses_itself[0]);
        }
        return soup;
    }

    // Replaces the pieces of the list by few that are unions of them.
    bool unite(std::vector<Index>& list)
    {
        sort_in_space(list);
        while (list.size() > kGroup) {
            std::vector<std::vector<Index>> groups;
            for (std::size_t i = 0; i < list.size(); i += kGroup)
                groups.emplace_back(
                    list.begin() + static_cast<std::ptrdiff_t>(i),
                    list.begin() + static_cast<std::ptrdiff_t>(std::min(list.size(), i + kGroup)));
            if (!unite_each(groups)) return false;
            list.clear();
            for (std::size_t g = 0; g < groups.size(); ++g)
                list.push_back(static_cast<Index>(pieces_.size() - groups.size() + g));
        }
        return true;
    }

    void sort_in_space(std::vector<Index>& list) const
    {
        std::vector<FloatBox> boxes;
        for (const Index i : list) {
            FloatBox box;
            for (const Vec3& p : pieces_[i].points) box.add(box_of(p, p, p));
            boxes.push_back(box);
        }
        std::vector<Index> sorted;
        const BoxTree tree(std::move(boxes), {});
        for (const Index i : tree.order()) sorted.push_back(list[i]);
        list = std::move(sorted);
    }

    bool unite_each(const std::vector<std::vector<Index>>& groups)
    {
        std::vector<std::optional<Solved>> made(groups.size());
        std::vector<MeshBooleanReport> reports(groups.size());
        std::vector<Vec3> places(groups.size());
        parallel_for(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) {
                const auto n = static_cast<Index>(groups[g].size());
                made[g] =
                    solve_together(groups[g], BooleanFormula::union_of(n), reports[g], places[g]);
            }
        });
        for (std::size_t g = 0; g < groups.size(); ++g) {
            add(reports[g]);
            if (!made[g]) {
                place_ = places[g];
                return false;
            }
            for (const Index i : groups[g]) pieces_[i] = {};
            pieces_.push_back(as_piece(std::move(*made[g])));
        }
        return true;
    }

    static Soup as_piece(Solved solved)
    {
        Soup piece;
        piece.points = std::move(solved.points);
        piece.faces = std::move(solved.faces);
        piece.given = std::move(solved.given);
        find_twins(piece.points.size(), piece.faces, piece.twin);
        // Corners at one place have to be found again: in a plane they are one.
        piece.crosses_itself = {static_cast<char>(solved.parts_touch)};
        return piece;
    }

    void add(const MeshBooleanReport& r)
    {
        report_.n_candidate_pairs += r.n_candidate_pairs;
        report_.n_contacts += r.n_contacts;
        report_.n_passive_faces += r.n_passive_faces;
        report_.n_left_alone += r.n_left_alone;
        report_.n_buried_faces += r.n_buried_faces;
        report_.n_cells += r.n_cells;
        report_.n_new_points += r.n_new_points;
        report_.n_mended += r.n_mended;
        ++report_.n_steps;
    }

    void renumber_operands(BooleanFormula& formula, std::vector<Index>& named) const
    {
        std::vector<Index> number(pieces_.size(), -1);
        for (auto& instruction : formula.instructions)
            for (auto& term : instruction.terms) {
                if (!term.is_operand) continue;
                Index& known = number[term.index];
                if (known < 0) {
                    known = static_cast<Index>(named.size());
                    named.push_back(term.index);
                }
                term.index = known;
            }
    }

    const Frame& frame_;
    const MeshBooleanOptions& options_;
    MeshBooleanReport& report_;
    Vec3& place_;
    std::vector<LongList> lists_;
    std::vector<Soup> pieces_;  // the operands, then unions of them
};

}  // namespace

std::optional<Solved> solve_in_groups(const Soup& soup, const Frame& frame,
                                      const BooleanFormula& formula, std::int32_t n_operands,
                                      const MeshBooleanOptions& options, MeshBooleanReport& report,
                                      Vec3& place)
{
    return InGroups(frame, options, report, place).solve(soup, formula, n_operands);
}

}  // namespace genus::exact
