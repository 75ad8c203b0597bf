#include "genus/boolean/arrangement.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <tuple>
#include <unordered_map>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/box_tree.h"
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
    auto operator<=>(const Recipe&) const = default;
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
    Index from;
    Index to;
    Index other;  // the face that makes it
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
    /// By cell; an empty list: not covered. Left out where one face covers all.
    std::vector<std::vector<Arrangement::Cover>> covers;
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
        join_flat_faces();
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
            return {edge(m.f, e.on_f - 3), static_cast<EdgeKey>(m.g), false};
        if (e.on_f == Contact::kInside)
            return {edge(m.g, e.on_g - 3), static_cast<EdgeKey>(m.f), false};
        const auto [low, high] = std::minmax({edge(m.f, e.on_f - 3), edge(m.g, e.on_g - 3)});
        return {low, high, true};
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

    void make_points()
    {
        for (const Meeting& m : meetings_)
            for (int i = 0; i < m.contact.n_events; ++i)
                if (!is_corner(m.contact.events[i]))
                    recipes_.push_back(recipe(m, m.contact.events[i]));
        sort_unique(recipes_);
        std::vector<ExactPoint> made(recipes_.size());
        parallel_for(recipes_.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) made[i] = make(recipes_[i]);
        });
        recipe_point_.reserve(recipes_.size());
        for (const ExactPoint& point : made) recipe_point_.push_back(table_.add(point));
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
        needed_.assign(out_.points.size(), 0);
        for (const Meeting& m : meetings_) {
            const Contact& c = m.contact;
            ++out_.n_contacts;
            out_.passive[m.f] = out_.passive[m.g] = 0;
            std::array<Index, 16> points;
            for (int i = 0; i < c.n_events; ++i) {
                points[i] = point_of(m, c.events[i]);
                register_at(m.f, c.events[i].on_f, points[i]);
                register_at(m.g, c.events[i].on_g, points[i]);
                if (!needed_[points[i]]) needed_[points[i]] = is_needed(m, c.events[i]);
            }
            if (c.coplanar) {
                coplanar_.push_back({m.f, m.g});
                continue;
            }
            if (c.n_events < 2 || points[0] == points[1]) continue;
            const auto [low, high] = std::minmax(points[0], points[1]);
            const int edge_f = edge_along(c.events[0].on_f, c.events[1].on_f);
            const int edge_g = edge_along(c.events[0].on_g, c.events[1].on_g);
            if (edge_f < 0 || is_flat(m.f, edge_f)) segments_.push_back({m.f, low, high, m.g});
            if (edge_g < 0 || is_flat(m.g, edge_g)) segments_.push_back({m.g, low, high, m.f});
        }
        meetings_.clear();
        sort_unique(on_edge_);
        sort_unique(in_face_);
    }

    // Edges between faces of one plane, diagonals mostly, are left out where something crosses
    // them: these faces are then one flat, and points that only such an edge would make are none.
    void join_flat_faces()
    {
        std::vector<SegmentInFace> joined;
        do {
            find_flats();
            joined = segments_;
            for (SegmentInFace& s : joined) {
                s.face = flats_.find(s.face);
                s.other = flats_.find(s.other);
            }
            sort_unique(joined);
        } while (!join_segments(joined));
        segments_ = std::move(joined);
        const auto needless = [&](const auto& at) { return !needed_[at.point]; };
        on_edge_.erase(std::remove_if(on_edge_.begin(), on_edge_.end(), needless), on_edge_.end());
        in_face_.erase(std::remove_if(in_face_.begin(), in_face_.end(), needless), in_face_.end());
    }

    void find_flats()
    {
        cut_edges_.clear();
        for (const PointOnEdge& at : on_edge_)
            if (!needed_[at.point] && (cut_edges_.empty() || cut_edges_.back() != at.edge))
                cut_edges_.push_back(at.edge);
        flats_ = DisjointSets(soup_.faces.size());
        if (cut_edges_.empty()) return;
        for (const Index h : touched_edges_)
            if (is_left_out(h / 3, h % 3)) flats_.unite(h / 3, soup_.twin[h] / 3);
    }

    // Among edges that something touches: is it flat, with points that it would make?
    bool is_left_out(Index f, int i) const
    {
        return flat_edge_[3 * f + i] == 1 &&
               std::binary_search(cut_edges_.begin(), cut_edges_.end(), edge(f, i));
    }

    // Joins segments of one flat and one other at needless points. False if there was one at which
    // not two of them ended: it is needed then, and all has to be done again.
    bool join_segments(std::vector<SegmentInFace>& segments)
    {
        std::vector<SegmentInFace> joined;
        std::vector<std::pair<Index, Index>> ends;  // needless point, segment
        bool sound = true;
        for (std::size_t begin = 0; begin < segments.size();) {
            ends.clear();
            std::size_t end = begin;
            for (; end < segments.size() && segments[end].face == segments[begin].face &&
                   segments[end].other == segments[begin].other;
                 ++end)
                for (const Index p : {segments[end].from, segments[end].to})
                    if (!needed_[p]) ends.push_back({p, static_cast<Index>(end)});
            std::sort(ends.begin(), ends.end());
            for (std::size_t i = 0; i < ends.size();) {
                std::size_t j = i;
                while (j < ends.size() && ends[j].first == ends[i].first) ++j;
                if (j - i != 2) {
                    needed_[ends[i].first] = 1;
                    sound = false;
                }
                i = j;
            }
            if (sound) follow_segments(segments, begin, end, ends, joined);
            begin = end;
        }
        std::sort(joined.begin(), joined.end());
        segments = std::move(joined);
        return sound;
    }

    void follow_segments(const std::vector<SegmentInFace>& segments, std::size_t begin,
                         std::size_t end, const std::vector<std::pair<Index, Index>>& ends,
                         std::vector<SegmentInFace>& joined) const
    {
        for (std::size_t s = begin; s < end; ++s) {
            SegmentInFace whole = segments[s];
            if (!needed_[whole.from]) std::swap(whole.from, whole.to);
            if (!needed_[whole.from]) continue;  // comes up from its ends
            auto at = static_cast<Index>(s);
            while (!needed_[whole.to]) {
                const auto pair = std::lower_bound(ends.begin(), ends.end(),
                                                   std::pair<Index, Index>{whole.to, 0});
                at = pair[0].second == at ? pair[1].second : pair[0].second;
                whole.to = segments[at].from == whole.to ? segments[at].to : segments[at].from;
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

    // Points of edge i of f from corner i to the next, both included.
    std::vector<Index> chain(Index f, int i) const
    {
        const Index from = corner(f, i);
        const Index to = corner(f, next(i));
        std::vector<Index> points{from};
        const auto [begin, end] = range_of(on_edge_, &PointOnEdge::edge, edge_key(from, to));
        for (std::size_t p = begin; p < end; ++p)
            if (on_edge_[p].point != from && on_edge_[p].point != to)
                points.push_back(on_edge_[p].point);
        points.push_back(to);
        if (points.size() == 2) return points;
        int axis = 0;
        const Vec3 d = soup_.points[to] - soup_.points[from];
        for (int k = 1; k < 3; ++k)
            if (std::abs(d[k]) > std::abs(d[axis])) axis = k;
        const int way = d[axis] > 0 ? -1 : 1;
        std::sort(points.begin() + 1, points.end() - 1, [&](Index a, Index b) {
            return compare_coordinate(axis, out_.points[a], out_.points[b]) == way;
        });
        return points;
    }

    void cut_groups()
    {
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
        for (std::size_t c = 0; c < group.corners.size(); ++c) {
            if (!group.covers.empty() && group.covers[c].empty()) continue;
            Arrangement::Cell cell;
            for (int i = 0; i < 3; ++i) cell.corners[i] = number[group.corners[c][i]];
            cell.plane = plane_face;
            cell.cut = group.corners.size() > 1;
            cell.covers_begin = static_cast<Index>(out_.covers.size());
            if (group.covers.empty())
                cover_cell({plane_face, 1});
            else
                for (const auto& cover : group.covers[c]) cover_cell(cover);
            cell.covers_end = static_cast<Index>(out_.covers.size());
            out_.cells.push_back(cell);
        }
        out_.group_end.resize(out_.cells.size(), static_cast<Index>(out_.cells.size()));
        for (std::size_t c = first; c < out_.cells.size(); ++c)
            out_.group_end[c] = static_cast<Index>(out_.cells.size());
    }

    GroupCells cut_group(Index begin, Index end) const
    {
        current_progress().check();
        const Index first = group_faces_[begin];
        std::vector<std::array<std::vector<Index>, 3>> chains;
        bool whole = end == begin + 1;
        for (Index m = begin; m < end; ++m) {
            const Index f = group_faces_[m];
            chains.push_back({chain(f, 0), chain(f, 1), chain(f, 2)});
            for (const auto& c : chains.back()) whole = whole && c.size() == 2;
            const auto inside = range_of(in_face_, &PointInFace::face, f);
            const auto across = range_of(segments_, &SegmentInFace::face, f);
            whole = whole && inside.first == inside.second && across.first == across.second;
        }
        GroupCells result;
        if (whole) {
            result.corners = {{0, 1, 2}};
            result.known = {corner(first, 0), corner(first, 1), corner(first, 2)};
            return result;
        }
        triangulate(begin, end, chains, result);
        return result;
    }

    void triangulate(Index begin, Index end,
                     const std::vector<std::array<std::vector<Index>, 3>>& chains,
                     GroupCells& result) const
    {
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

        std::unordered_map<Index, Index> local;
        if (end == begin + 1) {
            mesh.start_with_triangle(out_.points[corner(first, 0)], out_.points[corner(first, 1)],
                                     out_.points[corner(first, 2)]);
            for (int i = 0; i < 3; ++i) {
                local[corner(first, i)] = i;
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
            const auto [it, is_new] = local.try_emplace(point, 0);
            if (!is_new) return;
            it->second = mesh.insert(out_.points[point]);
            result.known.push_back(point);
        };
        for (const auto& three : chains)
            for (const auto& c : three)
                for (const Index p : c) insert(p);
        for (Index m = begin; m < end; ++m) {
            const auto [from, to] = range_of(in_face_, &PointInFace::face, group_faces_[m]);
            for (std::size_t i = from; i < to; ++i) insert(in_face_[i].point);
        }
        for (Index m = begin; m < end; ++m)
            for (int e = 0; e < 3; ++e) {
                if (is_left_out(group_faces_[m], e)) continue;
                const auto& c = chains[m - begin][e];
                for (std::size_t i = 1; i < c.size(); ++i)
                    mesh.constrain(local.at(c[i - 1]), local.at(c[i]), kEdgeCarrier);
            }
        for (Index m = begin; m < end; ++m) {
            const auto [from, to] = range_of(segments_, &SegmentInFace::face, group_faces_[m]);
            for (std::size_t i = from; i < to; ++i)
                mesh.constrain(local.at(segments_[i].from), local.at(segments_[i].to),
                               segments_[i].other);
        }
        // Points of nearly parallel planes make slivers that rounding would turn over.
        mesh.improve();
        result.corners.reserve(mesh.cells().size());
        for (const auto& cell : mesh.cells()) result.corners.push_back(cell.v);
        if (end == begin + 1) return;
        result.covers.resize(mesh.cells().size());
        for (Index m = begin; m < end;) {
            const Index flat = flat_of_[group_faces_[m]];
            const auto& c = soup_.faces[flat];
            const int sign = first_sign * normal_sign(axis, soup_.points[c[0]], soup_.points[c[1]],
                                                      soup_.points[c[2]]);
            std::vector<std::array<int, 2>> rim;
            for (; m < end && flat_of_[group_faces_[m]] == flat; ++m)
                for (int e = 0; e < 3; ++e)
                    if (!is_left_out(group_faces_[m], e))
                        add_to_rim(mesh, chains[m - begin][e], local, sign, rim);
            cover(mesh, rim, {flat, sign}, result.covers);
        }
    }

    static void add_to_rim(const PlanarTriangulation& mesh, const std::vector<Index>& chain,
                           const std::unordered_map<Index, Index>& local, int sign,
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
                      Arrangement::Cover what, std::vector<std::vector<Arrangement::Cover>>& covers)
    {
        std::sort(rim.begin(), rim.end());
        std::vector<int> stack;
        const auto enter = [&](int cell) {
            auto& list = covers[cell];
            if (!list.empty() && list.back().face == what.face) return;
            list.push_back(what);
            stack.push_back(cell);
        };
        for (const auto& edge : rim) enter(edge[0]);
        while (!stack.empty()) {
            const int cell = stack.back();
            stack.pop_back();
            for (int i = 0; i < 3; ++i)
                if (!std::binary_search(rim.begin(), rim.end(), std::array<int, 2>{cell, i}))
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
    std::vector<EdgeKey> cut_edges_;      // with points that only flat edges make; sorted
    std::vector<char> needed_;            // by point: there even if flat edges were not
    std::vector<std::pair<Index, Index>> coplanar_;
    std::vector<Index> group_faces_;
    std::vector<Index> group_start_;
};

}  // namespace

Candidates find_candidates(const Soup& soup, std::size_t most)
{
    const std::size_t n = soup.faces.size();
    std::vector<FloatBox> boxes(n);
    std::vector<Index> owners(n);
    parallel_for(n, 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const auto& t = soup.faces[f];
            boxes[f] = box_of(soup.points[t[0]], soup.points[t[1]], soup.points[t[2]]);
            const Index operand = soup.operand[f];
            const bool crosses = !soup.crosses_itself.empty() && soup.crosses_itself[operand] != 0;
            owners[f] = crosses ? -1 : operand;
        }
    });
    Candidates candidates;
    candidates.tree = BoxTree(std::move(boxes), std::move(owners));
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
