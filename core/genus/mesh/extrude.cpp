#include "genus/mesh/extrude.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/base/transform.h"
#include "genus/polygon/triangulate.h"

namespace genus {

namespace {

constexpr double kMostVertices = 2e7;

// The points of a region, those at one place once, with its sides and triangles by their numbers.
struct Profile {
    std::vector<Vec2> points;
    struct Side {
        std::int32_t from, to;
        bool outer;  // of an outer ring
    };
    std::vector<Side> sides;  // the inside on the left
    std::vector<PolygonTriangle> triangles;
};

Profile make_profile(const Region& region)
{
    Profile profile;
    std::map<std::array<double, 2>, std::int32_t> numbers;
    const auto number = [&](const Vec2& p) {
        const auto [place, is_new] =
            numbers.try_emplace(p.c, static_cast<std::int32_t>(profile.points.size()));
        if (is_new) profile.points.push_back(p);
        return place->second;
    };
    for (const Ring& ring : region.rings) {
        const bool outer = area(ring) > 0.0;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::int32_t from = number(ring[i]), to = number(ring[(i + 1) % ring.size()]);
            profile.sides.push_back({from, to, outer});
        }
    }
    for (const Polygon& polygon : polygons(region)) {
        std::vector<std::int32_t> point;
        for (const Vec2& p : polygon.outer) point.push_back(number(p));
        for (const Ring& hole : polygon.holes)
            for (const Vec2& p : hole) point.push_back(number(p));
        // Corners in a row up to rounding make needles by any other method, and these turn over
        // once the extrusion is moved.
        for (const PolygonTriangle& t : triangulate(polygon, TriangulateMethod::Delaunay))
            profile.triangles.push_back({point[t[0]], point[t[1]], point[t[2]]});
    }
    return profile;
}

// Adds faces, leaving out repeated corners and what then has no area.
class FaceList {
public:
    explicit FaceList(PolygonMesh& mesh) : mesh_(mesh) {}

    void add(std::initializer_list<std::int64_t> corners)
    {
        std::vector<std::int32_t> face;
        for (const std::int64_t v : corners)
            if (face.empty() || face.back() != v) face.push_back(static_cast<std::int32_t>(v));
        while (face.size() > 1 && face.front() == face.back()) face.pop_back();
        if (face.size() >= 3) mesh_.add_face(face);
    }

private:
    PolygonMesh& mesh_;
};

void check(const LinearExtrudeOptions& options)
{
    require(options.height > 0.0 && std::isfinite(options.height), "linear_extrude: height",
            options.height, "positive");
    require(std::isfinite(options.twist), "linear_extrude: twist", options.twist, "finite");
    require(options.slices >= 1, "linear_extrude: slices", options.slices, "positive");
    for (const double s : options.scale.c)
        require(s >= 0.0 && std::isfinite(s), "linear_extrude: scale", s, "zero or positive");
    require((options.scale[0] == 0.0) == (options.scale[1] == 0.0),
            "linear_extrude: scale is zero in one axis only: the top would have no area");
}

void check(const RotateExtrudeOptions& options, const Box2& box)
{
    require(std::isfinite(options.start), "rotate_extrude: start", options.start, "finite");
    require(options.angle != 0.0 && std::fabs(options.angle) <= 360.0, "rotate_extrude: angle",
            options.angle, "between -360 and 360, not zero");
    require(options.fragments >= (std::fabs(options.angle) == 360.0 ? 3 : 1),
            "rotate_extrude: fragments", options.fragments, "positive, 3 or more for a full turn");
    require(box.empty() || box.min[0] >= 0.0 || box.max[0] <= 0.0,
            "rotate_extrude: the region reaches to both sides of the axis x = 0");
}

}  // namespace

PolygonMesh linear_extrude(const Region& region, const LinearExtrudeOptions& options)
{
    check(options);
    const Profile profile = make_profile(region);
    const auto n = static_cast<std::int64_t>(profile.points.size());
    require(static_cast<double>(n) * (options.slices + 1.0) <= kMostVertices,
            "linear_extrude: slices", options.slices, "fewer: there would be over 10^8 vertices");
    const bool pointed = options.scale[0] == 0.0;
    PolygonMesh mesh;
    for (int slice = 0; slice <= options.slices; ++slice) {
        current_progress().check();
        const double t = static_cast<double>(slice) / options.slices;
        const double z = options.height * (options.center ? t - 0.5 : t);
        if (slice == options.slices && pointed) {
            mesh.vertices.push_back({{0.0, 0.0, z}});
            break;
        }
        const double c = cos_degrees(-options.twist * t), s = sin_degrees(-options.twist * t);
        const double sx = 1.0 + (options.scale[0] - 1.0) * t;
        const double sy = 1.0 + (options.scale[1] - 1.0) * t;
        for (const Vec2& p : profile.points)
            mesh.vertices.push_back({{sx * (c * p[0] - s * p[1]), sy * (s * p[0] + c * p[1]), z}});
    }
    const auto vertex = [&](int slice, std::int32_t point) {
        return pointed && slice == options.slices ? n * slice : n * slice + point;
    };
    FaceList faces(mesh);
    for (const PolygonTriangle& t : profile.triangles) {
        faces.add({vertex(0, t[0]), vertex(0, t[2]), vertex(0, t[1])});
        if (!pointed)
            faces.add({vertex(options.slices, t[0]), vertex(options.slices, t[1]),
                       vertex(options.slices, t[2])});
    }
    const bool flat = options.twist == 0.0 && options.scale[0] == options.scale[1];
    // The shorter diagonal; of two as good as equal the one that the text language takes.
    const bool leans_back = sin_degrees(options.twist / options.slices) < 0.0;
    const auto first_diagonal = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d,
                                    bool outer) {
        const double one = distance(mesh.vertices[a], mesh.vertices[c]);
        const double other = distance(mesh.vertices[b], mesh.vertices[d]);
        return std::fabs(one - other) > 1e-9 * (one + other) ? one < other : leans_back != outer;
    };
    for (int slice = 0; slice < options.slices; ++slice)
        for (const auto& side : profile.sides) {
            const auto a = vertex(slice, side.from), b = vertex(slice, side.to);
            const auto d = vertex(slice + 1, side.from), c = vertex(slice + 1, side.to);
            if (flat) {
                faces.add({a, b, c, d});
            } else if (first_diagonal(a, b, c, d, side.outer)) {
                faces.add({a, b, c});
                faces.add({a, c, d});
            } else {
                faces.add({a, b, d});
                faces.add({b, c, d});
            }
        }
    return mesh;
}

PolygonMesh rotate_extrude(const Region& region, const RotateExtrudeOptions& options)
{
    const Box2 box = bounds(region);
    check(options, box);
    const Profile profile = make_profile(region);
    const auto n = static_cast<std::int64_t>(profile.points.size());
    require(static_cast<double>(n) * (options.fragments + 1.0) <= kMostVertices,
            "rotate_extrude: fragments", options.fragments,
            "fewer: there would be over 10^8 vertices");
    const bool full = std::fabs(options.angle) == 360.0;
    const int n_copies = full ? options.fragments : options.fragments + 1;
    PolygonMesh mesh;
    for (int copy = 0; copy < n_copies; ++copy) {
        current_progress().check();
        const double angle = options.start + options.angle * copy / options.fragments;
        const double c = cos_degrees(angle), s = sin_degrees(angle);
        for (const Vec2& p : profile.points) mesh.vertices.push_back({{p[0] * c, p[0] * s, p[1]}});
    }
    // Points on the axis stand once, in the first copy.
    const auto vertex = [&](int copy, std::int32_t point) {
        return profile.points[point][0] == 0.0 ? point : n * (copy % n_copies) + point;
    };
    // Seen along the turn, a profile with x > 0 swept counterclockwise has its inside, on the left
    // of its sides, also on the left of the walls; either mirror image turns the faces round.
    const bool turned = (options.angle < 0.0) != (box.max[0] <= 0.0);
    FaceList faces(mesh);
    const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t c, std::int64_t d) {
        turned ? faces.add({d, c, b, a}) : faces.add({a, b, c, d});
    };
    for (int copy = 0; copy < options.fragments; ++copy)
        for (const auto& side : profile.sides)
            add(vertex(copy, side.from), vertex(copy + 1, side.from), vertex(copy + 1, side.to),
                vertex(copy, side.to));
    if (!full)
        for (const PolygonTriangle& t : profile.triangles) {
            const auto cap = [&](int copy, int i) { return vertex(copy, t[i]); };
            const int last = options.fragments;
            add(cap(0, 0), cap(0, 1), cap(0, 2), cap(0, 0));
            add(cap(last, 0), cap(last, 2), cap(last, 1), cap(last, 0));
        }
    // Copies of axis points were never named.
    std::vector<std::int32_t> number(mesh.vertices.size(), -1);
    std::vector<Vec3> named;
    for (std::int32_t& v : mesh.corners) {
        if (number[v] < 0) {
            number[v] = static_cast<std::int32_t>(named.size());
            named.push_back(mesh.vertices[v]);
        }
        v = number[v];
    }
    mesh.vertices = std::move(named);
    return mesh;
}

}  // namespace genus
