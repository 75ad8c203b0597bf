#include "genus/io/text_outline.h"

#include <ft2build.h>
#include <hb-ft.h>
#include <hb.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/base/progress.h"

#include FT_FREETYPE_H
#include FT_OUTLINE_H

namespace genus {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostBytes = 100'000;
constexpr std::size_t kMostFonts = 20'000;
constexpr std::size_t kMostPoints = 10'000'000;
constexpr double kPixelsToPoint = 100.0 / 72.0;  // the text language counts 100 pixels to the inch
// Letters are set a little closer than the font has them, and aligned by their height less as much:
// the text language divides these by 1024 where outlines are divided by 1000.
constexpr double kTightness = 1000.0 / 1024.0;
constexpr double kFine = 64.0;  // of a font unit, in which the shaper counts
// For a text that names no font, and for one whose font is not installed.
constexpr const char* kDefaultFamilies[] = {"liberation sans", "dejavu sans", "arial", "helvetica",
                                            "noto sans"};
constexpr const char* kOtherFamilies[] = {"dejavu sans", "liberation sans", "noto sans"};
// Families that stand for others with letters of the same widths or shapes.
constexpr std::pair<const char*, const char*> kStandIns[] = {
    {"arial", "liberation sans"},
    {"helvetica", "liberation sans"},
    {"times new roman", "liberation serif"},
    {"times", "liberation serif"},
    {"courier new", "liberation mono"},
    {"courier", "liberation mono"},
    {"bitstream vera sans", "dejavu sans"},
    {"bitstream vera serif", "dejavu serif"},
    {"bitstream vera sans mono", "dejavu sans mono"},
    {"sans", "dejavu sans"},
    {"sans-serif", "dejavu sans"},
    {"serif", "dejavu serif"},
    {"monospace", "dejavu sans mono"},
};

std::string lower(std::string_view text)
{
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
    return out;
}

struct FreeTypeEnd {
    void operator()(FT_Library library) const { FT_Done_FreeType(library); }
};
struct FaceEnd {
    void operator()(FT_Face face) const { FT_Done_Face(face); }
};
struct BufferEnd {
    void operator()(hb_buffer_t* buffer) const { hb_buffer_destroy(buffer); }
};
struct FontEnd {
    void operator()(hb_font_t* font) const { hb_font_destroy(font); }
};
using Library = std::unique_ptr<std::remove_pointer_t<FT_Library>, FreeTypeEnd>;
using Face = std::unique_ptr<std::remove_pointer_t<FT_Face>, FaceEnd>;
using Buffer = std::unique_ptr<hb_buffer_t, BufferEnd>;
using Font = std::unique_ptr<hb_font_t, FontEnd>;

Library open_library()
{
    FT_Library library = nullptr;
    if (FT_Init_FreeType(&library) != 0) throw InvalidInput("text: FreeType cannot be started");
    return Library(library);
}

struct FontFile {
    std::string path;
    FT_Long index = 0;
    std::string family, style;  // as the font has them
};

std::vector<fs::path> font_folders()
{
    std::vector<fs::path> folders;
    if (const char* listed = std::getenv("GENUS_FONT_PATH")) {
        const std::string text(listed);
        for (std::size_t at = 0; at <= text.size();) {
            const std::size_t end = std::min(text.find(':', at), text.size());
            if (end > at) folders.emplace_back(text.substr(at, end - at));
            at = end + 1;
        }
    }
    if (const char* home = std::getenv("HOME")) {
        folders.push_back(fs::path(home) / ".local/share/fonts");
        folders.push_back(fs::path(home) / ".fonts");
        folders.push_back(fs::path(home) / "Library/Fonts");
    }
    for (const char* folder : {"/usr/share/fonts", "/usr/local/share/fonts", "/Library/Fonts",
                               "/System/Library/Fonts", "C:/Windows/Fonts"})
        folders.emplace_back(folder);
    return folders;
}

// In the order of their paths, so that the choice does not depend on the file system's.
std::vector<fs::path> font_files()
{
    std::vector<fs::path> files;
    for (const fs::path& folder : font_folders()) {
        std::error_code error;
        std::vector<fs::path> found;
        constexpr auto skip = fs::directory_options::skip_permission_denied;
        for (fs::recursive_directory_iterator at(folder, skip, error), end; !error && at != end;
             at.increment(error)) {
            const std::string extension = lower(at->path().extension().string());
            if (extension == ".ttf" || extension == ".otf" || extension == ".ttc")
                found.push_back(at->path());
            if (found.size() >= kMostFonts) break;
        }
        std::sort(found.begin(), found.end());
        files.insert(files.end(), found.begin(), found.end());
    }
    return files;
}

std::vector<FontFile> list_fonts()
{
    const Library library = open_library();
    std::vector<FontFile> fonts;
    for (const fs::path& path : font_files()) {
        FT_Long n_faces = 1;
        for (FT_Long i = 0; i < n_faces && i < 64; ++i) {
            FT_Face raw = nullptr;
            if (FT_New_Face(library.get(), path.string().c_str(), i, &raw) != 0) break;
            const Face face(raw);
            n_faces = raw->num_faces;
            if (!FT_IS_SCALABLE(raw) || raw->family_name == nullptr) continue;
            fonts.push_back({path.string(), i, raw->family_name,
                             raw->style_name == nullptr ? "" : raw->style_name});
        }
    }
    return fonts;
}

// Listed when first asked for.
const std::vector<FontFile>& installed_fonts()
{
    static const std::vector<FontFile> fonts = list_fonts();
    return fonts;
}

struct Wanted {
    std::string family, style;  // in small letters
};

// "Family:style=Bold:other=..." in small letters.
Wanted wanted_font(const std::string& name)
{
    const std::string text = lower(name);
    Wanted wanted;
    wanted.family = text.substr(0, text.find(':'));
    while (!wanted.family.empty() && wanted.family.back() == ' ') wanted.family.pop_back();
    const std::size_t at = text.find("style=");
    if (at != std::string::npos) {
        wanted.style = text.substr(at + 6);
        wanted.style = wanted.style.substr(0, wanted.style.find(':'));
    }
    return wanted;
}

bool is_plain(const std::string& style)
{
    return style.empty() || style == "regular" || style == "book" || style == "roman" ||
           style == "normal";
}

// 2 for the style wanted, 1 for the plain one of the family, 0 for another.
int style_match(const FontFile& font, const Wanted& wanted)
{
    const std::string style = lower(font.style);
    if (style == wanted.style || (is_plain(style) && is_plain(wanted.style))) return 2;
    // Families differ in what they call slanted letters.
    const auto same = [](std::string text) {
        const std::size_t at = text.find("oblique");
        if (at != std::string::npos) text.replace(at, 7, "italic");
        return text;
    };
    if (same(style) == same(wanted.style)) return 2;
    return is_plain(style) ? 1 : 0;
}

const FontFile* best_of_family(const std::string& family, const Wanted& wanted)
{
    const FontFile* best = nullptr;
    int match = -1;
    for (const FontFile& font : installed_fonts())
        if (lower(font.family) == family && style_match(font, wanted) > match) {
            best = &font;
            match = style_match(font, wanted);
        }
    return best;
}

struct Choice {
    const FontFile* font = nullptr;
    bool is_substitute = false;
};

Choice choose_font(const std::string& name)
{
    const Wanted wanted = wanted_font(name);
    if (!wanted.family.empty())
        if (const FontFile* font = best_of_family(wanted.family, wanted)) return {font, false};
    for (const auto& [family, stand_in] : kStandIns)
        if (wanted.family == family)
            if (const FontFile* font = best_of_family(stand_in, wanted)) return {font, false};
    if (!wanted.family.empty())
        for (const char* family : kOtherFamilies)
            if (const FontFile* font = best_of_family(family, wanted)) return {font, true};
    for (const char* family : kDefaultFamilies)
        if (const FontFile* font = best_of_family(family, wanted))
            return {font, !wanted.family.empty()};
    if (installed_fonts().empty())
        throw InvalidInput(
            "text: no font is installed, or GENUS_FONT_PATH does not name its "
            "folder");
    return {&installed_fonts().front(), true};
}

// Collects the rings of an outline in font units, curves as chords.
class OutlineReader {
public:
    OutlineReader(int steps, std::vector<Ring>& rings) : steps_(steps), rings_(rings) {}

    void read(FT_Outline& outline, const Vec2& at)
    {
        shift_ = at;
        const FT_Outline_Funcs functions{move, line, conic, cubic, 0, 0};
        if (FT_Outline_Decompose(&outline, &functions, this) != 0)
            throw InvalidInput("text: an outline of the font is damaged");
        finish();
    }

private:
    static OutlineReader& self(void* data) { return *static_cast<OutlineReader*>(data); }
    Vec2 place(const FT_Vector* p) const
    {
        return shift_ + Vec2{{static_cast<double>(p->x), static_cast<double>(p->y)}};
    }
    static int move(const FT_Vector* to, void* data)
    {
        self(data).finish();
        self(data).ring_.push_back(self(data).place(to));
        return 0;
    }
    static int line(const FT_Vector* to, void* data)
    {
        self(data).ring_.push_back(self(data).place(to));
        return 0;
    }
    static int conic(const FT_Vector* control, const FT_Vector* to, void* data)
    {
        OutlineReader& s = self(data);
        const Vec2 a = s.ring_.back(), b = s.place(control), c = s.place(to);
        for (int i = 1; i <= s.steps_; ++i) {
            const double t = static_cast<double>(i) / s.steps_, u = 1.0 - t;
            s.ring_.push_back(u * u * a + 2.0 * u * t * b + t * t * c);
        }
        return 0;
    }
    static int cubic(const FT_Vector* first, const FT_Vector* second, const FT_Vector* to,
                     void* data)
    {
        OutlineReader& s = self(data);
        const Vec2 a = s.ring_.back(), b = s.place(first), c = s.place(second), d = s.place(to);
        for (int i = 1; i <= s.steps_; ++i) {
            const double t = static_cast<double>(i) / s.steps_, u = 1.0 - t;
            s.ring_.push_back(u * u * u * a + 3.0 * u * u * t * b + 3.0 * u * t * t * c +
                              t * t * t * d);
        }
        return 0;
    }
    void finish()
    {
        if (ring_.size() > 2) rings_.push_back(std::move(ring_));
        ring_.clear();
    }

    int steps_;
    std::vector<Ring>& rings_;
    Ring ring_;
    Vec2 shift_{};
};

// At a pixel to the font unit, so that nothing is rounded.
Font open_shaper(FT_Face face)
{
    if (FT_Set_Pixel_Sizes(face, 0, face->units_per_EM) != 0)
        throw InvalidInput("text: the font has no outlines");
    Font font(hb_ft_font_create_referenced(face));
    hb_ft_font_set_load_flags(font.get(), FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP);
    return font;
}

Buffer shaped(const TextOptions& options, hb_font_t* font)
{
    Buffer buffer(hb_buffer_create());
    hb_buffer_add_utf8(buffer.get(), options.text.data(), static_cast<int>(options.text.size()), 0,
                       static_cast<int>(options.text.size()));
    if (!options.script.empty())
        hb_buffer_set_script(
            buffer.get(),
            hb_script_from_string(options.script.data(), static_cast<int>(options.script.size())));
    hb_buffer_set_language(buffer.get(), hb_language_from_string(options.language.c_str(), -1));
    if (!options.direction.empty())
        hb_buffer_set_direction(buffer.get(),
                                hb_direction_from_string(options.direction.c_str(), -1));
    hb_buffer_guess_segment_properties(buffer.get());
    hb_shape(font, buffer.get(), nullptr, 0);
    return buffer;
}

// Extent of the line in font units, which the alignments go by.
struct Extent {
    double ascend = 0.0, descend = 0.0, width = 0.0;
};

// Where the line starts.
Vec2 start_of(const Extent& extent, const TextOptions& options)
{
    Vec2 start{};
    if (options.halign == "center") start[0] = -0.5 * extent.width;
    if (options.halign == "right") start[0] = -extent.width;
    if (options.valign == "top") start[1] = -extent.ascend;
    if (options.valign == "center") start[1] = -0.5 * (extent.ascend + extent.descend);
    if (options.valign == "bottom") start[1] = -extent.descend;
    return start;
}

double tight(hb_position_t position)
{
    return kTightness * position / kFine;
}

class Typesetter {
public:
    explicit Typesetter(const TextOptions& options)
        : options_(options), choice_(choose_font(options.font)), library_(open_library())
    {
        FT_Face raw = nullptr;
        if (FT_New_Face(library_.get(), choice_.font->path.c_str(), choice_.font->index, &raw) != 0)
            throw InvalidInput("text: the font " + choice_.font->path + " cannot be read");
        face_ = Face(raw);
    }

    TextOutline run()
    {
        const Font font = open_shaper(face_.get());
        const Buffer buffer = shaped(options_, font.get());
        unsigned n = 0, n_positions = 0;
        const hb_glyph_info_t* glyphs = hb_buffer_get_glyph_infos(buffer.get(), &n);
        const hb_glyph_position_t* places =
            hb_buffer_get_glyph_positions(buffer.get(), &n_positions);
        const bool level = HB_DIRECTION_IS_HORIZONTAL(hb_buffer_get_direction(buffer.get()));
        const Vec2 start = start_of(extent(glyphs, places, n, level), options_);

        std::vector<Ring> rings;
        OutlineReader reader(options_.curve_steps, rings);
        Vec2 pen = start;
        for (unsigned i = 0; i < n; ++i) {
            if (i % 256 == 255) current_progress().check();
            if (load(glyphs[i].codepoint)) {
                n_points_ += static_cast<std::size_t>(face_->glyph->outline.n_points);
                if (n_points_ * static_cast<std::size_t>(options_.curve_steps) > kMostPoints)
                    throw InvalidInput("text: outlines of too many points");
                reader.read(face_->glyph->outline,
                            pen + Vec2{{tight(places[i].x_offset), tight(places[i].y_offset)}});
            }
            pen +=
                options_.spacing * Vec2{{tight(places[i].x_advance), tight(places[i].y_advance)}};
        }
        const double scale = options_.size * kPixelsToPoint / std::max<int>(face_->units_per_EM, 1);
        for (Ring& ring : rings)
            for (Vec2& p : ring) p *= scale;
        const std::string name = choice_.font->family + ":style=" + choice_.font->style;
        return {make_region(rings), name, choice_.is_substitute};
    }

private:
    bool load(unsigned glyph)
    {
        constexpr FT_Int32 flags = FT_LOAD_NO_SCALE | FT_LOAD_NO_BITMAP;
        return FT_Load_Glyph(face_.get(), glyph, flags) == 0 &&
               face_->glyph->format == FT_GLYPH_FORMAT_OUTLINE;
    }

    Extent extent(const hb_glyph_info_t* glyphs, const hb_glyph_position_t* places, unsigned n,
                  bool level)
    {
        Extent e;
        for (unsigned i = 0; i < n; ++i) {
            FT_BBox box{};
            if (load(glyphs[i].codepoint)) FT_Outline_Get_CBox(&face_->glyph->outline, &box);
            const double high = kTightness * static_cast<double>(box.yMax);
            const double low = kTightness * static_cast<double>(box.yMin);
            if (level) {
                e.ascend = std::max(e.ascend, high);
                e.descend = std::min(e.descend, low);
                e.width += options_.spacing * tight(places[i].x_advance);
            } else {
                e.ascend = std::max(e.ascend, tight(places[i].y_offset) + high);
                e.descend += options_.spacing * tight(places[i].y_advance);
                e.width = std::max(e.width, kTightness * static_cast<double>(box.xMax));
            }
        }
        return e;
    }

    const TextOptions& options_;
    Choice choice_;
    Library library_;
    Face face_;
    std::size_t n_points_ = 0;
};

}  // namespace

TextOutline text_outline(const TextOptions& options)
{
    require(std::isfinite(options.size), "text: size", options.size, "finite");
    require(std::isfinite(options.spacing), "text: spacing", options.spacing, "finite");
    require(options.curve_steps >= 1 && options.curve_steps <= 10'000, "text: curve_steps",
            options.curve_steps, "from 1 to 10000");
    require(options.text.size() <= kMostBytes, "text: longer than 100,000 bytes");
    if (options.text.empty() || options.size == 0.0) return {};
    return Typesetter(options).run();
}

}  // namespace genus
