#include "genus/language/tight_bounds.h"

#include <algorithm>

namespace genus::language {

namespace {

Box3 images(const Transform& t, const std::vector<Vec3>& points)
{
    Box3 box;
    for (const Vec3& p : points) box.add(apply(t, p));
    return box;
}

std::vector<Vec3> corners(const Box3& box)
{
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < 8; ++k) out.push_back(box.corner(k));
    return out;
}

// Each axis goes to one axis.
bool keeps_axes(const Transform& t)
{
    for (int r = 0; r < 3; ++r) {
        int used = 0;
        for (int c = 0; c < 3; ++c) used += t.m[r][c] != 0.0;
        if (used != 1) return false;
    }
    return true;
}

void add_ring(std::vector<Vec3>& points, double r, double z, int fragments)
{
    for (int i = 0; i < fragments; ++i) {
        const double angle = 360.0 * i / fragments;
        points.push_back(Vec3{{r * cos_degrees(angle), r * sin_degrees(angle), z}});
    }
}

// All corners of the polyhedra that stand for round shapes.
std::vector<Vec3> ring_points(const Sphere& s)
{
    std::vector<Vec3> points;
    const int rings = (s.fragments + 1) / 2;
    for (int i = 0; i < rings; ++i) {
        const double polar = 180.0 * (i + 0.5) / rings;
        add_ring(points, s.r * sin_degrees(polar), s.r * cos_degrees(polar), s.fragments);
    }
    return points;
}
std::vector<Vec3> ring_points(const Cylinder& c)
{
    std::vector<Vec3> points;
    const double z = c.center ? -c.h / 2 : 0.0;
    add_ring(points, c.r1, z, c.fragments);
    add_ring(points, c.r2, z + c.h, c.fragments);
    return points;
}

std::optional<Box3> bounds_under(const Solid& solid, const Transform& t);

struct Visitor {
    const Solid& solid;
    const Transform& t;

    std::optional<Box3> operator()(const Empty&) const { return Box3(); }
    std::optional<Box3> operator()(const Cube&) const { return images(t, corners(solid.bounds())); }
    std::optional<Box3> operator()(const Polyhedron& p) const
    {
        return images(t, p.mesh->vertices);
    }
    std::optional<Box3> operator()(const Sphere& s) const
    {
        if (s.fragments > 0) return images(t, ring_points(s));
        // A ball moved by an affine map reaches as far along an axis as the row is long.
        Box3 box;
        for (int i = 0; i < 3; ++i) {
            const double reach = s.r * norm(Vec3{{t.m[i][0], t.m[i][1], t.m[i][2]}});
            box.min[i] = t.m[i][3] - reach;
            box.max[i] = t.m[i][3] + reach;
        }
        return box;
    }
    std::optional<Box3> operator()(const Cylinder& c) const
    {
        if (c.fragments > 0) return images(t, ring_points(c));
        if (!keeps_axes(t)) return std::nullopt;
        const double z = c.center ? -c.h / 2 : 0.0, r = std::max(c.r1, c.r2);
        return images(t, corners(Box3{Vec3{{-r, -r, z}}, Vec3{{r, r, z + c.h}}}));
    }
    std::optional<Box3> operator()(const Ellipsoid& e) const
    {
        if (!keeps_axes(t)) return std::nullopt;
        return images(t, corners(Box3{-e.radii, e.radii}));
    }
    std::optional<Box3> operator()(const TorusShape& torus) const
    {
        if (!keeps_axes(t)) return std::nullopt;
        const Vec3 reach{{torus.R + torus.r, torus.R + torus.r, torus.r}};
        return images(t, corners(Box3{-reach, reach}));
    }
    std::optional<Box3> operator()(const Union& u) const
    {
        Box3 box;
        for (const Solid& part : u.parts) {
            const auto inner = bounds_under(part, t);
            if (!inner) return std::nullopt;
            box.add(*inner);
        }
        return box;
    }
    std::optional<Box3> operator()(const Transformed& inner) const
    {
        return bounds_under(inner.part, t * inner.map);
    }
    std::optional<Box3> operator()(const Colored& c) const { return bounds_under(c.part, t); }
    template <typename Other>
    std::optional<Box3> operator()(const Other&) const
    {
        return std::nullopt;
    }
};

std::optional<Box3> bounds_under(const Solid& solid, const Transform& t)
{
    return std::visit(Visitor{solid, t}, solid.node().shape);
}

}  // namespace

std::optional<Box3> tight_bounds(const Solid& solid)
{
    return bounds_under(solid, Transform{});
}

}  // namespace genus::language
