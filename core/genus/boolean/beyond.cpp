#include "genus/boolean/beyond.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

}  // namespace

void Beyond::add_hits(const Ray& ray, std::vector<std::pair<Index, Index>>& hits)
{
    if (++n_rays_ > kRaysOneByOne) {
        if (item_.empty()) grow_tree();
        tree_.query(box_of_ray(ray), [&](Index i) { add_hit(ray, item_[i], hits); });
        return;
    }
    const CellGrid::Column column = grid_.column(ray.axis, ray.start);
    for (std::size_t f = 0; f < tract_.size(); ++f)
        if (tract_[f] != kSought && grid_.may_touch(column, whole_.faces[f]))
            add_hit(ray, static_cast<Index>(f), hits);
}

void Beyond::add_hit(const Ray& ray, Index f, std::vector<std::pair<Index, Index>>& hits) const
{
    const Triangle& t = whole_.faces[f];
    const int sign = hit(ray, whole_.points[t[0]], whole_.points[t[1]], whole_.points[t[2]]);
    if (sign != 0) hits.push_back({whole_.operand[f], sign});
}

void Beyond::grow_tree()
{
    std::vector<FloatBox> boxes;
    for (std::size_t f = 0; f < tract_.size(); ++f) {
        if (tract_[f] == kSought) continue;
        const Triangle& t = whole_.faces[f];
        item_.push_back(static_cast<Index>(f));
        boxes.push_back(box_of(whole_.points[t[0]], whole_.points[t[1]], whole_.points[t[2]]));
    }
    tree_ = BoxTree(std::move(boxes), {});
}

namespace {

// Puts the faces of a solved zone and of the tracts that are kept together.
class Joiner {
public:
    Joiner(const Soup& whole, const std::vector<Index>& tract, const std::vector<Index>& face,
           const std::vector<Index>& point, const Solved& zone)
        : whole_(whole),
          tract_(tract),
          face_(face),
          point_(point),
          zone_(zone),
          n_left_(zone.rim.sources.size()),
          n_plain_(zone.rim.on_rim.size()),
          number_(whole.points.size(), -1),
          plain_(n_plain_, -1)
    {
    }

    bool join(Solved& out)
    {
        out_ = &out;
        // First what was left as it was, in order.
        std::size_t next = 0;
        for (std::size_t f = 0; f < tract_.size(); ++f) {
            if (tract_[f] >= 0) {
                if (zone_.rim.tracts[tract_[f]] != 0) add_far(static_cast<Index>(f));
            } else if (next < n_left_ && face_[zone_.rim.sources[next]] == static_cast<Index>(f)) {
                add_near(next++);
            }
        }
        for (std::size_t f = n_left_; f < zone_.faces.size(); ++f) add_near(f);
        number_others();
        return n_round_ == n_corners_;
    }

    // By how much the faces and points after those of the rim have moved on.
    std::size_t faces_added() const { return out_->faces.size() - zone_.faces.size(); }
    std::size_t n_plain() const { return n_plain_now_; }

private:
    void add_far(Index f)
    {
        Triangle corners{3 * f, 3 * f + 1, 3 * f + 2};
        if (zone_.rim.tracts[tract_[f]] < 0) std::swap(corners[1], corners[2]);
        Triangle t;
        for (int i = 0; i < 3; ++i) {
            const Index h = corners[i];
            const Index p = whole_.faces[f][h % 3];
            t[i] = number_of_plain(number_[p], p);
            if (number_[p] >= static_cast<Index>(is_followed_.size()))
                is_followed_.resize(number_[p] + 1, 0);
            if (!is_followed_[number_[p]]) {
                is_followed_[number_[p]] = 1;
                n_round_ += faces_round(h);
            }
        }
        n_corners_ += 3;
        out_->faces.push_back(t);
        out_->given.push_back(whole_.given[f]);
    }

    // Points that are not plain keep their numbers, as -1 - number, for the time being.
    void add_near(std::size_t f)
    {
        Triangle t = zone_.faces[f];
        for (Index& v : t) {
            if (v >= static_cast<Index>(n_plain_)) {
                v = -1 - v;
                continue;
            }
            const Index at_rim = zone_.rim.on_rim[v];
            if (at_rim >= 0) ++n_corners_;
            v = at_rim >= 0 ? number_of_plain(number_[point_[at_rim]], point_[at_rim])
                            : number_of_plain(plain_[v], zone_.points[v]);
        }
        out_->faces.push_back(t);
        out_->given.push_back(zone_.given[f]);
    }

    Index number_of_plain(Index& known, Index point)
    {
        return number_of_plain(known, whole_.points[point]);
    }
    Index number_of_plain(Index& known, const Vec3& p)
    {
        if (known < 0) {
            known = static_cast<Index>(out_->points.size());
            out_->points.push_back(p);
        }
        return known;
    }

    void number_others()
    {
        n_plain_now_ = out_->points.size();
        out_->points.insert(out_->points.end(),
                            zone_.points.begin() + static_cast<std::ptrdiff_t>(n_plain_),
                            zone_.points.end());
        const auto shift = static_cast<Index>(n_plain_now_ - n_plain_);
        for (Triangle& t : out_->faces)
            for (Index& v : t)
                if (v < 0) v = -1 - v + shift;
    }

    // The number of faces that follow each other round the start of a halfedge.
    std::int64_t faces_round(Index halfedge) const
    {
        std::int64_t n = 0;
        Index h = halfedge;
        do {
            ++n;
            h = whole_.twin[prev_in_face(h)];
        } while (h != halfedge);
        return n;
    }

    const Soup& whole_;
    const std::vector<Index>& tract_;
    const std::vector<Index>& face_;
    const std::vector<Index>& point_;
    const Solved& zone_;
    std::size_t n_left_;
    std::size_t n_plain_;
    std::vector<Index> number_;  // by point of the whole
    std::vector<Index> plain_;   // by point of the solved zone that is not on the rim
    // Corners at points of tracts; and those that were come by going round each such point once.
    std::int64_t n_corners_ = 0, n_round_ = 0;
    std::vector<char> is_followed_;  // by new number
    std::size_t n_plain_now_ = 0;
    Solved* out_ = nullptr;
};

}  // namespace

bool Beyond::add_to(Solved& solved, Rounding& rounding) const
{
    Solved all;
    Joiner joiner(whole_, tract_, face_, point_, solved);
    if (!joiner.join(all)) return false;
    for (Index& f : rounding.turned) f += static_cast<Index>(joiner.faces_added());
    rounding.moved.erase(
        rounding.moved.begin(),
        rounding.moved.begin() + static_cast<std::ptrdiff_t>(solved.rim.on_rim.size()));
    rounding.moved.insert(rounding.moved.begin(), joiner.n_plain(), 0);
    solved.points = std::move(all.points);
    solved.faces = std::move(all.faces);
    solved.given = std::move(all.given);
    return true;
}

}  // namespace genus::exact
