#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/number_format.h"
#include "genus/io/scene_mesh.h"
#include "genus/io/text.h"
#include "genus/io/units.h"
#include "genus/io/xml.h"
#include "genus/io/xml_formats.h"
#include "genus/io/zip.h"

namespace genus::io {

namespace {

constexpr int kMaxComponentDepth = 32;
constexpr std::size_t kMostPlacements = std::size_t{1} << 20;
constexpr std::string_view kUsualModel = "3D/3dmodel.model";
constexpr std::string_view kRelations = "_rels/.rels";

using Attributes = std::span<const XmlAttribute>;

// A colour: the place in a group of them, which may be a group of something else.
struct Property {
    std::int32_t group = -1;
    std::int32_t index = 0;
};

struct Component {
    std::string part;  // empty for the same part
    std::int32_t object = 0;
    Transform map;
};

struct Object {
    std::vector<Vec3> points;
    std::vector<Triangle> faces;
    std::vector<Property> properties;  // of the faces
    Property standard;                 // of faces without one of their own
    std::vector<Component> components;
};

// What one .model file of the archive holds.
struct Part {
    double unit = 1.0;
    std::map<std::int32_t, Object> objects;
    std::map<std::int32_t, std::vector<Rgba>> colors;
    std::vector<Component> build;
};

std::string_view need(Attributes attributes, const char* name)
{
    const XmlAttribute* found = find_attribute(attributes, name);
    if (found == nullptr) throw std::string("the attribute '") + name + "' is missing";
    return found->value;
}

std::optional<std::string_view> maybe(Attributes attributes, const char* name)
{
    const XmlAttribute* found = find_attribute(attributes, name);
    return found ? std::optional(found->value) : std::nullopt;
}

// #RRGGBB or #RRGGBBAA.
Rgba parse_color(std::string_view text)
{
    std::uint8_t channels[4] = {0, 0, 0, 255};
    const bool valid = (text.size() == 7 || text.size() == 9) && text[0] == '#';
    for (std::size_t i = 0; valid && 2 * i + 1 < text.size(); ++i) {
        const char* digits = text.data() + 1 + 2 * i;
        const auto result = std::from_chars(digits, digits + 2, channels[i], 16);
        if (result.ec != std::errc{} || result.ptr != digits + 2)
            throw shown_word(text.data(), text.data() + text.size()) + " is not a colour";
    }
    if (!valid) throw shown_word(text.data(), text.data() + text.size()) + " is not a colour";
    return {channels[0], channels[1], channels[2], channels[3]};
}

// Twelve numbers, the images of the axes and of the origin one after the other.
Transform parse_map(std::string_view text)
{
    Transform map;
    for (std::size_t i = 0; i < 12; ++i) {
        while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
        const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
        map.m[i % 3][i / 3] = xml_number(text.substr(0, end), "transform");
        text.remove_prefix(end);
    }
    if (!std::all_of(text.begin(), text.end(), is_space))
        throw std::string("transform: more than twelve numbers");
    return map;
}

class PartHandler : public XmlHandler {
public:
    explicit PartHandler(Part& part) : part_(part) {}

    void start(std::string_view element, Attributes attributes) override
    {
        if (element == "model")
            start_model(attributes);
        else if (element == "basematerials" || element == "colorgroup")
            colors_ = &part_.colors[xml_index(need(attributes, "id"), "id")];
        else if (element == "base" && colors_ != nullptr)
            colors_->push_back(parse_color(need(attributes, "displaycolor")));
        else if (element == "color" && colors_ != nullptr)
            colors_->push_back(parse_color(need(attributes, "color")));
        else if (element == "object")
            start_object(attributes);
        else if (element == "mesh")
            in_mesh_ = true;
        else if (element == "vertex" && in_mesh_)
            add_vertex(attributes);
        else if (element == "triangle" && in_mesh_)
            add_triangle(attributes);
        else if (element == "component" && object_ != nullptr)
            object_->components.push_back(component(attributes));
        else if (element == "item")
            part_.build.push_back(component(attributes));
    }

    void end(std::string_view element) override
    {
        if (element == "basematerials" || element == "colorgroup")
            colors_ = nullptr;
        else if (element == "mesh")
            in_mesh_ = false;
        else if (element == "object")
            end_object();
    }

    void text(std::string_view) override {}

private:
    void start_model(Attributes attributes)
    {
        if (const auto unit = maybe(attributes, "unit")) part_.unit = unit_length(k3mfUnits, *unit);
        std::string_view required = maybe(attributes, "requiredextensions").value_or("");
        while (!required.empty()) {
            const std::size_t end = std::min(required.find(' '), required.size());
            if (end > 0) check_extension(required.substr(0, end), attributes);
            required.remove_prefix(std::min(end + 1, required.size()));
        }
    }

    // Extensions that do not change which triangles there are.
    static void check_extension(std::string_view prefix, Attributes attributes)
    {
        for (const XmlAttribute& attribute : attributes) {
            if (!attribute.name.starts_with("xmlns:") || attribute.name.substr(6) != prefix)
                continue;
            for (const std::string_view known :
                 {"/material/", "/production/", "/slice/", "/trianglesets/"})
                if (attribute.value.find(known) != std::string_view::npos) return;
            throw "the 3MF extension " + std::string(attribute.value.substr(0, 200)) +
                " is not read";
        }
        throw std::string("a required 3MF extension is not named");
    }

    void start_object(Attributes attributes)
    {
        const std::int32_t id = xml_index(need(attributes, "id"), "id");
        const auto [entry, is_new] = part_.objects.try_emplace(id);
        if (!is_new) throw "object " + std::to_string(id) + " comes twice";
        object_ = &entry->second;
        if (const auto group = maybe(attributes, "pid"))
            object_->standard = {xml_index(*group, "pid"),
                                 xml_index(maybe(attributes, "pindex").value_or("0"), "pindex")};
    }

    void end_object()
    {
        if (object_ == nullptr) return;
        const auto n = static_cast<std::int64_t>(object_->points.size());
        for (const Triangle& face : object_->faces)
            for (const std::int32_t v : face)
                if (v >= n) throw "there is no vertex " + std::to_string(v);
        object_ = nullptr;
    }

    Object& mesh_object()
    {
        if (object_ == nullptr) throw std::string("a mesh outside of an object");
        return *object_;
    }

    void add_vertex(Attributes attributes)
    {
        std::vector<Vec3>& points = mesh_object().points;
        points.push_back(
            {{xml_number(need(attributes, "x"), "x"), xml_number(need(attributes, "y"), "y"),
              xml_number(need(attributes, "z"), "z")}});
    }

    void add_triangle(Attributes attributes)
    {
        Object& object = mesh_object();
        object.faces.push_back({xml_index(need(attributes, "v1"), "v1"),
                                xml_index(need(attributes, "v2"), "v2"),
                                xml_index(need(attributes, "v3"), "v3")});
        Property property = object.standard;
        if (const auto group = maybe(attributes, "pid")) property.group = xml_index(*group, "pid");
        if (const auto index = maybe(attributes, "p1")) property.index = xml_index(*index, "p1");
        object.properties.push_back(property);
    }

    static Component component(Attributes attributes)
    {
        Component found;
        found.object = xml_index(need(attributes, "objectid"), "objectid");
        if (const auto path = maybe(attributes, "path")) found.part = *path;
        if (const auto map = maybe(attributes, "transform")) found.map = parse_map(*map);
        return found;
    }

    Part& part_;
    Object* object_ = nullptr;
    std::vector<Rgba>* colors_ = nullptr;
    bool in_mesh_ = false;
};

// The target of the relation that says where the model starts.
class RelationHandler : public XmlHandler {
public:
    void start(std::string_view element, Attributes attributes) override
    {
        if (element != "Relationship") return;
        if (maybe(attributes, "Type").value_or("").ends_with("/3dmodel"))
            target = std::string(need(attributes, "Target"));
    }
    void end(std::string_view) override {}
    void text(std::string_view) override {}

    std::string target;
};

class Reader {
public:
    Reader(std::span<const std::byte> content, const std::string& name)
        : archive_(content, name), name_(name), mesh_(content.size(), false)
    {
    }

    RawMesh read()
    {
        const std::string root = start_part();
        const Part& part = part_named(root);
        for (const Component& item : part.build) place(item, root, {}, 0);
        RawMesh raw = std::move(mesh_).take();
        raw.unit = part.unit;
        return raw;
    }

private:
    std::string start_part()
    {
        RelationHandler handler;
        if (const ZipArchive::Entry* entry = archive_.find(kRelations)) parse(*entry, handler);
        return handler.target.empty() ? std::string(kUsualModel) : handler.target;
    }

    void parse(const ZipArchive::Entry& entry, XmlHandler& handler)
    {
        try {
            XmlParser parser(handler);
            archive_.unpack(entry, [&](std::span<const char> piece) { parser.feed(piece); });
            parser.finish();
        } catch (const XmlFault& fault) {
            throw FileError(
                name_, entry.name + ", line " + std::to_string(fault.line) + ": " + fault.problem);
        }
    }

    const Part& part_named(const std::string& part_name)
    {
        const ZipArchive::Entry* entry = archive_.find(part_name);
        if (entry == nullptr)
            throw FileError(name_, "the 3MF archive has no '" + part_name.substr(0, 200) + "'");
        const auto [found, is_new] = parts_.try_emplace(entry->name);
        if (is_new) {
            PartHandler handler(found->second);
            parse(*entry, handler);
        }
        return found->second;
    }

    // Puts an object into the mesh. One that contains itself goes deeper than any real one.
    void place(const Component& component, const std::string& here, const Transform& outer,
               int depth)
    {
        current_progress().check();
        if (depth > kMaxComponentDepth)
            throw FileError(name_, "objects contain each other too deeply or in a circle");
        if (++placements_ > kMostPlacements) fail_too_large();
        const std::string& part_name = component.part.empty() ? here : component.part;
        const Part& part = part_named(part_name);
        const auto object = part.objects.find(component.object);
        if (object == part.objects.end())
            throw FileError(name_, "there is no object " + std::to_string(component.object));
        const Transform map = outer * component.map;
        add_mesh(object->second, part, map);
        for (const Component& inner : object->second.components)
            place(inner, part_name, map, depth + 1);
    }

    [[noreturn]] void fail_too_large() const
    {
        throw FileError(name_, "the build repeats its objects too often");
    }

    void add_mesh(const Object& object, const Part& part, const Transform& map)
    {
        if (object.points.empty()) return;
        const std::vector<Vec3> points = mapped(map, object.points);
        for (const Vec3& p : points)
            if (!is_finite(p)) throw FileError(name_, "a transform leads to infinity");
        std::vector<std::int32_t> numbers;
        if (!mesh_.add_points(points, {}, numbers)) fail_too_large();
        const bool mirrored = determinant(map) < 0.0;
        for (std::size_t f = 0; f < object.faces.size(); ++f) {
            Triangle face = object.faces[f];
            for (std::int32_t& v : face) v = numbers[static_cast<std::size_t>(v)];
            if (mirrored) std::swap(face[1], face[2]);
            const std::optional<Rgba> color = color_of(object.properties[f], part);
            if (!(color ? mesh_.add_face(face, *color) : mesh_.add_face(face))) fail_too_large();
        }
    }

    // Groups of other things, textures for instance, have no colour.
    static std::optional<Rgba> color_of(Property property, const Part& part)
    {
        const auto group = part.colors.find(property.group);
        if (group == part.colors.end()) return std::nullopt;
        const auto index = static_cast<std::size_t>(property.index);
        return index < group->second.size() ? std::optional(group->second[index]) : std::nullopt;
    }

    ZipArchive archive_;
    const std::string& name_;
    SceneMesh mesh_;
    std::map<std::string, Part> parts_;
    std::size_t placements_ = 0;
};

// ---- writing ----

constexpr char kContentTypes[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">"
    "<Default Extension=\"rels\" "
    "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>"
    "<Default Extension=\"model\" "
    "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>\n";
constexpr char kRootRelations[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";

constexpr std::size_t kGrain = 8192;

char* put_attribute(char* p, std::string_view name, double value)
{
    p = put_text(put_text(p, name), "=\"");
    return put_text(put_number(p, value), "\"");
}
char* put_attribute(char* p, std::string_view name, std::int64_t value)
{
    p = put_text(put_text(p, name), "=\"");
    return put_text(put_integer(p, value), "\"");
}

// The different colours of the faces, and which of them each face has.
struct Palette {
    std::vector<Rgba> colors;
    std::vector<std::int32_t> index;

    explicit Palette(const std::vector<Rgba>& faces)
    {
        std::map<std::tuple<int, int, int, int>, std::int32_t> known;
        for (const Rgba& c : faces) {
            const auto number = static_cast<std::int32_t>(colors.size());
            const auto [entry, is_new] = known.try_emplace({c.r, c.g, c.b, c.a}, number);
            if (is_new) colors.push_back(c);
            index.push_back(entry->second);
        }
    }
};

void write_palette(Output& output, const Palette& palette)
{
    constexpr char hex[] = "0123456789ABCDEF";
    output.write(std::string_view("<basematerials id=\"1\">\n"));
    for (const Rgba& c : palette.colors) {
        std::string line = "<base name=\"color\" displaycolor=\"#";
        for (const std::uint8_t channel : {c.r, c.g, c.b, c.a}) {
            line.push_back(hex[channel >> 4]);
            line.push_back(hex[channel & 15]);
        }
        output.write(line + "\"/>\n");
    }
    output.write(std::string_view("</basematerials>\n"));
}

void write_model(Output& output, const MeshFile& file)
{
    const ColoredTriangles triangles = to_colored_triangles(file);
    const Palette palette(triangles.colors);
    const UnitScale unit(k3mfUnits, file.unit);
    output.write("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"" + unit.name +
                 "\" xml:lang=\"en-US\" "
                 "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
                 "<metadata name=\"Application\">genus</metadata>\n<resources>\n");
    if (!palette.colors.empty()) write_palette(output, palette);
    output.write(std::string_view("<object id=\"2\" type=\"model\""));
    if (!palette.colors.empty()) output.write(std::string_view(" pid=\"1\" pindex=\"0\""));
    output.write(std::string_view("><mesh>\n<vertices>\n"));
    const std::vector<Vec3>& vertices = file.mesh.vertices;
    write_records(output, vertices.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      char* p = block.room((3 * kNumberChars + 32) * (end - begin));
                      for (std::size_t v = begin; v < end; ++v) {
                          const Vec3 position = vertices[v] * unit.factor;
                          p = put_attribute(put_text(p, "<vertex "), "x", position[0]);
                          p = put_attribute(p, " y", position[1]);
                          p = put_text(put_attribute(p, " z", position[2]), "/>\n");
                      }
                      block.advance_to(p);
                  });
    output.write(std::string_view("</vertices>\n<triangles>\n"));
    write_records(output, triangles.faces.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      char* p = block.room(128 * (end - begin));
                      for (std::size_t f = begin; f < end; ++f) {
                          const Triangle& face = triangles.faces[f];
                          p = put_text(p, "<triangle");
                          p = put_attribute(p, " v1", std::int64_t{face[0]});
                          p = put_attribute(p, " v2", std::int64_t{face[1]});
                          p = put_attribute(p, " v3", std::int64_t{face[2]});
                          if (!palette.colors.empty()) {
                              p = put_text(p, " pid=\"1\"");
                              p = put_attribute(p, " p1", std::int64_t{palette.index[f]});
                          }
                          p = put_text(p, "/>\n");
                      }
                      block.advance_to(p);
                  });
    output.write(
        std::string_view("</triangles>\n</mesh></object>\n</resources>\n"
                         "<build><item objectid=\"2\"/></build>\n</model>\n"));
}

}  // namespace

RawMesh read_3mf(std::span<const std::byte> content, const std::string& name)
{
    return Reader(content, name).read();
}

void write_3mf(Output& output, const MeshFile& file)
{
    ZipWriter archive(output);
    archive.add("[Content_Types].xml",
                [](Output& part) { part.write(std::string_view(kContentTypes)); });
    archive.add("_rels/.rels", [](Output& part) { part.write(std::string_view(kRootRelations)); });
    archive.add(std::string(kUsualModel), [&](Output& part) { write_model(part, file); });
    archive.finish();
}

}  // namespace genus::io
