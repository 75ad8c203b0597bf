#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "genus/patch/tessellate.h"

// The formats of patch_file.h other than its own, internal to io. Readers throw TextFault.
namespace genus::io {

/// Newell's form of the teapot: patches of sixteen numbers of points, then the points, with commas
/// or blanks between.
std::vector<Patch> read_newell(std::string_view text);
/// True if the second line that is not empty has commas.
bool is_newell(std::string_view text);

/// Patches of BezierView: kinds 3, 4, 5, and 9 and 10 without their normals.
std::vector<Patch> read_bezier_view(std::string_view text);
std::string bezier_view_text(const std::vector<Patch>& patches);

/// Patches of Geomview, [ST]BBP and [C]BEZ<u><v><3 or 4>[_ST].
std::vector<Patch> read_geomview(std::string_view text);
bool is_geomview(std::string_view text);
std::string geomview_text(const std::vector<Patch>& patches);

/// Bezier and B-spline surfaces of a Wavefront OBJ file, rational ones too, piece by piece.
std::vector<Patch> read_obj_surfaces(std::string_view text);
std::string obj_surfaces_text(const std::vector<Patch>& patches);

/// Where the control points of a tensor patch stand in `points()`, in the order of formats where u
/// runs fastest.
std::vector<std::size_t> u_fastest(int degree_u, int degree_v);

/// "x y z", numbers that read back the same.
std::string to_text(const Vec3& p);

/// Throws InvalidInput: `write_patches: patch 3 ` and why its format has no way to say it.
[[noreturn]] void cannot_write(std::size_t number, const std::string& why);

}  // namespace genus::io
