#include "genus/language/builtins_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "genus/base/transform.h"
#include "genus/io/height_map.h"
#include "genus/io/input_file.h"
#include "genus/io/region_file.h"
#include "genus/io/text.h"
#include "genus/io/text_outline.h"
#include "genus/language/evaluate.h"
#include "genus/language/node_reader.h"

namespace genus::language {

namespace {

constexpr double kFileShare = 0.5;  // of a tolerance, for curves of plane shapes

double number_or(const ModelValue& value, double otherwise)
{
    const double* n = value.number();
    return n && std::isfinite(*n) ? *n : otherwise;
}

std::string text_of(const ModelValue& value)
{
    const std::string* text = value.text();
    return text ? *text : std::string();
}

// Sides of circles as the node asks for them; those in SVG files have their own number in the text
// language.
void set_curves(const ModelNode& node, const NodeReader& read, RegionReadOptions& options)
{
    const Facets facets = read.facets();
    const bool to_tolerance = node.tolerance > 0.0 && !(facets.fn > 0.0);
    if (to_tolerance) {
        const double tolerance = kFileShare * node.tolerance;
        options.tolerance = tolerance;
        options.sides = [tolerance](double r) {
            return r > 0.0 ? fragments_within(tolerance, r) : 3;
        };
    } else if (region_format_of_extension(node.path) == RegionFormat::dxf) {
        options.sides = [facets](double r) { return facets.fragments(r); };
    }
}

// Arguments of dxf_dim and dxf_cross, all by name.
struct DrawingQuery {
    std::string file = "", layer = "", name = "";
    Vec2 origin{};
    double scale = 1.0;
};

std::string function_name(Evaluator& e, const Call& call)
{
    return std::string(e.program().names[call.name]);
}

DrawingQuery query_of(Evaluator& e, const Call& call, std::span<const Value> arguments)
{
    DrawingQuery query;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const Names::Id id = call.arguments[i].name;
        const std::string name =
            id == Argument::kNoName ? std::string() : std::string(e.program().names[id]);
        const Value& value = arguments[i];
        if (name == "file" && value.is_string()) {
            query.file = value.as_string();
        } else if (name == "layer" && value.is_string()) {
            query.layer = value.as_string();
        } else if (name == "name" && value.is_string()) {
            query.name = value.as_string();
        } else if (name == "scale" && value.is_number()) {
            query.scale = value.as_number();
        } else if (name == "origin" && value.is_list() && value.items().size() == 2 &&
                   value.items()[0].is_number() && value.items()[1].is_number()) {
            query.origin = {{value.items()[0].as_number(), value.items()[1].as_number()}};
        } else {
            e.diagnostics().warn(
                call.place, function_name(e, call) + "(..., " + name + "=...) is not supported");
        }
    }
    return query;
}

// Calls `body` with the text of the drawing; without a file that can be opened there is a warning.
template <class Body>
Value with_drawing(Evaluator& e, const Call& call, const DrawingQuery& query, const Body& body)
{
    namespace fs = std::filesystem;
    const fs::path wanted(query.file);
    const fs::path folder = fs::path(*e.program().sources[call.place.file].path).parent_path();
    const fs::path path = wanted.is_absolute() ? wanted : folder / wanted;
    std::error_code error;
    if (query.file.empty() || !fs::is_regular_file(path, error)) {
        e.diagnostics().warn(call.place, "Can't open DXF file '" + query.file + "'!");
        return Value();
    }
    try {
        const io::InputFile file(path.string());
        return body(io::as_text(file.bytes()), path.string());
    } catch (const FileError& problem) {
        e.fail(call.place, function_name(e, call) + "(): " + problem.what());
    }
}

}  // namespace

bool is_plane_import(const ModelNode& node)
{
    return node.name == "import" && region_format_of_extension(node.path).has_value();
}

PlaneShape imported_shape(const ModelNode& node)
{
    const NodeReader read(node);
    RegionReadOptions options;
    options.layer = text_of(node.parameter("layer"));
    if (node.parameter("origin").list()) options.origin = read.vec2("origin");
    const ModelValue& scale = node.parameter("scale");
    if (scale.list() && !scale.list()->empty())
        options.scale = number_or(scale.list()->front(), 1.0);
    else
        options.scale = number_or(scale, 1.0);
    options.center = node.parameter("center").truth() && node.name == "import";
    options.dpi = std::max(number_or(node.parameter("dpi"), 72.0), 0.001);
    set_curves(node, read, options);
    try {
        return {read_region(node.path, options), options.tolerance.value_or(0.0)};
    } catch (const FileError& problem) {
        read.fail(node.name + "(): " + problem.what());
    } catch (const InvalidInput& problem) {
        read.fail(node.name + "(): " + problem.what());
    }
}

Solid surface_solid(const ModelNode& node)
{
    const NodeReader read(node);
    try {
        const HeightMap map = read_height_map(node.path, read.truth("invert"));
        PolygonMesh mesh = height_map_mesh(map, read.truth("center"));
        return mesh.n_faces() == 0 ? Solid() : polyhedron(std::move(mesh));
    } catch (const FileError& problem) {
        read.fail(std::string("surface(): ") + problem.what());
    }
}

PlaneShape text_shape(const ModelNode& node, std::vector<Message>& messages)
{
    const NodeReader read(node);
    TextOptions options;
    options.text = text_of(node.parameter("text"));
    options.size = read.number("size");
    options.spacing = read.number("spacing");
    options.font = text_of(node.parameter("font"));
    options.direction = text_of(node.parameter("direction"));
    options.language = text_of(node.parameter("language"));
    options.script = text_of(node.parameter("script"));
    options.halign = text_of(node.parameter("halign"));
    options.valign = text_of(node.parameter("valign"));
    // The curves of letters are short: an eighth of a circle's sides follows them well enough.
    const Facets facets = read.facets();
    double deviation = 0.0;
    int sides = facets.round_fragments(options.size);
    if (sides == 0) {
        // No curve of a letter bends more than a circle of its height over a quarter turn.
        deviation = kFileShare * node.tolerance;
        sides = fragments_within(deviation, std::max(std::fabs(options.size), deviation)) * 4;
    }
    options.curve_steps = std::clamp(sides / 8 + 1, 2, 10'000);
    try {
        TextOutline made = text_outline(options);
        if (made.is_substitute)
            messages.push_back({Message::Kind::Warning, *node.file, node.line, node.column,
                                "WARNING: Font '" + options.font + "' is not installed, using '" +
                                    made.font + "' in file " + *node.file + ", line " +
                                    std::to_string(node.line)});
        return {std::move(made.region), deviation};
    } catch (const InvalidInput& problem) {
        read.fail(problem.what());
    }
}

Value dxf_dim(Evaluator& e, const Call& call, std::span<const Value> arguments)
{
    const DrawingQuery query = query_of(e, call, arguments);
    return with_drawing(e, call, query, [&](std::string_view text, const std::string& path) {
        const auto found =
            dxf_dimension(text, path, query.layer, query.name, query.origin, query.scale);
        if (found) return Value(*found);
        e.diagnostics().warn(call.place, "Can't find dimension '" + query.name + "' in '" +
                                             query.file + "', layer '" + query.layer + "'!");
        return Value();
    });
}

Value dxf_cross(Evaluator& e, const Call& call, std::span<const Value> arguments)
{
    const DrawingQuery query = query_of(e, call, arguments);
    return with_drawing(e, call, query, [&](std::string_view text, const std::string& path) {
        const auto found = dxf_crossing(text, path, query.layer, query.origin, query.scale);
        if (found) return Value::list(std::vector<Value>{(*found)[0], (*found)[1]});
        e.diagnostics().warn(
            call.place, "Can't find cross in '" + query.file + "', layer '" + query.layer + "'!");
        return Value();
    });
}

}  // namespace genus::language
