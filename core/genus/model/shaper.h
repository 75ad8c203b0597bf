#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "genus/model/flexible_mesh.h"
#include "genus/model/surface_form.h"

namespace genus {

/// Judges and changes a mesh by the shapes of its faces, and by how their normals agree with the
/// exact ones at their corners.
class Shaper {
public:
    Shaper(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms) : m_(mesh), forms_(forms) {}

    struct Shape {
        double height_ratio;  // smallest height over longest side
        bool faces_right;     // the normal agrees with the exact ones
    };
    static double height_ratio(const Vec3& a, const Vec3& b, const Vec3& c)
    {
        const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
        return longest > 0.0 ? norm(cross(b - a, c - a)) / longest : 0.0;
    }
    Shape shape(const Vec3& a, const Vec3& b, const Vec3& c, std::int32_t label,
                double least_cosine = kNormalCosine) const
    {
        const Vec3 n = cross(b - a, c - a);
        const double area = norm(n);
        const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
        const SurfaceForm& form = forms_[label >> 1];
        const double turn = (label & 1) != 0 ? -1.0 : 1.0;
        bool right = area > 0.0;
        const int n_checks = form.is_plane() ? 1 : 3;
        const std::array<const Vec3*, 3> corners{&a, &b, &c};
        for (int i = 0; i < n_checks && right; ++i) {
            const Vec3 g = form.gradient(*corners[i]);
            right = turn * dot(n, g) >= least_cosine * area * norm(g);
        }
        return {longest > 0.0 ? area / longest : 0.0, right};
    }

    Shape face_shape(std::int32_t s) const
    {
        return shape(m_.point(m_.from(s)), m_.point(m_.to(s)), m_.point(m_.apex(s)), m_.label(s));
    }

    double length(std::int32_t s) const
    {
        return distance(m_.point(m_.from(s)), m_.point(m_.to(s)));
    }

    // Of a point from the curve in which two surfaces meet, to first order; where their normals are
    // too much alike for that, from the farther of the two.
    double distance_from_curve(std::int32_t s, std::int32_t t, const Vec3& p) const
    {
        const auto one = [&](std::int32_t i, Vec3& normal) {
            normal = forms_[i].gradient(p);
            const double slope = norm(normal);
            normal = normal / slope;
            return forms_[i].value(p) / slope;
        };
        Vec3 g, h;
        const double u = one(s, g), v = one(t, h);
        // The least x with g.x = u, h.x = v.
        const double c = dot(g, h), det = 1.0 - c * c;
        if (!(det > 1e-6)) return std::max(std::fabs(u), std::fabs(v));
        return std::sqrt(std::max(0.0, (u * u - 2.0 * c * u * v + v * v) / det));
    }

    // May the origin of s go to its end? Inside a face always, along a curve on the curve only.
    bool kind_allows(std::int32_t s) const
    {
        const int n = m_.n_creases(m_.from(s));
        return n == 0 || (n == 2 && m_.is_crease(s));
    }

    // Where the mesh touches itself all edges at one place go together, or none.
    bool try_collapse(std::int32_t s)
    {
        if (!m_.touches(m_.from(s))) {
            if (!may_collapse(s)) return false;
            m_.collapse(s);
            return true;
        }
        const std::vector<std::int32_t> edges = m_.coincident(s);
        if (!m_.can_collapse_together(edges)) return false;
        for (const std::int32_t e : edges)
            if (!may_collapse(e)) return false;
        for (const std::int32_t e : edges) m_.collapse(e);
        return true;
    }

    bool may_collapse(std::int32_t s) const
    {
        if (!kind_allows(s) || !m_.can_collapse(s)) return false;
        const std::int32_t a = m_.from(s), b = m_.to(s);
        const double limit = kLongest * std::max(m_.cell_size(a), m_.cell_size(b));
        double after = 1.0;
        bool right_after = true, too_long = false;
        m_.visit_ring(a, [&](std::int32_t x) {
            if (too_long || m_.to(x) == b || m_.apex(x) == b) return;
            too_long = distance(m_.point(b), m_.point(m_.to(x))) > limit;
            const Shape now =
                shape(m_.point(b), m_.point(m_.to(x)), m_.point(m_.apex(x)), m_.label(x));
            after = std::min(after, now.height_ratio);
            right_after = right_after && now.faces_right;
        });
        if (too_long) return false;
        if (right_after && after >= kGoodShape) return true;
        // No worse than before will do.
        double before = 1.0;
        bool right_before = true;
        m_.visit_ring(a, [&](std::int32_t x) {
            const Shape old = face_shape(x);
            before = std::min(before, old.height_ratio);
            right_before = right_before && old.faces_right;
        });
        if (right_before && !right_after) return false;
        return after >= std::min(before, kGoodShape);
    }

    // Removes the vertex into that neighbour which leaves the best shapes, none of them turned.
    bool try_drop(std::int32_t v)
    {
        if (m_.touches(v)) return false;
        double best = 1e-4;  // thinner faces are worse than a vertex that is off
        std::int32_t chosen = -1;
        m_.visit_ring(v, [&](std::int32_t s) {
            if (!kind_allows(s) || !m_.can_collapse(s)) return;
            const std::int32_t b = m_.to(s);
            double worst = 1.0;
            m_.visit_ring(v, [&](std::int32_t x) {
                if (m_.to(x) == b || m_.apex(x) == b) return;
                const Shape now =
                    shape(m_.point(b), m_.point(m_.to(x)), m_.point(m_.apex(x)), m_.label(x));
                worst = std::min(worst, now.faces_right ? now.height_ratio : 0.0);
            });
            if (worst <= best) return;
            best = worst;
            chosen = s;
        });
        if (chosen < 0) return false;
        m_.collapse(chosen);
        return true;
    }

    // Flips an edge inside a face if the worse of its two triangles gets better by it.
    // `is_right(t)` tells of side t whether the normal of its face agrees with the exact ones.
    template <class IsRight>
    bool try_flip(std::int32_t s, double gain, IsRight&& is_right)
    {
        if (m_.is_crease(s)) return false;
        const std::int32_t t = m_.twin(s);
        const Vec3 &a = m_.point(m_.from(s)), &b = m_.point(m_.to(s));
        const Vec3 &c = m_.point(m_.apex(s)), &d = m_.point(m_.apex(t));
        const double before = std::min(height_ratio(a, b, c), height_ratio(b, a, d));
        const double after = std::min(height_ratio(d, c, a), height_ratio(c, d, b));
        if (after <= gain * before && is_right(s) && is_right(t)) return false;
        if (!shape(d, c, a, m_.label(s)).faces_right || !shape(c, d, b, m_.label(s)).faces_right)
            return false;
        return m_.flip(s);
    }
    bool try_flip(std::int32_t s, double gain)
    {
        return try_flip(s, gain, [&](std::int32_t t) { return face_shape(t).faces_right; });
    }

protected:
    static constexpr double kLongest = 1.5;       // of a cell, an edge after a collapse
    static constexpr double kNormalCosine = 0.6;  // between a face and the exact normals
    static constexpr double kGoodShape = 0.1;     // height over longest side

    FlexibleMesh& m_;
    const std::vector<SurfaceForm>& forms_;
};

}  // namespace genus
