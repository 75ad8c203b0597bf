#include "genus/boolean/surviving.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "genus/boolean/contact.h"

namespace genus::exact {

namespace {

using Index = std::int32_t;

constexpr std::size_t kFaces = 256;
constexpr std::size_t kMeetingsOfAFace = 4;
constexpr double kAside = 1e-6;  // of the size of everything

class Survey {
public:
    Survey(const Soup& soup, const PlateTree& tree, const std::vector<char>& united)
        : soup_(soup), tree_(tree), united_(united)
    {
        double size = 0.0;
        for (const Vec3& p : soup.points)
            for (int k = 0; k < 3; ++k) size = std::max(size, std::abs(p[k]));
        aside_ = kAside * size;
    }

    double share()
    {
        const std::size_t n = soup_.faces.size();
        // Not the same faces of boxes each time.
        std::size_t step = n / kFaces + 1;
        while (step % 2 == 0 || step % 3 == 0) ++step;
        for (std::size_t f = 0; f < n; f += step)
            if (united_[soup_.operand[f]]) look_round(static_cast<Index>(f));
        return n_seen_ == 0 ? 0.0 : static_cast<double>(n_left_) / static_cast<double>(n_seen_);
    }

private:
    void look_round(Index f)
    {
        std::vector<Index> near;
        const Triangle& t = soup_.faces[f];
        tree_.query(soup_, box_of(soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]),
                    [&](Index g) {
                        if (soup_.operand[g] != soup_.operand[f] && united_[soup_.operand[g]])
                            near.push_back(g);
                    });
        std::size_t n_found = 0;
        const std::size_t step = near.size() / (4 * kMeetingsOfAFace) + 1;
        for (std::size_t i = 0; i < near.size() && n_found < kMeetingsOfAFace; i += step) {
            Vec3 p;
            if (!crossing(f, near[i], p)) continue;
            ++n_found;
            ++n_seen_;
            const Vec3 out = normalized(normal(f)) + normalized(normal(near[i]));
            if (!lies_in_another(p + aside_ * out, soup_.operand[f], soup_.operand[near[i]]))
                ++n_left_;
        }
    }

    Vec3 normal(Index f) const
    {
        const Triangle& t = soup_.faces[f];
        const Vec3& a = soup_.points[t[0]];
        return cross(soup_.points[t[1]] - a, soup_.points[t[2]] - a);
    }

    // The middle of what the faces have in common, if that is a piece of a line inside both.
    bool crossing(Index f, Index g, Vec3& middle) const
    {
        Corners a = corners_of(soup_, f);
        Corners b = corners_of(soup_, g);
        number_corners(a, b);
        if (certainly_apart(a, b)) return false;
        const Contact contact = find_contact(a, b);
        if (contact.coplanar || contact.n_events != 2) return false;
        const auto [first, second] = std::pair(contact.events[0], contact.events[1]);
        if (edge_along(a, first.on_f, second.on_f) >= 0 ||
            edge_along(b, first.on_g, second.on_g) >= 0)
            return false;
        middle = 0.5 * place(a, b, first) + 0.5 * place(a, b, second);
        return true;
    }

    static Vec3 place(const Corners& f, const Corners& g, const Contact::Event& e)
    {
        if (Contact::is_corner(e.on_f)) return *f.at[e.on_f];
        if (Contact::is_corner(e.on_g)) return *g.at[e.on_g];
        if (e.on_g == Contact::kInside) return on_plane(f, e.on_f - Contact::kEdge, g);
        return on_plane(g, e.on_g - Contact::kEdge, f);
    }

    // Where edge i of f meets the plane of g, or its middle if it lies in it.
    static Vec3 on_plane(const Corners& f, int i, const Corners& g)
    {
        const Vec3& p = *f.at[i];
        const Vec3& q = *f.at[f.next(i)];
        const Vec3 n = cross(*g.at[1] - *g.at[0], *g.at[2] - *g.at[0]);
        const double at_p = dot(n, p - *g.at[0]);
        const double at_q = dot(n, q - *g.at[0]);
        const double t = at_p == at_q ? 0.5 : std::clamp(at_p / (at_p - at_q), 0.0, 1.0);
        return p + t * (q - p);
    }

    // Does any of the operands in question but a and b wind round p?
    bool lies_in_another(const Vec3& p, Index a, Index b) const
    {
        FloatBox up = box_of(p, p, p);
        up.high[2] = 3e38f;
        std::vector<std::pair<Index, int>> hits;
        tree_.query(soup_, up, [&](Index f) {
            const Index operand = soup_.operand[f];
            if (!united_[operand] || operand == a || operand == b) return;
            if (const int sign = face_above(p, f)) hits.push_back({operand, sign});
        });
        std::sort(hits.begin(), hits.end());
        for (std::size_t begin = 0, end = 0; begin < hits.size(); begin = end) {
            int winding = 0;
            for (; end < hits.size() && hits[end].first == hits[begin].first; ++end)
                winding += hits[end].second;
            if (winding != 0) return true;
        }
        return false;
    }

    // The sign of its normal upwards, if face f lies above p.
    int face_above(const Vec3& p, Index f) const
    {
        const Triangle& t = soup_.faces[f];
        const Vec3 a = soup_.points[t[0]] - p;
        const Vec3 b = soup_.points[t[1]] - p;
        const Vec3 c = soup_.points[t[2]] - p;
        const double ab = a[0] * b[1] - a[1] * b[0];
        const double bc = b[0] * c[1] - b[1] * c[0];
        const double ca = c[0] * a[1] - c[1] * a[0];
        const int sign = ab > 0.0 ? 1 : -1;
        if (sign * bc <= 0.0 || sign * ca <= 0.0 || ab == 0.0) return 0;
        return sign * (bc * a[2] + ca * b[2] + ab * c[2]) > 0.0 ? sign : 0;
    }

    const Soup& soup_;
    const PlateTree& tree_;
    const std::vector<char>& united_;
    double aside_ = 0.0;
    std::size_t n_seen_ = 0;
    std::size_t n_left_ = 0;
};

}  // namespace

double surviving_share(const Soup& soup, const PlateTree& tree, const std::vector<char>& united)
{
    return Survey(soup, tree, united).share();
}

}  // namespace genus::exact
