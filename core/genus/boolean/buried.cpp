#include "genus/boolean/buried.h"

#include <algorithm>

#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/boolean/ray.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

// In place of the place of a face in a list.
constexpr Index kNotListed = -1;
constexpr Index kIsBuried = -2;

// Operands outside of which the formula is settled are looked at one by one with all faces.
constexpr std::size_t kMostOutsides = 8;

class Burier {
public:
    Burier(const Soup& soup, const Candidates& candidates, const BooleanFormula& formula,
           Index n_operands)
        : soup_(soup),
          candidates_(candidates),
          settling_(settling_sides(formula, n_operands)),
          boxes_(n_operands),
          buried_(soup.faces.size(), 0)
    {
    }

    std::vector<char> run()
    {
        for (std::size_t f = 0; f < soup_.faces.size(); ++f) {
            const Triangle& t = soup_.faces[f];
            boxes_[soup_.operand[f]].add(
                box_of(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]));
        }
        list_near();
        bury_inside();
        bury_outside();
        keep_plates_whole();
        std::size_t n_pairs = 0;
        std::size_t n_saved = 0;
        for (const auto& [f, g] : candidates_.pairs) {
            if (soup_.operand[f] == soup_.operand[g]) continue;
            ++n_pairs;
            n_saved += buried_[f] || buried_[g];
        }
        if (2 * n_saved < n_pairs || n_saved == 0) return {};
        return std::move(buried_);
    }

private:
    // Faces of others that may meet those of an operand, by operand.
    void list_near()
    {
        near_start_.assign(boxes_.size() + 1, 0);
        const Plates& plates = candidates_.tree.plates();
        const auto for_each = [&](const auto& use) {
            const auto use_plate = [&](Index operand, Index f) {
                use(operand, f);
                if (const Index g = plates.other(soup_, f); g >= 0) use(operand, g);
            };
            for (const auto& [f, g] : candidates_.pairs) {
                if (soup_.operand[f] == soup_.operand[g]) continue;
                use_plate(soup_.operand[f], g);
                use_plate(soup_.operand[g], f);
            }
        };
        for_each([&](Index operand, Index) { ++near_start_[operand + 1]; });
        for (std::size_t i = 1; i < near_start_.size(); ++i) near_start_[i] += near_start_[i - 1];
        near_.resize(near_start_.back());
        std::vector<std::size_t> fill(near_start_.begin(), near_start_.end() - 1);
        for_each([&](Index operand, Index f) { near_[fill[operand]++] = f; });
    }

    void bury_inside()
    {
        constexpr std::size_t kChunks = 32;
        const std::size_t grain = boxes_.size() / kChunks + 1;
        std::vector<std::vector<Index>> found(kChunks);
        parallel_for(boxes_.size(), grain, [&](std::size_t begin, std::size_t end) {
            std::vector<Index> place(soup_.faces.size(), kNotListed);
            for (std::size_t b = begin; b < end; ++b)
                if (settling_[b].inside)
                    list_on_side(static_cast<Index>(b), true, place, found[begin / grain]);
        });
        for (const auto& list : found)
            for (const Index f : list) buried_[f] = 1;
    }

    void bury_outside()
    {
        std::vector<Index> outsides;
        for (std::size_t b = 0; b < boxes_.size(); ++b)
            if (settling_[b].outside) outsides.push_back(static_cast<Index>(b));
        const auto size = [&](Index b) {
            double product = 1.0;
            for (int k = 0; k < 3; ++k)
                product *= std::max(0.0, static_cast<double>(boxes_[b].high[k]) - boxes_[b].low[k]);
            return product;
        };
        std::sort(outsides.begin(), outsides.end(),
                  [&](Index a, Index b) { return std::pair(size(a), a) < std::pair(size(b), b); });
        if (outsides.size() > kMostOutsides) outsides.resize(kMostOutsides);
        std::vector<Index> place(soup_.faces.size(), kNotListed);
        std::vector<Index> found;
        for (const Index b : outsides) {
            list_on_side(b, false, place, found);
            for (std::size_t f = 0; f < soup_.faces.size(); ++f) {
                const Triangle& t = soup_.faces[f];
                if (!box_of(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]])
                         .overlaps(boxes_[b]))
                    buried_[f] = 1;
            }
        }
        for (const Index f : found) buried_[f] = 1;
    }

    // Lists the faces in the box of operand b that meet none of its faces and lie inside, or
    // outside, of it. `place` has all faces as not listed, but those found before.
    void list_on_side(Index b, bool inside, std::vector<Index>& place,
                      std::vector<Index>& found) const
    {
        current_progress().check();
        std::vector<Index> faces;
        candidates_.tree.query(soup_, boxes_[b], [&](Index f) {
            if (soup_.operand[f] == b || place[f] == kIsBuried) return;
            place[f] = static_cast<Index>(faces.size());
            faces.push_back(f);
        });
        enum : char { kNew, kNear, kDone };
        std::vector<char> state(faces.size(), kNew);
        for (std::size_t i = near_start_[b]; i < near_start_[b + 1]; ++i)
            if (place[near_[i]] >= 0) state[place[near_[i]]] = kNear;
        const std::size_t n_found = found.size();
        std::vector<Index> piece;
        for (std::size_t start = 0; start < faces.size(); ++start) {
            if (state[start] != kNew) continue;
            piece.assign(1, faces[start]);
            state[start] = kDone;
            bool leaves_box = false;
            for (std::size_t i = 0; i < piece.size(); ++i)
                for (int e = 0; e < 3; ++e) {
                    const Index h = soup_.twin[3 * piece[i] + e];
                    if (h < 0) continue;
                    const Index other = place[h / 3];
                    leaves_box = leaves_box || other == kNotListed;
                    if (other < 0 || state[other] != kNew) continue;
                    state[other] = kDone;
                    piece.push_back(h / 3);
                }
            if ((!leaves_box && holds(b, faces[start])) == inside)
                found.insert(found.end(), piece.begin(), piece.end());
        }
        for (const Index f : faces) place[f] = kNotListed;
        for (std::size_t i = n_found; i < found.size(); ++i) place[found[i]] = kIsBuried;
    }

    void keep_plates_whole()
    {
        for (std::size_t f = 0; f < buried_.size(); ++f) {
            const Index g = candidates_.tree.plates().other(soup_, static_cast<Index>(f));
            if (g >= 0 && !buried_[g]) buried_[f] = 0;
        }
    }

    // Does operand b, whose faces f does not meet, wind round it?
    bool holds(Index b, Index f) const
    {
        const Ray ray = ray_from(soup_, f);
        Index winding = 0;
        candidates_.tree.query(soup_, box_of_ray(ray), [&](Index g) {
            if (soup_.operand[g] != b) return;
            const Triangle& t = soup_.faces[g];
            winding += hit(ray, soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]);
        });
        return winding != 0;
    }

    const Soup& soup_;
    const Candidates& candidates_;
    std::vector<SettlingSides> settling_;
    std::vector<FloatBox> boxes_;  // by operand
    std::vector<std::size_t> near_start_;
    std::vector<Index> near_;
    std::vector<char> buried_;
};

}  // namespace

std::vector<char> find_buried(const Soup& soup, const Candidates& candidates,
                              const BooleanFormula& formula, std::int32_t n_operands)
{
    return Burier(soup, candidates, formula, n_operands).run();
}

}  // namespace genus::exact
