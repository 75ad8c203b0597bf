#include "genus/model/normal_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "genus/model/solid.h"

namespace genus {
namespace {

// Two faces with corners on a surface and directions that are its normals.
struct TwoFaces {
    TwoFaces(const SurfaceForm& surface, const Vec3& middle, double size, std::mt19937& random)
        : form(surface)
    {
        const auto number = [&] { return static_cast<double>(random() >> 5) * 0x1p-26 - 1.0; };
        const Vec3 n = normalized(form.gradient(middle));
        const Vec3 x = normalized(cross(n, Vec3{{0.3, 0.4, 0.5}})), y = cross(n, x);
        for (int i = 0; i < 6; ++i) {
            const double turn = 2.0 * 3.14159265 * (i + 0.3 * number()) / 3.0;
            const Vec3 p = middle + size * (std::cos(turn) * x + std::sin(turn) * y);
            fine.surface.mesh.vertices.push_back(p + *form.root_along(p, n) * n);
            fine.direction.push_back(normalized(form.gradient(fine.surface.mesh.vertices.back())));
            fine.surface.surfaces_of_vertex.push_back({0, -1, -1});
        }
        fine.surface.mesh.faces = {{0, 1, 2}, {3, 4, 5}};
        fine.surface.surface_of_face = {0, 0};
        fine.first_face = {0, 2};
        fine.first_vertex = {0, 6};
    }

    Vec3 moved(std::int32_t v, double offset) const
    {
        return fine.surface.mesh.vertices[v] + offset * fine.direction[v];
    }

    CornersOfFace corners(const Triangle& t, double out, double in) const
    {
        Two least = both(1e300);
        for (const std::int32_t v : t)
            least = lesser(least, Two{form.value(moved(v, out)), -form.value(moved(v, -in))});
        return {least, std::max(out, in), 0.0};
    }

    bool clear(double out, double in, const NormalsOfPart& normals) const
    {
        const auto& faces = fine.surface.mesh.faces;
        return are_clear(fine.surface.mesh.vertices, faces[0], faces[1], corners(faces[0], out, in),
                         corners(faces[1], out, in), normals, form);
    }

    // The least of F, times a sign, over the moved faces.
    double least(double offset, double sign) const
    {
        constexpr int kSteps = 24;
        double least = 1e300;
        for (const Triangle& t : fine.surface.mesh.faces)
            for (int i = 0; i <= kSteps; ++i)
                for (int j = 0; i + j <= kSteps; ++j)
                    least = std::min(
                        least,
                        sign * form.value((i * moved(t[0], offset) + j * moved(t[1], offset) +
                                           (kSteps - i - j) * moved(t[2], offset)) /
                                          kSteps));
        return least;
    }

    const SurfaceForm& form;
    FineMesh fine;
};

TEST(NormalOffsets, ShowSignsThatHoldAndFewLess)
{
    const unsigned seed = 20261122;
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Box3 box{{{-8, -8, -8}}, {{8, 8, 8}}};
    const CsgField field(unite(
        {sphere(5), transformed(ellipsoid({{6, 4, 2}}), rotation_x(30)), cylinder(7, 4, 4, true)}));
    int shown = 0, missed = 0;
    for (const Surface& surface : field.surfaces()) {
        const std::vector<SurfaceForm> forms{SurfaceForm(surface, box)};
        if (forms[0].is_plane()) continue;
        for (int trial = 0; trial < 300; ++trial) {
            const double size = std::pow(10.0, -2.0 + 0.006 * trial);
            const Vec3 ray = normalized(Vec3{{static_cast<double>(random()) * 0x1p-32 - 0.5,
                                              static_cast<double>(random()) * 0x1p-32 - 0.5,
                                              0.2 * static_cast<double>(random()) * 0x1p-32}});
            const auto root = forms[0].root_along(3.0 * ray, ray);
            if (!root) continue;
            const TwoFaces faces(forms[0], (3.0 + *root) * ray, size, random);
            const NormalsOfPart normals = normals_in(faces.fine, 0, 1e300, forms);
            ASSERT_EQ(normals.surface, 0);
            EXPECT_EQ(normals.outside, 1.0);
            // Outward they have to move by their sagitta.
            double low = 0.0, high = size;
            for (int step = 0; step < 40; ++step) {
                const double middle = 0.5 * (low + high);
                (faces.least(middle, 1.0) > 0.0 ? high : low) = middle;
            }
            // Inward only by what edges change.
            const double in = 0.02 * high;
            EXPECT_GT(faces.least(-in, -1.0), 0.0);
            EXPECT_FALSE(faces.clear(0.98 * high, in, normals));
            for (const double share : {0.999, 1.0, 1.001, 1.01}) {
                if (!faces.clear(share * high, in, normals)) continue;
                EXPECT_GT(faces.least(share * high, 1.0), 0.0);
            }
            // Where normals turn little over such a length the bound is near.
            if (normals.turn * high > 2e-4) continue;
            ++(faces.clear(1.02 * high, in, normals) ? shown : missed);
        }
    }
    EXPECT_GT(shown, 300);
    EXPECT_EQ(missed, 0);
}

TEST(NormalOffsets, OtherDirectionsAreNotTakenForNormals)
{
    const Box3 box{{{-8, -8, -8}}, {{8, 8, 8}}};
    const CsgField field(sphere(5));
    const std::vector<SurfaceForm> forms{SurfaceForm(field.surfaces()[0], box)};
    std::mt19937 random(1);
    const TwoFaces good(forms[0], {{0, 0, 5}}, 0.1, random);
    EXPECT_EQ(normals_in(good.fine, 0, 1e300, forms).surface, 0);
    EXPECT_GT(slope_along_normal(good.fine, 3, forms), 0.0);
    for (const Vec3& change : {Vec3{{1e-6, 0, 0}}, Vec3{{0, 0, 1e-6}}, Vec3{{0, 0, -2}}}) {
        FineMesh bad = good.fine;
        bad.direction[3] += change;
        EXPECT_EQ(normals_in(bad, 0, 1e300, forms).surface, -1);
    }
    FineMesh elsewhere = good.fine;
    elsewhere.surface.surfaces_of_vertex[5][0] = 1;
    EXPECT_EQ(normals_in(elsewhere, 0, 1e300, forms).surface, -1);
    // The slope at vertices of the border counts.
    EXPECT_LT(normals_in(good.fine, 0, 1e-3, forms).least_slope, 1e-3);
}

}  // namespace
}  // namespace genus
