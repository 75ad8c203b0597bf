#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/patch_formats.h"
#include "genus/io/text.h"
#include "genus/patch/bspline_surface.h"

// Free-form surfaces in Wavefront's OBJ text: attributes (cstype, deg) hold until changed; "surf"
// names the control points, u running fastest, and the part of the domain that is meant; "parm"
// gives knots, of Bezier surfaces the values where pieces meet; "end" closes the element.
namespace genus::io {

namespace {

struct Word {
    const char* at;
    std::string_view text;
};

struct Vertex {
    Vec3 p;
    double weight = 1.0;
};

class ObjReader {
public:
    explicit ObjReader(std::string_view text) : cursor_(text) {}

    std::vector<Patch> run()
    {
        while (next_line()) {
            if (n_lines_++ % 1024 == 0) current_progress().check();
            if (!words_.empty()) statement();
        }
        if (surface_) throw TextFault{surface_->at, "the surface has no end"};
        if (patches_.empty()) {
            const char* end = cursor_.end;
            throw TextFault{end, n_faces_ > 0 ? "the file has polygons and no free-form surfaces"
                                              : "the file has no free-form surfaces"};
        }
        if (n_faces_ > 0)
            throw TextFault{first_face_, "polygons beside free-form surfaces are not read"};
        return std::move(patches_);
    }

private:
    // What "surf" began.
    struct Surface {
        const char* at;
        std::array<double, 4> range;  // of u, of v
        std::vector<std::int64_t> vertices;
        std::array<std::vector<double>, 2> parameters;
    };

    // The words of a line and of those that continue it after a backslash.
    bool next_line()
    {
        words_.clear();
        if (cursor_.at_end()) return false;
        while (!cursor_.at_end()) {
            cursor_.skip_blanks();
            if (cursor_.at_line_end()) {
                cursor_.skip_comment();
                skip_newline();
                break;
            }
            const char* start = cursor_.p;
            cursor_.skip_word();
            const std::string_view word(start, static_cast<std::size_t>(cursor_.p - start));
            if (word == "\\") {
                cursor_.skip_blanks();
                skip_newline();
            } else {
                words_.push_back({start, word});
            }
        }
        return true;
    }
    void skip_newline()
    {
        if (cursor_.at_end()) return;
        const bool carriage = *cursor_.p == '\r';
        ++cursor_.p;
        if (carriage && !cursor_.at_end() && *cursor_.p == '\n') ++cursor_.p;
    }

    void statement()
    {
        const std::string_view key = words_[0].text;
        if (key == "v")
            vertex();
        else if (key == "cstype")
            type();
        else if (key == "deg")
            degrees();
        else if (key == "surf")
            surf();
        else if (key == "parm")
            parm();
        else if (key == "end")
            end();
        else if (key == "f" || key == "fo") {
            if (n_faces_++ == 0) first_face_ = words_[0].at;
        } else if (key == "curv" || key == "curv2") {
            in_curve_ = true;
        } else if (key == "trim" || key == "hole") {
            refuse("trimmed surfaces are not read");
        } else if (key == "bzp" || key == "bsp" || key == "cdc" || key == "cdp" || key == "res") {
            refuse("statements from before version 3 of the format are not read");
        }
        // Anything else is about looks, groups, polygons' corners or connectivity.
    }

    [[noreturn]] void refuse(const std::string& why) const
    {
        throw TextFault{words_[0].at, shown_word(words_[0].at, cursor_.end) + ": " + why};
    }

    double number(std::size_t k) const
    {
        if (k >= words_.size()) refuse("a number is missing");
        const auto& [at, text] = words_[k];
        double value = 0.0;
        const char* end = parse_number(at, at + text.size(), value);
        if (end != at + text.size())
            throw TextFault{at, "expected a number, not " + shown_word(at, cursor_.end)};
        return value;
    }

    void vertex()
    {
        if (words_.size() < 4) refuse("three coordinates are needed");
        Vertex v{{{number(1), number(2), number(3)}}};
        // Three more numbers would be a colour.
        if (words_.size() == 5) v.weight = number(4);
        vertices_.push_back(v);
    }

    void type()
    {
        rational_ = words_.size() > 2 && words_[1].text == "rat";
        if (words_.size() != (rational_ ? 3u : 2u)) refuse("one type is needed");
        type_ = words_.back();
    }

    void degrees()
    {
        for (std::size_t k = 0; k < 2; ++k) {
            if (k + 1 >= words_.size()) {
                degree_[k] = -1;  // that of a curve
                continue;
            }
            const double d = number(k + 1);
            if (!(d >= 1.0 && d <= kMaxDegree) || d != std::floor(d))
                refuse("the degree " + genus::to_text(d) + " is no whole number from 1 to " +
                       std::to_string(kMaxDegree));
            degree_[k] = static_cast<int>(d);
        }
    }

    void surf()
    {
        if (surface_) refuse("the surface before has no end");
        if (type_.text != "bezier" && type_.text != "bspline")
            refuse("only surfaces of cstype bezier and bspline are read");
        if (degree_[0] < 1 || degree_[1] < 1) refuse("two degrees are needed before, by deg");
        Surface s{words_[0].at, {number(1), number(2), number(3), number(4)}, {}, {}};
        if (!(s.range[0] < s.range[1] && s.range[2] < s.range[3]))
            refuse("its range of parameters is empty");
        for (std::size_t k = 5; k < words_.size(); ++k) s.vertices.push_back(vertex_index(k));
        surface_ = std::move(s);
    }

    // From 0, of "7", "7/1", "7/1/2", "-1".
    std::int64_t vertex_index(std::size_t k) const
    {
        const auto& [at, text] = words_[k];
        std::int64_t i = 0;
        const char* end = parse_integer(at, at + text.size(), i);
        const auto n = static_cast<std::int64_t>(vertices_.size());
        if (end != at + text.size() && *end != '/')
            throw TextFault{at,
                            "expected the number of a vertex, not " + shown_word(at, cursor_.end)};
        const std::int64_t from_0 = i < 0 ? n + i : i - 1;
        if (from_0 < 0 || from_0 >= n || i == 0)
            throw TextFault{at, "there is no vertex " + std::to_string(i) + " among the " +
                                    std::to_string(n) + " so far"};
        return from_0;
    }

    void parm()
    {
        if (!surface_) {
            if (!in_curve_) refuse("there is no surface before");
            return;
        }
        if (words_.size() < 4 || (words_[1].text != "u" && words_[1].text != "v"))
            refuse("u or v and two numbers or more are needed");
        std::vector<double>& values = surface_->parameters[words_[1].text == "u" ? 0 : 1];
        values.clear();
        for (std::size_t k = 2; k < words_.size(); ++k) values.push_back(number(k));
    }

    void end()
    {
        in_curve_ = false;
        if (!surface_) return;
        const Surface s = std::move(*surface_);
        surface_.reset();
        try {
            add_pieces(s);
        } catch (const InvalidInput& problem) {
            throw TextFault{s.at, std::string("the surface: ") + problem.what()};
        }
    }

    std::vector<double> knots(const Surface& s, std::size_t k) const
    {
        std::vector<double> values = s.parameters[k];
        if (type_.text == "bspline") {
            if (values.empty()) throw TextFault{s.at, "the surface has no knots: parm is missing"};
            return values;
        }
        if (values.empty()) values = {s.range[2 * k], s.range[2 * k + 1]};
        std::vector<double> repeated;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const bool outer = i == 0 || i + 1 == values.size();
            repeated.insert(repeated.end(), static_cast<std::size_t>(degree_[k]) + (outer ? 1 : 0),
                            values[i]);
        }
        return repeated;
    }

    void add_pieces(const Surface& s)
    {
        const KnotVector u(degree_[0], knots(s, 0)), v(degree_[1], knots(s, 1));
        const auto m = static_cast<std::size_t>(u.n_points()),
                   n = static_cast<std::size_t>(v.n_points());
        if (s.vertices.size() != m * n)
            throw TextFault{s.at, "the surface has " + std::to_string(s.vertices.size()) +
                                      " control points, degrees and parameters ask for " +
                                      std::to_string(m) + " x " + std::to_string(n)};
        std::vector<Vec3> points(m * n);
        std::vector<double> weights(rational_ ? m * n : 0);
        std::size_t next_vertex = 0;
        for (const std::size_t k : u_fastest(u.n_points() - 1, v.n_points() - 1)) {
            const Vertex& x = vertices_[static_cast<std::size_t>(s.vertices[next_vertex++])];
            points[k] = x.p;
            if (rational_) weights[k] = x.weight;
        }
        const std::vector<TensorPatch> pieces =
            bezier_pieces(u, v, std::move(points), std::move(weights));
        std::size_t next = 0;
        for (const int i : u.spans())
            for (const int j : v.spans()) {
                const auto a = part_of_span(u, i, s.range[0], s.range[1]);
                const auto b = part_of_span(v, j, s.range[2], s.range[3]);
                const TensorPatch& piece = pieces[next++];
                if (!a || !b) continue;
                const bool whole = *a == std::array{0.0, 1.0} && *b == std::array{0.0, 1.0};
                patches_.emplace_back(whole ? piece
                                            : piece.part((*a)[0], (*a)[1], (*b)[0], (*b)[1]));
            }
    }

    // A single Bezier patch stays as it is, to the last bit.
    std::vector<TensorPatch> bezier_pieces(const KnotVector& u, const KnotVector& v,
                                           std::vector<Vec3> points,
                                           std::vector<double> weights) const
    {
        if (type_.text == "bezier" && u.spans().size() == 1 && v.spans().size() == 1)
            return {TensorPatch(u.degree(), v.degree(), std::move(points), std::move(weights))};
        return BSplineSurface(u, v, std::move(points), std::move(weights)).bezier_patches();
    }

    // What of a span lies in a range, in parameters of the span from 0 to 1.
    static std::optional<std::array<double, 2>> part_of_span(const KnotVector& knots, int k,
                                                             double from, double to)
    {
        const double a = knots[static_cast<std::size_t>(k)],
                     b = knots[static_cast<std::size_t>(k) + 1];
        const double low = std::max(a, from), high = std::min(b, to);
        if (!(low < high)) return std::nullopt;
        return std::array{low == a ? 0.0 : (low - a) / (b - a),
                          high == b ? 1.0 : (high - a) / (b - a)};
    }

    TextCursor cursor_;
    std::vector<Word> words_;
    std::vector<Vertex> vertices_;
    std::vector<Patch> patches_;
    Word type_{nullptr, {}};
    bool rational_ = false, in_curve_ = false;
    std::array<int, 2> degree_{-1, -1};
    std::optional<Surface> surface_;
    std::int64_t n_faces_ = 0, n_lines_ = 0;
    const char* first_face_ = nullptr;
};

}  // namespace

std::vector<Patch> read_obj_surfaces(std::string_view text)
{
    return ObjReader(text).run();
}

std::string obj_surfaces_text(const std::vector<Patch>& patches)
{
    std::string text;
    std::size_t n_vertices = 0;
    for (std::size_t k = 0; k < patches.size(); ++k) {
        const auto* p = std::get_if<TensorPatch>(&patches[k]);
        if (!p) cannot_write(k, "is a triangle; an .obj file has none, .bpt and .bv do");
        const int m = p->degree_u(), n = p->degree_v();
        if (m < 1 || n < 1) cannot_write(k, "has degree 0, which an .obj file has not");
        std::string order;
        for (const std::size_t at : u_fastest(m, n)) {
            text += "v " + to_text(p->points()[at]);
            text += p->rational() ? " " + genus::to_text(p->weights()[at]) + "\n" : "\n";
            order += " " + std::to_string(++n_vertices);
        }
        text += std::string("cstype ") + (p->rational() ? "rat " : "") + "bezier\ndeg " +
                std::to_string(m) + " " + std::to_string(n) + "\nsurf 0 1 0 1" + order +
                "\nparm u 0 1\nparm v 0 1\nend\n";
    }
    return text;
}

}  // namespace genus::io
