#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "genus/polygon/region.h"

namespace genus {

/// The formats of plane shapes that this library reads and writes.
enum class RegionFormat { svg, dxf };

/// The format that the extension of `path` stands for, in either case.
std::optional<RegionFormat> region_format_of_extension(std::string_view path);

struct RegionReadOptions {
    std::string layer;    // DXF: only what is on it; empty: everything
    Vec2 origin{};        // DXF: this point of the drawing becomes the origin,
    double scale = 1.0;   // and lengths are multiplied
    bool center = false;  // SVG: the middle of the bounding box becomes the origin
    double dpi = 72.0;    // SVG: user units to the inch where the file gives sizes in none
    /// Sides of a full circle of a radius, in units of the result. Without it, 40, of an arc one
    /// every 18 degrees and four more, of a Bezier curve 20, as in the text language.
    std::function<int(double radius)> sides;
    /// Where given, curves stay within that of their chords; `sides` must do the same.
    std::optional<double> tolerance;
};

/// Reads a plane shape.
///
/// SVG: paths, rectangles, circles, ellipses, lines, polylines, polygons, groups, `use`, with
/// transforms, in millimetres with y upward; the lower edge of the page is at y = 0. An element
/// is filled by the even-odd rule, whatever its paint; open lines stand for their strokes. What is
/// in `defs` or not displayed is left out, as are texts, images and style sheets.
///
/// DXF: lines, light polylines with bulges, polylines, circles, arcs and ellipses, those of
/// inserted blocks too, in units of the drawing. Ends that meet within 1e-6 of the drawing's size
/// are joined to rings, and what stays open is closed by a straight side; all rings together are
/// filled by the even-odd rule.
///
/// Throws FileError with the line for what is not of the format. Formats that need expat (SVG) are
/// refused where genus was built without.
Region read_region(const std::string& path, const RegionReadOptions& options = {});
Region read_svg(std::string_view text, const std::string& name, const RegionReadOptions& options);
Region read_dxf(std::string_view text, const std::string& name, const RegionReadOptions& options);

/// Writes the rings: SVG as one filled path in millimetres, y upward, on a page that is the
/// bounding box; DXF as lines, which read back with the same bits. The file appears whole or not at
/// all.
void write_region(const std::string& path, const Region& region);

/// A measure or crossing that a DXF drawing holds for the text language: of the dimension with
/// this text on the layer, its length or angle (dxf_dim), or where the two lines of the layer cross
/// (dxf_cross). Nothing where there is none.
std::optional<double> dxf_dimension(std::string_view text, const std::string& name,
                                    const std::string& layer, const std::string& label,
                                    const Vec2& origin, double scale);
std::optional<Vec2> dxf_crossing(std::string_view text, const std::string& name,
                                 const std::string& layer, const Vec2& origin, double scale);

namespace io {

/// Points of curves, as the options ask for them.
class CurveSampler {
public:
    /// `scale`: length of a unit of the curve in units of the result.
    CurveSampler(const RegionReadOptions& options, double scale) : options_(options), scale_(scale)
    {
    }
    /// Steps over `turn` degrees of an ellipse with this longer half axis, at least 1.
    int arc_steps(double radius, double turn) const;
    /// Steps of a cubic curve.
    int cubic_steps(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) const;

private:
    const RegionReadOptions& options_;
    double scale_;
};

}  // namespace io
}  // namespace genus
