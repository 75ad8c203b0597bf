#include "genus/io/region_file.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"
#include "genus/io/input_file.h"
#include "genus/io/number_format.h"
#include "genus/io/output_file.h"
#include "genus/io/text.h"

namespace genus {

namespace {

constexpr int kCircleSteps = 40, kCubicSteps = 20;  // as the text language has them
constexpr int kMostSteps = 100'000;

std::string extension_of(std::string_view path)
{
    const std::size_t dot = path.find_last_of("./\\");
    std::string found(dot == std::string_view::npos ? std::string_view() : path.substr(dot));
    for (char& c : found) c = io::to_lower(c);
    return found;
}

RegionFormat known_format(const std::string& path)
{
    if (const auto format = region_format_of_extension(path)) return *format;
    throw FileError(path, "the extension of a file with a plane shape must be svg or dxf");
}

class Writer {
public:
    explicit Writer(std::string& out) : out_(out) {}

    Writer& operator<<(std::string_view text)
    {
        out_ += text;
        return *this;
    }
    Writer& operator<<(double value)
    {
        char digits[io::kNumberChars];
        out_.append(digits, io::put_number(digits, value));
        return *this;
    }

private:
    std::string& out_;
};

// The page is the bounding box; y runs downward there.
std::string svg_text(const Region& region)
{
    const Box2 box = region.empty() ? Box2{{}, {}} : bounds(region);
    const Vec2 size = box.size();
    std::string text;
    Writer out(text);
    out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
        << "version=\"1.1\" width=\"" << size[0] << "mm\" height=\"" << size[1] << "mm\" viewBox=\""
        << box.min[0] << " " << 0.0 - box.max[1] << " " << size[0] << " " << size[1]
        << "\">\n<path fill-rule=\"evenodd\" fill=\"lightgray\" stroke=\"black\" "
        << "stroke-width=\"0.5\" d=\"";
    for (const Ring& ring : region.rings) {
        const char* command = "M ";
        for (const Vec2& p : ring) {
            out << command << p[0] << "," << 0.0 - p[1] << "\n";
            command = "L ";
        }
        out << "z\n";
    }
    out << "\"/>\n</svg>\n";
    return text;
}

std::string dxf_text(const Region& region)
{
    std::string text;
    Writer out(text);
    out << "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n"
        << "0\nSECTION\n2\nENTITIES\n";
    for (const Ring& ring : region.rings)
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
            out << "0\nLINE\n8\n0\n10\n"
                << a[0] << "\n20\n"
                << a[1] << "\n11\n"
                << b[0] << "\n21\n"
                << b[1] << "\n";
        }
    out << "0\nENDSEC\n0\nEOF\n";
    return text;
}

}  // namespace

namespace io {

int CurveSampler::arc_steps(double radius, double turn) const
{
    const double degrees = std::min(std::fabs(turn), 360.0);
    double steps = degrees == 360.0 ? kCircleSteps : std::floor(degrees * 10.0 / 180.0) + 4.0;
    if (options_.sides) steps = std::ceil(options_.sides(radius * scale_) * degrees / 360.0 - 1e-9);
    return static_cast<int>(std::clamp(steps, 1.0, static_cast<double>(kMostSteps)));
}

// A chord of a curve is off by at most an eighth of its second derivative.
int CurveSampler::cubic_steps(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) const
{
    if (!options_.tolerance) return kCubicSteps;
    const double second = 6.0 * std::max(norm(a - 2.0 * b + c), norm(b - 2.0 * c + d)) * scale_;
    const double steps = std::ceil(std::sqrt(0.125 * second / *options_.tolerance));
    return static_cast<int>(std::clamp(steps, 1.0, static_cast<double>(kMostSteps)));
}

}  // namespace io

std::optional<RegionFormat> region_format_of_extension(std::string_view path)
{
    const std::string extension = extension_of(path);
    if (extension == ".svg") return RegionFormat::svg;
    if (extension == ".dxf") return RegionFormat::dxf;
    return std::nullopt;
}

Region read_region(const std::string& path, const RegionReadOptions& options)
{
    const RegionFormat format = known_format(path);
    const io::InputFile file(path);
    const std::string_view text = io::as_text(file.bytes());
    return format == RegionFormat::svg ? read_svg(text, path, options)
                                       : read_dxf(text, path, options);
}

void write_region(const std::string& path, const Region& region)
{
    const RegionFormat format = known_format(path);
    const std::string text = format == RegionFormat::svg ? svg_text(region) : dxf_text(region);
    io::OutputFile file(path);
    file.write(text);
    file.commit();
}

}  // namespace genus
