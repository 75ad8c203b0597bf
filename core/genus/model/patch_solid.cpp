#include "genus/model/patch_solid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "genus/base/error.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/measure.h"
#include "genus/model/freeform.h"

namespace genus {

namespace {

std::uint64_t mixed(std::uint64_t hash, double value)
{
    hash ^= std::bit_cast<std::uint64_t>(value + 0.0) + 0x9e3779b97f4a7c15U + (hash << 6U) +
            (hash >> 2U);
    return hash * 0xbf58476d1ce4e5b9U;
}

// Points of patches near points of a mesh of them: the parameters of the nearest face, then steps
// of Gauss and Newton.
class OnPatches {
public:
    OnPatches(const PatchModel& model, const TessellatedPatches& made)
        : patches_(model.patches()), made_(made), tree_(made_.mesh)
    {
    }

    std::optional<Vec3> near(const Vec3& p) const
    {
        const ClosestPoint at = tree_.nearest(p);
        if (at.face < 0) return std::nullopt;
        const auto f = static_cast<std::size_t>(at.face);
        const Vec3 b = shares(at.point, made_.mesh.faces[f]);
        Vec2 uv{};
        for (std::size_t k = 0; k < 3; ++k) uv += b[k] * made_.corners[f][k];
        return std::visit([&](const auto& patch) { return closest(patch, p, uv); },
                          patches_[static_cast<std::size_t>(made_.patch_of_face[f])]);
    }

private:
    // Barycentric coordinates.
    Vec3 shares(const Vec3& p, const Triangle& t) const
    {
        const auto corner = [&](std::size_t k) {
            return made_.mesh.vertices[static_cast<std::size_t>(t[k])];
        };
        const Vec3 a = corner(0), e = corner(1) - a, g = corner(2) - a, n = cross(e, g);
        const double area = dot(n, n);
        if (!(area > 0.0)) return {{1, 0, 0}};
        const double x = dot(cross(p - a, g), n) / area, y = dot(cross(e, p - a), n) / area;
        return {{1.0 - x - y, x, y}};
    }

    static Vec2 in_domain(const TensorPatch&, Vec2 uv)
    {
        return {{std::clamp(uv[0], 0.0, 1.0), std::clamp(uv[1], 0.0, 1.0)}};
    }
    static Vec2 in_domain(const BezierTriangle&, Vec2 uv)
    {
        for (double& c : uv.c) c = std::max(c, 0.0);
        const double sum = uv[0] + uv[1];
        return sum > 1.0 ? uv / sum : uv;
    }

    template <class P>
    static Vec3 closest(const P& patch, const Vec3& p, Vec2 uv)
    {
        uv = in_domain(patch, uv);
        Vec3 best = patch.value(uv[0], uv[1]);
        for (int step = 0; step < 4; ++step) {
            const SurfacePoint s = patch.partials(uv[0], uv[1]);
            const double uu = dot(s.pu, s.pu), cross_term = dot(s.pu, s.pv), vv = dot(s.pv, s.pv);
            const double d = uu * vv - cross_term * cross_term;
            const Vec3 r = p - s.p;
            const double ru = dot(r, s.pu), rv = dot(r, s.pv);
            const Vec2 move{{(vv * ru - cross_term * rv) / d, (uu * rv - cross_term * ru) / d}};
            if (!std::isfinite(move[0]) || !std::isfinite(move[1])) break;
            uv = in_domain(patch, uv + move);
            const Vec3 next = patch.value(uv[0], uv[1]);
            if (!(distance(next, p) < distance(best, p))) break;
            best = next;
        }
        return best;
    }

    const std::vector<Patch>& patches_;
    TessellatedPatches made_;
    MeshTree tree_;
};

class PatchSource final : public FreeformSource {
public:
    explicit PatchSource(const PatchModel& model) : model_(model), bounds_(model.bounds())
    {
        for (const Patch& patch : model.patches())
            std::visit(
                [&](const auto& p) {
                    for (const Vec3& x : p.points())
                        for (const double c : x.c) hash_ = mixed(hash_, c);
                    for (const double w : p.weights()) hash_ = mixed(hash_, w);
                },
                patch);
    }

    Box3 bounds() const override { return bounds_; }
    std::string describe() const override
    {
        return "solid of " + std::to_string(model_.patches().size()) + " patches";
    }
    std::uint64_t hash() const override { return hash_; }
    bool equals(const FreeformSource& other) const override
    {
        const auto* o = dynamic_cast<const PatchSource*>(&other);
        return o && hash_ == o->hash_ && model_.patches() == o->model_.patches();
    }
    Meshed mesh(double tolerance, const Limits& limits) const override
    {
        TessellatedPatches made = model_.tessellate({tolerance, limits.max_triangles});
        Meshed result;
        result.bound = made.bound;
        result.certified = true;
        if (limits.measure) result.measured = measured_deviation(model_.patches(), made);
        if (limits.to_surface)
            result.to_surface = [on = std::make_shared<const OnPatches>(model_, made)](
                                    const Vec3& p) { return on->near(p); };
        result.mesh = std::move(made.mesh);
        require(measure(result.mesh).volume > 0.0,
                "patches: the surface is turned inside out: exchange u and v of all patches");
        return result;
    }

private:
    PatchModel model_;
    Box3 bounds_;
    std::uint64_t hash_ = 0x94d049bb133111ebU;
};

std::string number_of(const PatchEdgeUse& use)
{
    return "edge " + std::to_string(use.edge) + " of patch " + std::to_string(use.patch);
}

void require_closed(const PatchModel& model)
{
    if (model.patches().empty()) throw InvalidInput("patches: there are none");
    for (const auto& users : model.edges()) {
        if (users.size() == 1)
            throw InvalidInput("patches: the surface is open at " + number_of(users[0]) +
                               " (both count from 0)");
        if (users.size() > 2)
            throw InvalidInput("patches: " + std::to_string(users.size()) +
                               " patches meet in one edge, " + number_of(users[0]) +
                               " (both count from 0)");
        if (users[0].forward == users[1].forward)
            throw InvalidInput("patches: " + number_of(users[0]) + " and " + number_of(users[1]) +
                               " run the same way: the front of one is inside (both count from 0)");
    }
}

}  // namespace

Solid patch_solid(const PatchModel& model)
{
    require_closed(model);
    return freeform(std::make_shared<const PatchSource>(model));
}

}  // namespace genus
