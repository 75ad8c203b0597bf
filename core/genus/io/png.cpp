#include "genus/io/png.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/pack.h"

namespace genus::io {

namespace {

constexpr std::uint64_t kMostPixels = 25'000'000;
constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

constexpr std::uint32_t tag(const char (&name)[5])
{
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(name[i]);
    return value;
}

class PngReader {
public:
    PngReader(std::span<const std::byte> content, const std::string& name)
        : content_(content), name_(name)
    {
    }

    Picture run()
    {
        read_chunks();
        if (packed_.empty()) fail(at_, "a PNG file without picture data");
        Picture picture;
        picture.width = width_;
        picture.height = height_;
        picture.rgb.assign(std::size_t{3} * width_ * height_, 0);
        const std::vector<std::uint8_t> raw = unpacked();
        std::size_t from = 0;
        if (!interlaced_) {
            read_pass(raw, from, {0, 0, 1, 1}, picture);
            return picture;
        }
        static constexpr Pass passes[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                          {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
        for (const Pass& pass : passes) read_pass(raw, from, pass, picture);
        return picture;
    }

private:
    // Every dx-th pixel of every dy-th row.
    struct Pass {
        std::uint32_t x, y, dx, dy;
        std::uint32_t columns(std::uint32_t width) const
        {
            return width > x ? (width - x + dx - 1) / dx : 0;
        }
        std::uint32_t rows(std::uint32_t height) const
        {
            return height > y ? (height - y + dy - 1) / dy : 0;
        }
    };

    [[noreturn]] void fail(std::size_t byte, const std::string& problem) const
    {
        throw FileError(name_, problem, FileError::at_byte(static_cast<std::int64_t>(byte)));
    }

    void read_chunks()
    {
        at_ = kSignature.size();
        bool first = true;
        while (true) {
            if (content_.size() - at_ < 12) fail(at_, "the PNG file is cut short");
            const std::size_t start = at_;
            const auto size = load<std::uint32_t>(content_.data() + at_, std::endian::big);
            const auto kind = load<std::uint32_t>(content_.data() + at_ + 4, std::endian::big);
            if (size > content_.size() - at_ - 12) fail(at_, "the PNG file is cut short");
            const std::span<const std::byte> data = content_.subspan(at_ + 8, size);
            at_ += std::size_t{12} + size;
            if (first != (kind == tag("IHDR")))
                fail(start, "PNG: the header is not the first part");
            first = false;
            if (kind == tag("IHDR")) read_header(data, start);
            if (kind == tag("PLTE")) palette_.assign(data.begin(), data.end());
            if (kind == tag("IDAT")) packed_.insert(packed_.end(), data.begin(), data.end());
            if (kind == tag("IEND")) return;
        }
    }

    void read_header(std::span<const std::byte> data, std::size_t start)
    {
        if (data.size() != 13) fail(start, "PNG: a header of the wrong size");
        width_ = load<std::uint32_t>(data.data(), std::endian::big);
        height_ = load<std::uint32_t>(data.data() + 4, std::endian::big);
        depth_ = std::to_integer<unsigned>(data[8]);
        color_ = std::to_integer<unsigned>(data[9]);
        const auto interlace = std::to_integer<unsigned>(data[12]);
        interlaced_ = interlace == 1;
        static constexpr std::array<unsigned, 7> channels{1, 0, 3, 1, 2, 0, 4};
        channels_ = color_ < channels.size() ? channels[color_] : 0;
        const bool small = depth_ == 1 || depth_ == 2 || depth_ == 4;
        const bool depth_good =
            depth_ == 8 || (depth_ == 16 && color_ != 3) || (small && (color_ == 0 || color_ == 3));
        if (channels_ == 0 || !depth_good || interlace > 1 || data[10] != std::byte{0} ||
            data[11] != std::byte{0})
            fail(start, "PNG: no known kind of picture");
        if (width_ == 0 || height_ == 0) fail(start, "PNG: a picture without pixels");
        if (std::uint64_t{width_} * height_ > kMostPixels)
            fail(start, "PNG: more than 25 million pixels");
    }

    std::size_t row_bytes(std::uint32_t columns) const
    {
        return (std::size_t{columns} * channels_ * depth_ + 7) / 8;
    }

    // Exactly as many bytes as the passes need; a stream that gives more or less is refused.
    std::vector<std::uint8_t> unpacked() const
    {
        std::size_t needed = (row_bytes(width_) + 1) * height_;
        if (interlaced_) needed += std::size_t{7} * (width_ + height_ + 16) * channels_ * 2;
        std::vector<std::uint8_t> raw(needed);
        z_stream stream{};
        if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
        stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed_.data()));
        stream.avail_in = static_cast<uInt>(packed_.size());
        stream.next_out = raw.data();
        stream.avail_out = static_cast<uInt>(raw.size());
        const int status = inflate(&stream, Z_FINISH);
        const std::size_t made = raw.size() - stream.avail_out;
        inflateEnd(&stream);
        if (status != Z_STREAM_END && !(status == Z_BUF_ERROR && made == raw.size()))
            fail(content_.size(), "PNG: the picture data are damaged");
        raw.resize(made);
        return raw;
    }

    void read_pass(const std::vector<std::uint8_t>& raw, std::size_t& from, const Pass& pass,
                   Picture& picture) const
    {
        const std::uint32_t columns = pass.columns(width_), rows = pass.rows(height_);
        if (columns == 0 || rows == 0) return;
        const std::size_t bytes = row_bytes(columns);
        const std::size_t step = std::max<std::size_t>(1, channels_ * depth_ / 8);
        std::vector<std::uint8_t> above(bytes, 0), row(bytes);
        for (std::uint32_t r = 0; r < rows; ++r) {
            if (r % 256 == 255) current_progress().check();
            if (raw.size() - from < bytes + 1)
                fail(content_.size(), "PNG: the picture data are cut short");
            const std::uint8_t filter = raw[from++];
            if (filter > 4) fail(content_.size(), "PNG: unknown filter of a row");
            for (std::size_t i = 0; i < bytes; ++i) {
                const int a = i >= step ? row[i - step] : 0, b = above[i];
                const int c = i >= step ? above[i - step] : 0;
                row[i] = static_cast<std::uint8_t>(raw[from + i] + predicted(filter, a, b, c));
            }
            from += bytes;
            for (std::uint32_t k = 0; k < columns; ++k)
                put_pixel(row, k, pass.x + k * pass.dx, pass.y + r * pass.dy, picture);
            std::swap(row, above);
        }
    }

    static int predicted(std::uint8_t filter, int a, int b, int c)
    {
        switch (filter) {
            case 1:
                return a;
            case 2:
                return b;
            case 3:
                return (a + b) / 2;
            case 4: {
                const int p = a + b - c;
                const int pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
                return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
            }
            default:
                return 0;
        }
    }

    // Channel of a pixel, as it is stored.
    unsigned sample(const std::vector<std::uint8_t>& row, std::uint32_t pixel,
                    unsigned channel) const
    {
        const std::size_t number = std::size_t{pixel} * channels_ + channel;
        if (depth_ == 8) return row[number];
        if (depth_ == 16) return row[2 * number];
        const std::size_t bit = number * depth_;
        return row[bit / 8] >> (8 - depth_ - bit % 8) & ((1u << depth_) - 1);
    }

    void put_pixel(const std::vector<std::uint8_t>& row, std::uint32_t pixel, std::uint32_t x,
                   std::uint32_t y, Picture& picture) const
    {
        std::uint8_t* out = picture.rgb.data() + 3 * (std::size_t{y} * width_ + x);
        if (color_ == 3) {
            const std::size_t entry = 3 * sample(row, pixel, 0);
            if (entry + 3 > palette_.size())
                fail(content_.size(), "PNG: a colour that is not in the palette");
            for (std::size_t i = 0; i < 3; ++i)
                out[i] = std::to_integer<std::uint8_t>(palette_[entry + i]);
            return;
        }
        const bool grey = color_ == 0 || color_ == 4;
        for (unsigned i = 0; i < 3; ++i) {
            const unsigned value = sample(row, pixel, grey ? 0 : i);
            out[i] =
                static_cast<std::uint8_t>(depth_ < 8 ? value * 255 / ((1u << depth_) - 1) : value);
        }
    }

    std::span<const std::byte> content_;
    const std::string& name_;
    std::size_t at_ = 0;
    std::uint32_t width_ = 0, height_ = 0;
    unsigned depth_ = 0, color_ = 0, channels_ = 0;
    bool interlaced_ = false;
    std::vector<std::byte> palette_, packed_;
};

}  // namespace

bool is_png(std::span<const std::byte> content)
{
    return content.size() >= kSignature.size() &&
           std::equal(kSignature.begin(), kSignature.end(), content.begin(),
                      [](std::uint8_t a, std::byte b) { return std::byte{a} == b; });
}

Picture read_png(std::span<const std::byte> content, const std::string& name)
{
    return PngReader(content, name).run();
}

}  // namespace genus::io
