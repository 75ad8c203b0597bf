#include "genus/io/patch_file.h"

#include <algorithm>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/input_file.h"
#include "genus/io/output_file.h"
#include "genus/io/patch_formats.h"
#include "genus/io/text.h"

namespace genus {

namespace {

using io::TextCursor;
using io::TextFault;

class Reader {
public:
    explicit Reader(std::string_view text) : at_(text) {}

    std::vector<Patch> run()
    {
        at_.skip_space();
        const char* start = at_.p;
        const std::int64_t count = at_.integer("the number of patches");
        if (count < 0 || count > 100'000'000)
            throw TextFault{start, "the number of patches is " + std::to_string(count)};
        std::vector<Patch> patches;
        for (std::int64_t k = 0; k < count; ++k) {
            if (k % 256 == 0) current_progress().check();
            patches.push_back(patch(k, count));
        }
        at_.skip_space();
        if (!at_.at_end())
            throw TextFault{at_.p, "unexpected " + io::shown_word(at_.p, at_.end) + " after " +
                                       std::to_string(count) + " patches"};
        return patches;
    }

private:
    // The numbers of the next line that is not empty.
    std::vector<double> line(const std::string& what)
    {
        at_.skip_space();
        if (at_.at_end()) throw TextFault{at_.p, "the file ends before " + what};
        std::vector<double> numbers;
        start_ = at_.p;
        while (!at_.at_line_end()) {
            if (numbers.size() == 4)
                throw TextFault{at_.p,
                                "unexpected " + io::shown_word(at_.p, at_.end) + " after " + what};
            numbers.push_back(at_.number(what.c_str()));
            at_.skip_blanks();
        }
        return numbers;
    }

    int degree(double number) const
    {
        if (!(number >= 0.0 && number <= kMaxDegree) || number != static_cast<int>(number))
            throw TextFault{start_, "the degree " + to_text(number) +
                                        " is no whole number from 0 to " +
                                        std::to_string(kMaxDegree)};
        return static_cast<int>(number);
    }

    Patch patch(std::int64_t number, std::int64_t count)
    {
        const std::string name =
            "patch " + std::to_string(number + 1) + " of " + std::to_string(count);
        const std::vector<double> head = line("the degrees of " + name);
        if (head.size() > 2)
            throw TextFault{start_, "the degrees of " + name + " are " +
                                        std::to_string(head.size()) + " numbers, not 1 or 2"};
        const int m = degree(head.front()), n = degree(head.back());
        const bool triangle = head.size() == 1;
        const auto wanted = static_cast<std::size_t>(m + 1) *
                            static_cast<std::size_t>(triangle ? n + 2 : n + 1) / (triangle ? 2 : 1);
        const char* first = at_.p;
        std::vector<Vec3> points;
        std::vector<double> weights;
        for (std::size_t i = 0; i < wanted; ++i) read_point(name, i, points, weights);
        try {
            if (triangle) return BezierTriangle(n, std::move(points), std::move(weights));
            return TensorPatch(m, n, std::move(points), std::move(weights));
        } catch (const InvalidInput& problem) {
            throw TextFault{first, name + ": " + problem.what()};
        }
    }

    void read_point(const std::string& name, std::size_t i, std::vector<Vec3>& points,
                    std::vector<double>& weights)
    {
        const std::string what = "point " + std::to_string(i + 1) + " of " + name;
        const std::vector<double> p = line(what);
        if (p.size() < 3)
            throw TextFault{start_,
                            what + " has " + std::to_string(p.size()) + " numbers, not 3 or 4"};
        if (i > 0 && (p.size() == 4) != (weights.size() == i))
            throw TextFault{start_, what + " has a weight, others none, or the other way round"};
        if (p.size() == 4 && !(p[3] > 0.0))
            throw TextFault{
                start_, "the weight of " + what + " is " + to_text(p[3]) + ", must be positive"};
        points.push_back({{p[0], p[1], p[2]}});
        if (p.size() == 4) weights.push_back(p[3]);
    }

    TextCursor at_;
    const char* start_ = nullptr;  // of the line read last
};

template <class P>
std::string text_of(const P& patch)
{
    std::string text;
    for (std::size_t i = 0; i < patch.points().size(); ++i) {
        const Vec3& p = patch.points()[i];
        text += to_text(p[0]) + " " + to_text(p[1]) + " " + to_text(p[2]);
        if (patch.rational()) text += " " + to_text(patch.weights()[i]);
        text += "\n";
    }
    return text;
}

std::string head_of(const TensorPatch& p)
{
    return std::to_string(p.degree_u()) + " " + std::to_string(p.degree_v()) + "\n";
}

std::string head_of(const BezierTriangle& p)
{
    return std::to_string(p.degree()) + "\n";
}

bool has_extension(std::string_view path, std::string_view extension)
{
    if (path.size() <= extension.size()) return false;
    path.remove_prefix(path.size() - extension.size());
    return std::equal(path.begin(), path.end(), extension.begin(),
                      [](char a, char b) { return io::to_lower(a) == b; });
}

std::vector<Patch> parse(std::string_view text, const std::string& name)
{
    if (io::is_geomview(text))
        return io::with_lines(text, name, [&] { return io::read_geomview(text); });
    if (has_extension(name, ".obj"))
        return io::with_lines(text, name, [&] { return io::read_obj_surfaces(text); });
    if (has_extension(name, ".bv"))
        return io::with_lines(text, name, [&] { return io::read_bezier_view(text); });
    if (io::is_newell(text)) {
        std::string blanks(text);
        std::replace(blanks.begin(), blanks.end(), ',', ' ');
        return io::with_lines(blanks, name, [&] { return io::read_newell(blanks); });
    }
    return io::with_lines(text, name, [&] { return Reader(text).run(); });
}

std::string bpt_text(const std::vector<Patch>& patches)
{
    std::string text = std::to_string(patches.size()) + "\n";
    for (const Patch& patch : patches)
        std::visit([&](const auto& p) { text += head_of(p) + text_of(p); }, patch);
    return text;
}

std::string text_for(const std::string& path, const std::vector<Patch>& patches)
{
    if (has_extension(path, ".bv")) return io::bezier_view_text(patches);
    if (has_extension(path, ".bez") || has_extension(path, ".bbp"))
        return io::geomview_text(patches);
    if (has_extension(path, ".obj")) return io::obj_surfaces_text(patches);
    return bpt_text(patches);
}

}  // namespace

std::vector<Patch> parse_patches(const std::string& text, const std::string& name)
{
    return parse(text, name);
}

std::vector<Patch> read_patches(const std::string& path)
{
    const io::InputFile file(path);
    return parse(io::as_text(file.bytes()), path);
}

void write_patches(const std::string& path, const std::vector<Patch>& patches)
{
    const std::string text = text_for(path, patches);
    io::OutputFile out(path);
    out.write(text);
    out.commit();
}

}  // namespace genus
