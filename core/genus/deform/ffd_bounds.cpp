#include "genus/deform/ffd.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/deform/lattice_net.h"

namespace genus {

using namespace lattice;

std::vector<Lattice::Piece> Lattice::pieces() const
{
    Net3<Vec3> net{counts_, points()};
    if (!is_bspline()) return {Piece{Box3{{}, {{1, 1, 1}}}, std::move(net)}};
    std::array<std::vector<double>, 3> cuts;
    for (int a = 0; a < 3; ++a) {
        const KnotVector& from = knots_[at(a)];
        KnotVector to = from;
        for (const int k : from.spans()) {
            cuts[at(a)].push_back(from[at(k)]);
            if (from[at(k)] > from.begin())
                to = to.with(from[at(k)], from.degree() - from.multiplicity(from[at(k)]));
        }
        cuts[at(a)].push_back(from.end());
        const KnotRefinement r = refinement(from, to);
        net = by_lines(net, a, [&](const std::vector<Vec3>& line) {
            std::vector<Vec3> image;
            for (const auto& row : r.rows) {
                Vec3 sum;
                for (std::size_t j = 0; j < row.weights.size(); ++j)
                    sum += row.weights[j] * line[at(row.first) + j];
                image.push_back(sum);
            }
            return image;
        });
    }
    std::vector<Piece> all;
    const int p = degree(0);
    for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i)
        for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j)
            for (std::size_t k = 0; k + 1 < cuts[2].size(); ++k) {
                Piece piece{{{{cuts[0][i], cuts[1][j], cuts[2][k]}},
                             {{cuts[0][i + 1], cuts[1][j + 1], cuts[2][k + 1]}}},
                            {{p + 1, p + 1, p + 1}, {}}};
                const auto first = std::array{i * at(p), j * at(p), k * at(p)};
                for (std::size_t a = 0; a <= at(p); ++a)
                    for (std::size_t b = 0; b <= at(p); ++b)
                        for (std::size_t c = 0; c <= at(p); ++c)
                            piece.net.c.push_back(
                                net.c[((first[0] + a) * at(net.n[1]) + first[1] + b) *
                                          at(net.n[2]) +
                                      first[2] + c]);
                all.push_back(std::move(piece));
            }
    return all;
}

std::array<IntervalVec3, 3> Lattice::derivative_bounds(const std::vector<Piece>& all,
                                                       const Box3& box) const
{
    std::array<IntervalVec3, 3> result;
    bool any = false;
    for (const Piece& piece : all) {
        if (is_bspline() && !overlap(piece.box, box)) continue;
        const Net3<Vec3> net = part_of(piece.net, piece.relative(box));
        for (int a = 0; a < 3; ++a) {
            const auto slope = derivative_of(net, a);
            const double width = box.max[at(a)] - box.min[at(a)];
            if (width == 0.0) continue;
            for (std::size_t c = 0; c < 3; ++c) {
                Interval range(slope.c[0][c]);
                double largest = 0.0;
                for (const Vec3& v : slope.c) range = hull(range, Interval(v[c]));
                for (const Vec3& v : net.c) largest = std::max(largest, std::fabs(v[c]));
                // Cutting out the part rounds its coefficients; a difference feels that divided
                // by the width.
                const double slack = 16.0 * kEpsilon * (net.n[0] + net.n[1] + net.n[2]) * largest *
                                     (net.n[at(a)] - 1);
                range = Interval((range.lo - slack) / width, (range.hi + slack) / width);
                result[at(a)][c] = any ? hull(result[at(a)][c], range) : range;
            }
        }
        any = true;
    }
    return result;
}

// The part of the lattice that a box of space may meet.
Box3 Lattice::local_box(const Box3& x) const
{
    Box3 box;
    for (std::size_t k = 0; k < 8; ++k) box.add(local(x.corner(k)));
    return intersection(box.inflated(16.0 * kEpsilon), Box3{{}, {{1, 1, 1}}});
}

Box3 Lattice::image_bounds(const Box3& x) const
{
    Box3 image;
    bool whole = true;  // the box lies in the lattice
    for (std::size_t k = 0; k < 8; ++k) whole = whole && in_unit_cube(local(x.corner(k)));
    if (!whole) image.add(x);
    const Box3 inside = local_box(x);
    if (!inside.empty()) image.add(image_of_local(inside));
    return image;
}

Box3 Lattice::image_of_local(const Box3& stu) const
{
    Box3 image;
    for (const Piece& piece : pieces()) {
        const Box3 common = intersection(piece.box, stu);
        if (common.empty()) continue;
        // A box that only touches a piece is widened a little into it.
        const Box3 wide = intersection(common.inflated(1e-6), piece.box);
        for (const Vec3& p : part_of(piece.net, piece.relative(wide)).c) image.add(p);
    }
    return image.empty() ? image : image.inflated(rounding());
}

namespace {

// At least the largest singular value.
double largest_stretch(const Columns3& m)
{
    double rows = 0.0, columns = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        double row = 0.0, column = 0.0;
        for (std::size_t j = 0; j < 3; ++j) {
            row += std::fabs(m[j][i]);
            column += std::fabs(m[i][j]);
            squares += m[i][j] * m[i][j];
        }
        rows = std::max(rows, row);
        columns = std::max(columns, column);
    }
    return std::min(std::sqrt(rows * columns), std::sqrt(squares)) * (1.0 + 8.0 * kEpsilon);
}

// Of a matrix somewhere between those with entries `d` times `inverse`.
double largest_stretch(const std::array<IntervalVec3, 3>& d, const Columns3& inverse)
{
    Columns3 middle, radius;
    for (std::size_t column = 0; column < 3; ++column)
        for (std::size_t c = 0; c < 3; ++c) {
            Interval sum(0.0);
            for (std::size_t a = 0; a < 3; ++a) sum = sum + d[a][c] * Interval(inverse[column][a]);
            middle[column][c] = sum.mid();
            radius[column][c] = 0.5 * (sum.hi - sum.lo);
        }
    return largest_stretch(middle) + largest_stretch(radius);
}

}  // namespace

double Lattice::stretch(const Box3& x) const
{
    constexpr int kParts = 4;  // along each axis: bounds over small boxes are tight
    const Box3 inside = local_box(x);
    if (inside.empty()) return 1.0;
    const Vec3 size = inside.size() / kParts;
    const std::vector<Piece> all = pieces();
    double largest = in_unit_cube(local(x.min)) && in_unit_cube(local(x.max)) ? 0.0 : 1.0;
    for (int part = 0; part < kParts * kParts * kParts; ++part) {
        const std::array<int, 3> at = {part / (kParts * kParts), part / kParts % kParts,
                                       part % kParts};
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::clamp(inside.min[k] + at[k] * size[k] - 1e-9, 0.0, 1.0 - 1e-6);
            box.max[k] = std::clamp(inside.min[k] + (at[k] + 1) * size[k] + 1e-9, 1e-6, 1.0);
        }
        largest = std::max(largest, largest_stretch(derivative_bounds(all, box), inverse_axes_));
    }
    return largest;
}

std::vector<std::array<double, 6>> Lattice::second_bounds(int n) const
{
    require(n >= 1 && n <= 256, "Lattice::second_bounds: boxes an axis", n, "in [1, 256]");
    constexpr std::array<std::array<int, 2>, 6> kPairs = {
        {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}}};
    const std::vector<Piece> all = pieces();
    std::vector<std::array<double, 6>> result(at(n) * at(n) * at(n));
    for (std::size_t i = 0; i < result.size(); ++i) {
        current_progress().check();
        const std::array<std::size_t, 3> place = {i / (at(n) * at(n)), i / at(n) % at(n),
                                                  i % at(n)};
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = static_cast<double>(place[k]) / n;
            box.max[k] = static_cast<double>(place[k] + 1) / n;
        }
        for (const Piece& piece : all) {
            const Box3 common = intersection(piece.box, box);
            if (common.empty()) continue;
            // A box that only touches a piece is widened a little into it.
            Box3 wide = intersection(common.inflated(0.5e-3 / n), piece.box);
            const Net3<Vec3> net = part_of(piece.net, piece.relative(wide));
            double coordinates = 0.0;
            for (const Vec3& p : net.c) coordinates = std::max(coordinates, norm(p));
            for (std::size_t pair = 0; pair < 6; ++pair) {
                const auto [a, b] = kPairs[pair];
                const double width = wide.size()[at(a)] * wide.size()[at(b)];
                double largest = 0.0;
                for (const Vec3& d : derivative_of(derivative_of(net, a), b).c)
                    largest = std::max(largest, norm(d));
                // Second differences of rounded coefficients.
                const double noise = 64.0 * kEpsilon * (net.n[0] + net.n[1] + net.n[2]) *
                                     coordinates * net.n[at(a)] * net.n[at(b)];
                result[i][pair] = std::max(result[i][pair], (largest + noise) / width);
            }
        }
    }
    return result;
}

std::vector<double> Lattice::kinks(int axis) const
{
    std::vector<double> places;
    if (!is_bspline()) return places;
    const KnotVector& knots = knots_[at(axis)];
    for (const int k : knots.spans()) {
        const double t = knots[at(k)];
        if (t > 0.0 && knots.multiplicity(t) >= knots.degree()) places.push_back(t);
    }
    return places;
}

}  // namespace genus
