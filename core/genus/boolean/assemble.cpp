#include "genus/boolean/assemble.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/boolean/planar_triangulation.h"
#include "genus/boolean/sheets.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

Sheet sheet_of(const std::vector<OutFace>& faces, Index f, int i)
{
    const OutFace& face = faces[f];
    const Index a = face.corners[i];
    const Index b = face.corners[next(i)];
    return {edge_key(a, b), f, face.plane, face.flipped, a < b};
}

// Calls use(begin, end) for each run of sheets at one edge.
template <class Use>
void for_each_edge(std::vector<Sheet>& sheets, const Use& use)
{
    for (std::size_t begin = 0; begin < sheets.size();) {
        std::size_t end = begin + 1;
        while (end < sheets.size() && sheets[end].edge == sheets[begin].edge) ++end;
        use(sheets.data() + begin, sheets.data() + end);
        begin = end;
    }
}

// Joins the faces of one plane and leaves out corners that are not needed.
class Merger {
public:
    Merger(const Soup& soup, const Arrangement& arrangement, std::vector<OutFace>& faces)
        : soup_(soup),
          cut_(arrangement),
          faces_(faces),
          regions_(static_cast<Index>(faces.size())),
          corner_(arrangement.points.size())
    {
    }

    void run()
    {
        find_regions();
        find_needless();
        replace_regions();
    }

private:
    // What is known of a point: the number of borders between regions that end there, and which
    // two regions they part.
    struct Corner {
        std::int32_t borders = 0;
        Index a = -1;
        Index b = -1;
        bool needed = false;
    };

    void find_regions()
    {
        for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f) {
            if (faces_[f].fixed)
                for (const Index p : faces_[f].corners) corner_[p].needed = true;
        }
        std::vector<Index> face_of_cell(cut_.cells.size(), -1);
        for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f)
            if (faces_[f].cell >= 0) face_of_cell[faces_[f].cell] = f;
        for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f) {
            if (faces_[f].fixed) continue;
            for (int i = 0; i < 3; ++i) {
                const Index across = cell_across(faces_[f], i);
                if (across >= 0)
                    regions_.unite(f, face_of_cell[across]);
                else
                    sheets_.push_back(sheet_of(faces_, f, i));
            }
        }
        sort_sheets(sheets_);
        // What lies within a region is done with; the others part two regions, or more.
        std::vector<Sheet> rims;
        for_each_edge(sheets_, [&](Sheet* begin, Sheet* end) {
            if (inner(begin, end))
                regions_.unite(begin[0].item, begin[1].item);
            else
                rims.insert(rims.end(), begin, end);
        });
        sheets_ = std::move(rims);
    }

    // The cell across edge i of a face, if nothing but the two meets there.
    Index cell_across(const OutFace& face, int i) const
    {
        if (face.cell < 0) return -1;
        // Turned over faces have their corners 1 and 2 swapped.
        return cut_.cells[face.cell].across[face.flipped ? 2 - i : i];
    }

    bool inner(const Sheet* begin, const Sheet* end) const
    {
        return end - begin == 2 && begin[0].forward != begin[1].forward &&
               parallel_faces(soup_, begin[0].plane, begin[1].plane);
    }

    void find_needless()
    {
        for_each_edge(sheets_, [&](Sheet* begin, Sheet* end) {
            for (const Index p : {static_cast<Index>(begin->edge >> 32),
                                  static_cast<Index>(begin->edge & 0xffffffffu)}) {
                Corner& corner = corner_[p];
                if (end - begin != 2) {
                    corner.needed = true;
                    continue;
                }
                const auto [low, high] =
                    std::minmax({regions_.find(begin[0].item), regions_.find(begin[1].item)});
                if (corner.borders++ == 0) {
                    corner.a = low;
                    corner.b = high;
                } else if (corner.a != low || corner.b != high) {
                    corner.needed = true;
                }
            }
        });
        // With two borders between the same two planes these are in line: the corner lies inside
        // an edge. With none it lies inside a face.
        for (Corner& corner : corner_)
            if (corner.borders != 0 && corner.borders != 2) corner.needed = true;
    }

    void replace_regions()
    {
        std::vector<std::pair<Index, Index>> members;
        for (Index f = 0; f < static_cast<Index>(faces_.size()); ++f)
            if (!faces_[f].fixed) members.push_back({regions_.find(f), f});
        std::sort(members.begin(), members.end());
        std::vector<Sheet> rim = std::move(sheets_);
        for (Sheet& s : rim) s.plane = s.item;  // the face it belongs to
        for (Sheet& s : rim) s.item = regions_.find(s.item);
        std::sort(rim.begin(), rim.end(), [](const Sheet& a, const Sheet& b) {
            return std::tie(a.item, a.edge, a.forward) < std::tie(b.item, b.edge, b.forward);
        });
        std::vector<OutFace> kept;
        for (const OutFace& face : faces_)
            if (face.fixed) kept.push_back(face);
        std::size_t r = 0;
        for (std::size_t begin = 0; begin < members.size();) {
            std::size_t end = begin;
            bool changed = false;
            for (; end < members.size() && members[end].first == members[begin].first; ++end)
                for (const Index p : faces_[members[end].second].corners)
                    changed = changed || !corner_[p].needed;
            const std::size_t rim_begin = r;
            while (r < rim.size() && rim[r].item == members[begin].first) ++r;
            if (changed)
                triangulate(rim.data() + rim_begin, rim.data() + r,
                            needed_corners(members, begin, end), kept);
            else
                for (std::size_t m = begin; m < end; ++m) kept.push_back(faces_[members[m].second]);
            begin = end;
        }
        faces_ = std::move(kept);
    }

    // The needed corners of a region: those on its borders, and those inside where another part
    // touches it.
    std::vector<Index> needed_corners(const std::vector<std::pair<Index, Index>>& members,
                                      std::size_t begin, std::size_t end) const
    {
        std::vector<Index> points;
        for (std::size_t m = begin; m < end; ++m)
            for (const Index p : faces_[members[m].second].corners)
                if (corner_[p].needed) points.push_back(p);
        std::sort(points.begin(), points.end());
        points.erase(std::unique(points.begin(), points.end()), points.end());
        return points;
    }

    struct Border {
        Index from;
        Index to;
        Index face;
    };

    // The borders of a region, surface to the left, from one needed corner to the next.
    std::vector<Border> borders(const Sheet* begin, const Sheet* end) const
    {
        std::unordered_map<Index, Index> after;  // from a needless corner to the next
        std::vector<Border> list;
        for (const Sheet* s = begin; s != end; ++s) {
            auto from = static_cast<Index>(s->edge >> 32);
            auto to = static_cast<Index>(s->edge & 0xffffffffu);
            if (!s->forward) std::swap(from, to);
            if (corner_[from].needed)
                list.push_back({from, to, s->plane});
            else
                after[from] = to;
        }
        for (Border& border : list)
            while (!corner_[border.to].needed) border.to = after.at(border.to);
        return list;
    }

    void triangulate(const Sheet* begin, const Sheet* end, const std::vector<Index>& corners,
                     std::vector<OutFace>& kept) const
    {
        current_progress().check();
        const std::vector<Border> rim = borders(begin, end);
        const OutFace first = faces_[rim.front().face];
        const auto& t = soup_.faces[first.plane];
        const int axis = dominant_axis(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        const int sign = turn(axis, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        PlanarTriangulation mesh(axis, (sign < 0) != first.flipped, [](int, int) -> PointRef {
            throw Error("mesh_boolean: borders of a plane region cross");
        });
        Vec3 low = Box3::filled(1e300);
        Vec3 high = Box3::filled(-1e300);
        for (const Border& border : rim)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], std::floor(cut_.points[border.from].approx[k]));
                high[k] = std::max(high[k], std::ceil(cut_.points[border.from].approx[k]));
            }
        mesh.start_with_rectangle(low, high);
        std::unordered_map<Index, int> local;
        std::vector<Index> global(4, -1);
        for (const Index p : corners) {
            local[p] = mesh.insert(cut_.points[p]);
            global.push_back(p);
        }
        for (const Border& border : rim)
            mesh.constrain(local.at(border.from), local.at(border.to), border.face);
        mesh.improve();
        flood(mesh, rim, local, global, first, kept);
    }

    void flood(const PlanarTriangulation& mesh, const std::vector<Border>& rim,
               const std::unordered_map<Index, int>& local, const std::vector<Index>& global,
               const OutFace& first, std::vector<OutFace>& kept) const
    {
        std::vector<Index> source(mesh.cells().size(), -1);
        std::vector<int> queue;
        const auto enter = [&](int cell, Index from) {
            if (cell < 0) throw Error("mesh_boolean: a plane region is open");
            if (source[cell] >= 0) return;
            source[cell] = from;
            queue.push_back(cell);
        };
        for (const Border& border : rim)
            enter(mesh.find_edge(local.at(border.from), local.at(border.to))[0],
                  faces_[border.face].source);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const auto& cell = mesh.cells()[queue[i]];
            for (int e = 0; e < 3; ++e)
                if (cell.carrier[e] < 0) enter(cell.neighbor[e], source[queue[i]]);
        }
        for (std::size_t c = 0; c < source.size(); ++c) {
            if (source[c] < 0) continue;
            OutFace face = first;
            for (int i = 0; i < 3; ++i) face.corners[i] = global[mesh.cells()[c].v[i]];
            face.source = source[c];
            face.untouched = false;
            face.cell = -1;
            kept.push_back(face);
        }
    }

    const Soup& soup_;
    const Arrangement& cut_;
    std::vector<OutFace>& faces_;
    DisjointSets regions_;
    std::vector<Corner> corner_;
    std::vector<Sheet> sheets_;
};

// Passive faces that continue the plane of a face that was touched: they belong to its regions.
std::vector<char> flat_surroundings(const Soup& soup, const Arrangement& arrangement)
{
    std::vector<char> marked(soup.faces.size(), 0);
    std::vector<Index> queue;
    const auto look_round = [&](Index f) {
        for (int i = 0; i < 3; ++i) {
            const Index h = soup.twin[3 * f + i];
            if (h < 0 || !arrangement.passive[h / 3] || marked[h / 3]) continue;
            if (!parallel_faces(soup, f, h / 3)) continue;
            marked[h / 3] = 1;
            queue.push_back(h / 3);
        }
    };
    for (std::size_t f = 0; f < soup.faces.size(); ++f)
        if (!arrangement.passive[f]) look_round(static_cast<Index>(f));
    for (std::size_t i = 0; i < queue.size(); ++i) look_round(queue[i]);
    return marked;
}

}  // namespace

std::vector<OutFace> collect_faces(const Soup& soup, const Arrangement& arrangement,
                                   const Selection& selection, bool merge_coplanar)
{
    std::vector<OutFace> faces;
    const std::vector<char> joining = merge_coplanar ? flat_surroundings(soup, arrangement)
                                                     : std::vector<char>(soup.faces.size(), 0);
    const auto keep = [&](Triangle corners, Index plane, Index source, bool flipped, bool fixed,
                          bool untouched) {
        if (flipped) std::swap(corners[1], corners[2]);
        faces.push_back({corners, plane, source, flipped, fixed, untouched});
    };
    for (std::size_t f = 0; f < soup.faces.size(); ++f) {
        if (selection.faces[f] == 0) continue;
        Triangle corners = soup.faces[f];
        for (Index& p : corners) p = arrangement.first_equal[p];
        keep(corners, static_cast<Index>(f), static_cast<Index>(f), selection.faces[f] < 0,
             !joining[f], true);
    }
    for (std::size_t c = 0; c < arrangement.cells.size(); ++c) {
        if (selection.cells[c] == 0) continue;
        const auto& cell = arrangement.cells[c];
        keep(cell.corners, cell.plane, arrangement.covers[cell.covers_begin].face,
             selection.cells[c] < 0, false, false);
        faces.back().cell = static_cast<Index>(c);
    }
    if (merge_coplanar) Merger(soup, arrangement, faces).run();
    return faces;
}

namespace {

struct Splitting {
    OutMesh mesh;
    std::vector<std::uint64_t> shared_edges;  // left with four faces or more
};

// Points at which other faces end than passive ones that are joined by twins.
std::vector<char> mixed_points(const Soup& soup, const Arrangement& arrangement,
                               const std::vector<Index>& out)
{
    std::vector<char> mixed(arrangement.points.size(), 1);
    std::fill(mixed.begin(), mixed.begin() + static_cast<std::ptrdiff_t>(soup.points.size()), 0);
    for (std::size_t f = 0; f < soup.faces.size(); ++f)
        if (out[f] < 0)
            for (const Index v : soup.faces[f]) mixed[arrangement.first_equal[v]] = 1;
    for (std::size_t v = 0; v < soup.points.size(); ++v)
        if (arrangement.first_equal[v] != static_cast<Index>(v))
            mixed[arrangement.first_equal[v]] = 1;
    return mixed;
}

// Numbers the corners at points where only passive faces end, one number a fan.
void number_fans(const Soup& soup, const std::vector<OutFace>& faces, const std::vector<Index>& out,
                 const std::vector<char>& mixed, std::vector<Index>& number, OutMesh& mesh)
{
    std::vector<Index> at_rim(soup.on_rim.size(), -1);  // by point
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const Index point = faces[f].corners[i];
            if (mixed[point] || number[3 * f + i] >= 0) continue;
            if (soup.is_on_rim(point) && at_rim[point] >= 0) {
                number[3 * f + i] = at_rim[point];
                continue;
            }
            const auto known = static_cast<Index>(mesh.points.size());
            mesh.points.push_back(point);
            if (soup.is_on_rim(point)) {
                // Its fan goes on beyond: see Beyond::keep.
                number[3 * f + i] = at_rim[point] = known;
                continue;
            }
            const Index first = faces[f].source;
            Index at = first;
            do {
                const Triangle& corners = faces[out[at]].corners;
                const int k = corners[0] == point ? 0 : (corners[1] == point ? 1 : 2);
                number[3 * out[at] + k] = known;
                // Turned over faces have their corners 1 and 2 swapped.
                const int in_soup = faces[out[at]].flipped ? (3 - k) % 3 : k;
                at = soup.twin[3 * at + in_soup] / 3;
            } while (at != first);
        }
}

Splitting split_corners(const Soup& soup, const Arrangement& arrangement,
                        const std::vector<OutFace>& faces)
{
    const auto n = static_cast<Index>(faces.size());
    const std::vector<PointRef>& points = arrangement.points;
    std::vector<Index> out(soup.faces.size(), -1);  // of an untouched face, its number in `faces`
    for (Index f = 0; f < n; ++f)
        if (faces[f].untouched) out[faces[f].source] = f;
    const std::vector<char> mixed = mixed_points(soup, arrangement, out);
    std::vector<Sheet> sheets;
    for (Index f = 0; f < n; ++f)
        for (int i = 0; i < 3; ++i)
            if (mixed[faces[f].corners[i]] || mixed[faces[f].corners[next(i)]])
                sheets.push_back(sheet_of(faces, f, i));
    sort_sheets(sheets);

    // Corners (3 face + i) of faces that are neighbours across an edge belong together.
    DisjointSets corners(3 * faces.size());
    const auto corner_at = [&](Index f, Index point) {
        const auto& c = faces[f].corners;
        return 3 * f + (c[0] == point ? 0 : (c[1] == point ? 1 : 2));
    };
    const auto low = [](const Sheet& s) { return static_cast<Index>(s.edge >> 32); };
    const auto high = [](const Sheet& s) { return static_cast<Index>(s.edge & 0xffffffffu); };
    const auto join = [&](const Sheet& a, const Sheet& b) {
        if (a.forward == b.forward) throw Error("mesh_boolean: the result is not oriented");
        for (const Index p : {low(a), high(a)})
            corners.unite(corner_at(a.item, p), corner_at(b.item, p));
    };
    for_each_edge(sheets, [&](Sheet* begin, Sheet* end) {
        if (end - begin == 2) {
            join(begin[0], begin[1]);
            return;
        }
        if ((end - begin) % 2 != 0) throw Error("mesh_boolean: the result is not closed");
        sort_round_edge(soup, points, begin, end);
        // The solid lies between a sheet that turns against the edge and the next one.
        for (Sheet* s = begin; s != end; ++s)
            if (!s->forward) join(*s, s + 1 == end ? *begin : s[1]);
    });

    Splitting result;
    for_each_edge(sheets, [&](Sheet* begin, Sheet* end) {
        std::vector<std::pair<Index, Index>> ends;
        for (const Sheet* s = begin; end - begin > 2 && s != end; ++s)
            if (s->forward)
                ends.push_back({corners.find(corner_at(s->item, low(*s))),
                                corners.find(corner_at(s->item, high(*s)))});
        std::sort(ends.begin(), ends.end());
        if (std::adjacent_find(ends.begin(), ends.end()) != ends.end())
            result.shared_edges.push_back(begin->edge);
    });
    OutMesh& mesh = result.mesh;
    mesh.faces.resize(faces.size());
    std::vector<Index> number(3 * faces.size(), -1);
    number_fans(soup, faces, out, mixed, number, mesh);
    mesh.n_plain_points = mesh.points.size();
    for (Index f = 0; f < n; ++f)
        for (int i = 0; i < 3; ++i) {
            Index& known = number[mixed[faces[f].corners[i]] ? corners.find(3 * f + i) : 3 * f + i];
            if (known < 0) {
                known = static_cast<Index>(mesh.points.size());
                mesh.points.push_back(faces[f].corners[i]);
            }
            mesh.faces[f][i] = known;
        }
    return result;
}

// Puts a corner in the middle of each of the edges and halves the faces there. Returns a point of
// an edge that is too short for that.
std::optional<Vec3> halve_edges(const std::vector<std::uint64_t>& edges,
                                std::vector<PointRef>& points, std::vector<OutFace>& faces)
{
    std::unordered_map<std::uint64_t, Index> middle;
    for (const std::uint64_t edge : edges) {
        const Vec3& a = points[edge >> 32].approx;
        const Vec3& b = points[edge & 0xffffffffu].approx;
        Vec3 m;
        for (int k = 0; k < 3; ++k) m[k] = std::nearbyint(0.5 * a[k] + 0.5 * b[k]);
        if (m == a || m == b) return a;
        middle[edge] = static_cast<Index>(points.size());
        points.push_back({m, nullptr});
    }
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (int i = 0; i < 3;) {
            const auto it = middle.find(edge_key(faces[f].corners[i], faces[f].corners[next(i)]));
            if (it == middle.end()) {
                ++i;
                continue;
            }
            faces[f].untouched = false;
            OutFace other = faces[f];
            other.corners[i] = it->second;
            faces[f].corners[next(i)] = it->second;
            faces.push_back(other);  // looked at when its turn comes
            i = 0;
        }
    return std::nullopt;
}

}  // namespace

std::optional<OutMesh> split_to_manifold(const Soup& soup, Arrangement& arrangement,
                                         std::vector<OutFace>& faces, Vec3& place)
{
    while (true) {
        Splitting splitting = split_corners(soup, arrangement, faces);
        if (splitting.shared_edges.empty()) return std::move(splitting.mesh);
        const auto failed = halve_edges(splitting.shared_edges, arrangement.points, faces);
        if (!failed) continue;
        place = *failed;
        return std::nullopt;
    }
}

}  // namespace genus::exact
