// Drawing Exchange Format, as text: pairs of a code, which says what follows, and a value.

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/base/transform.h"
#include "genus/io/region_file.h"
#include "genus/io/text.h"

namespace genus {

namespace {

using io::TextFault;

constexpr std::size_t kMostEntities = 10'000'000;
constexpr std::size_t kMostPoints = 50'000'000;
constexpr int kDeepest = 16;                    // blocks in blocks
constexpr std::size_t kMostPlaces = 1'000'000;  // of blocks
constexpr double kJoin = 1e-6;                  // of the size of the drawing: ends that meet
constexpr double kDegrees = 57.29577951308232;

// One entity: its kind and all its numbers and texts, in order.
struct Entity {
    std::string_view kind;
    std::string_view layer;
    std::string_view name;  // of an inserted block, or text of a dimension
    std::vector<std::pair<int, double>> numbers;

    double number(int code, double otherwise = 0.0) const
    {
        for (const auto& [c, value] : numbers)
            if (c == code) return value;
        return otherwise;
    }
    Vec2 point(int code) const { return {{number(code), number(code + 10)}}; }
};

struct Drawing {
    std::vector<Entity> entities;
    std::unordered_map<std::string_view, std::vector<Entity>> blocks;
};

class Reader {
public:
    explicit Reader(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

    Drawing run()
    {
        std::string_view section, block;
        Entity entity;
        bool is_open = false;
        const auto finish = [&] {
            if (is_open) take(section, block, std::move(entity));
            entity = {};
            is_open = false;
        };
        int code = 0;
        std::string_view value;
        while (next(code, value)) {
            if (code == 0) {
                finish();
                if (value == "EOF") return std::move(drawing_);
                if (value == "ENDSEC") section = {};
                if (value == "ENDBLK") block = {};
                entity.kind = value;
                is_open = true;
            } else if (entity.kind == "SECTION" && code == 2) {
                section = value;
            } else if (entity.kind == "BLOCK" && code == 2) {
                block = value;
                entity.name = value;
            } else if (code == 8) {
                entity.layer = value;
            } else if (code == 2 || (code == 1 && entity.kind == "DIMENSION")) {
                if (code == 1 || entity.kind != "DIMENSION") entity.name = value;
            } else if (code >= 10 && code <= 79 && is_wanted(section)) {
                entity.numbers.emplace_back(code, number(value));
            }
        }
        finish();
        return std::move(drawing_);
    }

private:
    static bool is_wanted(std::string_view section)
    {
        return section == "ENTITIES" || section == "BLOCKS";
    }

    // False at the end of the text.
    bool next(int& code, std::string_view& value)
    {
        std::string_view line;
        if (!take_line(line)) return false;
        std::int64_t wide = 0;
        if (io::parse_integer(line.data(), line.data() + line.size(), wide) !=
                line.data() + line.size() ||
            wide < -10'000 || wide > 10'000)
            throw TextFault{line.data(), "expected a group code"};
        code = static_cast<int>(wide);
        return take_line(value);
    }

    bool take_line(std::string_view& line)
    {
        if (at_ == end_) return false;
        const char* start = at_;
        while (at_ != end_ && *at_ != '\n') ++at_;
        const char* stop = at_;
        if (at_ != end_) ++at_;
        while (start != stop && io::is_space(*start)) ++start;
        while (stop != start && io::is_space(stop[-1])) --stop;
        line = {start, static_cast<std::size_t>(stop - start)};
        return !line.empty() || at_ != end_;
    }

    static double number(std::string_view text)
    {
        double value = 0.0;
        if (io::parse_number(text.data(), text.data() + text.size(), value) !=
            text.data() + text.size())
            throw TextFault{text.data(), "expected a number"};
        return value;
    }

    void take(std::string_view section, std::string_view block, Entity entity)
    {
        if (++n_entities_ > kMostEntities) throw TextFault{at_, "too many entities"};
        if (section == "ENTITIES") drawing_.entities.push_back(std::move(entity));
        if (section == "BLOCKS" && !block.empty()) drawing_.blocks[block].push_back(entity);
    }

    const char* at_;
    const char* end_;
    Drawing drawing_;
    std::size_t n_entities_ = 0;
};

Drawing read_drawing(std::string_view text, const std::string& name)
{
    if (text.starts_with("AutoCAD Binary DXF"))
        throw FileError(name, "binary DXF files are not read; save it as text");
    return io::with_lines(text, name, [&] { return Reader(text).run(); });
}

// Lines of a drawing, from point to point, with blocks put in their places.
class Tracer {
public:
    Tracer(const Drawing& drawing, const std::string& name, const RegionReadOptions& options)
        : drawing_(drawing), name_(name), options_(options)
    {
    }

    std::vector<Ring> run()
    {
        Transform map = scaling({{options_.scale, options_.scale, options_.scale}}) *
                        translation({{-options_.origin[0], -options_.origin[1], 0.0}});
        trace(drawing_.entities, map, 0, {});
        return std::move(lines_);
    }

private:
    void trace(const std::vector<Entity>& entities, const Transform& map, int depth,
               std::string_view layer)
    {
        if (depth > kDeepest) throw FileError(name_, "blocks contain each other too deeply");
        if (++n_places_ > kMostPlaces) throw FileError(name_, "blocks are repeated too often");
        for (std::size_t i = 0; i < entities.size(); ++i) {
            const Entity& e = entities[i];
            if (i % 4096 == 4095) current_progress().check();
            // Within a block, layer 0 is that of the insert.
            const std::string_view on = depth > 0 && e.layer == "0" ? layer : e.layer;
            if (e.kind == "INSERT") {
                insert(e, map, depth, on);
                continue;
            }
            if (!options_.layer.empty() && on != options_.layer) continue;
            if (e.kind == "LINE") {
                add({e.point(10), e.point(11)}, map);
            } else if (e.kind == "LWPOLYLINE") {
                light_polyline(e, map);
            } else if (e.kind == "POLYLINE") {
                polyline(entities, i, map);
            } else if (e.kind == "CIRCLE") {
                arc(e.point(10), {{e.number(40), 0.0}}, {{0.0, e.number(40)}}, 0.0, 360.0, map);
            } else if (e.kind == "ARC") {
                const double first = e.number(50), last = e.number(51);
                double turn = std::fmod(last - first, 360.0);
                if (turn <= 0.0) turn += 360.0;
                arc(e.point(10), {{e.number(40), 0.0}}, {{0.0, e.number(40)}}, first, turn, map);
            } else if (e.kind == "ELLIPSE") {
                ellipse(e, map);
            }
        }
    }

    void insert(const Entity& e, const Transform& map, int depth, std::string_view layer)
    {
        const auto block = drawing_.blocks.find(e.name);
        if (block == drawing_.blocks.end()) return;
        Vec2 base{};
        for (const Entity& part : block->second)
            if (part.kind == "BLOCK") base = part.point(10);
        const Vec2 at = e.point(10);
        const Transform place = translation({{at[0], at[1], 0.0}}) * rotation_z(e.number(50)) *
                                scaling({{e.number(41, 1.0), e.number(42, 1.0), 1.0}}) *
                                translation({{-base[0], -base[1], 0.0}});
        trace(block->second, map * place, depth + 1, layer);
    }

    void add(const Ring& line, const Transform& map)
    {
        n_points_ += line.size();
        if (n_points_ > kMostPoints) throw FileError(name_, "curves of too many points");
        Ring moved;
        for (const Vec2& p : line) {
            const Vec3 q = apply(map, Vec3{{p[0], p[1], 0.0}});
            moved.push_back({{q[0], q[1]}});
        }
        lines_.push_back(std::move(moved));
    }

    // Points centre + cos a u + sin a v, for angles from `first` over `turn` degrees.
    void arc(const Vec2& centre, const Vec2& u, const Vec2& v, double first, double turn,
             const Transform& map)
    {
        add(arc_points(centre, u, v, first, turn), map);
    }
    Ring arc_points(const Vec2& centre, const Vec2& u, const Vec2& v, double first,
                    double turn) const
    {
        const io::CurveSampler sampler(options_, std::fabs(options_.scale));
        const int steps = sampler.arc_steps(std::max(norm(u), norm(v)), turn);
        Ring points;
        for (int i = 0; i <= steps; ++i) {
            const double angle = first + turn * i / steps;
            points.push_back(centre + cos_degrees(angle) * u + sin_degrees(angle) * v);
        }
        if (std::fabs(turn) == 360.0) points.back() = points.front();
        return points;
    }

    void ellipse(const Entity& e, const Transform& map)
    {
        const Vec2 u = e.point(11);
        const double ratio = e.number(40, 1.0);
        const double first = e.number(41) * kDegrees;
        double turn = e.number(42, 2.0 * 3.141592653589793) * kDegrees - first;
        if (turn <= 0.0) turn += 360.0;
        if (std::fabs(turn - 360.0) < 1e-6) turn = 360.0;
        arc(e.point(10), u, {{-ratio * u[1], ratio * u[0]}}, first, turn, map);
    }

    // A side with bulge b is an arc whose quarter angle has the tangent b.
    void add_side(Ring& line, const Vec2& from, const Vec2& to, double bulge) const
    {
        if (bulge != 0.0 && from != to) {
            const double turn = 4.0 * std::atan(bulge) * kDegrees;
            const Vec2 chord = to - from;
            const double height = (1.0 - bulge * bulge) / (4.0 * bulge);
            const Vec2 centre = 0.5 * (from + to) + height * Vec2{{-chord[1], chord[0]}};
            const Vec2 u = from - centre;
            const Ring points = arc_points(centre, u, {{-u[1], u[0]}}, 0.0, turn);
            line.insert(line.end(), points.begin() + 1, points.end() - 1);
        }
        line.push_back(to);
    }

    struct Corner {
        Vec2 at;
        double bulge = 0.0;
    };
    void add_corners(const std::vector<Corner>& corners, bool closed, const Transform& map)
    {
        if (corners.size() < 2) return;
        Ring line{corners[0].at};
        for (std::size_t i = 0; i + 1 < corners.size(); ++i)
            add_side(line, corners[i].at, corners[i + 1].at, corners[i].bulge);
        if (closed) add_side(line, corners.back().at, corners[0].at, corners.back().bulge);
        add(line, map);
    }

    void light_polyline(const Entity& e, const Transform& map)
    {
        std::vector<Corner> corners;
        for (const auto& [code, value] : e.numbers) {
            if (code == 10) corners.push_back({{{value, 0.0}}, 0.0});
            if (code == 20 && !corners.empty()) corners.back().at[1] = value;
            if (code == 42 && !corners.empty()) corners.back().bulge = value;
        }
        add_corners(corners, (static_cast<int>(e.number(70)) & 1) != 0, map);
    }

    void polyline(const std::vector<Entity>& entities, std::size_t& i, const Transform& map)
    {
        const Entity& head = entities[i];
        std::vector<Corner> corners;
        while (i + 1 < entities.size() && entities[i + 1].kind == "VERTEX") {
            ++i;
            corners.push_back({entities[i].point(10), entities[i].number(42)});
        }
        add_corners(corners, (static_cast<int>(head.number(70)) & 1) != 0, map);
    }

    const Drawing& drawing_;
    const std::string& name_;
    const RegionReadOptions& options_;
    std::vector<Ring> lines_;
    std::size_t n_points_ = 0;
    std::size_t n_places_ = 0;
};

// Joins lines at ends that meet to rings. Ends count as one if they
// are within `reach` of each other, which a grid of that size finds.
class Joiner {
public:
    Joiner(std::vector<Ring> lines, const Vec2& corner, double reach)
        : lines_(std::move(lines)), corner_(corner), reach_(reach)
    {
    }

    std::vector<Ring> run()
    {
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            if (is_closed(lines_[i])) {
                rings_.push_back(lines_[i]);
                lines_[i].clear();
            } else {
                note(lines_[i].front(), 2 * i);
                note(lines_[i].back(), 2 * i + 1);
            }
        }
        for (std::size_t i = 0; i < lines_.size(); ++i)
            if (!lines_[i].empty()) follow(i);
        return std::move(rings_);
    }

private:
    using Cell = std::pair<std::int64_t, std::int64_t>;

    bool meet(const Vec2& a, const Vec2& b) const { return norm(a - b) <= reach_; }
    bool is_closed(const Ring& line) const { return meet(line.front(), line.back()); }
    Cell cell(const Vec2& p) const
    {
        return {static_cast<std::int64_t>(std::floor((p[0] - corner_[0]) / reach_)),
                static_cast<std::int64_t>(std::floor((p[1] - corner_[1]) / reach_))};
    }
    void note(const Vec2& p, std::size_t end) { ends_[cell(p)].push_back(end); }

    // An unused line that starts or ends at p: its number times two, plus one for its end.
    std::optional<std::size_t> continued_at(const Vec2& p)
    {
        const Cell middle = cell(p);
        for (std::int64_t dx = -1; dx <= 1; ++dx)
            for (std::int64_t dy = -1; dy <= 1; ++dy) {
                const auto found = ends_.find({middle.first + dx, middle.second + dy});
                if (found == ends_.end()) continue;
                std::erase_if(found->second,
                              [&](std::size_t end) { return lines_[end / 2].empty(); });
                for (const std::size_t end : found->second) {
                    const Ring& line = lines_[end / 2];
                    if (meet(end % 2 ? line.back() : line.front(), p)) return end;
                }
            }
        return std::nullopt;
    }

    // Adds lines to the end of the chain until it meets its start; false if none is left before.
    bool closes(Ring& chain)
    {
        while (!meet(chain.front(), chain.back()) || chain.size() < 3) {
            const auto next = continued_at(chain.back());
            if (!next) return false;
            Ring line = std::move(lines_[*next / 2]);
            lines_[*next / 2].clear();
            if (*next % 2) std::reverse(line.begin(), line.end());
            chain.insert(chain.end(), line.begin() + 1, line.end());
        }
        return true;
    }

    // An open chain goes on at both of its ends, and is closed by a straight side.
    void follow(std::size_t first)
    {
        Ring chain = std::move(lines_[first]);
        lines_[first].clear();
        bool closed = closes(chain);
        if (!closed) {
            std::reverse(chain.begin(), chain.end());
            closed = closes(chain);
        }
        if (closed) chain.pop_back();
        if (chain.size() >= 3) rings_.push_back(std::move(chain));
    }

    std::vector<Ring> lines_, rings_;
    Vec2 corner_;
    double reach_;
    std::map<Cell, std::vector<std::size_t>> ends_;
};

}  // namespace

Region read_dxf(std::string_view text, const std::string& name, const RegionReadOptions& options)
{
    const Drawing drawing = read_drawing(text, name);
    std::vector<Ring> lines = Tracer(drawing, name, options).run();
    Box2 box;
    for (const Ring& line : lines)
        for (const Vec2& p : line) {
            if (!is_finite(p)) throw FileError(name, "a coordinate is not finite");
            box.add(p);
        }
    const double reach = kJoin * box.diagonal();
    if (!(reach > 0.0) || !std::isfinite(reach)) return {};
    std::erase_if(lines, [](const Ring& line) { return line.size() < 2; });
    const std::vector<Ring> rings = Joiner(std::move(lines), box.min, reach).run();
    return make_region(rings, FillRule::EvenOdd);
}

std::optional<double> dxf_dimension(std::string_view text, const std::string& name,
                                    const std::string& layer, const std::string& label,
                                    const Vec2& origin, double scale)
{
    for (const Entity& e : read_drawing(text, name).entities) {
        if (e.kind != "DIMENSION" || (!label.empty() && e.name != label) ||
            (!layer.empty() && e.layer != layer))
            continue;
        const int kind = static_cast<int>(e.number(70)) & 7;
        const auto between = [&](int a, int b) { return e.point(b) - e.point(a); };
        switch (kind) {
            case 0: {  // along a direction
                const Vec2 way = between(13, 14);
                const double angle = e.number(50);
                return std::fabs(way[0] * cos_degrees(angle) + way[1] * sin_degrees(angle)) * scale;
            }
            case 1:  // from point to point
                return norm(between(13, 14)) * scale;
            case 2: {  // the angle between two lines
                const Vec2 a = between(15, 10), b = between(13, 14);
                const double turn =
                    std::fabs(std::atan2(a[1], a[0]) - std::atan2(b[1], b[0])) * kDegrees;
                return turn > 180.0 ? 360.0 - turn : turn;
            }
            case 3:  // a diameter
            case 4:  // a radius
                return norm(between(10, 15)) * scale;
            case 6: {  // one coordinate of a point
                const bool of_x = (static_cast<int>(e.number(70)) & 64) != 0;
                return of_x ? (e.number(13) - origin[0]) * scale
                            : (e.number(23) - origin[1]) * scale;
            }
            default:
                return std::nullopt;
        }
    }
    return std::nullopt;
}

std::optional<Vec2> dxf_crossing(std::string_view text, const std::string& name,
                                 const std::string& layer, const Vec2& origin, double scale)
{
    std::vector<std::pair<Vec2, Vec2>> lines;
    for (const Entity& e : read_drawing(text, name).entities)
        if (e.kind == "LINE" && (layer.empty() || e.layer == layer) && lines.size() < 2)
            lines.emplace_back(e.point(10), e.point(11));
    if (lines.size() < 2) return std::nullopt;
    const auto& [a, b] = lines[0];
    const auto& [c, d] = lines[1];
    const Vec2 u = b - a, v = d - c, w = c - a;
    const double turn = u[0] * v[1] - u[1] * v[0];
    if (turn == 0.0) return std::nullopt;
    const double t = (w[0] * v[1] - w[1] * v[0]) / turn;
    return (a + t * u - origin) * scale;
}

}  // namespace genus
