#include "genus/boolean/solve.h"

#include <algorithm>
#include <limits>
#include <map>

#include "genus/base/parallel.h"
#include "genus/boolean/assemble.h"
#include "genus/boolean/box_map.h"
#include "genus/boolean/buried.h"
#include "genus/boolean/charts.h"
#include "genus/boolean/closed_operand.h"
#include "genus/boolean/contact.h"
#include "genus/boolean/ray.h"
#include "genus/boolean/winding.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

constexpr int kMendRounds = 10, kFirstRounds = 2;
// A point is rounded once; twice that, for what rounding does to its distance from others.
constexpr double kRoundings = 2.0;

// What is wrong with a result.
struct Defects {
    std::vector<Index> faces;
    std::vector<BoxTree::Pair> pairs;  // those that meet in more than they have in common
};

// What pairs of faces of a result do, by part of the search.
struct Collisions {
    std::vector<BoxTree::Pair> pairs;
    bool parts_touch = false;
};

// Do two faces of a result meet in more than common corners and edges? Corners at one place are
// one corner; those that have numbers of their own are noted.
bool collide(const Solved& mesh, Index f, Index g, bool& parts_touch)
{
    Corners a;
    Corners b;
    for (int i = 0; i < 3; ++i) {
        a.at[i] = &mesh.points[mesh.faces[f][i]];
        b.at[i] = &mesh.points[mesh.faces[g][i]];
    }
    number_corners(a, b);
    for (int j = 0; j < 3; ++j)
        if (b.id[j] < 3 && a.at[b.id[j]] != b.at[j]) parts_touch = true;
    return !certainly_apart(a, b) && !find_contact(a, b).trivial();
}

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

// The parts that have few faces and a corner that rounding moved.
struct SmallParts {
    DisjointSets parts{0};
    std::map<Index, std::vector<Index>> faces;  // by part
};

SmallParts find_small_moved_parts(const Solved& mesh, const Rounding& rounding)
{
    constexpr Index kFew = 16;
    SmallParts small;
    if (std::none_of(rounding.moved.begin(), rounding.moved.end(), [](char m) { return m != 0; }))
        return small;
    DisjointSets parts(mesh.points.size());
    for (const Triangle& t : mesh.faces) {
        parts.unite(t[0], t[1]);
        parts.unite(t[0], t[2]);
    }
    std::vector<char> moved(mesh.points.size(), 0);  // by part
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (rounding.moved[v]) moved[parts.find(static_cast<Index>(v))] = 1;
    std::vector<Index> size(mesh.points.size(), 0);  // by part
    for (const Triangle& t : mesh.faces) ++size[parts.find(t[0])];
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Index part = parts.find(mesh.faces[f][0]);
        if (moved[part] && size[part] <= kFew) small.faces[part].push_back(static_cast<Index>(f));
    }
    small.parts = std::move(parts);
    return small;
}

// Faces of parts of few faces that rounding left with no volume, or a negative one, and that lie in
// nothing that they could hollow out. Exact.
std::vector<Index> find_inverted_slivers(const Solved& mesh, const Rounding& rounding)
{
    SmallParts small = find_small_moved_parts(mesh, rounding);
    const auto corner = [&](Index f, int i) -> const Vec3& {
        return mesh.points[mesh.faces[f][i]];
    };
    std::vector<Index> bad;
    for (const auto& [part, list] : small.faces) {
        WideInt<4> volume;
        for (const Index f : list)
            volume = WideInt<4>(volume + plane_through(corner(f, 0), corner(f, 1), corner(f, 2)).d);
        if (volume.sign() > 0) continue;
        const Vec3& start = corner(list[0], 0);
        const Vec3 first = corner(list[0], 1) - start;
        const Vec3 second = corner(list[0], 2) - start;
        const Ray ray{dominant_axis(start, start + first, start + second), start, first, second};
        Index winding = 0;
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const auto face = static_cast<Index>(f);
            if (small.parts.find(mesh.faces[f][0]) != part)
                winding += hit(ray, corner(face, 0), corner(face, 1), corner(face, 2));
        }
        if (winding == 0) bad.insert(bad.end(), list.begin(), list.end());
    }
    return bad;
}

// The faces that, after some corners moved, are flat or meet others. Notes where parts touch.
Defects find_collisions(Solved& mesh, const std::vector<char>& moved)
{
    enum : char { kStill, kSuspect, kFlat };
    Defects bad;
    std::vector<Index> suspects;
    std::vector<char> kind(mesh.faces.size(), kStill);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Triangle& t = mesh.faces[f];
        if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) continue;
        const bool flat = is_flat(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
        kind[f] = flat ? kFlat : kSuspect;
        (flat ? bad.faces : suspects).push_back(static_cast<Index>(f));
    }
    if (suspects.empty()) return bad;
    const auto box = [&](Index f) {
        const Triangle& t = mesh.faces[f];
        return box_of(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
    };
    std::vector<FloatBox> boxes;
    for (const Index f : suspects) boxes.push_back(box(f));
    const BoxMap map(boxes);
    const BoxTree tree(std::move(boxes), {});
    std::vector<Collisions> found;
    const auto look_at = [&](Index f, Index g, Collisions& part) {
        if (collide(mesh, f, g, part.parts_touch)) part.pairs.push_back({f, g});
    };
    const auto take = [&] {
        for (const Collisions& part : found) {
            bad.pairs.insert(bad.pairs.end(), part.pairs.begin(), part.pairs.end());
            mesh.parts_touch = mesh.parts_touch || part.parts_touch;
        }
    };
    tree.visit_pairs([&](std::size_t parts) { found.resize(parts); },
                     [&](Index a, Index b, std::size_t part) {
                         look_at(suspects[a], suspects[b], found[part]);
                     });
    take();
    constexpr std::size_t kGrain = 4096;
    found.assign(mesh.faces.size() / kGrain + 1, {});
    parallel_for(mesh.faces.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const auto face = static_cast<Index>(f);
            if (kind[f] != kStill || !map.may_overlap(box(face))) continue;
            tree.query(box(face),
                       [&](Index s) { look_at(face, suspects[s], found[begin / kGrain]); });
        }
    });
    take();
    for (const auto& [f, g] : bad.pairs) bad.faces.insert(bad.faces.end(), {f, g});
    std::sort(bad.faces.begin(), bad.faces.end());
    bad.faces.erase(std::unique(bad.faces.begin(), bad.faces.end()), bad.faces.end());
    return bad;
}

Start look_over_all(const Soup& soup, std::vector<Index> owners, const BooleanFormula& formula,
                    Index n_operands, std::size_t most_pairs)
{
    Start start{std::nullopt, find_candidates(soup, std::move(owners), most_pairs), {}};
    if (n_operands > 2 && start.candidates.complete)
        start.buried = find_buried(soup, start.candidates, formula, n_operands);
    return start;
}

}  // namespace

Start look_over(const Soup& soup, const BooleanFormula& formula, Index n_operands,
                std::size_t most_pairs)
{
    return look_over_all(soup, find_owners(soup), formula, n_operands, most_pairs);
}

Start look_over_zone(const Soup& soup, const Frame& frame, const BooleanFormula& formula,
                     Index n_operands)
{
    std::vector<Index> owners = find_owners(soup);
    // With buried faces the outcome is cut up in another way: what is known of operands must not
    // decide between the two.
    std::optional<Zone> zone =
        find_zone(soup, owners, kRoundings * frame.rounding(), n_operands > 2);
    if (!zone) return look_over_all(soup, std::move(owners), formula, n_operands, kAnyNumber);
    Candidates candidates = find_candidates(zone->soup, std::move(zone->owners), kAnyNumber);
    return {std::move(zone), std::move(candidates), {}};
}

namespace {

// Does a face turn against its plane now that corners moved?
bool turned_by(const std::vector<char>& moved, const Solved& mesh, Index f, const Soup& soup,
               const OutFace& from)
{
    const Triangle& t = mesh.faces[f];
    if (!moved[t[0]] && !moved[t[1]] && !moved[t[2]]) return false;
    const auto sign = [](int axis, const std::vector<Vec3>& points, const Triangle& corners) {
        return turn(axis, points[corners[0]], points[corners[1]], points[corners[2]]);
    };
    const Triangle& plane = soup.faces[from.plane];
    const int axis =
        dominant_axis(soup.points[plane[0]], soup.points[plane[1]], soup.points[plane[2]]);
    const int before = sign(axis, soup.points, plane) * (from.flipped ? -1 : 1);
    return sign(axis, mesh.points, t) == -before;
}

Solved::Rim rim_of(const Soup& zone, const Selection& selection, const std::vector<OutFace>& faces,
                   const OutMesh& mesh)
{
    Solved::Rim rim{selection.tracts, {}, {}};
    // What was halved has its other half at the end.
    for (const OutFace& face : faces) {
        if (!face.fixed || (!rim.sources.empty() && face.source <= rim.sources.back())) break;
        rim.sources.push_back(face.source);
    }
    for (std::size_t i = 0; i < mesh.n_plain_points; ++i)
        rim.on_rim.push_back(zone.is_on_rim(mesh.points[i]) ? mesh.points[i] : -1);
    return rim;
}

// The surface of a soup by formula, rounded. Nothing if it touches itself along an edge too short
// to be two; `place` is a point of it then.
std::optional<Solved> solve_once(const Soup& soup, const Frame& frame,
                                 const BooleanFormula& formula, Index n_operands, InsideRule rule,
                                 bool merge_coplanar, Start start, Rounding& rounding,
                                 MeshBooleanReport& report, Vec3& place)
{
    report.n_buried_faces += std::count(start.buried.begin(), start.buried.end(), 1);
    Arrangement arrangement = arrange(soup, std::move(start.candidates), std::move(start.buried));
    auto found = select(soup, arrangement, formula, n_operands, rule);
    if (!found) {
        arrangement = arrange(soup, find_candidates(soup, find_owners(soup), kAnyNumber), {});
        found = select(soup, arrangement, formula, n_operands, rule);
    }
    const Selection& selection = *found;
    auto faces = collect_faces(soup, arrangement, selection, merge_coplanar);
    const std::size_t n_exact = arrangement.points.size();
    std::optional<OutMesh> split = split_to_manifold(soup, arrangement, faces, place);
    if (!split) {
        place = frame.from_grid(place);
        return std::nullopt;
    }
    OutMesh& mesh = *split;

    report.n_candidate_pairs += arrangement.n_candidate_pairs;
    report.n_contacts += arrangement.n_contacts;
    report.n_passive_faces += std::count(arrangement.passive.begin(), arrangement.passive.end(), 1);
    report.n_cells += static_cast<std::int64_t>(arrangement.cells.size());
    report.n_new_points +=
        static_cast<std::int64_t>(arrangement.points.size() - soup.points.size());

    Solved solved;
    solved.saw_all = arrangement.buried.empty();
    solved.touch_themselves = std::move(arrangement.touch_themselves);
    std::vector<char> taken(arrangement.points.size(), 0);
    for (const Index p : mesh.points) {
        solved.parts_touch = solved.parts_touch || taken[p] != 0;
        taken[p] = 1;
    }
    solved.faces = std::move(mesh.faces);
    solved.points.resize(mesh.points.size());
    rounding = {};
    rounding.moved.assign(mesh.points.size(), 0);
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
        const PointRef& p = arrangement.points[mesh.points[i]];
        solved.points[i] = p.approx;
        const auto number = static_cast<std::size_t>(mesh.points[i]);
        if (number < soup.points.size()) continue;
        const bool middle = number >= n_exact;
        solved.points[i] = frame.rounded(p.approx);
        rounding.moved[i] = middle || !same_point({solved.points[i], nullptr}, p);
    }
    if (soup.n_tracts > 0) solved.rim = rim_of(soup, selection, faces, mesh);
    solved.given.reserve(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        solved.given.push_back(soup.given[faces[f].source]);
        if (turned_by(rounding.moved, solved, static_cast<Index>(f), soup, faces[f]))
            rounding.turned.push_back(static_cast<Index>(f));
    }
    return solved;
}

// A result as an operand, and what is known of it.
struct Operand {
    Soup soup;
    Start start;
};

// Equal points are made one, flat faces left out. No other faces than those of `pairs` meet in more
// than they have in common: the others are as the exact result had them, or were looked at.
Operand as_operand(const Solved& solved, const std::vector<BoxTree::Pair>& pairs)
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
    find_twins(soup.points.size(), all, twin);
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
    std::vector<Index> place_of(solved.faces.size(), -1);
    for (std::size_t f = 0; f < all.size(); ++f) place_of[face[f]] = place[f];
    Candidates known{PlateTree::of_faces(soup), {}};
    for (const auto& [f, g] : pairs) {
        const auto [low, high] = std::minmax(place_of[f], place_of[g]);
        known.pairs.push_back({low, high});
    }
    return {std::move(soup), {std::nullopt, std::move(known), {}}};
}

}  // namespace

namespace {

// The defects of a result that rounding made. Notes where parts touch.
Defects find_defects(Solved& solved, const Rounding& rounding)
{
    Defects bad = find_collisions(solved, rounding.moved);
    if (bad.faces.empty()) bad.faces = find_turned_parts(solved, rounding);
    if (bad.faces.empty()) bad.faces = find_inverted_slivers(solved, rounding);
    return bad;
}

// A zone without defects, as part of the whole: a part of it that is small may be large there.
bool is_sound_zone(Solved& solved, const Rounding& rounding)
{
    return find_collisions(solved, rounding.moved).faces.empty() && rounding.turned.empty() &&
           find_small_moved_parts(solved, rounding).faces.empty();
}

}  // namespace

std::optional<Solved> solve_whole(const Soup& soup, const Frame& frame,
                                  const BooleanFormula& formula, Index n_operands,
                                  const MeshBooleanOptions& options, Start start,
                                  MeshBooleanReport& report, Vec3& place)
{
    Rounding rounding;
    const std::optional<Zone> zone = std::move(start.zone);
    std::optional<Solved> found =
        solve_once(zone ? zone->soup : soup, frame, formula, n_operands, InsideRule::NonZero,
                   options.merge_coplanar, std::move(start), rounding, report, place);
    if (!found) return std::nullopt;
    if (zone) {
        const bool sound = is_sound_zone(*found, rounding);
        const auto n_far = static_cast<std::int64_t>(soup.faces.size() - zone->soup.faces.size());
        if (!zone->beyond->add_to(*found, rounding))
            return solve_whole(soup, frame, formula, n_operands, options,
                               look_over(soup, formula, n_operands), report, place);
        report.n_passive_faces += n_far;
        report.n_left_alone += n_far;
        if (sound) return found;
    }
    const bool saw_all = found->saw_all;
    const std::vector<Index> touch_themselves = std::move(found->touch_themselves);
    std::size_t least_bad = std::numeric_limits<std::size_t>::max();
    for (int round = 0; found; ++round) {
        Solved& solved = *found;
        const Defects bad = find_defects(solved, rounding);
        if (bad.faces.empty()) {
            solved.saw_all = saw_all;
            solved.touch_themselves = touch_themselves;
            return found;
        }
        place = frame.from_grid(solved.points[solved.faces[bad.faces[0]][0]]);
        // Thin parts that break up into ever more are helped by a coarser grid only.
        const bool spreads = round >= kFirstRounds && bad.faces.size() > 2 * least_bad;
        if (round == kMendRounds || spreads) return std::nullopt;
        least_bad = std::min(least_bad, bad.faces.size());
        ++report.n_mended;
        Operand again = as_operand(solved, bad.pairs);
        found = solve_once(again.soup, frame, BooleanFormula::union_of(1), 1, InsideRule::Positive,
                           options.merge_coplanar, std::move(again.start), rounding, report, place);
    }
    return std::nullopt;
}

}  // namespace genus::exact
