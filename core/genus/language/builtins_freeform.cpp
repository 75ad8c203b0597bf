#include "genus/language/builtins_freeform.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "genus/base/transform.h"
#include "genus/deform/inverse_ffd.h"
#include "genus/io/patch_file.h"
#include "genus/language/node_reader.h"
#include "genus/language/stack.h"
#include "genus/model/deformed.h"
#include "genus/model/leaf_mesh.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/patch_solid.h"
#include "genus/model/queries.h"
#include "genus/patch/bspline.h"
#include "genus/patch/subdivision.h"

namespace genus::language {

namespace {

using List = ModelValue::List;

// The share of a tolerance that the corners of plane curves, or a part meshed first, may take.
constexpr double kCurveShare = 0.5, kPartShare = 0.25;
constexpr double kMostPieces = 1e6;

// Runs `make`; what it finds wrong with numbers is an error of the node.
template <class Make>
auto at_node(const ModelNode& node, const Make& make)
{
    try {
        return make();
    } catch (const InvalidInput& problem) {
        throw ModelError(*node.file, node.line, node.column, node.name + "(): " + problem.what());
    }
}

class FreeformReader : public NodeReader {
public:
    using NodeReader::NodeReader;

    int integer(const char* name, int otherwise) const
    {
        if (!has(name)) return otherwise;
        const double n = number(name);
        if (!(std::fabs(n) <= 1e9) || n != std::trunc(n))
            fail(node_.name + "(): " + name + " is no whole number");
        return static_cast<int>(n);
    }
    bool truth_or(const char* name, bool otherwise) const
    {
        return has(name) ? truth(name) : otherwise;
    }
    std::string text_or(const char* name, const char* otherwise) const
    {
        const std::string* text = node_.parameter(name).text();
        return text ? *text : otherwise;
    }
    const List& list(const ModelValue& v, const std::string& name) const
    {
        if (!v.list()) fail(node_.name + "(): " + name + " is no vector");
        return *v.list();
    }
    std::vector<Vec3> points(const ModelValue& v, const std::string& name) const
    {
        std::vector<Vec3> result;
        for (const ModelValue& p : list(v, name))
            result.push_back(vec<3>(p, name + "[" + std::to_string(result.size()) + "]"));
        return result;
    }
    std::vector<Vec3> points(const char* name) const { return points(node_.parameter(name), name); }
    // In the plane, as points with z = 0.
    std::vector<Vec3> plane_points(const char* name) const
    {
        std::vector<Vec3> result;
        for (const ModelValue& p : rows(name)) {
            const Vec2 q = vec<2>(p, std::string(name) + "[" + std::to_string(result.size()) + "]");
            result.push_back({{q[0], q[1], 0.0}});
        }
        return result;
    }
    void add_numbers(const ModelValue& v, const std::string& name, std::vector<double>& to) const
    {
        for (const ModelValue& x : list(v, name)) {
            if (!x.number()) fail(node_.name + "(): " + name + " holds what is no number");
            to.push_back(*x.number());
        }
    }
    std::vector<double> numbers_or_none(const char* name) const
    {
        std::vector<double> result;
        if (has(name)) add_numbers(node_.parameter(name), name, result);
        return result;
    }
    std::array<int, 3> triple(const char* name, int otherwise) const
    {
        if (!has(name)) return {otherwise, otherwise, otherwise};
        if (node_.parameter(name).number()) {
            const int n = integer(name, otherwise);
            return {n, n, n};
        }
        const Vec3 v = vec3(name);
        std::array<int, 3> result;
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(std::fabs(v[k]) <= 1e6) || v[k] != std::trunc(v[k]))
                fail(node_.name + "(): " + name + " is not made of whole numbers");
            result[k] = static_cast<int>(v[k]);
        }
        return result;
    }
};

// ---- Curves

double length_of(std::span<const Vec3> points)
{
    double length = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) length += distance(points[i - 1], points[i]);
    return length;
}

// Corners on a curve with parameters in [first, last].
template <class Curve>
PlaneShape bounded_by(const FreeformReader& read, const ModelNode& node, const Curve& curve,
                      double first, double last)
{
    std::vector<Vec3> points;
    PlaneShape shape;
    const Facets facets = read.facets();
    if (!(facets.fn > 0.0) && node.tolerance > 0.0) {
        FlattenedCurve flat = curve.flatten(kCurveShare * node.tolerance);
        points = std::move(flat.points);
        shape.deviation = flat.bound;
    } else {
        const double wanted =
            facets.fn > 0.0 ? facets.fn : std::ceil(length_of(curve.points()) / facets.fs);
        const int n = static_cast<int>(std::clamp(wanted, 5.0, kMostPieces));
        std::vector<double> t;
        for (int i = 0; i <= n; ++i) t.push_back(first + (last - first) * i / n);
        points.resize(t.size());
        curve.evaluate(t, points);
    }
    Ring ring;
    for (const Vec3& p : points) ring.push_back({{p[0], p[1]}});
    if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
    const Ring rings[] = {ring};
    shape.region = make_region(rings, FillRule::EvenOdd);
    return shape;
}

PlaneShape bezier_curve(const ModelNode& node)
{
    const FreeformReader read(node);
    return bounded_by(read, node,
                      BezierCurve(read.plane_points("points"), read.numbers_or_none("weights")),
                      0.0, 1.0);
}

PlaneShape bspline(const ModelNode& node)
{
    const FreeformReader read(node);
    const int degree = read.integer("degree", 3);
    const auto points = read.plane_points("points");
    const auto knots = read.numbers_or_none("knots"), weights = read.numbers_or_none("weights");
    if (read.truth_or("closed", knots.empty() && weights.empty())) {
        if (!knots.empty() || !weights.empty())
            read.fail("bspline(): a closed curve takes no knots and no weights");
        const BSpline curve = BSpline::closed(points, degree);
        return bounded_by(read, node, curve, curve.knots().begin(), curve.knots().end());
    }
    require(degree >= 1 && degree < static_cast<int>(points.size()), "degree", degree,
            "at least 1 and less than the number of points");
    const BSpline curve(points,
                        knots.empty() ? KnotVector::clamped(degree, static_cast<int>(points.size()))
                                      : KnotVector(degree, knots),
                        weights);
    return bounded_by(read, node, curve, curve.knots().begin(), curve.knots().end());
}

// ---- Patches

TensorPatch tensor_patch(const ModelNode& node)
{
    const FreeformReader read(node);
    const List& rows = read.rows("points");
    std::vector<Vec3> points;
    std::size_t columns = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto row = read.points(rows[i], "points[" + std::to_string(i) + "]");
        if (i > 0 && row.size() != columns) read.fail("bezier_patch(): rows of different length");
        columns = row.size();
        points.insert(points.end(), row.begin(), row.end());
    }
    std::vector<double> weights;
    if (read.has("weights"))
        for (const ModelValue& row : read.rows("weights"))
            read.add_numbers(row, "weights", weights);
    require(!points.empty(), "there are no points");
    return TensorPatch(static_cast<int>(rows.size()) - 1, static_cast<int>(columns) - 1,
                       std::move(points), std::move(weights));
}

// Points in rows, the first from u = v = 0 along v; or all in one list.
BezierTriangle triangle_patch(const ModelNode& node)
{
    const FreeformReader read(node);
    const List& given = read.rows("points");
    std::vector<Vec3> points;
    const bool in_rows = !given.empty() && given[0].list() && !given[0].list()->empty() &&
                         given[0].list()->front().list();
    if (!in_rows) {
        points = read.points("points");
    } else {
        for (std::size_t i = 0; i < given.size(); ++i) {
            const auto row = read.points(given[i], "points[" + std::to_string(i) + "]");
            if (row.size() != given.size() - i)
                read.fail(
                    "triangle_patch(): each row must be one point shorter than the one "
                    "before, the last a single point");
            points.insert(points.end(), row.begin(), row.end());
        }
    }
    int degree = 0;
    while (static_cast<std::size_t>(degree + 1) * static_cast<std::size_t>(degree + 2) / 2 <
           points.size())
        ++degree;
    return BezierTriangle(degree, std::move(points), read.numbers_or_none("weights"));
}

std::vector<Patch> patches_of_file(const ModelNode& node)
{
    try {
        return read_patches(node.path);
    } catch (const FileError& problem) {
        FreeformReader(node).fail("patches(): " + std::string(problem.what()));
    }
}

void add_patches(const ModelNode& node, const Transform& map, std::vector<Patch>& out)
{
    check_stack();
    if (node.background) return;
    if (node.name == "bezier_patch" || node.name == "triangle_patch") {
        out.push_back(at_node(node, [&]() -> Patch {
            if (node.name == "bezier_patch") return transformed(tensor_patch(node), map);
            return transformed(triangle_patch(node), map);
        }));
        return;
    }
    if (node.name == "patches" && !node.path.empty())
        for (const Patch& patch : patches_of_file(node))
            std::visit([&](const auto& p) { out.emplace_back(transformed(p, map)); }, patch);
    Transform below = map;
    if (node.name == "multmatrix") {
        const FreeformReader read(node);
        Transform t;
        for (std::size_t r = 0; r < 4; ++r) t.m[r] = read.numbers<4>(read.rows("").at(r), "matrix");
        below = map * t;
    } else if (node.name != "patches" && node.name != "group" && node.name != "union" &&
               node.name != "color") {
        FreeformReader(node).fail("'" + node.name + "' among patches");
    }
    for (const ModelNode& child : node.children) add_patches(child, below, out);
}

Solid solid_of_patches(const ModelNode& node)
{
    std::vector<Patch> patches;
    add_patches(node, Transform{}, patches);
    return at_node(node, [&] { return patch_solid(oriented(PatchModel(std::move(patches)))); });
}

// ---- Deformations

Lattice lattice_of(const FreeformReader& read, const ModelNode& node, const Solid& part,
                   double margin)
{
    const std::array<int, 3> degree = read.triple("degree", 3);
    Box3 box = require_bounded(part);
    box = box.inflated(margin * box.diagonal());
    Vec3 origin = box.min;
    const Vec3 size = box.size();
    Columns3 axes = {Vec3{{size[0], 0, 0}}, Vec3{{0, size[1], 0}}, Vec3{{0, 0, size[2]}}};
    if (read.has("origin")) {
        origin = read.vec3("origin");
        if (!read.has("axes")) read.fail(node.name + "(): origin is given without axes");
    }
    if (read.has("axes")) {
        if (!read.has("origin")) read.fail(node.name + "(): axes are given without origin");
        // Three vectors, or the three lengths of a box.
        const ModelValue& given = node.parameter("axes");
        if (given.list() && given.list()->size() == 3 && given.list()->front().number()) {
            const Vec3 lengths = read.vec3("axes");
            axes = {Vec3{{lengths[0], 0, 0}}, Vec3{{0, lengths[1], 0}}, Vec3{{0, 0, lengths[2]}}};
        } else {
            const auto vectors = read.points("axes");
            if (vectors.size() != 3) read.fail(node.name + "(): axes are not three vectors");
            axes = {vectors[0], vectors[1], vectors[2]};
        }
    }
    return Lattice(origin, axes, degree);
}

void set_points(const FreeformReader& read, const ModelNode& node, Lattice& lattice)
{
    std::vector<Vec3> points;
    for (const ModelValue& plane : read.rows("points"))
        for (const ModelValue& row : read.list(plane, "points"))
            for (const Vec3& p : read.points(row, "points")) points.push_back(p);
    if (points.size() != lattice.n_points())
        read.fail(node.name + "(): " + std::to_string(points.size()) +
                  " control points; the degree asks for " + std::to_string(lattice.n_points()));
    lattice.set_points(points);
}

// Each move is [[i, j, k], [x, y, z]].
void move_some(const FreeformReader& read, const ModelNode& node, Lattice& lattice)
{
    const List& moves = read.rows("moves");
    for (std::size_t m = 0; m < moves.size(); ++m) {
        const std::string name = "moves[" + std::to_string(m) + "]";
        const List& pair = read.list(moves[m], name);
        if (pair.size() != 2)
            read.fail(node.name + "(): " + name + " is not [[i, j, k], [x, y, z]]");
        const Vec3 which = read.vec<3>(pair[0], name + "[0]");
        const Vec3 by = read.vec<3>(pair[1], name + "[1]");
        std::array<int, 3> at;
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(which[k] >= 0.0 && which[k] < lattice.counts()[k]) ||
                which[k] != std::trunc(which[k]))
                read.fail(node.name + "(): " + name + " names no control point");
            at[k] = static_cast<int>(which[k]);
        }
        lattice.set_point(at[0], at[1], at[2], lattice.point(at[0], at[1], at[2]) + by);
    }
}

Solid ffd(const ModelNode& node, const Solid& part)
{
    const FreeformReader read(node);
    Lattice lattice = lattice_of(read, node, part, 0.0);
    if (read.has("points")) set_points(read, node, lattice);
    if (read.has("moves")) move_some(read, node, lattice);
    return deformed(part, lattice);
}

Solid move_points(const ModelNode& node, const Solid& part, std::vector<Message>& messages)
{
    const FreeformReader read(node);
    const Lattice lattice = lattice_of(read, node, part, 0.05);
    const auto from = read.points("from"), to = read.points("to");
    if (from.size() != to.size())
        read.fail("move_points(): " + std::to_string(from.size()) + " points from, " +
                  std::to_string(to.size()) + " to");
    std::vector<FfdConstraint> constraints;
    for (std::size_t i = 0; i < from.size(); ++i)
        constraints.push_back({from[i], to[i], 1.0, std::nullopt});
    FfdFitOptions options;
    options.keep_border = read.integer("keep_border", -1);
    if (read.has("regularisation")) options.regularisation = read.number("regularisation");
    const FfdFit fit = fit_lattice(lattice, std::move(constraints), options);
    if (!fit.unmet.empty() && options.regularisation == 0.0)
        messages.push_back({Message::Kind::Warning, *node.file, node.line, node.column,
                            "WARNING: move_points(): " + fit.summary() + " in file " + *node.file +
                                ", line " + std::to_string(node.line)});
    return deformed(part, fit.lattice);
}

Solid subdivided(const ModelNode& node, const Solid& part)
{
    const FreeformReader read(node);
    const std::string scheme = read.text_or("scheme", "catmull_clark");
    if (scheme != "catmull_clark" && scheme != "loop")
        read.fail("subdivide(): scheme must be \"catmull_clark\" or \"loop\"");
    const bool loop = scheme == "loop";
    SubdivisionMesh cage;
    double deviation = 0.0;
    if (is_faceted(part.node().shape)) {
        cage.mesh = facet_mesh(part.node().shape);
        if (const auto* given = std::get_if<Polyhedron>(&part.node().shape))
            deviation = given->deviation;
    } else {
        MeshOptions options;
        options.measure = false;
        if (node.tolerance > 0.0) options.tolerance = kPartShare * node.tolerance;
        MeshedSolid made = mesh_solid(part, options);
        deviation = made.error.bound;
        cage.mesh = to_polygons(made.mesh);
    }
    if (loop) cage.mesh = to_polygons(to_triangles(cage.mesh));
    const int levels = read.integer("levels", 1);
    SubdivisionMesh fine = loop ? loop_subdivision(cage, levels) : catmull_clark(cage, levels);
    if (read.truth("limit"))
        fine.mesh.vertices =
            limit_surface(fine, loop ? SubdivisionScheme::Loop : SubdivisionScheme::CatmullClark)
                .points;
    return polyhedron(std::move(fine.mesh), deviation);
}

}  // namespace

bool is_freeform_shape(const std::string& name)
{
    return name == "bezier_curve" || name == "bspline" || name == "bezier_patch" ||
           name == "triangle_patch" || name == "patches";
}

std::variant<PlaneShape, Solid> freeform_shape(const ModelNode& node)
{
    if (node.name == "bezier_curve") return at_node(node, [&] { return bezier_curve(node); });
    if (node.name == "bspline") return at_node(node, [&] { return bspline(node); });
    return solid_of_patches(node);
}

bool is_deformation(const std::string& name)
{
    return name == "ffd" || name == "move_points" || name == "subdivide";
}

Solid deformed_solid(const ModelNode& node, const Solid& part, std::vector<Message>& messages)
{
    if (part.is_empty()) return part;
    return at_node(node, [&] {
        if (node.name == "ffd") return ffd(node, part);
        if (node.name == "move_points") return move_points(node, part, messages);
        return subdivided(node, part);
    });
}

}  // namespace genus::language
