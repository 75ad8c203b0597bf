#include "genus/io/patch_formats.h"

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>
#include <type_traits>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/text.h"

namespace genus::io {

namespace {

Vec3 point(TextCursor& at, const std::string& what)
{
    Vec3 p;
    for (double& c : p.c) c = at.number(what.c_str());
    return p;
}

std::vector<Vec3> points(TextCursor& at, std::size_t n, const std::string& name)
{
    std::vector<Vec3> p;
    for (std::size_t i = 0; i < n; ++i)
        p.push_back(point(at, "point " + std::to_string(i + 1) + " of " + name));
    return p;
}

std::string name_of(std::size_t number)
{
    return "patch " + std::to_string(number + 1);
}

std::size_t grid_size(int m, int n)
{
    return static_cast<std::size_t>(m + 1) * static_cast<std::size_t>(n + 1);
}

std::size_t triangle_size(int n)
{
    return grid_size(n, n + 1) / 2;
}

int read_degree(TextCursor& at, const std::string& of)
{
    at.skip_space();
    const char* start = at.p;
    const std::int64_t degree = at.integer(("the degrees of " + of).c_str());
    if (degree < 0 || degree > kMaxDegree)
        throw TextFault{start, "the degree " + std::to_string(degree) +
                                   " is no whole number from 0 to " + std::to_string(kMaxDegree)};
    return static_cast<int>(degree);
}

}  // namespace

std::string to_text(const Vec3& p)
{
    return genus::to_text(p[0]) + " " + genus::to_text(p[1]) + " " + genus::to_text(p[2]);
}

std::vector<std::size_t> u_fastest(int degree_u, int degree_v)
{
    std::vector<std::size_t> order;
    for (int j = 0; j <= degree_v; ++j)
        for (int i = 0; i <= degree_u; ++i)
            order.push_back(static_cast<std::size_t>(i * (degree_v + 1) + j));
    return order;
}

void cannot_write(std::size_t number, const std::string& why)
{
    throw InvalidInput("write_patches: " + name_of(number) + " " + why);
}

// ---- Newell

bool is_newell(std::string_view text)
{
    TextCursor at(text);
    at.word();
    at.skip_space();
    const char* start = at.p;
    at.skip_comment();
    return std::find(start, at.p, ',') != at.p;
}

std::vector<Patch> read_newell(std::string_view text)
{
    TextCursor at(text);
    const auto count = [&](const char* what) {
        at.skip_space();
        const char* start = at.p;
        const std::int64_t n = at.integer(what);
        if (n < 0 || n > 100'000'000)
            throw TextFault{start, std::string(what) + " is " + std::to_string(n)};
        return n;
    };
    struct Index {
        const char* at;
        std::int64_t number;
    };
    std::vector<Index> indices;
    for (std::int64_t k = 16 * count("the number of patches"); k > 0; --k) {
        if (k % 4096 == 0) current_progress().check();
        at.skip_space();
        const char* start = at.p;
        indices.push_back({start, at.integer("the numbers of the points of all patches")});
    }
    std::vector<Vec3> all;
    for (std::int64_t k = count("the number of points"); k > 0; --k)
        all.push_back(point(at, "all points"));
    at.skip_space();
    if (!at.at_end())
        throw TextFault{at.p, "unexpected " + shown_word(at.p, at.end) + " after all points"};
    std::vector<Patch> patches;
    for (std::size_t first = 0; first < indices.size(); first += 16) {
        std::vector<Vec3> net;
        for (std::size_t k = first; k < first + 16; ++k) {
            const auto [start, i] = indices[k];
            if (i < 1 || i > static_cast<std::int64_t>(all.size()))
                throw TextFault{start, "there is no point " + std::to_string(i) + ", only 1 to " +
                                           std::to_string(all.size())};
            net.push_back(all[static_cast<std::size_t>(i) - 1]);
        }
        patches.emplace_back(TensorPatch(3, 3, std::move(net)));
    }
    return patches;
}

// ---- BezierView

std::vector<Patch> read_bezier_view(std::string_view text)
{
    TextCursor at(text);
    std::vector<Patch> patches;
    for (at.skip_space(); !at.at_end(); at.skip_space()) {
        current_progress().check();
        const std::string name = name_of(patches.size());
        const char* start = at.p;
        if (at.word() == "Group") {
            at.skip_comment();  // its number and name
            continue;
        }
        at.p = start;
        const std::int64_t kind = at.integer("a kind of patch");
        if (kind == 3 || kind == 9) {
            const int n = read_degree(at, name);
            const int normals = kind == 9 ? read_degree(at, name) : -1;
            patches.emplace_back(BezierTriangle(n, points(at, triangle_size(n), name)));
            if (kind == 9) points(at, triangle_size(normals), "the normals of " + name);
        } else if (kind == 4 || kind == 5 || kind == 10) {
            const int m = read_degree(at, name), n = kind == 4 ? m : read_degree(at, name);
            std::array<int, 2> normals{};
            if (kind == 10)
                for (int& d : normals) d = read_degree(at, name);
            patches.emplace_back(TensorPatch(m, n, points(at, grid_size(m, n), name)));
            if (kind == 10) points(at, grid_size(normals[0], normals[1]), "the normals of " + name);
        } else {
            throw TextFault{start, name + " is of kind " + std::to_string(kind) +
                                       "; 3, 4, 5, 9 and 10 are read"};
        }
    }
    return patches;
}

std::string bezier_view_text(const std::vector<Patch>& patches)
{
    std::string text;
    for (std::size_t k = 0; k < patches.size(); ++k)
        std::visit(
            [&](const auto& p) {
                if (p.rational())
                    cannot_write(k, "has weights; a .bv file has none, .bpt and .obj do");
                if constexpr (std::is_same_v<decltype(p), const TensorPatch&>)
                    text += "5\n" + std::to_string(p.degree_u()) + " " +
                            std::to_string(p.degree_v()) + "\n";
                else
                    text += "3\n" + std::to_string(p.degree()) + "\n";
                for (const Vec3& x : p.points()) text += to_text(x) + "\n";
            },
            patches[k]);
    return text;
}

// ---- Geomview

namespace {

struct GeomviewHead {
    int m = 3, n = 3, dimension = 3;
    int n_extra = 0;  // numbers after the points of a patch: texture coordinates, colours
};

std::optional<GeomviewHead> geomview_head(std::string_view word)
{
    GeomviewHead head;
    if (word == "BBP") return head;
    if (word == "STBBP") {
        head.n_extra = 8;
        return head;
    }
    if (word.starts_with("C")) {
        head.n_extra += 16;
        word.remove_prefix(1);
    }
    if (word.ends_with("_ST")) {
        head.n_extra += 8;
        word.remove_suffix(3);
    }
    if (word.size() != 6 || !word.starts_with("BEZ")) return std::nullopt;
    std::array<int, 3> digits{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!is_digit(word[k + 3])) return std::nullopt;
        digits[k] = word[k + 3] - '0';
    }
    std::tie(head.m, head.n, head.dimension) = std::tuple_cat(digits);
    const bool in_range = head.m >= 1 && head.m <= 6 && head.n >= 1 && head.n <= 6;
    if (!in_range || head.dimension < 3 || head.dimension > 4) return std::nullopt;
    return head;
}

}  // namespace

bool is_geomview(std::string_view text)
{
    return geomview_head(first_word(text)).has_value();
}

std::vector<Patch> read_geomview(std::string_view text)
{
    TextCursor at(text);
    at.skip_space();
    const char* start = at.p;
    const auto head = geomview_head(at.word());
    if (!head)
        throw TextFault{start, "expected BBP or BEZ with two degrees from 1 to 6 and 3 or 4"};
    const auto [m, n, dimension, n_extra] = *head;
    std::vector<Patch> patches;
    for (at.skip_space(); !at.at_end(); at.skip_space()) {
        current_progress().check();
        const std::string name = name_of(patches.size());
        std::vector<Vec3> net(grid_size(m, n));
        std::vector<double> weights(dimension == 4 ? net.size() : 0);
        const std::string what = "the points of " + name;
        for (const std::size_t k : u_fastest(m, n)) {
            net[k] = point(at, what);
            if (dimension == 3) continue;
            at.skip_space();
            const char* place = at.p;
            const double w = weights[k] = at.number(what.c_str());
            if (!(w > 0.0))
                throw TextFault{place, "a weight of " + name + " is " + genus::to_text(w) +
                                           ", must be positive"};
            net[k] = net[k] / w;
            if (!is_finite(net[k])) throw TextFault{place, "a point of " + name + " overflows"};
        }
        for (int k = 0; k < n_extra; ++k) at.number(("the colours of " + name).c_str());
        patches.emplace_back(TensorPatch(m, n, std::move(net), std::move(weights)));
    }
    return patches;
}

std::string geomview_text(const std::vector<Patch>& patches)
{
    std::string text;
    std::string head;
    for (std::size_t k = 0; k < patches.size(); ++k) {
        const auto* p = std::get_if<TensorPatch>(&patches[k]);
        if (!p) cannot_write(k, "is a triangle; a file for Geomview has none, .bpt and .bv do");
        const int m = p->degree_u(), n = p->degree_v();
        if (m < 1 || n < 1 || m > 6 || n > 6)
            cannot_write(k, "has a degree out of the 1 to 6 of Geomview");
        const std::string own =
            "BEZ" + std::to_string(m) + std::to_string(n) + (p->rational() ? "4" : "3") + "\n";
        if (k == 0) text = head = own;
        if (own != head)
            cannot_write(k,
                         "has other degrees or weights than the first; in a file for Geomview "
                         "all are alike");
        for (const std::size_t at : u_fastest(m, n)) {
            const double w = p->rational() ? p->weights()[at] : 1.0;
            text += to_text(p->points()[at] * w);
            text += p->rational() ? " " + genus::to_text(w) + "\n" : "\n";
        }
    }
    return text.empty() ? "BBP\n" : text;
}

}  // namespace genus::io
