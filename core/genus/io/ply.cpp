#include "genus/io/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/io/number_format.h"
#include "genus/io/pack.h"
#include "genus/io/ply_header.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr std::int64_t kMaxIndex = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kRowsPerCheck = 16384;
constexpr std::size_t kGrain = 16384;  // rows read or written by one thread at a time

double load_number(PlyType type, const std::byte* p, std::endian order)
{
    switch (type) {
        case PlyType::int8:
            return load<std::int8_t>(p, order);
        case PlyType::uint8:
            return load<std::uint8_t>(p, order);
        case PlyType::int16:
            return load<std::int16_t>(p, order);
        case PlyType::uint16:
            return load<std::uint16_t>(p, order);
        case PlyType::int32:
            return load<std::int32_t>(p, order);
        case PlyType::uint32:
            return load<std::uint32_t>(p, order);
        case PlyType::int64:
            return static_cast<double>(load<std::int64_t>(p, order));
        case PlyType::uint64:
            return static_cast<double>(load<std::uint64_t>(p, order));
        case PlyType::float32:
            return load<float>(p, order);
        case PlyType::float64:
            return load<double>(p, order);
    }
    return 0.0;
}

// Of an integer type; a value beyond the signed range comes out negative, which no count and no
// index may be.
std::int64_t load_integer(PlyType type, const std::byte* p, std::endian order)
{
    if (type == PlyType::int64) return load<std::int64_t>(p, order);
    if (type == PlyType::uint64) return static_cast<std::int64_t>(load<std::uint64_t>(p, order));
    return static_cast<std::int64_t>(load_number(type, p, order));
}

std::uint8_t channel(PlyType type, double value)
{
    if (is_float(type)) value *= 255.0;
    if (type == PlyType::uint16) value /= 257.0;
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// Which properties of an element are used; -1 where it has none such.
struct Roles {
    explicit Roles(const PlyElement& element)
        : position{element.find({"x"}), element.find({"y"}), element.find({"z"})},
          color{element.find({"red", "r", "diffuse_red"}),
                element.find({"green", "g", "diffuse_green"}),
                element.find({"blue", "b", "diffuse_blue"}), element.find({"alpha", "a"})},
          corners(element.find({"vertex_indices", "vertex_index"}))
    {
        for (int& role : color)
            if (role >= 0 && element.properties[static_cast<std::size_t>(role)].is_list) role = -1;
    }
    bool has_color() const { return color[0] >= 0 && color[1] >= 0 && color[2] >= 0; }
    bool uses(int property) const
    {
        return std::find(position.begin(), position.end(), property) != position.end() ||
               std::find(color.begin(), color.end(), property) != color.end();
    }

    std::array<int, 3> position;
    std::array<int, 4> color;
    int corners;
};

// Where the numbers of a binary file come from.
class BinarySource {
public:
    BinarySource(std::span<const std::byte> content, std::size_t offset, std::endian order,
                 const std::string& name)
        : begin_(content.data()),
          p_(begin_ + offset),
          end_(begin_ + content.size()),
          order_(order),
          name_(name)
    {
    }

    std::uint64_t left() const { return static_cast<std::uint64_t>(end_ - p_); }
    const std::byte* place() const { return p_; }
    std::endian order() const { return order_; }

    [[noreturn]] void fail(const std::byte* place, const std::string& problem) const
    {
        throw FileError(name_, problem, FileError::at_byte(place - begin_));
    }
    /// `n` numbers of the type, as bytes.
    const std::byte* take(PlyType type, std::uint64_t n)
    {
        if (n > left() / size_of(type)) fail(end_, "the file ends within a row");
        const std::byte* taken = p_;
        p_ += n * size_of(type);
        return taken;
    }
    double number(PlyType type)
    {
        const std::byte* p = take(type, 1);
        const double value = load_number(type, p, order_);
        if (!std::isfinite(value)) fail(p, "a number is not finite");
        return value;
    }
    std::int64_t integer(PlyType type) { return load_integer(type, take(type, 1), order_); }
    void pass_over(PlyType type, std::uint64_t n) { take(type, n); }

private:
    const std::byte* begin_;
    const std::byte* p_;
    const std::byte* end_;
    std::endian order_;
    const std::string& name_;
};

// The same for an ASCII file.
class AsciiSource {
public:
    explicit AsciiSource(std::string_view text) : cursor_(text) {}

    std::uint64_t left() const { return static_cast<std::uint64_t>(cursor_.end - cursor_.p); }
    const char* place()
    {
        cursor_.skip_space();
        return cursor_.p;
    }
    [[noreturn]] void fail(const char* place, const std::string& problem) const
    {
        throw TextFault{place, problem};
    }
    double number(PlyType) { return cursor_.number("a number"); }
    std::int64_t integer(PlyType) { return cursor_.integer("an integer"); }
    void pass_over(PlyType, std::uint64_t n)
    {
        for (std::uint64_t i = 0; i < n; ++i)
            if (cursor_.word().empty()) throw TextFault{cursor_.p, "the file ends within a row"};
    }

private:
    TextCursor cursor_;
};

// Reads the rows of the elements one after the other.
template <class Source>
class RowReader {
public:
    RowReader(const PlyHeader& header, Source& source) : header_(header), source_(source)
    {
        if (const PlyElement* vertices = header.find("vertex")) n_vertices_ = vertices->count;
    }

    RawMesh read()
    {
        const auto* start = source_.place();
        check_counts(start);
        if (n_vertices_ > static_cast<std::uint64_t>(kMaxIndex))
            source_.fail(start, "more than 2^31 - 1 vertices");
        for (const PlyElement& element : header_.elements) {
            if (element.properties.empty()) continue;  // however many, they take no room
            if (element.name == "vertex")
                read_vertices(element);
            else if (element.name == "face")
                read_faces(element);
            else if (element.name == "tristrips")
                read_strips(element);
            else
                pass_over(element);
        }
        return std::move(raw_);
    }

private:
    template <class Place>
    void check_counts(Place start) const
    {
        std::uint64_t left = source_.left() + (header_.ascii ? 1 : 0);
        for (const PlyElement& element : header_.elements) {
            const std::uint64_t bytes = element.least_row_bytes(header_.ascii);
            if (bytes > 0 && element.count > left / bytes)
                source_.fail(start, "the file is too short for " + std::to_string(element.count) +
                                        " rows of the element " + element.name);
            left -= element.count * bytes;
        }
    }

    void pass_over(const PlyElement& element)
    {
        for (std::uint64_t row = 0; row < element.count; ++row) {
            if (row % kRowsPerCheck == 0) current_progress().check();
            for (const PlyProperty& property : element.properties) pass_over(property);
        }
    }

    void pass_over(const PlyProperty& property)
    {
        source_.pass_over(property.type, property.is_list ? list_size(property) : 1);
    }

    std::uint64_t list_size(const PlyProperty& property)
    {
        const auto* place = source_.place();
        const std::int64_t n = source_.integer(property.count_type);
        const std::uint64_t least = header_.ascii ? 2 : size_of(property.type);
        if (n < 0) source_.fail(place, "a list with a negative count");
        if (static_cast<std::uint64_t>(n) > (source_.left() + 1) / least)
            source_.fail(place, "the file is too short for a list of " + std::to_string(n));
        return static_cast<std::uint64_t>(n);
    }

    void check_roles(const PlyElement& element, const Roles& roles)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const int i = roles.position[k];
            if (i < 0 || element.properties[static_cast<std::size_t>(i)].is_list)
                source_.fail(source_.place(),
                             std::string("the vertices have no coordinate ") + "xyz"[k]);
        }
    }

    void read_vertices(const PlyElement& element)
    {
        const Roles roles(element);
        check_roles(element, roles);
        if (read_fixed_vertices(element, roles)) return;
        raw_.vertices.reserve(element.count);
        for (std::uint64_t row = 0; row < element.count; ++row) {
            if (row % kRowsPerCheck == 0) current_progress().check();
            read_row(element, roles);
            raw_.vertices.push_back({{values_[static_cast<std::size_t>(roles.position[0])],
                                      values_[static_cast<std::size_t>(roles.position[1])],
                                      values_[static_cast<std::size_t>(roles.position[2])]}});
            if (roles.has_color()) raw_.vertex_colors.push_back(row_color(element, roles));
        }
    }

    // Numbers of the used properties of the next row, and its corners.
    void read_row(const PlyElement& element, const Roles& roles)
    {
        values_.resize(element.properties.size());
        for (std::size_t i = 0; i < element.properties.size(); ++i) {
            const PlyProperty& property = element.properties[i];
            if (static_cast<int>(i) == roles.corners)
                read_corners(property);
            else if (roles.uses(static_cast<int>(i)) && !property.is_list)
                values_[i] = source_.number(property.type);
            else
                pass_over(property);
        }
    }

    Rgba row_color(const PlyElement& element, const Roles& roles) const
    {
        std::uint8_t c[4] = {255, 255, 255, 255};
        for (std::size_t k = 0; k < 4; ++k) {
            if (roles.color[k] < 0) continue;
            const auto i = static_cast<std::size_t>(roles.color[k]);
            c[k] = channel(element.properties[i].type, values_[i]);
        }
        return {c[0], c[1], c[2], c[3]};
    }

    void read_corners(const PlyProperty& property)
    {
        const std::uint64_t n = property.is_list ? list_size(property) : 1;
        corners_.clear();
        for (std::uint64_t i = 0; i < n; ++i) {
            const auto* place = source_.place();
            const std::int64_t index = source_.integer(property.type);
            const bool ends_strip = strips_ && index == -1;
            if (!ends_strip && (index < 0 || index >= static_cast<std::int64_t>(n_vertices_)))
                source_.fail(place, "there is no vertex " + std::to_string(index));
            corners_.push_back(static_cast<std::int32_t>(index));
        }
    }

    const PlyProperty& corner_list(const PlyElement& element, const Roles& roles)
    {
        if (roles.corners < 0)
            source_.fail(source_.place(), "the element " + element.name + " has no vertex_indices");
        const PlyProperty& list = element.properties[static_cast<std::size_t>(roles.corners)];
        if (!list.is_list || is_float(list.type))
            source_.fail(source_.place(), list.name + " is not a list of integers");
        return list;
    }

    void read_faces(const PlyElement& element)
    {
        const Roles roles(element);
        corner_list(element, roles);
        raw_.faces.reserve_triangles(element.count);
        if (read_fixed_faces(element, roles)) return;
        for (std::uint64_t row = 0; row < element.count; ++row) {
            if (row % kRowsPerCheck == 0) current_progress().check();
            const auto* place = source_.place();
            read_row(element, roles);
            if (corners_.size() < 3)
                source_.fail(place, "a face with " + std::to_string(corners_.size()) + " corners");
            raw_.faces.add(corners_);
            if (roles.has_color())
                add_color(raw_.face_colors, raw_.faces.size() - 1, row_color(element, roles));
        }
    }

    void read_strips(const PlyElement& element)
    {
        const Roles roles(element);
        corner_list(element, roles);
        strips_ = true;
        for (std::uint64_t row = 0; row < element.count; ++row) {
            read_row(element, roles);
            add_strip();
        }
        strips_ = false;
    }

    // Every corner from the third on makes a triangle with the two before it, turned round each
    // time; one with two equal corners only steers the strip.
    void add_strip()
    {
        std::size_t length = 0;
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            length = corners_[i] < 0 ? 0 : length + 1;
            if (length < 3) continue;
            Triangle face = {corners_[i - 2], corners_[i - 1], corners_[i]};
            if (length % 2 == 0) std::swap(face[0], face[1]);
            if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0])
                raw_.faces.add(face);
        }
    }

    // ---- rows of one size in a binary file, the usual case ----

    bool read_fixed_vertices(const PlyElement& element, const Roles& roles)
    {
        if constexpr (std::is_same_v<Source, BinarySource>) {
            std::vector<std::size_t> offsets;
            std::size_t stride = 0;
            for (const PlyProperty& property : element.properties) {
                if (property.is_list) return false;
                offsets.push_back(stride);
                stride += size_of(property.type);
            }
            raw_.vertices.resize(element.count);
            if (roles.has_color()) raw_.vertex_colors.resize(element.count);
            const std::byte* start = source_.take(PlyType::uint8, element.count * stride);
            parallel_for(element.count, kGrain, [&](std::size_t begin, std::size_t end) {
                read_positions(element, roles, offsets, stride, start, begin, end);
                if (roles.has_color())
                    read_colors(element, roles, offsets, stride, start, begin, end);
            });
            return true;
        }
        return false;
    }

    void read_positions(const PlyElement& element, const Roles& roles,
                        const std::vector<std::size_t>& offsets, std::size_t stride,
                        const std::byte* start, std::size_t begin, std::size_t end)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<std::size_t>(roles.position[k]);
            const PlyType type = element.properties[i].type;
            const std::byte* column = start + offsets[i];
            const std::endian order = source_.order();
            bool finite = true;
            const auto read_column = [&](const auto& number) {
                for (std::size_t v = begin; v < end; ++v) {
                    raw_.vertices[v][k] = number(column + v * stride);
                    finite &= std::isfinite(raw_.vertices[v][k]);
                }
            };
            if (type == PlyType::float32)
                read_column([=](const std::byte* p) { return load<float>(p, order); });
            else if (type == PlyType::float64)
                read_column([=](const std::byte* p) { return load<double>(p, order); });
            else
                read_column([=](const std::byte* p) { return load_number(type, p, order); });
            for (std::size_t v = begin; !finite; ++v)
                if (!std::isfinite(raw_.vertices[v][k]))
                    source_.fail(column + v * stride, "a coordinate is not a finite number");
        }
    }

    void read_colors(const PlyElement& element, const Roles& roles,
                     const std::vector<std::size_t>& offsets, std::size_t stride,
                     const std::byte* start, std::size_t begin, std::size_t end)
    {
        constexpr std::uint8_t Rgba::*channels[] = {&Rgba::r, &Rgba::g, &Rgba::b, &Rgba::a};
        for (std::size_t k = 0; k < 4; ++k) {
            if (roles.color[k] < 0) continue;
            const auto i = static_cast<std::size_t>(roles.color[k]);
            const PlyType type = element.properties[i].type;
            for (std::size_t v = begin; v < end; ++v) {
                const std::byte* p = start + v * stride + offsets[i];
                const double value = load_number(type, p, source_.order());
                if (!std::isfinite(value)) source_.fail(p, "a colour is not a finite number");
                raw_.vertex_colors[v].*channels[k] = channel(type, value);
            }
        }
    }

    // Rows of a byte 3, three 4-byte corners, and no more: all of them, or as many as come first.
    bool read_fixed_faces(const PlyElement& element, const Roles&)
    {
        if constexpr (std::is_same_v<Source, BinarySource>) {
            const PlyProperty& list = element.properties.front();
            const bool usual = element.properties.size() == 1 && size_of(list.count_type) == 1 &&
                               size_of(list.type) == 4;
            if (!usual) return false;
            for (std::uint64_t row = 0; row < element.count; ++row) {
                if (row % kRowsPerCheck == 0) current_progress().check();
                const std::byte* p = source_.place();
                if (source_.left() >= 13 && *p == std::byte{3})
                    add_usual_face(p);
                else
                    add_listed_face(p, list);
            }
            return true;
        }
        return false;
    }

    void add_usual_face(const std::byte* p)
    {
        Triangle face;
        bool valid = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto index = load<std::uint32_t>(p + 1 + 4 * k, source_.order());
            valid &= index < n_vertices_;
            face[k] = static_cast<std::int32_t>(index);
        }
        if (!valid) {
            const PlyProperty list{"", PlyType::int32, true, PlyType::uint8};
            read_corners(list);  // throws with the place
        }
        source_.take(PlyType::uint8, 13);
        raw_.faces.add(face);
    }

    void add_listed_face(const std::byte* p, const PlyProperty& list)
    {
        read_corners(list);
        if (corners_.size() < 3)
            source_.fail(p, "a face with " + std::to_string(corners_.size()) + " corners");
        raw_.faces.add(corners_);
    }

    const PlyHeader& header_;
    Source& source_;
    std::uint64_t n_vertices_ = 0;
    bool strips_ = false;
    std::vector<double> values_;
    std::vector<std::int32_t> corners_;
    RawMesh raw_;
};

void check_rest(std::string_view rest, const std::string& name, FileError::Place place)
{
    if (!std::all_of(rest.begin(), rest.end(), is_space))
        throw FileError(name, "something is left over after the last row", place);
}

RawMesh read_rows(std::span<const std::byte> content, std::string_view text,
                  const PlyHeader& header, const std::string& name)
{
    if (!header.ascii) {
        BinarySource source(content, header.size, header.order, name);
        RawMesh raw = RowReader<BinarySource>(header, source).read();
        const auto rest = content.size() - source.left();
        check_rest(text.substr(rest), name, FileError::at_byte(static_cast<std::int64_t>(rest)));
        return raw;
    }
    return with_lines(text, name, [&] {
        AsciiSource source(text.substr(header.size));
        RawMesh raw = RowReader<AsciiSource>(header, source).read();
        const char* rest = source.place();
        if (rest != text.data() + text.size())
            throw TextFault{rest, "something is left over after the last row"};
        return raw;
    });
}

// ---- writing ----

struct Layout {
    std::size_t n_vertices;
    std::size_t n_faces;
    std::size_t largest_degree;
    bool vertex_colors;
    bool face_colors;
    bool ascii;

    bool long_lists() const { return largest_degree > 255; }
};

void write_header(Output& output, const Layout& layout)
{
    const std::string colors =
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    std::string text = "ply\nformat ";
    text += layout.ascii ? "ascii" : "binary_little_endian";
    text += " 1.0\ncomment written by genus\nelement vertex " + std::to_string(layout.n_vertices);
    text += "\nproperty double x\nproperty double y\nproperty double z\n";
    if (layout.vertex_colors) text += colors;
    text += "element face " + std::to_string(layout.n_faces) + "\nproperty list ";
    text += layout.long_lists() ? "int" : "uchar";
    text += " int vertex_indices\n";
    if (layout.face_colors) text += colors;
    output.write(text + "end_header\n");
}

// Puts numbers as bytes or as text.
struct Writer {
    bool ascii;

    char* put(char* p, double value) const
    {
        if (!ascii) return store(p, value, std::endian::little);
        p = put_number(p, value);
        *p++ = ' ';
        return p;
    }
    char* put(char* p, std::int32_t value) const
    {
        return ascii ? put_word(p, value) : store(p, value, std::endian::little);
    }
    char* put(char* p, std::uint8_t value) const
    {
        return ascii ? put_word(p, value) : store(p, value, std::endian::little);
    }
    char* put(char* p, const Rgba& color) const
    {
        for (const std::uint8_t c : {color.r, color.g, color.b, color.a}) p = put(p, c);
        return p;
    }
    char* end_row(char* p) const
    {
        if (ascii) p[-1] = '\n';
        return p;
    }

private:
    static char* put_word(char* p, std::int32_t value)
    {
        p = put_integer(p, value);
        *p++ = ' ';
        return p;
    }
};

template <class Face>
void write(Output& output, const Layout& layout, const std::vector<Vec3>& vertices,
           const std::vector<Rgba>& vertex_colors, const Face& face,
           const std::vector<Rgba>& face_colors)
{
    constexpr std::size_t color_chars = 20;
    constexpr std::size_t vertex_chars = 3 * (kNumberChars + 1) + color_chars;
    constexpr std::size_t per_corner = 12;
    const Writer writer{layout.ascii};
    write_header(output, layout);
    write_records(output, layout.n_vertices, kGrain / 4,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      char* p = block.room(vertex_chars * (end - begin));
                      for (std::size_t v = begin; v < end; ++v) {
                          for (std::size_t k = 0; k < 3; ++k) p = writer.put(p, vertices[v][k]);
                          if (!vertex_colors.empty()) p = writer.put(p, vertex_colors[v]);
                          p = writer.end_row(p);
                      }
                      block.advance_to(p);
                  });
    write_records(
        output, layout.n_faces, kGrain, [&](std::size_t begin, std::size_t end, TextBlock& block) {
            for (std::size_t f = begin; f < end; ++f) {
                const std::span<const std::int32_t> corners = face(f);
                char* p = block.room(per_corner * (corners.size() + 1) + color_chars);
                const auto degree = static_cast<std::int32_t>(corners.size());
                p = layout.long_lists() ? writer.put(p, degree)
                                        : writer.put(p, static_cast<std::uint8_t>(degree));
                for (const std::int32_t v : corners) p = writer.put(p, v);
                if (!face_colors.empty()) p = writer.put(p, face_colors[f]);
                block.advance_to(writer.end_row(p));
            }
        });
}

}  // namespace

RawMesh read_ply(std::span<const std::byte> content, const std::string& name)
{
    const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
    const PlyHeader header = with_lines(text, name, [&] { return read_ply_header(text); });
    return read_rows(content, text, header, name);
}

void write_ply(Output& output, const MeshFile& file, bool ascii)
{
    std::size_t degree = 0;
    for (std::size_t f = 0; f < file.mesh.n_faces(); ++f)
        degree = std::max(degree, file.mesh.face(f).size());
    const Layout layout{file.mesh.n_vertices(),      file.mesh.n_faces(),       degree,
                        !file.vertex_colors.empty(), !file.face_colors.empty(), ascii};
    write(
        output, layout, file.mesh.vertices, file.vertex_colors,
        [&](std::size_t f) { return file.mesh.face(f); }, file.face_colors);
}

void write_ply(Output& output, const IndexedMesh& mesh, bool ascii)
{
    const Layout layout{mesh.n_vertices(), mesh.n_faces(), 3, false, false, ascii};
    write(output, layout, mesh.vertices, {},
          [&](std::size_t f) { return std::span<const std::int32_t>(mesh.faces[f]); }, {});
}

}  // namespace genus::io
