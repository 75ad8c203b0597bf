#include "genus/boolean/mesh_boolean.h"

#include "shapes.h"

namespace genus {
namespace {

using namespace shapes;

TEST(MeshBoolean, CubesInAllCoincidentPlaces)
{
    // Cubes of side 2 and boxes of other sides at all offsets of a small grid: faces, edges and
    // corners in every position to each other. Everything is an integer, so volumes are exact.
    for (const double side : {1.0, 2.0, 3.0})
        for (int place = 0; place < 6 * 6 * 6; ++place) {
            const Vec3 at{{place % 6 - 3.0, place / 6 % 6 - 3.0, place / 36 - 3.0}};
            SCOPED_TRACE(std::to_string(side) + " at " + std::to_string(at[0]) + " " +
                         std::to_string(at[1]) + " " + std::to_string(at[2]));
            const IndexedMesh a = cube(2.0);
            const IndexedMesh b = cube(side, at);
            double common = 1.0;
            for (int k = 0; k < 3; ++k)
                common *= std::max(0.0, std::min(2.0, at[k] + side) - std::max(0.0, at[k]));
            const IndexedMesh sum = unite(a, b);
            const IndexedMesh both = intersect(a, b);
            const IndexedMesh rest = subtract(a, b);
            EXPECT_EQ(volume(sum), 8.0 + side * side * side - common);
            EXPECT_EQ(volume(both), common);
            EXPECT_EQ(volume(rest), 8.0 - common);
            for (const IndexedMesh* mesh : {&sum, &both, &rest}) expect_sound(*mesh);
            if (common > 0.0) {
                EXPECT_EQ(both.faces.size(), 12u);
            }
            if (::testing::Test::HasFailure()) return;
        }
}

TEST(MeshBoolean, SphereLessShiftedSphere)
{
    const IndexedMesh a = sphere(24, 48, 1.0);
    const IndexedMesh b = moved(a, {{0.3, 0.4, 0.5}});
    const IndexedMesh sum = unite(a, b);
    const IndexedMesh both = intersect(a, b);
    const IndexedMesh rest = subtract(a, b);
    for (const IndexedMesh* mesh : {&sum, &both, &rest}) expect_sound(*mesh);
    EXPECT_NEAR(volume(sum) + volume(both), 2.0 * volume(a), 1e-12);
    EXPECT_NEAR(volume(rest) + volume(both), volume(a), 1e-12);
}

}  // namespace
}  // namespace genus
