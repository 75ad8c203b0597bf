#include "genus/model/deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Sampler {
public:
    Sampler(const SurfaceMesh& mesh, const SignFormula& formula,
            const std::vector<SurfaceForm>& forms)
        : m_(mesh), formula_(formula), forms_(forms)
    {
    }

    double from_mesh() const
    {
        const std::size_t n = m_.mesh.n_faces();
        constexpr std::size_t kGrain = 512;
        std::vector<double> most((n + kGrain - 1) / kGrain, 0.0);
        parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            double& here = most[begin / kGrain];
            for (std::size_t f = begin; f < end; ++f) here = face_deviation(f, here, signs);
        });
        return most.empty() ? 0.0 : *std::max_element(most.begin(), most.end());
    }

    double from_solid(const Box3& box, std::size_t n_lines) const
    {
        if (m_.mesh.faces.empty()) return 0.0;
        const MeshTree tree(m_.mesh);
        std::vector<double> most(n_lines, 0.0);
        parallel_for(n_lines, 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t i = begin; i < end; ++i) {
                std::uint64_t seed = 0x5851f42d4c957f2dull * (i + 1);
                const Vec3 a = random_point(box, seed), b = random_point(box, seed);
                for (const Vec3& p : crossings(a, b, signs))
                    most[i] = std::max(most[i], tree.nearest(p).distance);
            }
        });
        return *std::max_element(most.begin(), most.end());
    }

private:
    double face_deviation(std::size_t f, double most, std::vector<Sign>& signs) const
    {
        const Triangle& t = m_.mesh.faces[f];
        const std::array<Vec3, 3> p{m_.mesh.vertices[t[0]], m_.mesh.vertices[t[1]],
                                    m_.mesh.vertices[t[2]]};
        std::vector<std::int32_t> near{m_.surface_of_face[f] >> 1};
        for (const std::int32_t v : t)
            for (const std::int32_t s : m_.surfaces_of_vertex[v])
                if (s >= 0 && std::find(near.begin(), near.end(), s) == near.end())
                    near.push_back(s);
        const double reach =
            2.0 * std::max({distance(p[0], p[1]), distance(p[1], p[2]), distance(p[2], p[0])});
        const auto look = [&](const Vec3& x) {
            // Well below the largest so far: spare the work.
            if (near.size() == 1) {
                const double g = norm(forms_[near[0]].gradient(x));
                if (g > 0.0 && std::fabs(forms_[near[0]].value(x)) < 0.8 * most * g) return;
            }
            most = std::max(most, distance_to_solid(x, near, reach, signs));
        };
        look((p[0] + p[1] + p[2]) / 3.0);
        for (std::size_t i = 0; i < 3; ++i)
            if (t[i] < t[(i + 1) % 3]) look(0.5 * (p[i] + p[(i + 1) % 3]));
        return most;
    }

    // Distance to the nearest point of the surfaces in `near`, of their curves and corners, that
    // lies on the solid.
    double distance_to_solid(const Vec3& x, const std::vector<std::int32_t>& near, double reach,
                             std::vector<Sign>& signs) const
    {
        double least = kInfinity, any = kInfinity;
        const auto attempt = [&](std::initializer_list<std::int32_t> chosen) {
            std::array<const SurfaceForm*, 3> on{};
            std::size_t n = 0;
            for (const std::int32_t s : chosen) on[n++] = &forms_[s];
            const auto p = project(std::span(on.data(), n), x, reach);
            if (!p) return;
            const double d = distance(*p, x);
            any = std::min(any, d);
            if (d < least && on_solid(*p, chosen, signs)) least = d;
        };
        for (std::size_t i = 0; i < near.size(); ++i) {
            attempt({near[i]});
            if (near.size() > 6) continue;
            for (std::size_t j = i + 1; j < near.size(); ++j) {
                attempt({near[i], near[j]});
                for (std::size_t k = j + 1; k < near.size(); ++k)
                    attempt({near[i], near[j], near[k]});
            }
        }
        if (least < kInfinity) return least;
        return any < kInfinity ? any : 0.0;
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

    static Vec3 random_point(const Box3& box, std::uint64_t& state)
    {
        Vec3 p;
        for (std::size_t i = 0; i < 3; ++i) {
            state += 0x9e3779b97f4a7c15ull;
            std::uint64_t z = state;
            z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
            z = (z ^ z >> 27) * 0x94d049bb133111ebull;
            z ^= z >> 31;
            p[i] = box.min[i] + static_cast<double>(z >> 11) * 0x1p-53 * (box.max[i] - box.min[i]);
        }
        return p;
    }

    bool inside(const Vec3& p, std::vector<Sign>& signs) const
    {
        for (const std::int32_t s : formula_.surfaces())
            signs[s] = forms_[s].value(p) <= 0.0 ? Sign{-1} : Sign{1};
        return formula_.sign(signs) < 0;
    }

    std::vector<Vec3> crossings(const Vec3& a, const Vec3& b, std::vector<Sign>& signs) const
    {
        constexpr int kSteps = 48;
        std::vector<Vec3> found;
        bool before = inside(a, signs);
        for (int i = 1; i <= kSteps; ++i) {
            double lo = static_cast<double>(i - 1) / kSteps, hi = static_cast<double>(i) / kSteps;
            const bool after = inside(a + hi * (b - a), signs);
            if (after == before) continue;
            for (int step = 0; step < 50; ++step) {
                const double mid = 0.5 * (lo + hi);
                (inside(a + mid * (b - a), signs) == before ? lo : hi) = mid;
            }
            found.push_back(a + 0.5 * (lo + hi) * (b - a));
            before = after;
        }
        return found;
    }

    const SurfaceMesh& m_;
    const SignFormula& formula_;
    const std::vector<SurfaceForm>& forms_;
};

}  // namespace

double measure_deviation(const SurfaceMesh& mesh, const SignFormula& formula,
                         const std::vector<SurfaceForm>& forms, const Box3& box)
{
    if (formula.constant() != 0) return 0.0;
    const Sampler sampler(mesh, formula, forms);
    const double there = sampler.from_mesh();
    return std::max(there, sampler.from_solid(box, 1000));
}

}  // namespace genus
