#pragma once

#include <string>
#include <vector>

#include "genus/patch/tessellate.h"

namespace genus {

/// Reads Bezier patches from text, the format in which the teapot goes round: the number of
/// patches; then for each a line "m n" with its degrees and (m + 1) (n + 1) lines "x y z", v
/// running fastest. Two additions: a line with one degree "n" begins a triangle patch of
/// (n + 1) (n + 2) / 2 points in the order of BezierTriangle, and points of four numbers
/// "x y z w" make a patch rational, w being the weight. '#' begins a comment.
///
/// Throws FileError with the line of what is missing, malformed, out of range or left over.
/// Nothing is allocated for points that the file is too short to hold. O(bytes).
std::vector<Patch> read_patches(const std::string& path);
/// The same from text; `name` is what messages call it.
std::vector<Patch> parse_patches(const std::string& text, const std::string& name);

/// Writes that format, with numbers that read back the same; the file appears whole or not at all.
/// Throws FileError.
void write_patches(const std::string& path, const std::vector<Patch>& patches);

}  // namespace genus
