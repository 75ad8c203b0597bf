#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace genus::io {

/// A picture with 8 bits a channel, rows from the top.
struct Picture {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint8_t> rgb;  // three a pixel
};

bool is_png(std::span<const std::byte> content);

/// Reads the Portable Network Graphics format, of every colour type, depth and interlace method;
/// 16-bit channels lose their lower byte, transparency is left out. Throws FileError with the byte
/// of what is wrong, for more than 25 million pixels, and where genus was built without zlib.
Picture read_png(std::span<const std::byte> content, const std::string& name);

}  // namespace genus::io
