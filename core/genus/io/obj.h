#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "genus/io/output_file.h"
#include "genus/io/raw_mesh.h"

namespace genus::io {

/// Whether the first word is a statement of the OBJ format.
bool looks_like_obj(std::string_view text);

/// Reads `v` and `f` statements, as in [wavefront1995]: lines, comments, continued lines, corners
/// of the forms v, v/vt, v//vn and v/vt/vn, indices from 1 up or from -1 (the last vertex) down.
/// `v x y z r g b` gives a colour, by a custom of many programs. A face may name vertices that
/// come later in the file. Faces take the diffuse colour of their material, Kd and d, from
/// libraries in `folder`: one that is missing there, or would lie elsewhere, gives no colours, as
/// OBJ files often travel alone. Other statements of the format are passed over; a word that is
/// none is an error.
RawMesh read_obj(std::span<const std::byte> content, const std::string& name,
                 const std::optional<std::string>& folder);

/// Positions as the shortest text that reads back the same. Colours of faces become materials of
/// the library `library`, a file name for write_obj_materials; without one they are left out.
void write_obj(Output& output, const MeshFile& file, const std::string& library = {});
void write_obj_materials(Output& output, const MeshFile& file);
void write_obj(Output& output, const IndexedMesh& mesh);

}  // namespace genus::io
