#include "genus/model/fibres.h"

#include <algorithm>
#include <array>

#include "genus/base/parallel.h"
#include "genus/model/form_signs.h"

namespace genus {

namespace {

constexpr int kDeepest = 5;

struct Prism {
    std::array<Vec3, 6> corners;  // three of M-, then three of M+

    Vec3 fibre(std::size_t i) const { return corners[i + 3] - corners[i]; }
    std::array<Prism, 4> quarters() const
    {
        std::array<std::array<Vec3, 3>, 2> middle;  // opposite the corners
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t i = 0; i < 3; ++i)
                middle[side][i] =
                    0.5 * (corners[3 * side + (i + 1) % 3] + corners[3 * side + (i + 2) % 3]);
        std::array<Prism, 4> parts;
        for (std::size_t side = 0; side < 2; ++side) {
            for (std::size_t k = 0; k < 3; ++k) {
                parts[k].corners[3 * side] = corners[3 * side + k];
                parts[k].corners[3 * side + 1] = middle[side][(k + 2) % 3];
                parts[k].corners[3 * side + 2] = middle[side][(k + 1) % 3];
            }
            for (std::size_t i = 0; i < 3; ++i) parts[3].corners[3 * side + i] = middle[side][i];
        }
        return parts;
    }
};

class PrismCheck {
public:
    PrismCheck(const std::vector<SurfaceForm>& forms, double short_enough)
        : forms_(forms), short_enough_(short_enough), signs_(forms.size(), Sign{0})
    {
    }

    bool left_once(const Prism& prism, const SignFormula& formula, int depth)
    {
        find_signs(formula, forms_, std::span<const Vec3>(prism.corners), signs_);
        const SignFormula here = formula.simplified(signs_);
        if (here.constant() == 0 && all_grow(prism, here)) return true;
        if (const double length = longest_fibre(prism); length <= short_enough_) {
            longest_short_ = std::max(longest_short_, length);
            return true;
        }
        if (here.constant() != 0) return false;
        if (depth == kDeepest) return false;
        for (const Prism& part : prism.quarters())
            if (!left_once(part, here, depth + 1)) return false;
        return true;
    }

    double longest_short() const { return longest_short_; }

private:
    static double longest_fibre(const Prism& prism)
    {
        return std::max({norm(prism.fibre(0)), norm(prism.fibre(1)), norm(prism.fibre(2))});
    }

    bool all_grow(const Prism& prism, const SignFormula& f) const
    {
        for (std::size_t n = 0; n < f.surfaces().size(); ++n) {
            const SignFormula::Use use = f.uses()[n];
            if (use.plain == use.negated) return false;
            const SurfaceForm& form = forms_[f.surfaces()[n]];
            for (std::size_t i = 0; i < 3; ++i)
                if (!(form.least_slope(prism.corners, prism.fibre(i), use.plain ? 1.0 : -1.0) >
                      0.0))
                    return false;
        }
        return true;
    }

    const std::vector<SurfaceForm>& forms_;
    double short_enough_, longest_short_ = 0.0;
    std::vector<Sign> signs_;
};

}  // namespace

DoubtfulPrisms doubtful_prisms(const SurfaceMesh& mesh, const Sandwich& sandwich,
                               const SignFormula& formula, const std::vector<SurfaceForm>& forms,
                               double short_enough)
{
    constexpr std::size_t kGrain = 64;
    const std::size_t n = mesh.mesh.n_faces();
    std::vector<char> doubtful(n, 0);
    std::vector<double> longest(n / kGrain + 1, 0.0);
    parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
        PrismCheck check(forms, short_enough);
        for (std::size_t f = begin; f < end; ++f) {
            Prism prism;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int32_t v = mesh.mesh.faces[f][i];
                prism.corners[i] = sandwich.inner.vertices[v];
                prism.corners[i + 3] = sandwich.outer.vertices[v];
            }
            doubtful[f] = check.left_once(prism, formula, 0) ? 0 : 1;
        }
        longest[begin / kGrain] = check.longest_short();
    });
    DoubtfulPrisms found;
    for (std::size_t f = 0; f < n; ++f)
        if (doubtful[f] != 0) found.faces.push_back(static_cast<std::int32_t>(f));
    found.longest_short = *std::max_element(longest.begin(), longest.end());
    return found;
}

}  // namespace genus
