#include "genus/mesh/distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/measure.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

using Corners = std::array<Vec3, 3>;

Corners corners_of(const IndexedMesh& mesh, std::size_t face)
{
    const auto& [a, b, c] = mesh.faces[face];
    return {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
}

double area_of(const Corners& t)
{
    return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0]));
}

// A small generator with the same numbers everywhere: the samples of a face depend on nothing
// but its number.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15 + 0x632be59bd9b4e019) {}

    double next()  // in [0, 1)
    {
        state_ += 0x9e3779b97f4a7c15;
        std::uint64_t z = state_;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
        z = (z ^ z >> 27) * 0x94d049bb133111eb;
        return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

// Points of a triangle, evenly spread: cell (i, j) of a k by k grid on the unit square, whose upper
// half is folded onto the lower.
Vec3 sample_of(const Corners& t, std::int64_t index, std::int64_t k, Random& random)
{
    double u = (static_cast<double>(index % k) + random.next()) / static_cast<double>(k);
    double v = (static_cast<double>(index / k) + random.next()) / static_cast<double>(k);
    if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
    }
    return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
}

struct Sampled {
    double max = -1.0;
    Vec3 where;
    double weighted = 0.0;  // area times mean distance
    double area = 0.0;
    std::int64_t n = 0;

    void see(double distance, const Vec3& p)
    {
        ++n;
        if (distance <= max) return;
        max = distance;
        where = p;
    }
    void add(const Sampled& other)
    {
        n += other.n;
        weighted += other.weighted;
        area += other.area;
        if (other.max <= max) return;
        max = other.max;
        where = other.where;
    }
};

constexpr std::size_t kSampleGrain = 256;

// Splits [0, n) into chunks, lets `work(index, sampled)` fill one for each, and adds them in order.
template <class Work>
Sampled sample_in_parallel(std::size_t n, const Work& work)
{
    std::vector<Sampled> parts((n + kSampleGrain - 1) / kSampleGrain);
    parallel_for(n, kSampleGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) work(i, parts[begin / kSampleGrain]);
    });
    Sampled total;
    for (const Sampled& part : parts) total.add(part);
    return total;
}

std::int64_t samples_in(double area, double density, Random& random)
{
    constexpr double kMost = 1e9;
    const double wanted = std::min(area * density, kMost);
    const double whole = std::floor(wanted);
    // The fraction is drawn, so that small faces get their share too.
    return static_cast<std::int64_t>(whole) + (random.next() < wanted - whole ? 1 : 0);
}

// The mesh to which distances are sought: a tree, and for each side of a face that beyond it.
class Target {
public:
    explicit Target(const IndexedMesh& mesh) : tree_(mesh)
    {
        const TriangleSides sides(mesh);
        const auto none = [](std::size_t) { return false; };
        twin_ = twins(make_edge_table(sides, mesh.n_vertices(), none), sides.n_sides());
    }

    Corners corners(std::int32_t face) const { return corners_of(tree_.mesh(), face); }

    // The face across a side, -1 if there is not just one.
    std::int32_t across(std::int32_t face, std::int32_t side) const
    {
        const std::int32_t twin = twin_[3 * face + side];
        return twin >= 0 ? twin / 3 : -1;
    }

    ClosestPoint on_face(const Vec3& p, std::int32_t face) const
    {
        const Corners t = corners(face);
        const Vec3 there = closest_point(p, t[0], t[1], t[2]);
        return {face, there, distance(p, there)};
    }

    // The point nearest to p, found the sooner the nearer face `near` is, if there is one.
    ClosestPoint nearest(const Vec3& p, std::int32_t near) const
    {
        if (near < 0) return tree_.nearest(p);
        const ClosestPoint known = on_face(p, near), nearer = tree_.nearest(p, known.distance);
        return nearer.face >= 0 ? nearer : known;
    }

    // The same, or any point that is no farther from p than `enough`: such a one is met on a walk
    // from `near` as a rule, which takes a fraction of the time.
    ClosestPoint near_enough(const Vec3& p, std::int32_t near, double enough) const
    {
        if (near < 0) return tree_.nearest(p);
        near = walk(p, near);
        const ClosestPoint found = on_face(p, near);
        if (found.distance <= enough) return found;
        const ClosestPoint nearer = tree_.nearest(p, found.distance);
        return nearer.face >= 0 ? nearer : found;
    }

private:
    // To the face over or under which p lies, or near it.
    std::int32_t walk(const Vec3& p, std::int32_t face) const
    {
        constexpr int kSteps = 12;
        for (int step = 0; step < kSteps; ++step) {
            const Corners t = corners(face);
            const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
            std::int32_t next = -1;
            for (std::int32_t side = 0; side < 3 && next < 0; ++side)
                if (dot(cross(normal, t[(side + 1) % 3] - t[side]), p - t[side]) < 0.0)
                    next = across(face, side);
            if (next < 0) break;
            face = next;
        }
        return face;
    }

    MeshTree tree_;
    std::vector<std::int32_t> twin_;
};

Sampled sample_faces(const IndexedMesh& from, const Target& to,
                     const std::vector<ClosestPoint>& nearest, const DistanceOptions& options,
                     double density)
{
    return sample_in_parallel(from.n_faces(), [&](std::size_t f, Sampled& sampled) {
        const Corners t = corners_of(from, f);
        Random random(f);
        const double face_area = area_of(t);
        const std::int64_t wanted = samples_in(face_area, density, random);
        if (wanted == 0) return;
        const auto k = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(wanted))));
        double sum = 0.0;
        std::int32_t near = nearest[from.faces[f][0]].face;
        for (std::int64_t i = 0; i < k * k; ++i) {
            if (i % 1024 == 1023) current_progress().check();
            const Vec3 p = sample_of(t, i, k, random);
            const ClosestPoint at =
                options.mean ? to.nearest(p, near) : to.near_enough(p, near, sampled.max);
            near = at.face;
            sum += at.distance;
            sampled.see(at.distance, p);
        }
        // A face drawn by chance stands for more area than its own.
        const double stands_for = std::max(face_area, 1.0 / density);
        sampled.weighted += stands_for * sum / static_cast<double>(k * k);
        sampled.area += stands_for;
    });
}

// ---- branch and bound ---------------------------------------------------------------------------

// A triangle, with the nearest faces of the other mesh for its corners.
struct Piece {
    Corners corners;
    std::array<std::int32_t, 3> face;
    std::array<double, 3> distance;

    void set(std::size_t corner, const Vec3& p, const ClosestPoint& at)
    {
        corners[corner] = p;
        face[corner] = at.face;
        distance[corner] = at.distance;
    }
};

// A convex part of a triangle.
class Part {
public:
    Part() = default;
    Part(const Vec3* begin, const Vec3* end)
    {
        for (; begin != end; ++begin) push_back(*begin);
    }

    void push_back(const Vec3& p)
    {
        if (n_ < kMost) points_[n_] = p;
        ++n_;
    }
    std::size_t size() const { return n_; }
    // False: there were more corners than it holds.
    bool is_whole() const { return n_ <= kMost; }
    const Vec3& operator[](std::size_t i) const { return points_[i]; }
    const Vec3* begin() const { return points_.data(); }
    const Vec3* end() const { return points_.data() + n_; }

private:
    static constexpr std::size_t kMost = 16;
    std::size_t n_ = 0;
    std::array<Vec3, kMost> points_;
};

Vec3 middle_of(const Part& part)
{
    Vec3 middle;
    for (const Vec3& p : part) middle += p / static_cast<double>(part.size());
    return middle;
}

class Bounder {
public:
    Bounder(const IndexedMesh& from, const Target& to, const DistanceOptions& options)
        : from_(from), to_(to), options_(options)
    {
    }

    // Given the nearest faces of all vertices and a distance that does occur; returns a bound and
    // raises `known` where larger distances turn up.
    double run(const std::vector<ClosestPoint>& nearest, double& known, Vec3& where)
    {
        known_ = known;
        std::vector<Piece> pieces;
        for (std::size_t begin = 0; begin < from_.n_faces(); begin += kBatch) {
            const std::size_t end = std::min(begin + kBatch, from_.n_faces());
            look_at<1>(
                end - begin, [&](std::size_t i) { return whole_face(begin + i, nearest); }, pieces);
        }
        while (!pieces.empty() && looked_ < options_.max_pieces) {
            std::vector<Piece> finer;
            for (std::size_t begin = 0; begin < pieces.size(); begin += kBatch / 4) {
                const std::size_t end = std::min(begin + kBatch / 4, pieces.size());
                look_at<4>(
                    end - begin, [&](std::size_t i) { return quarters(pieces[begin + i]); }, finer);
                if (looked_ < options_.max_pieces) continue;
                finer.insert(finer.end(), pieces.begin() + static_cast<std::ptrdiff_t>(end),
                             pieces.end());
                break;
            }
            pieces = std::move(finer);
        }
        for (const Piece& piece : pieces) settled_ = std::max(settled_, loose_bound(piece));
        if (known_ > known) where = where_;
        known = known_;
        return std::max(settled_, known_);
    }

private:
    static constexpr std::size_t kBatch = 1 << 15;
    static constexpr double kNoBound = std::numeric_limits<double>::infinity();

    struct Open {
        Part part;
        std::int32_t face;  // to try first; -1: none
    };

    struct Seen {
        double bound = 0.0;
        Piece piece;
    };

    double distance_to(const Vec3& p, std::int32_t face) const
    {
        return to_.on_face(p, face).distance;
    }

    std::array<Piece, 1> whole_face(std::size_t f, const std::vector<ClosestPoint>& nearest) const
    {
        Piece piece;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t v = from_.faces[f][i];
            piece.set(i, from_.vertices[v], nearest[v]);
        }
        return {piece};
    }

    // Quarter 0, 1, 2 keeps that corner, 3 lies in the middle.
    std::array<Piece, 4> quarters(const Piece& whole) const
    {
        std::array<Piece, 4> out{whole, whole, whole, whole};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
            const Vec3 middle = 0.5 * whole.corners[j] + 0.5 * whole.corners[k];
            const ClosestPoint at = to_.near_enough(middle, whole.face[j], known_);
            for (const std::size_t quarter : {j, k, std::size_t{3}})
                out[quarter].set(i, middle, at);
        }
        return out;
    }

    // The distance function grows no faster than one moves, from whichever corner.
    static double loose_bound(const Piece& piece)
    {
        double bound = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            const double far = std::max(distance(piece.corners[i], piece.corners[(i + 1) % 3]),
                                        distance(piece.corners[i], piece.corners[(i + 2) % 3]));
            bound = std::min(bound, piece.distance[i] + far);
        }
        return bound;
    }

    // By the faces nearest to the corners; where that will not do, by parts.
    double bound_of(const Piece& piece) const
    {
        double bound = loose_bound(piece);
        const Part whole(piece.corners.data(), piece.corners.data() + 3);
        for (std::size_t i = 0; i < 3 && bound > enough(); ++i)
            bound = std::min(bound, farthest_from(whole, piece.face[i]));
        constexpr double kFewFaces = 6.0;
        if (bound <= enough() ||
            area_of(piece.corners) > kFewFaces * area_of(to_.corners(piece.face[0])))
            return bound;
        return std::min(bound, bound_by_parts(whole, nearest_of(piece.face, middle_of(whole))));
    }

    // The piece cut along the sides of the faces beneath it: each part is near one face, though the
    // whole is not. Without this, surfaces that lie in each other but are cut into triangles in
    // different ways would have to be split to the last bit wherever sides cross. From the face to
    // start with one comes to the others across its sides, or by the tree.
    double bound_by_parts(const Part& whole, std::int32_t start) const
    {
        std::vector<Open> open{{whole, start}};
        double bound = 0.0;
        for (int budget = 32; !open.empty(); --budget) {
            if (budget == 0) return kNoBound;
            const Open next = open.back();
            open.pop_back();
            double farthest = next.face >= 0 ? settle(next.part, next.face, open) : kNoBound;
            if (farthest > enough()) {
                const Vec3 middle = middle_of(next.part);
                farthest = settle(next.part, to_.nearest(middle, next.face).face, open);
            }
            if (farthest > enough()) return kNoBound;
            bound = std::max(bound, farthest);
        }
        return bound;
    }

    // How far the part is from the face at most, if that is little enough, or else that part of it
    // which lies over the face: the rest is left to the faces beside it.
    double settle(const Part& part, std::int32_t face, std::vector<Open>& open) const
    {
        const double farthest = farthest_from(part, face);
        if (farthest <= enough()) return farthest;
        std::array<Part, 3> beyond;
        const Part over = cut_along(face, part, beyond);
        if (over.size() < 3 || !over.is_whole()) return kNoBound;
        for (const Part& rest : beyond)
            if (!rest.is_whole()) return kNoBound;
        const double farthest_over = farthest_from(over, face);
        if (farthest_over > enough()) return kNoBound;
        for (std::int32_t side = 0; side < 3; ++side)
            if (beyond[side].size() >= 3) open.push_back({beyond[side], to_.across(face, side)});
        return farthest_over;
    }

    // Or something more than enough.
    double farthest_from(const Part& part, std::int32_t face) const
    {
        double farthest = 0.0;
        for (auto p = part.begin(); p != part.end() && farthest <= enough(); ++p)
            farthest = std::max(farthest, distance_to(*p, face));
        return farthest;
    }

    std::int32_t nearest_of(const std::array<std::int32_t, 3>& faces, const Vec3& p) const
    {
        std::int32_t best = faces[0];
        for (const std::int32_t f : {faces[1], faces[2]})
            if (f != best && distance_to(p, f) < distance_to(p, best)) best = f;
        return best;
    }

    // The part over the face; what lies beyond each of its sides is put to `beyond`.
    Part cut_along(std::int32_t face, Part part, std::array<Part, 3>& beyond) const
    {
        const Corners t = to_.corners(face);
        const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
        for (std::size_t side = 0; side < 3 && part.size() >= 3 && part.is_whole(); ++side) {
            const Vec3 inward = cross(normal, t[(side + 1) % 3] - t[side]);
            Part inside;
            for (std::size_t i = 0; i < part.size(); ++i) {
                const Vec3 &p = part[i], &q = part[(i + 1) % part.size()];
                const double at_p = dot(inward, p - t[side]), at_q = dot(inward, q - t[side]);
                (at_p >= 0.0 ? inside : beyond[side]).push_back(p);
                if ((at_p >= 0.0) == (at_q >= 0.0)) continue;
                const double s = at_p / (at_p - at_q);
                const Vec3 crossing = (1.0 - s) * p + s * q;
                inside.push_back(crossing);
                beyond[side].push_back(crossing);
            }
            part = inside;
        }
        return part;
    }

    static double area_of(const Corners& t) { return norm(cross(t[1] - t[0], t[2] - t[0])); }

    // Splitting ends where the bound is good enough, or rounding would be all that is left.
    double enough() const
    {
        const double rounding = 1e-15 * size_;
        return std::max(known_ + std::max(options_.precision * known_, rounding),
                        options_.sufficient);
    }

    template <std::size_t kEach, class MakePieces>
    void look_at(std::size_t n, const MakePieces& make, std::vector<Piece>& open)
    {
        std::vector<Seen> seen(kEach * n);
        parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::array<Piece, kEach> pieces = make(i);
                for (std::size_t k = 0; k < kEach; ++k)
                    seen[kEach * i + k] = {bound_of(pieces[k]), pieces[k]};
            }
        });
        looked_ += static_cast<std::int64_t>(seen.size());
        for (const Seen& s : seen)
            for (std::size_t k = 0; k < 3; ++k)
                if (s.piece.distance[k] > known_) {
                    known_ = s.piece.distance[k];
                    where_ = s.piece.corners[k];
                }
        for (const Seen& s : seen) {
            if (s.bound > enough())
                open.push_back(s.piece);
            else
                settled_ = std::max(settled_, s.bound);
        }
    }

    const IndexedMesh& from_;
    const Target& to_;
    const DistanceOptions& options_;
    double size_ = bounds(from_).diagonal() + norm(bounds(from_).center());
    double known_ = 0.0;
    Vec3 where_;
    double settled_ = 0.0;
    std::int64_t looked_ = 0;
};

OneSidedDistance one_sided(const IndexedMesh& from, const Target& to,
                           const DistanceOptions& options)
{
    constexpr double kDefaultSamples = 100'000;
    const double from_area = area(from);
    const double density = options.density > 0.0 ? options.density
                           : from_area > 0.0     ? kDefaultSamples / from_area
                                                 : 0;

    std::vector<ClosestPoint> nearest(from.n_vertices());
    std::vector<std::uint8_t> used(from.n_vertices(), 0);
    for (const Triangle& face : from.faces)
        for (const std::int32_t v : face) used[v] = 1;
    Sampled total = sample_in_parallel(from.n_vertices(), [&](std::size_t v, Sampled& sampled) {
        if (!used[v]) return;
        // Neighbours in number are so in space as a rule.
        const std::int32_t near = v % kSampleGrain > 0 ? nearest[v - 1].face : -1;
        nearest[v] = to.near_enough(from.vertices[v], near, sampled.max);
        sampled.see(nearest[v].distance, from.vertices[v]);
    });
    if (density > 0.0 && std::isfinite(density))
        total.add(sample_faces(from, to, nearest, options, density));

    OneSidedDistance out;
    out.max = total.max;
    out.where = total.where;
    if (options.mean) out.mean = total.area > 0.0 ? total.weighted / total.area : total.max;
    out.samples = total.n;
    out.bound = std::numeric_limits<double>::infinity();
    if (options.precision > 0.0)
        out.bound = Bounder(from, to, options).run(nearest, out.max, out.where);
    return out;
}

void check_options(const DistanceOptions& options)
{
    require(options.density >= 0.0, "mesh_distance: density", options.density, "at least 0");
    require(options.precision >= 0.0, "mesh_distance: precision", options.precision, "at least 0");
    require(options.sufficient >= 0.0, "mesh_distance: sufficient", options.sufficient,
            "at least 0");
}

}  // namespace

OneSidedDistance one_sided_distance(const IndexedMesh& from, const IndexedMesh& to,
                                    const DistanceOptions& options)
{
    check_options(options);
    if (from.faces.empty()) return {};
    require(!to.faces.empty(), "mesh_distance: one of the meshes has no faces");
    const MeshTree own(from);  // checks it
    return one_sided(from, Target(to), options);
}

MeshDistance mesh_distance(const IndexedMesh& a, const IndexedMesh& b,
                           const DistanceOptions& options)
{
    check_options(options);
    if (a.faces.empty() && b.faces.empty()) return {};
    require(!a.faces.empty() && !b.faces.empty(), "mesh_distance: one of the meshes has no faces");
    const Target tree_a(a), tree_b(b);
    MeshDistance out;
    out.a_to_b = one_sided(a, tree_b, options);
    out.b_to_a = one_sided(b, tree_a, options);
    out.max = std::max(out.a_to_b.max, out.b_to_a.max);
    out.mean = std::max(out.a_to_b.mean, out.b_to_a.mean);
    out.bound = std::max(out.a_to_b.bound, out.b_to_a.bound);
    return out;
}

}  // namespace genus
