#include "genus/language/builtins_solid.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "genus/base/progress.h"
#include "genus/language/stack.h"
#include "genus/language/tight_bounds.h"

namespace genus {

namespace {

using List = ModelValue::List;

/// Makes the solid of one node; its parts are made already.
class Maker {
public:
    Maker(const ModelNode& node, std::vector<Solid> parts, std::vector<Message>& messages)
        : node_(node), parts_(std::move(parts)), messages_(messages)
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
            mesh.vertices.push_back(vec3(points[i], "points[" + std::to_string(i) + "]"));
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
            bounds = Box3{vec3(corners[0], "bounds[0]"), vec3(corners[1], "bounds[1]")};
        }
        const List coefficients = rows("coefficients");
        if (coefficients.size() == 4) {
            std::array<std::array<double, 4>, 4> q;
            for (std::size_t i = 0; i < 4; ++i)
                q[i] = numbers<4>(coefficients[i], "coefficients[" + std::to_string(i) + "]");
            return genus::quadric(Quadric::from_matrix(q), bounds);
        }
        return genus::quadric(
            Quadric::from_polynomial(numbers<10>(node_.parameter("coefficients"), "coefficients")),
            bounds);
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
        const std::optional<Box3> box = language::tight_bounds(part);
        if (!box)
            fail(
                "resize() of this shape is not supported yet: only of shapes whose size is known "
                "without a mesh");
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

    [[noreturn]] void fail(const std::string& problem) const
    {
        throw ModelError(*node_.file, node_.line, node_.column, problem);
    }

private:
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

    double number(const char* name) const
    {
        const double* n = node_.parameter(name).number();
        if (!n) fail(node_.name + "(): " + name + " is no number");
        return *n;
    }
    bool truth(const char* name) const { return node_.parameter(name).truth(); }

    const List& rows(const char* name) const
    {
        const List* list = node_.parameter(name).list();
        if (!list) fail(node_.name + "(): " + name + " is no vector");
        return *list;
    }

    template <std::size_t n>
    std::array<double, n> numbers(const ModelValue& v, const std::string& name,
                                  bool finite = true) const
    {
        const List* list = v.list();
        std::array<double, n> out;
        bool good = list && list->size() == n;
        for (std::size_t i = 0; good && i < n; ++i) {
            const double* x = (*list)[i].number();
            good = x && (!finite || std::isfinite(*x));
            if (good) out[i] = *x;
        }
        if (!good)
            fail(node_.name + "(): " + name + " is no vector of " + std::to_string(n) +
                 " finite numbers");
        return out;
    }

    Vec3 vec3(const ModelValue& v, const std::string& name) const
    {
        return Vec3{numbers<3>(v, name)};
    }
    Vec3 vec3(const char* name) const { return vec3(node_.parameter(name), name); }

    std::int32_t point_number(const ModelValue& v, std::size_t n_points,
                              const std::string& face) const
    {
        const double* n = v.number();
        if (!n || !(*n > -1.0) || !(*n < static_cast<double>(n_points)))
            fail("polyhedron(): " + face + " names a point that is not among the " +
                 std::to_string(n_points));
        return static_cast<std::int32_t>(*n);
    }

    const ModelNode& node_;
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
        {"multmatrix", &Maker::transform},
        {"color", &Maker::color},
        {"resize", &Maker::resize},
    };
    return map;
}

Solid solid_of(const ModelNode& node, std::vector<Message>& messages)
{
    language::check_stack();
    current_progress().check();
    const auto method = methods().find(node.name);
    if (method == methods().end())
        throw ModelError(*node.file, node.line, node.column,
                         "geometry of '" + node.name + "' is not supported yet");
    std::vector<Solid> parts;
    for (const ModelNode& child : node.children)
        if (!child.background) parts.push_back(solid_of(child, messages));
    Maker maker(node, std::move(parts), messages);
    try {
        return (maker.*method->second)();
    } catch (const InvalidInput& problem) {
        maker.fail(problem.what());
    }
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

Solid to_solid(const ModelNode& tree, std::vector<Message>& messages)
{
    return solid_of(picked(tree), messages);
}

}  // namespace genus
