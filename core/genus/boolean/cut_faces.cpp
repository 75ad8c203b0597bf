#include "genus/boolean/cut_faces.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <tuple>

#include "genus/base/box.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/chords.h"
#include "genus/boolean/planar_triangulation.h"
#include "genus/boolean/sheets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

constexpr int kEdgeCarrier = -2;
constexpr std::size_t kManyPoints = 64;
constexpr std::size_t kFewPoints = 24;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

// What cutting one group of coplanar faces gives, with corners numbered by the group.
struct GroupCells {
    std::vector<Triangle> corners;
    std::vector<Triangle> across;  // the cell across each free edge, or -1
    /// Of each cell that is covered, in order; left out where one face covers all.
    struct CoverOf {
        Index cell;
        Arrangement::Cover cover;
    };
    std::vector<CoverOf> covers;
    bool one_covers_all = true;
    bool is_whole = false;     // one plate that is not cut: a cell a face
    std::vector<Index> known;  // group's number of a point: its number, or -1 - new one
    std::vector<std::unique_ptr<ExactPoint>> created;
};

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

    Index at(Index point) const { return numbers_[point]; }  // -1 if it was never set
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

// The points along the edges of the faces of a group, both ends included; edge e of the m-th face
// is number 3 m + e.
struct Chains {
    std::vector<Index> points;
    std::vector<std::size_t> start{0};

    std::span<const Index> operator[](std::size_t edge) const
    {
        return {points.data() + start[edge], start[edge + 1] - start[edge]};
    }
};

// Cuts the faces of one plane that lie in one flat or overlap.
class GroupCutter {
public:
    GroupCutter(const Soup& soup, const Incidence& incidence, const Arrangement& out,
                const std::vector<Index>& flat_of, std::span<const Index> group)
        : soup_(soup),
          by_(incidence),
          out_(out),
          flat_of_(flat_of),
          group_(group),
          first_(group.front())
    {
    }

    GroupCells run()
    {
        current_progress().check();
        bool is_polygon = is_one_plate();
        std::size_t n_segments = 0;
        for (const Index f : group_) {
            for (int e = 0; e < 3; ++e) {
                add_chain(f, e);
                chains_.start.push_back(chains_.points.size());
            }
            is_polygon = is_polygon && by_.in_face[f].empty();
            n_segments += by_.segments[f].size();
        }
        if (is_polygon && n_segments == 0 && chains_.points.size() == 6 * group_.size()) {
            keep_faces();
        } else if (!is_polygon || chains_.points.size() > kFewPoints || !cut_polygon()) {
            triangulate();
        }
        return std::move(result_);
    }

private:
    bool is_one_plate() const
    {
        return group_.size() == 1 ||
               (group_.size() == 2 && out_.tree.plates().other(soup_, first_) == group_[1]);
    }

    void keep_faces()
    {
        number_corners();
        result_.corners = {{0, 1, 2}};
        result_.across = {{-1, -1, -1}};
        if (group_.size() > 1) {
            result_.corners.push_back({0, 2, 3});
            result_.across = {{-1, -1, 1}, {0, -1, -1}};
        }
        result_.is_whole = true;
    }

    // The corners of the only plate, its first face first.
    void number_corners()
    {
        const Outline round = out_.tree.plates().outline(soup_, first_);
        for (int i = 0; i < round.n; ++i)
            result_.known.push_back(corner(round.halfedge[i] / 3, round.halfedge[i] % 3));
    }

    // Cuts the only plate along segments from side to side. False if they are not all such, or
    // cross.
    bool cut_polygon()
    {
        const Outline round = out_.tree.plates().outline(soup_, first_);
        std::vector<Index>& ring = result_.known;
        for (int i = 0; i < round.n; ++i) {
            const auto chain = chains_[number_of(round.halfedge[i])];
            ring.insert(ring.end(), chain.begin(), chain.end() - 1);
        }
        std::vector<Chord> chords;
        const auto place = [&](Index point) {
            return static_cast<Index>(std::find(ring.begin(), ring.end(), point) - ring.begin());
        };
        const auto n = static_cast<Index>(ring.size());
        bool on_ring = inner_edge_is_whole();
        for (const Index f : group_)
            for (const auto& segment : by_.segments[f]) {
                chords.push_back({place(segment.from), place(segment.to)});
                on_ring = on_ring && chords.back()[0] < n && chords.back()[1] < n;
            }
        std::optional<PolygonCells> cells;
        if (on_ring) {
            std::vector<PointRef> points;
            for (const Index p : ring) points.push_back(out_.points[p]);
            const auto [axis, sign] = view();
            cells = cut_by_chords(axis, sign < 0, points, chords);
        }
        if (!cells) {
            ring.clear();
            return false;
        }
        result_.corners = std::move(cells->corners);
        result_.across = std::move(cells->across);
        return true;
    }

    // Among the edges of the group.
    std::size_t number_of(Index halfedge) const
    {
        const auto m = std::find(group_.begin(), group_.end(), halfedge / 3) - group_.begin();
        return static_cast<std::size_t>(3 * m + halfedge % 3);
    }

    // Are there no points on the edge between the faces of the only plate?
    bool inner_edge_is_whole() const
    {
        const Index h = out_.tree.plates().diagonal(first_);
        return h < 0 || chains_[number_of(h)].size() == 2;
    }

    // The axis along which the plane is seen best, and how it turns from there.
    std::pair<int, int> view() const
    {
        const Triangle& t = soup_.faces[first_];
        const Vec3 &a = soup_.points[t[0]], &b = soup_.points[t[1]], &c = soup_.points[t[2]];
        const int axis = dominant_axis(a, b, c);
        return {axis, turn(axis, a, b, c)};
    }

    Index corner(Index f, int i) const { return out_.first_equal[soup_.faces[f][i]]; }

    // Adds the points of edge i of f from corner i to the next, both included.
    void add_chain(Index f, int i)
    {
        const Index from = corner(f, i);
        const Index to = corner(f, next(i));
        const Index edge = by_.edge_of[3 * f + i];
        std::vector<Index>& points = chains_.points;
        points.push_back(from);
        if (edge >= 0) {
            const auto list = by_.on_edge[edge];
            if (from < to)
                points.insert(points.end(), list.begin(), list.end());
            else
                points.insert(points.end(), list.rbegin(), list.rend());
        }
        points.push_back(to);
    }

    void triangulate()
    {
        LocalNumbers local(out_.points.size());
        const auto [axis, sign] = view();
        PlanarTriangulation mesh(axis, sign < 0, [&](int a, int b) { return cross(a, b); });
        insert_points(mesh, local);
        keep_edges(mesh, local);
        // Points of nearly parallel planes make slivers that rounding would turn over.
        mesh.improve();
        result_.corners.reserve(mesh.cells().size());
        result_.across.reserve(mesh.cells().size());
        for (const auto& cell : mesh.cells()) {
            result_.corners.push_back(cell.v);
            Triangle across = cell.neighbor;
            for (int i = 0; i < 3; ++i)
                if (cell.carrier[i] != PlanarTriangulation::kNone) across[i] = -1;
            result_.across.push_back(across);
        }
        if (!is_one_plate()) cover_cells(mesh, local, axis, sign);
    }

    // The point where the planes of faces a and b meet in that of the group.
    PointRef cross(Index a, Index b)
    {
        if (a < 0 || b < 0)
            throw Error("mesh_boolean: operand " + std::to_string(soup_.given[first_].operand) +
                        " or another crosses itself near its face " +
                        std::to_string(soup_.given[first_].face));
        result_.created.push_back(std::make_unique<ExactPoint>(
            three_planes(plane_of(soup_, first_), plane_of(soup_, a), plane_of(soup_, b))));
        const ExactPoint& point = *result_.created.back();
        result_.known.push_back(-static_cast<Index>(result_.created.size()));
        return PointRef{point.approximate(), &point};
    }

    void insert_points(PlanarTriangulation& mesh, LocalNumbers& local)
    {
        if (is_one_plate()) {
            number_corners();
            std::vector<PointRef> corners;
            for (const Index p : result_.known) {
                local.set(p, static_cast<Index>(corners.size()));
                corners.push_back(out_.points[p]);
            }
            mesh.start_with_polygon(corners);
        } else {
            start_with_rectangle(mesh);
        }
        const auto insert = [&](Index point) {
            if (local.at(point) >= 0) return;
            local.set(point, mesh.insert(out_.points[point]));
            result_.known.push_back(point);
        };
        std::size_t n_points = chains_.points.size();
        for (const Index f : group_) n_points += by_.in_face[f].size();
        mesh.reserve(n_points);
        if (n_points > kManyPoints) {
            for (const Index p : spread_points(local)) insert(p);
            return;
        }
        for (const Index p : chains_.points) insert(p);
        for (const Index f : group_)
            for (const Index p : by_.in_face[f]) insert(p);
    }

    // Those without a number, each once.
    std::vector<Index> spread_points(LocalNumbers& local) const
    {
        constexpr Index kListed = -2;
        std::vector<Index> points;
        const auto list = [&](Index p) {
            if (local.at(p) != -1) return;
            local.set(p, kListed);
            points.push_back(p);
        };
        for (const Index p : chains_.points) list(p);
        for (const Index f : group_)
            for (const Index p : by_.in_face[f]) list(p);
        sort_along_curve(view().first, out_.points, points);
        return points;
    }

    void start_with_rectangle(PlanarTriangulation& mesh)
    {
        Vec3 low = Box3::filled(1e300);
        Vec3 high = Box3::filled(-1e300);
        for (const Index f : group_)
            for (const Index v : soup_.faces[f])
                for (int k = 0; k < 3; ++k) {
                    low[k] = std::min(low[k], soup_.points[v][k]);
                    high[k] = std::max(high[k], soup_.points[v][k]);
                }
        mesh.start_with_rectangle(low, high);
        result_.known.assign(4, 0);  // never a corner of a covered cell
    }

    void keep_edges(PlanarTriangulation& mesh, const LocalNumbers& local) const
    {
        for (std::size_t h = 0; h < 3 * group_.size(); ++h) {
            if (by_.left_out[3 * group_[h / 3] + h % 3]) continue;
            const auto chain = chains_[h];
            for (std::size_t i = 1; i < chain.size(); ++i)
                mesh.constrain(local.at(chain[i - 1]), local.at(chain[i]), kEdgeCarrier);
        }
        for (const Index f : group_)
            for (const auto& segment : by_.segments[f])
                mesh.constrain(local.at(segment.from), local.at(segment.to), segment.other);
    }

    void cover_cells(const PlanarTriangulation& mesh, const LocalNumbers& local, int axis, int sign)
    {
        result_.one_covers_all = false;
        covered_.assign(mesh.cells().size(), -1);
        rim_of_.assign(3 * mesh.cells().size(), -1);
        for (std::size_t m = 0; m < group_.size();) {
            const Index flat = flat_of_[group_[m]];
            const Triangle& c = soup_.faces[flat];
            const int way =
                sign * turn(axis, soup_.points[c[0]], soup_.points[c[1]], soup_.points[c[2]]);
            rim_.clear();
            for (; m < group_.size() && flat_of_[group_[m]] == flat; ++m)
                for (int e = 0; e < 3; ++e)
                    if (!by_.left_out[3 * group_[m] + e])
                        add_to_rim(mesh, chains_[3 * m + e], local, way);
            for (const auto& [cell, edge] : rim_) rim_of_[3 * cell + edge] = flat;
            cover(mesh, {flat, way});
        }
        std::sort(result_.covers.begin(), result_.covers.end(), [](const auto& a, const auto& b) {
            return std::tie(a.cell, a.cover.face) < std::tie(b.cell, b.cover.face);
        });
    }

    void add_to_rim(const PlanarTriangulation& mesh, std::span<const Index> chain,
                    const LocalNumbers& local, int way)
    {
        for (std::size_t i = 1; i < chain.size(); ++i) {
            int a = local.at(chain[i - 1]);
            int b = local.at(chain[i]);
            if (way < 0) std::swap(a, b);
            const auto edge = mesh.find_edge(a, b);
            if (edge[0] < 0) throw Error("mesh_boolean: an edge was lost in its plane");
            rim_.push_back(edge);
        }
    }

    // Floods the cells of one flat from its rim.
    void cover(const PlanarTriangulation& mesh, Arrangement::Cover what)
    {
        std::vector<int> stack;
        const auto enter = [&](int cell) {
            if (cell < 0) throw Error("mesh_boolean: a plane region is open");
            if (covered_[cell] == what.face) return;
            covered_[cell] = what.face;
            result_.covers.push_back({cell, what});
            stack.push_back(cell);
        };
        for (const auto& edge : rim_) enter(edge[0]);
        while (!stack.empty()) {
            const int cell = stack.back();
            stack.pop_back();
            for (int i = 0; i < 3; ++i)
                if (rim_of_[3 * cell + i] != what.face) enter(mesh.cells()[cell].neighbor[i]);
        }
    }

    const Soup& soup_;
    const Incidence& by_;
    const Arrangement& out_;
    const std::vector<Index>& flat_of_;
    std::span<const Index> group_;
    Index first_;  // stands for the plane
    Chains chains_;
    std::vector<std::array<int, 2>> rim_;  // cells and edges
    std::vector<Index> covered_;           // by cell: by which flat, the last one
    std::vector<Index> rim_of_;            // by edge of a cell: of which flat, the last one
    GroupCells result_;
};

class Cutter {
public:
    Cutter(const Soup& soup, const Incidence& incidence, Arrangement& out, PointTable& table)
        : soup_(soup), by_(incidence), out_(out), table_(table)
    {
        out_.first_cell.assign(soup_.faces.size(), -1);
    }

    void run()
    {
        group_faces();
        cut_groups();
    }

private:
    void group_faces()
    {
        const auto n = static_cast<Index>(soup_.faces.size());
        flat_of_.assign(n, -1);
        DisjointSets flats = by_.flats;
        DisjointSets sets(n);
        for (const auto& [f, g] : by_.coplanar) sets.unite(f, g);
        for (Index f = 0; f < n; ++f) {
            if (out_.passive[f] || (!out_.buried.empty() && out_.buried[f] != 0)) continue;
            flat_of_[f] = flats.find(f);
            sets.unite(f, flat_of_[f]);
        }
        std::vector<Lists<Index>::Keyed> members;
        for (Index f = 0; f < n; ++f)
            if (flat_of_[f] >= 0) members.push_back({sets.find(f), f});
        groups_ = Lists<Index>(n, members);
        for (Index f = 0; f < n; ++f) {
            const std::span<Index> group = groups_[f];
            if (group.empty()) continue;
            roots_.push_back(f);
            std::sort(group.begin(), group.end(), [&](Index a, Index b) {
                return std::pair(flat_of_[a], a) < std::pair(flat_of_[b], b);
            });
        }
    }

    void cut_groups()
    {
        std::vector<GroupCells> cut(roots_.size());
        parallel_for(roots_.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g)
                cut[g] = GroupCutter(soup_, by_, out_, flat_of_, groups_[roots_[g]]).run();
        });
        for (std::size_t g = 0; g < roots_.size(); ++g) {
            collect(cut[g], groups_[roots_[g]]);
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

    void collect(const GroupCells& group, std::span<const Index> faces)
    {
        std::vector<Index> number(group.known.size());
        for (std::size_t i = 0; i < number.size(); ++i)
            number[i] = group.known[i] >= 0 ? group.known[i]
                                            : table_.add(*group.created[-1 - group.known[i]]);
        const std::size_t first = out_.cells.size();
        std::size_t next_cover = 0;
        std::vector<Index> place(group.corners.size(), -1);
        for (std::size_t c = 0; c < group.corners.size(); ++c) {
            const auto is_of_cell = [&] {
                return next_cover < group.covers.size() &&
                       group.covers[next_cover].cell == static_cast<Index>(c);
            };
            if (!group.one_covers_all && !is_of_cell()) continue;
            place[c] = static_cast<Index>(out_.cells.size());
            const Index face = group.is_whole ? faces[c] : faces[0];
            Arrangement::Cell cell;
            for (int i = 0; i < 3; ++i) cell.corners[i] = number[group.corners[c][i]];
            cell.plane = face;
            cell.across = group.across[c];
            cell.covers_begin = static_cast<Index>(out_.covers.size());
            if (group.one_covers_all) cover_cell({face, 1});
            for (; is_of_cell(); ++next_cover) cover_cell(group.covers[next_cover].cover);
            cell.covers_end = static_cast<Index>(out_.covers.size());
            out_.cells.push_back(cell);
        }
        out_.group_end.resize(out_.cells.size(), static_cast<Index>(out_.cells.size()));
        for (std::size_t c = first; c < out_.cells.size(); ++c)
            for (Index& other : out_.cells[c].across)
                if (other >= 0) other = place[other];
    }

    const Soup& soup_;
    const Incidence& by_;
    Arrangement& out_;
    PointTable& table_;
    std::vector<Index> flat_of_;  // by face; the first face of a flat stands for it
    Lists<Index> groups_;         // by their first face
    std::vector<Index> roots_;    // those that have faces
};

}  // namespace

void cut_faces(const Soup& soup, const Incidence& incidence, Arrangement& out, PointTable& table)
{
    Cutter(soup, incidence, out, table).run();
}

}  // namespace genus::exact
