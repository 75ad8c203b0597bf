#include "genus/io/stream.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/number_format.h"
#include "genus/io/output_file.h"
#include "genus/io/pack.h"
#include "genus/io/stl.h"

namespace genus {

namespace {

using io::Output;
using io::TextBlock;
using Points = std::array<Vec3, 3>;

constexpr std::size_t kBlock = std::size_t{1} << 16;  // triangles held at a time
constexpr std::size_t kGrain = 4096;
constexpr std::size_t kNormalBytes = 12;

class BinaryStl {
public:
    explicit BinaryStl(const std::string& path) : path_(path), file_(path, std::ios::binary)
    {
        if (!file_) throw FileError(path, "cannot be read");
        std::array<char, io::kStlHeaderBytes> header{};
        file_.read(header.data(), header.size());
        if (!file_) return;
        n_ = io::load<std::uint32_t>(
            reinterpret_cast<const std::byte*>(header.data()) + io::kStlCountOffset,
            std::endian::little);
        file_.seekg(0, std::ios::end);
        const auto size = static_cast<std::uint64_t>(file_.tellg());
        whole_ = n_ > 0 && size == io::kStlHeaderBytes + n_ * io::kStlTriangleBytes;
    }

    bool is_whole() const { return whole_; }
    std::size_t n_faces() const { return n_; }

    // Calls `use(triangles, number of the first)` block after block.
    void visit(double scale, const char* stage,
               const std::function<void(const std::vector<Points>&, std::size_t)>& use)
    {
        file_.clear();
        file_.seekg(io::kStlHeaderBytes);
        std::vector<char> bytes;
        std::vector<Points> triangles;
        for (std::size_t begin = 0; begin < n_; begin += kBlock) {
            current_progress().report(stage, static_cast<double>(begin) / static_cast<double>(n_));
            triangles.resize(std::min(kBlock, n_ - begin));
            bytes.resize(triangles.size() * io::kStlTriangleBytes);
            file_.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
            if (!file_) throw FileError(path_, "was cut short while it was read");
            for (std::size_t i = 0; i < triangles.size(); ++i)
                unpack(bytes.data() + i * io::kStlTriangleBytes, begin + i, scale, triangles[i]);
            use(triangles, begin);
        }
    }

private:
    void unpack(const char* record, std::size_t number, double scale, Points& triangle) const
    {
        const auto* p = reinterpret_cast<const std::byte*>(record) + kNormalBytes;
        for (std::size_t i = 0; i < 9; ++i) {
            const double x = io::load<float>(p + 4 * i, std::endian::little);
            if (!std::isfinite(x))
                throw FileError(path_, "a coordinate is not a finite number",
                                FileError::at_byte(static_cast<std::int64_t>(
                                    io::kStlHeaderBytes + number * io::kStlTriangleBytes +
                                    kNormalBytes + 4 * i)));
            triangle[i / 3][i % 3] = x * scale;
        }
    }

    std::string path_;
    std::ifstream file_;
    std::size_t n_ = 0;
    bool whole_ = false;
};

// Formats the triangles of a block, `most` characters each at most.
void write_block(Output& output, const std::vector<Points>& triangles, std::size_t most,
                 const std::function<char*(char*, const Points&, std::size_t)>& put)
{
    io::write_records(output, triangles.size(), kGrain,
                      [&](std::size_t begin, std::size_t end, TextBlock& block) {
                          for (std::size_t i = begin; i < end; ++i)
                              block.advance_to(put(block.room(most), triangles[i], i));
                      });
}

void check_fits(const Output& output, const Points& triangle)
{
    for (const Vec3& p : triangle)
        for (const double x : p.c)
            if (std::isinf(static_cast<float>(x)))
                throw FileError(output.name(),
                                "a coordinate is too large for the 4-byte numbers of binary STL; "
                                "ASCII would hold it");
}

void stream_stl(BinaryStl& source, Output& output, bool ascii, double scale)
{
    const auto put_binary = [&](char* p, const Points& t, std::size_t) {
        check_fits(output, t);
        return io::put_binary_facet(p, t[0], t[1], t[2]);
    };
    const auto put_ascii = [](char* p, const Points& t, std::size_t) {
        return io::put_ascii_facet(p, t[0], t[1], t[2]);
    };
    io::begin_stl(output, source.n_faces(), ascii);
    source.visit(scale, "convert", [&](const std::vector<Points>& triangles, std::size_t) {
        if (ascii)
            write_block(output, triangles, io::kAsciiFacetChars, put_ascii);
        else
            write_block(output, triangles, io::kStlTriangleBytes, put_binary);
    });
    io::end_stl(output, ascii);
}

// Three numbers with something before, between and behind them.
template <class Put>
char* put_three(char* p, std::string_view before, const Put& put)
{
    p = io::put_text(p, before);
    for (std::size_t k = 0; k < 3; ++k) {
        if (k > 0) *p++ = ' ';
        p = put(p, k);
    }
    *p++ = '\n';
    return p;
}

constexpr std::size_t kThreeChars = 3 * (io::kNumberChars + 1) + 8;

char* put_points(char* p, std::string_view before, const Points& t)
{
    for (const Vec3& v : t)
        p = put_three(p, before, [&](char* q, std::size_t k) { return io::put_number(q, v[k]); });
    return p;
}

char* put_corners(char* p, std::string_view before, std::size_t first)
{
    return put_three(p, before, [&](char* q, std::size_t k) {
        return io::put_integer(q, static_cast<std::int64_t>(first + k));
    });
}

void stream_obj(BinaryStl& source, Output& output, double scale)
{
    source.visit(scale, "convert", [&](const std::vector<Points>& triangles, std::size_t begin) {
        write_block(output, triangles, 4 * kThreeChars,
                    [&](char* p, const Points& t, std::size_t i) {
                        return put_corners(put_points(p, "v ", t), "f ", 3 * (begin + i) + 1);
                    });
    });
}

// Vertices first, then faces, which are known without the file.
void stream_parts(BinaryStl& source, Output& output, bool ascii, std::string_view corners_before,
                  double scale)
{
    const auto put_vertices = [&](char* p, const Points& t, std::size_t) {
        if (ascii) return put_points(p, "", t);
        for (const Vec3& v : t)
            for (const double x : v.c) p = io::store(p, x, std::endian::little);
        return p;
    };
    source.visit(scale, "vertices", [&](const std::vector<Points>& triangles, std::size_t) {
        write_block(output, triangles, 3 * kThreeChars, put_vertices);
    });
    io::write_records(output, source.n_faces(), kGrain,
                      [&](std::size_t begin, std::size_t end, TextBlock& block) {
                          for (std::size_t f = begin; f < end; ++f) {
                              char* p = block.room(kThreeChars);
                              if (ascii) {
                                  block.advance_to(put_corners(p, corners_before, 3 * f));
                                  continue;
                              }
                              p = io::store(p, std::uint8_t{3}, std::endian::little);
                              for (std::size_t k = 0; k < 3; ++k)
                                  p = io::store(p, static_cast<std::int32_t>(3 * f + k),
                                                std::endian::little);
                              block.advance_to(p);
                          }
                      });
}

void stream_ply(BinaryStl& source, Output& output, bool ascii, double scale)
{
    const std::string n = std::to_string(source.n_faces());
    output.write(std::string("ply\nformat ") + (ascii ? "ascii" : "binary_little_endian") +
                 " 1.0\ncomment written by genus\nelement vertex " +
                 std::to_string(3 * source.n_faces()) +
                 "\nproperty double x\nproperty double y\nproperty double z\nelement face " + n +
                 "\nproperty list uchar int vertex_indices\nend_header\n");
    stream_parts(source, output, ascii, "3 ", scale);
}

void stream_off(BinaryStl& source, Output& output, double scale)
{
    const std::size_t n = source.n_faces();
    output.write("OFF\n" + std::to_string(3 * n) + " " + std::to_string(n) + " 0\n");
    stream_parts(source, output, true, "3 ", scale);
}

MeshFormat target_format(const std::string& target, const WriteOptions& options)
{
    const auto format = options.format ? options.format : format_of_extension(target);
    if (!format) throw FileError(target, "its extension names no mesh format known here");
    return *format;
}

}  // namespace

bool can_stream(const std::string& source, MeshFormat target)
{
    const bool writes = target == MeshFormat::stl || target == MeshFormat::ply ||
                        target == MeshFormat::obj || target == MeshFormat::off;
    return writes && BinaryStl(source).is_whole();
}

StreamCounts stream_mesh(const std::string& source, const std::string& target,
                         const WriteOptions& options, double scale)
{
    require(std::isfinite(scale) && scale > 0.0, "stream_mesh: scale", scale, "positive");
    const MeshFormat format = target_format(target, options);
    BinaryStl input(source);
    if (!input.is_whole() || !can_stream(source, format))
        throw InvalidInput(source + " to " + target +
                           ": only binary STL files to STL, PLY, OBJ or OFF can be streamed");
    constexpr std::size_t kMostVertices = std::numeric_limits<std::int32_t>::max();
    if (format != MeshFormat::stl && 3 * input.n_faces() > kMostVertices)
        throw FileError(source, "has more corners than 32-bit indices can number");
    io::OutputFile output(target);
    if (format == MeshFormat::stl)
        stream_stl(input, output, options.ascii, scale);
    else if (format == MeshFormat::ply)
        stream_ply(input, output, options.ascii, scale);
    else if (format == MeshFormat::obj)
        stream_obj(input, output, scale);
    else
        stream_off(input, output, scale);
    output.commit();
    const auto n = static_cast<std::int64_t>(input.n_faces());
    return {3 * n, n};
}

}  // namespace genus
