#include "genus/boolean/arrangement.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <span>
#include <tuple>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/box_tree.h"
#include "genus/boolean/charts.h"
#include "genus/boolean/contact.h"
#include "genus/boolean/planar_triangulation.h"
#include "genus/boolean/sheets.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;
using EdgeKey = std::uint64_t;

constexpr int kEdgeCarrier = -2;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

std::uint64_t mixed(std::uint64_t h)
{
    h ^= h >> 31;
    h *= 0x9E3779B97F4A7C15ull;
    h ^= h >> 29;
    return h;
}

std::uint64_t hash_of(const std::array<std::int64_t, 3>& fixed)
{
    std::uint64_t h = 0;
    for (const std::int64_t c : fixed) h = mixed(h + static_cast<std::uint64_t>(c) + 0x51ull);
    return h;
}

std::array<std::int64_t, 3> fixed_of(const Vec3& p)
{
    std::array<std::int64_t, 3> fixed;
    for (int k = 0; k < 3; ++k) fixed[k] = static_cast<std::int64_t>(p[k]) * 1024;
    return fixed;
}

// Numbers points so that equal points get one number. Open addressing: no allocation a point.
class PointTable {
public:
    explicit PointTable(Arrangement& arrangement) : out_(arrangement) {}

    /// The first grid point equal to point `index`, which may be itself.
    Index add_grid_point(Index index)
    {
        return find_or_add(fixed_of(out_.points[index].approx), out_.points[index], index);
    }
    Index add(const ExactPoint& point)
    {
        const auto number = static_cast<Index>(out_.points.size());
        PointRef p{point.approximate(), point.on_grid ? nullptr : &point};
        const Index found = find_or_add(point.fixed, p, number);
        if (found == number) {
            if (p.exact) p.exact = &out_.exact.emplace_back(point);
            out_.points.push_back(p);
        }
        return found;
    }

private:
    struct Slot {
        std::uint32_t hash = 0;
        Index point = -1;
    };

    Index find_or_add(const std::array<std::int64_t, 3>& fixed, const PointRef& p, Index number)
    {
        if (2 * n_used_ >= slots_.size()) grow();
        const auto h = static_cast<std::uint32_t>(hash_of(fixed) >> 32);
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = h & mask;; at = (at + 1) & mask) {
            Slot& slot = slots_[at];
            if (slot.point < 0) {
                slot = {h, number};
                ++n_used_;
                return number;
            }
            if (slot.hash == h && same_point(out_.points[slot.point], p)) return slot.point;
        }
    }
    void grow()
    {
        const std::vector<Slot> old = std::move(slots_);
        slots_.assign(std::max<std::size_t>(64, 2 * old.size()), {});
        const std::size_t mask = slots_.size() - 1;
        for (const Slot& slot : old) {
            if (slot.point < 0) continue;
            std::size_t at = slot.hash & mask;
            while (slots_[at].point >= 0) at = (at + 1) & mask;
            slots_[at] = slot;
        }
    }

    Arrangement& out_;
    std::vector<Slot> slots_;
    std::size_t n_used_ = 0;
};

// An intersection point by what makes it: an edge and a face, or two edges.
struct Recipe {
    EdgeKey edge;
    EdgeKey other;  // a second edge, or a face number
    bool two_edges;
    bool needless;  // only flat edges would make it, see is_needed
    auto operator<=>(const Recipe&) const = default;
    bool same_point_as(const Recipe& o) const
    {
        return edge == o.edge && other == o.other && two_edges == o.two_edges;
    }
};

struct Meeting {
    Index f;
    Index g;
    Contact contact;
};

struct PointOnEdge {
    EdgeKey edge;
    Index point;
    auto operator<=>(const PointOnEdge&) const = default;
};
struct PointInFace {
    Index face;
    Index point;
    auto operator<=>(const PointInFace&) const = default;
};
struct SegmentInFace {
    Index face;
    Index other;  // the face that makes it
    Index from;
    Index to;
    auto operator<=>(const SegmentInFace&) const = default;
};

template <class T>
void sort_unique(std::vector<T>& items)
{
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
}

// Entries of a sorted list whose member `key` equals `value`.
template <class T, class K>
std::pair<std::size_t, std::size_t> range_of(const std::vector<T>& list, K T::*key, K value)
{
    const auto low = std::lower_bound(list.begin(), list.end(), value,
                                      [&](const T& t, K v) { return t.*key < v; });
    auto high = low;
    while (high != list.end() && (*high).*key == value) ++high;
    return {low - list.begin(), high - list.begin()};
}

// What cutting one group of coplanar faces gives, with corners numbered by the group.
struct GroupCells {
    std::vector<Triangle> corners;
    /// Of each cell that is covered, in order; left out where one face covers all.
    struct CoverOf {
        Index cell;
        Arrangement::Cover cover;
    };
    std::vector<CoverOf> covers;
    bool one_covers_all = true;
    std::vector<Index> known;  // group's number of a point: its number, or -1 - new one
    std::deque<ExactPoint> created;
};

Corners corners_of(const Soup& soup, Index f)
{
    Corners c;
    c.id = soup.faces[f];
    for (int i = 0; i < 3; ++i) c.at[i] = &soup.points[c.id[i]];
    return c;
}

// Numbers of points in one group. The memory is kept by the thread, clean between groups.
class LocalNumbers {
public:
    explicit LocalNumbers(std::size_t n_points) : numbers_(memory())
    {
        if (numbers_.size() < n_points) numbers_.resize(n_points, -1);
    }
    ~LocalNumbers()
    {
        for (const Index p : used_) numbers_[p] = -1;
    }
    LocalNumbers(const LocalNumbers&) = delete;
    LocalNumbers& operator=(const LocalNumbers&) = delete;

    Index at(Index point) const { return numbers_[point]; }  // -1 if it has none
    void set(Index point, Index number)
    {
        numbers_[point] = number;
        used_.push_back(point);
    }

private:
    static std::vector<Index>& memory()
    {
        thread_local std::vector<Index> numbers;
        return numbers;
    }

    std::vector<Index>& numbers_;
    std::vector<Index> used_;
};

class Arranger {
public:
    Arranger(const Soup& soup, Candidates candidates, std::vector<char> buried)
        : soup_(soup),
          table_(out_),
          pairs_(std::move(candidates.pairs)),
          flats_(soup.faces.size()),
          flat_edge_(3 * soup.faces.size(), -1)
    {
        out_.tree = std::move(candidates.tree);
        out_.buried = std::move(buried);
        if (out_.buried.empty()) return;
        std::erase_if(pairs_, [&](const auto& pair) {
            return is_buried(pair.first) || is_buried(pair.second);
        });
    }

    Arrangement run()
    {
        start();
        find_meetings();
        make_points();
        register_events();
        if (!join_flat_faces()) {
            forget_flat_edges();
            make_points();
            register_events();
            join_flat_faces();
        }
        meetings_ = {};
        wake_neighbors();
        group_faces();
        cut_groups();
        return std::move(out_);
    }

    void start()
    {
        out_.points.reserve(soup_.points.size());
        for (const Vec3& p : soup_.points) out_.points.push_back({p, nullptr});
        out_.first_equal.resize(soup_.points.size());
        std::iota(out_.first_equal.begin(), out_.first_equal.end(), 0);
        entered_.assign(soup_.points.size(), 0);
        out_.passive.assign(soup_.faces.size(), 1);
        out_.first_cell.assign(soup_.faces.size(), -1);
        for (std::size_t f = 0; f < soup_.faces.size(); ++f)
            for (int i = 0; i < 3; ++i)
                if (soup_.twin[3 * f + i] < 0 || is_buried(static_cast<Index>(f)))
                    out_.passive[f] = 0;
    }

    bool is_buried(Index f) const { return !out_.buried.empty() && out_.buried[f] != 0; }

    // What pairs of faces are, by part of the search.
    struct Found {
        std::vector<Meeting> meetings;
        std::vector<std::pair<Index, Index>> equal;  // points at one place, where faces just touch
    };

    void look_at(Index f, Index g, Found& found) const
    {
        Corners at_f = corners_of(soup_, f);
        Corners at_g = corners_of(soup_, g);
        number_corners(at_f, at_g);
        const Contact contact = find_contact(at_f, at_g);
        if (contact.n_events == 0) return;
        if (contact.n_events == 1 && contact.trivial()) {
            const Index v = soup_.faces[f][contact.events[0].on_f];
            const Index w = soup_.faces[g][contact.events[0].on_g];
            if (v != w) found.equal.push_back({v, w});
            return;
        }
        if (contact.trivial() && joined_by_twins(f, g)) return;
        found.meetings.push_back({f, g, contact});
    }

    void find_meetings()
    {
        constexpr std::size_t kGrain = 512;
        out_.n_candidate_pairs = static_cast<std::int64_t>(pairs_.size());
        std::vector<Found> found(pairs_.size() / kGrain + 1);
        parallel_for(pairs_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                look_at(pairs_[i].first, pairs_[i].second, found[begin / kGrain]);
        });
        for (std::size_t f = 0; f < soup_.faces.size(); ++f)
            if (!out_.passive[f]) enter_corners(static_cast<Index>(f));
        for (const Found& part : found) {
            for (const auto& [v, w] : part.equal) {
                enter_point(v);
                enter_point(w);
            }
            for (const Meeting& m : part.meetings) {
                enter_corners(m.f);
                enter_corners(m.g);
            }
            meetings_.insert(meetings_.end(), part.meetings.begin(), part.meetings.end());
        }
        pairs_ = {};
    }

    void enter_corners(Index f)
    {
        for (const Index v : soup_.faces[f]) enter_point(v);
    }
    void enter_point(Index v)
    {
        if (entered_[v]) return;
        entered_[v] = 1;
        out_.first_equal[v] = table_.add_grid_point(v);
    }

    Index corner(Index f, int i) const { return out_.first_equal[soup_.faces[f][i]]; }
    EdgeKey edge(Index f, int i) const { return edge_key(corner(f, i), corner(f, next(i))); }

    bool is_corner(const Contact::Event& e) const { return e.on_f < 3 || e.on_g < 3; }

    Recipe recipe(const Meeting& m, const Contact::Event& e) const
    {
        if (e.on_g == Contact::kInside)
            return {edge(m.f, e.on_f - 3), static_cast<EdgeKey>(m.g), false, false};
        if (e.on_f == Contact::kInside)
            return {edge(m.g, e.on_g - 3), static_cast<EdgeKey>(m.f), false, false};
        const auto [low, high] = std::minmax({edge(m.f, e.on_f - 3), edge(m.g, e.on_g - 3)});
        return {low, high, true, false};
    }

    Plane plane(Index f) const
    {
        const auto& t = soup_.faces[f];
        return plane_through(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
    }

    ExactPoint make(const Recipe& r) const
    {
        const auto at = [&](EdgeKey key, bool second) -> const Vec3& {
            return soup_.points[second ? static_cast<std::uint32_t>(key)
                                       : static_cast<std::uint32_t>(key >> 32)];
        };
        if (r.two_edges)
            return two_lines(at(r.edge, false), at(r.edge, true), at(r.other, false),
                             at(r.other, true));
        return line_and_plane(at(r.edge, false), at(r.edge, true),
                              plane(static_cast<Index>(r.other)));
    }

    // Needless points have no coordinates, only numbers: -2 and below.
    void make_points()
    {
        for (const Meeting& m : meetings_)
            for (int i = 0; i < m.contact.n_events; ++i) {
                const Contact::Event& e = m.contact.events[i];
                if (is_corner(e)) continue;
                recipes_.push_back(recipe(m, e));
                recipes_.back().needless = !is_needed(m, e);
            }
        std::sort(recipes_.begin(), recipes_.end());  // of equal ones, one that is needed is first
        const auto same = [](const Recipe& a, const Recipe& b) { return a.same_point_as(b); };
        recipes_.erase(std::unique(recipes_.begin(), recipes_.end(), same), recipes_.end());
        constexpr std::size_t kGrain = 4096;
        std::vector<std::vector<ExactPoint>> made(recipes_.size() / kGrain + 1);
        parallel_for(recipes_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                if (!recipes_[i].needless) made[begin / kGrain].push_back(make(recipes_[i]));
        });
        recipe_point_.resize(recipes_.size());
        for (std::size_t part = 0, i = 0; part < made.size(); ++part) {
            for (std::size_t n = 0; i < std::min(recipes_.size(), (part + 1) * kGrain); ++i)
                recipe_point_[i] =
                    recipes_[i].needless ? -2 - static_cast<Index>(i) : table_.add(made[part][n++]);
            made[part] = {};
        }
    }

    Index point_of(const Meeting& m, const Contact::Event& e) const
    {
        if (e.on_f < 3) return corner(m.f, e.on_f);
        if (e.on_g < 3) return corner(m.g, e.on_g);
        const auto it = std::lower_bound(recipes_.begin(), recipes_.end(), recipe(m, e));
        return recipe_point_[it - recipes_.begin()];
    }

    void register_at(Index face, int place, Index point)
    {
        if (place == Contact::kInside)
            in_face_.push_back({face, point});
        else if (place > 2) {
            on_edge_.push_back({edge(face, place - 3), point});
            touched_edges_.push_back(3 * face + place - 3);
        }
    }

    // Both places on one closed edge of the face? Returns the edge, or -1.
    static int edge_along(int a, int b)
    {
        for (int i = 0; i < 3; ++i) {
            const auto on = [&](int place) {
                return place == i || place == next(i) || place == 3 + i;
            };
            if (on(a) && on(b)) return i;
        }
        return -1;
    }

    // Does edge i of f join two faces of one plane that turn alike?
    bool is_flat(Index f, int i)
    {
        signed char& known = flat_edge_[3 * f + i];
        if (known < 0) {
            const Index h = soup_.twin[3 * f + i];
            known = h >= 0 && !is_buried(h / 3) && same_plane(f, h / 3) ? 1 : 0;
            if (h >= 0) flat_edge_[h] = known;
        }
        return known != 0;
    }

    // For faces with a common edge.
    bool same_plane(Index f, Index g) const
    {
        if (!parallel_faces(soup_, f, g)) return false;
        const auto at = [&](Index face, int i) -> const Vec3& {
            return soup_.points[soup_.faces[face][i]];
        };
        const int axis = dominant_axis(at(f, 0), at(f, 1), at(f, 2));
        return normal_sign(axis, at(f, 0), at(f, 1), at(f, 2)) ==
               normal_sign(axis, at(g, 0), at(g, 1), at(g, 2));
    }

    bool edge_in_plane(Index f, int i, Index g) const
    {
        const Triangle& t = soup_.faces[g];
        const SideOfPlane side(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        return side.of(soup_.points[soup_.faces[f][i]]) == 0 &&
               side.of(soup_.points[soup_.faces[f][next(i)]]) == 0;
    }

    // Would the point be there if flat edges were not?
    bool is_needed(const Meeting& m, const Contact::Event& e)
    {
        if (is_corner(e)) return true;
        const bool flat_f = e.on_f != Contact::kInside && is_flat(m.f, e.on_f - 3);
        const bool flat_g = e.on_g != Contact::kInside && is_flat(m.g, e.on_g - 3);
        if (!flat_f && !flat_g) return true;
        if (flat_f == flat_g || m.contact.coplanar) return false;
        if (e.on_f == Contact::kInside || e.on_g == Contact::kInside) return false;
        // The other edge pierces the plane, or lies in it.
        return flat_f ? !edge_in_plane(m.g, e.on_g - 3, m.f) : !edge_in_plane(m.f, e.on_f - 3, m.g);
    }

    void register_events()
    {
        for (const Meeting& m : meetings_) {
            const Contact& c = m.contact;
            ++out_.n_contacts;
            out_.passive[m.f] = out_.passive[m.g] = 0;
            std::array<Index, 16> points;
            for (int i = 0; i < c.n_events; ++i) {
                points[i] = point_of(m, c.events[i]);
                register_at(m.f, c.events[i].on_f, points[i]);
                register_at(m.g, c.events[i].on_g, points[i]);
            }
            if (c.coplanar) {
                coplanar_.push_back({m.f, m.g});
                continue;
            }
            if (c.n_events < 2 || points[0] == points[1]) continue;
            const auto [low, high] = std::minmax(points[0], points[1]);
            const int edge_f = edge_along(c.events[0].on_f, c.events[1].on_f);
            const int edge_g = edge_along(c.events[0].on_g, c.events[1].on_g);
            // A neighbour in the plane that shares a flat edge makes no segment of it.
            const auto cuts = [&](Index f, int along) {
                return along < 0 || (is_flat(f, along) && !parallel_faces(soup_, m.f, m.g));
            };
            if (cuts(m.f, edge_f)) segments_.push_back({m.f, m.g, low, high});
            if (cuts(m.g, edge_g)) segments_.push_back({m.g, m.f, low, high});
        }
        sort_unique(on_edge_);
        sort_unique(in_face_);
    }

    // Edges between faces of one plane, diagonals mostly, are left out where something crosses
    // them: these faces are then one flat, and points that only such an edge would make are none.
    //
    // False if a segment ends at such a point, which theory forbids for operands that keep their
    // promises.
    bool join_flat_faces()
    {
        find_flats();
        for (SegmentInFace& s : segments_) {
            s.face = flats_.find(s.face);
            s.other = flats_.find(s.other);
        }
        sort_unique(segments_);
        if (!join_segments()) return false;
        const auto needless = [](const auto& at) { return at.point < 0; };
        on_edge_.erase(std::remove_if(on_edge_.begin(), on_edge_.end(), needless), on_edge_.end());
        in_face_.erase(std::remove_if(in_face_.begin(), in_face_.end(), needless), in_face_.end());
        return true;
    }

    void forget_flat_edges()
    {
        flat_edge_.assign(flat_edge_.size(), 0);
        recipes_.clear();
        on_edge_.clear();
        in_face_.clear();
        segments_.clear();
        coplanar_.clear();
        touched_edges_.clear();
        out_.n_contacts = 0;
    }

    void find_flats()
    {
        std::vector<EdgeKey> cut;  // edges with needless points; sorted
        for (const PointOnEdge& at : on_edge_)
            if (at.point < 0 && (cut.empty() || cut.back() != at.edge)) cut.push_back(at.edge);
        flats_ = DisjointSets(soup_.faces.size());
        left_out_.assign(3 * soup_.faces.size(), 0);
        has_points_.assign(3 * soup_.faces.size(), 0);
        for (const Index h : touched_edges_) {
            const Index twin = soup_.twin[h];
            has_points_[h] = 1;
            if (twin >= 0) has_points_[twin] = 1;
            if (flat_edge_[h] != 1 || left_out_[h] ||
                !std::binary_search(cut.begin(), cut.end(), edge(h / 3, h % 3)))
                continue;
            left_out_[h] = left_out_[twin] = 1;
            flats_.unite(h / 3, twin / 3);
        }
    }

    // Joins segments of one flat and one other at needless points. False if there is one at which
    // not two of them end.
    bool join_segments()
    {
        std::vector<SegmentInFace> joined;
        std::vector<std::pair<Index, Index>> ends;  // needless point, segment
        for (std::size_t begin = 0; begin < segments_.size();) {
            ends.clear();
            std::size_t end = begin;
            for (; end < segments_.size() && segments_[end].face == segments_[begin].face &&
                   segments_[end].other == segments_[begin].other;
                 ++end)
                for (const Index p : {segments_[end].from, segments_[end].to})
                    if (p < 0) ends.push_back({p, static_cast<Index>(end)});
            std::sort(ends.begin(), ends.end());
            for (std::size_t i = 0; i < ends.size(); i += 2)
                if (i + 1 == ends.size() || ends[i].first != ends[i + 1].first ||
                    (i + 2 < ends.size() && ends[i].first == ends[i + 2].first))
                    return false;
            follow_segments(begin, end, ends, joined);
            begin = end;
        }
        segments_ = std::move(joined);
        return true;
    }

    void follow_segments(std::size_t begin, std::size_t end,
                         const std::vector<std::pair<Index, Index>>& ends,
                         std::vector<SegmentInFace>& joined) const
    {
        for (std::size_t s = begin; s < end; ++s) {
            SegmentInFace whole = segments_[s];
            if (whole.from < 0) std::swap(whole.from, whole.to);
            if (whole.from < 0) continue;  // comes up from its ends
            auto at = static_cast<Index>(s);
            while (whole.to < 0) {
                const auto pair = std::lower_bound(ends.begin(), ends.end(),
                                                   std::pair<Index, Index>{whole.to, 0});
                at = pair[0].second == at ? pair[1].second : pair[0].second;
                whole.to = segments_[at].from == whole.to ? segments_[at].to : segments_[at].from;
            }
            if (whole.from > whole.to) std::swap(whole.from, whole.to);
            // One that was joined comes up from both ends.
            if (at == static_cast<Index>(s) || static_cast<Index>(s) < at) joined.push_back(whole);
        }
    }

    bool joined_by_twins(Index f, Index g) const
    {
        for (int i = 0; i < 3; ++i)
            if (soup_.twin[3 * f + i] >= 0 && soup_.twin[3 * f + i] / 3 == g) return true;
        return false;
    }

    // Faces beyond an edge with new points have to be cut as well.
    void wake_neighbors()
    {
        for (const Index h : touched_edges_)
            if (soup_.twin[h] >= 0) out_.passive[soup_.twin[h] / 3] = 0;
    }

    void group_faces()
    {
        flat_of_.assign(soup_.faces.size(), -1);
        DisjointSets sets(static_cast<Index>(soup_.faces.size()));
        for (const auto& [f, g] : coplanar_) sets.unite(f, g);
        std::vector<std::array<Index, 3>> members;  // group, flat, face
        for (Index f = 0; f < static_cast<Index>(soup_.faces.size()); ++f) {
            if (out_.passive[f] || is_buried(f)) continue;
            flat_of_[f] = flats_.find(f);
            sets.unite(f, flat_of_[f]);
        }
        for (Index f = 0; f < static_cast<Index>(soup_.faces.size()); ++f)
            if (flat_of_[f] >= 0) members.push_back({sets.find(f), flat_of_[f], f});
        std::sort(members.begin(), members.end());
        for (std::size_t i = 0; i < members.size(); ++i) {
            if (i == 0 || members[i][0] != members[i - 1][0])
                group_start_.push_back(static_cast<Index>(i));
            group_faces_.push_back(members[i][2]);
        }
        group_start_.push_back(static_cast<Index>(members.size()));
    }

    // Adds the points of edge i of f from corner i to the next, both included.
    void add_chain(Index f, int i, std::vector<Index>& points) const
    {
        const Index from = corner(f, i);
        const Index to = corner(f, next(i));
        points.push_back(from);
        const std::size_t first = points.size();
        if (has_points_[3 * f + i]) {
            const auto [begin, end] = range_of(on_edge_, &PointOnEdge::edge, edge_key(from, to));
            for (std::size_t p = begin; p < end; ++p)
                if (on_edge_[p].point != from && on_edge_[p].point != to)
                    points.push_back(on_edge_[p].point);
        }
        if (points.size() > first + 1)
            sort_along(f, i, points.data() + first, points.data() + points.size());
        points.push_back(to);
    }

    void sort_along(Index f, int i, Index* begin, Index* end) const
    {
        int axis = 0;
        const Vec3 d = soup_.points[corner(f, next(i))] - soup_.points[corner(f, i)];
        for (int k = 1; k < 3; ++k)
            if (std::abs(d[k]) > std::abs(d[axis])) axis = k;
        const int way = d[axis] > 0 ? -1 : 1;
        std::sort(begin, end, [&](Index a, Index b) {
            return compare_coordinate(axis, out_.points[a], out_.points[b]) == way;
        });
    }

    // Starts of the runs of each face in a list sorted by face.
    template <class T>
    std::vector<Index> starts_by_face(const std::vector<T>& list) const
    {
        std::vector<Index> start(soup_.faces.size() + 1, 0);
        for (const T& item : list) ++start[item.face + 1];
        for (std::size_t f = 0; f < soup_.faces.size(); ++f) start[f + 1] += start[f];
        return start;
    }

    void cut_groups()
    {
        in_face_start_ = starts_by_face(in_face_);
        segment_start_ = starts_by_face(segments_);
        const std::size_t n = group_start_.size() - 1;
        std::vector<GroupCells> cut(n);
        parallel_for(n, 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g)
                cut[g] = cut_group(group_start_[g], group_start_[g + 1]);
        });
        for (std::size_t g = 0; g < n; ++g) {
            collect(cut[g], group_faces_[group_start_[g]]);
            cut[g] = {};
        }
    }

    // Adds a cover to the cell that comes next.
    void cover_cell(const Arrangement::Cover& cover)
    {
        out_.covers.push_back(cover);
        if (out_.first_cell[cover.face] < 0)
            out_.first_cell[cover.face] = static_cast<Index>(out_.cells.size());
    }

    void collect(const GroupCells& group, Index plane_face)
    {
        std::vector<Index> number(group.known.size());
        for (std::size_t i = 0; i < number.size(); ++i)
            number[i] = group.known[i] >= 0 ? group.known[i]
                                            : table_.add(group.created[-1 - group.known[i]]);
        const std::size_t first = out_.cells.size();
        std::size_t next_cover = 0;
        for (std::size_t c = 0; c < group.corners.size(); ++c) {
            const auto is_of_cell = [&] {
                return next_cover < group.covers.size() &&
                       group.covers[next_cover].cell == static_cast<Index>(c);
            };
            if (!group.one_covers_all && !is_of_cell()) continue;
            Arrangement::Cell cell;
            for (int i = 0; i < 3; ++i) cell.corners[i] = number[group.corners[c][i]];
            cell.plane = plane_face;
            cell.cut = group.corners.size() > 1;
            cell.covers_begin = static_cast<Index>(out_.covers.size());
            if (group.one_covers_all) cover_cell({plane_face, 1});
            for (; is_of_cell(); ++next_cover) cover_cell(group.covers[next_cover].cover);
            cell.covers_end = static_cast<Index>(out_.covers.size());
            out_.cells.push_back(cell);
        }
        out_.group_end.resize(out_.cells.size(), static_cast<Index>(out_.cells.size()));
        for (std::size_t c = first; c < out_.cells.size(); ++c)
            out_.group_end[c] = static_cast<Index>(out_.cells.size());
    }

    // The points along the edges of the faces of a group, both ends included; edge e of the m-th
    // face is number 3 m + e.
    struct Chains {
        std::vector<Index> points;
        std::vector<std::size_t> start{0};

        std::span<const Index> operator[](std::size_t edge) const
        {
            return {points.data() + start[edge], start[edge + 1] - start[edge]};
        }
    };

    GroupCells cut_group(Index begin, Index end) const
    {
        current_progress().check();
        const Index first = group_faces_[begin];
        Chains chains;
        bool whole = end == begin + 1;
        for (Index m = begin; m < end; ++m) {
            const Index f = group_faces_[m];
            for (int e = 0; e < 3; ++e) {
                add_chain(f, e, chains.points);
                chains.start.push_back(chains.points.size());
            }
            whole = whole && in_face_start_[f] == in_face_start_[f + 1] &&
                    segment_start_[f] == segment_start_[f + 1];
        }
        GroupCells result;
        if (whole && chains.points.size() == 6) {
            result.corners = {{0, 1, 2}};
            result.known = {corner(first, 0), corner(first, 1), corner(first, 2)};
            return result;
        }
        triangulate(begin, end, chains, result);
        return result;
    }

    void triangulate(Index begin, Index end, const Chains& chains, GroupCells& result) const
    {
        LocalNumbers local(out_.points.size());
        const Index first = group_faces_[begin];
        const auto& t = soup_.faces[first];
        const int axis = dominant_axis(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        const int first_sign =
            normal_sign(axis, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);

        PlanarTriangulation mesh(axis, first_sign < 0, [&](int a, int b) {
            if (a < 0 || b < 0)
                throw Error("mesh_boolean: operand " + std::to_string(soup_.given[first].operand) +
                            " or another crosses itself near its face " +
                            std::to_string(soup_.given[first].face));
            result.created.push_back(three_planes(plane(first), plane(a), plane(b)));
            const ExactPoint& point = result.created.back();
            result.known.push_back(-static_cast<Index>(result.created.size()));
            return PointRef{point.approximate(), &point};
        });

        if (end == begin + 1) {
            mesh.start_with_triangle(out_.points[corner(first, 0)], out_.points[corner(first, 1)],
                                     out_.points[corner(first, 2)]);
            for (int i = 0; i < 3; ++i) {
                local.set(corner(first, i), i);
                result.known.push_back(corner(first, i));
            }
        } else {
            Vec3 low = Box3::filled(1e300);
            Vec3 high = Box3::filled(-1e300);
            for (Index m = begin; m < end; ++m)
                for (const Index v : soup_.faces[group_faces_[m]])
                    for (int k = 0; k < 3; ++k) {
                        low[k] = std::min(low[k], soup_.points[v][k]);
                        high[k] = std::max(high[k], soup_.points[v][k]);
                    }
            mesh.start_with_rectangle(low, high);
            result.known.assign(4, 0);  // never a corner of a covered cell
        }
        const auto insert = [&](Index point) {
            if (local.at(point) >= 0) return;
            local.set(point, mesh.insert(out_.points[point]));
            result.known.push_back(point);
        };
        for (const Index p : chains.points) insert(p);
        for (Index m = begin; m < end; ++m) {
            const Index f = group_faces_[m];
            for (Index i = in_face_start_[f]; i < in_face_start_[f + 1]; ++i)
                insert(in_face_[i].point);
        }
        for (Index m = begin; m < end; ++m)
            for (int e = 0; e < 3; ++e) {
                if (left_out_[3 * group_faces_[m] + e]) continue;
                const auto chain = chains[3 * (m - begin) + e];
                for (std::size_t i = 1; i < chain.size(); ++i)
                    mesh.constrain(local.at(chain[i - 1]), local.at(chain[i]), kEdgeCarrier);
            }
        for (Index m = begin; m < end; ++m) {
            const Index f = group_faces_[m];
            for (Index i = segment_start_[f]; i < segment_start_[f + 1]; ++i)
                mesh.constrain(local.at(segments_[i].from), local.at(segments_[i].to),
                               segments_[i].other);
        }
        // Points of nearly parallel planes make slivers that rounding would turn over.
        mesh.improve();
        result.corners.reserve(mesh.cells().size());
        for (const auto& cell : mesh.cells()) result.corners.push_back(cell.v);
        if (end == begin + 1) return;
        result.one_covers_all = false;
        std::vector<Index> covered(mesh.cells().size(), -1);  // by which flat, the last one
        for (Index m = begin; m < end;) {
            const Index flat = flat_of_[group_faces_[m]];
            const auto& c = soup_.faces[flat];
            const int sign = first_sign * normal_sign(axis, soup_.points[c[0]], soup_.points[c[1]],
                                                      soup_.points[c[2]]);
            std::vector<std::array<int, 2>> rim;
            for (; m < end && flat_of_[group_faces_[m]] == flat; ++m)
                for (int e = 0; e < 3; ++e)
                    if (!left_out_[3 * group_faces_[m] + e])
                        add_to_rim(mesh, chains[3 * (m - begin) + e], local, sign, rim);
            cover(mesh, rim, {flat, sign}, covered, result.covers);
        }
        std::sort(result.covers.begin(), result.covers.end(), [](const auto& a, const auto& b) {
            return std::tie(a.cell, a.cover.face) < std::tie(b.cell, b.cover.face);
        });
    }

    static void add_to_rim(const PlanarTriangulation& mesh, std::span<const Index> chain,
                           const LocalNumbers& local, int sign,
                           std::vector<std::array<int, 2>>& rim)
    {
        for (std::size_t i = 1; i < chain.size(); ++i) {
            int a = local.at(chain[i - 1]);
            int b = local.at(chain[i]);
            if (sign < 0) std::swap(a, b);
            const auto edge = mesh.find_edge(a, b);
            if (edge[0] < 0) throw Error("mesh_boolean: an edge was lost in its plane");
            rim.push_back(edge);
        }
    }

    // Floods the cells of one flat from its rim.
    static void cover(const PlanarTriangulation& mesh, std::vector<std::array<int, 2>>& rim,
                      Arrangement::Cover what, std::vector<Index>& covered,
                      std::vector<GroupCells::CoverOf>& covers)
    {
        std::sort(rim.begin(), rim.end());
        std::vector<int> stack;
        const auto enter = [&](int cell) {
            if (cell < 0) throw Error("mesh_boolean: a plane region is open");
            if (covered[cell] == what.face) return;
            covered[cell] = what.face;
            covers.push_back({cell, what});
            stack.push_back(cell);
        };
        for (const auto& edge : rim) enter(edge[0]);
        while (!stack.empty()) {
            const int cell = stack.back();
            stack.pop_back();
            for (int i = 0; i < 3; ++i)
                if (mesh.cells()[cell].carrier[i] == PlanarTriangulation::kNone ||
                    !std::binary_search(rim.begin(), rim.end(), std::array<int, 2>{cell, i}))
                    enter(mesh.cells()[cell].neighbor[i]);
        }
    }

private:
    const Soup& soup_;
    Arrangement out_;
    PointTable table_;
    std::vector<BoxTree::Pair> pairs_;
    std::vector<char> entered_;  // by point of the soup: in the table
    std::vector<Meeting> meetings_;
    std::vector<Recipe> recipes_;
    std::vector<Index> recipe_point_;
    std::vector<PointOnEdge> on_edge_;
    std::vector<PointInFace> in_face_;
    std::vector<SegmentInFace> segments_;
    std::vector<Index> touched_edges_;
    DisjointSets flats_;                  // faces joined across flat edges that are left out
    std::vector<Index> flat_of_;          // by face; the first face of a flat stands for it
    std::vector<signed char> flat_edge_;  // by halfedge: 1 flat, 0 not, -1 not asked yet
    std::vector<char> left_out_;          // by halfedge: flat, and something crosses it
    std::vector<char> has_points_;        // by halfedge: it may
    std::vector<Index> in_face_start_;    // by face, in in_face_
    std::vector<Index> segment_start_;    // by face, in segments_
    std::vector<std::pair<Index, Index>> coplanar_;
    std::vector<Index> group_faces_;
    std::vector<Index> group_start_;
};

}  // namespace

Candidates find_candidates(const Soup& soup, std::size_t most)
{
    const std::size_t n = soup.faces.size();
    std::vector<FloatBox> boxes(n);
    parallel_for(n, 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const auto& t = soup.faces[f];
            boxes[f] = box_of(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
        }
    });
    Candidates candidates;
    candidates.tree = BoxTree(std::move(boxes), find_owners(soup));
    std::vector<std::vector<BoxTree::Pair>> found;
    std::atomic<std::size_t> count{0};
    candidates.tree.visit_pairs([&](std::size_t parts) { found.resize(parts); },
                                [&](Index f, Index g, std::size_t part) {
                                    if (count.load(std::memory_order_relaxed) > most) return;
                                    // Corners that are one in their operand may be common. Those
                                    // of two operands at one place are contacts.
                                    if (certainly_apart(corners_of(soup, f), corners_of(soup, g)))
                                        return;
                                    found[part].push_back({f, g});
                                    count.fetch_add(1, std::memory_order_relaxed);
                                });
    candidates.complete = count.load() <= most;
    if (!candidates.complete) return candidates;
    candidates.pairs.reserve(count.load());
    for (const auto& part : found)
        candidates.pairs.insert(candidates.pairs.end(), part.begin(), part.end());
    return candidates;
}

Arrangement arrange(const Soup& soup, Candidates candidates, std::vector<char> buried)
{
    return Arranger(soup, std::move(candidates), std::move(buried)).run();
}

}  // namespace genus::exact
