#pragma once

#include <string>

#include "genus/polygon/region.h"

namespace genus {

/// A line of text, as the text language describes it.
struct TextOptions {
    std::string text;       // UTF-8
    double size = 10.0;     // about the height of capitals
    std::string font;       // "Family:style=Bold Italic", or empty for Liberation Sans
    double spacing = 1.0;   // factor on the way from letter to letter
    std::string direction;  // ltr, rtl, ttb, btt; empty: as the script goes
    std::string language = "en";
    std::string script;               // four letters, such as Latn; empty: found from the text
    std::string halign = "left";      // left, center, right
    std::string valign = "baseline";  // top, center, baseline, bottom
    int curve_steps = 4;              // chords of each curve of an outline
};

struct TextOutline {
    Region region;
    /// Family and style of the font that was taken; another one than asked for where that is not
    /// installed.
    std::string font;
    bool is_substitute = false;
};

/// The outlines of a text. Letters are chosen and placed by the library HarfBuzz, their outlines
/// read by FreeType; an em is size * 100 / 72 units. Fonts are looked for in the folders that
/// systems keep them in and in those that the environment variable GENUS_FONT_PATH lists; the
/// fonts of these folders are listed once in a program.
///
/// Throws InvalidInput for a size or spacing that is not finite, for texts longer than 100,000
/// bytes, where no font is installed, and where genus was built without FreeType and HarfBuzz.
TextOutline text_outline(const TextOptions& options);

}  // namespace genus
