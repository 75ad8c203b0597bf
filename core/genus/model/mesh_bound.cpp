#include "genus/model/mesh_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "genus/base/halves.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/model/form_signs.h"

namespace genus {

namespace {

constexpr int kDeepest = 8;      // quarterings of a face
constexpr int kDeepestBox = 60;  // halvings of the box
constexpr double kNear = 1e-3;   // of the largest distance: the first that is tried
constexpr int kBisections = 4;
constexpr double kSmall = 1.0 / 16.0;  // of the distance that is enough: parts are not cut further
constexpr double kUp = 1.0 + 1e-9;     // covers what distances round

/// Of a formula at a place, 0 where rounding leaves it open.
Sign side_of(const SignFormula& formula, const std::vector<SurfaceForm>& forms, const Vec3& q,
             std::vector<Sign>& signs)
{
    for (const std::int32_t s : formula.surfaces()) signs[s] = forms[s].sign(q);
    return formula.sign(signs);
}

/// From the surface of the solid to the mesh.
class BoxSearch {
public:
    BoxSearch(const MeshTree& tree, const std::vector<SurfaceForm>& forms)
        : tree_(tree), forms_(forms)
    {
    }

    MeshBound run(const Box3& box, const SignFormula& formula, double enough, double most,
                  std::int64_t max_boxes) const
    {
        std::vector<Open> open{{box, std::make_shared<SignFormula>(formula)}};
        double bound = 0.0;  // of the boxes that are done
        std::int64_t n_boxes = 1;
        for (int depth = 0; !open.empty(); ++depth) {
            current_progress().check();
            look_at(open, most);
            double exceeded = 0.0;
            for (const Open& o : open) exceeded = std::max(exceeded, o.exceeded);
            if (exceeded > 0.0) return {std::nullopt, exceeded};
            // Once halving all of them would be too much, only those are that have to be.
            const auto n_above = std::count_if(
                open.begin(), open.end(), [&](const Open& o) { return !is_done(o, enough, most); });
            const double limit = n_boxes + 4 * n_above > max_boxes ? most : enough;
            std::vector<Open> next;
            for (Open& o : open) {
                if (is_done(o, limit, most))
                    bound = std::max(bound, o.farthest);
                else
                    halve(o, next);
            }
            n_boxes += static_cast<std::int64_t>(next.size());
            if (n_boxes > max_boxes || (depth == kDeepestBox && !next.empty())) return {};
            open = std::move(next);
        }
        return {bound, 0.0};
    }

private:
    struct Open {
        Box3 box;
        std::shared_ptr<const SignFormula> formula;
        double farthest = 0.0;  // no point of the surface in the box is farther from the mesh
        double exceeded = 0.0;  // one is that far, if that is too much
    };

    // Small ones would gain little.
    static bool is_done(const Open& o, double limit, double most)
    {
        return o.farthest <= limit ||
               (o.farthest <= most && o.box.diagonal() <= 2.0 * kSmall * limit);
    }

    void look_at(std::vector<Open>& open, double most) const
    {
        parallel_for(open.size(), 64, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            for (std::size_t i = begin; i < end; ++i) {
                Open& o = open[i];
                find_signs(*o.formula, forms_, o.box, signs);
                SignFormula here = o.formula->simplified(signs);
                for (const std::int32_t s : o.formula->surfaces()) signs[s] = 0;
                if (here.constant() != 0) continue;  // no surface: `farthest` stays zero
                o.formula = std::make_shared<SignFormula>(std::move(here));
                const double away = tree_.nearest(o.box.center()).distance;
                const double half = 0.5 * o.box.diagonal();
                o.farthest = kUp * (away + half);
                if (away > kUp * (most + half) && has_surface(o, signs)) o.exceeded = away - half;
            }
        });
    }

    // Whether corners of the box are on both sides.
    bool has_surface(const Open& o, std::vector<Sign>& signs) const
    {
        bool inside = false, outside = false;
        for (int corner = 0; corner < 8; ++corner) {
            const Sign side = side_of(*o.formula, forms_, o.box.corner(corner), signs);
            inside = inside || side < 0;
            outside = outside || side > 0;
        }
        for (const std::int32_t s : o.formula->surfaces()) signs[s] = 0;
        return inside && outside;
    }

    static void halve(const Open& o, std::vector<Open>& into)
    {
        for (const Box3& half : halves(o.box)) into.push_back({half, o.formula});
    }

    const MeshTree& tree_;
    const std::vector<SurfaceForm>& forms_;
};

Vec3 normal_of(const std::array<Vec3, 3>& face)
{
    const Vec3 normal = cross(face[1] - face[0], face[2] - face[0]);
    const double length = norm(normal);
    return length > 0.0 ? normal / length : Vec3{{1, 0, 0}};
}

/// From the mesh to the surface of the solid.
class FaceSearch {
public:
    FaceSearch(const SignFormula& formula, const std::vector<SurfaceForm>& forms, const Box3& box,
               double enough, double most)
        : formula_(formula),
          forms_(forms),
          box_(box),
          enough_(enough),
          most_(most),
          signs_(forms.size(), Sign{0})
    {
    }

    /// Such that the surface is that near to p, or something above `most`: at twice the distance
    /// each time, then between the last two.
    double away(const Vec3& p, const Vec3& across)
    {
        double low = 0.0, high = kNear * most_;
        while (!has_surface(p, across, high)) {
            if (high >= most_) return 2.0 * most_;
            low = high;
            high = std::min(2.0 * high, most_);
        }
        for (int step = 0; step < kBisections && low > 0.0; ++step) {
            const double middle = 0.5 * (low + high);
            (has_surface(p, across, middle) ? high : low) = middle;
        }
        return high;
    }

    /// How far the points of a face are from the surface at most, or something above `most`.
    double farthest(const std::array<Vec3, 3>& face, const std::array<double, 3>& away_at)
    {
        return farthest(face, away_at, normal_of(face), 0);
    }

private:
    double farthest(const std::array<Vec3, 3>& p, const std::array<double, 3>& away_at,
                    const Vec3& across, int depth)
    {
        const double longest =
            std::max({distance(p[0], p[1]), distance(p[1], p[2]), distance(p[2], p[0])});
        // Any point is that near to all corners, or to some.
        const auto [nearest, farthest_away] = std::minmax({away_at[0], away_at[1], away_at[2]});
        const double here =
            kUp * std::min(nearest + longest, farthest_away + longest / std::sqrt(3.0));
        const bool is_small = longest <= kSmall * enough_ && here <= most_;
        if (here <= enough_ || is_small || depth == kDeepest) return here;
        std::array<Vec3, 3> middle;  // of the side from corner i
        std::array<double, 3> away_there{};
        for (std::size_t i = 0; i < 3; ++i) {
            middle[i] = 0.5 * (p[i] + p[(i + 1) % 3]);
            away_there[i] = away(middle[i], across);
        }
        double most = farthest(middle, away_there, across, depth + 1);
        for (std::size_t i = 0; i < 3 && most <= most_; ++i) {
            const std::size_t j = (i + 2) % 3;
            most = std::max(
                most, farthest({p[i], middle[i], middle[j]},
                               {away_at[i], away_there[i], away_there[j]}, across, depth + 1));
        }
        return std::min(here, most);
    }

    /// Whether p and places at this distance of it, along `across` and the axes, are on different
    /// sides.
    bool has_surface(const Vec3& p, const Vec3& across, double at)
    {
        bool inside = false, outside = false;
        const auto ask = [&](const Vec3& q) {
            const Sign side = side_at(q);
            inside = inside || side < 0;
            outside = outside || side > 0;
            return inside && outside;
        };
        if (ask(p) || ask(p + at * across) || ask(p - at * across)) return true;
        for (std::size_t k = 0; k < 3; ++k)
            for (const double sign : {1.0, -1.0}) {
                Vec3 q = p;
                q[k] += sign * at;
                if (ask(q)) return true;
            }
        return false;
    }

    /// Outside of the box there is no solid.
    Sign side_at(const Vec3& q)
    {
        return box_.contains(q) ? side_of(formula_, forms_, q, signs_) : Sign{1};
    }

    const SignFormula& formula_;
    const std::vector<SurfaceForm>& forms_;
    const Box3& box_;
    double enough_, most_;
    std::vector<Sign> signs_;
};

/// Nothing if one face is not shown to be within `most`.
std::optional<double> mesh_to_surface(const IndexedMesh& mesh, const SignFormula& formula,
                                      const std::vector<SurfaceForm>& forms, const Box3& box,
                                      double enough, double most)
{
    constexpr std::size_t kGrain = 256;
    const auto corners = [&](std::size_t f) {
        const Triangle& t = mesh.faces[f];
        return std::array{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    };
    std::vector<Vec3> across(mesh.n_vertices());
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        for (const std::int32_t v : mesh.faces[f]) across[v] = normal_of(corners(f));
    std::vector<double> away(mesh.n_vertices(), 0.0);
    parallel_for(away.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        FaceSearch search(formula, forms, box, enough, most);
        for (std::size_t v = begin; v < end; ++v)
            away[v] = search.away(mesh.vertices[v], across[v]);
    });
    std::vector<double> farthest((mesh.n_faces() + kGrain - 1) / kGrain, 0.0);
    parallel_for(mesh.n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
        FaceSearch search(formula, forms, box, enough, most);
        double& here = farthest[begin / kGrain];
        for (std::size_t f = begin; f < end && here <= most; ++f) {
            const Triangle& t = mesh.faces[f];
            here =
                std::max(here, search.farthest(corners(f), {away[t[0]], away[t[1]], away[t[2]]}));
        }
    });
    const double all = *std::max_element(farthest.begin(), farthest.end());
    if (!(all <= most)) return std::nullopt;
    return all;
}

}  // namespace

MeshBound bound_by_boxes(const IndexedMesh& mesh, const SignFormula& formula,
                         const std::vector<SurfaceForm>& forms, const Box3& box, double enough,
                         double most, std::int64_t max_boxes)
{
    if (mesh.faces.empty()) return {};
    const MeshTree tree(mesh);
    MeshBound result = BoxSearch(tree, forms).run(box, formula, enough, most, max_boxes);
    if (!result.bound) return result;
    const auto there = mesh_to_surface(mesh, formula, forms, box, enough, most);
    if (!there) return {};
    return {std::max(*there, *result.bound), 0.0};
}

}  // namespace genus
