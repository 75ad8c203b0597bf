#pragma once

#include <string>
#include <vector>

#include "genus/patch/tessellate.h"

namespace genus {

/// Reads Bezier patches. The format is told by the content, else by the extension:
///
/// - ".bpt", the form in which the teapot goes round, and any other name: the number of patches;
///   then for each a line "m n" with its degrees and (m + 1) (n + 1) lines "x y z", v running
///   fastest. Two additions: a line with one degree "n" begins a triangle patch of
///   (n + 1) (n + 2) / 2 points in the order of BezierTriangle, and points of four numbers
///   "x y z w" make a patch rational, w being the weight. '#' begins a comment.
/// - Newell's own form, told by its commas: the number of bicubic patches, sixteen numbers of
/// points
///   for each, the number of points, the points.
/// - ".bv", BezierView: kinds 3 (triangles), 4, 5; of 9 and 10 the points without the normals.
/// - Geomview's BBP and BEZ, told by the first word; colours and textures are passed over.
/// - ".obj": Bezier and B-spline surfaces of Wavefront's free-form geometry, rational or not, cut
///   into their pieces. Trimmed surfaces and polygons beside them are refused.
///
/// Throws FileError with the line of what is missing, malformed, out of range or left over.
/// Nothing is allocated for points that the file is too short to hold. O(bytes).
std::vector<Patch> read_patches(const std::string& path);
/// The same from text; `name` is what messages call it, and its extension counts.
std::vector<Patch> parse_patches(const std::string& text, const std::string& name);

/// Writes the format of the extension: ".bv" (no weights), ".bez" or ".bbp" for Geomview (degrees
/// from 1 to 6, all alike), ".obj" (no triangles), else as ".bpt", which has all. Numbers read back
/// the same, but for points of rational patches in Geomview's, which have their weight multiplied
/// in. The file appears whole or not at all. Throws FileError, InvalidInput for a patch that the
/// format cannot hold.
void write_patches(const std::string& path, const std::vector<Patch>& patches);

}  // namespace genus
