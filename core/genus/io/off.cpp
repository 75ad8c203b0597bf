#include "genus/io/off.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/number_format.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

constexpr std::int64_t kMaxIndex = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kRowsPerCheck = 16384;

// The shortest texts: "0 0 0" and a space, "3 0 0 0" and a space.
constexpr std::int64_t kVertexChars = 6;
constexpr std::int64_t kFaceChars = 8;

struct Header {
    bool texture = false;
    bool colors = false;
    bool normals = false;
};

class Reader {
public:
    explicit Reader(std::string_view text) : cursor_(text) {}

    RawMesh read()
    {
        read_header();
        read_counts();
        read_vertices();
        read_faces();
        cursor_.skip_space();
        if (!cursor_.at_end())
            throw TextFault{cursor_.p, "unexpected " + shown_word(cursor_.p, cursor_.end) +
                                           " after the last face"};
        return std::move(raw_);
    }

private:
    void read_header()
    {
        cursor_.skip_space();
        const char* start = cursor_.p;
        std::string_view word = cursor_.word();
        if (!word.ends_with("OFF")) {
            cursor_.p = start;  // the word may be left out
            return;
        }
        header_.texture = take(word, "ST");
        header_.colors = take(word, "C");
        header_.normals = take(word, "N");
        if (take(word, "4") || take(word, "n"))
            throw TextFault{start, "OFF files of other than three dimensions are not read"};
        if (word != "OFF")
            throw TextFault{start, shown_word(start, cursor_.end) + " is no OFF header"};
        cursor_.skip_blanks();
        if (std::string_view(cursor_.p, cursor_.end).starts_with("BINARY"))
            throw TextFault{cursor_.p, "binary OFF files are not read"};
    }

    static bool take(std::string_view& word, std::string_view prefix)
    {
        if (!word.starts_with(prefix)) return false;
        word.remove_prefix(prefix.size());
        return true;
    }

    void read_counts()
    {
        n_vertices_ = read_count("the number of vertices");
        n_faces_ = read_count("the number of faces");
        cursor_.skip_blanks();
        // The number of edges is not used, and some programs leave it out.
        if (!cursor_.at_line_end()) cursor_.integer("the number of edges");
        const std::int64_t left = cursor_.end - cursor_.p + 1;
        if (n_vertices_ > left / kVertexChars || n_faces_ > left / kFaceChars ||
            n_vertices_ * kVertexChars + n_faces_ * kFaceChars > left)
            throw TextFault{cursor_.p, "the file is too short for " + std::to_string(n_vertices_) +
                                           " vertices and " + std::to_string(n_faces_) + " faces"};
        if (n_vertices_ > kMaxIndex) throw TextFault{cursor_.p, "more than 2^31 - 1 vertices"};
    }

    std::int64_t read_count(const char* what)
    {
        cursor_.skip_space();
        const char* start = cursor_.p;
        const std::int64_t count = cursor_.integer(what);
        if (count < 0) throw TextFault{start, std::string(what) + " is negative"};
        return count;
    }

    void read_vertices()
    {
        raw_.vertices.reserve(static_cast<std::size_t>(n_vertices_));
        for (std::size_t v = 0; v < static_cast<std::size_t>(n_vertices_); ++v) {
            if (v % kRowsPerCheck == 0) current_progress().check();
            Vec3 position;
            for (std::size_t k = 0; k < 3; ++k) position[k] = cursor_.number("a coordinate");
            if (header_.normals)
                for (int k = 0; k < 3; ++k) cursor_.number("a normal");
            if (header_.colors) add_color(raw_.vertex_colors, v, read_vertex_color());
            raw_.vertices.push_back(position);
            if (header_.texture) skip_line();
        }
    }

    // Three or four channels, integers up to 255 or fractions of 1; how many there are, the end of
    // the line says, as in faces.
    Rgba read_vertex_color()
    {
        const char* start = cursor_.p;
        const std::size_t n = read_channels(header_.texture ? 4 : kMaxChannels);
        if (n != 3 && n != 4) throw TextFault{start, "a colour needs three or four numbers"};
        return channels_color(n);
    }

    // Numbers up to the end of the line, at most `most`.
    std::size_t read_channels(std::size_t most)
    {
        std::size_t n = 0;
        fractions_ = false;
        for (cursor_.skip_blanks(); !cursor_.at_line_end() && n < most; cursor_.skip_blanks()) {
            const char* start = cursor_.p;
            channels_[n++] = cursor_.number("a colour");
            fractions_ |= std::find(start, cursor_.p, '.') != cursor_.p;
        }
        return n;
    }

    Rgba channels_color(std::size_t n) const
    {
        const double scale = fractions_ ? 255.0 : 1.0;
        std::uint8_t c[4] = {255, 255, 255, 255};
        for (std::size_t i = 0; i < n; ++i)
            c[i] = static_cast<std::uint8_t>(
                std::lround(std::clamp(scale * channels_[i], 0.0, 255.0)));
        return {c[0], c[1], c[2], c[3]};
    }

    void skip_line()
    {
        while (!cursor_.at_line_end()) ++cursor_.p;
    }

    void read_faces()
    {
        raw_.faces.reserve_triangles(static_cast<std::size_t>(n_faces_));
        for (std::size_t f = 0; f < static_cast<std::size_t>(n_faces_); ++f) {
            if (f % kRowsPerCheck == 0) current_progress().check();
            read_face();
            read_face_color(f);
        }
    }

    void read_face()
    {
        cursor_.skip_space();
        const char* start = cursor_.p;
        const std::int64_t degree = cursor_.integer("a face");
        if (degree < 3)
            throw TextFault{start, "a face with " + std::to_string(degree) + " corners"};
        if (degree > (cursor_.end - cursor_.p + 1) / 2)
            throw TextFault{start, "the file is too short for a face with " +
                                       std::to_string(degree) + " corners"};
        if (degree == 3) {
            Triangle face;
            for (std::int32_t& corner : face) corner = read_corner();
            raw_.faces.add(face);
            return;
        }
        polygon_.clear();
        for (std::int64_t i = 0; i < degree; ++i) polygon_.push_back(read_corner());
        raw_.faces.add(polygon_);
    }

    std::int32_t read_corner()
    {
        cursor_.skip_space();
        const char* start = cursor_.p;
        const std::int64_t index = cursor_.integer("a corner");
        if (index < 0 || index >= n_vertices_)
            throw TextFault{start, "there is no vertex " + shown_word(start, cursor_.end)};
        return static_cast<std::int32_t>(index);
    }

    void read_face_color(std::size_t f)
    {
        cursor_.skip_blanks();
        if (cursor_.at_line_end()) return;
        const char* start = cursor_.p;
        const std::size_t n = read_channels(kMaxChannels);
        if (n == 3 || n == 4)
            add_color(raw_.face_colors, f, channels_color(n));
        else if (n > 4)
            throw TextFault{start, "a colour needs three or four numbers"};
    }

    static constexpr std::size_t kMaxChannels = 5;  // one too many, so that it is noticed

    TextCursor cursor_;
    Header header_;
    std::int64_t n_vertices_ = 0;
    std::int64_t n_faces_ = 0;
    double channels_[kMaxChannels] = {};
    bool fractions_ = false;
    std::vector<std::int32_t> polygon_;
    RawMesh raw_;
};

// ---- writing ----

constexpr std::size_t kGrain = 8192;
constexpr std::size_t kColorChars = 20;

char* put_color(char* p, const Rgba& color)
{
    for (const std::uint8_t channel : {color.r, color.g, color.b, color.a}) {
        *p++ = ' ';
        p = put_integer(p, channel);
    }
    return p;
}

void write_header(Output& output, std::size_t n_vertices, std::size_t n_faces, bool colors)
{
    output.write(std::string(colors ? "COFF\n" : "OFF\n") + std::to_string(n_vertices) + " " +
                 std::to_string(n_faces) + " 0\n");
}

void write_vertices(Output& output, const std::vector<Vec3>& vertices,
                    const std::vector<Rgba>& colors)
{
    constexpr std::size_t most = 3 * (kNumberChars + 1) + kColorChars + 1;
    write_records(output, vertices.size(), kGrain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      char* p = block.room(most * (end - begin));
                      for (std::size_t v = begin; v < end; ++v) {
                          for (std::size_t k = 0; k < 3; ++k) {
                              p = put_number(p, vertices[v][k]);
                              *p++ = k < 2 ? ' ' : '\n';
                          }
                          if (colors.empty()) continue;
                          p = put_color(p - 1, colors[v]);
                          *p++ = '\n';
                      }
                      block.advance_to(p);
                  });
}

template <class Face>
void write_faces(Output& output, std::size_t n, const Face& face, const std::vector<Rgba>& colors)
{
    constexpr std::size_t per_corner = 12;
    write_records(output, n, kGrain, [&](std::size_t begin, std::size_t end, TextBlock& block) {
        for (std::size_t f = begin; f < end; ++f) {
            const std::span<const std::int32_t> corners = face(f);
            char* p = block.room(per_corner * (corners.size() + 1) + kColorChars);
            p = put_integer(p, static_cast<std::int64_t>(corners.size()));
            for (const std::int32_t v : corners) {
                *p++ = ' ';
                p = put_integer(p, v);
            }
            if (!colors.empty()) p = put_color(p, colors[f]);
            *p++ = '\n';
            block.advance_to(p);
        }
    });
}

}  // namespace

RawMesh read_off(std::span<const std::byte> content, const std::string& name)
{
    const std::string_view text = as_text(content);
    return with_lines(text, name, [&] { return Reader(text).read(); });
}

void write_off(Output& output, const MeshFile& file)
{
    write_header(output, file.mesh.n_vertices(), file.mesh.n_faces(), !file.vertex_colors.empty());
    write_vertices(output, file.mesh.vertices, file.vertex_colors);
    write_faces(
        output, file.mesh.n_faces(), [&](std::size_t f) { return file.mesh.face(f); },
        file.face_colors);
}

void write_off(Output& output, const IndexedMesh& mesh)
{
    write_header(output, mesh.n_vertices(), mesh.n_faces(), false);
    write_vertices(output, mesh.vertices, {});
    write_faces(output, mesh.n_faces(),
                [&](std::size_t f) { return std::span<const std::int32_t>(mesh.faces[f]); }, {});
}

}  // namespace genus::io
