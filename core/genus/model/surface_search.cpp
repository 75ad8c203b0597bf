#include "genus/model/surface_search.h"

#include <algorithm>
#include <cmath>

#include "genus/base/parallel.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/model/fans.h"
#include "genus/model/form_signs.h"

namespace genus {

namespace {

constexpr double kSmallBox = 1.0 / 16.0;        // radius, of the tolerance
constexpr double kSmallestBox = 1.0 / 4096.0;   // radius, of the tolerance
constexpr double kLargestShare = 0.125;         // radius of a box that may lie in a sandwich
constexpr double kSmallestShare = 1.0 / 256.0;  // radius of a box that must lie in one
constexpr std::int64_t kMaxBoxes = 2'000'000, kMaxBoxesStrict = 400'000;

class Search {
public:
    explicit Search(const SearchScene& scene)
        : mesh_(scene.mesh),
          outer_(scene.outer),
          inner_(scene.inner),
          open_(scene.open),
          forms_(scene.forms),
          tolerance_(scene.tolerance),
          strict_(scene.strict)
    {
    }

    void run(const Box3& cube, const SignFormula& formula, Certificate& c)
    {
        enough_ = std::min(tolerance_, std::max(c.bound, 0.25 * tolerance_));
        std::vector<Item> level{{cube, formula}};
        while (!level.empty() && c.n_failed <= Certificate::kMostListed &&
               c.n_boxes <= (strict_ ? kMaxBoxesStrict : kMaxBoxes)) {
            c.n_boxes += static_cast<std::int64_t>(level.size());
            std::vector<Outcome> outcomes(level.size());
            parallel_for(level.size(), 16, [&](std::size_t begin, std::size_t end) {
                std::vector<Sign> signs(forms_.size(), Sign{0});
                for (std::size_t i = begin; i < end; ++i) outcomes[i] = look(level[i], signs);
            });
            std::vector<Item> next;
            for (std::size_t i = 0; i < level.size(); ++i) {
                nearness_ = std::max(nearness_, outcomes[i].nearness);
                if (outcomes[i].kind == Outcome::Open) divide(level[i], next);
                if (outcomes[i].kind != Outcome::Failed) continue;
                ++c.n_failed;
                c.failed.push_back(level[i].box);
            }
            level.swap(next);
        }
        if (!level.empty()) {
            c.n_failed += static_cast<std::int64_t>(level.size());
            for (std::size_t i = 0; i < level.size() && i < 64; ++i)
                c.failed.push_back(level[i].box);
        }
        c.bound = std::max(c.bound, nearness_);
    }

private:
    struct Item {
        Box3 box;
        SignFormula formula;  // good for `wide(box)`
    };
    // The box with the surroundings in which ways are sought.
    Box3 wide(const Box3& box) const
    {
        return box.inflated((strict_ ? 8.0 : 2.0) * (box.max[0] - box.min[0]));
    }

    struct Outcome {
        enum Kind { Done, Open, Failed } kind = Done;
        double nearness = 0.0;
    };

    static void divide(const Item& item, std::vector<Item>& next)
    {
        const Vec3 c = item.box.center();
        for (int k = 0; k < 8; ++k) {
            Box3 part = item.box;
            for (std::size_t a = 0; a < 3; ++a)
                ((k >> a & 1) != 0 ? part.min[a] : part.max[a]) = c[a];
            next.push_back({part, item.formula});
        }
    }

    Outcome look(Item& item, std::vector<Sign>& signs) const
    {
        find_signs(item.formula, forms_, item.box, signs);
        const SignFormula here = item.formula.simplified(signs);
        if (here.constant() != 0) return {};
        find_signs(item.formula, forms_, wide(item.box), signs);
        item.formula = item.formula.simplified(signs);
        const double radius = 0.5 * item.box.diagonal();
        const Vec3 c = item.box.center();
        const Ways ways = find_ways(item, here, signs);
        // If the ends have the wrong sign, no point of the box is on the surface.
        if (ways.found && (ways.none || (outer_.winding_number(ways.inside) == 1 &&
                                         inner_.winding_number(ways.outside) == 0)))
            return {};
        if (strict_ && radius <= kLargestShare * tolerance_) {
            if (between(c, radius)) return {};
            if (radius <= kSmallestShare * tolerance_) return {Outcome::Failed};
        } else if (!strict_ && radius <= 0.5 * tolerance_) {
            // Nearness counts towards the bound, so it should not be had too cheaply.
            const double d = (mesh_.nearest(c).distance + radius) * (1.0 + 1e-12);
            if (d <= (radius <= kSmallBox * tolerance_ ? tolerance_ : enough_))
                return {Outcome::Done, d};
            if (radius <= kSmallestBox * tolerance_) return {Outcome::Failed};
        }
        return {ways.found && far_from_mesh(c, radius) ? Outcome::Failed : Outcome::Open};
    }

    // All of the ball lies between M- and M+: it meets neither, and its centre does.
    bool between(const Vec3& c, double radius) const
    {
        const double far = radius * (1.0 + 1e-9);
        return outer_.nearest(c, far).face < 0 && inner_.nearest(c, far).face < 0 &&
               outer_.winding_number(c) == 1 && inner_.winding_number(c) == 0;
    }

    bool far_from_mesh(const Vec3& c, double radius) const
    {
        const double far = radius + tolerance_;
        return mesh_.nearest(c, far).face < 0;
    }

    struct Ways {
        bool found = false, none = false;
        Vec3 inside, outside;
    };

    struct Directed {
        std::int32_t surface;
        double sign;
    };
    static bool directed(const SignFormula& f, std::vector<Directed>& out)
    {
        out.clear();
        for (std::size_t i = 0; i < f.surfaces().size(); ++i) {
            const SignFormula::Use use = f.uses()[i];
            if (use.plain == use.negated) return false;
            out.push_back({f.surfaces()[i], use.plain ? 1.0 : -1.0});
        }
        return true;
    }

    // Points c - Hd and c + Hd that all points of the box reach on ways along which every surface
    // that decides there falls, or grows.
    Ways find_ways(const Item& item, const SignFormula& here, std::vector<Sign>& signs) const
    {
        std::vector<Directed> near;
        if (here.surfaces().size() > 12 || !directed(here, near)) return {};
        const Vec3 c = item.box.center(), half = 0.5 * item.box.size();
        for (int attempt = 0; attempt < 3; ++attempt) {
            std::vector<Vec3> normals;
            for (const Directed& s : near)
                normals.push_back(s.sign * normalized(forms_[s.surface].gradient(c)));
            const std::vector<double> ones(normals.size(), 1.0);
            const auto shortest = shortest_direction(normals, ones);
            if (!shortest || norm(*shortest) > (strict_ ? 8.0 : 2.0)) return {};
            const Vec3 d = normalized(*shortest);
            double height = 0.0;
            for (const Vec3& n : normals) {
                const double across = std::fabs(n[0]) * half[0] + std::fabs(n[1]) * half[1] +
                                      std::fabs(n[2]) * half[2];
                height = std::max(height, across / dot(n, d));
            }
            height *= 1.3;
            const Vec3 up = height * d;
            Box3 hull = item.box;
            hull.add(c + up);
            hull.add(c - up);
            if (!wide(item.box).contains(hull) || meets_open_face(hull)) return {};
            find_signs(item.formula, forms_, hull, signs);
            const SignFormula around = item.formula.simplified(signs);
            std::vector<Directed> all;
            if (around.surfaces().size() > 12 || !directed(around, all)) return {};
            if (all.size() == near.size()) {
                const bool grow = std::all_of(all.begin(), all.end(), [&](const Directed& s) {
                    return forms_[s.surface].grows_towards(c, half, up, hull, s.sign);
                });
                if (!grow) return {};
                return ends(around, c - up, c + up, signs);
            }
            near.swap(all);
        }
        return {};
    }

    bool meets_open_face(const Box3& hull) const
    {
        bool any = false;
        open_.visit_overlapping(hull, [&](std::int32_t) { any = true; });
        return any;
    }

    Ways ends(const SignFormula& f, const Vec3& inside, const Vec3& outside,
              std::vector<Sign>& signs) const
    {
        Ways ways{true, false, inside, outside};
        const auto sign_at = [&](const Vec3& p) {
            for (const std::int32_t s : f.surfaces()) signs[s] = forms_[s].sign(p);
            return f.sign_by_cases(signs);
        };
        ways.none = sign_at(inside) > 0 || sign_at(outside) < 0;
        return ways;
    }

    MeshTree mesh_, outer_, inner_;
    BoxTree open_;
    const std::vector<SurfaceForm>& forms_;
    double tolerance_;
    bool strict_;
    double enough_ = 0.0;
    double nearness_ = 0.0;
};

}  // namespace

void find_surface_near(const SearchScene& scene, const Box3& cube, const SignFormula& formula,
                       Certificate& c)
{
    Search(scene).run(cube, formula, c);
}

}  // namespace genus
