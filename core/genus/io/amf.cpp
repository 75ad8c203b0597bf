#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

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

constexpr int kMaxConstellationDepth = 32;
constexpr std::size_t kMostPlacements = std::size_t{1} << 20;
constexpr std::size_t kMostText = 1024;  // of a number between its tags

using Attributes = std::span<const XmlAttribute>;
using MaybeColor = std::optional<Rgba>;

struct Face {
    Triangle corners;
    MaybeColor color;
    std::int32_t material = -1;
};

struct Object {
    std::vector<Vec3> points;
    std::vector<MaybeColor> colors;  // of the points
    std::vector<Face> faces;
    MaybeColor color;
};

// A child of a constellation.
struct Instance {
    std::int32_t object = 0;
    Vec3 shift;
    Vec3 degrees;
};

struct Document {
    double unit = 1.0;
    std::map<std::int32_t, Object> objects;
    std::map<std::int32_t, std::vector<Instance>> constellations;
    std::map<std::int32_t, Rgba> materials;
};

// Collects the numbers between tags; the innermost element around a colour has it.
class Handler : public XmlHandler {
public:
    explicit Handler(Document& document) : document_(document) {}

    void start(std::string_view element, Attributes attributes) override
    {
        text_.clear();
        if (element == "amf")
            start_document(attributes);
        else if (element == "object")
            object_ = &new_entry(document_.objects, attributes);
        else if (element == "constellation")
            constellation_ = &new_entry(document_.constellations, attributes);
        else if (element == "material")
            material_ = id_of(attributes, "id");
        else if (element == "instance")
            start_instance(attributes);
        else if (element == "volume")
            start_volume(attributes);
        else if (element == "vertex")
            start_vertex();
        else if (element == "triangle")
            start_triangle();
        else if (element == "color")
            channels_ = {{0.0, 0.0, 0.0, 1.0}};
    }

    void text(std::string_view piece) override
    {
        if (text_.size() + piece.size() <= kMostText) text_ += piece;
    }

    void end(std::string_view element) override
    {
        if (element == "color")
            end_color();
        else if (element == "vertex")
            end_vertex();
        else if (element == "triangle")
            end_triangle();
        else if (element == "volume")
            end_volume();
        else if (element == "object")
            end_object();
        else if (element == "constellation")
            constellation_ = nullptr;
        else if (element == "material")
            material_ = -1;
        else if (element == "instance")
            instance_ = nullptr;
        else
            end_number(element);
        text_.clear();
    }

private:
    static std::int32_t id_of(Attributes attributes, const char* name)
    {
        const XmlAttribute* id = find_attribute(attributes, name);
        if (id == nullptr) throw std::string("the attribute '") + name + "' is missing";
        return xml_index(id->value, name);
    }

    template <class Map>
    typename Map::mapped_type& new_entry(Map& map, Attributes attributes)
    {
        const std::int32_t id = id_of(attributes, "id");
        if (document_.objects.count(id) + document_.constellations.count(id) > 0)
            throw "object " + std::to_string(id) + " comes twice";
        return map[id];
    }

    void start_document(Attributes attributes)
    {
        const XmlAttribute* unit = find_attribute(attributes, "unit");
        if (unit != nullptr) document_.unit = unit_length(kAmfUnits, unit->value);
    }

    void start_instance(Attributes attributes)
    {
        if (constellation_ == nullptr) throw std::string("an instance outside of a constellation");
        instance_ = &constellation_->emplace_back();
        instance_->object = id_of(attributes, "objectid");
    }

    Object& object()
    {
        if (object_ == nullptr) throw std::string("a mesh outside of an object");
        return *object_;
    }

    void start_volume(Attributes attributes)
    {
        volume_ = {};
        first_face_ = object().faces.size();
        if (find_attribute(attributes, "materialid") != nullptr)
            volume_.material = id_of(attributes, "materialid");
    }

    void start_vertex()
    {
        object();
        in_vertex_ = true;
        point_ = {{NAN, NAN, NAN}};
        point_color_ = {};
    }

    void start_triangle()
    {
        object();
        in_triangle_ = true;
        face_ = {};
        face_.corners = {-1, -1, -1};
    }

    // x, y and z stand in coordinates, but edges and normals of curved faces have their own names.
    void end_number(std::string_view element)
    {
        if (element.empty()) return;
        const char last = element.back();
        if (in_vertex_ && element.size() == 1 && last >= 'x' && last <= 'z')
            point_[static_cast<std::size_t>(last - 'x')] = xml_number(text_, "a coordinate");
        else if (in_triangle_ && element.size() == 2 && element[0] == 'v' && last >= '1' &&
                 last <= '3')
            face_.corners[static_cast<std::size_t>(last - '1')] = xml_index(text_, "a corner");
        else if (element.size() == 1 &&
                 std::string_view("rgba").find(last) != std::string_view::npos)
            channels_[std::string_view("rgba").find(last)] = channel_number();
        else if (instance_ != nullptr && last >= 'x' && last <= 'z')
            end_instance_number(element, static_cast<std::size_t>(last - 'x'));
    }

    // Not a number where the text is a formula.
    double channel_number() const
    {
        const auto is_plain = [](char c) {
            return is_digit(c) || is_space(c) ||
                   std::string_view("+-.eE").find(c) != std::string_view::npos;
        };
        return std::all_of(text_.begin(), text_.end(), is_plain) ? xml_number(text_, "a colour")
                                                                 : NAN;
    }

    void end_instance_number(std::string_view element, std::size_t axis)
    {
        if (element.starts_with("delta") && element.size() == 6)
            instance_->shift[axis] = xml_number(text_, "a shift");
        else if (element.starts_with("r") && element.size() == 2)
            instance_->degrees[axis] = xml_number(text_, "an angle");
    }

    void end_color()
    {
        std::uint8_t c[4];
        for (std::size_t i = 0; i < 4; ++i) {
            if (std::isnan(channels_[i])) return;
            c[i] =
                static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(channels_[i], 0.0, 1.0)));
        }
        const Rgba color = {c[0], c[1], c[2], c[3]};
        if (in_vertex_)
            point_color_ = color;
        else if (in_triangle_)
            face_.color = color;
        else if (material_ >= 0)
            document_.materials[material_] = color;
        else if (volume_.open)
            volume_.color = color;
        else if (object_ != nullptr)
            object_->color = color;
    }

    void end_vertex()
    {
        if (!is_finite(point_)) throw std::string("a vertex without x, y and z");
        object().points.push_back(point_);
        object().colors.push_back(point_color_);
        in_vertex_ = false;
    }

    void end_triangle()
    {
        for (const std::int32_t v : face_.corners)
            if (v < 0) throw std::string("a triangle without v1, v2 and v3");
        face_.material = volume_.material;
        object().faces.push_back(face_);
        in_triangle_ = false;
    }

    void end_volume()
    {
        std::vector<Face>& faces = object().faces;
        for (std::size_t f = first_face_; f < faces.size(); ++f)
            if (!faces[f].color) faces[f].color = volume_.color;
        volume_ = {};
        volume_.open = false;
    }

    void end_object()
    {
        const auto n = static_cast<std::int64_t>(object().points.size());
        for (const Face& face : object().faces)
            for (const std::int32_t v : face.corners)
                if (v >= n) throw "there is no vertex " + std::to_string(v);
        object_ = nullptr;
    }

    struct Volume {
        bool open = true;
        MaybeColor color;
        std::int32_t material = -1;
    };

    Document& document_;
    Object* object_ = nullptr;
    std::vector<Instance>* constellation_ = nullptr;
    Instance* instance_ = nullptr;
    Volume volume_{false, {}, -1};
    std::size_t first_face_ = 0;
    std::int32_t material_ = -1;
    bool in_vertex_ = false;
    bool in_triangle_ = false;
    Vec3 point_;
    MaybeColor point_color_;
    Face face_;
    Vec4 channels_;
    std::string text_;
};

class Assembler {
public:
    Assembler(const Document& document, std::size_t file_bytes, const std::string& name)
        : document_(document), mesh_(file_bytes, false), name_(name)
    {
    }

    // Everything that no constellation places somewhere stands at its own place.
    RawMesh assemble()
    {
        std::set<std::int32_t> placed;
        for (const auto& [id, instances] : document_.constellations)
            for (const Instance& instance : instances) placed.insert(instance.object);
        for (const auto& [id, object] : document_.objects)
            if (placed.count(id) == 0) place(id, {}, 0);
        for (const auto& [id, instances] : document_.constellations)
            if (placed.count(id) == 0) place(id, {}, 0);
        // Those that contain each other in a circle hang on none of these.
        if (visited_.size() < document_.constellations.size()) fail_circle();
        RawMesh raw = std::move(mesh_).take();
        raw.unit = document_.unit;
        return raw;
    }

private:
    [[noreturn]] void fail_circle() const
    {
        throw FileError(name_, "constellations contain each other too deeply or in a circle");
    }
    [[noreturn]] void fail_too_large() const
    {
        throw FileError(name_, "the constellations repeat their objects too often");
    }

    void place(std::int32_t id, const Transform& map, int depth)
    {
        current_progress().check();
        if (depth > kMaxConstellationDepth) fail_circle();
        if (++placements_ > kMostPlacements) fail_too_large();
        if (const auto object = document_.objects.find(id); object != document_.objects.end()) {
            add(object->second, map);
            return;
        }
        const auto constellation = document_.constellations.find(id);
        if (constellation == document_.constellations.end())
            throw FileError(name_, "there is no object " + std::to_string(id));
        visited_.insert(id);
        for (const Instance& instance : constellation->second)
            place(instance.object, map * translation(instance.shift) * rotation(instance.degrees),
                  depth + 1);
    }

    void add(const Object& object, const Transform& map)
    {
        const std::vector<Vec3> points = mapped(map, object.points);
        for (const Vec3& p : points)
            if (!is_finite(p)) throw FileError(name_, "a constellation leads to infinity");
        std::vector<std::int32_t> numbers;
        if (!mesh_.add_points(points, point_colors(object), numbers)) fail_too_large();
        for (const Face& face : object.faces) {
            Triangle corners = face.corners;
            for (std::int32_t& v : corners) v = numbers[static_cast<std::size_t>(v)];
            const MaybeColor color = color_of(face, object);
            if (!(color ? mesh_.add_face(corners, *color) : mesh_.add_face(corners)))
                fail_too_large();
        }
    }

    static std::vector<Rgba> point_colors(const Object& object)
    {
        const auto has_color = [](const MaybeColor& color) { return color.has_value(); };
        if (std::none_of(object.colors.begin(), object.colors.end(), has_color)) return {};
        std::vector<Rgba> colors;
        for (const MaybeColor& color : object.colors) colors.push_back(color.value_or(Rgba{}));
        return colors;
    }

    MaybeColor color_of(const Face& face, const Object& object) const
    {
        if (face.color) return face.color;
        const auto material = document_.materials.find(face.material);
        if (material != document_.materials.end()) return material->second;
        return object.color;
    }

    const Document& document_;
    SceneMesh mesh_;
    const std::string& name_;
    std::set<std::int32_t> visited_;  // constellations
    std::size_t placements_ = 0;
};

void parse_plain(std::span<const std::byte> content, const std::string& name, Document& document)
{
    Handler handler(document);
    try {
        XmlParser parser(handler);
        parser.feed({reinterpret_cast<const char*>(content.data()), content.size()});
        parser.finish();
    } catch (const XmlFault& fault) {
        throw FileError(name, fault.problem, FileError::at_line(fault.line));
    }
}

void parse_packed(std::span<const std::byte> content, const std::string& name, Document& document)
{
    const ZipArchive archive(content, name);
    const auto is_amf = [](const ZipArchive::Entry& entry) {
        return format_of_extension(entry.name) == MeshFormat::amf;
    };
    const auto entry = std::find_if(archive.entries().begin(), archive.entries().end(), is_amf);
    if (entry == archive.entries().end()) throw FileError(name, "the archive has no .amf file");
    Handler handler(document);
    try {
        XmlParser parser(handler);
        archive.unpack(*entry, [&](std::span<const char> piece) { parser.feed(piece); });
        parser.finish();
    } catch (const XmlFault& fault) {
        throw FileError(
            name, entry->name + ", line " + std::to_string(fault.line) + ": " + fault.problem);
    }
}

// ---- writing ----

constexpr std::size_t kGrain = 8192;
constexpr std::size_t kColorChars = 128;

char* put_element(char* p, std::string_view name, double value)
{
    p = put_text(put_text(put_text(p, "<"), name), ">");
    p = put_number(p, value);
    return put_text(put_text(put_text(p, "</"), name), ">");
}

char* put_index(char* p, std::string_view name, std::int64_t value)
{
    p = put_text(put_text(put_text(p, "<"), name), ">");
    p = put_integer(p, value);
    return put_text(put_text(put_text(p, "</"), name), ">");
}

char* put_color(char* p, const Rgba& color)
{
    const std::string_view names[] = {"r", "g", "b", "a"};
    const std::uint8_t channels[] = {color.r, color.g, color.b, color.a};
    p = put_text(p, "<color>");
    for (std::size_t i = 0; i < 4; ++i) {
        p = put_text(put_text(put_text(p, "<"), names[i]), ">");
        p = put_short_number(p, channels[i] / 255.0);
        p = put_text(put_text(put_text(p, "</"), names[i]), ">");
    }
    return put_text(p, "</color>");
}

void write_vertices(Output& output, const MeshFile& file, double factor)
{
    const std::vector<Vec3>& vertices = file.mesh.vertices;
    write_records(output, vertices.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      for (std::size_t v = begin; v < end; ++v) {
                          char* p = block.room(3 * kNumberChars + 128 + kColorChars);
                          const Vec3 position = vertices[v] * factor;
                          p = put_text(p, "<vertex><coordinates>");
                          p = put_element(p, "x", position[0]);
                          p = put_element(p, "y", position[1]);
                          p = put_element(p, "z", position[2]);
                          p = put_text(p, "</coordinates>");
                          if (!file.vertex_colors.empty()) p = put_color(p, file.vertex_colors[v]);
                          block.advance_to(put_text(p, "</vertex>\n"));
                      }
                  });
}

void write_triangles(Output& output, const ColoredTriangles& triangles)
{
    write_records(output, triangles.faces.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      for (std::size_t f = begin; f < end; ++f) {
                          char* p = put_text(block.room(256 + kColorChars), "<triangle>");
                          if (!triangles.colors.empty()) p = put_color(p, triangles.colors[f]);
                          p = put_index(p, "v1", triangles.faces[f][0]);
                          p = put_index(p, "v2", triangles.faces[f][1]);
                          p = put_index(p, "v3", triangles.faces[f][2]);
                          block.advance_to(put_text(p, "</triangle>\n"));
                      }
                  });
}

}  // namespace

RawMesh read_amf(std::span<const std::byte> content, const std::string& name)
{
    Document document;
    if (is_zip(content))
        parse_packed(content, name, document);
    else
        parse_plain(content, name, document);
    return Assembler(document, content.size(), name).assemble();
}

void write_amf(Output& output, const MeshFile& file)
{
    const UnitScale unit(kAmfUnits, file.unit);
    output.write("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<amf unit=\"" + unit.name +
                 "\" version=\"1.1\">\n<metadata type=\"producer\">genus</metadata>\n"
                 "<object id=\"0\"><mesh>\n<vertices>\n");
    write_vertices(output, file, unit.factor);
    output.write(std::string_view("</vertices>\n<volume>\n"));
    write_triangles(output, to_colored_triangles(file));
    output.write(std::string_view("</volume>\n</mesh></object>\n</amf>\n"));
}

}  // namespace genus::io
