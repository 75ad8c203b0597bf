#include "genus/boolean/winding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/boolean/beyond.h"
#include "genus/boolean/lists.h"
#include "genus/boolean/ray.h"
#include "genus/boolean/sheets.h"
#include "genus/mesh/disjoint_sets.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

int next(int i)
{
    return i == 2 ? 0 : i + 1;
}

std::uint64_t random_of(Index operand)
{
    std::uint64_t h = static_cast<std::uint64_t>(operand) + 0x9E3779B97F4A7C15ull;
    for (int i = 0; i < 3; ++i) {
        h ^= h >> 30;
        h *= 0xBF58476D1CE4E5B9ull;
        h ^= h >> 27;
    }
    return h;
}

class Selector {
public:
    Selector(const Soup& soup, const Arrangement& arrangement, const BooleanFormula& formula,
             Index n_operands, InsideRule rule)
        : soup_(soup),
          cut_(arrangement),
          rule_(rule),
          n_cells_(static_cast<Index>(arrangement.cells.size())),
          formula_(formula, n_operands),
          winding_(n_operands, 0)
    {
    }

    std::optional<Selection> run()
    {
        find_patches();
        number_items();
        sides_ = DisjointSets(2 * n_items());
        join_sides();
        if (cut_.buried.empty()) {
            list_items();
            follow_regions();
        } else if (!look_into_regions()) {
            return std::nullopt;
        }
        return decide();
    }

private:
    // Items are the cells, as many at a time as only free edges part, then the patches of passive
    // faces. Item i has sides 2i (front) and 2i + 1 (back).
    Index n_items() const { return n_pieces() + static_cast<Index>(patch_face_.size()); }
    Index n_pieces() const { return static_cast<Index>(first_cell_.size()); }

    void number_items()
    {
        item_.assign(n_cells_, -1);
        std::vector<Index> stack;
        for (Index c = 0; c < n_cells_; ++c) {
            if (item_[c] >= 0) continue;
            const Index item = n_pieces();
            first_cell_.push_back(c);
            item_[c] = item;
            stack.push_back(c);
            while (!stack.empty()) {
                const Index at = stack.back();
                stack.pop_back();
                for (const Index other : cut_.cells[at].across) {
                    if (other < 0 || item_[other] >= 0) continue;
                    item_[other] = item;
                    stack.push_back(other);
                }
            }
        }
    }

    void find_patches()
    {
        patch_.assign(soup_.faces.size(), -1);
        patch_of_tract_.assign(soup_.n_tracts, -1);
        const Lists<Index> along_rim = faces_by_tract();
        std::vector<Index> stack;
        Index patch = 0;
        const auto enter = [&](Index f) {
            if (!cut_.passive[f] || patch_[f] >= 0) return;
            patch_[f] = patch;
            stack.push_back(f);
        };
        for (Index f = 0; f < static_cast<Index>(soup_.faces.size()); ++f) {
            if (!cut_.passive[f] || patch_[f] >= 0) continue;
            patch = static_cast<Index>(patch_face_.size());
            patch_face_.push_back(f);
            enter(f);
            while (!stack.empty()) {
                const Index at = stack.back();
                stack.pop_back();
                for (int i = 0; i < 3; ++i) {
                    const Index h = soup_.twin[3 * at + i];  // passive: there is one
                    if (h >= 0) {
                        enter(h / 3);
                        continue;
                    }
                    Index& known = patch_of_tract_[Soup::tract_across(h)];
                    if (known >= 0) continue;
                    known = patch;
                    for (const Index f_at_rim : along_rim[Soup::tract_across(h)]) enter(f_at_rim);
                }
            }
        }
    }

    Lists<Index> faces_by_tract() const
    {
        std::vector<Lists<Index>::Keyed> at_rim;
        for (std::size_t h = 0; soup_.n_tracts > 0 && h < soup_.twin.size(); ++h)
            if (soup_.twin[h] < -1)
                at_rim.push_back({Soup::tract_across(soup_.twin[h]), static_cast<Index>(h / 3)});
        return {static_cast<std::size_t>(soup_.n_tracts), at_rim};
    }

    Index corner(Index f, int i) const { return cut_.first_equal[soup_.faces[f][i]]; }

    void add_sheet(Index a, Index b, Index item, Index plane)
    {
        sheets_.push_back({edge_key(a, b), item, plane, false, a < b});
    }

    void join_sides()
    {
        for (Index c = 0; c < n_cells_; ++c) {
            const auto& cell = cut_.cells[c];
            for (int i = 0; i < 3; ++i)
                if (cell.across[i] < 0)
                    add_sheet(cell.corners[i], cell.corners[next(i)], item_[c], cell.plane);
        }
        for (Index f = 0; f < static_cast<Index>(soup_.faces.size()); ++f) {
            if (cut_.passive[f]) continue;
            for (int i = 0; i < 3; ++i) {
                const Index h = soup_.twin[3 * f + i];
                if (h >= 0 && cut_.passive[h / 3])
                    add_sheet(corner(f, next(i)), corner(f, i), n_pieces() + patch_[h / 3], h / 3);
            }
        }
        sort_sheets(sheets_);
        for (std::size_t begin = 0; begin < sheets_.size();) {
            std::size_t end = begin + 1;
            while (end < sheets_.size() && sheets_[end].edge == sheets_[begin].edge) ++end;
            join_round_edge(begin, end);
            begin = end;
        }
        sheets_ = {};
    }

    void join_round_edge(std::size_t begin, std::size_t end)
    {
        if (end - begin > 2)
            sort_round_edge(soup_, cut_.points, sheets_.data() + begin, sheets_.data() + end);
        for (std::size_t s = begin; s < end; ++s) {
            const Sheet& a = sheets_[s];
            const Sheet& b = sheets_[s + 1 < end ? s + 1 : begin];
            sides_.unite(2 * a.item + (a.forward ? 0 : 1), 2 * b.item + (b.forward ? 1 : 0));
        }
    }

    // Items by region.
    void list_items()
    {
        item_start_.assign(2 * n_items() + 1, 0);
        for (Index side = 0; side < 2 * n_items(); ++side) ++item_start_[sides_.find(side) + 1];
        for (std::size_t i = 1; i < item_start_.size(); ++i) item_start_[i] += item_start_[i - 1];
        items_.resize(2 * n_items());
        std::vector<Index> fill(item_start_.begin(), item_start_.end() - 1);
        for (Index side = 0; side < 2 * n_items(); ++side) items_[fill[sides_.find(side)]++] = side;
    }

    bool inside(Index winding) const
    {
        return rule_ == InsideRule::NonZero ? winding != 0 : winding > 0;
    }

    void change(Index operand, Index by)
    {
        const bool was = inside(winding_[operand]);
        winding_[operand] += by;
        print_ += static_cast<std::uint64_t>(static_cast<std::int64_t>(by)) * random_of(operand);
        if (inside(winding_[operand]) != was) formula_.set(operand, !was);
    }

    // Goes through an item, from its front to its back if `way` is 1.
    void cross(Index item, Index way)
    {
        if (item >= n_pieces()) {
            change(soup_.operand[patch_face_[item - n_pieces()]], way);
            return;
        }
        const auto& cell = cut_.cells[first_cell_[item]];
        for (Index c = cell.covers_begin; c < cell.covers_end; ++c)
            change(soup_.operand[cut_.covers[c].face], way * cut_.covers[c].sign);
    }

    struct Step {
        Index region;
        Index item;  // crossed to come here, -1 at the start
        Index way;
        Index next;  // in items_
    };

    void enter(Index region)
    {
        known_[region] = 1;
        holds_[region] = formula_.value();
        prints_[region] = print_;
    }

    void follow_regions()
    {
        known_.assign(2 * n_items(), 0);
        holds_.assign(2 * n_items(), 0);
        prints_.assign(2 * n_items(), 0);
        for (Index item = 0; item < n_items(); ++item) {
            if (known_[sides_.find(2 * item)]) continue;
            current_progress().check();
            const Seed seed = shoot(item);
            for (const auto& [operand, count] : seed.winding) change(operand, count);
            follow_from(sides_.find(seed.side));
            for (const auto& [operand, count] : seed.winding) change(operand, -count);
        }
    }

    void follow_from(Index start)
    {
        std::vector<Step> steps{{start, -1, 0, item_start_[start]}};
        enter(start);
        while (!steps.empty()) {
            Step& step = steps.back();
            if (step.next == item_start_[step.region + 1]) {
                if (step.item >= 0) cross(step.item, -step.way);
                steps.pop_back();
                continue;
            }
            const Index side = items_[step.next++];
            const Index other = sides_.find(side ^ 1);
            if (known_[other]) continue;
            const Index way = side % 2 == 0 ? 1 : -1;
            cross(side / 2, way);
            enter(other);
            steps.push_back({other, side / 2, way, item_start_[other]});
        }
    }

    struct Seed {
        Index side;
        std::vector<std::pair<Index, Index>> winding;  // operand, number
    };

    // Winding numbers on one side of a piece of surface connected to the item.
    Seed shoot(Index item) const
    {
        const Index f = item >= n_pieces()
                            ? patch_face_[item - n_pieces()]
                            : cut_.covers[cut_.cells[first_cell_[item]].covers_begin].face;
        const Ray ray = ray_from(soup_, f);
        Seed seed;
        Index plane = f;
        if (item >= n_pieces()) {
            seed.side = 2 * item;
        } else {
            const Index cell = cell_at_start(ray, f);
            seed.side = 2 * item_[cell];
            plane = cut_.cells[cell].plane;
        }
        const auto& t = soup_.faces[plane];
        if (turn(ray.axis, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]) < 0)
            ++seed.side;
        seed.winding = windings_beyond(ray);
        return seed;
    }

    // The cell over face f into which the ray's start moves.
    Index cell_at_start(const Ray& ray, Index f) const
    {
        const Index corner_f = corner(f, 0);
        const Index first = cut_.first_cell[f];
        for (Index c = first; c < cut_.group_end[first]; ++c) {
            const auto& cell = cut_.cells[c];
            for (int i = 0; i < 3; ++i) {
                if (cell.corners[i] != corner_f) continue;
                const auto& t = soup_.faces[cell.plane];
                const int sign =
                    turn(ray.axis, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
                const auto left_of = [&](Index p) {
                    const PointRef& to = cut_.points[p];
                    const int s = turn_of_vector(ray.axis, ray.start, to, ray.m);
                    return sign * (s != 0 ? s : turn_of_vector(ray.axis, ray.start, to, ray.m2));
                };
                if (left_of(cell.corners[next(i)]) > 0 && left_of(cell.corners[next(next(i))]) < 0)
                    return c;
            }
        }
        throw Error("mesh_boolean: no cell at a corner of a face");
    }

    std::vector<std::pair<Index, Index>> windings_beyond(const Ray& ray) const
    {
        std::vector<std::pair<Index, Index>> hits;
        cut_.tree.query(soup_, box_of_ray(ray), [&](Index f) {
            const auto& t = soup_.faces[f];
            const int s = hit(ray, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
            if (s != 0) hits.push_back({soup_.operand[f], s});
        });
        if (soup_.beyond != nullptr) soup_.beyond->add_hits(ray, hits);
        std::sort(hits.begin(), hits.end());
        std::vector<std::pair<Index, Index>> winding;
        for (const auto& [operand, s] : hits) {
            if (winding.empty() || winding.back().first != operand) winding.push_back({operand, 0});
            winding.back().second += s;
        }
        return winding;
    }

    // Faces that are buried were neither cut nor followed: winding numbers change within a region,
    // the value of the formula does not. One look a region, from the first of its items that has
    // room for an upright line. False if there are regions too thin for that.
    bool look_into_regions()
    {
        known_.assign(2 * n_items(), 0);
        holds_.assign(2 * n_items(), 0);
        std::vector<Index> thin;
        const auto look = [&](Index item, Index cell) {
            if (is_seen(item)) return;
            current_progress().check();
            if (!look_from(item, cell)) thin.push_back(item);
        };
        for (Index c = 0; c < n_cells_; ++c) look(item_[c], c);
        for (Index item = n_pieces(); item < n_items(); ++item) look(item, -1);
        return std::all_of(thin.begin(), thin.end(), [&](Index item) { return is_seen(item); });
    }

    // Is the value known on both sides of an item, or the same for sure?
    bool is_seen(Index item)
    {
        const Index front = sides_.find(2 * item);
        const Index back = sides_.find(2 * item + 1);
        return front == back || (known_[front] && known_[back]);
    }

    // Winding numbers just above and below an item, on a line through the inside of one of its
    // cells.
    bool look_from(Index item, Index cell)
    {
        const bool is_cell = item < n_pieces();
        const Index plane = is_cell ? cut_.cells[cell].plane : patch_face_[item - n_pieces()];
        std::array<PointRef, 3> triangle;
        for (int i = 0; i < 3; ++i)
            triangle[i] = is_cell ? cut_.points[cut_.cells[cell].corners[i]]
                                  : PointRef{soup_.points[soup_.faces[plane][i]], nullptr};
        UprightLine line(soup_, plane);
        for (int attempt = 0; attempt < 4; ++attempt) {
            if (!line.pass_through(triangle, point_inside(triangle, attempt))) continue;
            std::vector<std::pair<Index, Index>> above;  // operand, sign
            std::vector<std::pair<Index, Index>> at;
            bool clear = true;
            cut_.tree.query(soup_, line.box(), [&](Index f) {
                const UprightLine::Crossing crossing = line.cross(f);
                clear = clear && crossing.clear;
                if (crossing.sign == 0 || crossing.height < 0) return;
                (crossing.height > 0 ? above : at).push_back({soup_.operand[f], crossing.sign});
            });
            if (!clear) continue;
            const Index up = sides_.find(2 * item + (line.normal_is_up() ? 0 : 1));
            const Index down = sides_.find(2 * item + (line.normal_is_up() ? 1 : 0));
            for (const auto& [operand, sign] : above) change(operand, sign);
            set_value(up);
            for (const auto& [operand, sign] : at) change(operand, sign);
            set_value(down);
            for (const auto& [operand, sign] : at) change(operand, -sign);
            for (const auto& [operand, sign] : above) change(operand, -sign);
            return true;
        }
        return false;
    }

    // A grid point that lies inside the triangle where there is room.
    static Vec3 point_inside(const std::array<PointRef, 3>& triangle, int attempt)
    {
        Vec3 p;
        for (int k = 0; k < 3; ++k) {
            double sum = 0.0;
            for (int i = 0; i < 3; ++i)
                sum += triangle[i].approx[k] * (attempt == 0 ? 1.0 / 3.0 : 0.25);
            if (attempt > 0) sum += 0.25 * triangle[attempt - 1].approx[k];
            p[k] = std::nearbyint(sum);
        }
        return p;
    }

    void set_value(Index region)
    {
        known_[region] = 1;
        holds_[region] = formula_.value();
    }

    // Does what lies in front of an item, and the item, make what lies behind it?
    bool windings_agree(Index item)
    {
        print_ = prints_[sides_.find(2 * item)];
        cross(item, 1);
        const bool agree = print_ == prints_[sides_.find(2 * item + 1)];
        cross(item, -1);
        return agree;
    }

    Selection decide()
    {
        Selection selection;
        const auto kept = [&](Index item) -> std::int8_t {
            const Index front = sides_.find(2 * item);
            const Index back = sides_.find(2 * item + 1);
            if (cut_.buried.empty() && !windings_agree(item))
                throw Error("mesh_boolean: winding numbers do not agree across a face of operand " +
                            std::to_string(
                                soup_
                                    .given[item < n_pieces() ? cut_.cells[first_cell_[item]].plane
                                                             : patch_face_[item - n_pieces()]]
                                    .operand));
            if (holds_[front] == holds_[back]) return 0;
            return holds_[back] ? 1 : -1;
        };
        std::vector<std::int8_t> kept_items(n_items());
        for (Index item = 0; item < n_items(); ++item) kept_items[item] = kept(item);
        selection.cells.resize(n_cells_);
        for (Index c = 0; c < n_cells_; ++c) selection.cells[c] = kept_items[item_[c]];
        selection.faces.assign(soup_.faces.size(), 0);
        for (std::size_t f = 0; f < soup_.faces.size(); ++f)
            if (patch_[f] >= 0) selection.faces[f] = kept_items[n_pieces() + patch_[f]];
        for (const Index patch : patch_of_tract_)
            selection.tracts.push_back(kept_items[n_pieces() + patch]);
        return selection;
    }

    const Soup& soup_;
    const Arrangement& cut_;
    InsideRule rule_;
    Index n_cells_;
    FormulaState formula_;
    std::vector<Index> winding_;
    std::uint64_t print_ = 0;  // sum over operands of winding number times a random number

    std::vector<Index> item_;        // of each cell
    std::vector<Index> first_cell_;  // of each item made of cells
    std::vector<Index> patch_;       // of each face, -1 where not passive
    std::vector<Index> patch_face_;  // the first face of each patch
    std::vector<Index> patch_of_tract_;
    std::vector<Sheet> sheets_;
    DisjointSets sides_{0};  // regions: sides that see each other
    std::vector<Index> item_start_;
    std::vector<Index> items_;
    std::vector<char> known_;
    std::vector<char> holds_;
    std::vector<std::uint64_t> prints_;
};

}  // namespace

std::optional<Selection> select(const Soup& soup, const Arrangement& arrangement,
                                const BooleanFormula& formula, std::int32_t n_operands,
                                InsideRule rule)
{
    return Selector(soup, arrangement, formula, n_operands, rule).run();
}

}  // namespace genus::exact
