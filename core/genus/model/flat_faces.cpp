#include "genus/model/flat_faces.h"

#include <array>
#include <cmath>

#include "genus/base/progress.h"
#include "genus/model/refine.h"

namespace genus {

namespace {

constexpr int kRounds = 6, kSweeps = 12;

bool is_flat(const FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms, std::int32_t s)
{
    return forms[mesh.label(s) >> 1].is_plane();
}

// The angle at the apex of a side: cosine and sine, times the lengths of both other sides.
std::array<double, 2> apex_angle(const FlexibleMesh& mesh, std::int32_t s)
{
    const Vec3 c = mesh.point(mesh.apex(s));
    const Vec3 a = mesh.point(mesh.from(s)) - c, b = mesh.point(mesh.to(s)) - c;
    return {dot(a, b), norm(cross(a, b))};
}

// The two opposite angles are more than half a turn together, and the quadrilateral is convex.
bool should_flip(const FlexibleMesh& mesh, std::int32_t s)
{
    const std::int32_t t = mesh.twin(s);
    const auto [cos_c, sin_c] = apex_angle(mesh, s);
    const auto [cos_d, sin_d] = apex_angle(mesh, t);
    const double least = -1e-9 * (std::hypot(cos_c, sin_c) * std::hypot(cos_d, sin_d));
    if (!(sin_c * cos_d + cos_c * sin_d < least)) return false;
    const Vec3 &a = mesh.point(mesh.from(s)), &b = mesh.point(mesh.to(s));
    const Vec3 &c = mesh.point(mesh.apex(s)), &d = mesh.point(mesh.apex(t));
    const Vec3 normal = cross(b - a, c - a);
    return dot(cross(c - d, a - d), normal) > 0.0 && dot(cross(d - c, b - c), normal) > 0.0;
}

void flip_to_delaunay(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms)
{
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool any = false;
        for (std::int32_t s = 0; s < mesh.n_sides(); ++s) {
            if (!mesh.alive(s) || mesh.twin(s) < s || mesh.is_crease(s)) continue;
            if (is_flat(mesh, forms, s) && should_flip(mesh, s)) any = mesh.flip(s) || any;
        }
        if (!any) return;
    }
}

// Edges of the borders of planes that see a vertex at more than a right angle.
std::vector<std::array<std::int32_t, 2>> encroached(const FlexibleMesh& mesh,
                                                    const std::vector<SurfaceForm>& forms)
{
    std::vector<std::array<std::int32_t, 2>> ends;
    for (std::int32_t s = 0; s < mesh.n_sides(); ++s)
        if (mesh.alive(s) && mesh.is_crease(s) && is_flat(mesh, forms, s) &&
            apex_angle(mesh, s)[0] < 0.0)
            ends.push_back({mesh.from(s), mesh.to(s)});
    return ends;
}

bool any_curve(const FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms)
{
    for (std::int32_t s = 0; s < mesh.n_sides(); ++s)
        if (mesh.alive(s) && is_flat(mesh, forms, s) && !is_flat(mesh, forms, mesh.twin(s)))
            return true;
    return false;
}

}  // namespace

void round_flat_faces(FlexibleMesh& mesh, const std::vector<SurfaceForm>& forms)
{
    if (!any_curve(mesh, forms)) return;
    for (int round = 0; round < kRounds; ++round) {
        current_progress().check();
        flip_to_delaunay(mesh, forms);
        if (halve_edges(mesh, forms, encroached(mesh, forms)) == 0) return;
    }
    flip_to_delaunay(mesh, forms);
}

}  // namespace genus
