#include "genus/mesh/aabb_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "genus/base/error.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/mesh/sides.h"

namespace genus {

// ---------------------------------------------------------------------------------------------
// Building

class BoxTree::Builder {
public:
    Builder(BoxTree& tree, std::span<const Box3> boxes) : tree_(tree), boxes_(boxes) {}

    void run()
    {
        sort_by_code();
        const std::size_t n = boxes_.size();
        task_items_ = static_cast<std::int32_t>(std::max<std::size_t>(n / 64, 4096));
        list_tasks(0, static_cast<std::int32_t>(n));
        task_nodes_.resize(tasks_.size());
        parallel_for(tasks_.size(), 1, [&](std::size_t t, std::size_t) {
            build(tasks_[t][0], tasks_[t][1], task_nodes_[t]);
        });
        std::size_t total = 2 * tasks_.size();
        for (const std::vector<Node>& nodes : task_nodes_) total += nodes.size();
        tree_.nodes_.reserve(total);
        join(0, static_cast<std::int32_t>(n));
    }

private:
    struct Key {
        std::uint64_t code;
        std::int32_t item;
    };

    // Spreads 21 bits so that two zeros lie between each and the next.
    static std::uint64_t spread(std::uint64_t x)
    {
        x = (x | x << 32) & 0x001f00000000ffff;
        x = (x | x << 16) & 0x001f0000ff0000ff;
        x = (x | x << 8) & 0x100f00f00f00f00f;
        x = (x | x << 4) & 0x10c30c30c30c30c3;
        x = (x | x << 2) & 0x1249249249249249;
        return x;
    }

    void sort_by_code()
    {
        Box3 centers;
        for (const Box3& box : boxes_) centers.add(box.center());
        // Halves, so that the size of a huge scene does not overflow.
        const Vec3 size = 0.5 * centers.max - 0.5 * centers.min;
        const double widest = std::max({size[0], size[1], size[2]});
        constexpr double kSteps = (1 << 21) - 1;
        keys_.resize(boxes_.size());
        parallel_for(boxes_.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 at = 0.5 * boxes_[i].center() - 0.5 * centers.min;
                std::uint64_t code = 0;
                for (std::size_t k = 0; k < 3 && widest > 0.0; ++k) {
                    const double step = std::clamp(at[k] / widest, 0.0, 1.0) * kSteps;
                    code |= spread(static_cast<std::uint64_t>(step)) << k;
                }
                keys_[i] = {code, static_cast<std::int32_t>(i)};
            }
        });
        sort_keys();
        tree_.items_.resize(keys_.size());
        tree_.boxes_.resize(keys_.size());
        parallel_for(keys_.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                tree_.items_[i] = keys_[i].item;
                tree_.boxes_[i] = boxes_[keys_[i].item];
            }
        });
    }

    // Stable, so equal codes stay in the order of items.
    void sort_keys()
    {
        if (keys_.size() < 4096) {
            std::sort(keys_.begin(), keys_.end(), [](const Key& a, const Key& b) {
                return a.code != b.code ? a.code < b.code : a.item < b.item;
            });
            return;
        }
        constexpr int kBits = 11;
        std::vector<Key> other(keys_.size());
        for (int shift = 0; shift < 63; shift += kBits) {
            std::array<std::size_t, 1 << kBits> start{};
            for (const Key& key : keys_) ++start[digit(key, shift)];
            std::size_t sum = 0;
            for (std::size_t& s : start) sum += std::exchange(s, sum);
            for (const Key& key : keys_) other[start[digit(key, shift)]++] = key;
            keys_.swap(other);
            current_progress().check();
        }
    }

    static std::size_t digit(const Key& key, int shift) { return (key.code >> shift) & 0x7ff; }

    // Where the highest code bit that differs in the range changes.
    std::int32_t split(std::int32_t begin, std::int32_t end) const
    {
        const std::uint64_t first = keys_[begin].code, last = keys_[end - 1].code;
        if (first == last) return begin + (end - begin) / 2;
        const std::uint64_t bit = std::bit_floor(first ^ last);
        const auto at = std::partition_point(keys_.begin() + begin, keys_.begin() + end,
                                             [&](const Key& key) { return !(key.code & bit); });
        return static_cast<std::int32_t>(at - keys_.begin());
    }

    void list_tasks(std::int32_t begin, std::int32_t end)
    {
        if (end - begin <= task_items_) {
            tasks_.push_back({begin, end});
            return;
        }
        const std::int32_t middle = split(begin, end);
        list_tasks(begin, middle);
        list_tasks(middle, end);
    }

    Box3 build(std::int32_t begin, std::int32_t end, std::vector<Node>& nodes) const
    {
        const std::size_t at = nodes.size();
        nodes.push_back({});
        Node node{};
        if (end - begin <= kLeafItems) {
            for (std::int32_t i = begin; i < end; ++i) node.box.add(tree_.boxes_[i]);
            node.link = begin;
            node.count = end - begin;
        } else {
            const std::int32_t middle = split(begin, end);
            node.box.add(build(begin, middle, nodes));
            node.link = static_cast<std::int32_t>(nodes.size());
            node.box.add(build(middle, end, nodes));
        }
        nodes[at] = node;
        return node.box;
    }

    // Appends the finished parts in preorder, with the nodes above them.
    Box3 join(std::int32_t begin, std::int32_t end)
    {
        std::vector<Node>& nodes = tree_.nodes_;
        const auto at = static_cast<std::int32_t>(nodes.size());
        if (end - begin <= task_items_) {
            for (Node node : task_nodes_[next_task_]) {
                if (node.count == 0) node.link += at;
                nodes.push_back(node);
            }
            task_nodes_[next_task_++] = {};
            return nodes[at].box;
        }
        nodes.push_back({});
        const std::int32_t middle = split(begin, end);
        Node node{};
        node.box.add(join(begin, middle));
        node.link = static_cast<std::int32_t>(nodes.size());
        node.box.add(join(middle, end));
        nodes[at] = node;
        return node.box;
    }

    BoxTree& tree_;
    std::span<const Box3> boxes_;
    std::vector<Key> keys_;
    std::int32_t task_items_ = 0;
    std::vector<Pair> tasks_;
    std::vector<std::vector<Node>> task_nodes_;
    std::size_t next_task_ = 0;
};

BoxTree::BoxTree(std::span<const Box3> boxes)
{
    require(boxes.size() < (std::size_t{1} << 30), "BoxTree: more than 2^30 boxes");
    for (std::size_t i = 0; i < boxes.size(); ++i)
        if (boxes[i].empty() || !boxes[i].bounded())
            throw InvalidInput("BoxTree: box " + std::to_string(i) + " is empty or not bounded");
    if (!boxes.empty()) Builder(*this, boxes).run();
}

// ---------------------------------------------------------------------------------------------
// Queries

std::vector<std::int32_t> BoxTree::overlapping(const Box3& box) const
{
    std::vector<std::int32_t> found;
    visit_overlapping(box, [&](std::int32_t item) { found.push_back(item); });
    std::sort(found.begin(), found.end());
    return found;
}

BoxTree::RayTest::RayTest(const Vec3& origin, const Vec3& direction, double t_max)
    : origin_(origin), t_max_(t_max)
{
    for (std::size_t i = 0; i < 3; ++i) inverse_[i] = 1.0 / direction[i];
}

// Slabs. A ray that runs in the plane of a side gives 0 * infinity, which must not exclude it.
bool BoxTree::RayTest::operator()(const Box3& box) const
{
    constexpr double kMore = 1.0 + 16.0 * std::numeric_limits<double>::epsilon();
    constexpr double kLess = 1.0 - 16.0 * std::numeric_limits<double>::epsilon();
    double t0 = 0.0, t1 = t_max_;
    for (std::size_t i = 0; i < 3; ++i) {
        double enter = (box.min[i] - origin_[i]) * inverse_[i];
        double leave = (box.max[i] - origin_[i]) * inverse_[i];
        if (inverse_[i] < 0.0) std::swap(enter, leave);
        enter *= enter > 0.0 ? kLess : kMore;
        leave *= leave > 0.0 ? kMore : kLess;
        if (enter > t0) t0 = enter;
        if (leave < t1) t1 = leave;
    }
    return t0 <= t1 && t0 < std::numeric_limits<double>::infinity();
}

void BoxTree::expand(const BoxTree& a, const BoxTree& b, bool self, Pair pair,
                     std::vector<Pair>& out)
{
    const Node& m = a.nodes_[pair[0]];
    const Node& n = b.nodes_[pair[1]];
    const bool same = self && pair[0] == pair[1];
    if (!same && !overlap(m.box, n.box)) return;
    if (m.count > 0 || n.count > 0) {
        out.push_back(pair);
        return;
    }
    if (same) {
        out.push_back({pair[0] + 1, pair[0] + 1});
        out.push_back({m.link, m.link});
        out.push_back({pair[0] + 1, m.link});
        return;
    }
    for (const std::int32_t i : {pair[0] + 1, m.link})
        for (const std::int32_t j : {pair[1] + 1, n.link}) out.push_back({i, j});
}

// Enough pairs of nodes to keep all threads busy to the end.
std::vector<BoxTree::Pair> BoxTree::first_pairs(const BoxTree& a, const BoxTree& b, bool self)
{
    if (a.nodes_.empty() || b.nodes_.empty()) return {};
    constexpr std::size_t kEnough = 1024;
    const bool small = a.items_.size() + b.items_.size() < 1000;
    std::vector<Pair> pairs{{0, 0}};
    while (!small && pairs.size() < kEnough) {
        std::vector<Pair> finer;
        for (const Pair pair : pairs) expand(a, b, self, pair, finer);
        if (finer == pairs || finer.empty()) return finer;
        pairs = std::move(finer);
    }
    return pairs;
}

std::vector<Box3> face_boxes(const IndexedMesh& mesh)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    std::vector<Box3> boxes(mesh.n_faces());
    parallel_for(mesh.n_faces(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f)
            for (const std::int32_t v : mesh.faces[f]) {
                if (!is_finite(mesh.vertices[v]))
                    throw InvalidInput("vertex " + std::to_string(v) + " of face " +
                                       std::to_string(f) + " is not finite");
                boxes[f].add(mesh.vertices[v]);
            }
    });
    return boxes;
}

// ---------------------------------------------------------------------------------------------
// Triangles

namespace {

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b)
{
    const Vec3 d = b - a;
    const double length2 = dot(d, d);
    if (!(length2 > 0.0)) return a;
    const double t = std::clamp(dot(p - a, d) / length2, 0.0, 1.0);
    return t < 1.0 ? a + t * d : b;
}

Vec3 closest_on_sides(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const std::array<Vec3, 3> candidates{closest_on_segment(p, a, b), closest_on_segment(p, b, c),
                                         closest_on_segment(p, c, a)};
    return *std::min_element(
        candidates.begin(), candidates.end(),
        [&](const Vec3& x, const Vec3& y) { return dot(x - p, x - p) < dot(y - p, y - p); });
}

// Sign of the turn a, b, p, where p is thought moved by (e, e^2) for a small e: never zero unless
// a = b. So a point on a common side is inside exactly one of two neighbouring triangles.
int turn(const Vec2& a, const Vec2& b, const Vec2& p)
{
    const int sign = orient2d(a, b, p);
    if (sign != 0) return sign;
    if (a[1] != b[1]) return a[1] > b[1] ? 1 : -1;
    if (a[0] != b[0]) return b[0] > a[0] ? 1 : -1;
    return 0;
}

// Direction in which the triangle goes round p, 0 if not at all.
int goes_round(const std::array<Vec2, 3>& t, const Vec2& p)
{
    const int first = turn(t[0], t[1], p);
    if (first == 0 || turn(t[1], t[2], p) != first || turn(t[2], t[0], p) != first) return 0;
    return first;
}

// Coordinates in which the ray runs along the third axis: shears by the direction's ratios. Each
// vertex is mapped by itself, so neighbours agree about the image of what they share.
class RayFrame {
public:
    RayFrame(const Vec3& origin, const Vec3& direction) : origin_(origin)
    {
        for (std::size_t k = 1; k < 3; ++k)
            if (std::fabs(direction[k]) > std::fabs(direction[z_])) z_ = k;
        x_ = (z_ + 1) % 3;
        y_ = (z_ + 2) % 3;
        if (direction[z_] < 0.0) std::swap(x_, y_);
        shear_x_ = direction[x_] / direction[z_];
        shear_y_ = direction[y_] / direction[z_];
        scale_ = direction[z_];
    }

    Vec3 operator()(const Vec3& p) const
    {
        const Vec3 d = p - origin_;
        return {{d[x_] - shear_x_ * d[z_], d[y_] - shear_y_ * d[z_], d[z_] / scale_}};
    }

private:
    Vec3 origin_;
    std::size_t x_ = 0, y_ = 0, z_ = 0;
    double shear_x_ = 0.0, shear_y_ = 0.0, scale_ = 1.0;
};

double twice_area(const Vec3& a, const Vec3& b)
{
    return a[0] * b[1] - a[1] * b[0];
}

std::optional<RayHit> hit(const RayFrame& frame, const std::array<Vec3, 3>& corners)
{
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = frame(corners[i]);
    const std::array<Vec2, 3> flat{
        {{{p[0][0], p[0][1]}}, {{p[1][0], p[1][1]}}, {{p[2][0], p[2][1]}}}};
    const int around = goes_round(flat, Vec2{});
    if (around == 0) return std::nullopt;
    Vec3 w{{twice_area(p[1], p[2]), twice_area(p[2], p[0]), twice_area(p[0], p[1])}};
    for (double& weight : w.c) weight = std::max(around * weight, 0.0);
    const double sum = w[0] + w[1] + w[2];
    w = sum > 0.0 ? w / sum : Vec3{{1.0 / 3, 1.0 / 3, 1.0 / 3}};
    RayHit result;
    result.t = w[0] * p[0][2] + w[1] * p[1][2] + w[2] * p[2][2];
    result.leaves = around > 0;
    result.weights = w;
    return result;
}

}  // namespace

Vec3 closest_point(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0.0 && d2 <= 0.0) return a;
    const Vec3 bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0.0 && d4 <= d3) return b;
    const Vec3 cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0.0 && d5 <= d6) return c;
    // Areas by cross products, not by products of the d's: the error then grows with the reciprocal
    // of a needle's angle, not with its square.
    const Vec3 n = cross(ab, ac);
    const double va = dot(n, cross(bp, cp)), vb = dot(n, cross(cp, ap)), vc = dot(n, cross(ap, bp));
    if (!(va > 0.0 && vb > 0.0 && vc > 0.0)) return closest_on_sides(p, a, b, c);
    const double sum = va + vb + vc;
    const Vec3 inside = a + (vb / sum) * ab + (vc / sum) * ac;
    constexpr double kNeedle = 1e-12;  // squared sine
    if (dot(n, n) > kNeedle * dot(ab, ab) * dot(ac, ac)) return inside;
    const Vec3 side = closest_on_sides(p, a, b, c);
    return dot(side - p, side - p) < dot(inside - p, inside - p) ? side : inside;
}

MeshTree::MeshTree(const IndexedMesh& mesh) : mesh_(&mesh), tree_(face_boxes(mesh)) {}

ClosestPoint MeshTree::nearest(const Vec3& p, double limit) const
{
    const auto point_of = [&](std::int32_t f) {
        const auto& [a, b, c] = mesh_->faces[f];
        return closest_point(p, mesh_->vertices[a], mesh_->vertices[b], mesh_->vertices[c]);
    };
    const auto distance2 = [&](std::int32_t f) {
        const Vec3 d = point_of(f) - p;
        return dot(d, d);
    };
    const BoxTree::Nearest found = tree_.nearest(p, distance2, limit * limit);
    if (found.item < 0) return {};
    return {found.item, point_of(found.item), std::sqrt(found.distance2)};
}

std::vector<RayHit> MeshTree::ray_hits(const Vec3& origin, const Vec3& direction) const
{
    require(is_finite(origin) && is_finite(direction), "ray_hits: ray is not finite");
    require(direction != Vec3{}, "ray_hits: direction is zero");
    const RayFrame frame(origin, direction);
    std::vector<RayHit> hits;
    tree_.visit_along(origin, direction, std::numeric_limits<double>::infinity(),
                      [&](std::int32_t f) {
                          const auto& [a, b, c] = mesh_->faces[f];
                          const auto& v = mesh_->vertices;
                          auto found = hit(frame, {v[a], v[b], v[c]});
                          if (!found || found->t < 0.0) return;
                          found->face = f;
                          hits.push_back(*found);
                      });
    std::sort(hits.begin(), hits.end(), [](const RayHit& a, const RayHit& b) {
        return a.t != b.t ? a.t < b.t : a.face < b.face;
    });
    return hits;
}

std::array<int, 2> detail::face_ahead(const IndexedMesh& mesh, std::int32_t face, const Vec3& p)
{
    const auto& [ia, ib, ic] = mesh.faces[face];
    const Vec3 &a = mesh.vertices[ia], &b = mesh.vertices[ib], &c = mesh.vertices[ic];
    const int around =
        goes_round({{{{a[1], a[2]}}, {{b[1], b[2]}}, {{c[1], c[2]}}}}, Vec2{{p[1], p[2]}});
    if (around == 0) return {0, 0};
    return {around, orient3d(a, b, c, p)};
}

// Counts the faces that a ray leaves through, less those it enters through.
std::optional<int> MeshTree::winding_number(const Vec3& p) const
{
    require(is_finite(p), "winding_number: point is not finite");
    int winding = 0;
    bool on_face = false;
    visit_faces_ahead(*mesh_, tree_, p, [&](std::int32_t, int around, int side) {
        if (side == 0) on_face = true;
        if (side == around) winding += around;
    });
    if (on_face) return std::nullopt;
    return winding;
}

}  // namespace genus
