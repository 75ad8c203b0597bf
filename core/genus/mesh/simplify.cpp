#include "genus/mesh/simplify.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/collapse_mesh.h"
#include "genus/mesh/distance.h"
#include "genus/mesh/measure.h"

namespace genus {

namespace {

// Sum of weighted squared distances to planes, x^T A x + 2 b^T x + c, and of the weights.
struct Quadric {
    double a00 = 0, a01 = 0, a02 = 0, a11 = 0, a12 = 0, a22 = 0;
    Vec3 b;
    double c = 0, weight = 0;

    static Quadric of_plane(const Vec3& unit_normal, const Vec3& point, double weight)
    {
        const Vec3& n = unit_normal;
        const double d = -dot(n, point), w = weight;
        Quadric q;
        q.a00 = w * n[0] * n[0];
        q.a01 = w * n[0] * n[1];
        q.a02 = w * n[0] * n[2];
        q.a11 = w * n[1] * n[1];
        q.a12 = w * n[1] * n[2];
        q.a22 = w * n[2] * n[2];
        q.b = (w * d) * n;
        q.c = w * d * d;
        q.weight = w;
        return q;
    }

    Quadric& operator+=(const Quadric& o)
    {
        a00 += o.a00;
        a01 += o.a01;
        a02 += o.a02;
        a11 += o.a11;
        a12 += o.a12;
        a22 += o.a22;
        b += o.b;
        c += o.c;
        weight += o.weight;
        return *this;
    }

    double operator()(const Vec3& p) const
    {
        const Vec3 ap{{a00 * p[0] + a01 * p[1] + a02 * p[2], a01 * p[0] + a11 * p[1] + a12 * p[2],
                       a02 * p[0] + a12 * p[1] + a22 * p[2]}};
        return dot(p, ap) + 2.0 * dot(b, p) + c;
    }

    // Where it is least; no value where that is no one point, as on a plane or along an edge.
    std::optional<Vec3> least() const
    {
        const Vec3 r0{{a00, a01, a02}}, r1{{a01, a11, a12}}, r2{{a02, a12, a22}};
        const Vec3 c01 = cross(r0, r1), c12 = cross(r1, r2), c20 = cross(r2, r0);
        const double det = dot(r0, c12), trace = a00 + a11 + a22;
        constexpr double kLeast = 1e-4;  // of the cube of the mean eigenvalue
        if (!(det > kLeast * trace * trace * trace / 27.0)) return std::nullopt;
        return (c12 * b[0] + c20 * b[1] + c01 * b[2]) / -det;
    }
};

struct Candidate {
    double cost;  // squared distance, not negative
    std::int32_t side;
    std::int32_t stamp;
};

// The cheapest first, up to an eighth of the cost: those as cheap come in the order in which they
// went in, neighbours one after the other. A heap would be exact, and slower by half: it takes
// edges from all over the mesh, none of them in the cache.
class CandidateQueue {
public:
    CandidateQueue() : buckets_(kBuckets) {}

    void push(const Candidate& c)
    {
        const std::size_t b = bucket_of(c.cost);
        buckets_[b].waiting.push_back(c);
        least_ = std::min(least_, b);
    }

    // None if all are gone.
    std::optional<Candidate> pop()
    {
        for (; least_ < kBuckets; ++least_) {
            Bucket& bucket = buckets_[least_];
            if (bucket.first < bucket.waiting.size()) return bucket.waiting[bucket.first++];
            bucket = {};
        }
        return std::nullopt;
    }

    // That which is to come after so many others, if they are as cheap.
    const Candidate* upcoming(std::size_t n) const
    {
        if (least_ >= kBuckets) return nullptr;
        const Bucket& bucket = buckets_[least_];
        return n < bucket.waiting.size() - bucket.first ? &bucket.waiting[bucket.first + n]
                                                        : nullptr;
    }

private:
    struct Bucket {
        std::vector<Candidate> waiting;
        std::size_t first = 0;
    };

    // Exponent and three bits of the mantissa.
    static constexpr int kShift = 49;
    static constexpr std::size_t kBuckets = std::size_t{1} << (63 - kShift);
    static std::size_t bucket_of(double cost)
    {
        return static_cast<std::size_t>(std::bit_cast<std::uint64_t>(cost + 0.0) >> kShift);
    }

    std::vector<Bucket> buckets_;
    std::size_t least_ = kBuckets;
};

class Simplifier {
public:
    // Points relative to `origin`, so that a mesh far out loses nothing.
    Simplifier(const CollapseMesh& mesh, const std::vector<Vec3>& points, const Vec3& origin)
        : mesh_(mesh),
          vertices_(points.size()),
          versions_(points.size(), 0),
          queued_(mesh.n_sides(), 0)
    {
        for (std::size_t v = 0; v < points.size(); ++v) vertices_[v].point = points[v] - origin;
        gather_quadrics();
        for_each_side([&](Side s) {
            if (mesh_.opposite(s) < s) push(s);
        });
    }

    // Until the next edge errs by more than `limit` or so many faces are left. The least error that
    // was too much, infinity if none was.
    double run(double limit, std::int64_t max_faces)
    {
        const double limit2 = limit * limit;
        double refused2 = std::numeric_limits<double>::infinity();
        for (std::size_t n = 0; static_cast<std::int64_t>(mesh_.n_faces()) > max_faces; ++n) {
            if (n % 4096 == 0) current_progress().check();
            const std::optional<Candidate> candidate = queue_.pop();
            if (!candidate) break;
            fetch_ahead();
            const Candidate& next = *candidate;
            const Side s = next.side;
            if (next.cost > limit2 && mesh_.is_alive(s)) refused2 = std::min(refused2, next.cost);
            if (next.cost > 2.0 * limit2) break;  // all that follow err more
            queued_[s] = 0;
            if (next.cost > limit2 || !mesh_.is_alive(s)) continue;
            // Costs grow as a rule: those of edges that changed are computed anew only here.
            if (stamp(s) != next.stamp)
                push(s);
            else
                collapse(s);
        }
        return std::sqrt(refused2);
    }

    IndexedMesh result(const Vec3& origin) const
    {
        IndexedMesh out;
        std::vector<std::int32_t> number(vertices_.size(), -1);
        for (std::size_t v = 0; v < vertices_.size(); ++v) {
            if (mesh_.leaving(static_cast<std::int32_t>(v)) == CollapseMesh::kNone) continue;
            number[v] = static_cast<std::int32_t>(out.n_vertices());
            out.vertices.push_back(vertices_[v].point + origin);
        }
        for_each_side([&](Side s) {
            if (s % 3 == 0)
                out.faces.push_back(
                    {number[mesh_.from(s)], number[mesh_.from(s + 1)], number[mesh_.from(s + 2)]});
        });
        return out;
    }

private:
    using Side = CollapseMesh::Side;

    // What an edge needs to know of an end, together in memory.
    struct VertexData {
        Quadric quadric;
        Vec3 point;
    };

    template <class Visit>
    void for_each_side(Visit&& visit) const
    {
        for (Side s = 0; s < static_cast<Side>(mesh_.n_sides()); ++s)
            if (mesh_.is_alive(s)) visit(s);
    }

    VertexData& from(Side s) { return vertices_[mesh_.from(s)]; }
    VertexData& to(Side s) { return vertices_[mesh_.to(s)]; }
    const VertexData& from(Side s) const { return vertices_[mesh_.from(s)]; }
    const VertexData& to(Side s) const { return vertices_[mesh_.to(s)]; }

    // Edges come from all over the mesh, and most of the time would go by waiting for memory.
    GENUS_PREFETCHING void fetch_ahead() const
    {
        if (const Candidate* later = queue_.upcoming(24)) mesh_.prefetch_side(later->side);
        const Candidate* soon = queue_.upcoming(10);
        if (!soon || !mesh_.is_alive(soon->side)) return;
        for (const VertexData* end : {&from(soon->side), &to(soon->side)}) {
            prefetch(&end->quadric);
            prefetch(&end->point);
        }
    }

    Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) const
    {
        return cross(b - a, c - a);
    }

    void gather_quadrics()
    {
        for_each_side([&](Side s) {
            if (s % 3 == 0) add_plane(s);
        });
        for_each_side([&](Side s) {
            if (mesh_.opposite(s) == CollapseMesh::kNone) add_border_plane(s);
        });
    }

    void add_plane(Side s)
    {
        const Vec3& a = from(s).point;
        const Vec3 n = area_vector(a, from(s + 1).point, from(s + 2).point);
        const double area = norm(n);
        if (!(area > 0.0)) return;
        const Quadric q = Quadric::of_plane(n / area, a, area);
        for (const Side corner : {s, s + 1, s + 2}) from(corner).quadric += q;
    }

    // The plane through a boundary edge at a right angle to its face.
    void add_border_plane(Side s)
    {
        const Vec3 &a = from(s).point, &b = to(s).point;
        const Vec3 n = area_vector(a, b, from(CollapseMesh::previous(s)).point);
        const Vec3 across = cross(b - a, n);
        if (!(norm(across) > 0.0)) return;
        const Quadric q = Quadric::of_plane(normalized(across), a, dot(b - a, b - a));
        from(s).quadric += q;
        to(s).quadric += q;
    }

    Vec3 place(Side s, const Quadric& q) const
    {
        const Vec3 &a = from(s).point, &b = to(s).point;
        if (const std::optional<Vec3> p = q.least()) {
            // Far off the edge the quadric knows nothing of the surface.
            const Vec3 middle = 0.5 * a + 0.5 * b;
            if (dot(*p - middle, *p - middle) <= 4.0 * dot(b - a, b - a)) return *p;
        }
        const Vec3 middle = 0.5 * a + 0.5 * b;
        const double at_a = q(a), at_b = q(b), at_middle = q(middle);
        if (at_middle <= at_a && at_middle <= at_b) return middle;
        return at_a <= at_b ? a : b;
    }

    Quadric sum(Side s) const
    {
        Quadric q = from(s).quadric;
        q += to(s).quadric;
        return q;
    }

    double cost(Side s) const
    {
        const Quadric q = sum(s);
        return q.weight > 0.0 ? std::max(0.0, q(place(s, q)) / q.weight) : 0.0;
    }

    // The faces round `v` but those beside s, with v moved to p: none turns over or vanishes.
    bool faces_stay(std::int32_t v, Side s, const Vec3& p) const
    {
        constexpr double kLeastCosine = 0.1;
        const std::int32_t beside = s / 3;
        const Side o = mesh_.opposite(s);
        bool stay = true;
        mesh_.visit_leaving(v, [&](Side x) {
            if (!stay || x / 3 == beside || (o >= 0 && x / 3 == o / 3)) return;
            const Vec3 &b = to(x).point, &c = from(CollapseMesh::previous(x)).point;
            const Vec3 before = area_vector(vertices_[v].point, b, c), after = area_vector(p, b, c);
            const double before2 = dot(before, before), after2 = dot(after, after);
            const double cosine = dot(before, after);
            const bool turns =
                before2 > 0.0 &&
                (cosine <= 0.0 || cosine * cosine < kLeastCosine * kLeastCosine * before2 * after2);
            stay = after2 > 0.0 && !turns;
        });
        return stay;
    }

    void collapse(Side s)
    {
        const Quadric q = sum(s);
        const Vec3 p = place(s, q);
        const std::int32_t kept = mesh_.to(s);
        if (!faces_stay(mesh_.from(s), s, p) || !faces_stay(kept, s, p)) return;
        if (!mesh_.collapse(s)) return;
        vertices_[kept] = {q, p};
        versions_[kept] = ++last_version_;
        // An edge that was two may have lost the entries of both.
        mesh_.visit_leaving(kept, [&](Side x) {
            push_if_missing(x);
            if (const Side y = CollapseMesh::previous(x); mesh_.opposite(y) == CollapseMesh::kNone)
                push_if_missing(y);
        });
    }

    void push_if_missing(Side s)
    {
        const Side o = mesh_.opposite(s);
        if (!queued_[s] && (o == CollapseMesh::kNone || !queued_[o])) push(s);
    }

    void push(Side s)
    {
        queue_.push({cost(s), s, stamp(s)});
        queued_[s] = 1;
    }

    // Grows whenever an end of the edge changes.
    std::int32_t stamp(Side s) const { return versions_[mesh_.from(s)] + versions_[mesh_.to(s)]; }

    CollapseMesh mesh_;
    std::vector<VertexData> vertices_;
    std::vector<std::int32_t> versions_;  // by vertex; asked much more often than the rest
    std::int32_t last_version_ = 0;
    std::vector<std::uint8_t> queued_;  // by side
    CandidateQueue queue_;
};

// The limits to the quadric error that are tried: smaller until the bound is within the tolerance,
// then larger, three times at most, while much of the tolerance is left.
class Limits {
public:
    explicit Limits(double tolerance) : tolerance_(tolerance), next_(tolerance) {}

    double next() const { return next_; }
    int tried() const { return tried_; }

    // What the limit came to: the bound, and the least error that was refused. False if another
    // would not be worth its time.
    bool note(double bound, double refused)
    {
        ++tried_;
        // The quadric error is about proportional to the distance.
        const double fitting = bound > 0.0 ? kAim * tolerance_ / bound : kMostGrowth;
        if (bound <= tolerance_) {
            held_ = next_;
            if (bound >= kEnough * tolerance_) return false;
            next_ *= std::clamp(fitting, 1.0, kMostGrowth);
        } else {
            failed_ = next_;
            next_ *= std::clamp(fitting, kMostShrinking, kLeastShrinking);
        }
        if (held_ == 0.0) return tried_ < kAttempts;
        if (std::isfinite(failed_)) next_ = std::sqrt(held_ * failed_);
        if (bound <= tolerance_) refused_ = refused;
        return ++larger_ <= kLarger && tried_ < kAttempts && next_ > refused_;
    }

private:
    static constexpr double kAim = 0.9, kEnough = 0.8;
    static constexpr double kMostGrowth = 1.5, kMostShrinking = 0.05, kLeastShrinking = 0.75;
    static constexpr int kAttempts = 8, kLarger = 3;

    double tolerance_, next_;
    double held_ = 0.0, failed_ = std::numeric_limits<double>::infinity();  // the last of each
    double refused_ = 0.0;                                                  // at the last that held
    int tried_ = 0, larger_ = 0;
};

void compare(const IndexedMesh& mesh, const SimplifyOptions& options, SimplifiedMesh& out)
{
    DistanceOptions distance;
    const double size = bounds(mesh).diagonal(), surface = area(mesh);
    constexpr double kSamples = 20'000;
    if (surface > 0.0) distance.density = kSamples / surface;
    distance.precision = options.certify ? 0.05 : 0.0;
    distance.mean = false;
    distance.sufficient = std::min(0.25 * options.tolerance, 1e-3 * size);
    const MeshDistance d = mesh_distance(mesh, out.mesh, distance);
    out.measured = d.max;
    out.certified = options.certify;
    out.bound = options.certify ? d.bound : d.max;
}

}  // namespace

SimplifiedMesh simplify(const IndexedMesh& mesh, const SimplifyOptions& options)
{
    require(options.tolerance > 0.0, "simplify: tolerance", options.tolerance, "positive");
    const std::int64_t max_faces = options.max_faces.value_or(0);
    require(max_faces >= 0, "simplify: max_faces", static_cast<double>(max_faces), "at least 0");
    require(options.max_faces || std::isfinite(options.tolerance),
            "simplify: give a tolerance or max_faces");
    for (std::size_t v = 0; v < mesh.n_vertices(); ++v)
        if (!is_finite(mesh.vertices[v]))
            throw InvalidInput("simplify: vertex " + std::to_string(v) + " is not finite");
    const CollapseMesh sides{TriangleHalfedgeMesh(mesh)};
    const Vec3 origin = mesh.vertices.empty() ? Vec3{} : bounds(mesh).center();
    SimplifiedMesh best;
    bool any = false, again = true;
    Limits limits(options.tolerance);
    while (again) {
        Simplifier simplifier(sides, mesh.vertices, origin);
        const double refused = simplifier.run(limits.next(), max_faces);
        SimplifiedMesh out;
        out.mesh = simplifier.result(origin);
        compare(mesh, options, out);
        again = limits.note(out.bound, refused);
        if (out.bound > options.tolerance) continue;
        if (!any || out.mesh.n_faces() < best.mesh.n_faces()) best = std::move(out);
        any = true;
    }
    if (!any) {
        best.mesh = mesh;
        compare(mesh, options, best);
    }
    best.attempts = limits.tried();
    return best;
}

}  // namespace genus
