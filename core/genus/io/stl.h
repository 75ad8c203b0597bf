#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "genus/io/output_file.h"
#include "genus/io/raw_mesh.h"

namespace genus::io {

/// Whether the size is exactly that of the binary STL file whose header these bytes begin with.
/// No text has such a size: four characters would count 100 million triangles and more. Zero
/// triangles do not count, a header of zeros could be anything.
bool is_binary_stl_size(std::span<const std::byte> content);

/// Whether the text begins with the word solid and soon has a facet or the end of the solid.
bool looks_like_ascii_stl(std::string_view text);

/// Binary: 80 bytes of comment, 4 of the number of triangles, 50 each: normal, three corners as
/// floats, two bytes of attributes. Fewer than 50 bytes behind the last are passed over.
/// ASCII: any number of solids, facets with three or more corners.
/// Which one it is, the size decides, then the word solid followed by plain text: binary files
/// exist whose comment begins with solid. Normals are not read. Equal corners are welded.
/// The binary and ASCII forms are those of [burns1993], section 6.5.
RawMesh read_stl(std::span<const std::byte> content, const std::string& name);

constexpr std::size_t kStlHeaderBytes = 84;
constexpr std::size_t kStlCountOffset = 80;
constexpr std::size_t kStlTriangleBytes = 50;
constexpr std::size_t kAsciiFacetChars = 128 + 12 * 33;

/// A file in pieces: the part before the facets, one facet at p, of kStlTriangleBytes or at most
/// kAsciiFacetChars, returning the place behind it, and the part behind them.
void begin_stl(Output& output, std::size_t n_faces, bool ascii);
char* put_binary_facet(char* p, const Vec3& a, const Vec3& b, const Vec3& c);
char* put_ascii_facet(char* p, const Vec3& a, const Vec3& b, const Vec3& c);
void end_stl(Output& output, bool ascii);

/// Positions are rounded to floats in the binary form, kept in the ASCII form. Normals are those
/// of the triangles as written, zero for a degenerate one. Throws FileError where a coordinate
/// is too large for a float or there are more than 2^32 - 1 triangles.
void write_stl(Output& output, const IndexedMesh& mesh, bool ascii);

}  // namespace genus::io
