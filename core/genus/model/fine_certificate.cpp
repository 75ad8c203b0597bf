#include "genus/model/fine_certificate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "genus/base/parallel.h"
#include "genus/base/predicates.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/disjoint_sets.h"
#include "genus/model/form_signs.h"
#include "genus/model/two_lanes.h"

namespace genus {

namespace {

constexpr int kMaxRounds = 16;
constexpr double kGrowth = 1.25, kFirstStep = 0.125;

// The meshes N+ and N-.
class Offsets {
public:
    Offsets(const FineMesh& fine, const SignFormula& formula, const std::vector<SurfaceForm>& forms,
            double tolerance)
        : fine_(fine), m_(fine.surface), formula_(formula), forms_(forms), tolerance_(tolerance)
    {
        find_blocks();
        first_offsets();
    }

    // Returns the faces of the coarse mesh in which signs are missing in the end.
    std::vector<std::int32_t> grow()
    {
        const std::size_t n = m_.mesh.n_faces();
        std::vector<char> open(n, 3), moved(m_.mesh.n_vertices(), 1);
        for (int round = 0; round < kMaxRounds; ++round) {
            current_progress().check();
            if (!check_faces(moved, open)) return {};
            std::fill(moved.begin(), moved.end(), 0);
            bool any = false;
            for (std::size_t f = 0; f < n; ++f) {
                if (open[f] == 0) continue;
                for (const std::int32_t v : m_.mesh.faces[f]) moved[v] |= open[f];
            }
            for (std::size_t v = 0; v < moved.size(); ++v)
                if (moved[v] != 0) any = widen(v, moved[v]) || any;
            if (!any) break;
        }
        std::vector<std::int32_t> failed;
        for (std::size_t part = 0; part + 1 < fine_.first_face.size(); ++part)
            if (std::any_of(open.begin() + fine_.first_face[part],
                            open.begin() + fine_.first_face[part + 1],
                            [](char sides) { return sides != 0; }))
                failed.push_back(static_cast<std::int32_t>(part));
        return failed;
    }

    void report(Certificate& c) const
    {
        c.rounding = rounding_;
        for (std::size_t v = 0; v < offset_.size(); ++v) {
            double& part = m_.surfaces_of_vertex[v][1] >= 0 ? c.creases : c.faces;
            const double offset = std::max(offset_[v][0], offset_[v][1]);
            const Vec3& d = fine_.direction[v];
            if (offset * offset * dot(d, d) > 0.999 * part * part)
                part = std::max(part, offset * norm(d));
        }
        c.bound = std::max({c.bound, c.creases, c.faces});
    }

    // Calls visit(face) for all that may meet the box once moved, to either side, and some more.
    template <class Visit>
    void visit_near(const Box3& box, Visit&& visit) const
    {
        for (const Block& block : blocks_)
            if (overlap(block.box, box))
                for (std::int64_t f = block.begin; f < block.end; ++f) visit(m_.mesh.faces[f]);
    }

    // A vertex of N+ (side 0) or N-.
    Vec3 corner(std::int32_t v, int side) const
    {
        const double step = side == 0 ? offset_[v][0] : -offset_[v][1];
        return m_.mesh.vertices[v] + step * fine_.direction[v];
    }

private:
    // The values there of the first surface that the vertex stands on.
    std::array<double, 2> values_at(std::size_t v) const
    {
        const SurfaceForm& form = forms_[m_.surfaces_of_vertex[v][0]];
        const auto i = static_cast<std::int32_t>(v);
        return {form.value(corner(i, 0)), form.value(corner(i, 1))};
    }

    // Some faces from one face of the coarse mesh, with what holds them moved as far as they may
    // be.
    struct Block {
        std::int64_t begin = 0, end = 0;
        Box3 box;
    };

    void find_blocks()
    {
        constexpr std::int64_t kFaces = 32;
        const std::size_t n = fine_.first_face.size() - 1;
        first_block_.assign(n + 1, 0);
        for (std::size_t part = 0; part < n; ++part) {
            const std::int64_t size = fine_.first_face[part + 1] - fine_.first_face[part];
            first_block_[part + 1] =
                first_block_[part] + static_cast<std::size_t>((size + kFaces - 1) / kFaces);
        }
        blocks_.resize(first_block_[n]);
        parallel_for(n, 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t part = begin; part < end; ++part) {
                std::int64_t f = fine_.first_face[part];
                for (std::size_t i = first_block_[part]; i < first_block_[part + 1]; ++i) {
                    Block& block = blocks_[i];
                    block.begin = f;
                    block.end = std::min(f + kFaces, fine_.first_face[part + 1]);
                    for (; f < block.end; ++f)
                        for (const std::int32_t v : m_.mesh.faces[f])
                            block.box.add(m_.mesh.vertices[v]);
                    block.box = block.box.inflated(1.01 * tolerance_);
                }
            }
        });
    }

    double rounding_at(std::size_t v) const
    {
        double most = 0.0;
        for (const std::int32_t s : m_.surfaces_of_vertex[v])
            if (s >= 0)
                most = std::max(
                    most, 4.0 * forms_[s].slack() / norm(forms_[s].gradient(m_.mesh.vertices[v])));
        return most;
    }

    void first_offsets()
    {
        const std::size_t n = m_.mesh.n_vertices();
        offset_ = fine_.reach;
        value_.resize(n);
        constexpr std::size_t kGrain = 2048;
        std::vector<double> roundings(n / kGrain + 1, 0.0);
        parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
            double& worst = roundings[begin / kGrain];
            for (std::size_t v = begin; v < end; ++v) {
                const double rounding = rounding_at(v), length = norm(fine_.direction[v]);
                const double most = largest(length);
                for (double& a : offset_[v]) a = std::min(1.01 * a + rounding, most);
                value_[v] = values_at(v);
                worst = std::max(worst, rounding * length);
            }
        });
        rounding_ = *std::max_element(roundings.begin(), roundings.end());
    }

    // Where a direction has this length. No share of the bound passes the tolerance, not by
    // rounding either.
    double largest(double length) const { return tolerance_ * (1.0 - 1e-14) / length; }

    bool widen(std::size_t v, int sides)
    {
        bool changed = false;
        const double most = largest(norm(fine_.direction[v]));
        for (const std::size_t side : {0u, 1u}) {
            double& a = offset_[v][side];
            if ((sides >> side & 1) == 0 || a >= most) continue;
            a = std::min(most, std::max(kGrowth * a + rounding_at(v), kFirstStep * most));
            changed = true;
        }
        if (changed) value_[v] = values_at(v);
        return changed;
    }

    // Looks at faces with a moved corner. True if some have a side without signs.
    bool check_faces(const std::vector<char>& moved, std::vector<char>& open) const
    {
        std::atomic<bool> any{false};
        parallel_for(first_block_.size() - 1, 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            bool any_here = false;
            for (std::size_t part = begin; part < end; ++part) {
                Box3 box;
                for (std::size_t i = first_block_[part]; i < first_block_[part + 1]; ++i)
                    box.add(blocks_[i].box);
                const SignFormula near = formula_in(box, formula_, signs);
                for (std::size_t i = first_block_[part]; i < first_block_[part + 1]; ++i)
                    any_here = check_block(blocks_[i], near, signs, moved, open) || any_here;
            }
            if (any_here) any = true;
        });
        return any;
    }

    bool check_block(const Block& block, const SignFormula& formula, std::vector<Sign>& signs,
                     const std::vector<char>& moved, std::vector<char>& open) const
    {
        const bool is_one = formula.constant() == 0 && formula.surfaces().size() == 1;
        const SignFormula near = is_one ? formula : formula_in(block.box, formula, signs);
        if (near.constant() != 0) {
            std::fill(open.begin() + block.begin, open.begin() + block.end,
                      near.constant() < 0 ? 1 : 2);
            return true;
        }
        const std::optional<double> alone = sign_of_one(near);
        bool any = false;
        for (std::int64_t f = block.begin; f < block.end; ++f) {
            const Triangle& t = m_.mesh.faces[f];
            if ((moved[t[0]] | moved[t[1]] | moved[t[2]]) == 0 && open[f] == 0) continue;
            open[f] = static_cast<char>(alone ? sides_without_sign(t, near.surfaces()[0], *alone)
                                              : sides_without_sign(t, near, signs));
            any = any || open[f] != 0;
        }
        return any;
    }

    SignFormula formula_in(const Box3& box, const SignFormula& formula,
                           std::vector<Sign>& signs) const
    {
        if (formula.constant() != 0) return formula;
        find_signs(formula, forms_, box, signs);
        return formula.simplified(signs);
    }

    // Nearly everywhere one surface decides, mostly a quadratic one: the sign it has outside.
    std::optional<double> sign_of_one(const SignFormula& near) const
    {
        const SignFormula::Use use = near.uses()[0];
        if (near.surfaces().size() > 1 || use.plain == use.negated ||
            !forms_[near.surfaces()[0]].is_quadratic())
            return std::nullopt;
        return use.plain ? 1.0 : -1.0;
    }

    // The sides, as bits, on which a quadratic surface has not its sign all over a moved face.
    int sides_without_sign(const Triangle& t, std::int32_t s, double outside) const
    {
        const SurfaceForm& form = forms_[s];
        const Two sign{outside, -outside};
        const std::array<TwoVec, 3> p{corners(t[0]), corners(t[1]), corners(t[2])};
        const std::array<Two, 3> values{values_at(t[0], s), values_at(t[1], s), values_at(t[2], s)};
        const Two least = lesser(sign * values[0], lesser(sign * values[1], sign * values[2]));
        const std::array<Two, 3> bends{sign * form.bend(p[1] - p[0]), sign * form.bend(p[2] - p[1]),
                                       sign * form.bend(p[0] - p[2])};
        // First a bound that is had for less.
        const double margin = 2.0 * form.slack();
        const Two low =
            least - greater(both(0.0), greater(bends[0], greater(bends[1], bends[2]))) / 3.0;
        int without = 0;
        for (const int side : {0, 1}) {
            if (low[side] > margin ||
                least[side] - most_between({bends[0][side], bends[1][side], bends[2][side]}) >
                    margin)
                continue;
            const Interval range =
                form.range({corner(t[0], side), corner(t[1], side), corner(t[2], side)},
                           {values[0][side], values[1][side], values[2][side]});
            if (!(sign[side] > 0.0 ? range.lo > 0.0 : range.hi < 0.0)) without |= 1 << side;
        }
        return without;
    }

    TwoVec corners(std::int32_t v) const
    {
        const Vec3 &p = m_.mesh.vertices[v], &d = fine_.direction[v];
        const Two step{offset_[v][0], -offset_[v][1]};
        return {p[0] + step * d[0], p[1] + step * d[1], p[2] + step * d[2]};
    }

    Two values_at(std::int32_t v, std::int32_t s) const
    {
        if (m_.surfaces_of_vertex[v][0] == s) return Two{value_[v][0], value_[v][1]};
        return Two{forms_[s].value(corner(v, 0)), forms_[s].value(corner(v, 1))};
    }

    int sides_without_sign(const Triangle& t, const SignFormula& near,
                           std::vector<Sign>& signs) const
    {
        int without = 0;
        for (const int side : {0, 1}) {
            for (const std::int32_t s : near.surfaces()) signs[s] = sign_of(t, side, s);
            if (near.sign_by_cases(signs) != (side == 0 ? 1 : -1)) without |= 1 << side;
        }
        return without;
    }

    Sign sign_of(const Triangle& t, int side, std::int32_t s) const
    {
        const SurfaceForm& form = forms_[s];
        const std::array<Vec3, 3> p{corner(t[0], side), corner(t[1], side), corner(t[2], side)};
        std::array<double, 3> values;
        for (std::size_t i = 0; i < 3; ++i)
            values[i] = m_.surfaces_of_vertex[t[i]][0] == s ? value_[t[i]][side] : form.value(p[i]);
        if (form.is_quadratic()) {
            const Interval between = SurfaceForm::deviation_of(form.bends(p));
            if (std::min({values[0], values[1], values[2]}) + between.lo > 2.0 * form.slack())
                return 1;
            if (std::max({values[0], values[1], values[2]}) + between.hi < -2.0 * form.slack())
                return -1;
        }
        return genus::sign_of(form.range(p, values));
    }

    const FineMesh& fine_;
    const SurfaceMesh& m_;
    const SignFormula& formula_;
    const std::vector<SurfaceForm>& forms_;
    double tolerance_;
    std::vector<Block> blocks_;
    std::vector<std::size_t> first_block_;       // of each face of the coarse mesh
    std::vector<std::array<double, 2>> offset_;  // outward, inward; in units of the direction
    std::vector<std::array<double, 2>> value_;
    double rounding_ = 0.0;  // the largest share of it
};

// A vertex of each component.
std::vector<std::int32_t> one_of_each(const IndexedMesh& mesh)
{
    DisjointSets components(mesh.n_vertices());
    std::vector<char> used(mesh.n_vertices(), 0);
    for (const Triangle& t : mesh.faces) {
        components.unite(t[0], t[1]);
        components.unite(t[0], t[2]);
        for (const std::int32_t v : t) used[v] = 1;
    }
    std::vector<std::int32_t> found;
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(used.size()); ++v)
        if (used[v] != 0 && components.find(v) == v) found.push_back(v);
    return found;
}

// How often N+ (side 0) or N- winds round p: faces left less faces entered on the way along x.
int winding_number(const Offsets& offsets, int side, const Vec3& p)
{
    constexpr double kFar = std::numeric_limits<double>::infinity();
    IndexedMesh ahead;  // the faces the way may meet, each with vertices of its own
    offsets.visit_near({p, {{kFar, p[1], p[2]}}}, [&](const Triangle& t) {
        const Vec3 a = offsets.corner(t[0], side), b = offsets.corner(t[1], side),
                   c = offsets.corner(t[2], side);
        const auto beside = [&](std::size_t i) {
            return std::max({a[i], b[i], c[i]}) < p[i] || std::min({a[i], b[i], c[i]}) > p[i];
        };
        if (beside(1) || beside(2) || std::max({a[0], b[0], c[0]}) < p[0]) return;
        const auto n = static_cast<std::int32_t>(ahead.vertices.size());
        ahead.vertices.insert(ahead.vertices.end(), {a, b, c});
        ahead.faces.push_back({n, n + 1, n + 2});
    });
    int number = 0;
    const MeshTree tree(ahead);
    for (const RayHit& hit : tree.ray_hits(p, {{1.0, 0.0, 0.0}})) {
        const Triangle& t = ahead.faces[hit.face];
        const auto flat = [&](std::int32_t v) {
            return Vec2{{ahead.vertices[v][1], ahead.vertices[v][2]}};
        };
        number += orient2d(flat(t[0]), flat(t[1]), flat(t[2]));
    }
    return number;
}

}  // namespace

Certificate certify_within(const Sandwich& sandwich, const SurfaceMesh& coarse,
                           const FineMesh& fine, const SignFormula& formula,
                           const std::vector<SurfaceForm>& forms, double tolerance,
                           double short_fibre)
{
    Certificate c;
    Offsets offsets(fine, formula, forms, tolerance - short_fibre);
    c.failed_faces = offsets.grow();
    if (c.failed_faces.empty()) {
        for (const std::int32_t v : one_of_each(coarse.mesh)) {
            if (winding_number(offsets, 0, sandwich.inner.vertices[v]) == 1 &&
                winding_number(offsets, 1, sandwich.outer.vertices[v]) == 0)
                continue;
            c.failed_faces.resize(coarse.mesh.n_faces());
            std::iota(c.failed_faces.begin(), c.failed_faces.end(), 0);
            break;
        }
    }
    c.n_failed = static_cast<std::int64_t>(c.failed_faces.size());
    if (c.n_failed > 0) return c;
    offsets.report(c);
    c.bound += short_fibre;
    return c;
}

}  // namespace genus
