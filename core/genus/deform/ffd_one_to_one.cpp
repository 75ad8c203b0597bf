#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <optional>

#include "genus/base/progress.h"
#include "genus/deform/ffd.h"
#include "genus/deform/lattice_net.h"
#include "genus/mesh/aabb_tree.h"

namespace genus {

using namespace lattice;

namespace {

constexpr double kUsual = 64.0;        // coefficients that a pair of rectangles is compared by
constexpr double kSmallest = 0x1p-20;  // side of a rectangle, of the lattice

// A rectangle of the surface of the box and its image; its halves are made once, when asked for.
struct Rectangle {
    Box3 box;  // of (s, t, u), without width along `normal`
    std::size_t normal;
    Net3<Vec3> net;
    Box3 image;
    std::unique_ptr<std::array<Rectangle, 2>> parts;

    Rectangle(const Box3& where, std::size_t axis, Net3<Vec3> coefficients)
        : box(where), normal(axis), net(std::move(coefficients))
    {
        double largest = 0.0;
        for (const Vec3& p : net.c) {
            image.add(p);
            largest = std::max(largest, norm(p));
        }
        // Halving rounds coefficients, by less than a unit a step; they do not grow.
        slack = 64.0 * kEpsilon * (net.n[0] + net.n[1] + net.n[2]) * largest;
        image = image.inflated(slack);
    }

    double slack = 0.0;

    std::array<Rectangle, 2>& halves()
    {
        if (!parts) {
            const std::size_t axis = longest_way();
            auto nets = lattice::halves(net, axis);
            const auto boxes = genus::halves(box, axis);
            parts = std::make_unique<std::array<Rectangle, 2>>(
                std::array{Rectangle(boxes[0], normal, std::move(nets[0])),
                           Rectangle(boxes[1], normal, std::move(nets[1]))});
        }
        return *parts;
    }

private:
    // The axis along which the rows of control points are longest.
    std::size_t longest_way() const
    {
        Vec3 length;
        for (std::size_t a = 0; a < 3; ++a)
            if (a != normal && box.size()[a] >= 2.0 * kSmallest)
                net.for_lines(static_cast<int>(a), [&](std::size_t first) {
                    const std::size_t step = net.stride(static_cast<int>(a));
                    double row = 0.0;
                    for (std::size_t k = 1; k < at(net.n[a]); ++k)
                        row += distance(net.c[first + k * step], net.c[first + (k - 1) * step]);
                    length[a] = std::max(length[a], row);
                });
        return longest_axis(length);
    }
};

// True if some plane has all of one image on its positive side and all of the other on its
// negative: across the line between the middles, or along one of the rectangles.
bool apart(const Rectangle& a, const Rectangle& b)
{
    if (!overlap(a.image, b.image)) return true;
    const auto normal_of = [](const Rectangle& r) {
        // Between the diagonals of the corners.
        const std::size_t p = (r.normal + 1) % 3, q = (r.normal + 2) % 3;
        const std::size_t u = r.net.stride(static_cast<int>(p)) * at(r.net.n[p] - 1),
                          v = r.net.stride(static_cast<int>(q)) * at(r.net.n[q] - 1);
        return cross(r.net.c[u + v] - r.net.c[0], r.net.c[v] - r.net.c[u]);
    };
    const double slack = 4.0 * (a.slack + b.slack);
    for (const Vec3& way : {b.image.center() - a.image.center(), normal_of(a), normal_of(b)}) {
        const double length = norm(way);
        if (!(length > 0.0) || !std::isfinite(length)) continue;
        const Vec3 d = way / length;
        const auto range = [&](const Rectangle& r) {
            std::array<double, 2> extent{std::numeric_limits<double>::infinity(),
                                         -std::numeric_limits<double>::infinity()};
            for (const Vec3& p : r.net.c) {
                extent[0] = std::min(extent[0], dot(d, p));
                extent[1] = std::max(extent[1], dot(d, p));
            }
            return extent;
        };
        const auto ra = range(a), rb = range(b);
        if (ra[1] + slack < rb[0] || rb[1] + slack < ra[0]) return true;
    }
    return false;
}

// What of a piece lies on the side of a box where `axis` has the given value.
template <class Piece>
Piece cut_at(const Piece& piece, std::size_t axis, double value)
{
    Box3 plane = piece.box;
    plane.min[axis] = plane.max[axis] = value;
    const double t = piece.relative(plane).min[axis];
    Piece cut{piece.box,
              by_lines(piece.net, static_cast<int>(axis), [&](const std::vector<Vec3>& line) {
                  return std::vector<Vec3>{bernstein::value<Vec3>(line, t)};
              })};
    // Without a degree along the axis any place along it will do.
    cut.box.min[axis] = 0.0;
    cut.box.max[axis] = 1.0;
    return cut;
}

}  // namespace

// The surface of a box of (s, t, u), compared with itself.
class Lattice::Surface {
public:
    Surface(const Lattice& lattice, const Box3& box)
        : lattice_(lattice), box_(box), pieces_(lattice.pieces())
    {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const std::size_t side : {0u, 1u}) {
                Box3 face = box;
                const double value = side != 0 ? box.max[axis] : box.min[axis];
                face.min[axis] = face.max[axis] = value;
                for (const Piece& piece : pieces_) {
                    if (!overlap(piece.box, face)) continue;
                    sides_[axis][side].push_back(cut_at(piece, axis, value));
                    add(sides_[axis][side].back(), face, axis);
                }
            }
    }

    OneToOneReport compare(int max_pairs)
    {
        // The largest first, so that points that meet are found early.
        std::deque<std::array<Rectangle*, 2>> open;
        std::vector<Box3> images;
        for (const auto& r : rectangles_) images.push_back(r->image);
        const BoxTree tree(images);
        for (std::size_t i = 0; i < rectangles_.size(); ++i)
            tree.visit_overlapping(images[i], [&](std::int32_t j) {
                if (at(j) <= i) open.push_back({rectangles_[i].get(), rectangles_[at(j)].get()});
            });
        while (!open.empty()) {
            current_progress().check();
            const auto [a, b] = open.front();
            open.pop_front();
            if ((a != b && apart(*a, *b)) || one_to_one_over(*a, *b)) continue;
            if (auto found = meeting(*a, *b)) return *found;
            Rectangle& larger = a->image.diagonal() >= b->image.diagonal() ? *a : *b;
            const Vec3 size = larger.box.size();
            if (work_ > max_pairs || size[longest_axis(size)] < 2.0 * kSmallest)
                return {OneToOneReport::Kind::Undecided,
                        {lattice_.global(a->box.center()), lattice_.global(b->box.center())},
                        0.0};
            auto& [low, high] = larger.halves();
            if (a == b) {
                open.push_back({&low, &low});
                open.push_back({&high, &high});
                open.push_back({&low, &high});
            } else {
                Rectangle* other = &larger == a ? b : a;
                open.push_back({&low, other});
                open.push_back({&high, other});
            }
        }
        return {};
    }

private:
    void add(const Piece& side, const Box3& face, std::size_t axis)
    {
        Box3 box = intersection(side.box, face);
        for (std::size_t k = 0; k < 3; ++k)
            if (k != axis && !(box.max[k] > box.min[k])) return;  // only touched
        Box3 part = side.relative(box);
        part.min[axis] = 0.0;
        part.max[axis] = 1.0;
        rectangles_.push_back(
            std::make_unique<Rectangle>(box, axis, part_of<Vec3>(side.net, part)));
    }

    // The difference of two images is the mean of the derivative between the points, times their
    // difference.
    bool one_to_one_over(const Rectangle& a, const Rectangle& b)
    {
        Box3 both = a.box;
        both.add(b.box);
        const std::vector<Piece>* pieces = &pieces_;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (both.min[axis] == both.max[axis])
                pieces = &sides_[axis][both.min[axis] == box_.min[axis] ? 0 : 1];
        std::size_t coefficients = 0;
        for (const Piece& piece : *pieces)
            if (overlap(piece.box, both)) coefficients += piece.net.c.size();
        work_ += std::max(1.0, static_cast<double>(coefficients) / kUsual);
        return lattice_.least_determinant(*pieces, both) > 0.0;
    }

    // Two points, one of each rectangle or near it, that go to one place.
    std::optional<OneToOneReport> meeting(const Rectangle& a, const Rectangle& b)
    {
        constexpr int kMostTries = 2000;
        if (overlap(a.box, b.box) || n_tries_ >= kMostTries) return std::nullopt;
        ++n_tries_;
        double coefficients = 1.0;
        for (int axis = 0; axis < 3; ++axis) coefficients *= lattice_.degree(axis) + 1;
        work_ += coefficients / kUsual;
        return lattice_.meeting(box_, a.box.center(), b.box.center());
    }

    const Lattice& lattice_;
    Box3 box_;
    std::vector<Piece> pieces_;
    std::array<std::array<std::vector<Piece>, 2>, 3> sides_;
    std::vector<std::unique_ptr<Rectangle>> rectangles_;
    int n_tries_ = 0;
    double work_ = 0.0;  // in pairs of a cubic lattice
};

// Starting from `start`, another point of the box that goes where p does.
std::optional<OneToOneReport> Lattice::meeting(const Box3& stu, const Vec3& p,
                                               const Vec3& start) const
{
    int steps = 0;
    const Vec3 x = global(p), y = apply(x);
    const auto q = newton(y, start, steps);
    const double away = q ? norm(*q - p) : 0.0;
    if (!q || !stu.contains(*q) || away < 0.25 * norm(start - p)) return std::nullopt;
    const double radius = certify(y, *q);
    if (!(radius < 0.1 * away)) return std::nullopt;
    double size = 0.0;
    for (const Vec3& a : axes_) size += norm(a);
    return OneToOneReport{OneToOneReport::Kind::No, {x, global(*q)}, radius * size};
}

// Between points where the determinant has either sign it is zero: there, points on both sides
// along its kernel are taken to one place.
OneToOneReport Lattice::meeting_at_fold(const Box3& stu, const Vec3& positive,
                                        const Vec3& negative) const
{
    Vec3 low = positive, high = negative;
    const bool sign = local_determinant(low) > 0.0;
    for (int step = 0; step < 60; ++step) {
        const Vec3 middle = 0.5 * (low + high);
        ((local_determinant(middle) > 0.0) == sign ? low : high) = middle;
    }
    const Columns3 d = local_derivative(low);
    const auto row = [&](std::size_t r) { return Vec3{{d[0][r], d[1][r], d[2][r]}}; };
    Vec3 kernel;
    for (std::size_t r = 0; r < 3; ++r) {
        const Vec3 across = cross(row(r), row((r + 1) % 3));
        if (norm(across) > norm(kernel)) kernel = across;
    }
    if (norm(kernel) > 0.0 && is_finite(kernel)) {
        kernel = normalized(kernel);
        for (double far = 0.25; far > 1e-4; far *= 0.7)
            for (const double side : {far, -far}) {
                const Vec3 p = low + side * kernel, start = low - side * kernel;
                if (!stu.contains(p)) continue;
                if (const auto found = meeting(stu, p, start)) return *found;
            }
    }
    return {OneToOneReport::Kind::Undecided, {global(low), global(high)}, 0.0};
}

OneToOneReport Lattice::one_to_one(const Box3& x, int max_pairs) const
{
    constexpr double kThin = 1e-6;
    Box3 inside = local_box(x);
    if (inside.empty()) return {};
    // More than was asked for, where a side is too short for rounding.
    for (std::size_t k = 0; k < 3; ++k)
        if (inside.max[k] - inside.min[k] < kThin) {
            inside.min[k] = std::max(0.0, std::min(inside.min[k] - kThin, 1.0 - 2.0 * kThin));
            inside.max[k] = std::min(1.0, inside.min[k] + 3.0 * kThin);
        }
    const double sign = local_determinant(inside.center()) < 0.0 ? -1.0 : 1.0;
    const FoldReport folds = folds_in(inside, sign, max_pairs / 10);
    if (folds.kind == FoldReport::Kind::Folded)
        return meeting_at_fold(inside, inside.center(), local(folds.where));
    if (folds.kind == FoldReport::Kind::Undecided)
        return {OneToOneReport::Kind::Undecided, {folds.where, folds.where}, 0.0};
    return Surface(*this, inside).compare(max_pairs);
}

}  // namespace genus
