#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "genus/base/transform.h"
#include "genus/language/colors.h"
#include "genus/language/evaluate.h"
#include "genus/language/facets.h"

namespace genus::language {

namespace fs = std::filesystem;

namespace {

using Arguments = ModuleArguments;

bool is_true(const Value& v)
{
    return v.is_bool() && v.as_bool();
}

std::optional<double> number(const Value& v)
{
    return v.is_number() ? std::optional(v.as_number()) : std::nullopt;
}

// Up to three numbers of a vector; nothing if one of them is none.
std::optional<std::vector<double>> numbers(const Value& v, std::size_t least, std::size_t most)
{
    if (!v.is_list()) return std::nullopt;
    const auto items = v.items();
    if (items.size() < least || items.size() > most) return std::nullopt;
    std::vector<double> out;
    for (const Value& item : items) {
        if (!item.is_number()) return std::nullopt;
        out.push_back(item.as_number());
    }
    return out;
}

// Deeper lists than any parameter has are cut off, so that nobody need fear to walk a tree.
constexpr int kMaxListDepth = 50;

ModelValue to_model(const Value& v, const Names& names, int depth = 0)
{
    if (depth > kMaxListDepth) return {};
    switch (v.tag()) {
        case Value::Tag::Bool:
            return v.as_bool();
        case Value::Tag::Number:
            return v.as_number();
        case Value::Tag::String:
            return std::string(v.as_string());
        case Value::Tag::List: {
            ModelValue::List list;
            list.reserve(v.items().size());
            for (const Value& item : v.items()) list.push_back(to_model(item, names, depth + 1));
            return list;
        }
        case Value::Tag::Range:
        case Value::Tag::Function:
            return to_text(v, names);
        default:
            return {};
    }
}

ModelValue to_model(std::span<const double> items)
{
    return ModelValue::List(items.begin(), items.end());
}

ModelValue to_model(const Transform& t)
{
    ModelValue::List rows;
    for (const auto& row : t.m) rows.push_back(to_model(row));
    return rows;
}

// A number as warnings show it, any other value in full.
std::string shown(Evaluator& e, const Value& v)
{
    return to_quoted_text(v, e.program().names);
}

void warn(Evaluator& e, const Statement& s, const std::string& text)
{
    e.diagnostics().warn(s.place, text);
}

Facets facets(const Evaluator& e)
{
    const auto get = [&](std::string_view name, double otherwise) {
        return number(e.special(name)).value_or(otherwise);
    };
    Facets f;
    f.fn = get("$fn", 0.0);
    f.fs = std::max(get("$fs", 2.0), Facets::kSmallest);
    f.fa = std::max(get("$fa", 12.0), Facets::kSmallest);
    f.tolerance = get("$tolerance", 0.0);
    return f;
}

void add_facets(ModelNode& node, const Facets& f)
{
    node.parameters.emplace_back("$fn", f.fn);
    node.parameters.emplace_back("$fa", f.fa);
    node.parameters.emplace_back("$fs", f.fs);
}

// Radius from r or d, the latter first.
std::optional<double> radius(Evaluator& e, const Statement& s, const Arguments& a,
                             std::string_view diameter_name, std::string_view radius_name)
{
    const Value &d = a[diameter_name], &r = a[radius_name];
    if (d.is_number()) {
        if (!r.is_undef())
            warn(e, s,
                 "Ignoring radius variable '" + std::string(radius_name) + "' as diameter '" +
                     std::string(diameter_name) + "' is defined too.");
        return d.as_number() / 2.0;
    }
    return number(r);
}

// Solids.

ModelNode cube(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("cube", s);
    std::vector<double> size{1, 1, 1};
    const Value& given = a["size"];
    if (given.is_number())
        size.assign(3, given.as_number());
    else if (const auto v = numbers(given, 3, 3))
        size = *v;
    else if (!given.is_undef())
        warn(e, s,
             "Unable to convert cube(size=" + shown(e, given) +
                 ", ...) parameter to a number or a vec3 of numbers");
    node.parameters = {{"size", to_model(size)}, {"center", is_true(a["center"])}};
    return node;
}

ModelNode sphere(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("sphere", s);
    const double r = radius(e, s, a, "d", "r").value_or(1.0);
    const Facets f = facets(e);
    add_facets(node, f);
    node.parameters.emplace_back("r", r);
    node.fragments = f.round_fragments(r);
    return node;
}

ModelNode cylinder(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("cylinder", s);
    const double h = number(a["h"]).value_or(1.0);
    const auto both = radius(e, s, a, "d", "r");
    const auto bottom = radius(e, s, a, "d1", "r1");
    const auto top = radius(e, s, a, "d2", "r2");
    if (both && (bottom || top)) warn(e, s, "Cylinder parameters ambiguous");
    const double r1 = bottom.value_or(both.value_or(1.0)), r2 = top.value_or(both.value_or(1.0));
    const Facets f = facets(e);
    add_facets(node, f);
    node.parameters.emplace_back("h", h);
    node.parameters.emplace_back("r1", r1);
    node.parameters.emplace_back("r2", r2);
    node.parameters.emplace_back("center", is_true(a["center"]));
    node.fragments = f.round_fragments(std::max(std::fabs(r1), std::fabs(r2)));
    return node;
}

ModelNode polyhedron(Evaluator& e, const Statement& s, const Arguments& a)
{
    const Names& names = e.program().names;
    ModelNode node = e.make_node("polyhedron", s);
    const Value* faces = &a["faces"];
    if (faces->is_undef() && !a["triangles"].is_undef()) {
        e.diagnostics().deprecated_anywhere(
            s.place,
            "polyhedron(triangles=[]) will be removed in future releases. Use "
            "polyhedron(faces=[]) instead.");
        faces = &a["triangles"];
    }
    node.parameters = {{"points", to_model(a["points"], names)},
                       {"faces", to_model(*faces, names)},
                       {"convexity", number(a["convexity"]).value_or(1.0)}};
    return node;
}

// Solids of our own. What is not a number is left for the maker of solids to refuse.

template <const char* name>
ModelNode own_solid(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node(name, s);
    for (std::size_t i = 0; i < a.names->size(); ++i)
        if (!a.values[i].is_undef())
            node.parameters.emplace_back(std::string((*a.names)[i]),
                                         to_model(a.values[i], e.program().names));
    return node;
}
constexpr char kTorus[] = "torus", kEllipsoid[] = "ellipsoid", kCone[] = "cone",
               kQuadric[] = "quadric", kHalfSpace[] = "half_space", kImplicit[] = "implicit";
constexpr char kBezierCurve[] = "bezier_curve", kBspline[] = "bspline",
               kBezierPatch[] = "bezier_patch", kTrianglePatch[] = "triangle_patch", kFfd[] = "ffd",
               kMovePoints[] = "move_points", kSubdivide[] = "subdivide";

// Curves are cut into pieces by the special variables.
template <const char* name>
ModelNode own_curve(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = own_solid<name>(e, s, a);
    add_facets(node, facets(e));
    return node;
}

// Transforms.

ModelNode transform_node(Evaluator& e, const Statement& s, const Transform& t)
{
    ModelNode node = e.make_node("multmatrix", s);
    node.parameters.emplace_back("", to_model(t));
    return node;
}

// x, y and z of a vector of two or three numbers.
std::optional<Vec3> vector_2_or_3(const Value& v, double z)
{
    const auto n = numbers(v, 2, 3);
    if (!n) return std::nullopt;
    return Vec3{{(*n)[0], (*n)[1], n->size() > 2 ? (*n)[2] : z}};
}

ModelNode translate(Evaluator& e, const Statement& s, const Arguments& a)
{
    Transform t;
    if (const auto v = vector_2_or_3(a["v"], 0.0); v && is_finite(*v))
        for (int i = 0; i < 3; ++i) t.m[i][3] = (*v)[i];
    else
        warn(e, s,
             "Unable to convert translate(" + shown(e, a["v"]) +
                 ") parameter to a vec3 or vec2 of numbers");
    return transform_node(e, s, t);
}

ModelNode scale(Evaluator& e, const Statement& s, const Arguments& a)
{
    Vec3 factors{{1, 1, 1}};
    if (const auto v = vector_2_or_3(a["v"], 1.0))
        factors = *v;
    else if (a["v"].is_number())
        factors = Vec3{{a["v"].as_number(), a["v"].as_number(), a["v"].as_number()}};
    else
        warn(e, s,
             "Unable to convert scale(" + shown(e, a["v"]) +
                 ") parameter to a number, a vec3 or vec2 of numbers or a number");
    Transform t;
    for (int i = 0; i < 3; ++i) t.m[i][i] = factors[i];
    return transform_node(e, s, t);
}

Transform rotation_about(double angle, const Vec3& axis)
{
    // Of length zero or endless: no rotation.
    const double length = norm(axis);
    if (!(length > 0.0) || !std::isfinite(length)) return {};
    return rotation(angle, axis);
}

// Degrees about x, y and z; false if one of them is no finite number.
bool euler_angles(const Value& angle, Vec3& degrees)
{
    const auto items = angle.items();
    bool good = items.size() <= 3;
    for (std::size_t i = 0; i < std::min<std::size_t>(items.size(), 3); ++i) {
        if (items[i].is_number() && std::isfinite(items[i].as_number()))
            degrees[i] = items[i].as_number();
        else
            good = false;
    }
    return good;
}

ModelNode rotate(Evaluator& e, const Statement& s, const Arguments& a)
{
    const Value &angle = a["a"], &about = a["v"];
    const bool no_axis = about.is_undef();
    if (angle.is_list()) {
        Vec3 degrees{};
        const bool good = euler_angles(angle, degrees);
        if (!good)
            warn(e, s,
                 "Problem converting rotate(a=" + shown(e, angle) +
                     (no_axis ? "" : ", v=" + shown(e, about)) + ") parameter");
        else if (!no_axis)
            warn(e, s,
                 "When parameter a is supplied as vector, v is ignored rotate(a=" +
                     shown(e, angle) + ", v=" + shown(e, about) + ")");
        return transform_node(e, s, rotation(degrees));
    }
    const double degrees = number(angle).value_or(0.0);
    const bool angle_good = angle.is_number() && std::isfinite(degrees);
    const auto axis = vector_2_or_3(about, 0.0);
    const bool axis_good = no_axis || (axis && is_finite(*axis));
    if (!angle_good && !axis_good)
        warn(e, s,
             "Problem converting rotate(a=" + shown(e, angle) + ", v=" + shown(e, about) +
                 ") parameter");
    else if (!angle_good)
        warn(e, s, "Problem converting rotate(a=" + shown(e, angle) + ") parameter");
    else if (!axis_good)
        warn(e, s, "Problem converting rotate(..., v=" + shown(e, about) + ") parameter");
    if (!angle_good) return transform_node(e, s, {});
    return transform_node(e, s, axis ? rotation_about(degrees, *axis) : rotation_z(degrees));
}

ModelNode mirror(Evaluator& e, const Statement& s, const Arguments& a)
{
    Transform t;
    auto v = vector_2_or_3(a["v"], 0.0);
    if (!v) {
        warn(e, s,
             "Unable to convert mirror(" + shown(e, a["v"]) +
                 ") parameter to a vec3 or vec2 of numbers");
        v = Vec3{{1, 0, 0}};
    }
    if (is_finite(*v) && norm(*v) > 0.0) t = genus::mirror(*v);
    return transform_node(e, s, t);
}

ModelNode multiply_matrix(Evaluator& e, const Statement& s, const Arguments& a)
{
    Transform t;
    if (a["m"].is_list()) {
        const auto rows = a["m"].items();
        for (std::size_t r = 0; r < std::min<std::size_t>(rows.size(), 4); ++r) {
            if (!rows[r].is_list()) continue;
            const auto cells = rows[r].items();
            for (std::size_t c = 0; c < std::min<std::size_t>(cells.size(), 4); ++c)
                if (cells[c].is_number()) t.m[r][c] = cells[c].as_number();
        }
        const double w = t.m[3][3];
        if (w != 1.0)
            for (auto& row : t.m)
                for (double& cell : row) cell /= w;
    }
    return transform_node(e, s, t);
}

std::string one_decimal(double x)
{
    char buffer[400];
    const auto end =
        std::to_chars(buffer, buffer + sizeof buffer, x, std::chars_format::fixed, 1).ptr;
    return std::string(buffer, end);
}

ModelNode color(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("color", s);
    std::array<double, 4> rgba{-1, -1, -1, 1};
    const Value& c = a["c"];
    if (c.is_list()) {
        const auto items = c.items();
        rgba.fill(1.0);
        for (std::size_t i = 0; i < std::min<std::size_t>(items.size(), 4); ++i) {
            rgba[i] = number(items[i]).value_or(0.0);
            if (!(rgba[i] <= 1.0))
                warn(e, s,
                     "color() expects numbers between 0.0 and 1.0. Value of " +
                         one_decimal(rgba[i]) + " is out of range");
        }
    } else if (c.is_string()) {
        const auto found = parse_color(c.as_string());
        if (found)
            rgba = *found;
        else
            e.diagnostics().warn_with_hint(s.place, "Unable to parse color " + shown(e, c),
                                           "Please see https://en.wikipedia.org/wiki/Web_colors");
    }
    if (a["alpha"].is_number()) rgba[3] = a["alpha"].as_number();
    // The text language keeps colours in single precision.
    for (double& part : rgba) part = static_cast<double>(static_cast<float>(part));
    node.parameters.emplace_back("", to_model(rgba));
    return node;
}

ModelNode resize(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("resize", s);
    std::array<double, 3> size{}, automatic{};
    if (a["newsize"].is_list()) {
        const auto items = a["newsize"].items();
        for (std::size_t i = 0; i < std::min<std::size_t>(items.size(), 3); ++i)
            size[i] = number(items[i]).value_or(0.0);
    }
    if (a["auto"].is_list()) {
        const auto items = a["auto"].items();
        for (std::size_t i = 0; i < std::min<std::size_t>(items.size(), 3); ++i)
            automatic[i] = is_true(items[i]) ? 1.0 : 0.0;
    } else if (is_true(a["auto"])) {
        automatic.fill(1.0);
    }
    node.parameters = {{"newsize", to_model(size)},
                       {"auto", to_model(automatic)},
                       {"convexity", number(a["convexity"]).value_or(0.0)}};
    return node;
}

// Operators.

template <const char* name>
ModelNode plain(Evaluator& e, const Statement& s, const Arguments&)
{
    return e.make_node(name, s);
}
constexpr char kUnion[] = "union", kDifference[] = "difference", kIntersection[] = "intersection",
               kHull[] = "hull";

ModelNode render(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("render", s);
    node.parameters.emplace_back("convexity", number(a["convexity"]).value_or(1.0));
    return node;
}

ModelNode minkowski(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("minkowski", s);
    node.parameters.emplace_back("convexity", number(a["convexity"]).value_or(0.0));
    return node;
}

// Plane shapes and what makes solids of them.

ModelNode square(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("square", s);
    std::vector<double> size{1, 1};
    const Value& given = a["size"];
    if (given.is_number())
        size.assign(2, given.as_number());
    else if (const auto v = numbers(given, 2, 2))
        size = *v;
    else if (!given.is_undef())
        warn(e, s,
             "Unable to convert square(size=" + shown(e, given) +
                 ", ...) parameter to a number or a vec2 of numbers");
    node.parameters = {{"size", to_model(size)}, {"center", is_true(a["center"])}};
    return node;
}

ModelNode circle(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("circle", s);
    const double r = radius(e, s, a, "d", "r").value_or(1.0);
    const Facets f = facets(e);
    add_facets(node, f);
    node.parameters.emplace_back("r", r);
    node.fragments = f.round_fragments(r);
    return node;
}

ModelNode polygon(Evaluator& e, const Statement& s, const Arguments& a)
{
    const Names& names = e.program().names;
    ModelNode node = e.make_node("polygon", s);
    node.parameters = {{"points", to_model(a["points"], names)},
                       {"paths", to_model(a["paths"], names)},
                       {"convexity", number(a["convexity"]).value_or(1.0)}};
    return node;
}

std::string text_or(const Value& v, const char* otherwise)
{
    return v.is_string() ? std::string(v.as_string()) : std::string(otherwise);
}

// The script of the first letter whose script is known, by the ranges of Unicode; empty if none.
std::string script_of(std::string_view text)
{
    struct Range {
        std::uint32_t first, last;
        const char* script;
    };
    static constexpr Range ranges[] = {
        {0x41, 0x5a, "Latn"},     {0x61, 0x7a, "Latn"},     {0xc0, 0x24f, "Latn"},
        {0x370, 0x3ff, "Grek"},   {0x400, 0x52f, "Cyrl"},   {0x531, 0x58f, "Armn"},
        {0x591, 0x5f4, "Hebr"},   {0x600, 0x6ff, "Arab"},   {0x900, 0x97f, "Deva"},
        {0xe01, 0xe5b, "Thai"},   {0x10a0, 0x10ff, "Geor"}, {0x1e00, 0x1eff, "Latn"},
        {0x3041, 0x309f, "Hira"}, {0x30a0, 0x30ff, "Kana"}, {0x4e00, 0x9fff, "Hani"},
        {0xac00, 0xd7a3, "Hang"}};
    std::string found;
    for_each_character(text, [&](std::string_view c) {
        const std::uint32_t code = decode_character(c);
        for (const Range& range : ranges)
            if (found.empty() && code >= range.first && code <= range.last) found = range.script;
    });
    return found;
}

// A script is named by four letters, the first of them a capital.
std::string script_tag(std::string_view name)
{
    std::string tag(name.substr(0, 4));
    for (std::size_t i = 0; i < tag.size(); ++i)
        tag[i] = static_cast<char>(i == 0 ? std::toupper(static_cast<unsigned char>(tag[i]))
                                          : std::tolower(static_cast<unsigned char>(tag[i])));
    tag.resize(4, ' ');
    return tag;
}

ModelNode text(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("text", s);
    const std::string content = text_or(a["text"], "");
    const std::string script =
        a["script"].is_string() ? script_tag(a["script"].as_string()) : script_of(content);
    const bool leftward = script == "Hebr" || script == "Arab";
    std::string direction = text_or(a["direction"], "");
    if (direction != "ltr" && direction != "rtl" && direction != "ttb" && direction != "btt")
        direction = leftward ? "rtl" : "ltr";
    node.parameters = {{"text", content},
                       {"size", number(a["size"]).value_or(10.0)},
                       {"spacing", number(a["spacing"]).value_or(1.0)},
                       {"font", text_or(a["font"], "")},
                       {"direction", direction},
                       {"language", text_or(a["language"], "en")}};
    if (!script.empty()) node.parameters.emplace_back("script", script);
    node.parameters.emplace_back("halign", text_or(a["halign"], "left"));
    node.parameters.emplace_back("valign", text_or(a["valign"], "baseline"));
    const Facets f = facets(e);
    add_facets(node, f);
    node.fragments = f.round_fragments(number(a["size"]).value_or(10.0));
    return node;
}

ModelNode offset(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("offset", s);
    if (const auto r = number(a["r"]); r || !a["delta"].is_number()) {
        node.parameters.emplace_back("r", r.value_or(1.0));
    } else {
        node.parameters.emplace_back("delta", a["delta"].as_number());
        node.parameters.emplace_back("chamfer", is_true(a["chamfer"]));
    }
    add_facets(node, facets(e));
    return node;
}

// The file that a node names, looked for from the folder of the text that asks, as the folder of
// the model sees it. The node keeps how to open it.
std::string existing_file(Evaluator& e, const Statement& s, const Value& name, ModelNode& node)
{
    if (!name.is_string() || name.as_string().empty())
        e.fail(s.place, "'" + e.program().names[s.name] + "' needs the name of a file");
    const Sources& sources = e.program().sources;
    const fs::path wanted(name.as_string());
    const fs::path folder = fs::path(*sources[s.place.file].path).parent_path();
    const fs::path path = wanted.is_absolute() ? wanted : folder / wanted;
    std::error_code error;
    if (!fs::is_regular_file(path, error))
        e.fail(s.place, "file '" + std::string(name.as_string()) + "' not found");
    node.path = path.string();
    const fs::path model = fs::path(*sources[e.program().files[0]->source].path).parent_path();
    const fs::path seen = fs::proximate(path, model.empty() ? fs::path(".") : model, error);
    return (error ? path : seen).lexically_normal().string();
}

// An extrusion may name a drawing in place of children: the start of its parameters then.
void take_file(Evaluator& e, const Statement& s, const Arguments& a, ModelNode& node)
{
    if (!a["file"].is_string()) return;
    e.diagnostics().deprecated_anywhere(
        s.place, "Support for reading files in " + node.name +
                     " will be removed in future releases. Use a child import() instead.");
    std::array<double, 2> origin{};
    if (const auto v = numbers(a["origin"], 2, 2)) origin = {(*v)[0], (*v)[1]};
    node.parameters = {{"file", existing_file(e, s, a["file"], node)},
                       {"layer", text_or(a["layer"], "")},
                       {"origin", to_model(origin)}};
}

ModelNode linear_extrude(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("linear_extrude", s);
    const Value& first = a["file"];
    const double height =
        number(a["height"]).value_or(first.is_number() ? first.as_number() : 100.0);
    std::array<double, 2> factors{1, 1};
    if (const auto v = numbers(a["scale"], 2, 2))
        factors = {(*v)[0], (*v)[1]};
    else if (a["scale"].is_number())
        factors.fill(a["scale"].as_number());
    for (double& factor : factors) factor = std::max(factor, 0.0);
    const double wanted = number(a["convexity"]).value_or(1.0);
    const double convexity = std::isfinite(wanted) ? std::max(wanted, 1.0) : 1.0;
    take_file(e, s, a, node);
    node.parameters.emplace_back("height", std::max(height, 0.0));
    node.parameters.emplace_back("center", is_true(a["center"]));
    node.parameters.emplace_back("convexity", std::trunc(convexity));
    const Facets f = facets(e);
    double twist = number(a["twist"]).value_or(0.0);
    if (!std::isfinite(twist)) twist = 0.0;
    if (twist != 0.0) node.parameters.emplace_back("twist", twist);
    const double slices = std::trunc(number(a["slices"]).value_or(0.0));
    if (slices > 0) node.parameters.emplace_back("slices", slices);
    node.parameters.emplace_back("scale", to_model(factors));
    if (!(slices > 0)) add_facets(node, f);
    return node;
}

ModelNode rotate_extrude(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("rotate_extrude", s);
    double angle = number(a["angle"]).value_or(360.0);
    if (!(angle > -360.0 && angle <= 360.0)) angle = 360.0;
    const double convexity = number(a["convexity"]).value_or(0.0);
    take_file(e, s, a, node);
    if (!node.path.empty()) node.parameters.emplace_back("scale", number(a["scale"]).value_or(1.0));
    node.parameters.emplace_back("angle", angle);
    node.parameters.emplace_back("convexity", convexity <= 0 ? 2.0 : convexity);
    const Facets f = facets(e);
    add_facets(node, f);
    return node;
}

ModelNode projection(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("projection", s);
    node.parameters = {{"cut", is_true(a["cut"])},
                       {"convexity", number(a["convexity"]).value_or(0.0)}};
    return node;
}

ModelNode import(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("import", s);
    const std::string file =
        existing_file(e, s, a["file"].is_undef() ? a["filename"] : a["file"], node);
    const Value& layer = a["layer"].is_undef() ? a["layername"] : a["layer"];
    std::array<double, 2> origin{};
    if (const auto v = numbers(a["origin"], 2, 2)) origin = {(*v)[0], (*v)[1]};
    node.parameters = {{"file", file}, {"layer", text_or(layer, "")}, {"origin", to_model(origin)}};
    std::string extension = fs::path(file).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension == ".svg") {
        node.parameters.emplace_back("center", is_true(a["center"]));
        node.parameters.emplace_back("dpi", number(a["dpi"]).value_or(72.0));
    }
    node.parameters.emplace_back("scale", number(a["scale"]).value_or(1.0));
    node.parameters.emplace_back("convexity", number(a["convexity"]).value_or(1.0));
    add_facets(node, facets(e));
    return node;
}

// Of a file, or of the patches below the node.
ModelNode patches(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("patches", s);
    if (!a["file"].is_undef())
        node.parameters.emplace_back("file", existing_file(e, s, a["file"], node));
    return node;
}

ModelNode surface(Evaluator& e, const Statement& s, const Arguments& a)
{
    ModelNode node = e.make_node("surface", s);
    node.parameters = {{"file", existing_file(e, s, a["file"], node)},
                       {"center", is_true(a["center"])},
                       {"invert", is_true(a["invert"])}};
    return node;
}

const std::vector<NodeMaker>& makers()
{
    static const std::vector<NodeMaker> list = {
        {"cube", {"size", "center"}, 2, cube, true},
        {"sphere", {"r", "d"}, 1, sphere, true},
        {"cylinder", {"h", "r1", "r2", "center", "r", "d", "d1", "d2"}, 4, cylinder, true},
        {"polyhedron", {"points", "faces", "convexity", "triangles"}, 3, polyhedron, true},
        {"torus", {"R", "r"}, 2, own_solid<kTorus>, true},
        {"ellipsoid", {"rx", "ry", "rz"}, 3, own_solid<kEllipsoid>, true},
        {"cone", {"h", "r", "center"}, 3, own_solid<kCone>, true},
        {"quadric", {"coefficients", "bounds"}, 2, own_solid<kQuadric>, true},
        {"half_space", {"normal", "offset"}, 2, own_solid<kHalfSpace>, true},
        {"implicit", {"f", "bounds"}, 2, own_solid<kImplicit>, true},
        {"bezier_curve", {"points", "weights"}, 2, own_curve<kBezierCurve>, true},
        {"bspline",
         {"points", "degree", "closed", "knots", "weights"},
         3,
         own_curve<kBspline>,
         true},
        {"bezier_patch", {"points", "weights"}, 2, own_solid<kBezierPatch>, true},
        {"triangle_patch", {"points", "weights"}, 2, own_solid<kTrianglePatch>, true},
        {"patches", {"file"}, 1, patches},
        {"ffd", {"degree", "moves", "points", "origin", "axes"}, 2, own_solid<kFfd>},
        {"move_points",
         {"from", "to", "degree", "keep_border", "regularisation", "origin", "axes"},
         3,
         own_solid<kMovePoints>},
        {"subdivide", {"levels", "scheme", "limit"}, 2, own_solid<kSubdivide>},
        {"translate", {"v"}, 1, translate},
        {"rotate", {"a", "v"}, 2, rotate},
        {"scale", {"v"}, 1, scale},
        {"mirror", {"v"}, 1, mirror},
        {"multmatrix", {"m"}, 1, multiply_matrix},
        {"color", {"c", "alpha"}, 2, color},
        {"resize", {"newsize", "auto", "convexity"}, 3, resize},
        {"union", {}, 0, plain<kUnion>},
        {"difference", {}, 0, plain<kDifference>},
        {"intersection", {}, 0, plain<kIntersection>},
        {"render", {"convexity"}, 1, render},
        {"hull", {}, 0, plain<kHull>},
        {"minkowski", {"convexity"}, 1, minkowski},
        {"square", {"size", "center"}, 2, square, true},
        {"circle", {"r", "d"}, 1, circle, true},
        {"polygon", {"points", "paths", "convexity"}, 3, polygon, true},
        {"text",
         {"text", "size", "font", "direction", "language", "script", "halign", "valign", "spacing"},
         3,
         text,
         true},
        {"offset", {"r", "delta", "chamfer"}, 1, offset},
        {"linear_extrude",
         {"file", "layer", "height", "origin", "scale", "center", "twist", "slices", "convexity"},
         8,
         linear_extrude},
        {"rotate_extrude",
         {"file", "layer", "origin", "scale", "convexity", "angle"},
         4,
         rotate_extrude},
        {"projection", {"cut", "convexity"}, 2, projection},
        {"import",
         {"file", "layer", "convexity", "origin", "scale", "width", "height", "filename",
          "layername", "center", "dpi", "id"},
         5,
         import,
         true},
        {"surface", {"file", "center", "convexity", "invert"}, 3, surface, true},
    };
    return list;
}

}  // namespace

const NodeMaker& node_maker(std::uint32_t number)
{
    return makers()[number];
}

std::optional<std::uint32_t> find_builtin_module(std::string_view name)
{
    using M = BuiltinModule;
    static const auto numbers = [] {
        std::unordered_map<std::string_view, std::uint32_t> map;
        const auto add = [&](std::string_view text, M m) {
            map.emplace(text, static_cast<std::uint32_t>(m));
        };
        add("for", M::For);
        add("intersection_for", M::IntersectionFor);
        add("let", M::Let);
        add("assign", M::Assign);
        add("echo", M::Echo);
        add("assert", M::Assert);
        add("children", M::Children);
        add("child", M::Child);
        add("group", M::Group);
        std::uint32_t next = static_cast<std::uint32_t>(M::First);
        for (const NodeMaker& maker : makers()) map.emplace(maker.name, next++);
        return map;
    }();
    const auto at = numbers.find(name);
    return at == numbers.end() ? std::nullopt : std::optional(at->second);
}

}  // namespace genus::language
