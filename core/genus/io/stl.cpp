#include "genus/io/stl.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/io/number_format.h"
#include "genus/io/pack.h"
#include "genus/io/text.h"
#include "genus/io/weld.h"

namespace genus::io {

namespace {

constexpr std::size_t kHeaderBytes = kStlHeaderBytes;
constexpr std::size_t kCountOffset = kStlCountOffset;
constexpr std::size_t kTriangleBytes = kStlTriangleBytes;
constexpr std::size_t kNormalBytes = 12;
constexpr std::size_t kChunkBytes = std::size_t{1} << 20;  // of text read by one thread at a time
constexpr std::size_t kLookBytes = 1024;                   // of a file, to tell text from binary

constexpr char kNoVertices[] = "has more different vertices than 32-bit indices can number";

std::size_t triangle_count(std::span<const std::byte> content)
{
    return load<std::uint32_t>(content.data() + kCountOffset, std::endian::little);
}

bool has_control_bytes(std::string_view text)
{
    return std::any_of(text.begin(), text.end(),
                       [](char c) { return static_cast<unsigned char>(c) < 0x20 && !is_space(c); });
}

bool equals_word(const char* p, std::string_view word)
{
    for (std::size_t i = 0; i < word.size(); ++i)
        if (to_lower(p[i]) != word[i]) return false;
    return true;
}

bool begins_with_solid(std::string_view text)
{
    const auto start = std::find_if_not(text.begin(), text.end(), is_space);
    return text.end() - start >= 5 && equals_word(&*start, "solid");
}

// ---- binary ----

RawMesh read_binary(std::span<const std::byte> content, const std::string& name)
{
    if (content.size() < kHeaderBytes)
        throw FileError(name, "is too short for a binary STL file, and ASCII begins with 'solid'",
                        FileError::at_byte(static_cast<std::int64_t>(content.size())));
    const std::size_t n = triangle_count(content);
    const std::size_t room = (content.size() - kHeaderBytes) / kTriangleBytes;
    if (n != room)
        throw FileError(name,
                        "the STL header counts " + std::to_string(n) +
                            " triangles, but the size of the file is that of " +
                            std::to_string(room),
                        FileError::at_byte(kCountOffset));
    const auto corner_offset = [](std::size_t i) {
        return kHeaderBytes + i / 3 * kTriangleBytes + kNormalBytes + i % 3 * 12;
    };
    bool finite = true;
    const auto corner = [&](std::size_t i) {
        const std::byte* p = content.data() + corner_offset(i);
        Vec3 v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = load<float>(p + 4 * k, std::endian::little);
        finite &= is_finite(v);
        return v;
    };
    RawMesh raw;
    std::vector<Triangle> triangles(n);
    PointTable table(3 * n / kCornersPerVertex);
    if (n > 0 && !number_corners(table, 3 * n, corner, triangles.front().data()))
        throw FileError(name, kNoVertices);
    for (std::size_t i = 0; !finite; ++i)
        if (!is_finite(corner(i)))
            throw FileError(name, "a coordinate is not a finite number",
                            FileError::at_byte(static_cast<std::int64_t>(corner_offset(i))));
    raw.vertices = std::move(table).take_points();
    raw.faces = FaceList(std::move(triangles));
    return raw;
}

// ---- ASCII ----

// The corners of the facets in a piece of text, and how many each has where that is not three.
struct Soup {
    std::vector<Vec3> corners;
    std::vector<std::int32_t> degrees;  // empty while all are 3
    bool inside = false;                // a solid is open at the end
};

// Reads the words of an ASCII STL file. No comments; the rest of a line after solid and endsolid
// is a name.
class AsciiReader {
public:
    AsciiReader(std::string_view text, bool inside) : p_(text.data()), end_(p_ + text.size())
    {
        soup_.inside = inside;
    }

    Soup read()
    {
        while (skip_space()) {
            if (take("facet"))
                read_facet();
            else if (take("endsolid") || (take("end") && take("solid")))
                set_inside(false);
            else if (take("solid"))
                set_inside(true);
            else
                throw TextFault{p_,
                                "expected 'facet' or 'endsolid', found " + shown_word(p_, end_)};
        }
        return std::move(soup_);
    }

private:
    bool skip_space()
    {
        while (p_ != end_ && is_space(*p_)) ++p_;
        return p_ != end_;
    }

    bool take(std::string_view word)
    {
        if (!skip_space()) return false;
        const auto left = static_cast<std::size_t>(end_ - p_);
        if (left < word.size() || !equals_word(p_, word)) return false;
        if (left > word.size() && !is_space(p_[word.size()])) return false;
        p_ += word.size();
        return true;
    }

    void expect(std::string_view word)
    {
        if (take(word)) return;
        const std::string wanted = shown_word(word.data(), word.data() + word.size());
        if (p_ == end_) throw TextFault{p_, "the file ends before " + wanted};
        throw TextFault{p_, "expected " + wanted + ", found " + shown_word(p_, end_)};
    }

    double number()
    {
        if (!skip_space()) throw TextFault{p_, "the file ends before a coordinate"};
        double value = 0.0;
        p_ = parse_number(p_, end_, value);
        if (p_ != end_ && !is_space(*p_))
            throw TextFault{p_, "unexpected " + shown_word(p_, end_) + " after a number"};
        return value;
    }

    void set_inside(bool inside)
    {
        if (soup_.inside == inside)
            throw TextFault{p_, inside ? "'solid' before the last solid has ended"
                                       : "'endsolid' without 'solid'"};
        soup_.inside = inside;
        while (p_ != end_ && !is_newline(*p_)) ++p_;
    }

    void read_facet()
    {
        if (!soup_.inside) throw TextFault{p_, "'facet' outside of a solid"};
        expect("normal");
        for (int i = 0; i < 3; ++i) {  // whatever it is: many programs write nan here
            skip_space();
            while (p_ != end_ && !is_space(*p_)) ++p_;
        }
        expect("outer");
        expect("loop");
        std::int32_t degree = 0;
        for (; take("vertex"); ++degree) {
            Vec3 v;
            for (std::size_t k = 0; k < 3; ++k) v[k] = number();
            soup_.corners.push_back(v);
        }
        if (degree < 3 && p_ != end_)
            throw TextFault{p_, "a facet with " + std::to_string(degree) + " vertices"};
        expect("endloop");
        expect("endfacet");
        count_facet(degree);
    }

    void count_facet(std::int32_t degree)
    {
        if (degree != 3 && soup_.degrees.empty())
            soup_.degrees.assign((soup_.corners.size() - static_cast<std::size_t>(degree)) / 3, 3);
        if (degree != 3 || !soup_.degrees.empty()) soup_.degrees.push_back(degree);
    }

    const char* p_;
    const char* end_;
    Soup soup_;
};

// Begin of the first line from `from` on whose first word is facet; the end where there is none.
std::size_t next_facet_line(std::string_view text, std::size_t from)
{
    while (true) {
        const std::size_t newline = text.find('\n', from);
        if (newline == std::string_view::npos) return text.size();
        from = newline + 1;
        std::size_t word = from;
        while (word < text.size() && is_blank(text[word])) ++word;
        if (text.size() - word >= 5 && equals_word(text.data() + word, "facet")) return from;
    }
}

std::vector<std::size_t> facet_chunks(std::string_view text)
{
    std::vector<std::size_t> starts{0};
    while (starts.back() < text.size())
        starts.push_back(text.size() - starts.back() <= kChunkBytes
                             ? text.size()
                             : next_facet_line(text, starts.back() + kChunkBytes));
    return starts;
}

std::vector<Soup> read_soup(std::string_view text)
{
    const std::vector<std::size_t> starts = facet_chunks(text);
    std::vector<Soup> soup(starts.size() - 1);
    parallel_for(soup.size(), 1, [&](std::size_t begin, std::size_t) {
        const std::string_view piece =
            text.substr(starts[begin], starts[begin + 1] - starts[begin]);
        soup[begin] = AsciiReader(piece, begin > 0).read();
    });
    // Every piece but the first was read as if a solid were open before it.
    for (std::size_t i = 0; i + 1 < soup.size(); ++i)
        if (!soup[i].inside)
            throw TextFault{text.data() + starts[i + 1], "'facet' outside of a solid"};
    if (soup.back().inside)
        throw TextFault{text.data() + text.size(), "the file ends before 'endsolid'"};
    return soup;
}

void add_faces(FaceList& faces, const Soup& piece, const std::vector<std::int32_t>& numbers)
{
    std::size_t corner = 0;
    if (piece.degrees.empty())
        for (; corner < numbers.size(); corner += 3)
            faces.add(Triangle{numbers[corner], numbers[corner + 1], numbers[corner + 2]});
    for (const std::int32_t degree : piece.degrees) {
        faces.add(std::span(numbers).subspan(corner, static_cast<std::size_t>(degree)));
        corner += static_cast<std::size_t>(degree);
    }
}

RawMesh read_ascii(std::string_view text, const std::string& name)
{
    std::vector<Soup> soup = with_lines(text, name, [&] { return read_soup(text); });
    std::size_t n_corners = 0;
    for (const Soup& piece : soup) n_corners += piece.corners.size();
    RawMesh raw;
    raw.faces.reserve_triangles(n_corners / 3);
    PointTable table(n_corners / kCornersPerVertex);
    std::vector<std::int32_t> numbers;
    for (Soup& piece : soup) {
        numbers.resize(piece.corners.size());
        const auto corner = [&](std::size_t i) { return piece.corners[i]; };
        if (!number_corners(table, numbers.size(), corner, numbers.data()))
            throw FileError(name, kNoVertices);
        add_faces(raw.faces, piece, numbers);
        piece = {};
    }
    raw.vertices = std::move(table).take_points();
    return raw;
}

// ---- writing ----

// Zero for a degenerate triangle; most readers take that for "compute it yourself".
Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 n = cross(b - a, c - a);
    const double length = norm(n);
    return length > 0.0 && std::isfinite(length) ? n * (1.0 / length) : Vec3{};
}

void check_fits_floats(const std::vector<Vec3>& vertices, const std::string& name)
{
    constexpr std::size_t grain = 65536;
    parallel_for(vertices.size(), grain, [&](std::size_t begin, std::size_t end) {
        double largest = 0.0;
        for (std::size_t v = begin; v < end; ++v)
            for (const double x : vertices[v].c) largest = std::max(largest, std::abs(x));
        if (std::isinf(static_cast<float>(largest)))
            throw FileError(name,
                            "a coordinate is too large for the 4-byte numbers of binary STL; "
                            "ASCII would hold it");
    });
}

void write_binary(Output& output, const IndexedMesh& mesh)
{
    constexpr std::size_t grain = 4096;
    check_fits_floats(mesh.vertices, output.name());
    begin_stl(output, mesh.n_faces(), false);
    const auto vertex = [&](std::int32_t v) -> const Vec3& {
        return mesh.vertices[static_cast<std::size_t>(v)];
    };
    write_records(
        output, mesh.n_faces(), grain, [&](std::size_t begin, std::size_t end, TextBlock& block) {
            char* p = block.room(kTriangleBytes * (end - begin));
            for (std::size_t f = begin; f < end; ++f) {
                const Triangle& face = mesh.faces[f];
                p = put_binary_facet(p, vertex(face[0]), vertex(face[1]), vertex(face[2]));
            }
            block.advance_to(p);
        });
}

char* put_vector(char* p, const Vec3& v)
{
    for (std::size_t k = 0; k < 3; ++k) {
        *p++ = ' ';
        p = put_number(p, v[k]);
    }
    *p++ = '\n';
    return p;
}

void write_ascii(Output& output, const IndexedMesh& mesh)
{
    constexpr std::size_t grain = 2048;
    begin_stl(output, mesh.n_faces(), true);
    const auto put = [&](char* p, const Triangle& face) {
        const auto vertex = [&](std::size_t k) -> const Vec3& {
            return mesh.vertices[static_cast<std::size_t>(face[k])];
        };
        return put_ascii_facet(p, vertex(0), vertex(1), vertex(2));
    };
    write_records(output, mesh.n_faces(), grain,
                  [&](std::size_t begin, std::size_t end, TextBlock& block) {
                      for (std::size_t f = begin; f < end; ++f)
                          block.advance_to(put(block.room(kAsciiFacetChars), mesh.faces[f]));
                  });
    end_stl(output, true);
}

}  // namespace

void begin_stl(Output& output, std::size_t n_faces, bool ascii)
{
    if (ascii) return output.write(std::string_view("solid genus\n"));
    constexpr std::string_view comment = "binary STL, written by genus";  // must not be "solid"
    if (n_faces > std::numeric_limits<std::uint32_t>::max())
        throw FileError(output.name(), "binary STL cannot count so many triangles");
    char header[kHeaderBytes] = {};
    std::copy(comment.begin(), comment.end(), header);
    store(header + kCountOffset, static_cast<std::uint32_t>(n_faces), std::endian::little);
    output.write(header);
}

char* put_binary_facet(char* p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const float corners[9] = {
        static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2]),
        static_cast<float>(b[0]), static_cast<float>(b[1]), static_cast<float>(b[2]),
        static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
    const auto side = [&](std::size_t from, std::size_t to) {
        Vec3 d;
        for (std::size_t k = 0; k < 3; ++k)
            d[k] = static_cast<double>(corners[to + k]) - static_cast<double>(corners[from + k]);
        return d;
    };
    // Neither a product nor a sum of products of floats leaves the range of doubles.
    const Vec3 normal = cross(side(0, 3), side(0, 6));
    const double square = dot(normal, normal);
    const double scale = square > 0.0 ? 1.0 / std::sqrt(square) : 0.0;
    for (std::size_t k = 0; k < 3; ++k)
        p = store(p, static_cast<float>(normal[k] * scale), std::endian::little);
    for (const float x : corners) p = store(p, x, std::endian::little);
    return store(p, std::uint16_t{0}, std::endian::little);
}

char* put_ascii_facet(char* p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    static_assert(kAsciiFacetChars >= 128 + 12 * (kNumberChars + 1));
    p = put_text(p, "facet normal");
    p = put_vector(p, unit_normal(a, b, c));
    p = put_text(p, " outer loop\n");
    for (const Vec3* v : {&a, &b, &c}) p = put_vector(put_text(p, "  vertex"), *v);
    return put_text(p, " endloop\nendfacet\n");
}

void end_stl(Output& output, bool ascii)
{
    if (ascii) output.write(std::string_view("endsolid genus\n"));
}

bool is_binary_stl_size(std::span<const std::byte> content)
{
    if (content.size() <= kHeaderBytes) return false;
    const std::size_t n = triangle_count(content);
    return n > 0 && content.size() == kHeaderBytes + n * kTriangleBytes;
}

bool looks_like_ascii_stl(std::string_view text)
{
    const std::string_view start = text.substr(0, kLookBytes);
    if (!begins_with_solid(start) || has_control_bytes(start)) return false;
    std::string lower(start);
    for (char& c : lower) c = to_lower(c);
    return lower.find("facet") != std::string::npos || lower.find("endsolid") != std::string::npos;
}

RawMesh read_stl(std::span<const std::byte> content, const std::string& name)
{
    const std::string_view text = as_text(content);
    const bool ascii = !is_binary_stl_size(content) && begins_with_solid(text) &&
                       !has_control_bytes(text.substr(0, kLookBytes));
    return ascii ? read_ascii(text, name) : read_binary(content, name);
}

void write_stl(Output& output, const IndexedMesh& mesh, bool ascii)
{
    if (ascii)
        write_ascii(output, mesh);
    else
        write_binary(output, mesh);
}

}  // namespace genus::io
