#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// The mesh formats this library reads and writes.
enum class MeshFormat { stl, obj, off, ply, glb, gltf, three_mf, amf };

/// "stl", "obj", ...; the extension of its files.
const char* format_name(MeshFormat format);

/// The format that the extension of `path` stands for, in either case; nothing where it is none
/// of ours.
std::optional<MeshFormat> format_of_extension(std::string_view path);

/// The format that the first bytes of a file give away, nothing where they do not: the words ply
/// and OFF, the size of a binary STL file, "solid" followed by a facet.
std::optional<MeshFormat> format_of_content(std::span<const std::byte> content);

/// A colour with 8 bits a channel; opaque white when new.
struct Rgba {
    std::uint8_t r = 255;
    std::uint8_t g = 255;
    std::uint8_t b = 255;
    std::uint8_t a = 255;

    bool operator==(const Rgba&) const = default;
};

/// What a mesh file holds. Each list of colours is empty or has one entry per vertex or face.
/// Colours are sRGB.
struct MeshFile {
    PolygonMesh mesh;
    std::vector<Rgba> vertex_colors;
    std::vector<Rgba> face_colors;
    /// Length of one unit in millimetres; 0 where the file does not say.
    double unit = 0.0;

    bool operator==(const MeshFile&) const = default;
};

}  // namespace genus
