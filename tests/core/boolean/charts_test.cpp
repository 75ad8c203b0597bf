#include "genus/boolean/charts.h"

#include <set>

#include "genus/boolean/contact.h"
#include "shapes.h"
#include "soups.h"

// Charts are a promise: two faces of one chart meet in common corners and edges only.

namespace genus {
namespace {

using namespace shapes;

bool meet(const exact::Soup& soup, std::int32_t f, std::int32_t g)
{
    exact::Corners a;
    exact::Corners b;
    for (int i = 0; i < 3; ++i) {
        a.at[i] = &soup.points[soup.faces[f][i]];
        b.at[i] = &soup.points[soup.faces[g][i]];
    }
    exact::number_corners(a, b);
    return !exact::find_contact(a, b).trivial();
}

// Number of pairs of faces that meet; none of them is of one chart.
int count_meetings(const exact::Soup& soup)
{
    const std::vector<std::int32_t> owner = exact::find_owners(soup);
    const auto n = static_cast<std::int32_t>(soup.faces.size());
    int meetings = 0;
    for (std::int32_t f = 0; f < n; ++f)
        for (std::int32_t g = f + 1; g < n; ++g) {
            if (!meet(soup, f, g)) continue;
            ++meetings;
            EXPECT_FALSE(owner[f] >= 0 && owner[f] == owner[g]) << "faces " << f << " and " << g;
        }
    return meetings;
}

// A closed tube round a curve.
template <class Curve>
IndexedMesh tube(int around, int across, double radius, const Curve& curve)
{
    IndexedMesh mesh = torus(around, across, 1.0, 0.0);
    for (int i = 0; i < around; ++i) {
        const double t = 2.0 * std::numbers::pi * i / around;
        const Vec3 along = normalized(curve(t + 1e-4) - curve(t - 1e-4));
        const Vec3 side = normalized(cross(along, Vec3{{0.3, 0.1, 1.0}}));
        const Vec3 up = cross(side, along);
        for (int j = 0; j < across; ++j) {
            const double p = 2.0 * std::numbers::pi * j / across;
            mesh.vertices[i * across + j] =
                curve(t) + radius * (std::cos(p) * side + std::sin(p) * up);
        }
    }
    return mesh;
}

TEST(Charts, ASphereIsSixOrFewer)
{
    const exact::Soup soup = soup_of({sphere(20, 40, 1.0)});
    const std::vector<std::int32_t> owner = exact::find_owners(soup);
    const std::set<std::int32_t> charts(owner.begin(), owner.end());
    EXPECT_EQ(charts.count(-1), 0u);
    EXPECT_LE(charts.size(), 6u);
    EXPECT_EQ(count_meetings(soup), 0);
}

TEST(Charts, NeverHideWhatMeets)
{
    // A tube laid twice round flatly, so that it comes to lie in itself and a chart would cover
    // the view twice.
    const auto coil = [](double t) {
        return Vec3{{(2.0 + 0.2 * std::cos(t)) * std::cos(2 * t),
                     (2.0 + 0.2 * std::cos(t)) * std::sin(2 * t), 0.15 * std::sin(t)}};
    };
    EXPECT_GT(count_meetings(soup_of({tube(60, 12, 0.5, coil)})), 100);
    const auto eight = [](double t) {
        return Vec3{{2.0 * std::sin(t), 2.0 * std::sin(t) * std::cos(t), 0.2 * std::cos(t)}};
    };
    EXPECT_GT(count_meetings(soup_of({tube(50, 10, 0.3, eight)})), 20);
    // A spindle: the axis lies inside the tube.
    EXPECT_GT(count_meetings(soup_of({torus(24, 16, 0.5, 1.0)})), 20);
}

TEST(Charts, NeverHideWhatMeetsInNoise)
{
    for (const std::uint32_t seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        IndexedMesh mesh = sphere(14, 28, 1.0);
        const double noise = 0.02 * std::pow(2.0, static_cast<double>(seed) - 1.0);
        for (Vec3& p : mesh.vertices)
            for (int k = 0; k < 3; ++k)
                p[k] += noise * (static_cast<double>(random()) / 4294967296.0 - 0.5);
        const int meetings = count_meetings(soup_of({mesh}));
        EXPECT_TRUE(seed < 5 || meetings > 0);
    }
}

}  // namespace
}  // namespace genus
