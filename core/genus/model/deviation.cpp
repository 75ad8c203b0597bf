#include "genus/model/deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/model/form_signs.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Sampler {
public:
    Sampler(const SurfaceMesh& mesh, const SignFormula& formula,
            const std::vector<SurfaceForm>& forms, bool by_sides)
        : m_(mesh), formula_(formula), forms_(forms), by_sides_(by_sides)
    {
    }

    double from_mesh() const
    {
        const std::size_t n = m_.mesh.n_faces(), sampled = std::min(n, kMostFaces);
        constexpr std::size_t kGrain = 512;
        std::vector<double> most((sampled + kGrain - 1) / kGrain, 0.0);
        parallel_for(sampled, kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            double& here = most[begin / kGrain];
            for (std::size_t i = begin; i < end; ++i)
                here = face_deviation(one_of(i * n / sampled, (i + 1) * n / sampled), here, signs);
        });
        return most.empty() ? 0.0 : *std::max_element(most.begin(), most.end());
    }

    // `expected`: about how far the mesh is from the solid.
    double from_solid(const Box3& box, double expected) const
    {
        if (m_.mesh.faces.empty()) return 0.0;
        std::vector<std::vector<Vec3>> on_line(kLines);
        parallel_for(kLines, 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t i = begin; i < end; ++i) {
                std::uint64_t seed = 0x5851f42d4c957f2dull * (i + 1);
                const Vec3 a = random_point(box, seed), b = random_point(box, seed);
                on_line[i] = crossings(a, b, signs);
            }
        });
        std::vector<Vec3> points;
        for (const std::vector<Vec3>& some : on_line)
            points.insert(points.end(), some.begin(), some.end());
        return farthest(points, std::max(4.0 * expected, 1e-6 * box.diagonal()));
    }

private:
    static constexpr std::size_t kMostFaces = 1 << 15, kLines = 1000;

    // A face of begin .. end - 1, so chosen that the choice keeps no step.
    static std::size_t one_of(std::size_t begin, std::size_t end)
    {
        std::uint64_t state = begin;
        return begin + next_random(state) % (end - begin);
    }

    // The largest distance of a point from the mesh, most of them expected within `reach`. Faces
    // look for points near them: a tree over the faces would cost more than all the rest.
    double farthest(const std::vector<Vec3>& points, double reach) const
    {
        if (points.empty()) return 0.0;
        std::vector<Box3> boxes;
        for (const Vec3& p : points) boxes.push_back(Box3{p, p}.inflated(reach));
        const BoxTree tree(boxes);
        constexpr std::size_t kGrain = 1 << 14;
        const std::size_t n = m_.mesh.n_faces();
        std::vector<std::vector<double>> squares((n + kGrain - 1) / kGrain);
        parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<double>& here = squares[begin / kGrain];
            here.assign(points.size(), kInfinity);
            for (std::size_t f = begin; f < end; ++f) {
                const std::array<Vec3, 3> c = corners(f);
                Box3 box;
                for (const Vec3& p : c) box.add(p);
                tree.visit_overlapping(box, [&](std::int32_t i) {
                    const Vec3 d = closest_point(points[i], c[0], c[1], c[2]) - points[i];
                    here[i] = std::min(here[i], dot(d, d));
                });
            }
        });
        double most = 0.0;
        std::vector<Vec3> far;
        for (std::size_t i = 0; i < points.size(); ++i) {
            double least = kInfinity;
            for (const std::vector<double>& block : squares) least = std::min(least, block[i]);
            if (least <= reach * reach)
                most = std::max(most, std::sqrt(least));
            else
                far.push_back(points[i]);
        }
        if (far.empty()) return most;
        const MeshTree faces(m_.mesh);
        for (const Vec3& p : far) most = std::max(most, faces.nearest(p).distance);
        return most;
    }

    std::array<Vec3, 3> corners(std::size_t f) const
    {
        const Triangle& t = m_.mesh.faces[f];
        return {m_.mesh.vertices[t[0]], m_.mesh.vertices[t[1]], m_.mesh.vertices[t[2]]};
    }

    double face_deviation(std::size_t f, double most, std::vector<Sign>& signs) const
    {
        const Triangle& t = m_.mesh.faces[f];
        const std::array<Vec3, 3> p = corners(f);
        std::vector<std::int32_t> near{m_.surface_of_face[f] >> 1};
        for (const std::int32_t v : t)
            for (const std::int32_t s : m_.surfaces_of_vertex[v])
                if (s >= 0 && std::find(near.begin(), near.end(), s) == near.end())
                    near.push_back(s);
        const double reach =
            2.0 * std::max({distance(p[0], p[1]), distance(p[1], p[2]), distance(p[2], p[0])});
        const Vec3 normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
        const auto look = [&](const Vec3& x) {
            if (by_sides_) {
                most = std::max(most, to_other_side(x, normal, most, reach, signs));
                return;
            }
            // Well below the largest so far: spare the work.
            if (near.size() == 1) {
                const double g = norm(forms_[near[0]].gradient(x));
                if (g > 0.0 && std::fabs(forms_[near[0]].value(x)) < 0.8 * most * g) return;
            }
            const Distances own = distances(x, near, reach, signs);
            double d = own.on_solid;
            // Before it counts, the other surfaces round x are looked at too.
            if (d > most) {
                const double far = std::min(d, reach);
                d = std::min(d, distances(x, surfaces_within(x, far, signs), far, signs).on_solid);
            }
            if (d == kInfinity) d = own.on_any < kInfinity ? own.on_any : 0.0;
            most = std::max(most, d);
        };
        look((p[0] + p[1] + p[2]) / 3.0);
        for (std::size_t i = 0; i < 3; ++i)
            if (t[i] < t[(i + 1) % 3]) look(0.5 * (p[i] + p[(i + 1) % 3]));
        return most;
    }

    // From x along the normal, either way, to where the side changes, or along an axis, as beside
    // a face with no width; anything below `least` if that is nearer, `most` if it is farther.
    double to_other_side(const Vec3& x, const Vec3& normal, double least, double most,
                         std::vector<Sign>& signs) const
    {
        double nearest = to_other_side_along(x, normal, least, most, signs);
        for (std::size_t axis = 0; axis < 3 && nearest > least; ++axis) {
            Vec3 direction;
            direction[axis] = 1.0;
            nearest = std::min(nearest, to_other_side_along(x, direction, least, nearest, signs));
        }
        return nearest;
    }

    double to_other_side_along(const Vec3& x, const Vec3& direction, double least, double most,
                               std::vector<Sign>& signs) const
    {
        constexpr double kFirst = 0x1p-12;  // of `most`
        constexpr int kHalvings = 5;
        Sides sides(*this, signs);
        const auto changes = [&](double t) {
            return sides.inside(x - t * direction) != sides.inside(x + t * direction);
        };
        double low = 0.0, high = std::max(least, kFirst * most);
        while (!changes(high)) {
            if (high >= most) return most;
            low = std::exchange(high, std::min(2.0 * high, most));
        }
        if (low == 0.0) return high;
        for (int step = 0; step < kHalvings; ++step) {
            const double middle = 0.5 * (low + high);
            (changes(middle) ? high : low) = middle;
        }
        return high;
    }

    // The surfaces that decide within `far` of x.
    std::vector<std::int32_t> surfaces_within(const Vec3& x, double far,
                                              std::vector<Sign>& signs) const
    {
        const Box3 box = Box3{x, x}.inflated(far);
        find_signs(formula_, forms_, box, signs);
        return formula_.simplified(signs).surfaces();
    }

    // To the nearest point of some surfaces, of their curves and corners: one that lies on the
    // solid, and any.
    struct Distances {
        double on_solid = kInfinity, on_any = kInfinity;
    };
    Distances distances(const Vec3& x, const std::vector<std::int32_t>& near, double reach,
                        std::vector<Sign>& signs) const
    {
        constexpr std::size_t kFew = 6;
        if (near.size() > kFew) return distances_by_nearest(x, near, kFew, reach, signs);
        return distances(x, near, near.size(), reach, signs);
    }

    // There may be many: curves and corners of the nearest only.
    Distances distances_by_nearest(const Vec3& x, const std::vector<std::int32_t>& near,
                                   std::size_t n_few, double reach, std::vector<Sign>& signs) const
    {
        std::vector<std::pair<double, std::int32_t>> by_distance;
        for (const std::int32_t s : near) {
            const double d = forms_[s].distance(x);
            by_distance.emplace_back(std::isnan(d) ? 0.0 : d, s);
        }
        std::sort(by_distance.begin(), by_distance.end());
        std::vector<std::int32_t> sorted;
        for (const auto& [d, s] : by_distance) sorted.push_back(s);
        return distances(x, sorted, n_few, reach, signs);
    }

    Distances distances(const Vec3& x, const std::vector<std::int32_t>& near, std::size_t n_few,
                        double reach, std::vector<Sign>& signs) const
    {
        Distances least;
        const auto attempt = [&](std::initializer_list<std::int32_t> chosen) {
            std::array<const SurfaceForm*, 3> on{};
            std::size_t n = 0;
            for (const std::int32_t s : chosen) on[n++] = &forms_[s];
            const auto p = project(std::span(on.data(), n), x, reach);
            if (!p) return;
            const double d = distance(*p, x);
            least.on_any = std::min(least.on_any, d);
            if (d < least.on_solid && on_solid(*p, chosen, signs)) least.on_solid = d;
        };
        for (std::size_t i = 0; i < near.size(); ++i) {
            attempt({near[i]});
            for (std::size_t j = i + 1; j < n_few; ++j) {
                attempt({near[i], near[j]});
                for (std::size_t k = j + 1; k < n_few; ++k) attempt({near[i], near[j], near[k]});
            }
        }
        return least;
    }

    bool on_solid(const Vec3& p, std::initializer_list<std::int32_t> on,
                  std::vector<Sign>& signs) const
    {
        for (const std::int32_t s : formula_.surfaces()) {
            const double value = forms_[s].value(p), slack = forms_[s].slack();
            signs[s] = value > slack ? Sign{1} : value < -slack ? Sign{-1} : Sign{0};
        }
        for (const std::int32_t s : on) signs[s] = 0;
        return formula_.sign_by_cases(signs) == 0;
    }

    static std::uint64_t next_random(std::uint64_t& state)
    {
        state += 0x9e3779b97f4a7c15ull;
        std::uint64_t z = state;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ z >> 27) * 0x94d049bb133111ebull;
        return z ^ z >> 31;
    }

    static Vec3 random_point(const Box3& box, std::uint64_t& state)
    {
        Vec3 p;
        for (std::size_t i = 0; i < 3; ++i)
            p[i] = box.min[i] + static_cast<double>(next_random(state) >> 11) * 0x1p-53 *
                                    (box.max[i] - box.min[i]);
        return p;
    }

    // Which side of the solid points are on; the formula is asked only where a sign has changed.
    class Sides {
    public:
        Sides(const Sampler& sampler, std::vector<Sign>& signs) : sampler_(sampler), signs_(signs)
        {
            std::fill(signs.begin(), signs.end(), Sign{0});
        }
        bool inside(const Vec3& p)
        {
            bool changed = false;
            for (const std::int32_t s : sampler_.formula_.surfaces()) {
                const Sign now = sampler_.forms_[s].value(p) <= 0.0 ? Sign{-1} : Sign{1};
                changed = changed || now != signs_[s];
                signs_[s] = now;
            }
            if (changed) inside_ = sampler_.formula_.sign(signs_) < 0;
            return inside_;
        }

    private:
        const Sampler& sampler_;
        std::vector<Sign>& signs_;
        bool inside_ = false;
    };

    std::vector<Vec3> crossings(const Vec3& a, const Vec3& b, std::vector<Sign>& signs) const
    {
        constexpr int kSteps = 48, kBisections = 44;
        Sides sides(*this, signs);
        std::vector<Vec3> found;
        bool before = sides.inside(a);
        for (int i = 1; i <= kSteps; ++i) {
            double lo = static_cast<double>(i - 1) / kSteps, hi = static_cast<double>(i) / kSteps;
            const bool after = sides.inside(a + hi * (b - a));
            if (after == before) continue;
            for (int step = 0; step < kBisections; ++step) {
                const double mid = 0.5 * (lo + hi);
                (sides.inside(a + mid * (b - a)) == before ? lo : hi) = mid;
            }
            found.push_back(a + 0.5 * (lo + hi) * (b - a));
            before = after;
        }
        return found;
    }

    const SurfaceMesh& m_;
    const SignFormula& formula_;
    const std::vector<SurfaceForm>& forms_;
    bool by_sides_;
};

}  // namespace

double measure_deviation(const SurfaceMesh& mesh, const SignFormula& formula,
                         const std::vector<SurfaceForm>& forms, const Box3& box, bool by_sides)
{
    if (formula.constant() != 0) return 0.0;
    const Sampler sampler(mesh, formula, forms, by_sides);
    const double there = sampler.from_mesh();
    return std::max(there, sampler.from_solid(box, there));
}

}  // namespace genus
