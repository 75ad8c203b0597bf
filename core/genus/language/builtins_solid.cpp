#include "genus/language/builtins_solid.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <variant>

#include "genus/base/progress.h"
#include "genus/implicit/parse_expression.h"
#include "genus/io/read_mesh.h"
#include "genus/language/builtins_files.h"
#include "genus/language/builtins_freeform.h"
#include "genus/language/builtins_plane.h"
#include "genus/language/node_reader.h"
#include "genus/language/stack.h"
#include "genus/language/tight_bounds.h"
#include "genus/mesh/slice.h"
#include "genus/model/construct.h"
#include "genus/model/mesh_solid.h"

namespace genus {

namespace {

using language::ExtrudedMesh;
using language::NodeReader;
using language::plane_shape;
using language::PlaneShape;
using List = ModelValue::List;

constexpr double kPartShare = 0.25;  // of the tolerance, for parts that are meshed first

/// Makes the solid of one node; its parts are made already.
class Maker : NodeReader {
public:
    Maker(const ModelNode& node, std::vector<Solid> parts, std::vector<Message>& messages)
        : NodeReader(node), parts_(std::move(parts)), messages_(messages)
    {
    }

    using Method = Solid (Maker::*)();

    Solid group() { return join(); }
    Solid difference() { return subtract(std::move(parts_)); }
    Solid intersection() { return intersect(std::move(parts_)); }

    Solid cube()
    {
        const Vec3 size = vec3("size");
        if (!(size[0] > 0 && size[1] > 0 && size[2] > 0)) return Solid();
        return genus::cube(size, truth("center"));
    }

    Solid sphere()
    {
        const double r = number("r");
        return r > 0 ? genus::sphere(r, node_.fragments) : Solid();
    }

    Solid cylinder()
    {
        const double h = number("h"), r1 = number("r1"), r2 = number("r2");
        if (!(h > 0) || !(r1 >= 0) || !(r2 >= 0) || !(r1 + r2 > 0)) return Solid();
        return genus::cylinder(h, r1, r2, truth("center"), node_.fragments);
    }

    Solid polyhedron()
    {
        const List points = rows("points");
        PolygonMesh mesh;
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.vertices.push_back(vec<3>(points[i], "points[" + std::to_string(i) + "]"));
        const List faces = rows("faces");
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const std::string name = "faces[" + std::to_string(f) + "]";
            if (!faces[f].list() || faces[f].list()->size() < 3)
                fail(name + " is no list of at least three point numbers");
            std::vector<std::int32_t> corners;
            for (const ModelValue& corner : *faces[f].list())
                corners.push_back(point_number(corner, mesh.vertices.size(), name));
            std::reverse(corners.begin(), corners.end());
            mesh.add_face(corners);
        }
        if (mesh.n_faces() == 0) return Solid();
        return genus::polyhedron(std::move(mesh));
    }

    Solid torus() { return genus::torus(number("R"), number("r")); }

    Solid ellipsoid()
    {
        if (node_.parameter("rx").list()) return genus::ellipsoid(vec3("rx"));
        return genus::ellipsoid(Vec3{{number("rx"), number("ry"), number("rz")}});
    }

    Solid cone()
    {
        return genus::cylinder(number("h"), number("r"), 0.0, truth("center"), node_.fragments);
    }

    Solid quadric()
    {
        std::optional<Box3> bounds;
        if (!node_.parameter("bounds").is_undef()) {
            const List corners = rows("bounds");
            if (corners.size() != 2) fail("bounds must be two corners, [min, max]");
            bounds = Box3{vec<3>(corners[0], "bounds[0]"), vec<3>(corners[1], "bounds[1]")};
        }
        const List coefficients = rows("coefficients");
        if (coefficients.size() == 4) {
            std::array<std::array<double, 4>, 4> q;
            for (std::size_t i = 0; i < 4; ++i)
                q[i] = numbers<4>(coefficients[i], "coefficients[" + std::to_string(i) + "]");
            return genus::quadric(Quadric::from_matrix(q), bounds);
        }
        return genus::quadric(Quadric(numbers<10>(node_.parameter("coefficients"), "coefficients")),
                              bounds);
    }

    Solid implicit()
    {
        const std::string* formula = node_.parameter("f").text();
        if (!formula) fail("implicit(): f is no text");
        const List corners = rows("bounds");
        if (corners.size() != 2) fail("implicit(): bounds must be two corners, [min, max]");
        return genus::implicit(parse_expression(*formula),
                               {vec<3>(corners[0], "bounds[0]"), vec<3>(corners[1], "bounds[1]")});
    }

    Solid half_space() { return genus::half_space(vec3("normal"), number("offset")); }

    Solid transform()
    {
        Transform t;
        const List matrix = rows("");
        for (std::size_t r = 0; r < 4; ++r) t.m[r] = numbers<4>(matrix.at(r), "matrix", false);
        const Solid part = join();
        if (part.is_empty() || t.is_identity()) return part;
        for (const auto& row : t.m)
            for (const double x : row)
                if (!std::isfinite(x))
                    return removed("Transformation matrix contains Not-a-Number and/or Infinity");
        if (determinant(t) == 0.0) return removed("Scaling a 3D object with 0");
        // A chain of transforms is one.
        if (const auto* inner = std::get_if<Transformed>(&part.node().shape))
            return transformed(inner->part, t * inner->map);
        return transformed(part, t);
    }

    Solid color()
    {
        const auto rgba = numbers<4>(node_.parameter(""), "color");
        const Solid part = join();
        // Below zero: no colour was given.
        if (part.is_empty() || rgba[0] < 0) return part;
        Vec4 clamped;
        for (std::size_t i = 0; i < 4; ++i) clamped[i] = std::clamp(rgba[i], 0.0, 1.0);
        return colored(part, clamped);
    }

    Solid resize()
    {
        const Solid part = join();
        if (part.is_empty()) return part;
        std::optional<Box3> box = language::tight_bounds(part);
        if (!box) box = bounds(mesh_of(part).mesh);
        const Vec3 wanted = vec3("newsize"), keep = vec3("auto"), size = box->size();
        Vec3 factor{{1, 1, 1}};
        // Sides set to 0 follow the largest factor given, where `auto` says so.
        double follow = 1.0;
        for (int i = 0; i < 3; ++i)
            if (wanted[i] > 0) {
                factor[i] = wanted[i] / size[i];
                follow = follow == 1.0 ? factor[i] : std::max(follow, factor[i]);
            }
        for (int i = 0; i < 3; ++i)
            if (!(wanted[i] > 0) && keep[i] != 0) factor[i] = follow;
        return transformed(part, scaling(factor));
    }

    Solid hull() { return genus::hull(parts_, part_tolerance()); }
    Solid minkowski() { return genus::minkowski(parts_, part_tolerance()); }

    Solid import()
    {
        try {
            PolygonMesh mesh = read_polygons(node_.path);
            if (mesh.n_faces() == 0) return Solid();
            return genus::polyhedron(std::move(mesh));
        } catch (const FileError& problem) {
            fail(std::string("import(): ") + problem.what());
        }
    }

    using NodeReader::fail;

    struct MeshedPart {
        IndexedMesh mesh;
        double deviation = 0.0;
    };
    // A solid as a mesh, within the share of the tolerance that a part may take.
    MeshedPart mesh_of(const Solid& solid) const
    {
        MeshOptions options;
        options.measure = false;
        options.tolerance = part_tolerance();
        MeshedSolid made = mesh_solid(solid, options);
        const double exact = 1e-9 * bounds(made.mesh).diagonal();
        return {std::move(made.mesh), made.error.bound > exact ? made.error.bound : 0.0};
    }

private:
    std::optional<double> part_tolerance() const
    {
        return node_.tolerance > 0.0 ? std::optional(kPartShare * node_.tolerance) : std::nullopt;
    }

    Solid join()
    {
        if (parts_.size() == 1) return parts_[0];
        return unite(std::move(parts_));
    }

    Solid removed(const std::string& why)
    {
        messages_.push_back({Message::Kind::Warning, *node_.file, node_.line, node_.column,
                             "WARNING: " + why + " - removing object. in file " + *node_.file +
                                 ", line " + std::to_string(node_.line)});
        return Solid();
    }

    std::vector<Solid> parts_;
    std::vector<Message>& messages_;
};

const std::unordered_map<std::string_view, Maker::Method>& methods()
{
    static const std::unordered_map<std::string_view, Maker::Method> map = {
        {"root", &Maker::group},
        {"group", &Maker::group},
        {"union", &Maker::group},
        {"render", &Maker::group},
        {"difference", &Maker::difference},
        {"intersection", &Maker::intersection},
        {"cube", &Maker::cube},
        {"sphere", &Maker::sphere},
        {"cylinder", &Maker::cylinder},
        {"polyhedron", &Maker::polyhedron},
        {"torus", &Maker::torus},
        {"ellipsoid", &Maker::ellipsoid},
        {"cone", &Maker::cone},
        {"quadric", &Maker::quadric},
        {"half_space", &Maker::half_space},
        {"implicit", &Maker::implicit},
        {"multmatrix", &Maker::transform},
        {"color", &Maker::color},
        {"resize", &Maker::resize},
        {"hull", &Maker::hull},
        {"minkowski", &Maker::minkowski},
        {"import", &Maker::import},
    };
    return map;
}

// What a node comes to.
using Geometry = std::variant<PlaneShape, Solid>;

void warn_of_mixture(const ModelNode& node, std::vector<Message>& messages)
{
    messages.push_back({Message::Kind::Warning, *node.file, node.line, node.column,
                        "WARNING: Mixing 2D and 3D objects is not supported. in file " +
                            *node.file + ", line " + std::to_string(node.line)});
}

bool is_nothing(const Geometry& part)
{
    if (const auto* plane = std::get_if<PlaneShape>(&part)) return plane->region.empty();
    return std::get<Solid>(part).is_empty();
}

// The parts of one kind, with nothing in the place of nothing; the other kind is left out with a
// warning.
template <typename Kind>
std::vector<Kind> taken(const ModelNode& node, std::vector<Geometry>& parts,
                        std::vector<Message>& messages)
{
    std::vector<Kind> kept;
    bool mixed = false;
    for (Geometry& part : parts)
        if (is_nothing(part))
            kept.emplace_back();
        else if (auto* kind = std::get_if<Kind>(&part))
            kept.push_back(std::move(*kind));
        else
            mixed = true;
    if (mixed) warn_of_mixture(node, messages);
    return kept;
}

Geometry solid_from(const ModelNode& node, std::vector<Solid> parts, std::vector<Message>& messages)
{
    const auto method = methods().find(node.name);
    if (method == methods().end())
        throw ModelError(*node.file, node.line, node.column,
                         "geometry of '" + node.name + "' is not supported yet");
    Maker maker(node, std::move(parts), messages);
    try {
        return (maker.*method->second)();
    } catch (const InvalidInput& problem) {
        maker.fail(problem.what());
    }
}

Geometry extruded_solid(const ModelNode& node, std::vector<PlaneShape> parts)
{
    try {
        const PlaneShape profile = node.path.empty() ? plane_shape(node, std::move(parts))
                                                     : language::imported_shape(node);
        ExtrudedMesh made = language::extruded(node, profile);
        if (made.mesh.n_faces() == 0) return Solid();
        return polyhedron(std::move(made.mesh), made.deviation);
    } catch (const InvalidInput& problem) {
        throw ModelError(*node.file, node.line, node.column, problem.what());
    }
}

Geometry projected(const ModelNode& node, std::vector<Solid> parts, std::vector<Message>& messages)
{
    Maker maker(node, {}, messages);
    const auto part = maker.mesh_of(unite(std::move(parts)));
    return PlaneShape{node.parameter("cut").truth() ? slice(part.mesh, 0.0) : project(part.mesh),
                      part.deviation};
}

Geometry geometry_of(const ModelNode& node, std::vector<Message>& messages)
{
    language::check_stack();
    current_progress().check();
    if (language::is_freeform_shape(node.name)) return language::freeform_shape(node);
    if (node.name == "text") return language::text_shape(node, messages);
    if (language::is_plane_import(node)) return language::imported_shape(node);
    if (node.name == "surface") return language::surface_solid(node);
    std::vector<Geometry> parts;
    for (const ModelNode& child : node.children)
        if (!child.background) parts.push_back(geometry_of(child, messages));
    if (node.name == "projection")
        return projected(node, taken<Solid>(node, parts, messages), messages);
    if (language::is_extrusion(node.name))
        return extruded_solid(node, taken<PlaneShape>(node, parts, messages));
    if (language::is_deformation(node.name))
        return language::deformed_solid(node, unite(taken<Solid>(node, parts, messages)), messages);
    // What has extent first decides whether the node is plane.
    const auto first = std::find_if(parts.begin(), parts.end(),
                                    [](const Geometry& part) { return !is_nothing(part); });
    const bool plane = first != parts.end() ? std::holds_alternative<PlaneShape>(*first)
                                            : language::is_plane_node(node.name);
    if (plane) return plane_shape(node, taken<PlaneShape>(node, parts, messages));
    return solid_from(node, taken<Solid>(node, parts, messages), messages);
}

// The first node, in order of the text, that the modifier ! picks.
const ModelNode& picked(const ModelNode& tree)
{
    std::vector<const ModelNode*> open{&tree};
    while (!open.empty()) {
        const ModelNode* node = open.back();
        open.pop_back();
        if (node->root) return *node;
        for (std::size_t i = node->children.size(); i-- > 0;) open.push_back(&node->children[i]);
    }
    return tree;
}

}  // namespace

ModelGeometry to_geometry(const ModelNode& tree, std::vector<Message>& messages)
{
    Geometry made = geometry_of(picked(tree), messages);
    if (auto* solid = std::get_if<Solid>(&made)) return {std::move(*solid), std::nullopt};
    return {Solid(), std::move(std::get<PlaneShape>(made).region)};
}

Solid to_solid(const ModelNode& tree, std::vector<Message>& messages)
{
    ModelGeometry made = to_geometry(tree, messages);
    if (made.region && !made.region->empty()) {
        const ModelNode& top = picked(tree);
        throw ModelError(*top.file, top.line, top.column,
                         "the model is a plane shape; extrude it to a solid");
    }
    return std::move(made.solid);
}

}  // namespace genus
