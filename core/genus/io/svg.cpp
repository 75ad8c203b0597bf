// Scalable Vector Graphics, read by the library expat into a small tree and walked from there.

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/base/transform.h"
#include "genus/io/region_file.h"
#include "genus/io/text.h"
#include "genus/io/xml.h"

namespace genus {

namespace {

constexpr std::size_t kMostElements = 2'000'000;
constexpr std::size_t kMostDrawn = 2'000'000;  // elements, with those repeated by `use`
constexpr std::size_t kMostPoints = 20'000'000;
constexpr int kDeepest = 100;  // elements in elements, through `use`
constexpr double kInch = 25.4;
constexpr double kDegrees = 57.29577951308232;

struct Element {
    std::string kind;
    std::vector<std::pair<std::string, std::string>> attributes;
    std::vector<std::unique_ptr<Element>> children;

    // Of an attribute, or of a property of the style.
    std::string_view value(std::string_view name) const
    {
        for (const auto& [key, text] : attributes)
            if (key == name) return text;
        return {};
    }
};

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && io::is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && io::is_space(text.back())) text.remove_suffix(1);
    return text;
}

std::string_view without_prefix(std::string_view name)
{
    const std::size_t colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// Builds the tree; properties of `style` become attributes that go before others.
class TreeBuilder : public io::XmlHandler {
public:
    void start(std::string_view kind, std::span<const io::XmlAttribute> attributes) override
    {
        if (++n_elements_ > kMostElements) throw std::string("too many elements");
        auto element = std::make_unique<Element>();
        element->kind = kind;
        for (const io::XmlAttribute& a : attributes)
            if (a.name == "style") add_style(a.value, *element);
        for (const io::XmlAttribute& a : attributes)
            if (a.name != "style")
                element->attributes.emplace_back(without_prefix(a.name), a.value);
        Element* at = element.get();
        if (!open_.empty())
            open_.back()->children.push_back(std::move(element));
        else
            root = std::move(element);
        open_.push_back(at);
    }
    void end(std::string_view) override { open_.pop_back(); }
    void text(std::string_view) override {}

    std::unique_ptr<Element> root;

private:
    static void add_style(std::string_view style, Element& element)
    {
        while (!style.empty()) {
            const std::string_view one = style.substr(0, style.find(';'));
            style.remove_prefix(std::min(one.size() + 1, style.size()));
            const std::size_t colon = one.find(':');
            if (colon == std::string_view::npos) continue;
            element.attributes.emplace_back(trimmed(one.substr(0, colon)),
                                            trimmed(one.substr(colon + 1)));
        }
    }

    std::vector<Element*> open_;
    std::size_t n_elements_ = 0;
};

// Numbers of an attribute, one after the other, with commas or without.
class NumberList {
public:
    explicit NumberList(std::string_view text) : at_(text.data()), end_(text.data() + text.size())
    {
    }

    void skip()
    {
        while (at_ != end_ && (io::is_space(*at_) || *at_ == ',')) ++at_;
    }
    bool at_end()
    {
        skip();
        return at_ == end_;
    }
    // The next character, if it is a letter, else 0.
    char letter()
    {
        skip();
        if (at_ == end_ || io::to_lower(*at_) < 'a' || io::to_lower(*at_) > 'z') return 0;
        return *at_++;
    }
    bool is_number()
    {
        skip();
        return at_ != end_ && (io::is_digit(*at_) || *at_ == '-' || *at_ == '+' || *at_ == '.');
    }
    double number()
    {
        skip();
        const char* start = at_;
        // A second point starts a new number, which the common reader would not see.
        const char* stop = at_;
        bool point = false, exponent = false;
        for (; stop != end_; ++stop) {
            const char c = io::to_lower(*stop);
            if (c == '.' && (point || exponent)) break;
            point = point || c == '.';
            if (c == 'e' && (exponent || stop + 1 == end_ ||
                             !(io::is_digit(stop[1]) || stop[1] == '-' || stop[1] == '+')))
                break;
            exponent = exponent || c == 'e';
            const bool sign = c == '-' || c == '+';
            if (sign && stop != start && io::to_lower(stop[-1]) != 'e') break;
            if (!io::is_digit(c) && c != '.' && c != 'e' && !sign) break;
        }
        double value = 0.0;
        try {
            at_ = io::parse_number(start, stop, value);
        } catch (const io::TextFault& fault) {
            throw std::string(fault.problem);
        }
        return value;
    }
    // Flags of arcs may stand without a space.
    bool flag()
    {
        skip();
        if (at_ == end_ || (*at_ != '0' && *at_ != '1'))
            throw std::string("a flag of an arc is neither 0 nor 1");
        return *at_++ == '1';
    }
    std::string_view rest()
    {
        skip();
        return {at_, static_cast<std::size_t>(end_ - at_)};
    }

private:
    const char* at_;
    const char* end_;
};

struct Length {
    double number = 0.0;
    std::string_view unit;
    bool given = false;
};

Length to_length(std::string_view text)
{
    NumberList list(text);
    if (!list.is_number()) return {};
    const double number = list.number();
    return {number, trimmed(list.rest()), true};
}

// In millimetres; a length without unit is one in pixels.
double in_millimetres(const Length& length, double dpi)
{
    static constexpr std::pair<std::string_view, double> units[] = {
        {"mm", 1.0}, {"cm", 10.0}, {"in", kInch}, {"pt", kInch / 72.0}, {"pc", kInch / 6.0}};
    for (const auto& [name, millimetres] : units)
        if (length.unit == name) return length.number * millimetres;
    return length.number * kInch / dpi;
}

// In user units, 96 to the inch for lengths with a unit.
double in_user_units(std::string_view text, double otherwise)
{
    const Length length = to_length(text);
    if (!length.given) return otherwise;
    if (length.unit.empty() || length.unit == "px") return length.number;
    return in_millimetres(length, 96.0) * 96.0 / kInch;
}

// One line of points of a path.
struct Line {
    Ring points;
    bool closed = false;
};

// Points of path data, in the order of SVG 1.1, section 8.3.
class PathReader {
public:
    PathReader(std::string_view data, const io::CurveSampler& sampler)
        : data_(data), sampler_(sampler)
    {
    }

    std::vector<Line> run()
    {
        char command = 0;
        while (!data_.at_end()) {
            if (const char letter = data_.letter())
                command = letter;
            else if (command == 0 || io::to_lower(command) == 'z' || !data_.is_number())
                throw std::string("path data: a command is missing");
            step(command);
            if (command == 'M') command = 'L';
            if (command == 'm') command = 'l';
        }
        finish(false);
        return std::move(lines_);
    }

private:
    void step(char command)
    {
        relative_ = command >= 'a';
        const char kind = io::to_lower(command);
        if (kind != 'c' && kind != 's') cubic_handle_.reset();
        if (kind != 'q' && kind != 't') square_handle_.reset();
        switch (kind) {
            case 'm':
                finish(false);
                at_ = point();
                start_ = at_;
                line_.points = {at_};
                return;
            case 'z':
                finish(true);
                at_ = start_;
                return;
            case 'l':
                return line_to(point());
            case 'h':
                return line_to({{data_.number() + (relative_ ? at_[0] : 0.0), at_[1]}});
            case 'v':
                return line_to({{at_[0], data_.number() + (relative_ ? at_[1] : 0.0)}});
            case 'c': {
                const Vec2 b = point(), c = point(), d = point();
                return cubic(b, c, d);
            }
            case 's': {
                const Vec2 b = cubic_handle_ ? 2.0 * at_ - *cubic_handle_ : at_;
                const Vec2 c = point(), d = point();
                return cubic(b, c, d);
            }
            case 'q': {
                const Vec2 b = point(), c = point();
                return square(b, c);
            }
            case 't': {
                const Vec2 b = square_handle_ ? 2.0 * at_ - *square_handle_ : at_;
                return square(b, point());
            }
            case 'a': {
                const double rx = data_.number(), ry = data_.number(), turned = data_.number();
                const bool large = data_.flag(), sweep = data_.flag();
                return arc(rx, ry, turned, large, sweep, point());
            }
            default:
                throw std::string("path data: unknown command '") + command + "'";
        }
    }

    Vec2 point()
    {
        const double x = data_.number(), y = data_.number();
        return relative_ ? at_ + Vec2{{x, y}} : Vec2{{x, y}};
    }
    void add(const Vec2& p)
    {
        if (++n_points_ > kMostPoints) throw std::string("paths of too many points");
        line_.points.push_back(p);
    }
    void line_to(const Vec2& p)
    {
        if (line_.points.empty()) line_.points = {at_};
        add(p);
        at_ = p;
    }
    void cubic(const Vec2& b, const Vec2& c, const Vec2& d)
    {
        const Vec2 a = at_;
        const int steps = sampler_.cubic_steps(a, b, c, d);
        for (int i = 1; i < steps; ++i) {
            const double t = static_cast<double>(i) / steps, u = 1.0 - t;
            line_to(u * u * u * a + 3.0 * u * u * t * b + 3.0 * u * t * t * c + t * t * t * d);
        }
        line_to(d);
        cubic_handle_ = c;
    }
    void square(const Vec2& b, const Vec2& c)
    {
        const Vec2 a = at_;
        const int steps = sampler_.cubic_steps(a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c);
        for (int i = 1; i < steps; ++i) {
            const double t = static_cast<double>(i) / steps, u = 1.0 - t;
            line_to(u * u * a + 2.0 * u * t * b + t * t * c);
        }
        line_to(c);
        square_handle_ = b;
    }

    // From end points to the centre, SVG 1.1, appendix F.6.5.
    void arc(double rx, double ry, double turned, bool large, bool sweep, const Vec2& to)
    {
        rx = std::fabs(rx);
        ry = std::fabs(ry);
        if (rx == 0.0 || ry == 0.0 || to == at_) return line_to(to);
        const double c = cos_degrees(turned), s = sin_degrees(turned);
        const Vec2 half = 0.5 * (at_ - to);
        const double x = (c * half[0] + s * half[1]) / rx, y = (c * half[1] - s * half[0]) / ry;
        const double squares = x * x + y * y;
        const double grow = std::max(1.0, std::sqrt(squares));
        rx *= grow;
        ry *= grow;
        const double away =
            std::sqrt(std::max(0.0, 1.0 / squares - 1.0)) * (large == sweep ? -1.0 : 1.0);
        // On the unit circle of the arc: its centre, and the angles of both ends.
        const double ux = away * y, uy = -away * x;
        const double px = x / grow, py = y / grow;
        const double first = std::atan2(py - uy, px - ux) * kDegrees;
        double turn = std::atan2(-py - uy, -px - ux) * kDegrees - first;
        if (sweep && turn < 0.0) turn += 360.0;
        if (!sweep && turn > 0.0) turn -= 360.0;
        const Vec2 centre =
            0.5 * (at_ + to) + Vec2{{c * rx * ux - s * ry * uy, s * rx * ux + c * ry * uy}};
        const int steps = sampler_.arc_steps(std::max(rx, ry), turn);
        for (int i = 1; i < steps; ++i) {
            const double angle = first + turn * i / steps;
            const double ex = rx * cos_degrees(angle), ey = ry * sin_degrees(angle);
            line_to(centre + Vec2{{c * ex - s * ey, s * ex + c * ey}});
        }
        line_to(to);
    }

    void finish(bool closed)
    {
        line_.closed = closed;
        if (line_.points.size() > 1) lines_.push_back(std::move(line_));
        line_ = {};
    }

    NumberList data_;
    const io::CurveSampler& sampler_;
    std::vector<Line> lines_;
    Line line_;
    Vec2 at_{}, start_{};
    bool relative_ = false;
    std::optional<Vec2> cubic_handle_, square_handle_;
    std::size_t n_points_ = 0;
};

// A map of the plane, as a transform of space.
Transform plane_map(double a, double b, double c, double d, double e, double f)
{
    Transform t;
    t.m[0] = {a, c, 0.0, e};
    t.m[1] = {b, d, 0.0, f};
    return t;
}

Transform to_transform(std::string_view text)
{
    Transform all;
    while (!(text = trimmed(text)).empty()) {
        const std::size_t open = text.find('('), close = text.find(')');
        if (open == std::string_view::npos || close == std::string_view::npos || close < open)
            throw std::string("transform: parentheses are missing");
        std::string_view name = trimmed(text.substr(0, open));
        while (!name.empty() && (name.front() == ',' || io::is_space(name.front())))
            name.remove_prefix(1);
        std::vector<double> n;
        NumberList list(text.substr(open + 1, close - open - 1));
        while (!list.at_end() && n.size() < 8) n.push_back(list.number());
        const auto get = [&](std::size_t i, double otherwise) {
            return i < n.size() ? n[i] : otherwise;
        };
        text.remove_prefix(close + 1);
        if (n.empty()) throw std::string("transform: numbers are missing");
        if (name == "matrix" && n.size() == 6) {
            all = all * plane_map(n[0], n[1], n[2], n[3], n[4], n[5]);
        } else if (name == "translate") {
            all = all * plane_map(1, 0, 0, 1, n[0], get(1, 0.0));
        } else if (name == "scale") {
            all = all * plane_map(n[0], 0, 0, get(1, n[0]), 0, 0);
        } else if (name == "rotate") {
            const Vec3 about{{get(1, 0.0), get(2, 0.0), 0.0}};
            all = all * translation(about) * rotation_z(n[0]) * translation(-1.0 * about);
        } else if (name == "skewX") {
            all = all * plane_map(1, 0, std::tan(n[0] / kDegrees), 1, 0, 0);
        } else if (name == "skewY") {
            all = all * plane_map(1, std::tan(n[0] / kDegrees), 0, 1, 0, 0);
        } else {
            throw "transform: unknown '" + std::string(name.substr(0, 40)) + "'";
        }
    }
    return all;
}

// The area of a drawn line of some width.
class Stroke {
public:
    Stroke(double width, std::string_view cap, std::string_view join, double miter_limit, int sides)
        : half_(0.5 * width), cap_(cap), join_(join), miter_limit_(miter_limit), sides_(sides)
    {
    }

    std::vector<Ring> outline(const Ring& line)
    {
        Ring points;
        for (const Vec2& p : line)
            if (points.empty() || p != points.back()) points.push_back(p);
        for (std::size_t i = 0; i + 1 < points.size(); ++i) side(points, i);
        for (std::size_t i = 1; i + 1 < points.size(); ++i)
            corner(points[i - 1], points[i], points[i + 1]);
        return std::move(rings_);
    }

private:
    void add(Ring ring)
    {
        if (area(ring) < 0.0) std::reverse(ring.begin(), ring.end());
        rings_.push_back(std::move(ring));
    }
    static Vec2 along(const Vec2& a, const Vec2& b) { return (b - a) / norm(b - a); }
    static Vec2 aside(const Vec2& u) { return {{-u[1], u[0]}}; }

    void side(const Ring& points, std::size_t i)
    {
        const Vec2 u = along(points[i], points[i + 1]), v = half_ * aside(u);
        const bool first = i == 0, last = i + 2 == points.size();
        const bool square = cap_ != "butt" && cap_ != "round";
        const Vec2 a = points[i] - (first && square ? half_ : 0.0) * u;
        const Vec2 b = points[i + 1] + (last && square ? half_ : 0.0) * u;
        add({a + v, a - v, b - v, b + v});
        if (cap_ == "round" && first) disc(points[i]);
        if (cap_ == "round" && last) disc(points[i + 1]);
    }
    void disc(const Vec2& centre)
    {
        Ring ring;
        for (int k = 0; k < sides_; ++k) {
            const double angle = 360.0 * k / sides_;
            ring.push_back(centre + half_ * Vec2{{cos_degrees(angle), sin_degrees(angle)}});
        }
        add(std::move(ring));
    }
    void corner(const Vec2& before, const Vec2& at, const Vec2& after)
    {
        const Vec2 u = along(before, at), w = along(at, after);
        const double sine = u[0] * w[1] - u[1] * w[0], cosine = dot(u, w);
        if (sine == 0.0 && cosine > 0.0) return;
        if (join_ == "round") return disc(at);
        // The gap is on the outer side of the bend.
        const double out = sine > 0.0 ? -half_ : half_;
        const Vec2 p = at + out * aside(u), q = at + out * aside(w);
        Ring wedge{at, p};
        if (join_ != "bevel" && 2.0 <= miter_limit_ * miter_limit_ * (1.0 + cosine) &&
            1.0 + cosine > 1e-12)
            wedge.push_back(at + (out / (1.0 + cosine)) * (aside(u) + aside(w)));
        wedge.push_back(q);
        add(std::move(wedge));
    }

    double half_;
    std::string_view cap_, join_;
    double miter_limit_;
    int sides_;
    std::vector<Ring> rings_;
};

// Properties that elements take from those around them.
struct Inherited {
    std::string_view stroke_width, stroke_linecap, stroke_linejoin, stroke_miterlimit;

    Inherited within(const Element& e) const
    {
        Inherited now = *this;
        const auto take = [&](std::string_view& property, const char* name) {
            if (const std::string_view value = e.value(name); !value.empty()) property = value;
        };
        take(now.stroke_width, "stroke-width");
        take(now.stroke_linecap, "stroke-linecap");
        take(now.stroke_linejoin, "stroke-linejoin");
        take(now.stroke_miterlimit, "stroke-miterlimit");
        return now;
    }
};

class Drawer {
public:
    Drawer(const Element& root, const RegionReadOptions& options) : options_(options)
    {
        note_names(root);
    }

    Region run(const Element& root)
    {
        draw(root, Transform{}, {}, 0);
        return unite(shapes_);
    }

private:
    void note_names(const Element& root)
    {
        std::vector<const Element*> open{&root};
        while (!open.empty()) {
            const Element* e = open.back();
            open.pop_back();
            if (const std::string_view id = e->value("id"); !id.empty()) by_id_.emplace(id, e);
            for (const auto& child : e->children) open.push_back(child.get());
        }
    }

    static bool is_left_out(const std::string& kind)
    {
        static constexpr std::string_view kinds[] = {
            "defs", "symbol", "clipPath", "mask",  "pattern", "marker",         "metadata",
            "text", "image",  "style",    "title", "desc",    "linearGradient", "radialGradient"};
        return std::find(std::begin(kinds), std::end(kinds), kind) != std::end(kinds);
    }

    void draw(const Element& e, const Transform& outside, const Inherited& around, int depth)
    {
        if (depth > kDeepest) throw std::string("elements use each other too deeply");
        if (++n_drawn_ > kMostDrawn) throw std::string("too many elements are drawn");
        if (n_drawn_ % 1024 == 0) current_progress().check();
        if (is_left_out(e.kind) && (depth == 0 || e.kind != "symbol")) return;
        if (e.value("display") == "none") return;
        const Transform map = outside * to_transform(e.value("transform"));
        const Inherited style = around.within(e);
        if (e.kind == "use") {
            use(e, map, style, depth);
        } else {
            const double scale = largest_stretch(map);
            shape(e, map, style, io::CurveSampler(options_, scale));
            for (const auto& child : e.children) draw(*child, map, style, depth + 1);
        }
    }

    void use(const Element& e, const Transform& map, const Inherited& style, int depth)
    {
        std::string_view name = e.value("href");
        if (!name.starts_with('#')) return;
        const auto found = by_id_.find(name.substr(1));
        if (found == by_id_.end()) return;
        const double x = in_user_units(e.value("x"), 0.0), y = in_user_units(e.value("y"), 0.0);
        const Transform moved = map * translation({{x, y, 0.0}});
        const Element& target = *found->second;
        if (target.kind != "symbol") return draw(target, moved, style, depth + 1);
        for (const auto& child : target.children) draw(*child, moved, style, depth + 1);
    }

    void shape(const Element& e, const Transform& map, const Inherited& style,
               const io::CurveSampler& sampler)
    {
        const auto get = [&](const char* name) { return in_user_units(e.value(name), 0.0); };
        if (e.kind == "path") {
            add(PathReader(e.value("d"), sampler).run(), map, style);
        } else if (e.kind == "rect") {
            rectangle(e, map, style, sampler);
        } else if (e.kind == "circle") {
            ellipse({{get("cx"), get("cy")}}, get("r"), get("r"), map, style, sampler);
        } else if (e.kind == "ellipse") {
            ellipse({{get("cx"), get("cy")}}, get("rx"), get("ry"), map, style, sampler);
        } else if (e.kind == "line") {
            add({{{{{get("x1"), get("y1")}}, {{get("x2"), get("y2")}}}, false}}, map, style);
        } else if (e.kind == "polyline" || e.kind == "polygon") {
            Line line;
            line.closed = e.kind == "polygon";
            NumberList list(e.value("points"));
            while (!list.at_end()) {
                const double x = list.number();
                line.points.push_back({{x, list.number()}});
            }
            add({std::move(line)}, map, style);
        }
    }

    void ellipse(const Vec2& centre, double rx, double ry, const Transform& map,
                 const Inherited& style, const io::CurveSampler& sampler)
    {
        if (!(rx > 0.0 && ry > 0.0)) return;
        Line line;
        line.closed = true;
        const int steps = std::max(3, sampler.arc_steps(std::max(rx, ry), 360.0));
        for (int i = 0; i < steps; ++i) {
            const double angle = 360.0 * i / steps;
            line.points.push_back(centre +
                                  Vec2{{rx * cos_degrees(angle), ry * sin_degrees(angle)}});
        }
        add({std::move(line)}, map, style);
    }

    void rectangle(const Element& e, const Transform& map, const Inherited& style,
                   const io::CurveSampler& sampler)
    {
        const auto get = [&](const char* name) { return in_user_units(e.value(name), 0.0); };
        const double x = get("x"), y = get("y"), w = get("width"), h = get("height");
        if (!(w > 0.0 && h > 0.0)) return;
        double rx = in_user_units(e.value("rx"), -1.0), ry = in_user_units(e.value("ry"), -1.0);
        if (rx < 0.0) rx = std::max(ry, 0.0);
        if (ry < 0.0) ry = rx;
        rx = std::min(rx, 0.5 * w);
        ry = std::min(ry, 0.5 * h);
        Line line;
        line.closed = true;
        const int steps = rx > 0.0 && ry > 0.0 ? sampler.arc_steps(std::max(rx, ry), 90.0) : 0;
        const Vec2 middles[] = {{{x + w - rx, y + ry}},
                                {{x + w - rx, y + h - ry}},
                                {{x + rx, y + h - ry}},
                                {{x + rx, y + ry}}};
        for (int corner = 0; corner < 4; ++corner)
            for (int i = 0; i <= steps; ++i) {
                const double angle = 90.0 * (corner - 1) + (steps > 0 ? 90.0 * i / steps : 0.0);
                const Vec2 way{{rx * cos_degrees(angle), ry * sin_degrees(angle)}};
                line.points.push_back(steps > 0 ? middles[corner] + way : middles[corner]);
            }
        add({std::move(line)}, map, style);
    }

    // Closed lines of one element are filled together, open ones are stroked.
    void add(const std::vector<Line>& lines, const Transform& map, const Inherited& style)
    {
        std::vector<Ring> filled, drawn;
        for (const Line& line : lines) {
            if (line.points.size() < 2) continue;
            n_points_ += line.points.size();
            if (n_points_ > kMostPoints) throw std::string("shapes of too many points");
            if (line.closed || line.points.front() == line.points.back()) {
                filled.push_back(moved(line.points, map));
                continue;
            }
            const double width = in_user_units(style.stroke_width, 1.0);
            if (!(width > 0.0)) continue;
            const double limit = in_user_units(style.stroke_miterlimit, 4.0);
            const io::CurveSampler sampler(options_, largest_stretch(map));
            Stroke stroke(width, style.stroke_linecap, style.stroke_linejoin, limit,
                          std::max(3, sampler.arc_steps(0.5 * width, 360.0)));
            for (const Ring& ring : stroke.outline(line.points)) drawn.push_back(moved(ring, map));
        }
        if (!filled.empty()) shapes_.push_back(make_region(filled, FillRule::EvenOdd));
        if (!drawn.empty()) shapes_.push_back(make_region(drawn, FillRule::NonZero));
    }

    static Ring moved(const Ring& ring, const Transform& map)
    {
        Ring out;
        for (const Vec2& p : ring) {
            const Vec3 q = apply(map, Vec3{{p[0], p[1], 0.0}});
            out.push_back({{q[0], q[1]}});
            if (!is_finite(out.back())) throw std::string("a coordinate is not finite");
        }
        return out;
    }

    const RegionReadOptions& options_;
    std::unordered_map<std::string_view, const Element*> by_id_;
    std::vector<Region> shapes_;
    std::size_t n_points_ = 0;
    std::size_t n_drawn_ = 0;
};

// From user units to millimetres with y upward, the lower edge of the page at 0.
Transform page_map(const Element& root, double dpi)
{
    const Length width = to_length(root.value("width")), height = to_length(root.value("height"));
    NumberList box(root.value("viewBox"));
    std::array<double, 4> view{};
    bool has_view = true;
    for (double& number : view)
        has_view = has_view && box.is_number() && ((number = box.number()), true);
    has_view = has_view && view[2] > 0.0 && view[3] > 0.0;
    const bool wide = width.given && width.unit != "%", high = height.given && height.unit != "%";
    const double page_height = high ? in_millimetres(height, dpi) : 0.0;
    const Transform flip = plane_map(1, 0, 0, -1, 0, page_height);
    if (!has_view) return flip;
    const double w = wide ? in_millimetres(width, dpi) : view[2] * kInch / dpi;
    const double h = high ? page_height : view[3] * kInch / dpi;
    double sx = w / view[2], sy = h / view[3];
    double x = 0.0, y = 0.0;
    const std::string_view fit = root.value("preserveAspectRatio");
    if (!fit.starts_with("none")) {
        const bool slice = fit.find("slice") != std::string_view::npos;
        sx = sy = slice ? std::max(sx, sy) : std::min(sx, sy);
        const auto share = [&](const char* low, const char* far) {
            if (fit.find(low) != std::string_view::npos) return 0.0;
            return fit.find(far) != std::string_view::npos ? 1.0 : 0.5;
        };
        x = share("xMin", "xMax") * (w - sx * view[2]);
        y = share("YMin", "YMax") * (h - sy * view[3]);
    }
    return plane_map(1, 0, 0, -1, 0, h) *
           plane_map(sx, 0, 0, sy, x - sx * view[0], y - sy * view[1]);
}

std::unique_ptr<Element> parse(std::string_view text, const std::string& name)
{
    TreeBuilder builder;
    try {
        io::XmlParser parser(builder, io::XmlParser::DocumentType::Allowed);
        parser.feed({text.data(), text.size()});
        parser.finish();
    } catch (const io::XmlFault& fault) {
        throw FileError(name, fault.problem, FileError::at_line(fault.line));
    }
    if (!builder.root || builder.root->kind != "svg")
        throw FileError(name, "the outermost element is not svg");
    return std::move(builder.root);
}

}  // namespace

Region read_svg(std::string_view text, const std::string& name, const RegionReadOptions& options)
{
    const std::unique_ptr<Element> root = parse(text, name);
    try {
        const Transform page = page_map(*root, options.dpi);
        // Curves are cut in units of the result.
        RegionReadOptions inner = options;
        const double scale = largest_stretch(page);
        if (options.sides)
            inner.sides = [&](double radius) { return options.sides(radius * scale); };
        if (options.tolerance) inner.tolerance = *options.tolerance / scale;
        Region region = Drawer(*root, inner).run(*root);
        Vec2 shift{};
        const bool turned = determinant(page) < 0.0;
        for (Ring& ring : region.rings) {
            for (Vec2& p : ring) {
                const Vec3 q = apply(page, Vec3{{p[0], p[1], 0.0}});
                p = {{q[0], q[1]}};
            }
            if (turned) std::reverse(ring.begin(), ring.end());
        }
        if (options.center && !region.empty()) {
            const Box2 box = bounds(region);
            shift = -0.5 * (box.min + box.max);
        }
        for (Ring& ring : region.rings)
            for (Vec2& p : ring) p += shift;
        return region;
    } catch (const std::string& problem) {
        throw FileError(name, problem);
    } catch (const InvalidInput& problem) {
        throw FileError(name, problem.what());
    }
}

}  // namespace genus
