#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace genus::io {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

std::size_t size_of(PlyType type);
constexpr bool is_float(PlyType type)
{
    return type == PlyType::float32 || type == PlyType::float64;
}

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::float32;
    bool is_list = false;
    PlyType count_type = PlyType::uint8;  // of a list
};

struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;

    /// Number of the property with one of the names; -1 where there is none.
    int find(std::initializer_list<std::string_view> names) const;
    /// Fewest bytes of a row in a binary file, or fewest characters in ASCII with a space behind.
    std::uint64_t least_row_bytes(bool ascii) const;
};

struct PlyHeader {
    bool ascii = true;
    std::endian order = std::endian::little;  // of a binary file
    std::vector<PlyElement> elements;
    std::size_t size = 0;  // bytes up to the first row

    const PlyElement* find(std::string_view element) const;
};

/// Reads the header at the beginning of `text`. Throws TextFault.
PlyHeader read_ply_header(std::string_view text);

}  // namespace genus::io
