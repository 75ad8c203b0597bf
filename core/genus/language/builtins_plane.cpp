#include "genus/language/builtins_plane.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "genus/base/transform.h"
#include "genus/language/node_reader.h"
#include "genus/mesh/extrude.h"
#include "genus/model/construct.h"

namespace genus::language {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadian = 180.0 / kPi;
// The share of a tolerance that the facets of plane curves may take.
constexpr double kPlaneShare = 0.5;
constexpr std::size_t kMostSums = 4'000'000;  // of corners, for minkowski

/// Makes the plane shape of one node; its parts are made already.
class PlaneMaker : NodeReader {
public:
    PlaneMaker(const ModelNode& node, std::vector<PlaneShape> parts)
        : NodeReader(node), parts_(std::move(parts))
    {
        for (const PlaneShape& part : parts_) {
            deviation_ = std::max(deviation_, part.deviation);
            regions_.push_back(part.region);
        }
    }

    using Method = PlaneShape (PlaneMaker::*)();

    PlaneShape group()
    {
        if (parts_.size() == 1) return parts_[0];
        return made(unite(regions_));
    }
    PlaneShape difference() { return made(subtract(regions_)); }
    PlaneShape intersection() { return made(intersect(regions_)); }

    PlaneShape square()
    {
        const Vec2 size = vec2("size");
        if (!(size[0] > 0 && size[1] > 0)) return {};
        const double x = truth("center") ? -0.5 * size[0] : 0.0;
        const double y = truth("center") ? -0.5 * size[1] : 0.0;
        return made(
            {{{{{x, y}}, {{x + size[0], y}}, {{x + size[0], y + size[1]}}, {{x, y + size[1]}}}}});
    }

    PlaneShape circle()
    {
        const double r = number("r");
        if (!(r > 0) || !std::isfinite(r)) return {};
        int sides = node_.fragments;
        if (sides == 0) {
            sides = fragments_within(kPlaneShare * node_.tolerance, r);
            deviation_ = r * (1.0 - cos_degrees(180.0 / sides));
        }
        Ring ring;
        for (int i = 0; i < sides; ++i)
            ring.push_back(
                {{r * cos_degrees(360.0 * i / sides), r * sin_degrees(360.0 * i / sides)}});
        return made({{std::move(ring)}});
    }

    PlaneShape polygon()
    {
        const ModelValue::List& given = rows("points");
        std::vector<Vec2> points;
        for (std::size_t i = 0; i < given.size(); ++i)
            points.push_back(vec<2>(given[i], "points[" + std::to_string(i) + "]"));
        if (!has("paths") || rows("paths").empty()) {
            const Ring ring[] = {points};
            return made(make_region(ring, FillRule::EvenOdd));
        }
        ModelValue::List paths = rows("paths");
        if (paths[0].number()) paths = {ModelValue(paths)};  // one path, not in a list
        std::vector<Ring> rings;
        for (std::size_t p = 0; p < paths.size(); ++p) {
            const std::string name = "paths[" + std::to_string(p) + "]";
            if (!paths[p].list()) fail("polygon(): " + name + " is no list of point numbers");
            Ring ring;
            for (const ModelValue& corner : *paths[p].list())
                ring.push_back(points[point_number(corner, points.size(), name)]);
            rings.push_back(std::move(ring));
        }
        return made(make_region(rings, FillRule::EvenOdd));
    }

    PlaneShape transform()
    {
        std::array<std::array<double, 4>, 4> m;
        for (std::size_t r = 0; r < 4; ++r) m[r] = numbers<4>(rows("").at(r), "matrix");
        const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        PlaneShape shape = group();
        if (det == 0.0) return {};
        for (Ring& ring : shape.region.rings) {
            for (Vec2& p : ring)
                p = {{m[0][0] * p[0] + m[0][1] * p[1] + m[0][3],
                      m[1][0] * p[0] + m[1][1] * p[1] + m[1][3]}};
            if (det < 0.0) std::reverse(ring.begin(), ring.end());
        }
        Transform map;
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j) map.m[i][j] = m[i][j];
        map.m[2][2] = 0.0;
        shape.deviation *= largest_stretch(map);
        return shape;
    }

    PlaneShape resize()
    {
        PlaneShape shape = group();
        if (shape.region.empty()) return shape;
        const Vec2 size = bounds(shape.region).size();
        const Vec3 wanted = vec3("newsize"), keep = vec3("auto");
        Vec2 factor{{1, 1}};
        double follow = 1.0;
        for (int i = 0; i < 2; ++i)
            if (wanted[i] > 0) {
                factor[i] = wanted[i] / size[i];
                follow = follow == 1.0 ? factor[i] : std::max(follow, factor[i]);
            }
        for (int i = 0; i < 2; ++i)
            if (!(wanted[i] > 0) && keep[i] != 0) factor[i] = follow;
        for (Ring& ring : shape.region.rings)
            for (Vec2& p : ring) p = {{p[0] * factor[0], p[1] * factor[1]}};
        shape.deviation *= std::max(factor[0], factor[1]);
        return shape;
    }

    PlaneShape offset()
    {
        const PlaneShape shape = group();
        OffsetOptions options;
        double distance = 0.0, arc_error = 0.0;
        if (has("r")) {
            distance = number("r");
            const Facets f = facets();
            options.fragments = f.round_fragments(std::fabs(distance));
            if (options.fragments == 0) {
                options.fragments =
                    fragments_within(kPlaneShare * node_.tolerance, std::fabs(distance));
                arc_error = std::fabs(distance) * (1.0 - cos_degrees(180.0 / options.fragments));
            }
        } else {
            distance = number("delta");
            options.join = truth("chamfer") ? JoinStyle::Chamfer : JoinStyle::Miter;
        }
        PlaneShape result = made(genus::offset(shape.region, distance, options));
        result.deviation += arc_error;
        return result;
    }

    PlaneShape hull()
    {
        std::vector<Vec2> points;
        for (const Region& region : regions_)
            for (const Ring& ring : region.rings)
                points.insert(points.end(), ring.begin(), ring.end());
        Ring ring = convex_hull(points);
        return ring.empty() ? PlaneShape{} : made({{std::move(ring)}});
    }

    // Of connected parts A and B, A + B is what their borders sweep over each other, with A moved
    // to a point of B and B to one of A.
    PlaneShape minkowski()
    {
        PlaneShape sum;
        bool first = true;
        for (const PlaneShape& part : parts_) {
            if (part.region.empty()) continue;
            if (first) {
                sum = part;
            } else {
                sum.region = added(sum.region, part.region);
                sum.deviation += part.deviation;
            }
            first = false;
        }
        return sum;
    }

private:
    PlaneShape made(Region region) const { return {std::move(region), deviation_}; }

    static void move_to(const Region& shape, const Region& places, std::vector<Region>& out)
    {
        for (const Ring& place : places.rings) {
            Region moved = shape;
            for (Ring& ring : moved.rings)
                for (Vec2& p : ring) p += place[0];
            out.push_back(std::move(moved));
        }
    }

    Region added(const Region& a, const Region& b) const
    {
        std::size_t n_a = 0, n_b = 0;
        for (const Ring& ring : a.rings) n_a += ring.size();
        for (const Ring& ring : b.rings) n_b += ring.size();
        if (n_a * n_b > kMostSums) fail("minkowski(): shapes with too many corners");
        std::vector<Region> pieces;
        move_to(a, b, pieces);
        move_to(b, a, pieces);
        for (const Ring& p : a.rings)
            for (const Ring& q : b.rings)
                for (std::size_t i = 0; i < p.size(); ++i)
                    for (std::size_t j = 0; j < q.size(); ++j) {
                        const Vec2 &p0 = p[i], &p1 = p[(i + 1) % p.size()];
                        const Vec2 &q0 = q[j], &q1 = q[(j + 1) % q.size()];
                        const Vec2 corners[] = {p0 + q0, p1 + q0, p1 + q1, p0 + q1};
                        Ring piece = convex_hull(corners);
                        if (!piece.empty()) pieces.push_back({{std::move(piece)}});
                    }
        return unite(pieces);
    }

    std::vector<PlaneShape> parts_;
    std::vector<Region> regions_;
    double deviation_ = 0.0;
};

const std::unordered_map<std::string_view, PlaneMaker::Method>& methods()
{
    static const std::unordered_map<std::string_view, PlaneMaker::Method> map = {
        {"difference", &PlaneMaker::difference},
        {"intersection", &PlaneMaker::intersection},
        {"square", &PlaneMaker::square},
        {"circle", &PlaneMaker::circle},
        {"polygon", &PlaneMaker::polygon},
        {"multmatrix", &PlaneMaker::transform},
        {"resize", &PlaneMaker::resize},
        {"offset", &PlaneMaker::offset},
        {"hull", &PlaneMaker::hull},
        {"minkowski", &PlaneMaker::minkowski},
    };
    return map;
}

// Slices of a twisted or unevenly scaled extrusion, by the special variables.
class SliceRule {
public:
    SliceRule(const Facets& facets, const Region& profile, const LinearExtrudeOptions& options)
        : facets_(facets), options_(options)
    {
        for (const Ring& ring : profile.rings)
            for (const Vec2& p : ring) {
                reach_ = std::max(reach_, norm(p));
                const Vec2 end{{p[0] * options.scale[0], p[1] * options.scale[1]}};
                slide_ = std::max(slide_, distance(p, end));
            }
    }

    int slices() const
    {
        const bool uneven = options_.scale[0] != options_.scale[1];
        if (options_.twist == 0.0) return uneven ? along_slide() : 1;
        return uneven ? std::max(along_helix(), along_slide()) : along_helix();
    }

private:
    int along_helix() const
    {
        const double twist = std::fabs(options_.twist);
        const double least = std::max(std::ceil(twist / 120.0), 1.0);
        if (facets_.fn > 0.0) return count(std::max(std::ceil(twist / 360.0 * facets_.fn), least));
        const double by_angle = std::ceil(twist / facets_.fa);
        const double by_length =
            std::ceil(std::hypot(twist / kRadian * reach_, options_.height) / facets_.fs);
        return count(std::max(std::min(by_angle, by_length), least));
    }
    int along_slide() const
    {
        if (facets_.fn > 0.0) return count(std::max(facets_.fn, 1.0));
        return count(std::max(std::ceil(std::hypot(slide_, options_.height) / facets_.fs), 1.0));
    }
    static int count(double n) { return static_cast<int>(std::min(n, 1e8)); }

    Facets facets_;
    LinearExtrudeOptions options_;
    double reach_ = 0.0;  // of the farthest point from the axis
    double slide_ = 0.0;  // longest way of a point under the scale
};

ExtrudedMesh linear(const ModelNode& node, const PlaneShape& profile)
{
    const NodeReader read(node);
    LinearExtrudeOptions options;
    options.height = read.number("height");
    options.center = read.truth("center");
    options.scale = read.vec2("scale");
    options.twist = read.has("twist") ? read.number("twist") : 0.0;
    if (!(options.height > 0.0)) return {};
    options.slices = read.has("slices")
                         ? static_cast<int>(std::min(read.number("slices"), 1e8))
                         : SliceRule(read.facets(), profile.region, options).slices();
    const double widest = std::max({1.0, options.scale[0], options.scale[1]});
    return {linear_extrude(profile.region, options), widest * profile.deviation};
}

ExtrudedMesh rotational(const ModelNode& node, const PlaneShape& profile)
{
    const NodeReader read(node);
    RotateExtrudeOptions options;
    options.angle = read.number("angle");
    const Box2 box = bounds(profile.region);
    if (box.empty() || options.angle == 0.0) return {};
    const double reach = std::max(std::fabs(box.min[0]), std::fabs(box.max[0]));
    const Facets f = read.facets();
    double error = 0.0;
    double sides = f.round_fragments(box.max[0] - std::min(box.min[0], 0.0));
    if (sides == 0.0) {
        sides = fragments_within(kPlaneShare * node.tolerance, reach);
        error = reach * (1.0 - cos_degrees(180.0 / sides));
    }
    const bool full = options.angle == 360.0;
    options.fragments =
        std::max(full ? 3 : 1, static_cast<int>(sides * std::fabs(options.angle) / 360.0));
    // A full turn starts on the far side of the axis, as in older releases of the text language.
    options.start = full ? 180.0 : 0.0;
    return {rotate_extrude(profile.region, options), profile.deviation + error};
}

}  // namespace

bool is_plane_node(const std::string& name)
{
    return name == "square" || name == "circle" || name == "polygon" || name == "text" ||
           name == "projection" || name == "offset";
}

bool is_extrusion(const std::string& name)
{
    return name == "linear_extrude" || name == "rotate_extrude";
}

PlaneShape plane_shape(const ModelNode& node, std::vector<PlaneShape> parts)
{
    const auto method = methods().find(node.name);
    PlaneMaker maker(node, std::move(parts));
    try {
        return method == methods().end() ? maker.group() : (maker.*method->second)();
    } catch (const InvalidInput& problem) {
        throw ModelError(*node.file, node.line, node.column, problem.what());
    }
}

ExtrudedMesh extruded(const ModelNode& node, const PlaneShape& profile)
{
    if (profile.region.empty()) return {};
    return node.name == "linear_extrude" ? linear(node, profile) : rotational(node, profile);
}

int fragments_within(double tolerance, double r)
{
    return sides_within(tolerance, r);
}

}  // namespace genus::language
