#include "genus/deform/deform_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "genus/base/error.h"
#include "genus/base/progress.h"

namespace genus {

namespace {

constexpr std::int32_t kNone = -1;

std::size_t at(std::int32_t i)
{
    return static_cast<std::size_t>(i);
}

std::uint64_t key_of(std::int32_t a, std::int32_t b)
{
    if (a > b) std::swap(a, b);
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
}

// Triangles whose sides are split all at once, by a point each. Points that belong to the vertices,
// if there are any, are split alike.
class Splitter {
public:
    explicit Splitter(IndexedMesh& mesh, std::vector<Vec3>* images = nullptr)
        : mesh_(mesh), images_(images)
    {
    }

    // `share`: of the way from a to b.
    void mark(std::int32_t a, std::int32_t b, double share)
    {
        const auto [place, added] = points_.emplace(key_of(a, b), 0);
        if (!added) return;
        place->second = static_cast<std::int32_t>(mesh_.vertices.size());
        add_point(mesh_.vertices, a, b, share);
        if (images_) add_point(*images_, a, b, share);
    }
    bool any() const { return !points_.empty(); }

    void run()
    {
        std::vector<Triangle> faces;
        faces.reserve(mesh_.faces.size() + 2 * points_.size());
        for (const Triangle& t : mesh_.faces) split(t, faces);
        mesh_.faces = std::move(faces);
        points_.clear();
    }

private:
    static void add_point(std::vector<Vec3>& points, std::int32_t a, std::int32_t b, double share)
    {
        points.push_back(points[at(a)] * (1.0 - share) + points[at(b)] * share);
    }

    std::int32_t point(std::int32_t a, std::int32_t b) const
    {
        const auto place = points_.find(key_of(a, b));
        return place == points_.end() ? kNone : place->second;
    }

    void split(const Triangle& t, std::vector<Triangle>& out) const
    {
        std::array<std::int32_t, 3> middle;  // of the side from corner k
        int count = 0, first = 0;
        for (int k = 0; k < 3; ++k) {
            middle[at(k)] = point(t[at(k)], t[at((k + 1) % 3)]);
            count += middle[at(k)] != kNone;
        }
        if (count == 0) {
            out.push_back(t);
            return;
        }
        // Turned so that with one point it is on the first side, with two the last side has none.
        while (count == 1 ? middle[at(first)] == kNone
                          : count == 2 && middle[at((first + 2) % 3)] != kNone)
            ++first;
        const std::int32_t a = t[at(first)], b = t[at((first + 1) % 3)], c = t[at((first + 2) % 3)];
        const std::int32_t ab = middle[at(first)], bc = middle[at((first + 1) % 3)];
        const std::int32_t ca = middle[at((first + 2) % 3)];
        if (count == 1) {
            out.push_back({a, ab, c});
            out.push_back({ab, b, c});
        } else if (count == 2) {
            out.push_back({ab, b, bc});
            // The shorter diagonal of what is left.
            const auto length = [&](std::int32_t p, std::int32_t q) {
                return distance(mesh_.vertices[at(p)], mesh_.vertices[at(q)]);
            };
            if (length(a, bc) <= length(ab, c)) {
                out.push_back({a, ab, bc});
                out.push_back({a, bc, c});
            } else {
                out.push_back({ab, bc, c});
                out.push_back({a, ab, c});
            }
        } else {
            out.push_back({a, ab, ca});
            out.push_back({ab, b, bc});
            out.push_back({ca, bc, c});
            out.push_back({ab, bc, ca});
        }
    }

    IndexedMesh& mesh_;
    std::vector<Vec3>* images_;
    std::unordered_map<std::uint64_t, std::int32_t> points_;
};

// How far the image of a triangle may be from the triangle of the images.
class ImageError {
public:
    explicit ImageError(const Lattice& lattice)
        : lattice_(lattice), n_(boxes_of(lattice)), second_(lattice.second_bounds(n_))
    {
    }

    // Of the triangle, and the side that has the largest share in it.
    double of(const std::array<Vec3, 3>& p, int& worst_side) const
    {
        std::array<Vec3, 3> s;
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            s[k] = lattice_.local(p[k]);
            box.add(s[k]);
        }
        worst_side = 0;
        const std::array<double, 6> d = largest_over(box);
        double worst = -1.0;
        for (int k = 0; k < 3; ++k) {
            const Vec3 side = s[at((k + 1) % 3)] - s[at(k)];
            const double error = form(d, side);
            if (error <= worst) continue;
            worst = error;
            worst_side = k;
        }
        return form(d, box.size());
    }

private:
    // Few where the degree makes each box dear.
    static int boxes_of(const Lattice& lattice)
    {
        double work = 1.0;
        for (int a = 0; a < 3; ++a) work *= lattice.degree(a) + 1;
        return work <= 64.0 ? 12 : work <= 1000.0 ? 8 : work <= 10000.0 ? 4 : 1;
    }

    static double form(const std::array<double, 6>& d, const Vec3& x)
    {
        const double s = std::fabs(x[0]), t = std::fabs(x[1]), u = std::fabs(x[2]);
        return 0.125 * (d[0] * s * s + d[1] * t * t + d[2] * u * u +
                        2.0 * (d[3] * s * t + d[4] * t * u + d[5] * u * s));
    }

    std::array<double, 6> largest_over(const Box3& box) const
    {
        std::array<double, 6> d{};
        std::array<int, 3> low, high;
        for (std::size_t a = 0; a < 3; ++a) {
            // Boxes share their sides: those just beyond count, too.
            if (box.max[a] < 0.0 || box.min[a] > 1.0) return d;
            low[a] = static_cast<int>(std::clamp(box.min[a] * n_ - 1e-9, 0.0, n_ - 1.0));
            high[a] = static_cast<int>(std::clamp(box.max[a] * n_ + 1e-9, 0.0, n_ - 1.0));
        }
        for (int i = low[0]; i <= high[0]; ++i)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int k = low[2]; k <= high[2]; ++k)
                    for (std::size_t e = 0; e < 6; ++e)
                        d[e] = std::max(d[e], second_[at((i * n_ + j) * n_ + k)][e]);
        return d;
    }

    const Lattice& lattice_;
    int n_;
    std::vector<std::array<double, 6>> second_;
};

// Cuts all triangles where coordinate `axis` of (s, t, u) is `value`.
void cut(IndexedMesh& mesh, std::vector<Vec3>* images, const Lattice& lattice, int axis,
         double value)
{
    std::vector<double> side;
    for (const Vec3& p : mesh.vertices) side.push_back(lattice.local(p)[at(axis)] - value);
    Splitter splitter(mesh, images);
    for (const Triangle& t : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t a = std::min(t[k], t[(k + 1) % 3]),
                               b = std::max(t[k], t[(k + 1) % 3]);
            const double x = side[at(a)], y = side[at(b)];
            if (!(x * y < 0.0)) continue;
            splitter.mark(a, b, x / (x - y));
        }
    splitter.run();
}

bool inside(const Lattice& lattice, const Vec3& p)
{
    return Box3{{}, {{1, 1, 1}}}.contains(lattice.local(p));
}

// Kinks: the border where it only holds together, and knots. Returns whether some of the mesh is
// outside.
void cut_at_kinks(IndexedMesh& mesh, std::vector<Vec3>* images, const Lattice& lattice)
{
    const bool all_inside = std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                                        [&](const Vec3& p) { return inside(lattice, p); });
    const int continuity = lattice.border_continuity();
    require(all_inside || continuity >= 0,
            "deform: the solid reaches out of the lattice, whose border moves: it would be torn "
            "(leave the outer control points in place, or let the lattice hold all of it)");
    for (int axis = 0; axis < 3; ++axis) {
        if (!all_inside && continuity < 1)
            for (const double border : {0.0, 1.0}) cut(mesh, images, lattice, axis, border);
        for (const double knot : lattice.kinks(axis)) cut(mesh, images, lattice, axis, knot);
    }
}

void require_few(const IndexedMesh& mesh, double tolerance, std::int64_t max_triangles)
{
    if (static_cast<std::int64_t>(mesh.n_faces()) <= max_triangles) return;
    throw ToleranceNotMet(
        "deform: tolerance " + to_text(tolerance) + " needs more triangles than allowed", tolerance,
        std::numeric_limits<double>::infinity(), {});
}

}  // namespace

DeformedMesh deformed_within(IndexedMesh mesh, const Lattice& lattice, double tolerance,
                             std::int64_t max_triangles)
{
    require(tolerance > 0.0 && std::isfinite(tolerance), "deform: tolerance", tolerance,
            "positive and finite");
    const double rounding = 2.0 * lattice.rounding();
    if (tolerance <= rounding)
        throw ToleranceNotMet("deform: tolerance " + to_text(tolerance) + " is below rounding",
                              tolerance, rounding, {});
    cut_at_kinks(mesh, nullptr, lattice);
    const ImageError error(lattice);
    DeformedMesh result;
    for (;;) {
        current_progress().check();
        require_few(mesh, tolerance, max_triangles);
        result.bound = 0.0;
        Splitter splitter(mesh);
        for (const Triangle& t : mesh.faces) {
            int side = 0;
            const double e = error.of(
                {mesh.vertices[at(t[0])], mesh.vertices[at(t[1])], mesh.vertices[at(t[2])]}, side);
            result.bound = std::max(result.bound, e);
            if (e <= tolerance - rounding) continue;
            const std::int32_t a = t[at(side)], b = t[at((side + 1) % 3)];
            splitter.mark(a, b, 0.5);
        }
        if (!splitter.any()) break;
        splitter.run();
    }
    result.mesh = deformed(mesh, lattice);
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto middle = [&](const IndexedMesh& m) {
            const Triangle& t = m.faces[f];
            return (m.vertices[at(t[0])] + m.vertices[at(t[1])] + m.vertices[at(t[2])]) / 3.0;
        };
        result.measured =
            std::max(result.measured, distance(lattice.apply(middle(mesh)), middle(result.mesh)));
    }
    result.bound += rounding;
    return result;
}

double image_deviation(IndexedMesh source, std::vector<Vec3> images, const Lattice& lattice)
{
    require(images.size() == source.n_vertices(), "image_deviation: one image for each vertex");
    // Between the points of a cut the images are flat still, and the map has no kink.
    cut_at_kinks(source, &images, lattice);
    const ImageError error(lattice);
    std::vector<double> gap(images.size());
    for (std::size_t v = 0; v < gap.size(); ++v)
        gap[v] = distance(lattice.apply(source.vertices[v]), images[v]);
    double largest = 0.0;
    for (const Triangle& t : source.faces) {
        current_progress().check();
        int side = 0;
        const double e = error.of(
            {source.vertices[at(t[0])], source.vertices[at(t[1])], source.vertices[at(t[2])]},
            side);
        largest = std::max(largest, e + std::max({gap[at(t[0])], gap[at(t[1])], gap[at(t[2])]}));
    }
    return largest + 2.0 * lattice.rounding();
}

}  // namespace genus
