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

// Splits [0, n) into chunks, lets `work(index, sampled)` fill one for each, and adds them in order.
template <class Work>
Sampled sample_in_parallel(std::size_t n, const Work& work)
{
    constexpr std::size_t kGrain = 256;
    std::vector<Sampled> parts((n + kGrain - 1) / kGrain);
    parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) work(i, parts[begin / kGrain]);
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

Sampled sample_faces(const IndexedMesh& from, const MeshTree& to, double density)
{
    return sample_in_parallel(from.n_faces(), [&](std::size_t f, Sampled& sampled) {
        const Corners t = corners_of(from, f);
        Random random(f);
        const double face_area = area_of(t);
        const std::int64_t wanted = samples_in(face_area, density, random);
        if (wanted == 0) return;
        const auto k = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(wanted))));
        double sum = 0.0;
        for (std::int64_t i = 0; i < k * k; ++i) {
            if (i % 1024 == 1023) current_progress().check();
            const Vec3 p = sample_of(t, i, k, random);
            const double distance = to.nearest(p).distance;
            sum += distance;
            sampled.see(distance, p);
        }
        // A face drawn by chance stands for more area than its own.
        const double stands_for = std::max(face_area, 1.0 / density);
        sampled.weighted += stands_for * sum / static_cast<double>(k * k);
        sampled.area += stands_for;
    });
}

// ---- branch and bound ---------------------------------------------------------------------------

struct Piece {
    Corners corners;
    std::array<double, 3> distance;  // of the corners
};

struct Nearby {
    std::int32_t face;
    double distance;
};

class Bounder {
public:
    Bounder(const IndexedMesh& from, const MeshTree& to, const DistanceOptions& options)
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
            look_at(
                end - begin, [&](std::size_t i) { return whole_face(begin + i, nearest); }, pieces);
        }
        while (!pieces.empty() && looked_ < options_.max_pieces) {
            std::vector<Piece> finer;
            for (std::size_t begin = 0; begin < pieces.size(); begin += kBatch / 4) {
                const std::size_t end = std::min(begin + kBatch / 4, pieces.size());
                look_at(
                    4 * (end - begin),
                    [&](std::size_t i) { return quarter(pieces[begin + i / 4], i % 4); }, finer);
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

    struct Candidate {
        Piece piece;
        std::array<std::int32_t, 3> faces;  // of `to_`, near the corners
    };
    struct Seen {
        bool open = false;
        double bound = 0.0;
        Piece piece;
    };

    double distance_to(const Vec3& p, std::int32_t face) const
    {
        const Corners t = corners_of(to_.mesh(), face);
        return distance(p, closest_point(p, t[0], t[1], t[2]));
    }

    Candidate whole_face(std::size_t face, const std::vector<ClosestPoint>& nearest) const
    {
        Candidate c;
        c.piece.corners = corners_of(from_, face);
        for (std::size_t i = 0; i < 3; ++i) {
            const ClosestPoint& at = nearest[from_.faces[face][i]];
            c.piece.distance[i] = at.distance;
            c.faces[i] = at.face;
        }
        return c;
    }

    // Quarter 0, 1, 2 keeps that corner, 3 lies in the middle.
    Candidate quarter(const Piece& whole, std::size_t which) const
    {
        const Corners& t = whole.corners;
        const Corners middles{0.5 * t[1] + 0.5 * t[2], 0.5 * t[2] + 0.5 * t[0],
                              0.5 * t[0] + 0.5 * t[1]};
        Candidate c;
        c.piece.corners = middles;
        if (which < 3) c.piece.corners[which] = t[which];
        for (std::size_t i = 0; i < 3; ++i) {
            const ClosestPoint at = to_.nearest(c.piece.corners[i]);
            c.piece.distance[i] = at.distance;
            c.faces[i] = at.face;
        }
        return c;
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

    double bound_by_face(const Piece& piece, std::int32_t face) const
    {
        double farthest = 0.0;
        for (const Vec3& corner : piece.corners)
            farthest = std::max(farthest, distance_to(corner, face));
        return farthest;
    }

    // By the faces nearest to the corners; where that will not do, by the one nearest to the
    // middle: corners on an edge of the other mesh may all have found the faces beyond it.
    double bound_of(const Candidate& c) const
    {
        double bound = loose_bound(c.piece);
        for (std::size_t i = 0; i < 3 && bound > enough(); ++i)
            bound = std::min(bound, bound_by_face(c.piece, c.faces[i]));
        if (bound <= enough()) return bound;
        const Corners& t = c.piece.corners;
        const Vec3 middle = (1.0 / 3.0) * t[0] + (1.0 / 3.0) * t[1] + (1.0 / 3.0) * t[2];
        const std::int32_t face = to_.nearest(middle).face;
        bound = std::min(bound, bound_by_face(c.piece, face));
        constexpr double kFewFaces = 6.0;
        if (bound <= enough() || area_of(t) > kFewFaces * area_of(corners_of(to_.mesh(), face)))
            return bound;
        return std::min(bound, bound_by_parts(t));
    }

    // The piece cut along the sides of the faces beneath it: each part is near one face, though the
    // whole is not. Without this, surfaces that lie in each other but are cut into triangles in
    // different ways would have to be split to the last bit wherever sides cross.
    double bound_by_parts(const Corners& t) const
    {
        constexpr double kNone = std::numeric_limits<double>::infinity();
        std::vector<std::vector<Vec3>> open{{t[0], t[1], t[2]}};
        double bound = 0.0;
        for (int budget = 32; !open.empty(); --budget) {
            if (budget == 0) return kNone;
            std::vector<Vec3> part = std::move(open.back());
            open.pop_back();
            Vec3 middle;
            for (const Vec3& p : part) middle += p / static_cast<double>(part.size());
            const std::int32_t face = to_.nearest(middle).face;
            double farthest = farthest_from(part, face);
            if (farthest > enough()) {
                part = cut_along(face, std::move(part), open);
                farthest = part.size() < 3 ? kNone : farthest_from(part, face);
            }
            if (farthest > enough()) return kNone;
            bound = std::max(bound, farthest);
        }
        return bound;
    }

    double farthest_from(const std::vector<Vec3>& part, std::int32_t face) const
    {
        double farthest = 0.0;
        for (const Vec3& p : part) farthest = std::max(farthest, distance_to(p, face));
        return farthest;
    }

    // The part over the face; what lies beyond its sides goes to `beyond`.
    std::vector<Vec3> cut_along(std::int32_t face, std::vector<Vec3> part,
                                std::vector<std::vector<Vec3>>& beyond) const
    {
        const Corners t = corners_of(to_.mesh(), face);
        const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
        for (std::size_t side = 0; side < 3 && part.size() >= 3; ++side) {
            const Vec3 inward = cross(normal, t[(side + 1) % 3] - t[side]);
            std::vector<Vec3> inside, outside;
            for (std::size_t i = 0; i < part.size(); ++i) {
                const Vec3 &p = part[i], &q = part[(i + 1) % part.size()];
                const double at_p = dot(inward, p - t[side]), at_q = dot(inward, q - t[side]);
                (at_p >= 0.0 ? inside : outside).push_back(p);
                if ((at_p >= 0.0) == (at_q >= 0.0)) continue;
                const double s = at_p / (at_p - at_q);
                const Vec3 crossing = (1.0 - s) * p + s * q;
                inside.push_back(crossing);
                outside.push_back(crossing);
            }
            if (outside.size() >= 3) beyond.push_back(std::move(outside));
            part = std::move(inside);
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

    template <class MakeCandidate>
    void look_at(std::size_t n, const MakeCandidate& candidate, std::vector<Piece>& open)
    {
        std::vector<Seen> seen(n);
        parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Candidate c = candidate(i);
                seen[i] = {false, bound_of(c), c.piece};
            }
        });
        looked_ += static_cast<std::int64_t>(n);
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
    const MeshTree& to_;
    const DistanceOptions& options_;
    double size_ = bounds(from_).diagonal() + norm(bounds(from_).center());
    double known_ = 0.0;
    Vec3 where_;
    double settled_ = 0.0;
    std::int64_t looked_ = 0;
};

OneSidedDistance one_sided(const IndexedMesh& from, const MeshTree& to,
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
        nearest[v] = to.nearest(from.vertices[v]);
        sampled.see(nearest[v].distance, from.vertices[v]);
    });
    if (density > 0.0 && std::isfinite(density)) total.add(sample_faces(from, to, density));

    OneSidedDistance out;
    out.max = total.max;
    out.where = total.where;
    out.mean = total.area > 0.0 ? total.weighted / total.area : total.max;
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
    return one_sided(from, MeshTree(to), options);
}

MeshDistance mesh_distance(const IndexedMesh& a, const IndexedMesh& b,
                           const DistanceOptions& options)
{
    check_options(options);
    if (a.faces.empty() && b.faces.empty()) return {};
    require(!a.faces.empty() && !b.faces.empty(), "mesh_distance: one of the meshes has no faces");
    const MeshTree tree_a(a), tree_b(b);
    MeshDistance out;
    out.a_to_b = one_sided(a, tree_b, options);
    out.b_to_a = one_sided(b, tree_a, options);
    out.max = std::max(out.a_to_b.max, out.b_to_a.max);
    out.mean = std::max(out.a_to_b.mean, out.b_to_a.mean);
    out.bound = std::max(out.a_to_b.bound, out.b_to_a.bound);
    return out;
}

}  // namespace genus
