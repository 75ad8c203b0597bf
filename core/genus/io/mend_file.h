#pragma once

#include <string_view>

#include "genus/io/mesh_file.h"
#include "genus/mesh/repair.h"

namespace genus {

/// Millimetres of a unit by its name or short form: millimeter (mm), centimeter (cm), meter (m),
/// micron (um, micrometer), inch (in), foot (ft, feet). Throws InvalidInput naming them all.
double unit_millimetres(std::string_view name);

/// Multiplies all coordinates.
void scale_file(MeshFile& file, double factor);

/// Welds as `weld` does; faces keep their degree and colour, joined vertices the colour of the one
/// kept. Corners that fall together become one, and faces with fewer than three left go. Returns
/// how many vertices went. Throws as `weld` does.
std::int64_t weld_file(MeshFile& file, double tolerance);

/// Cuts faces into triangles and mends them as `repair` does; colours stay with their vertices and
/// faces, those of faces that close holes are white. Throws as `repair` does.
RepairReport repair_file(MeshFile& file, const RepairOptions& options);

}  // namespace genus
