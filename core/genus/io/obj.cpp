#include "genus/io/obj.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/io/input_file.h"
#include "genus/io/number_format.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  // read by one thread at a time
constexpr std::int64_t kMaxIndex = std::numeric_limits<std::int32_t>::max();

// Statements that say nothing about polygons.
constexpr std::string_view kPassedOver[] = {
    "vt",     "vn",     "vp",       "g",        "s",    "o",          "l",         "p",
    "usemap", "maplib", "mg",       "deg",      "bmat", "step",       "cstype",    "curv",
    "curv2",  "surf",   "parm",     "trim",     "hole", "scrv",       "sp",        "end",
    "con",    "bevel",  "c_interp", "d_interp", "lod",  "shadow_obj", "trace_obj", "ctech",
    "stech",  "call",   "csh",      "bsp",      "bzp",  "cdc",        "cdp",       "res"};

bool is_statement(std::string_view word)
{
    return word == "v" || word == "f" || word == "fo" || word == "usemtl" || word == "mtllib" ||
           std::find(std::begin(kPassedOver), std::end(kPassedOver), word) != std::end(kPassedOver);
}

struct MaterialUse {
    std::size_t first_face;  // of the piece
    std::string_view name;
};

// What one piece of the text holds; the material in use goes on into the next. Vertices before it
// are not counted yet while it is read, so a corner given by a negative index is numbered from the
// first vertex of the piece, possibly below zero, and listed for correction.
struct Piece {
    std::vector<MaterialUse> materials;
    std::vector<std::string_view> libraries;
    std::vector<Vec3> vertices;
    std::vector<Rgba> colors;
    FaceList faces;
    std::vector<std::size_t> relative_corners;
    std::int64_t largest_index = -1;  // of those counted from the first vertex of the file
    std::int64_t smallest_index = 0;  // of those counted from the first vertex of the piece
};

// How many vertices the file has, and how many of them before the piece.
struct Numbering {
    std::int64_t before = kMaxIndex;
    std::int64_t total = kMaxIndex;
};

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

class PieceReader {
public:
    PieceReader(std::string_view text, Numbering numbering)
        : p_(text.data()), end_(p_ + text.size()), numbering_(numbering)
    {
    }

    Piece read()
    {
        while (true) {
            skip_blanks();
            if (p_ == end_) break;
            if (is_newline(*p_))
                ++p_;
            else if (*p_ == '#')
                skip_comment();
            else if (is_word("v", 1))
                read_vertex();
            else if (is_word("f", 1) || is_word("fo", 2))
                read_face();
            else if (is_word("usemtl", 6))
                piece_.materials.push_back({piece_.faces.size(), rest_of_line()});
            else if (is_word("mtllib", 6))
                piece_.libraries.push_back(rest_of_line());
            else
                pass_over();
        }
        return std::move(piece_);
    }

private:
    // A backslash before the end of a line makes the line go on; it counts as a blank.
    void skip_blanks()
    {
        while (p_ != end_) {
            if (is_blank(*p_))
                ++p_;
            else if (*p_ == '\\' && continuation() != 0)
                p_ += continuation();
            else
                break;
        }
    }
    std::ptrdiff_t continuation() const
    {
        if (end_ - p_ >= 3 && p_[1] == '\r' && p_[2] == '\n') return 3;
        return end_ - p_ >= 2 && is_newline(p_[1]) ? 2 : 0;
    }
    void skip_comment()
    {
        while (p_ != end_ && !is_newline(*p_)) ++p_;
    }
    bool at_line_end() const { return p_ == end_ || is_newline(*p_) || *p_ == '#'; }
    bool ends_word(const char* q) const { return q == end_ || is_space(*q) || *q == '\\'; }

    bool is_word(const char* word, std::ptrdiff_t length) const
    {
        return end_ - p_ >= length && std::equal(word, word + length, p_) && ends_word(p_ + length);
    }

    void pass_over()
    {
        const char* start = p_;
        while (!ends_word(p_)) ++p_;
        if (!is_statement({start, static_cast<std::size_t>(p_ - start)}))
            throw TextFault{start, shown_word(start, end_) + " is not an OBJ statement"};
        while (p_ != end_ && !is_newline(*p_)) {
            if (*p_ == '\\' && continuation() != 0)
                p_ += continuation();
            else
                ++p_;
        }
    }

    // What stands behind the word at p_, a name that may have blanks in it.
    std::string_view rest_of_line()
    {
        while (!ends_word(p_)) ++p_;
        const char* start = p_;
        while (p_ != end_ && !is_newline(*p_)) ++p_;
        return trimmed({start, static_cast<std::size_t>(p_ - start)});
    }

    void read_vertex()
    {
        const char* start = p_++;
        double value[8];
        std::size_t n = 0;
        for (skip_blanks(); !at_line_end(); skip_blanks()) {
            if (n == std::size(value)) throw TextFault{p_, "a vertex with more than 8 numbers"};
            p_ = parse_number(p_, end_, value[n++]);
            if (!ends_word(p_) && *p_ != '#')
                throw TextFault{p_, "unexpected " + shown_word(p_, end_) + " after a number"};
        }
        if (n < 3) throw TextFault{start, "a vertex needs three coordinates"};
        if (n >= 6)
            add_color(piece_.colors, piece_.vertices.size(),
                      {channel(value[3]), channel(value[4]), channel(value[5]),
                       n >= 7 ? channel(value[6]) : std::uint8_t{255}});
        piece_.vertices.push_back({{value[0], value[1], value[2]}});
    }

    static std::uint8_t channel(double value)
    {
        return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
    }

    void read_face()
    {
        const char* start = p_;
        while (!ends_word(p_)) ++p_;
        corners_.clear();
        bool relative = false;
        for (skip_blanks(); !at_line_end(); skip_blanks()) relative |= read_corner();
        if (corners_.size() < 3) throw TextFault{start, "a face needs three corners"};
        if (relative) list_relative_corners();
        if (corners_.size() == 3)
            piece_.faces.add(Triangle{corners_[0].number, corners_[1].number, corners_[2].number});
        else
            add_polygon();
    }

    struct Corner {
        std::int32_t number;
        bool relative;
    };

    // Whether its index is negative.
    bool read_corner()
    {
        const char* start = p_;
        const bool negative = *p_ == '-';
        if (negative) ++p_;
        std::int64_t index = 0;
        const char* digits = p_;
        for (; p_ != end_ && is_digit(*p_) && p_ - digits < 12; ++p_)
            index = 10 * index + (*p_ - '0');
        if (p_ == digits) throw_bad_corner(start);
        if (index == 0) throw TextFault{start, "vertex index 0; they count from 1"};
        if (index > kMaxIndex) throw_no_vertex(start);
        if (negative)
            add_relative(start, index);
        else
            add_absolute(start, index - 1);
        if (!ends_word(p_)) skip_other_indices(start);
        return negative;
    }

    void add_absolute(const char* start, std::int64_t index)
    {
        if (index >= numbering_.total) throw_no_vertex(start);
        piece_.largest_index = std::max(piece_.largest_index, index);
        corners_.push_back({static_cast<std::int32_t>(index), false});
    }

    void add_relative(const char* start, std::int64_t back)
    {
        const std::int64_t index = static_cast<std::int64_t>(piece_.vertices.size()) - back;
        if (numbering_.before + index < 0) throw_no_vertex(start);
        piece_.smallest_index = std::min(piece_.smallest_index, index);
        corners_.push_back({static_cast<std::int32_t>(index), true});
    }

    // Of texture coordinates and normals; only their form is checked.
    void skip_other_indices(const char* start)
    {
        for (int slashes = 0; !ends_word(p_) && *p_ != '#';) {
            if (*p_ != '/' || ++slashes > 2) throw_bad_corner(start);
            ++p_;
            if (p_ != end_ && *p_ == '-') ++p_;
            while (p_ != end_ && is_digit(*p_)) ++p_;
        }
    }

    [[noreturn]] void throw_bad_corner(const char* start) const
    {
        throw TextFault{start, shown_word(start, end_) + " is not a corner of a face"};
    }
    [[noreturn]] void throw_no_vertex(const char* start) const
    {
        throw TextFault{start, "there is no vertex " + shown_word(start, end_)};
    }

    void list_relative_corners()
    {
        for (std::size_t i = 0; i < corners_.size(); ++i)
            if (corners_[i].relative)
                piece_.relative_corners.push_back(piece_.faces.n_corners() + i);
    }

    void add_polygon()
    {
        polygon_.clear();
        for (const Corner& corner : corners_) polygon_.push_back(corner.number);
        piece_.faces.add(polygon_);
    }

    const char* p_;
    const char* end_;
    Numbering numbering_;
    Piece piece_;
    std::vector<Corner> corners_;
    std::vector<std::int32_t> polygon_;
};

// Begin of the first line from `from` on that does not continue the one before it.
std::size_t next_line(std::string_view text, std::size_t from)
{
    while (true) {
        const std::size_t newline = text.find('\n', from);
        if (newline == std::string_view::npos) return text.size();
        from = newline + 1;
        std::size_t last = newline;
        if (last > 0 && text[last - 1] == '\r') --last;
        if (last == 0 || text[last - 1] != '\\') return from;
    }
}

std::vector<std::string_view> cut_at_lines(std::string_view text)
{
    std::vector<std::string_view> pieces;
    while (text.size() > kChunkBytes) {
        const std::size_t end = next_line(text, kChunkBytes);
        pieces.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    pieces.push_back(text);
    return pieces;
}

void append_vertices(RawMesh& raw, Piece& piece)
{
    if (!raw.vertex_colors.empty() || !piece.colors.empty()) {
        raw.vertex_colors.resize(raw.vertices.size());
        raw.vertex_colors.insert(raw.vertex_colors.end(), piece.colors.begin(), piece.colors.end());
    }
    raw.vertices.insert(raw.vertices.end(), piece.vertices.begin(), piece.vertices.end());
}

// ---- materials ----

using Materials = std::map<std::string, Rgba, std::less<>>;

std::uint8_t to_channel(double value)
{
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

// The statements newmtl, Kd, d and Tr of a library; the rest is for pictures.
void read_materials(std::string_view text, Materials& materials)
{
    Rgba* material = nullptr;
    while (!text.empty()) {
        const std::size_t newline = std::min(text.find('\n'), text.size() - 1);
        const std::string_view line = trimmed(text.substr(0, newline + 1));
        text.remove_prefix(newline + 1);
        const std::string_view word =
            line.substr(0, std::min(line.find_first_of(" \t"), line.size()));
        if (word == "newmtl") material = &materials[std::string(trimmed(line.substr(word.size())))];
        const std::size_t n = word == "Kd" ? 3 : word == "d" || word == "Tr" ? 1 : 0;
        if (n == 0 || material == nullptr) continue;
        const std::string_view rest = trimmed(line.substr(word.size()));
        // "Kd spectral file", "Kd xyz x y z", "d -halo x": not plain numbers, left out.
        if (!rest.empty() && !is_digit(rest[0]) && rest[0] != '.' && rest[0] != '+') continue;
        double value[3] = {};
        TextCursor cursor(rest);
        for (std::size_t i = 0; i < n; ++i) value[i] = cursor.number("a number");
        if (n == 3) {
            material->r = to_channel(value[0]);
            material->g = to_channel(value[1]);
            material->b = to_channel(value[2]);
        } else {
            material->a = to_channel(word == "d" ? value[0] : 1.0 - value[0]);
        }
    }
}

bool stays_in_folder(const std::filesystem::path& file)
{
    if (file.empty() || file.has_root_path()) return false;
    return std::none_of(file.begin(), file.end(), [](const auto& part) { return part == ".."; });
}

// One name, or several; none of them has to be there.
void read_libraries(std::string_view names, const std::string& folder, Materials& materials)
{
    std::vector<std::string> files{std::string(names)};
    const auto path_of = [&](const std::string& file) {
        return folder.empty() ? file : folder + "/" + file;
    };
    const auto is_there = [&](const std::string& file) {
        std::error_code error;
        return stays_in_folder(file) && std::filesystem::is_regular_file(path_of(file), error);
    };
    if (!is_there(files[0])) {
        files.clear();
        while (!names.empty()) {
            const std::string_view word = first_word(names);
            files.emplace_back(word);
            names = trimmed(names.substr(word.size()));
        }
    }
    for (const std::string& file : files) {
        if (!is_there(file)) continue;
        const InputFile input(path_of(file));
        const std::string_view text = as_text(input.bytes());
        with_lines(text, path_of(file), [&] { read_materials(text, materials); });
    }
}

// Faces from `first_face` on take the colour of the material in use.
class Painter {
public:
    Painter(const std::vector<Piece>& pieces, const std::optional<std::string>& folder)
    {
        if (!folder) return;
        for (const Piece& piece : pieces)
            for (const std::string_view names : piece.libraries)
                read_libraries(names, *folder, materials_);
    }

    // `n_before` faces come before those of the piece.
    void paint(const Piece& piece, std::size_t n_before, std::vector<Rgba>& colors)
    {
        if (materials_.empty()) return;
        for (const MaterialUse& use : piece.materials) {
            fill(n_before + use.first_face, colors);
            const auto at = materials_.find(use.name);
            color_ = at != materials_.end() ? at->second : Rgba{};
            painted_ |= at != materials_.end();
        }
        fill(n_before + piece.faces.size(), colors);
    }

    bool has_painted() const { return painted_; }

private:
    void fill(std::size_t end, std::vector<Rgba>& colors) const { colors.resize(end, color_); }

    Materials materials_;
    Rgba color_;
    bool painted_ = false;
};

RawMesh join(const std::vector<std::string_view>& texts, std::vector<Piece>& pieces,
             const std::optional<std::string>& folder)
{
    Painter painter(pieces, folder);
    std::size_t n_vertices = 0;
    std::size_t n_faces = 0;
    for (const Piece& piece : pieces) {
        n_vertices += piece.vertices.size();
        n_faces += piece.faces.size();
    }
    const auto total = static_cast<std::int64_t>(n_vertices);
    if (total > kMaxIndex) throw TextFault{texts.back().data(), "more than 2^31 - 1 vertices"};
    RawMesh raw;
    raw.vertices.reserve(n_vertices);
    raw.faces.reserve_triangles(n_faces);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        Piece& piece = pieces[i];
        const auto before = static_cast<std::int64_t>(raw.vertices.size());
        // Some index is wrong: reading again with the numbers known finds the first.
        if (piece.largest_index >= total || before + piece.smallest_index < 0)
            PieceReader(texts[i], {before, total}).read();
        for (const std::size_t corner : piece.relative_corners)
            piece.faces.corner(corner) += static_cast<std::int32_t>(before);
        append_vertices(raw, piece);
        painter.paint(piece, raw.faces.size(), raw.face_colors);
        raw.faces.append(piece.faces);
        piece = {};
    }
    if (!painter.has_painted()) raw.face_colors.clear();
    return raw;
}

// ---- writing ----

constexpr std::size_t kGrain = 8192;

char* put_vertex(char* p, const Vec3& v, const Rgba* color)
{
    *p++ = 'v';
    for (std::size_t k = 0; k < 3; ++k) {
        *p++ = ' ';
        p = put_number(p, v[k]);
    }
    if (color != nullptr) {
        // Six digits are enough to find the 8 bits again.
        for (const std::uint8_t channel : {color->r, color->g, color->b}) {
            *p++ = ' ';
            p = put_short_number(p, channel / 255.0);
        }
    }
    *p++ = '\n';
    return p;
}

void write_vertices(Output& output, const std::vector<Vec3>& vertices,
                    const std::vector<Rgba>& colors)
{
    constexpr std::size_t most = 8 * (kNumberChars + 1);
    write_records(output, vertices.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      char* p = block.room(most * (end - begin));
                      for (std::size_t v = begin; v < end; ++v)
                          p = put_vertex(p, vertices[v], colors.empty() ? nullptr : &colors[v]);
                      block.advance_to(p);
                  });
}

char* put_face(char* p, std::span<const std::int32_t> face)
{
    *p++ = 'f';
    for (const std::int32_t v : face) {
        *p++ = ' ';
        p = put_integer(p, std::int64_t{v} + 1);
    }
    *p++ = '\n';
    return p;
}

template <class Face>
void write_faces(Output& output, std::size_t n, const Face& face)
{
    constexpr std::size_t per_corner = 12;
    write_records(output, n, kGrain, [&](std::size_t begin, std::size_t end, TextBlock& block) {
        for (std::size_t f = begin; f < end; ++f)
            block.advance_to(put_face(block.room(per_corner * face(f).size() + 2), face(f)));
    });
}

std::string material_name(const Rgba& color)
{
    constexpr char kDigits[] = "0123456789abcdef";
    std::string name = "color_";
    for (const std::uint8_t channel : {color.r, color.g, color.b, color.a}) {
        name += kDigits[channel >> 4];
        name += kDigits[channel & 15];
    }
    return name;
}

void write_comment(Output& output)
{
    output.write(std::string_view("# written by genus\n"));
}

}  // namespace

bool looks_like_obj(std::string_view text)
{
    return is_statement(first_word(text));
}

RawMesh read_obj(std::span<const std::byte> content, const std::string& name,
                 const std::optional<std::string>& folder)
{
    const std::string_view text = as_text(content);
    return with_lines(text, name, [&] {
        const std::vector<std::string_view> texts = cut_at_lines(text);
        std::vector<Piece> pieces(texts.size());
        parallel_for(texts.size(), 1, [&](std::size_t begin, std::size_t) {
            pieces[begin] = PieceReader(texts[begin], {}).read();
        });
        return join(texts, pieces, folder);
    });
}

void write_obj(Output& output, const MeshFile& file, const std::string& library)
{
    write_comment(output);
    const bool colored = !library.empty() && !file.face_colors.empty();
    if (colored) output.write("mtllib " + library + "\n");
    write_vertices(output, file.mesh.vertices, file.vertex_colors);
    if (!colored)
        return write_faces(output, file.mesh.n_faces(),
                           [&](std::size_t f) { return file.mesh.face(f); });
    constexpr std::size_t per_corner = 12;
    const std::vector<Rgba>& colors = file.face_colors;
    write_records(output, file.mesh.n_faces(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      for (std::size_t f = begin; f < end; ++f) {
                          char* p = block.room(per_corner * file.mesh.face(f).size() + 32);
                          if (f == 0 || colors[f] != colors[f - 1])
                              p = put_text(p, "usemtl " + material_name(colors[f]) + "\n");
                          block.advance_to(put_face(p, file.mesh.face(f)));
                      }
                  });
}

void write_obj_materials(Output& output, const MeshFile& file)
{
    write_comment(output);
    std::map<std::string, Rgba> materials;
    for (const Rgba& color : file.face_colors) materials.try_emplace(material_name(color), color);
    for (const auto& [name, color] : materials) {
        char line[4 * (kNumberChars + 4)];
        char* p = put_text(line, "Kd");
        for (const std::uint8_t channel : {color.r, color.g, color.b}) {
            *p++ = ' ';
            p = put_short_number(p, channel / 255.0);
        }
        p = put_short_number(put_text(p, "\nd "), color.a / 255.0);
        *p++ = '\n';
        output.write("newmtl " + name + "\n");
        output.write(std::span<const char>(line, static_cast<std::size_t>(p - line)));
    }
}

void write_obj(Output& output, const IndexedMesh& mesh)
{
    write_comment(output);
    write_vertices(output, mesh.vertices, {});
    write_faces(output, mesh.n_faces(),
                [&](std::size_t f) { return std::span<const std::int32_t>(mesh.faces[f]); });
}

}  // namespace genus::io
