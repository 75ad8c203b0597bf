#include "genus/model/cut_face.h"

#include <algorithm>
#include <cmath>

namespace genus {

namespace {

constexpr double kMostPieces = 1 << 22;  // of one side
constexpr int kDeepest = 400;            // cuts of one face, each of a half
constexpr int kMostAttempts = 12;        // at a side
constexpr std::size_t kMostMends = 64;   // and a quarter of the faces
constexpr double kTooFar = -1.0;
constexpr double kShareOfOthers = 0.95;  // of the limit: bounds of a quartic are not exact

// Lengths are in radii of the largest circle whose points are within the limit of its plane.
constexpr double kLongestChord = 1.97;
constexpr double kPiece = 1.86;    // of a new side
constexpr double kStretch = 1.03;  // of its longest piece, beside that
constexpr double kSpare = 0.02;    // of a piece, before a side gets one more
constexpr double kThin = 1.0;      // height of a face that is cut in one strip
constexpr double kRound = 0.4;     // of an equilateral triangle, for a lattice
constexpr double kRadius = 0.99;   // of the circles round the triangles of a lattice
constexpr double kMostOfLattice = 1 << 14;
// Where these are measured: the weights of two corners.
constexpr std::array<std::array<double, 2>, 4> kSamples{
    {{1.0 / 3.0, 1.0 / 3.0}, {0.2, 0.2}, {0.6, 0.2}, {0.2, 0.6}}};

double squared(const Vec3& v)
{
    return dot(v, v);
}

// Where lines through two points meet a quadratic surface, nearest to these, as one by one. Nothing
// where one does not, or its point is not yet there but for rounding.
std::optional<TwoVec> meeting_points(const SurfaceForm& form, const TwoVec& p, const TwoVec& way)
{
    const Two f = form.value(p), g = dot(form.gradient(p), way), h = form.bend(way);
    const Two discriminant = g * g - 4.0 * f * h;
    if (!(discriminant[0] >= 0.0 && discriminant[1] >= 0.0)) return std::nullopt;
    const TwoVec at = p + -2.0 * f / (g + with_sign(root(discriminant), g)) * way;
    const Two left = form.value(at);
    const double most = 0.0625 * form.slack();
    if (!(std::fabs(left[0]) <= most && std::fabs(left[1]) <= most)) return std::nullopt;
    return at;
}

// The place between two others.
Weights between(const Weights& a, const Weights& b, double t)
{
    return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])};
}

}  // namespace

double pieces_for(double sagitta, double limit)
{
    return std::max(1.0, std::ceil(std::sqrt(sagitta / limit)));
}

// How far the surface lies outside and inside of a face with its corners on it, about, where it has
// this slope.
inline std::array<double, 2> CutFace::own_distance(const Vec3& a, const Vec3& b, const Vec3& c,
                                                   double slope) const
{
    if (form_->is_plane()) return {0.0, 0.0};
    const Interval r = form_->is_quadratic()
                           ? SurfaceForm::deviation_of(
                                 {form_->bend(b - a), form_->bend(c - b), form_->bend(a - c)})
                           : form_->range(std::array{a, b, c});
    const double below = std::max(0.0, -r.lo) / slope, above = std::max(0.0, r.hi) / slope;
    return sign_ < 0.0 ? std::array{above, below} : std::array{below, above};
}

CutFace::CutFace(double limit, std::int64_t max_triangles)
    : full_limit_(limit), max_triangles_(max_triangles)
{
}

bool CutFace::run(const SurfaceForm& form, bool turned, const std::vector<FinePoint>& border,
                  const std::array<std::int32_t, 3>& pieces, bool any_curve)
{
    form_ = &form;
    limit_ = (form.is_quadratic() ? 1.0 : kShareOfOthers) * full_limit_;
    sign_ = turned ? -1.0 : 1.0;
    any_curve_ = any_curve;
    points_ = border;
    n_border_ = static_cast<std::int32_t>(points_.size());
    for (const bool in_halves : {false, true}) {
        points_.resize(static_cast<std::size_t>(n_border_));
        faces_.clear();
        distances_.clear();
        too_far_.clear();
        pool_.clear();
        turned_over_ = false;
        only_halves_ = in_halves;
        std::array<Side, 3> sides;
        std::int32_t at = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            sides[i].begin = static_cast<std::int32_t>(pool_.size());
            sides[i].n = pieces[i];
            for (std::int32_t k = 0; k <= pieces[i]; ++k) pool_.push_back((at + k) % n_border_);
            at += pieces[i];
        }
        if (!fill(sides, 0) || !mend()) continue;
        find_reaches();
        return true;
    }
    return false;
}

void CutFace::find_reaches()
{
    reaches_.assign(points_.size(), {0.0, 0.0});
    for (std::size_t f = 0; f < faces_.size(); ++f)
        for (const std::int32_t v : faces_[f])
            for (const std::size_t side : {0u, 1u})
                reaches_[v][side] = std::max(reaches_[v][side], distances_[f][side]);
}

// Side i runs from corner i to the next.
bool CutFace::fill(const std::array<Side, 3>& sides, int depth)
{
    std::size_t most = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (sides[i].n > sides[most].n) most = i;
    if (sides[most].n == 1) {
        add({sides[0].at(pool_, 0), sides[1].at(pool_, 0), sides[2].at(pool_, 0)});
        return true;
    }
    if (too_many()) return false;
    if (only_halves_) return fill_halves(sides, most, depth);
    const MetricShape shape = metric_shape(sides);
    if (shape.height < kThin) {
        fill_thin(sides, most);
        return true;
    }
    if (const std::int64_t n = lattice_for(sides, shape); n > 0)
        return n * n <= max_triangles_ && fill_lattice(sides, static_cast<std::int32_t>(n));
    return fill_halves(sides, most, depth);
}

// Of the triangle that has sides as long as the chords are by their sagitta.
CutFace::MetricShape CutFace::metric_shape(const std::array<Side, 3>& sides) const
{
    std::array<double, 3> k{};
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 &a = points_[sides[i].at(pool_, 0)].at,
                   &b = points_[sides[i].at(pool_, sides[i].n)].at;
        if (!form_->is_plane()) k[i] = 4.0 * form_->sagitta(a, b) / limit_;
    }
    const double sum = k[0] + k[1] + k[2], longest = std::max({k[0], k[1], k[2]});
    const double area16 = 4.0 * (k[0] * k[1] + k[1] * k[2] + k[2] * k[0]) - sum * sum;
    MetricShape shape;
    if (area16 > 0.0 && longest > 0.0) shape.height = 0.5 * std::sqrt(area16 / longest);
    shape.is_round = 3.0 * area16 > kRound * kRound * sum * sum;
    shape.radius = std::sqrt(most_between(k));
    return shape;
}

bool CutFace::fill_halves(const std::array<Side, 3>& sides, std::size_t most, int depth)
{
    if (depth == kDeepest) return false;
    const Side cut = sides[most], next = sides[(most + 1) % 3], last = sides[(most + 2) % 3];
    const std::int32_t half = cut.n / 2;
    const std::size_t mark = pool_.size();
    const auto inner = new_side(cut.at(pool_, half), last.at(pool_, 0), kPiece);
    if (!inner || !fill({cut.part(0, half), *inner, last}, depth + 1) ||
        !fill({cut.part(half, cut.n), next, inner->turned()}, depth + 1))
        return false;
    pool_.resize(mark);
    return true;
}

// In radii of the largest circle whose points are within the limit of its plane: between offsets
// r^2 and s^2 at its ends a chord may have the length r + s.
double CutFace::chord_length(std::int32_t a, std::int32_t b) const
{
    if (form_->is_plane()) return 0.0;
    const FinePoint &p = points_[a], &q = points_[b];
    const double length = 2.0 * std::sqrt(form_->sagitta(p.at, q.at) / limit_);
    if (p.room == 1.0 && q.room == 1.0) return length;
    return 2.0 * length / (std::sqrt(p.room) + std::sqrt(q.room));
}

// Of two chords, in some unit.
std::array<double, 2> CutFace::chord_lengths(const std::array<std::int32_t, 2>& one,
                                             const std::array<std::int32_t, 2>& other) const
{
    const FinePoint &a = points_[one[0]], &b = points_[one[1]], &c = points_[other[0]],
                    &d = points_[other[1]];
    if (!form_->is_quadratic() || form_->may_be_saddle() ||
        std::min({a.room, b.room, c.room, d.room}) < 1.0)
        return {chord_length(one[0], one[1]), chord_length(other[0], other[1])};
    // With both ends on the surface the middle of a chord is off by a quarter of its bend.
    const TwoVec from(a.at, c.at), along = TwoVec(b.at, d.at) - from;
    const TwoVec g = form_->gradient(from + both(0.5) * along);
    const Two bend = form_->bend(along), fourth_power = bend * bend / dot(g, g);
    return {fourth_power[0], fourth_power[1]};
}

// Pieces on a side of the regular lattice to be used, 0 if there is none. Lengths grow where a flat
// face is projected onto its surface, most in its middle.
std::int32_t CutFace::lattice_for(const std::array<Side, 3>& sides, const MetricShape& shape) const
{
    if (!shape.is_round || std::min({sides[0].n, sides[1].n, sides[2].n}) < 2) return 0;
    const double n = shape.radius;
    if (!(n <= kMostOfLattice)) return 0;
    double longest = 0.0;
    for (const auto& [u, v] : kSamples) {
        const auto length = lattice_radius(sides, u, v, 1.0 / std::max(n, 3.0));
        if (!length) return 0;
        longest = std::max(longest, *length);
    }
    const double pieces = std::ceil(std::max(n, std::max(n, 3.0) * longest / kRadius) - kSpare);
    return pieces >= 3.0 ? static_cast<std::int32_t>(pieces) : 0;
}

// The radius of a triangle of a lattice with this step, round the place with weights u and v of the
// second and third corner.
std::optional<double> CutFace::lattice_radius(const std::array<Side, 3>& sides, double u, double v,
                                              double step) const
{
    const FinePoint &a = points_[sides[0].at(pool_, 0)], &b = points_[sides[1].at(pool_, 0)],
                    &c = points_[sides[2].at(pool_, 0)];
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
        const double x = u + step * ((i == 1 ? 1.0 : 0.0) - 1.0 / 3.0),
                     y = v + step * ((i == 2 ? 1.0 : 0.0) - 1.0 / 3.0);
        p[i] = a.at + x * (b.at - a.at) + y * (c.at - a.at);
        const Vec3 way =
            a.direction + x * (b.direction - a.direction) + y * (c.direction - a.direction);
        const auto t = form_->root_along(p[i], way);
        if (!t) return std::nullopt;
        p[i] += *t * way;
    }
    const auto distance = own_distance(p[0], p[1], p[2], norm(form_->gradient(p[0])));
    return std::sqrt(std::max(distance[0], distance[1]) / limit_);
}

// One strip between the longest side and the two others: two ears, and what is between them.
void CutFace::fill_thin(const std::array<Side, 3>& sides, std::size_t most)
{
    const Side lower = sides[most], first = sides[(most + 2) % 3].turned(),
               second = sides[(most + 1) % 3].turned();
    const auto begin = static_cast<std::int32_t>(pool_.size());
    for (std::int32_t k = 1; k <= first.n; ++k) pool_.push_back(first.at(pool_, k));
    for (std::int32_t k = 1; k < second.n; ++k) pool_.push_back(second.at(pool_, k));
    const Side upper{begin, first.n + second.n - 2, 1};
    add({lower.at(pool_, 0), lower.at(pool_, 1), upper.at(pool_, 0)});
    fill_strip(upper, lower.part(1, lower.n - 1));
    add({lower.at(pool_, lower.n - 1), lower.at(pool_, lower.n), upper.at(pool_, upper.n)});
    pool_.resize(begin);
}

// Numbers of the inner points of a lattice: those with distance r > 0 of n from side 0 in rows,
// from side 2 to side 1.
struct CutFace::Lattice {
    std::int32_t begin, n;
    std::int32_t at(std::int32_t r, std::int32_t q) const  // q: distance from side 2
    {
        return begin + (r - 1) * (2 * n - 2 - r) / 2 + q - 1;
    }
};

bool CutFace::fill_lattice(const std::array<Side, 3>& sides, std::int32_t n)
{
    const Lattice lattice{static_cast<std::int32_t>(points_.size()), n};
    if (!place_lattice(sides, n)) return false;
    if (form_->is_quadratic())
        add_in_pairs(lattice);
    else
        add_one_by_one(lattice);
    fill_rim(sides, lattice);
    return true;
}

// What is affine on a face, from its values at the corners.
struct OnFace {
    Vec3 at, along_u, along_v;

    OnFace(const Vec3& a, const Vec3& b, const Vec3& c) : at(a), along_u(b - a), along_v(c - a) {}
    Vec3 operator()(double u, double v) const { return at + u * along_u + v * along_v; }
};

bool CutFace::place_lattice(const std::array<Side, 3>& sides, std::int32_t n)
{
    const FinePoint &a = points_[sides[0].at(pool_, 0)], &b = points_[sides[1].at(pool_, 0)],
                    &c = points_[sides[2].at(pool_, 0)];
    const OnFace flat(a.at, b.at, c.at), direction(a.direction, b.direction, c.direction);
    const Weights origin = a.place, second = b.place, third = c.place;
    slopes_.clear();
    for (std::int32_t r = 1; r < n - 1; ++r) {
        const double v = static_cast<double>(r) / n;
        const auto start = [&](double u) { return flat(u, v) + swept(sides, u, v); };
        const auto place = [&](double u) {
            return Weights{origin[0] + u * (second[0] - origin[0]) + v * (third[0] - origin[0]),
                           origin[1] + u * (second[1] - origin[1]) + v * (third[1] - origin[1])};
        };
        for (std::int32_t q = 1; q < n - r; ++q) {
            const double u = static_cast<double>(q) / n, next = static_cast<double>(q + 1) / n;
            if (q + 1 < n - r && form_->is_quadratic()) {
                const TwoVec ways(direction(u, v), direction(next, v));
                if (const auto p = meeting_points(*form_, {start(u), start(next)}, ways)) {
                    add_points(*p, {place(u), place(next)});
                    ++q;
                    continue;
                }
            }
            const auto p = on_surface(start(u), direction(u, v), place(u));
            if (!p) return false;
            slopes_.push_back(norm(form_->gradient(points_.back().at)));
        }
    }
    return true;
}

void CutFace::add_points(const TwoVec& p, const std::array<Weights, 2>& places)
{
    const TwoVec g = form_->gradient(p);
    const Two slope = root(dot(g, g));
    const TwoVec direction = sign_ / slope * g;
    for (const std::size_t i : {0u, 1u}) {
        points_.push_back({p[i], direction[i], places[i], 1.0});
        slopes_.push_back(slope[i]);
    }
}

void CutFace::add_one_by_one(const Lattice& l)
{
    for (std::int32_t r = 1; r < l.n - 2; ++r)
        for (std::int32_t q = 1; q < l.n - r - 1; ++q) {
            add({l.at(r, q), l.at(r, q + 1), l.at(r + 1, q)});
            if (q < l.n - r - 2) add({l.at(r, q + 1), l.at(r + 1, q + 1), l.at(r + 1, q)});
        }
}

// Two faces that make a parallelogram at a time.
void CutFace::add_in_pairs(const Lattice& l)
{
    for (std::int32_t r = 1; r < l.n - 2; ++r) {
        const std::int32_t last = l.n - r - 2;
        for (std::int32_t q = 1; q < last; ++q)
            add_pair(l.at(r, q), l.at(r, q + 1), l.at(r + 1, q), l.at(r + 1, q + 1), l.begin);
        add({l.at(r, last), l.at(r, last + 1), l.at(r + 1, last)});
    }
}

// Faces a, b, c and b, d, c; points from `begin` on have slopes.
void CutFace::add_pair(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d,
                       std::int32_t begin)
{
    const FinePoint &p = points_[a], &q = points_[b], &r = points_[c], &s = points_[d];
    const TwoVec along(q.at - p.at, s.at - r.at), up(r.at - p.at, s.at - q.at);
    const Two turn = dot(cross(along, up), TwoVec(p.direction, s.direction));
    turned_over_ = turned_over_ || !(turn[0] > 0.0 && turn[1] > 0.0);
    const std::array<Two, 3> bends{form_->bend(along), form_->bend(up),
                                   both(form_->bend(r.at - q.at))};
    const double shared = std::min(slopes_[b - begin], slopes_[c - begin]);
    const Two slope{std::min(slopes_[a - begin], shared), std::min(slopes_[d - begin], shared)};
    const Two least_bend = lesser(bends[0], lesser(bends[1], bends[2]));
    std::array<Two, 2> far{most_between(bends) / slope, both(0.0)};
    if (!(least_bend[0] >= 0.0 && least_bend[1] >= 0.0))
        far[1] = most_between({-bends[0], -bends[1], -bends[2]}) / slope;
    if (sign_ < 0.0) std::swap(far[0], far[1]);
    const Two farthest = greater(far[0], far[1]);
    for (const int i : {0, 1}) {
        faces_.push_back(i == 0 ? Triangle{a, b, c} : Triangle{b, d, c});
        const bool near = farthest[i] <= limit_;
        if (!near) too_far_.push_back(static_cast<std::int32_t>(distances_.size()));
        distances_.push_back(near ? std::array{far[0][i], far[1][i]}
                                  : std::array{kTooFar, kTooFar});
    }
}

// Strips along the sides, and what is left in the corners.
void CutFace::fill_rim(const std::array<Side, 3>& sides, const Lattice& lattice)
{
    const std::size_t mark = pool_.size();
    const std::int32_t n = lattice.n;
    std::array<Side, 3> rim;
    for (std::size_t i = 0; i < 3; ++i) {
        rim[i] = {static_cast<std::int32_t>(pool_.size()), n - 3, 1};
        for (std::int32_t k = 1; k < n - 1; ++k)
            pool_.push_back(i == 0   ? lattice.at(1, k)
                            : i == 1 ? lattice.at(k, n - 1 - k)
                                     : lattice.at(n - 1 - k, 1));
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const Side &side = sides[i], &before = sides[(i + 2) % 3];
        fill_strip(rim[i], side.part(1, side.n - 1));
        const std::int32_t a = side.at(pool_, 0), b = side.at(pool_, 1), c = rim[i].at(pool_, 0),
                           d = before.at(pool_, before.n - 1);
        const bool ear =
            squared(points_[b].at - points_[d].at) < squared(points_[c].at - points_[a].at);
        add(ear ? Triangle{a, b, d} : Triangle{a, b, c});
        add(ear ? Triangle{b, c, d} : Triangle{a, c, d});
    }
    pool_.resize(mark);
}

// By how much a point is moved so that a lattice follows sides that are not straight.
Vec3 CutFace::swept(const std::array<Side, 3>& sides, double u, double v) const
{
    if (!any_curve_) return {};
    Vec3 by;
    const std::array<double, 3> weight{1.0 - u - v, u, v};
    for (std::size_t i = 0; i < 3; ++i) {
        const double from = weight[i], to = weight[(i + 1) % 3];
        const Side& side = sides[i];
        const double at = to / (from + to) * side.n;
        const auto k = std::min(static_cast<std::int32_t>(at), side.n - 1);
        const Vec3 &a = points_[side.at(pool_, 0)].at, &b = points_[side.at(pool_, side.n)].at;
        const Vec3 &p = points_[side.at(pool_, k)].at, &q = points_[side.at(pool_, k + 1)].at;
        by += (from + to) * (from + to) * (p + (at - k) * (q - p) - a - (at / side.n) * (b - a));
    }
    return by;
}

// Between two rows from left to right, each step along the shorter diagonal.
void CutFace::fill_strip(const Side& upper, const Side& lower)
{
    std::int32_t i = 0, j = 0;
    while (i < upper.n || j < lower.n) {
        const std::int32_t a = upper.at(pool_, i), b = lower.at(pool_, j);
        bool along_upper = j == lower.n;
        if (i < upper.n && j < lower.n) {
            const std::int32_t d = upper.at(pool_, i + 1), e = lower.at(pool_, j + 1);
            const auto [down, up] = chord_lengths({d, b}, {e, a});
            along_upper = down < up || (down == up && squared(points_[d].at - points_[b].at) <
                                                          squared(points_[e].at - points_[a].at));
        }
        const std::int32_t c = along_upper ? upper.at(pool_, ++i) : lower.at(pool_, ++j);
        add({a, b, c});
    }
}

// Whether a face clears its surface with its corners as far outward (side 0) or inward as they may
// move: beside a short room the surface's own curvature counts.
bool CutFace::clears(const Triangle& t, std::size_t side) const
{
    std::array<Vec3, 3> moved;
    std::array<double, 3> values;
    for (std::size_t i = 0; i < 3; ++i) {
        const FinePoint& p = points_[t[i]];
        moved[i] = p.at + (side == 0 ? limit_ : -limit_) * p.room * p.direction;
        values[i] = form_->value(moved[i]);
    }
    const Interval range = form_->range(moved, values);
    return (side == 0) == (sign_ > 0.0) ? range.lo > 0.0 : range.hi < 0.0;
}

void CutFace::add(const Triangle& t)
{
    faces_.push_back(t);
    distances_.emplace_back();
    judge(static_cast<std::int32_t>(faces_.size()) - 1);
}

// How far the corners of a face must move outward and inward for it to clear its surface, or
// `kTooFar` if there is no room for that. Where one has less room the others make up for it.
void CutFace::judge(std::int32_t f)
{
    const Triangle& t = faces_[f];
    const FinePoint &a = points_[t[0]], &b = points_[t[1]], &c = points_[t[2]];
    const Vec3 g = form_->gradient((1.0 / 3.0) * (a.at + b.at + c.at));
    turned_over_ = turned_over_ || !(sign_ * dot(cross(b.at - a.at, c.at - a.at), g) > 0.0);
    std::array<double, 2> distance = own_distance(a.at, b.at, c.at, norm(g));
    const double least = limit_ * std::min({a.room, b.room, c.room});
    for (const std::size_t side : {0u, 1u}) {
        if (distance[side] <= least) continue;
        if (!(distance[side] <= limit_) || !clears(t, side)) {
            distance = {kTooFar, kTooFar};
            too_far_.push_back(f);
            break;
        }
        distance[side] = limit_;
    }
    distances_[f] = distance;
}

// Faces that are too far from the surface are cut: an edge that is too long in its middle, together
// with the face across, or the face in its own middle.
bool CutFace::mend()
{
    for (std::size_t k = 0; k < too_far_.size(); ++k) {
        if (k > kMostMends + faces_.size() / 4) return false;
        const std::int32_t f = too_far_[k];
        if (distances_[f][0] != kTooFar) continue;
        const Triangle t = faces_[f];
        std::size_t i = 0;
        double longest = 0.0;
        for (std::size_t j = 0; j < 3; ++j) {
            const double length = chord_length(t[j], t[(j + 1) % 3]);
            if (length > longest) i = j;
            longest = std::max(longest, length);
        }
        const std::int32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
        const FinePoint p = points_[a], q = points_[b], r = points_[c];
        if (longest <= kLongestChord) {
            const auto m =
                on_surface((p.at + q.at + r.at) / 3.0, p.direction + q.direction + r.direction,
                           between(p.place, between(q.place, r.place, 0.5), 2.0 / 3.0));
            if (!m) return false;
            faces_[f] = {a, b, *m};
            add({b, c, *m});
            add({c, a, *m});
        } else {
            const std::int32_t g = face_across(f, a, b);
            const auto m = on_surface(0.5 * (p.at + q.at), p.direction + q.direction,
                                      between(p.place, q.place, 0.5));
            if (g < 0 || !m) return false;
            const Triangle u = faces_[g];
            const std::int32_t d = u[0] != a && u[0] != b   ? u[0]
                                   : u[1] != a && u[1] != b ? u[1]
                                                            : u[2];
            faces_[f] = {a, *m, c};
            faces_[g] = {b, *m, d};
            judge(g);
            add({*m, b, c});
            add({*m, a, d});
        }
        judge(f);
    }
    return (only_halves_ || !turned_over_) && !too_many();
}

// The face with a side from b to a, sought from face f outward: it is seldom far. -1 for none.
std::int32_t CutFace::face_across(std::int32_t f, std::int32_t a, std::int32_t b) const
{
    const auto n = static_cast<std::int32_t>(faces_.size());
    const auto has = [&](std::int32_t g) {
        const Triangle& t = faces_[g];
        return (t[0] == b && t[1] == a) || (t[1] == b && t[2] == a) || (t[2] == b && t[0] == a);
    };
    for (std::int32_t step = 1; step < n; ++step) {
        if (f >= step && has(f - step)) return f - step;
        if (f + step < n && has(f + step)) return f + step;
    }
    return -1;
}

// Number of the new vertex.
std::optional<std::int32_t> CutFace::on_surface(const Vec3& start, const Vec3& way,
                                                const Weights& place)
{
    const auto root = form_->root_along(start, way);
    if (!root) return std::nullopt;
    const Vec3 p = form_->straightened(start + *root * way);
    points_.push_back({p, sign_ * normalized(form_->gradient(p)), place, 1.0});
    return static_cast<std::int32_t>(points_.size()) - 1;
}

// A side of pieces no longer than the widest.
std::optional<CutFace::Side> CutFace::new_side(std::int32_t a, std::int32_t b, double widest)
{
    const FinePoint from = points_[a], to = points_[b];
    const std::size_t mark = points_.size(), begin = pool_.size();
    double pieces = std::max(1.0, std::ceil(chord_length(a, b) / widest - kSpare));
    for (int attempt = 0; attempt < kMostAttempts && pieces <= kMostPieces; ++attempt) {
        const Side side{static_cast<std::int32_t>(begin), static_cast<std::int32_t>(pieces), 1};
        pool_.push_back(a);
        for (std::int32_t i = 1; i < side.n; ++i) {
            const double t = static_cast<double>(i) / side.n;
            const auto v = on_surface(from.at + t * (to.at - from.at),
                                      from.direction + t * (to.direction - from.direction),
                                      between(from.place, to.place, t));
            if (!v) return std::nullopt;
            pool_.push_back(*v);
        }
        pool_.push_back(b);
        // Where the chord is farthest from the surface pieces are longer than the others.
        const std::int32_t middle = side.n / 2;
        const double longest =
            side.n == 1 ? 0.0 : chord_length(side.at(pool_, middle), side.at(pool_, middle - 1));
        if (longest <= kStretch * widest) return side;
        pieces = std::max(pieces + 1.0, std::ceil(pieces * longest / widest - kSpare));
        points_.resize(mark);
        pool_.resize(begin);
    }
    return std::nullopt;
}

}  // namespace genus
