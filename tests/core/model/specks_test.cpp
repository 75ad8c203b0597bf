#include "genus/model/specks.h"

#include <gtest/gtest.h>

#include "genus/mesh/topology.h"
#include "genus/mesh/validate.h"
#include "genus/model/csg_field.h"
#include "genus/model/mesh_solid.h"
#include "genus/volume/marching_cubes.h"

namespace genus {
namespace {

constexpr double kCell = 0.04;

// What two balls have in common, on the slant: its rim ends in an angle of some 28 degrees.
Solid lens()
{
    return transformed(intersect({transformed(sphere(2), translation({{0, 0, 1.94}})),
                                  transformed(sphere(2), translation({{0, 0, -1.94}}))}),
                       rotation({{31, 17, 5}}));
}

IndexedMesh over_grid(const CsgField& field, const Box3& box)
{
    MarchingCubesOptions options;
    options.cell_size = kCell;
    return marching_cubes(field, box, options);
}

std::int64_t n_parts(const IndexedMesh& mesh)
{
    return static_cast<std::int64_t>(topology(mesh).components.size());
}

TEST(Specks, OfARimAreLeftOut)
{
    const CsgField field(lens());
    IndexedMesh mesh = over_grid(field, sphere(1.1).bounds());
    const auto before = n_parts(mesh);
    ASSERT_GT(before, 1);
    const std::int64_t n = leave_out_specks(mesh, field, kCell, 0.5);
    EXPECT_EQ(n, before - 1);
    EXPECT_EQ(n_parts(mesh), 1);
    EXPECT_TRUE(validate(mesh).ok());
}

TEST(Specks, FarFromTheRestStay)
{
    const CsgField field(lens());
    IndexedMesh mesh = over_grid(field, sphere(1.1).bounds());
    const IndexedMesh before = mesh;
    EXPECT_EQ(leave_out_specks(mesh, field, kCell, 1e-3), 0);
    EXPECT_EQ(mesh.vertices, before.vertices);
    EXPECT_EQ(mesh.faces, before.faces);
}

TEST(Specks, ThatAreSmallPartsAndHolesOfTheSolidStay)
{
    const Solid ball = transformed(sphere(0.05), translation({{1.12, 0.013, 0.007}}));
    const Solid bubble = transformed(sphere(0.06), translation({{0.1, 0.88, 0.1}}));
    const CsgField field(unite({subtract({sphere(1), bubble}), ball}));
    IndexedMesh mesh = over_grid(field, sphere(1.3).bounds());
    ASSERT_EQ(n_parts(mesh), 3);
    EXPECT_EQ(leave_out_specks(mesh, field, kCell, 0.5), 0);
    EXPECT_EQ(n_parts(mesh), 3);
}

}  // namespace
}  // namespace genus
