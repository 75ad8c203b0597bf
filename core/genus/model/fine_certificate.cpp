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
#include "genus/model/normal_offsets.h"
#include "genus/model/two_lanes.h"

namespace genus {

namespace {

constexpr int kMaxRounds = 16;
constexpr double kReserve = 1.01, kGrowth = 1.25, kFirstStep = 0.125;
constexpr std::int64_t kFaces = 64, kFewFaces = 8;  // looked at together near other surfaces

// The meshes N+ and N-.
class Offsets {
public:
    Offsets(const FineMesh& fine, const SignFormula& formula, const std::vector<SurfaceForm>& forms,
            double tolerance)
        : fine_(fine),
          m_(fine.surface),
          formula_(formula),
          forms_(forms),
          tolerance_(tolerance),
          parts_(fine.first_face.size() - 1),
          offset_(fine.reach),
          value_(m_.mesh.n_vertices())
    {
    }

    // Returns the faces of the coarse mesh in which signs are missing in the end.
    std::vector<std::int32_t> grow()
    {
        const std::size_t n = m_.mesh.n_faces();
        first_offsets();
        std::vector<char> open(n, 0), moved;
        for (int round = 0; round < kMaxRounds; ++round) {
            current_progress().check();
            if (!check_parts(moved, open)) return {};
            moved.assign(m_.mesh.n_vertices(), 0);
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
        for (std::size_t part = 0; part < parts_.size(); ++part)
            if (std::any_of(open.begin() + fine_.first_face[part],
                            open.begin() + fine_.first_face[part + 1],
                            [](char sides) { return sides != 0; }))
                failed.push_back(static_cast<std::int32_t>(part));
        return failed;
    }

    void report(Certificate& c) const
    {
        c.rounding = rounding_;
        for (const Part& part : parts_) c.rounding = std::max(c.rounding, part.rounding);
        for (std::size_t v = 0; v < offset_.size(); ++v) {
            const bool is_crease = v < n_border() && m_.surfaces_of_vertex[v][1] >= 0;
            double& part = is_crease ? c.creases : c.faces;
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
        for (std::size_t part = 0; part < parts_.size(); ++part)
            if (overlap(parts_[part].box, box))
                for (std::int64_t f = fine_.first_face[part]; f < fine_.first_face[part + 1]; ++f)
                    visit(m_.mesh.faces[f]);
    }

    // A vertex of N+ (side 0) or N-.
    Vec3 corner(std::int32_t v, int side) const
    {
        const double step = side == 0 ? offset_[v][0] : -offset_[v][1];
        return m_.mesh.vertices[v] + step * fine_.direction[v];
    }

private:
    // What was cut from one face of the coarse mesh.
    struct Part {
        Box3 box;               // round its faces, moved as far as they may be
        double rounding = 0.0;  // the largest share of it at vertices inside
        double border_slope = std::numeric_limits<double>::infinity();  // the least of its border
    };

    // On the edges of the coarse mesh and in its corners.
    std::size_t n_border() const { return static_cast<std::size_t>(fine_.first_vertex[0]); }

    bool is_inside(const Triangle& t) const
    {
        return std::min({t[0], t[1], t[2]}) >= fine_.first_vertex[0];
    }

    // In a part where all directions inside are normals of this surface.
    bool has_normals(const Triangle& t, std::int32_t surface) const
    {
        if (is_inside(t)) return true;
        return std::all_of(t.begin(), t.end(), [&](std::int32_t v) {
            return v >= fine_.first_vertex[0] ||
                   (border_slope_[v] > 0.0 && m_.surfaces_of_vertex[v][0] == surface);
        });
    }

    // The values there of the first surface that the vertex stands on.
    std::array<double, 2> values_at(std::size_t v) const
    {
        const SurfaceForm& form = forms_[m_.surfaces_of_vertex[v][0]];
        const auto i = static_cast<std::int32_t>(v);
        return {form.value(corner(i, 0)), form.value(corner(i, 1))};
    }

    // Its box, and the least slope at its border.
    void look_at(Part& part, std::size_t number) const
    {
        for (std::int64_t v = fine_.first_vertex[number]; v < fine_.first_vertex[number + 1]; ++v)
            part.box.add(m_.mesh.vertices[v]);
        for (std::int64_t f = fine_.first_face[number]; f < fine_.first_face[number + 1]; ++f) {
            const Triangle& t = m_.mesh.faces[f];
            if (is_inside(t)) continue;
            for (const std::int32_t v : t) {
                if (v >= fine_.first_vertex[0]) continue;
                part.box.add(m_.mesh.vertices[v]);
                if (border_slope_[v] > 0.0)
                    part.border_slope = std::min(part.border_slope, border_slope_[v]);
            }
        }
        part.box = part.box.inflated(1.01 * tolerance_);
    }

    Box3 box_of(std::int64_t first_face, std::int64_t end) const
    {
        Box3 box;
        for (std::int64_t f = first_face; f < end; ++f)
            for (const std::int32_t v : m_.mesh.faces[f]) box.add(m_.mesh.vertices[v]);
        return box.inflated(1.01 * tolerance_);
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

    // Returns the share of rounding.
    double first_offset(std::size_t v)
    {
        const double rounding = rounding_at(v), length = norm(fine_.direction[v]);
        for (double& a : offset_[v]) a = std::min(kReserve * a + rounding, largest(length));
        value_[v] = values_at(v);
        return rounding * length;
    }

    // Of the border, and what must be known of all parts.
    void first_offsets()
    {
        border_slope_.resize(n_border());
        for (std::size_t v = 0; v < n_border(); ++v) {
            rounding_ = std::max(rounding_, first_offset(v));
            border_slope_[v] = slope_along_normal(fine_, static_cast<std::int32_t>(v), forms_);
        }
        parallel_for(parts_.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t part = begin; part < end; ++part) look_at(parts_[part], part);
        });
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

    // Looks at faces with a moved corner, at first at all of them. True if some have a side without
    // signs.
    bool check_parts(const std::vector<char>& moved, std::vector<char>& open)
    {
        std::atomic<bool> any{false};
        parallel_for(parts_.size(), 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Sign> signs(forms_.size(), Sign{0});
            bool any_here = false;
            for (std::size_t part = begin; part < end; ++part)
                any_here = check_part(part, signs, moved, open) || any_here;
            if (any_here) any = true;
        });
        return any;
    }

    bool check_part(std::size_t part, std::vector<Sign>& signs, const std::vector<char>& moved,
                    std::vector<char>& open)
    {
        const std::int64_t begin = fine_.first_face[part], end = fine_.first_face[part + 1];
        NormalsOfPart normals;
        if (moved.empty()) {
            normals = normals_in(fine_, part, parts_[part].border_slope, forms_);
            offset_inside(part, normals);
        }
        const SignFormula near = formula_in(parts_[part].box, formula_, signs);
        return check_range(begin, end, near, normals, signs, moved, open);
    }

    // Faces near which this formula decides: in smaller boxes that may be a shorter one.
    bool check_range(std::int64_t begin, std::int64_t end, const SignFormula& near,
                     const NormalsOfPart& normals, std::vector<Sign>& signs,
                     const std::vector<char>& moved, std::vector<char>& open) const
    {
        if (near.constant() != 0 || sign_of_one(near) || end - begin <= kFewFaces)
            return check_faces(begin, end, near, normals, signs, moved, open);
        const std::int64_t step = end - begin > kFaces ? kFaces : (end - begin + 1) / 2;
        bool any = false;
        for (std::int64_t f = begin; f < end; f += step) {
            const std::int64_t next = std::min(f + step, end);
            any = check_range(f, next, formula_in(box_of(f, next), near, signs), normals, signs,
                              moved, open) ||
                  any;
        }
        return any;
    }

    bool check_faces(std::int64_t begin, std::int64_t end, const SignFormula& near,
                     const NormalsOfPart& normals, std::vector<Sign>& signs,
                     const std::vector<char>& moved, std::vector<char>& open) const
    {
        if (near.constant() != 0) {
            std::fill(open.begin() + begin, open.begin() + end, near.constant() < 0 ? 1 : 2);
            return true;
        }
        const std::optional<double> alone = sign_of_one(near);
        bool any = false;
        const auto check = [&](std::int64_t f) {
            const Triangle& t = m_.mesh.faces[f];
            open[f] = static_cast<char>(alone ? sides_without_sign(t, near.surfaces()[0], *alone)
                                              : sides_without_sign(t, near, signs));
            any = any || open[f] != 0;
        };
        if (!moved.empty()) {
            for (std::int64_t f = begin; f < end; ++f) {
                const Triangle& t = m_.mesh.faces[f];
                if ((moved[t[0]] | moved[t[1]] | moved[t[2]]) != 0 || open[f] != 0) check(f);
            }
            return any;
        }
        const bool in_pairs =
            alone && normals.surface == near.surfaces()[0] && normals.outside == *alone;
        std::int64_t waiting = -1;
        for (std::int64_t f = begin; f < end; ++f) {
            if (!in_pairs || !has_normals(m_.mesh.faces[f], normals.surface)) {
                check(f);
            } else if (waiting < 0) {
                waiting = f;
            } else {
                if (!pair_is_clear(m_.mesh.faces[waiting], m_.mesh.faces[f], normals)) {
                    check(waiting);
                    check(f);
                }
                waiting = -1;
            }
        }
        if (waiting >= 0) check(waiting);
        return any;
    }

    void offset_inside(std::size_t part, const NormalsOfPart& normals)
    {
        const auto begin = static_cast<std::size_t>(fine_.first_vertex[part]),
                   end = static_cast<std::size_t>(fine_.first_vertex[part + 1]);
        double& worst = parts_[part].rounding;
        if (normals.surface < 0) {
            for (std::size_t v = begin; v < end; ++v) worst = std::max(worst, first_offset(v));
            return;
        }
        const SurfaceForm& form = forms_[normals.surface];
        const double rounding = 4.0 * form.slack() / normals.least_slope;
        const double most = largest(normals.longest);
        worst = rounding * normals.longest;
        for (std::size_t v = begin; v < end; ++v) {
            for (double& a : offset_[v]) a = std::min(kReserve * a + rounding, most);
            const Two value = form.value(corners(static_cast<std::int32_t>(v)));
            value_[v] = {value[0], value[1]};
        }
    }

    bool pair_is_clear(const Triangle& t, const Triangle& u, const NormalsOfPart& normals) const
    {
        return are_clear(m_.mesh.vertices, t, u, corners_of(t, normals), corners_of(u, normals),
                         normals, forms_[normals.surface]);
    }

    CornersOfFace corners_of(const Triangle& t, const NormalsOfPart& normals) const
    {
        const auto two = [](const std::array<double, 2>& x) { return Two{x[0], x[1]}; };
        const Two sign{normals.outside, -normals.outside};
        const Two values = lesser(sign * two(value_[t[0]]),
                                  lesser(sign * two(value_[t[1]]), sign * two(value_[t[2]])));
        const Two a = two(offset_[t[0]]), b = two(offset_[t[1]]), c = two(offset_[t[2]]);
        const Two most = greater(a, greater(b, c)), spread = most - lesser(a, lesser(b, c));
        return {values, std::max(most[0], most[1]), std::max(spread[0], spread[1])};
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
        if (near.constant() != 0 || near.surfaces().size() != 1) return std::nullopt;
        const SignFormula::Use use = near.uses()[0];
        if (use.plain == use.negated || !forms_[near.surfaces()[0]].is_quadratic())
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
    std::vector<Part> parts_;
    std::vector<double> border_slope_;           // at vertices there with a normal, 0 at others
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
