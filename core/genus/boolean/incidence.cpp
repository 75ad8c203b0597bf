#include "genus/boolean/incidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "genus/base/parallel.h"
#include "genus/boolean/contact.h"
#include "genus/boolean/sheets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;
using Event = Contact::Event;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

// An intersection point by what makes it: an edge and a face, or two edges.
struct Recipe {
    bool two_edges;
    Index edge;
    Index other;  // a second edge, or a face

    std::uint64_t key() const
    {
        return static_cast<std::uint64_t>(two_edges) << 63 |
               static_cast<std::uint64_t>(static_cast<std::uint32_t>(edge)) << 31 |
               static_cast<std::uint32_t>(other);
    }
    static Recipe of_key(std::uint64_t key)
    {
        constexpr std::uint64_t k31Bits = 0x7fffffffu;
        return {key >> 63 != 0, static_cast<Index>(key >> 31 & k31Bits),
                static_cast<Index>(key & k31Bits)};
    }
};

// Of two plates, named by their first faces.
struct Meeting {
    Index f;
    Index g;
    std::size_t first_event;
    std::int8_t n_events;
    bool coplanar;
};

// What pairs of faces are, by part of the search.
struct Found {
    std::vector<Meeting> meetings;
    std::vector<Event> events;
    std::vector<std::pair<Index, Index>> equal;  // points at one place, where faces just touch
    std::vector<Index> touch_themselves;         // operands
};

class Finder {
public:
    Finder(const Soup& soup, std::vector<BoxTree::Pair> pairs, Arrangement& out, PointTable& table)
        : soup_(soup),
          plates_(out.tree.plates()),
          pairs_(std::move(pairs)),
          out_(out),
          table_(table),
          flat_edge_(3 * soup.faces.size(), -1)
    {
        found_.edge_of.assign(3 * soup.faces.size(), -1);
    }

    Incidence run()
    {
        start();
        find_meetings();
        make_points();
        register_all();
        if (!join_flat_faces()) {
            forget_flat_edges();
            make_points();
            register_all();
            join_flat_faces();
        }
        wake_neighbors();
        list_points();
        return std::move(found_);
    }

private:
    // ---- where faces meet

    void start()
    {
        out_.points.reserve(soup_.points.size());
        for (const Vec3& p : soup_.points) out_.points.push_back({p, nullptr});
        out_.first_equal.resize(soup_.points.size());
        std::iota(out_.first_equal.begin(), out_.first_equal.end(), 0);
        entered_.assign(soup_.points.size(), 0);
        out_.passive.assign(soup_.faces.size(), 1);
        for (std::size_t f = 0; f < soup_.faces.size(); ++f)
            for (int i = 0; i < 3; ++i)
                if (soup_.twin[3 * f + i] == -1 || is_buried(static_cast<Index>(f)))
                    wake(static_cast<Index>(f));
    }

    void wake(Index f)
    {
        out_.passive[f] = 0;
        if (const Index g = plates_.other(soup_, f); g >= 0) out_.passive[g] = 0;
    }

    bool is_buried(Index f) const { return !out_.buried.empty() && out_.buried[f] != 0; }

    void find_meetings()
    {
        constexpr std::size_t kGrain = 512;
        out_.n_candidate_pairs = static_cast<std::int64_t>(pairs_.size());
        std::vector<Found> found(pairs_.size() / kGrain + 1);
        parallel_for(pairs_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                look_at(pairs_[i].first, pairs_[i].second, found[begin / kGrain]);
        });
        pairs_ = {};
        for (std::size_t f = 0; f < soup_.faces.size(); ++f)
            if (!out_.passive[f]) enter_corners(static_cast<Index>(f));
        std::vector<std::pair<Index, Index>> equal;
        std::vector<Lists<Meeting>::Keyed> by_face;
        for (Found& part : found) {
            equal.insert(equal.end(), part.equal.begin(), part.equal.end());
            out_.touch_themselves.insert(out_.touch_themselves.end(), part.touch_themselves.begin(),
                                         part.touch_themselves.end());
            for (Meeting& m : part.meetings) {
                m.first_event += events_.size();
                by_face.push_back({m.f, m});
            }
            events_.insert(events_.end(), part.events.begin(), part.events.end());
            part = {};
        }
        // In an order that says nothing about the pairs that do not meet.
        std::sort(equal.begin(), equal.end());
        for (const auto& [v, w] : equal) {
            enter_point(v);
            enter_point(w);
        }
        list_meetings(by_face);
        out_.n_contacts = static_cast<std::int64_t>(meetings_.size());
    }

    void list_meetings(const std::vector<Lists<Meeting>::Keyed>& by_face)
    {
        meetings_.reserve(by_face.size());
        Lists<Meeting> lists(soup_.faces.size(), by_face);
        for (std::size_t f = 0; f < soup_.faces.size(); ++f) {
            const std::span<Meeting> list = lists[f];
            std::sort(list.begin(), list.end(),
                      [](const Meeting& a, const Meeting& b) { return a.g < b.g; });
            for (const Meeting& m : list) {
                for (const Index plate : {m.f, m.g}) {
                    wake(plate);
                    enter_corners(plate);
                    if (const Index g = plates_.other(soup_, plate); g >= 0) enter_corners(g);
                }
                meetings_.push_back(m);
            }
        }
    }

    void look_at(Index f, Index g, Found& found) const
    {
        Corners at_f = corners(f);
        Corners at_g = corners(g);
        const auto ids_f = at_f.id;
        const auto ids_g = at_g.id;
        number_corners(at_f, at_g);
        const Contact contact = find_contact(at_f, at_g);
        if (contact.n_events == 0) return;
        if (contact.n_events == 1 && contact.trivial()) {
            const Index v = ids_f[contact.events[0].on_f];
            const Index w = ids_g[contact.events[0].on_g];
            if (v == w) return;
            found.equal.push_back({v, w});
            note_touch(f, g, found);
            return;
        }
        if (contact.trivial() && joined_by_twins(f, g)) return;
        note_touch(f, g, found);
        found.meetings.push_back({f, g, found.events.size(),
                                  static_cast<std::int8_t>(contact.n_events), contact.coplanar});
        found.events.insert(found.events.end(), contact.events.begin(),
                            contact.events.begin() + contact.n_events);
    }

    void note_touch(Index f, Index g, Found& found) const
    {
        if (soup_.operand[f] == soup_.operand[g])
            found.touch_themselves.push_back(soup_.operand[f]);
    }

    Outline outline(Index f) const { return plates_.outline(soup_, f); }
    Corners corners(Index f) const { return plates_.corners(soup_, f); }

    bool joined_by_twins(Index f, Index g) const
    {
        const Outline of_f = outline(f);
        const Index other = plates_.other(soup_, g);
        for (int i = 0; i < of_f.n; ++i) {
            const Index h = soup_.twin[of_f.halfedge[i]];
            if (h >= 0 && (h / 3 == g || h / 3 == other)) return true;
        }
        return false;
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

    // ---- points

    static bool is_corner(const Event& e)
    {
        return Contact::is_corner(e.on_f) || Contact::is_corner(e.on_g);
    }

    // The halfedge at a place on the edge of a plate.
    Index halfedge(Index f, int place) const { return outline(f).halfedge[place - Contact::kEdge]; }
    // The number of an edge that something touches.
    Index edge(Index h)
    {
        Index& known = found_.edge_of[h];
        if (known < 0) known = edges_.number_of(edge_key(start_of(h), end_of(h)));
        return known;
    }
    Index start_of(Index h) const { return corner(h / 3, h % 3); }
    Index end_of(Index h) const { return corner(h / 3, next(h % 3)); }
    Index low_end(Index edge) const { return static_cast<Index>(edges_.keys()[edge] >> 32); }
    Index high_end(Index edge) const
    {
        return static_cast<Index>(edges_.keys()[edge] & 0xffffffffu);
    }

    Recipe recipe(const Meeting& m, const Event& e)
    {
        if (e.on_g == Contact::kInside) return {false, edge(halfedge(m.f, e.on_f)), m.g};
        if (e.on_f == Contact::kInside) return {false, edge(halfedge(m.g, e.on_g)), m.f};
        const auto [low, high] =
            std::minmax({edge(halfedge(m.f, e.on_f)), edge(halfedge(m.g, e.on_g))});
        return {true, low, high};
    }

    // Needless points have no coordinates, only numbers: -2 and below.
    void make_points()
    {
        std::vector<char> needed;  // by recipe
        point_of_event_.resize(events_.size());
        for (const Meeting& m : meetings_)
            for (std::size_t i = m.first_event; i < m.first_event + m.n_events; ++i) {
                if (is_corner(events_[i])) continue;
                const Index r = recipes_.number_of(recipe(m, events_[i]).key());
                if (r == static_cast<Index>(needed.size())) needed.push_back(0);
                if (!needed[r]) needed[r] = is_needed(m, events_[i]);
                point_of_event_[i] = r;
            }
        const std::size_t n = needed.size();
        constexpr std::size_t kGrain = 4096;
        std::vector<std::vector<ExactPoint>> made(n / kGrain + 1);
        parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r)
                if (needed[r])
                    made[begin / kGrain].push_back(make(Recipe::of_key(recipes_.keys()[r])));
        });
        recipe_point_.resize(n);
        for (std::size_t part = 0, r = 0; part < made.size(); ++part) {
            for (std::size_t i = 0; r < std::min(n, (part + 1) * kGrain); ++r)
                recipe_point_[r] =
                    needed[r] ? table_.add(made[part][i++]) : -2 - static_cast<Index>(r);
            made[part] = {};
        }
        for (const Meeting& m : meetings_)
            for (std::size_t i = m.first_event; i < m.first_event + m.n_events; ++i) {
                const Event& e = events_[i];
                Index& point = point_of_event_[i];
                if (Contact::is_corner(e.on_f))
                    point = start_of(outline(m.f).halfedge[e.on_f]);
                else if (Contact::is_corner(e.on_g))
                    point = start_of(outline(m.g).halfedge[e.on_g]);
                else
                    point = recipe_point_[point];
            }
    }

    ExactPoint make(const Recipe& r) const
    {
        const Vec3& p = soup_.points[low_end(r.edge)];
        const Vec3& q = soup_.points[high_end(r.edge)];
        if (r.two_edges)
            return two_lines(p, q, soup_.points[low_end(r.other)], soup_.points[high_end(r.other)]);
        const Triangle& t = soup_.faces[r.other];
        return line_and_plane(p, q, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
    }

    // Would the point be there if flat edges were not?
    bool is_needed(const Meeting& m, const Event& e)
    {
        const Index on_f = e.on_f == Contact::kInside ? -1 : halfedge(m.f, e.on_f);
        const Index on_g = e.on_g == Contact::kInside ? -1 : halfedge(m.g, e.on_g);
        const bool flat_f = on_f >= 0 && is_flat(on_f);
        const bool flat_g = on_g >= 0 && is_flat(on_g);
        if (!flat_f && !flat_g) return true;
        if (flat_f == flat_g || m.coplanar) return false;
        if (on_f < 0 || on_g < 0) return false;
        // The other edge pierces the plane, or lies in it.
        return flat_f ? !edge_in_plane(on_g, m.f) : !edge_in_plane(on_f, m.g);
    }

    // Does halfedge i join two faces of one plane that turn alike?
    bool is_flat(Index i)
    {
        signed char& known = flat_edge_[i];
        if (known < 0) {
            const Index h = soup_.twin[i];
            known = h >= 0 && !is_buried(h / 3) && same_plane(soup_, i) ? 1 : 0;
            if (h >= 0) flat_edge_[h] = known;
        }
        return known != 0;
    }

    bool edge_in_plane(Index h, Index g) const
    {
        const Triangle& t = soup_.faces[g];
        const SideOfPlane side(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        return side.of(soup_.points[soup_.faces[h / 3][h % 3]]) == 0 &&
               side.of(soup_.points[soup_.faces[h / 3][next(h % 3)]]) == 0;
    }

    // ---- what lies where

    void register_all()
    {
        cut_.assign(edges_.keys().size(), 0);
        for (std::size_t r = 0; r < recipe_point_.size(); ++r) register_recipe(r);
        for (const Meeting& m : meetings_) {
            const Event* events = events_.data() + m.first_event;
            const Index* points = point_of_event_.data() + m.first_event;
            for (int i = 0; i < m.n_events; ++i)
                if (is_corner(events[i])) {
                    register_corner(m.f, events[i].on_f, points[i]);
                    register_corner(m.g, events[i].on_g, points[i]);
                }
            if (m.coplanar) {
                found_.coplanar.push_back({m.f, m.g});
                continue;
            }
            if (m.n_events < 2 || points[0] == points[1]) continue;
            const auto [low, high] = std::minmax(points[0], points[1]);
            if (cuts(m.f, m.g, events[0].on_f, events[1].on_f))
                segments_.push_back({m.f, {m.g, low, high}});
            if (cuts(m.g, m.f, events[0].on_g, events[1].on_g))
                segments_.push_back({m.g, {m.f, low, high}});
        }
    }

    // Does what plate g shares with f, from place a to b on it, cut f, and is no edge of it?
    bool cuts(Index f, Index g, int a, int b)
    {
        if (a == Contact::kInside || b == Contact::kInside) return true;
        const int along = edge_along(corners(f), a, b);
        // A neighbour in the plane that shares a flat edge makes no segment of it.
        return along < 0 || (is_flat(outline(f).halfedge[along]) && !parallel_faces(soup_, f, g));
    }

    void register_recipe(std::size_t number)
    {
        const Recipe r = Recipe::of_key(recipes_.keys()[number]);
        const Index point = recipe_point_[number];
        if (point < 0) {
            cut_[r.edge] = 1;
            if (r.two_edges) cut_[r.other] = 1;
            return;
        }
        on_edge_.push_back({r.edge, point});
        (r.two_edges ? on_edge_ : in_face_).push_back({r.other, point});
    }

    void register_corner(Index face, int place, Index point)
    {
        if (place == Contact::kInside)
            in_face_.push_back({face, point});
        else if (Contact::is_edge(place))
            on_edge_.push_back({edge(halfedge(face, place)), point});
    }

    // Faces beyond an edge that is touched have to be cut as well.
    void wake_neighbors()
    {
        for (Index h = 0; h < static_cast<Index>(found_.edge_of.size()); ++h) {
            const Index twin = soup_.twin[h];
            if (found_.edge_of[h] < 0 || twin < 0) continue;
            found_.edge_of[twin] = found_.edge_of[h];
            wake(twin / 3);
        }
    }

    void list_points()
    {
        found_.in_face = Lists<Index>(soup_.faces.size(), in_face_);
        found_.in_face.sort_and_make_unique();
        found_.on_edge = Lists<Index>(edges_.keys().size(), on_edge_);
        found_.on_edge.sort_and_make_unique();
        for (std::size_t e = 0; e < found_.on_edge.n_keys(); ++e) {
            const auto list = found_.on_edge[e];
            const Index low = low_end(static_cast<Index>(e));
            const Index high = high_end(static_cast<Index>(e));
            const auto end = std::remove_if(list.begin(), list.end(), [&](Index point) {
                return point == low || point == high;
            });
            found_.on_edge.shorten(e, static_cast<std::size_t>(end - list.begin()));
            sort_along(low, high, found_.on_edge[e]);
        }
    }

    void sort_along(Index from, Index to, std::span<Index> points) const
    {
        if (points.size() < 2) return;
        int axis = 0;
        const Vec3 d = soup_.points[to] - soup_.points[from];
        for (int k = 1; k < 3; ++k)
            if (std::abs(d[k]) > std::abs(d[axis])) axis = k;
        const int way = d[axis] > 0 ? -1 : 1;
        std::sort(points.begin(), points.end(), [&](Index a, Index b) {
            return compare_coordinate(axis, out_.points[a], out_.points[b]) == way;
        });
    }

    // ---- flats

    // Joins faces across flat edges that something crosses: these are then one flat.
    //
    // False if that cannot be: a flat of an operand that crosses itself may cover a place twice,
    // and a segment may end at a point that such an edge would make.
    bool join_flat_faces()
    {
        find_flats();
        if (a_flat_overlaps_itself()) return false;
        for (auto& [face, segment] : segments_) {
            face = found_.flats.find(face);
            segment.other = found_.flats.find(segment.other);
        }
        found_.segments = Lists<Incidence::Segment>(soup_.faces.size(), segments_);
        found_.segments.sort_and_make_unique();
        segments_.clear();
        for (std::size_t face = 0; face < soup_.faces.size(); ++face)
            if (!join_segments(face)) return false;
        return true;
    }

    void find_flats()
    {
        cut_.resize(edges_.keys().size(), 0);
        found_.flats = DisjointSets(soup_.faces.size());
        found_.left_out.assign(3 * soup_.faces.size(), 0);
        const auto join = [&](Index h, Index twin) {
            found_.left_out[h] = found_.left_out[twin] = 1;
            found_.flats.unite(h / 3, twin / 3);
        };
        for (Index f = 0; !plates_.empty() && f < static_cast<Index>(soup_.faces.size()); ++f)
            if (const Index h = plates_.diagonal(f); h >= 0) join(h, soup_.twin[h]);
        for (Index h = 0; h < static_cast<Index>(found_.edge_of.size()); ++h) {
            const Index edge = found_.edge_of[h];
            if (edge < 0 || !cut_[edge] || flat_edge_[h] != 1) continue;
            const Index twin = soup_.twin[h];
            join(h, twin);
        }
    }

    bool a_flat_overlaps_itself()
    {
        return std::any_of(found_.coplanar.begin(), found_.coplanar.end(), [&](const auto& pair) {
            return found_.flats.find(pair.first) == found_.flats.find(pair.second);
        });
    }

    void forget_flat_edges()
    {
        flat_edge_.assign(flat_edge_.size(), 0);
        recipes_ = {};
        on_edge_.clear();
        in_face_.clear();
        segments_.clear();
        found_.coplanar.clear();
    }

    // Joins segments of one flat and one other at needless points. False if there is one at which
    // not two of them end.
    bool join_segments(std::size_t face)
    {
        const std::span<Incidence::Segment> list = found_.segments[face];
        if (std::none_of(list.begin(), list.end(),
                         [](const auto& s) { return s.from < 0 || s.to < 0; }))
            return true;
        std::vector<Incidence::Segment> joined;
        std::vector<std::pair<Index, Index>> ends;  // needless point, segment
        for (std::size_t begin = 0; begin < list.size();) {
            ends.clear();
            std::size_t end = begin;
            for (; end < list.size() && list[end].other == list[begin].other; ++end)
                for (const Index p : {list[end].from, list[end].to})
                    if (p < 0) ends.push_back({p, static_cast<Index>(end)});
            std::sort(ends.begin(), ends.end());
            for (std::size_t i = 0; i < ends.size(); i += 2)
                if (i + 1 == ends.size() || ends[i].first != ends[i + 1].first ||
                    (i + 2 < ends.size() && ends[i].first == ends[i + 2].first))
                    return false;
            follow_segments(list, begin, end, ends, joined);
            begin = end;
        }
        std::copy(joined.begin(), joined.end(), list.begin());
        found_.segments.shorten(face, joined.size());
        return true;
    }

    static void follow_segments(std::span<const Incidence::Segment> list, std::size_t begin,
                                std::size_t end, const std::vector<std::pair<Index, Index>>& ends,
                                std::vector<Incidence::Segment>& joined)
    {
        for (std::size_t s = begin; s < end; ++s) {
            Incidence::Segment whole = list[s];
            if (whole.from < 0) std::swap(whole.from, whole.to);
            if (whole.from < 0) continue;  // comes up from its ends
            auto at = static_cast<Index>(s);
            while (whole.to < 0) {
                const auto pair = std::lower_bound(ends.begin(), ends.end(),
                                                   std::pair<Index, Index>{whole.to, 0});
                at = pair[0].second == at ? pair[1].second : pair[0].second;
                whole.to = list[at].from == whole.to ? list[at].to : list[at].from;
            }
            if (whole.from > whole.to) std::swap(whole.from, whole.to);
            // One that was joined comes up from both ends.
            if (at == static_cast<Index>(s) || static_cast<Index>(s) < at) joined.push_back(whole);
        }
    }

    const Soup& soup_;
    const Plates& plates_;
    std::vector<BoxTree::Pair> pairs_;
    Arrangement& out_;
    PointTable& table_;
    Incidence found_;
    std::vector<char> entered_;  // by point of the soup: in the table
    std::vector<Meeting> meetings_;
    std::vector<Event> events_;
    std::vector<Index> point_of_event_;
    Numbering edges_;
    Numbering recipes_;
    std::vector<Index> recipe_point_;
    std::vector<Lists<Index>::Keyed> on_edge_;
    std::vector<Lists<Index>::Keyed> in_face_;
    std::vector<Lists<Incidence::Segment>::Keyed> segments_;
    std::vector<signed char> flat_edge_;  // by halfedge: 1 flat, 0 not, -1 not asked yet
    std::vector<char> cut_;               // by edge: has needless points
};

}  // namespace

Incidence find_incidence(const Soup& soup, std::vector<BoxTree::Pair> pairs, Arrangement& out,
                         PointTable& table)
{
    return Finder(soup, std::move(pairs), out, table).run();
}

}  // namespace genus::exact
