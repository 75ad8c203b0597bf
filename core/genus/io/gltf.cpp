#include "genus/io/gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/base64.h"
#include "genus/io/input_file.h"
#include "genus/io/json.h"
#include "genus/io/number_format.h"
#include "genus/io/pack.h"
#include "genus/io/scene_mesh.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr std::uint32_t kMagic = 0x46546C67;        // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN"
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr double kMillimetres = 1000.0;  // in the unit of glTF

constexpr std::uint64_t kTriangles = 4;  // kinds of primitives
constexpr std::uint64_t kStrip = 5;
constexpr std::uint64_t kFan = 6;

constexpr std::size_t kMostPrimitives = std::size_t{1} << 22;

constexpr char kTooLarge[] = "the scene repeats its meshes too often";

// ---- colours: linear in the file, sRGB in a Rgba ----

std::uint8_t to_srgb(double linear)
{
    linear = std::clamp(linear, 0.0, 1.0);
    const double value =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255.0 * value));
}

double to_linear(std::uint8_t channel)
{
    const double value = channel / 255.0;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

Rgba from_linear(const double (&c)[4])
{
    const double alpha = std::clamp(c[3], 0.0, 1.0);
    return {to_srgb(c[0]), to_srgb(c[1]), to_srgb(c[2]),
            static_cast<std::uint8_t>(std::lround(255.0 * alpha))};
}

// ---- reading ----

struct Parts {
    std::string_view json;
    std::optional<std::span<const std::byte>> binary;
};

[[noreturn]] void fail_at(const std::string& name, std::size_t byte, const std::string& problem)
{
    throw FileError(name, problem, FileError::at_byte(static_cast<std::int64_t>(byte)));
}

Parts split_binary(std::span<const std::byte> content, const std::string& name)
{
    const auto word = [&](std::size_t at) {
        if (content.size() < at + 4) fail_at(name, content.size(), "the file ends too soon");
        return load<std::uint32_t>(content.data() + at, std::endian::little);
    };
    if (word(4) != 2) fail_at(name, 4, "glTF version " + std::to_string(word(4)) + " is not read");
    if (word(8) != content.size()) fail_at(name, 8, "the length in the header is not the file's");
    Parts parts;
    for (std::size_t at = kHeaderBytes; at < content.size();) {
        const std::size_t length = word(at);
        const std::uint32_t kind = word(at + 4);
        const std::size_t data = at + kChunkHeaderBytes;
        if (length > content.size() - data) fail_at(name, at, "a chunk longer than the file");
        const auto chunk = content.subspan(data, length);
        if (at == kHeaderBytes && kind != kJsonChunk)
            fail_at(name, at, "the JSON chunk is missing");
        if (at == kHeaderBytes)
            parts.json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
        else if (kind == kBinaryChunk && !parts.binary)
            parts.binary = chunk;
        at = data + length;
    }
    if (parts.json.empty()) fail_at(name, content.size(), "the JSON chunk is missing");
    return parts;
}

// Numbers in a buffer, `components` together, one such group every `stride` bytes. A sparse one has
// other values for some groups, and zeros where it has no data besides.
struct Accessor {
    const std::byte* data = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;
    std::uint64_t type = 0;
    std::size_t components = 0;
    bool normalized = false;
    std::vector<std::size_t> replaced;  // ascending
    const std::byte* values = nullptr;  // in their place, close together

    double number(std::size_t i, std::size_t component) const
    {
        const std::byte* group = data ? data + i * stride : nullptr;
        const auto at = std::lower_bound(replaced.begin(), replaced.end(), i);
        if (at != replaced.end() && *at == i)
            group = values + static_cast<std::size_t>(at - replaced.begin()) * group_size();
        return group ? number_at(group, component) : 0.0;
    }

    std::size_t group_size() const;

private:
    template <class T>
    static double value_at(const std::byte* group, std::size_t component)
    {
        return static_cast<double>(load<T>(group + sizeof(T) * component, std::endian::little));
    }

    double number_at(const std::byte* group, std::size_t component) const
    {
        switch (type) {
            case 5120:
                return scaled(value_at<std::int8_t>(group, component), 127.0);
            case 5121:
                return scaled(value_at<std::uint8_t>(group, component), 255.0);
            case 5122:
                return scaled(value_at<std::int16_t>(group, component), 32767.0);
            case 5123:
                return scaled(value_at<std::uint16_t>(group, component), 65535.0);
            case 5125:
                return value_at<std::uint32_t>(group, component);
            default:
                return value_at<float>(group, component);
        }
    }

    double scaled(double value, double largest) const
    {
        return normalized ? std::max(value / largest, -1.0) : value;
    }
};

std::size_t component_size(std::uint64_t type)
{
    switch (type) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

std::size_t Accessor::group_size() const
{
    return component_size(type) * components;
}

class Reader {
public:
    Reader(const JsonText& json, const Parts& parts, const std::optional<std::string>& folder,
           std::size_t file_bytes)
        : root_(json.root()),
          parts_(parts),
          folder_(folder),
          file_bytes_(file_bytes),
          buffers_(root_["buffers"].elements()),
          views_(root_["bufferViews"].elements()),
          accessors_(root_["accessors"].elements()),
          materials_(root_["materials"].elements()),
          meshes_(root_["meshes"].elements()),
          nodes_(root_["nodes"].elements()),
          data_(buffers_.size())
    {
    }

    RawMesh read()
    {
        check_version();
        SceneMesh welded(file_bytes_, true);
        read_scene(welded);
        if (!welded.colors_clash()) return with_unit(std::move(welded).take());
        primitives_read_ = 0;
        SceneMesh separate(file_bytes_, false);
        read_scene(separate);
        return with_unit(std::move(separate).take());
    }

private:
    [[noreturn]] static void fail(const JsonValue& at, const std::string& problem)
    {
        throw TextFault{at.at(), problem};
    }

    static RawMesh with_unit(RawMesh raw)
    {
        raw.unit = kMillimetres;
        return raw;
    }

    void check_version() const
    {
        const JsonValue version = root_["asset"]["version"];
        if (!version) fail(root_, "no glTF file: asset.version is missing");
        if (!version.string().starts_with("2."))
            fail(version, "glTF version " + version.string() + " is not read");
        for (const JsonValue& extension : root_["extensionsRequired"].elements())
            if (!is_harmless(extension.string()))
                fail(extension, "the glTF extension " + extension.string() + " is not read");
    }

    // Extensions that do not change where the triangles are, or are read.
    static bool is_harmless(const std::string& extension)
    {
        return extension.starts_with("KHR_materials_") || extension == "KHR_texture_transform" ||
               extension == "KHR_texture_basisu" || extension == "EXT_texture_webp" ||
               extension == "KHR_lights_punctual" || extension == "KHR_mesh_quantization";
    }

    static JsonValue need(const JsonValue& object, std::string_view key)
    {
        const JsonValue value = object[key];
        if (!value) fail(object, "'" + std::string(key) + "' is missing");
        return value;
    }

    template <class List>
    static std::size_t checked_index(const JsonValue& value, const List& list, const char* what)
    {
        const std::uint64_t index = value.index();
        if (index >= list.size())
            fail(value, std::string("there is no ") + what + " " + std::to_string(index));
        return index;
    }

    // ---- the scene ----

    struct Placed {
        JsonValue reference;  // to the node, where a mistake is shown
        Transform map;
    };

    void read_scene(SceneMesh& mesh)
    {
        std::vector<Placed> stack;
        for (const JsonValue& node : root_nodes()) stack.push_back({node, {}});
        std::reverse(stack.begin(), stack.end());
        std::vector<bool> seen(nodes_.size());
        while (!stack.empty()) {
            current_progress().check();
            const Placed placed = stack.back();
            stack.pop_back();
            const std::size_t index = checked_index(placed.reference, nodes_, "node");
            // Nodes are trees: one that comes again has two parents or is its own ancestor.
            if (seen[index])
                fail(placed.reference, "node " + std::to_string(index) + " comes twice");
            seen[index] = true;
            const JsonValue node = nodes_[index];
            const Transform map = placed.map * local_map(node);
            if (const JsonValue reference = node["mesh"])
                read_mesh(meshes_[checked_index(reference, meshes_, "mesh")], map, mesh);
            const std::vector<JsonValue> children = node["children"].elements();
            for (auto child = children.rbegin(); child != children.rend(); ++child)
                stack.push_back({*child, map});
        }
    }

    // Of the default scene, else of the first. Without scenes every mesh counts, at its place.
    std::vector<JsonValue> root_nodes()
    {
        const std::vector<JsonValue> scenes = root_["scenes"].elements();
        if (scenes.empty()) {
            if (!nodes_.empty()) fail(root_, "a glTF file with nodes but without a scene");
            return {};
        }
        const JsonValue chosen = root_["scene"];
        const std::size_t scene = chosen ? checked_index(chosen, scenes, "scene") : 0;
        return scenes[scene]["nodes"].elements();
    }

    template <std::size_t N>
    static bool read_numbers(const JsonValue& value, std::array<double, N>& numbers)
    {
        if (!value) return false;
        const std::vector<JsonValue> elements = value.elements();
        if (elements.size() != N) fail(value, "expected " + std::to_string(N) + " numbers");
        for (std::size_t i = 0; i < N; ++i) numbers[i] = elements[i].number();
        return true;
    }

    static Transform local_map(const JsonValue& node)
    {
        std::array<double, 16> m;
        Transform map;
        if (read_numbers(node["matrix"], m)) {
            for (std::size_t i = 0; i < 16; ++i) map.m[i % 4][i / 4] = m[i];  // column by column
            if (!map.is_affine()) fail(node["matrix"], "the map of a node must be affine");
            return map;
        }
        std::array<double, 3> shift = {0, 0, 0};
        std::array<double, 4> q = {0, 0, 0, 1};
        std::array<double, 3> scale = {1, 1, 1};
        read_numbers(node["translation"], shift);
        read_numbers(node["rotation"], q);
        read_numbers(node["scale"], scale);
        const auto [x, y, z, w] = q;
        const double rotation[3][3] = {
            {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) map.m[i][j] = rotation[i][j] * scale[j];
            map.m[i][3] = shift[i];
        }
        return map;
    }

    // ---- meshes ----

    void read_mesh(const JsonValue& mesh, const Transform& map, SceneMesh& scene)
    {
        const std::vector<JsonValue> primitives = need(mesh, "primitives").elements();
        primitives_read_ += primitives.size();
        if (primitives_read_ > kMostPrimitives) fail(mesh, kTooLarge);
        for (const JsonValue& primitive : primitives) {
            const JsonValue mode = primitive["mode"];
            const std::uint64_t kind = mode ? mode.index() : kTriangles;
            if (kind > kFan) fail(mode, "there is no such kind of primitive");
            if (kind >= kTriangles) read_primitive(primitive, kind, map, scene);
        }
    }

    void read_primitive(const JsonValue& primitive, std::uint64_t kind, const Transform& map,
                        SceneMesh& scene)
    {
        current_progress().check();
        const JsonValue attributes = need(primitive, "attributes");
        const JsonValue position = attributes["POSITION"];
        if (!position) return;  // by the specification there is nothing to draw
        const std::vector<Vec3> points = mapped(map, read_points(position));
        for (const Vec3& p : points)
            if (!is_finite(p)) fail(position, "a coordinate is not a finite number");
        const std::vector<Rgba> colors = read_colors(attributes["COLOR_0"], points.size());
        std::vector<std::int32_t> numbers;
        if (!scene.add_points(points, colors, numbers)) fail(primitive, kTooLarge);
        add_faces(primitive, kind, determinant(map) < 0.0, numbers, scene);
    }

    std::vector<Vec3> read_points(const JsonValue& reference)
    {
        const Accessor accessor = read_accessor(reference);
        // Whole numbers by KHR_mesh_quantization.
        if (accessor.components != 3 || accessor.type == 5125)
            fail(reference, "positions must be vectors of three numbers of a type for positions");
        std::vector<Vec3> points(accessor.count);
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) points[i][k] = accessor.number(i, k);
        return points;
    }

    std::vector<Rgba> read_colors(const JsonValue& reference, std::size_t n)
    {
        if (!reference) return {};
        const Accessor accessor = read_accessor(reference);
        const bool valid =
            (accessor.components == 3 || accessor.components == 4) && accessor.count == n &&
            (accessor.type == 5126 ||
             (accessor.normalized && (accessor.type == 5121 || accessor.type == 5123)));
        if (!valid) fail(reference, "colours of vertices of a wrong type or number");
        std::vector<Rgba> colors(n);
        for (std::size_t i = 0; i < n; ++i) {
            double c[4] = {0.0, 0.0, 0.0, 1.0};
            for (std::size_t k = 0; k < accessor.components; ++k) c[k] = accessor.number(i, k);
            for (const double value : c)
                if (!std::isfinite(value)) fail(reference, "a colour is not a finite number");
            colors[i] = from_linear(c);
        }
        return colors;
    }

    std::optional<Rgba> material_color(const JsonValue& primitive) const
    {
        const JsonValue reference = primitive["material"];
        if (!reference) return std::nullopt;
        const JsonValue material = materials_[checked_index(reference, materials_, "material")];
        std::array<double, 4> factor;
        if (!read_numbers(material["pbrMetallicRoughness"]["baseColorFactor"], factor))
            return std::nullopt;
        const double c[4] = {factor[0], factor[1], factor[2], factor[3]};
        return from_linear(c);
    }

    void add_faces(const JsonValue& primitive, std::uint64_t kind, bool mirrored,
                   const std::vector<std::int32_t>& numbers, SceneMesh& scene)
    {
        const JsonValue reference = primitive["indices"];
        const std::optional<Rgba> color = material_color(primitive);
        Accessor indices;
        if (reference) {
            indices = read_accessor(reference);
            const bool integer =
                indices.type == 5121 || indices.type == 5123 || indices.type == 5125;
            if (indices.components != 1 || !integer || indices.normalized)
                fail(reference, "indices must be single whole numbers");
        }
        const auto corner = [&](std::size_t i) {
            const std::size_t index =
                reference ? static_cast<std::size_t>(indices.number(i, 0)) : i;
            if (index >= numbers.size())
                fail(reference, "there is no vertex " + std::to_string(index));
            return numbers[index];
        };
        const std::size_t n = reference ? indices.count : numbers.size();
        if (kind == kTriangles && n % 3 != 0)
            fail(primitive, "the number of corners is no multiple of three");
        const std::size_t step = kind == kTriangles ? 3 : 1;
        for (std::size_t i = 0; i + 2 < n; i += step) {
            Triangle face = {corner(kind == kFan ? 0 : i), corner(i + 1), corner(i + 2)};
            // The second triangle of a strip, the fourth and so on run the other way.
            if (mirrored != (kind == kStrip && i % 2 == 1)) std::swap(face[1], face[2]);
            if (!(color ? scene.add_face(face, *color) : scene.add_face(face)))
                fail(primitive, kTooLarge);
        }
    }

    // ---- data ----

    Accessor read_accessor(const JsonValue& reference)
    {
        const JsonValue object = accessors_[checked_index(reference, accessors_, "accessor")];
        Accessor accessor;
        accessor.type = need(object, "componentType").index();
        if (component_size(accessor.type) == 0) fail(object, "a wrong componentType");
        accessor.components = component_count(need(object, "type"));
        accessor.count = need(object, "count").index();
        if (const JsonValue normalized = object["normalized"])
            accessor.normalized = normalized.boolean();
        const JsonValue sparse = object["sparse"];
        if (!sparse || object["bufferView"]) {
            std::tie(accessor.data, accessor.stride) =
                read_groups(object, accessor.group_size(), accessor.count);
        } else if (accessor.count > file_bytes_) {
            fail(object, "an accessor without data is longer than the file");
        }
        if (sparse) read_replaced(sparse, accessor);
        return accessor;
    }

    // Where `count` groups begin, and how far from each other.
    std::pair<const std::byte*, std::size_t> read_groups(const JsonValue& object, std::size_t group,
                                                         std::size_t count)
    {
        const JsonValue view_reference = need(object, "bufferView");
        const JsonValue view = views_[checked_index(view_reference, views_, "bufferView")];
        const std::span<const std::byte> bytes = view_bytes(view);
        const std::size_t stride = optional_index(view, "byteStride", group);
        const std::size_t offset = optional_index(object, "byteOffset", 0);
        if (stride < group || stride > 255) fail(view, "a wrong byteStride");
        // Written so that nothing overflows: (count - 1) * stride + group bytes are needed.
        if (count > 0 && (offset > bytes.size() || bytes.size() - offset < group ||
                          count - 1 > (bytes.size() - offset - group) / stride))
            fail(object, "an accessor reaches beyond its data");
        return {bytes.data() + (count > 0 ? offset : 0), stride};
    }

    void read_replaced(const JsonValue& sparse, Accessor& accessor)
    {
        const JsonValue where = need(sparse, "indices"), values = need(sparse, "values");
        Accessor indices;
        indices.count = need(sparse, "count").index();
        indices.type = need(where, "componentType").index();
        indices.components = 1;
        if (indices.type != 5121 && indices.type != 5123 && indices.type != 5125)
            fail(where, "indices must be single whole numbers");
        std::tie(indices.data, indices.stride) =
            read_groups(where, indices.group_size(), indices.count);
        std::size_t stride = 0;
        std::tie(accessor.values, stride) =
            read_groups(values, accessor.group_size(), indices.count);
        if (stride != accessor.group_size()) fail(values, "a wrong byteStride");
        for (std::size_t i = 0; i < indices.count; ++i) {
            const auto at = static_cast<std::size_t>(indices.number(i, 0));
            const bool ascending = accessor.replaced.empty() || accessor.replaced.back() < at;
            if (!ascending || at >= accessor.count)
                fail(where, "indices of a sparse accessor must ascend within its count");
            accessor.replaced.push_back(at);
        }
    }

    static std::size_t component_count(const JsonValue& type)
    {
        const std::string name = type.string();
        if (name == "SCALAR") return 1;
        if (name == "VEC3") return 3;
        if (name == "VEC4") return 4;
        fail(type, "accessors of type " + name + " are not read");
    }

    static std::size_t optional_index(const JsonValue& object, std::string_view key,
                                      std::size_t otherwise)
    {
        const JsonValue value = object[key];
        return value ? value.index() : otherwise;
    }

    std::span<const std::byte> view_bytes(const JsonValue& view)
    {
        const JsonValue reference = need(view, "buffer");
        const std::size_t buffer = checked_index(reference, buffers_, "buffer");
        const std::span<const std::byte> bytes = buffer_bytes(buffer);
        const std::size_t offset = optional_index(view, "byteOffset", 0);
        const std::size_t length = need(view, "byteLength").index();
        if (offset > bytes.size() || length > bytes.size() - offset)
            fail(view, "a bufferView reaches beyond its buffer");
        return bytes.subspan(offset, length);
    }

    struct Buffer {
        bool loaded = false;
        std::span<const std::byte> bytes;
        std::vector<std::byte> decoded;
        std::optional<InputFile> file;
    };

    std::span<const std::byte> buffer_bytes(std::size_t index)
    {
        Buffer& buffer = data_[index];
        if (buffer.loaded) return buffer.bytes;
        const JsonValue object = buffers_[index];
        const std::size_t length = need(object, "byteLength").index();
        if (const JsonValue uri = object["uri"])
            load_uri(uri, buffer);
        else if (index == 0 && parts_.binary)
            buffer.bytes = *parts_.binary;
        else
            fail(object, "a buffer without data");
        if (buffer.bytes.size() < length)
            fail(object, "a buffer of " + std::to_string(length) + " bytes has " +
                             std::to_string(buffer.bytes.size()));
        buffer.bytes = buffer.bytes.first(length);
        buffer.loaded = true;
        return buffer.bytes;
    }

    void load_uri(const JsonValue& reference, Buffer& buffer)
    {
        const std::string uri = reference.string();
        if (uri.starts_with("data:")) {
            const std::size_t comma = uri.find(";base64,");
            if (comma == std::string::npos) fail(reference, "data that are not in base64");
            auto decoded = base64_decoded(std::string_view(uri).substr(comma + 8));
            if (!decoded) fail(reference, "wrong base64");
            buffer.decoded = std::move(*decoded);
            buffer.bytes = buffer.decoded;
            return;
        }
        const std::string file = percent_decoded(uri);
        if (!folder_) fail(reference, "data in another file, '" + file + "', cannot be found");
        if (!stays_in_folder(file))
            fail(reference, "data outside the folder of the file: '" + file + "'");
        buffer.file.emplace(folder_->empty() ? file : *folder_ + "/" + file);
        buffer.bytes = buffer.file->bytes();
    }

    // A file from elsewhere must not make us read what its sender cannot see.
    static bool stays_in_folder(const std::string& file)
    {
        if (file.empty() || file.front() == '/' || file.find('\\') != std::string::npos ||
            file.find(':') != std::string::npos || file.find('\0') != std::string::npos)
            return false;
        std::string_view rest = file;
        while (!rest.empty()) {
            const std::size_t slash = std::min(rest.find('/'), rest.size());
            if (rest.substr(0, slash) == "..") return false;
            rest.remove_prefix(std::min(slash + 1, rest.size()));
        }
        return true;
    }

    JsonValue root_;
    const Parts& parts_;
    const std::optional<std::string>& folder_;
    std::size_t file_bytes_;
    std::vector<JsonValue> buffers_;
    std::vector<JsonValue> views_;
    std::vector<JsonValue> accessors_;
    std::vector<JsonValue> materials_;
    std::vector<JsonValue> meshes_;
    std::vector<JsonValue> nodes_;
    std::vector<Buffer> data_;
    std::size_t primitives_read_ = 0;
};

// ---- writing ----

struct Group {
    std::optional<Rgba> color;
    std::vector<Triangle> faces;
};

std::vector<Group> group_by_color(const MeshFile& file)
{
    const ColoredTriangles triangles = to_colored_triangles(file);
    if (triangles.colors.empty()) return {{std::nullopt, triangles.faces}};
    using Key = std::tuple<std::uint8_t, std::uint8_t, std::uint8_t, std::uint8_t>;
    std::map<Key, std::size_t> group_of;
    std::vector<Group> groups;
    for (std::size_t f = 0; f < triangles.faces.size(); ++f) {
        const Rgba& c = triangles.colors[f];
        const auto [entry, is_new] = group_of.try_emplace({c.r, c.g, c.b, c.a}, groups.size());
        if (is_new) groups.push_back({c, {}});
        groups[entry->second].faces.push_back(triangles.faces[f]);
    }
    return groups;
}

class Writer {
public:
    Writer(const MeshFile& file, const std::string& name) : file_(file), name_(name)
    {
        groups_ = group_by_color(file);
        std::erase_if(groups_, [](const Group& group) { return group.faces.empty(); });
    }

    void write(Output& output, bool binary)
    {
        // A primitive must have at least one vertex, and an empty list is not allowed either.
        const bool empty = groups_.empty();
        if (!empty) fill_buffer();
        std::string json =
            empty ? R"({"asset":{"version":"2.0","generator":"genus"}})" : scene(binary);
        if (!binary) {
            output.write(json);
            return;
        }
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const std::size_t chunk = empty ? 0 : kChunkHeaderBytes + buffer_.size();
        const std::size_t total = kHeaderBytes + kChunkHeaderBytes + json.size() + chunk;
        if (total > 0xFFFFFFFF) throw FileError(name_, "more than the 4 GB that GLB can hold");
        put_words(output, {kMagic, 2, static_cast<std::uint32_t>(total)});
        put_words(output, {static_cast<std::uint32_t>(json.size()), kJsonChunk});
        output.write(json);
        if (empty) return;
        put_words(output, {static_cast<std::uint32_t>(buffer_.size()), kBinaryChunk});
        output.write(buffer_);
    }

private:
    static void put_words(Output& output, std::initializer_list<std::uint32_t> words)
    {
        for (const std::uint32_t word : words) {
            char bytes[4];
            store(bytes, word, std::endian::little);
            output.write(bytes);
        }
    }

    void fill_buffer()
    {
        const bool colored = !file_.vertex_colors.empty();
        const std::size_t n = file_.mesh.n_vertices();
        std::size_t n_faces = 0;
        for (const Group& group : groups_) n_faces += group.faces.size();
        buffer_.resize(12 * n + (colored ? 16 * n : 0) + 12 * n_faces);
        char* p = buffer_.data();
        const double scale = file_.unit > 0.0 ? file_.unit / kMillimetres : 1.0;
        for (const Vec3& v : file_.mesh.vertices) p = put_position(p, v * scale);
        if (colored) {
            std::array<float, 256> linear;
            for (std::size_t i = 0; i < 256; ++i)
                linear[i] = static_cast<float>(to_linear(static_cast<std::uint8_t>(i)));
            for (const Rgba& c : file_.vertex_colors)
                for (const float x :
                     {linear[c.r], linear[c.g], linear[c.b], static_cast<float>(c.a / 255.0)})
                    p = store(p, x, std::endian::little);
        }
        for (const Group& group : groups_)
            for (const Triangle& face : group.faces)
                for (const std::int32_t v : face) p = store(p, v, std::endian::little);
    }

    char* put_position(char* p, const Vec3& v)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto x = static_cast<float>(v[k]);
            if (std::isinf(x))
                throw FileError(name_, "a coordinate is too large for the 4-byte numbers of glTF");
            least_[k] = std::min(least_[k], x);
            most_[k] = std::max(most_[k], x);
            p = store(p, x, std::endian::little);
        }
        return p;
    }

    static std::string text(double value)
    {
        char buffer[kNumberChars];
        return std::string(buffer, put_number(buffer, value));
    }
    static std::string list(const std::array<float, 3>& v)
    {
        return "[" + text(v[0]) + "," + text(v[1]) + "," + text(v[2]) + "]";
    }

    std::string scene(bool binary)
    {
        const std::size_t n = file_.mesh.n_vertices();
        const bool colored = !file_.vertex_colors.empty();
        std::string json =
            R"({"asset":{"version":"2.0","generator":"genus"},"scene":0,"scenes":[{"nodes":[0]}],)"
            R"("nodes":[{"mesh":0}],"buffers":[{"byteLength":)";
        json += std::to_string(buffer_.size());
        if (!binary)
            json +=
                R"(,"uri":"data:application/octet-stream;base64,)" + base64_encoded(buffer_) + '"';
        json += "}],\"bufferViews\":[";
        std::string accessors;
        add_view(json, accessors, 0, 12 * n, 34962, 5126, n, "VEC3");
        accessors.insert(accessors.size() - 1,
                         ",\"min\":" + list(least_) + ",\"max\":" + list(most_));
        std::size_t offset = 12 * n;
        if (colored) {
            add_view(json, accessors, offset, 16 * n, 34962, 5126, n, "VEC4");
            offset += 16 * n;
        }
        std::string primitives;
        std::string materials;
        const std::size_t first = colored ? 2 : 1;
        for (std::size_t g = 0; g < groups_.size(); ++g) {
            const std::size_t corners = 3 * groups_[g].faces.size();
            add_view(json, accessors, offset, 4 * corners, 34963, 5125, corners, "SCALAR");
            offset += 4 * corners;
            add_primitive(primitives, materials, g, first + g, colored);
        }
        json += "],\"accessors\":[" + accessors + "],";
        if (!materials.empty()) json += "\"materials\":[" + materials + "],";
        return json + "\"meshes\":[{\"primitives\":[" + primitives + "]}]}";
    }

    void add_view(std::string& views, std::string& accessors, std::size_t offset,
                  std::size_t length, int target, int type, std::size_t count, const char* kind)
    {
        if (n_views_ > 0) {
            views += ',';
            accessors += ',';
        }
        views += "{\"buffer\":0,\"byteOffset\":" + std::to_string(offset) +
                 ",\"byteLength\":" + std::to_string(length) +
                 ",\"target\":" + std::to_string(target) + "}";
        accessors += "{\"bufferView\":" + std::to_string(n_views_++) +
                     ",\"componentType\":" + std::to_string(type) +
                     ",\"count\":" + std::to_string(count) + ",\"type\":\"" + kind + "\"}";
    }

    void add_primitive(std::string& primitives, std::string& materials, std::size_t group,
                       std::size_t indices, bool colored) const
    {
        if (!primitives.empty()) primitives += ',';
        primitives += "{\"attributes\":{\"POSITION\":0";
        if (colored) primitives += ",\"COLOR_0\":1";
        primitives += "},\"indices\":" + std::to_string(indices);
        if (const std::optional<Rgba>& color = groups_[group].color) {
            if (!materials.empty()) materials += ',';
            materials += "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[" +
                         text(to_linear(color->r)) + "," + text(to_linear(color->g)) + "," +
                         text(to_linear(color->b)) + "," + text(color->a / 255.0) +
                         "],\"metallicFactor\":0}";
            if (color->a < 255) materials += ",\"alphaMode\":\"BLEND\"";
            materials += "}";
            primitives += ",\"material\":" + std::to_string(group);
        }
        primitives += "}";
    }

    const MeshFile& file_;
    const std::string& name_;
    std::vector<Group> groups_;
    std::vector<char> buffer_;
    std::size_t n_views_ = 0;
    std::array<float, 3> least_ = {INFINITY, INFINITY, INFINITY};
    std::array<float, 3> most_ = {-INFINITY, -INFINITY, -INFINITY};
};

}  // namespace

RawMesh read_gltf(std::span<const std::byte> content, const std::string& name,
                  const std::optional<std::string>& folder)
{
    const bool binary =
        content.size() >= 4 && load<std::uint32_t>(content.data(), std::endian::little) == kMagic;
    const Parts parts =
        binary ? split_binary(content, name) : Parts{as_text(content), std::nullopt};
    const auto read = [&] {
        const JsonText json(parts.json);
        return Reader(json, parts, folder, content.size()).read();
    };
    if (!binary) return with_lines(parts.json, name, read);
    try {
        return read();
    } catch (const TextFault& fault) {
        const auto* at = reinterpret_cast<const std::byte*>(fault.at);
        fail_at(name, static_cast<std::size_t>(at - content.data()), fault.problem);
    }
}

void write_gltf(Output& output, const MeshFile& file, bool binary)
{
    Writer(file, output.name()).write(output, binary);
}

}  // namespace genus::io
