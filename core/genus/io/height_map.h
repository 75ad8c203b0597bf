#pragma once

#include <string>
#include <vector>

#include "genus/mesh/indexed_mesh.h"

namespace genus {

/// Heights on a grid, row by row from the front (least y) to the back.
struct HeightMap {
    int columns = 0;
    int rows = 0;
    std::vector<double> heights;
    /// Where a solid under them ends: a unit below the lowest of them, and not above 0.
    double floor = 0.0;
};

/// Reads a height map, as the text language does. A PNG picture, of any colour type, gives grey
/// values from 0 to 100, the lower row first; its alpha is left out. `invert` takes from each
/// 100 (1 - g), for its grey g from 0 to 255, over 255. Any other file is a text with a row of
/// numbers a line, the last line first; '#' starts a comment, short rows are filled with zeros.
///
/// Throws FileError with line or byte for what is neither, for more than 25 million values, and
/// for pictures where genus was built without zlib.
HeightMap read_height_map(const std::string& path, bool invert = false);

/// The solid below the heights, in unit steps: each cell four triangles round its middle. Closed;
/// empty for less than two rows or columns. The front left corner, or the middle, is at the origin.
PolygonMesh height_map_mesh(const HeightMap& map, bool center);

}  // namespace genus
