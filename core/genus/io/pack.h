#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace genus::io {

template <std::size_t N>
struct UnsignedOf;
template <>
struct UnsignedOf<1> {
    using type = std::uint8_t;
};
template <>
struct UnsignedOf<2> {
    using type = std::uint16_t;
};
template <>
struct UnsignedOf<4> {
    using type = std::uint32_t;
};
template <>
struct UnsignedOf<8> {
    using type = std::uint64_t;
};

inline std::uint8_t swap_bytes(std::uint8_t x)
{
    return x;
}
inline std::uint16_t swap_bytes(std::uint16_t x)
{
    return __builtin_bswap16(x);
}
inline std::uint32_t swap_bytes(std::uint32_t x)
{
    return __builtin_bswap32(x);
}
inline std::uint64_t swap_bytes(std::uint64_t x)
{
    return __builtin_bswap64(x);
}

/// The number of type T stored at `p`, aligned or not, in the given order of bytes.
template <class T>
T load(const void* p, std::endian order)
{
    using Bits = typename UnsignedOf<sizeof(T)>::type;
    Bits bits;
    std::memcpy(&bits, p, sizeof bits);
    if (order != std::endian::native) bits = swap_bytes(bits);
    return std::bit_cast<T>(bits);
}

/// Stores `value` at `p`; returns the place behind it.
template <class T>
char* store(char* p, T value, std::endian order)
{
    using Bits = typename UnsignedOf<sizeof(T)>::type;
    auto bits = std::bit_cast<Bits>(value);
    if (order != std::endian::native) bits = swap_bytes(bits);
    std::memcpy(p, &bits, sizeof bits);
    return p + sizeof bits;
}

}  // namespace genus::io
