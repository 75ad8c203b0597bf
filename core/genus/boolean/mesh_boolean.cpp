#include "genus/boolean/mesh_boolean.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "genus/base/box.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/arrangement.h"
#include "genus/boolean/assemble.h"
#include "genus/boolean/buried.h"
#include "genus/boolean/close_coordinates.h"
#include "genus/boolean/closed_operand.h"
#include "genus/boolean/contact.h"
#include "genus/boolean/winding.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus {

namespace {

using exact::ClosedOperand;
using exact::Soup;
using Index = std::int32_t;

constexpr std::size_t kAnyNumber = std::numeric_limits<std::size_t>::max();
constexpr int kMendRounds = 10;
constexpr int kCoarserBits = 4;
constexpr double kCloseSteps = 8.0;  // within which coordinates are meant to be equal
constexpr double kCloseUnits = 4.0;  // the same in units in the last place

// An integer grid over a box: x = origin + 2^exponent X with |X| below kGridLimit.
class Frame {
public:
    explicit Frame(const Box3& box)
    {
        const Vec3 half = 0.5 * box.max - 0.5 * box.min;
        const double reach = std::max({half[0], half[1], half[2]});
        int power = 0;
        std::frexp(reach, &power);  // reach < 2^power
        exponent_ = std::max(power - 53, -1074) - 1;
        do {
            ++exponent_;
            place_origin(box.center());
        } while (farthest(box) > exact::kGridLimit);
        for (int k = 0; k < 3; ++k) {
            int digits = 0;
            std::frexp(std::max(std::abs(box.min[k]), std::abs(box.max[k])), &digits);
            unit_[k] = std::ldexp(1.0, std::max(0, digits - 53 - exponent_));
        }
    }

    double step() const { return std::ldexp(1.0, exponent_); }

    /// The nearest grid point; `off` grows to the distance, in steps, where that is larger.
    Vec3 to_grid(const Vec3& p, double& off) const
    {
        Vec3 grid;
        for (int k = 0; k < 3; ++k) {
            // The difference as a sum of two doubles, exactly.
            const double d = p[k] - origin_[k];
            const double o = p[k] - d;
            const double rest = (p[k] - (d + o)) + (o - origin_[k]);
            const double scaled = std::ldexp(d, -exponent_);
            const double tail = std::ldexp(rest, -exponent_);
            double whole = std::nearbyint(scaled);
            double part = (scaled - whole) + tail;
            if (std::abs(part) > 0.5) {
                const double one = std::copysign(1.0, part);
                whole += one;
                part -= one;
            }
            grid[k] = whole + 0.0;  // no negative zero
            off = std::max(off, std::abs(part));
        }
        return grid;
    }
    Vec3 from_grid(const Vec3& grid) const
    {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = origin_[k] + std::ldexp(grid[k], exponent_);
        return p;
    }
    /// The grid point nearest to `p` that is a triple of doubles in model units.
    Vec3 rounded(const Vec3& p) const
    {
        Vec3 whole;
        for (int k = 0; k < 3; ++k) whole[k] = std::nearbyint(p[k]);
        double off = 0.0;
        return to_grid(from_grid(whole), off);
    }
    /// The nearest point of a grid coarser by `bits` than doubles of the largest coordinate are.
    Vec3 coarsened(const Vec3& p, int bits) const
    {
        Vec3 q;
        for (int k = 0; k < 3; ++k) {
            const double unit = std::ldexp(unit_[k], bits);
            q[k] = std::clamp(std::nearbyint(p[k] / unit) * unit, -exact::kGridLimit,
                              exact::kGridLimit);
        }
        return q;
    }
    /// Distances, in steps, within which coordinates are meant to be equal: a few roundings.
    Vec3 close(double most_snap) const
    {
        Vec3 reach;
        for (int k = 0; k < 3; ++k)
            reach[k] = std::max(kCloseSteps,
                                std::min(kCloseUnits * unit_[k], most_snap * exact::kGridLimit));
        return reach;
    }
    /// What `coarsened` may move a coordinate by, as a share of the size of the box.
    double coarseness(int bits) const
    {
        return 0.5 * std::ldexp(std::max({unit_[0], unit_[1], unit_[2]}), bits) / exact::kGridLimit;
    }

private:
    void place_origin(const Vec3& center)
    {
        for (int k = 0; k < 3; ++k)
            origin_[k] = std::ldexp(std::nearbyint(std::ldexp(center[k], -exponent_)), exponent_);
    }
    double farthest(const Box3& box) const
    {
        double far = 0.0;
        double off = 0.0;
        for (const Vec3& p : {to_grid(box.min, off), to_grid(box.max, off)})
            for (int k = 0; k < 3; ++k) far = std::max(far, std::abs(p[k]));
        return far;
    }

    Vec3 origin_;
    Vec3 unit_;  // unit in the last place of the largest coordinates, in steps
    int exponent_;
};

// A solved cluster, on its grid.
struct Solved {
    std::vector<Vec3> points;
    std::vector<Triangle> faces;
    std::vector<Soup::Given> given;
};

bool is_flat(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return exact::dominant_axis(a, b, c) < 0;
}

// Do two faces of a result meet in more than common corners and edges? Corners at one place are
// one corner.
bool collide(const Solved& mesh, Index f, Index g)
{
    exact::Corners a;
    exact::Corners b;
    for (int i = 0; i < 3; ++i) {
        a.at[i] = &mesh.points[mesh.faces[f][i]];
        b.at[i] = &mesh.points[mesh.faces[g][i]];
    }
    exact::number_corners(a, b);
    return !exact::certainly_apart(a, b) && !exact::find_contact(a, b).trivial();
}

// What the rounding of a result did.
struct Rounding {
    std::vector<char> moved;    // by point
    std::vector<Index> turned;  // faces that now turn the other way
};

// Faces of parts that the rounding may have turned inside out: thin ones whose corners moved to the
// other side, so that a quarter of their faces or more turned over, and which meet nothing.
std::vector<Index> find_turned_parts(const Solved& mesh, const Rounding& rounding)
{
    if (rounding.turned.empty()) return {};
    DisjointSets parts(mesh.points.size());
    for (const Triangle& t : mesh.faces) {
        parts.unite(t[0], t[1]);
        parts.unite(t[0], t[2]);
    }
    std::vector<Index> balance(mesh.points.size(), 0);  // by part
    for (const Triangle& t : mesh.faces) --balance[parts.find(t[0])];
    for (const Index f : rounding.turned) balance[parts.find(mesh.faces[f][0])] += 4;
    std::vector<Index> bad;
    for (const Index f : rounding.turned)
        if (balance[parts.find(mesh.faces[f][0])] >= 0) bad.push_back(f);
    return bad;
}

// The faces that, after some corners moved, are flat or meet others.
std::vector<Index> find_collisions(const Solved& mesh, const std::vector<char>& moved)
{
    enum : char { kStill, kSuspect, kFlat };
    std::vector<Index> bad;
    std::vector<Index> suspects;
    std::vector<char> kind(mesh.faces.size(), kStill);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Triangle& t = mesh.faces[f];
        if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) continue;
        const bool flat = is_flat(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
        kind[f] = flat ? kFlat : kSuspect;
        (flat ? bad : suspects).push_back(static_cast<Index>(f));
    }
    if (suspects.empty()) return bad;
    const auto box = [&](Index f) {
        const Triangle& t = mesh.faces[f];
        return exact::box_of(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
    };
    std::vector<exact::FloatBox> boxes;
    for (const Index f : suspects) boxes.push_back(box(f));
    const exact::BoxTree tree(std::move(boxes), {});
    std::vector<std::vector<Index>> found;
    const auto look_at = [&](Index f, Index g, std::vector<Index>& list) {
        if (!collide(mesh, f, g)) return;
        list.push_back(f);
        list.push_back(g);
    };
    const auto take = [&] {
        for (const auto& part : found) bad.insert(bad.end(), part.begin(), part.end());
    };
    tree.visit_pairs([&](std::size_t parts) { found.resize(parts); },
                     [&](Index a, Index b, std::size_t part) {
                         look_at(suspects[a], suspects[b], found[part]);
                     });
    take();
    constexpr std::size_t kGrain = 4096;
    found.assign(mesh.faces.size() / kGrain + 1, {});
    parallel_for(mesh.faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f)
            if (kind[f] == kStill)
                tree.query(box(static_cast<Index>(f)), [&](Index s) {
                    look_at(static_cast<Index>(f), suspects[s], found[begin / kGrain]);
                });
    });
    take();
    std::sort(bad.begin(), bad.end());
    bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
    return bad;
}

// What is known of a soup before anything is cut.
struct Start {
    exact::Candidates candidates;
    std::vector<char> buried;
};

Start look_over(const Soup& soup, const BooleanFormula& formula, Index n_operands,
                std::size_t most_pairs = kAnyNumber)
{
    Start start{exact::find_candidates(soup, most_pairs), {}};
    if (n_operands > 2 && start.candidates.complete)
        start.buried = exact::find_buried(soup, start.candidates, formula, n_operands);
    return start;
}

// Does a face turn against its plane now that corners moved?
bool turned_by(const std::vector<char>& moved, const Solved& mesh, Index f, const Soup& soup,
               const exact::OutFace& from)
{
    const Triangle& t = mesh.faces[f];
    if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) return false;
    const auto sign = [](int axis, const std::vector<Vec3>& points, const Triangle& corners) {
        return exact::normal_sign(axis, points[corners[0]], points[corners[1]], points[corners[2]]);
    };
    const Triangle& plane = soup.faces[from.plane];
    const int axis =
        exact::dominant_axis(soup.points[plane[0]], soup.points[plane[1]], soup.points[plane[2]]);
    const int before = sign(axis, soup.points, plane) * (from.flipped ? -1 : 1);
    return sign(axis, mesh.points, t) == -before;
}

// The surface of a soup by formula, rounded.
Solved solve_once(const Soup& soup, const Frame& frame, const BooleanFormula& formula,
                  Index n_operands, exact::InsideRule rule, bool merge_coplanar, Start start,
                  Rounding& rounding, MeshBooleanReport& report)
{
    report.n_buried_faces += std::count(start.buried.begin(), start.buried.end(), 1);
    exact::Arrangement arrangement =
        exact::arrange(soup, std::move(start.candidates), std::move(start.buried));
    auto found = exact::select(soup, arrangement, formula, n_operands, rule);
    if (!found) {
        arrangement = exact::arrange(soup, exact::find_candidates(soup, kAnyNumber), {});
        found = exact::select(soup, arrangement, formula, n_operands, rule);
    }
    const exact::Selection& selection = *found;
    auto faces = exact::collect_faces(soup, arrangement, selection, merge_coplanar);
    const std::size_t n_exact = arrangement.points.size();
    exact::OutMesh mesh = exact::split_to_manifold(soup, arrangement, faces);

    report.n_candidate_pairs += arrangement.n_candidate_pairs;
    report.n_contacts += arrangement.n_contacts;
    report.n_passive_faces += std::count(arrangement.passive.begin(), arrangement.passive.end(), 1);
    report.n_cells += static_cast<std::int64_t>(arrangement.cells.size());
    report.n_new_points +=
        static_cast<std::int64_t>(arrangement.points.size() - soup.points.size());

    Solved solved;
    solved.faces = std::move(mesh.faces);
    solved.points.resize(mesh.points.size());
    rounding = {};
    rounding.moved.assign(mesh.points.size(), 0);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const exact::PointRef& p = arrangement.points[mesh.points[i]];
        solved.points[i] = p.approx;
        const auto number = static_cast<std::size_t>(mesh.points[i]);
        if (number < soup.points.size()) continue;
        const bool middle = number >= n_exact;
        solved.points[i] = frame.rounded(p.approx);
        rounding.moved[i] = middle || !exact::same_point({solved.points[i], nullptr}, p);
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
        solved.given.push_back(soup.given[faces[f].source]);
        if (turned_by(rounding.moved, solved, static_cast<Index>(f), soup, faces[f]))
            rounding.turned.push_back(static_cast<Index>(f));
    }
    return solved;
}

// A result as an operand: equal points made one, flat faces left out.
Soup as_soup(const Solved& solved)
{
    Soup soup;
    std::map<std::array<double, 3>, Index> numbers;
    std::vector<Index> number(solved.points.size());
    for (std::size_t i = 0; i < number.size(); ++i) {
        const auto [it, is_new] =
            numbers.try_emplace(solved.points[i].c, static_cast<Index>(soup.points.size()));
        if (is_new) soup.points.push_back(solved.points[i]);
        number[i] = it->second;
    }
    std::vector<Triangle> all;
    std::vector<Index> face;
    for (std::size_t f = 0; f < solved.faces.size(); ++f) {
        Triangle t = solved.faces[f];
        for (Index& v : t) v = number[v];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        all.push_back(t);
        face.push_back(static_cast<Index>(f));
    }
    std::vector<Index> twin;
    exact::find_twins(soup.points.size(), all, twin);
    std::vector<Index> place(all.size(), -1);
    for (std::size_t f = 0; f < all.size(); ++f) {
        const Triangle& t = all[f];
        if (is_flat(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]])) continue;
        place[f] = static_cast<Index>(soup.faces.size());
        soup.faces.push_back(t);
        soup.given.push_back(solved.given[face[f]]);
    }
    for (std::size_t f = 0; f < all.size(); ++f)
        if (place[f] >= 0)
            for (int i = 0; i < 3; ++i) {
                const Index h = twin[3 * f + i];
                soup.twin.push_back(h < 0 || place[h / 3] < 0 ? -1 : 3 * place[h / 3] + h % 3);
            }
    soup.operand.assign(soup.faces.size(), 0);
    soup.crosses_itself = {1};
    return soup;
}

std::string place_text(const Vec3& p)
{
    return "(" + to_text(p[0]) + ", " + to_text(p[1]) + ", " + to_text(p[2]) + ")";
}

// Nothing if the rounded result crosses itself and solving it again does not help; `place` then
// is a point where it does.
std::optional<Solved> solve_whole(const Soup& soup, const Frame& frame,
                                  const BooleanFormula& formula, Index n_operands,
                                  const MeshBooleanOptions& options, Start start,
                                  MeshBooleanReport& report, Vec3& place)
{
    Rounding rounding;
    Solved solved = solve_once(soup, frame, formula, n_operands, exact::InsideRule::NonZero,
                               options.merge_coplanar, std::move(start), rounding, report);
    const std::size_t most_faces = 2 * solved.faces.size() + 1000;
    for (int round = 0;; ++round) {
        std::vector<Index> bad = find_collisions(solved, rounding.moved);
        if (bad.empty()) bad = find_turned_parts(solved, rounding);
        if (bad.empty()) return solved;
        place = frame.from_grid(solved.points[solved.faces[bad[0]][0]]);
        if (round == kMendRounds || solved.faces.size() > most_faces) return std::nullopt;
        ++report.n_mended;
        const Soup again = as_soup(solved);
        const BooleanFormula itself = BooleanFormula::union_of(1);
        solved = solve_once(again, frame, itself, 1, exact::InsideRule::Positive,
                            options.merge_coplanar, look_over(again, itself, 1), rounding, report);
    }
}

// Unions of many operands, solved in groups of neighbours: what lies inside a group is gone before
// groups meet, so that the work grows with the surface and not with the square of the overlaps.
// All groups use the grid of their cluster, and what a group gives needs no look at itself again.
class InGroups {
public:
    InGroups(const Frame& frame, const MeshBooleanOptions& options, MeshBooleanReport& report,
             Vec3& place)
        : frame_(frame), options_(options), report_(report), place_(place)
    {
    }

    /// As `solve_whole`; long unions, and long lists of things taken away, are united first.
    std::optional<Solved> solve(const Soup& soup, BooleanFormula formula, Index n_operands)
    {
        find_long_lists(soup, formula, n_operands);
        const std::size_t n_faces = soup.faces.size();
        Start start = look_over(soup, formula, n_operands,
                                lists_.empty() ? kAnyNumber : kPairsToLookAt * n_faces);
        if (lists_.empty() || few_pairs(start, n_faces))
            return solve_whole(soup, frame_, formula, n_operands, options_, std::move(start),
                               report_, place_);
        start = {};
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
        return solve_together(named, formula, report_, place_);
    }

private:
    static constexpr std::size_t kGroup = 4;
    // More pairs a face than this are not even listed; with fewer than that all is solved at once.
    static constexpr std::size_t kPairsToLookAt = 16;
    static constexpr std::size_t kPairsToCut = 3;

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

    static bool few_pairs(const Start& start, std::size_t n_faces)
    {
        if (!start.candidates.complete) return false;
        const auto& pairs = start.candidates.pairs;
        const auto is_left = [&](const auto& pair) {
            return start.buried.empty() ||
                   (!start.buried[pair.first] && !start.buried[pair.second]);
        };
        return static_cast<std::size_t>(std::count_if(pairs.begin(), pairs.end(), is_left)) <=
               kPairsToCut * n_faces;
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
        std::vector<exact::FloatBox> boxes;
        for (const Index i : list) {
            exact::FloatBox box;
            for (const Vec3& p : pieces_[i].points) box.add(exact::box_of(p, p, p));
            boxes.push_back(box);
        }
        std::vector<Index> sorted;
        const exact::BoxTree tree(std::move(boxes), {});
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
        exact::find_twins(piece.points.size(), piece.faces, piece.twin);
        piece.crosses_itself = {0};
        return piece;
    }

    void add(const MeshBooleanReport& r)
    {
        report_.n_candidate_pairs += r.n_candidate_pairs;
        report_.n_contacts += r.n_contacts;
        report_.n_passive_faces += r.n_passive_faces;
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

using Meshes = std::vector<const IndexedMesh*>;

// All of one call: operands made ready, their components and the clusters of these.
class Call {
public:
    Call(const Meshes& operands, const BooleanFormula& formula, const MeshBooleanOptions& options)
        : meshes_(operands), formula_(formula), options_(options)
    {
    }

    MeshBooleanResult run()
    {
        const auto n = static_cast<Index>(meshes_.size());
        ready_.resize(n);
        parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                ready_[i] = exact::close_operand(*meshes_[i], static_cast<Index>(i));
        });
        find_clusters();
        for (Index c = 0; c < n_clusters_; ++c) {
            current_progress().check();
            solve_cluster(c);
        }
        return std::move(result_);
    }

private:
    // With all that a few roundings might have moved into the box.
    static Box3 nearby(const Box3& box)
    {
        double largest = 0.0;
        for (int k = 0; k < 3; ++k)
            largest = std::max({largest, std::abs(box.min[k]), std::abs(box.max[k])});
        return box.inflated(kCloseUnits * std::numeric_limits<double>::epsilon() * largest);
    }

    void find_clusters()
    {
        std::vector<Index> start{0};
        for (const ClosedOperand& operand : ready_)
            start.push_back(start.back() + operand.n_components);
        std::vector<Box3> boxes(start.back());
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i].faces.size(); ++f)
                for (const Index v : ready_[i].faces[f])
                    boxes[start[i] + ready_[i].component[f]].add(meshes_[i]->vertices[v]);
        DisjointSets sets(start.back());
        std::vector<exact::FloatBox> rough;
        for (const Box3& b : boxes)
            rough.push_back(exact::box_of(nearby(b).min, nearby(b).max, nearby(b).min));
        const exact::BoxTree tree(std::move(rough), {});
        std::vector<std::vector<std::pair<Index, Index>>> touching;
        tree.visit_pairs([&](std::size_t parts) { touching.resize(parts); },
                         [&](Index a, Index b, std::size_t part) {
                             if (overlap(nearby(boxes[a]), nearby(boxes[b])))
                                 touching[part].push_back({a, b});
                         });
        for (const auto& part : touching)
            for (const auto& [a, b] : part) sets.unite(a, b);

        std::vector<Index> number(start.back(), -1);
        for (Index c = 0; c < start.back(); ++c) {
            Index& known = number[sets.find(c)];
            if (known < 0) {
                known = n_clusters_++;
                cluster_box_.emplace_back();
            }
            number[c] = known;
            cluster_box_[known].add(boxes[c]);
        }
        cluster_faces_.resize(n_clusters_);
        for (std::size_t i = 0; i < ready_.size(); ++i)
            for (std::size_t f = 0; f < ready_[i].faces.size(); ++f)
                cluster_faces_[number[start[i] + ready_[i].component[f]]].push_back(
                    {static_cast<Index>(i), static_cast<Index>(f)});
        result_.report.n_components = start.back();
        result_.report.n_clusters = n_clusters_;
    }

    void solve_cluster(Index c)
    {
        const Frame frame(cluster_box_[c]);
        Vec3 place;
        for (int bits = 0; bits == 0 || frame.coarseness(bits) <= options_.most_snap;
             bits += kCoarserBits) {
            const double largest_snap = result_.report.largest_snap;
            const Soup soup = make_soup(cluster_faces_[c], frame, bits);
            const std::int64_t n_cells = result_.report.n_cells;
            const auto solved = InGroups(frame, options_, result_.report, place)
                                    .solve(soup, formula_, static_cast<Index>(meshes_.size()));
            if (!solved) continue;
            append(*solved, frame);
            if (n_cells == result_.report.n_cells && bits == 0 && is_one_part(c)) {
                restore(solved->faces.size());
                result_.report.largest_snap = largest_snap;
            }
            cluster_faces_[c] = {};
            return;
        }
        throw Error(
            "mesh_boolean: the result cannot be written in doubles without crossing itself "
            "near " +
            place_text(place));
    }

    bool is_one_part(Index c) const
    {
        const auto part = [&](const std::pair<Index, Index>& at) {
            return std::pair(at.first, ready_[at.first].component[at.second]);
        };
        const auto& faces = cluster_faces_[c];
        return std::all_of(faces.begin(), faces.end(),
                           [&](const auto& at) { return part(at) == part(faces[0]); });
    }

    // Gives the last `n` faces, which nothing touched, the very coordinates of their source.
    void restore(std::size_t n)
    {
        const auto& faces = result_.mesh.faces;
        for (std::size_t f = faces.size() - n; f < faces.size(); ++f) {
            const IndexedMesh& from = *meshes_[result_.operand[f]];
            const Triangle& t = from.faces[result_.source_face[f]];
            const Vec3* p[3];
            for (int i = 0; i < 3; ++i) p[i] = &from.vertices[t[i]];
            // The face may have been turned over, its first corner stayed.
            const auto off = [&](int i, int j) {
                return distance(result_.mesh.vertices[faces[f][i]], *p[j]);
            };
            if (off(1, 1) + off(2, 2) > off(1, 2) + off(2, 1)) std::swap(p[1], p[2]);
            for (int i = 0; i < 3; ++i) result_.mesh.vertices[faces[f][i]] = *p[i];
        }
    }

    Soup make_soup(const std::vector<std::pair<Index, Index>>& faces, const Frame& frame, int bits)
    {
        Soup soup;
        soup.crosses_itself.assign(meshes_.size(), options_.operands_may_cross_themselves);
        if (place_.empty()) {
            place_.resize(meshes_.size());
            vertex_.resize(meshes_.size());
            for (std::size_t i = 0; i < meshes_.size(); ++i) {
                place_[i].assign(ready_[i].faces.size(), -1);
                vertex_[i].assign(meshes_[i]->vertices.size(), -1);
            }
        }
        for (const auto& [i, f] : faces) {
            place_[i][f] = -1;
            for (const Index v : ready_[i].faces[f]) vertex_[i][v] = -1;
        }
        double largest = 0.0;
        std::vector<Index> owner;  // of each point, an operand
        for (const auto& [i, f] : faces)
            for (const Index v : ready_[i].faces[f]) {
                if (vertex_[i][v] >= 0) continue;
                double off = 0.0;
                vertex_[i][v] = static_cast<Index>(soup.points.size());
                Vec3 p = frame.to_grid(meshes_[i]->vertices[v], off);
                if (bits > 0) {
                    const Vec3 q = frame.coarsened(p, bits);
                    for (int k = 0; k < 3; ++k) off = std::max(off, std::abs(q[k] - p[k]));
                    p = q;
                }
                soup.points.push_back(p);
                owner.push_back(i);
                if (off > 0.5) soup.crosses_itself[i] = 1;
                largest = std::max(largest, off);
            }
        std::vector<Triangle> corners;
        for (const auto& [i, f] : faces) {
            Triangle t = ready_[i].faces[f];
            for (Index& v : t) v = vertex_[i][v];
            corners.push_back(t);
        }
        const auto moved =
            exact::merge_close_coordinates(soup.points, corners, frame.close(options_.most_snap));
        for (std::size_t n = 0; n < moved.size(); ++n) {
            if (moved[n] > 0.5) soup.crosses_itself[owner[n]] = 1;
            largest = std::max(largest, moved[n]);
        }
        for (std::size_t n = 0; n < faces.size(); ++n) {
            const auto [i, f] = faces[n];
            const Triangle& t = corners[n];
            if (is_flat(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]])) {
                soup.crosses_itself[i] = 1;
                continue;
            }
            place_[i][f] = static_cast<Index>(soup.faces.size());
            soup.faces.push_back(t);
            soup.operand.push_back(i);
            soup.given.push_back({i, ready_[i].source.empty() ? f : ready_[i].source[f]});
        }
        soup.twin.reserve(3 * soup.faces.size());
        for (const auto& [i, f] : faces) {
            if (place_[i][f] < 0) continue;
            for (int k = 0; k < 3; ++k) {
                const Index h = ready_[i].twin[3 * f + k];
                const Index at = h < 0 ? -1 : place_[i][h / 3];
                soup.twin.push_back(at < 0 ? -1 : 3 * at + h % 3);
            }
        }
        auto& report = result_.report;
        report.grid_step = std::max(report.grid_step, frame.step());
        report.largest_snap = std::max(report.largest_snap, largest * frame.step());
        return soup;
    }

    void append(const Solved& solved, const Frame& frame)
    {
        IndexedMesh& mesh = result_.mesh;
        const auto base = static_cast<Index>(mesh.vertices.size());
        for (const Vec3& p : solved.points) mesh.vertices.push_back(frame.from_grid(p));
        for (const Triangle& t : solved.faces)
            mesh.faces.push_back({t[0] + base, t[1] + base, t[2] + base});
        for (const auto& [operand, face] : solved.given) {
            result_.operand.push_back(operand);
            result_.source_face.push_back(face);
        }
    }

    const Meshes& meshes_;
    const BooleanFormula& formula_;
    const MeshBooleanOptions& options_;
    std::vector<ClosedOperand> ready_;
    Index n_clusters_ = 0;
    std::vector<Box3> cluster_box_;
    std::vector<std::vector<std::pair<Index, Index>>> cluster_faces_;
    std::vector<std::vector<Index>> place_;   // by operand and face: number in its soup
    std::vector<std::vector<Index>> vertex_;  // by operand and vertex: number in its soup
    MeshBooleanResult result_;
};

}  // namespace

MeshBooleanResult mesh_boolean(std::span<const IndexedMesh> operands, const BooleanFormula& formula,
                               const MeshBooleanOptions& options)
{
    formula.check(static_cast<Index>(operands.size()));
    Meshes meshes;
    for (const IndexedMesh& mesh : operands) meshes.push_back(&mesh);
    return Call(meshes, formula, options).run();
}

IndexedMesh unite(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands, BooleanFormula::union_of(static_cast<Index>(operands.size())))
        .mesh;
}

IndexedMesh intersect(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands,
                        BooleanFormula::intersection_of(static_cast<Index>(operands.size())))
        .mesh;
}

IndexedMesh subtract(std::span<const IndexedMesh> operands)
{
    return mesh_boolean(operands,
                        BooleanFormula::difference_of(static_cast<Index>(operands.size())))
        .mesh;
}

}  // namespace genus
