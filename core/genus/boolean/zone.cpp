#include "genus/boolean/zone.h"

#include <algorithm>

#include "genus/base/parallel.h"
#include "genus/boolean/cell_grid.h"
#include "genus/boolean/plates.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

constexpr std::size_t kFewFaces = 4096;  // not worth a zone
constexpr std::size_t kLeastSaved = 2;   // a zone holds at most one face in so many
constexpr std::size_t kGrain = 65536;
// Cells gone through, for each face: large faces have many.
constexpr std::size_t kMostCells = 16;

class Finder {
public:
    Finder(const Soup& whole, const std::vector<Index>& owners, double reach)
        : whole_(whole),
          owners_(owners),
          reach_(reach),
          grid_(whole.points, n_cells_for(whole.faces.size())),
          has_open_edges_(std::find(whole.twin.begin(), whole.twin.end(), -1) != whole.twin.end())
    {
    }

    std::optional<Zone> run(bool by_operands)
    {
        if (by_operands) {
            if (!mark(whole_.operand)) return std::nullopt;
            find_close();
            if (!saves_much()) return std::nullopt;
        }
        if (!mark(owners_)) return std::nullopt;
        find_close();
        if (!by_operands && !saves_much()) return std::nullopt;
        follow_planes();
        mark_surroundings();
        find_surroundings();
        if (!by_operands && !saves_much()) return std::nullopt;
        find_tracts();
        return make_zone();
    }

private:
    // A face may be near others to be cut; or just come along.
    enum : char { kFar, kClose, kAround };
    // What a cell holds beside the number of an owner.
    enum : Index { kEmpty = -1, kMixed = -2, kSurrounding = -3 };
    static constexpr Index kUnknown = -3;

    // Small cells let fewer faces pass for close; many of them do not fit into a cache.
    static std::size_t n_cells_for(std::size_t n_faces)
    {
        return std::max(2 * n_faces, std::min<std::size_t>(8 * n_faces, 1u << 19));
    }

    std::size_t n_faces() const { return whole_.faces.size(); }

    // Cells by the number that all their faces have. False if faces have too many cells.
    bool mark(const std::vector<Index>& label)
    {
        cells_.assign(grid_.n_cells(), kEmpty);
        set_cells_.clear();
        wide_.clear();
        std::size_t n_seen = 0;
        for (std::size_t f = 0; f < n_faces() && n_seen <= kMostCells * n_faces(); ++f) {
            const Index number = label[f];
            const Triangle& t = whole_.faces[f];
            const CellGrid::Range range = grid_.range(t);
            if (!range.is_small()) wide_.push_back(static_cast<Index>(f));
            grid_.visit_until(t, range, 0.0, [&](std::size_t cell) {
                ++n_seen;
                Index& known = cells_[cell];
                if (known == kEmpty && number >= 0)
                    known = number;
                else if ((known != number || number < 0) && known != kMixed)
                    set(cell, kMixed);
                return false;
            });
        }
        return n_seen <= kMostCells * n_faces();
    }

    void set(std::size_t cell, Index kind)
    {
        cells_[cell] = kind;
        set_cells_.push_back(cell);
    }

    // Faces at edges that do not join exactly two are always cut.
    bool has_open_edge(std::size_t f) const
    {
        const Index* twin = whole_.twin.data() + 3 * f;
        return twin[0] < 0 || twin[1] < 0 || twin[2] < 0;
    }

    bool has_cell(std::size_t f, Index kind) const
    {
        const Triangle& t = whole_.faces[f];
        return grid_.visit_until(t, grid_.range(t), 0.0,
                                 [&](std::size_t cell) { return cells_[cell] == kind; });
    }

    // Calls use(f) for the faces that touch cells of a kind, which are those that were set.
    template <class Use>
    void for_those_at(Index kind, const Use& use) const
    {
        const std::vector<char> maybe = grid_.with_neighbours(set_cells_);
        parallel_for(n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f)
                if (maybe[grid_.cell_of(whole_.faces[f][0])] && has_cell(f, kind)) use(f);
        });
        for (const Index f : wide_)
            if (has_cell(f, kind)) use(f);
    }

    void find_close()
    {
        near_.assign(n_faces(), kFar);
        for_those_at(kMixed, [&](std::size_t f) { near_[f] = kClose; });
        for (std::size_t f = 0; has_open_edges_ && f < n_faces(); ++f)
            if (has_open_edge(f)) near_[f] = kClose;
    }

    bool saves_much() const
    {
        const auto n_far = static_cast<std::size_t>(std::count(near_.begin(), near_.end(), kFar));
        return (n_faces() - n_far) * kLeastSaved <= n_faces();
    }

    // What continues the plane of a close face may become one face with it.
    void follow_planes()
    {
        std::vector<Index> stack;
        for (std::size_t f = 0; f < n_faces(); ++f)
            if (near_[f] == kClose) stack.push_back(static_cast<Index>(f));
        while (!stack.empty()) {
            const Index f = stack.back();
            stack.pop_back();
            for (Index h = 3 * f; h < 3 * f + 3; ++h) {
                const Index twin = whole_.twin[h];
                if (twin < 0 || near_[twin / 3] == kClose || !same_plane(whole_, h)) continue;
                near_[twin / 3] = kClose;
                stack.push_back(twin / 3);
            }
        }
    }

    void mark_surroundings()
    {
        set_cells_.clear();
        for (std::size_t f = 0; f < n_faces(); ++f) {
            if (near_[f] != kClose) continue;
            const Triangle& t = whole_.faces[f];
            grid_.visit_until(t, grid_.range(t, reach_), reach_, [&](std::size_t cell) {
                if (cells_[cell] != kSurrounding) set(cell, kSurrounding);
                return false;
            });
        }
    }

    void find_surroundings()
    {
        for_those_at(kSurrounding, [&](std::size_t f) {
            if (near_[f] == kFar) near_[f] = kAround;
        });
        cells_ = {};
    }

    static bool is_in_zone(Index tract)
    {
        return tract == Beyond::kSought || tract == Beyond::kAround;
    }

    // Numbers the far faces by tract. One with no face of the zone next to it lends its first.
    void find_tracts()
    {
        tract_.resize(n_faces());
        for (std::size_t f = 0; f < n_faces(); ++f)
            tract_[f] = near_[f] == kFar     ? kUnknown
                        : near_[f] == kClose ? Beyond::kSought
                                             : Beyond::kAround;
        std::vector<Index> stack;
        for (Index first = 0; first < static_cast<Index>(n_faces()); ++first) {
            if (tract_[first] != kUnknown) continue;
            bool has_rim = false;
            tract_[first] = n_tracts_;
            stack.push_back(first);
            while (!stack.empty()) {
                const Index f = stack.back();
                stack.pop_back();
                for (Index h = 3 * f; h < 3 * f + 3; ++h) {
                    Index& other = tract_[whole_.twin[h] / 3];
                    has_rim = has_rim || is_in_zone(other);
                    if (other != kUnknown) continue;
                    other = n_tracts_;
                    stack.push_back(whole_.twin[h] / 3);
                }
            }
            if (!has_rim) tract_[first] = Beyond::kAround;
            ++n_tracts_;
        }
    }

    // Numbers stay in order, so that the outcome does not depend on what is left out.
    Zone make_zone()
    {
        Zone zone;
        std::vector<Index> face;  // of the zone: in the whole
        std::vector<Index> place(n_faces(), -1);
        for (std::size_t f = 0; f < n_faces(); ++f) {
            if (!is_in_zone(tract_[f])) continue;
            place[f] = static_cast<Index>(face.size());
            face.push_back(static_cast<Index>(f));
        }
        std::vector<Index> point = add_points(face, zone.soup);
        add_faces(face, zone);
        add_rim(face, place, zone.soup);
        zone.beyond = std::make_unique<Beyond>(whole_, std::move(grid_), std::move(tract_),
                                               std::move(face), std::move(point));
        zone.soup.beyond = zone.beyond.get();
        return zone;
    }

    // Returns their numbers in the whole.
    std::vector<Index> add_points(const std::vector<Index>& face, Soup& soup)
    {
        number_.assign(whole_.points.size(), -1);
        for (const Index f : face)
            for (const Index v : whole_.faces[f]) number_[v] = 0;
        std::vector<Index> point;
        for (std::size_t v = 0; v < number_.size(); ++v) {
            if (number_[v] < 0) continue;
            number_[v] = static_cast<Index>(point.size());
            point.push_back(static_cast<Index>(v));
            soup.points.push_back(whole_.points[v]);
        }
        return point;
    }

    void add_faces(const std::vector<Index>& face, Zone& zone) const
    {
        Soup& soup = zone.soup;
        for (const Index f : face) {
            Triangle t = whole_.faces[f];
            for (Index& v : t) v = number_[v];
            soup.faces.push_back(t);
            soup.operand.push_back(whole_.operand[f]);
            soup.given.push_back(whole_.given[f]);
            zone.owners.push_back(near_[f] == kClose ? owners_[f] : kNotSought);
        }
        soup.crosses_itself = whole_.crosses_itself;
    }

    void add_rim(const std::vector<Index>& face, const std::vector<Index>& place, Soup& soup) const
    {
        soup.n_tracts = n_tracts_;
        soup.on_rim.assign(soup.points.size(), 0);
        for (std::size_t f = 0; f < face.size(); ++f)
            for (int i = 0; i < 3; ++i) {
                const Index h = whole_.twin[3 * face[f] + i];
                const Index tract = h < 0 ? Beyond::kAround : tract_[h / 3];
                soup.twin.push_back(h < 0               ? -1
                                    : is_in_zone(tract) ? 3 * place[h / 3] + h % 3
                                                        : Soup::across_rim(tract));
                if (!is_in_zone(tract))
                    for (const int end : {i, (i + 1) % 3}) soup.on_rim[soup.faces[f][end]] = 1;
            }
    }

    const Soup& whole_;
    const std::vector<Index>& owners_;
    double reach_;
    CellGrid grid_;
    bool has_open_edges_;
    std::vector<Index> cells_;
    std::vector<std::size_t> set_cells_;  // to the kind that is looked for
    std::vector<Index> wide_;             // faces of more than a cell and its neighbours
    std::vector<char> near_;              // by face
    std::vector<Index> tract_;            // by face
    Index n_tracts_ = 0;
    std::vector<Index> number_;  // by point of the whole: in the zone
};

}  // namespace

std::optional<Zone> find_zone(const Soup& whole, const std::vector<Index>& owners, double reach,
                              bool by_operands)
{
    if (whole.faces.size() < kFewFaces) return std::nullopt;
    return Finder(whole, owners, reach).run(by_operands);
}

}  // namespace genus::exact
