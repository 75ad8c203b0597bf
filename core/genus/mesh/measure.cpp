#include "genus/mesh/measure.h"

#include <cmath>
#include <vector>

#include "genus/base/parallel.h"
#include "genus/mesh/sides.h"

namespace genus {

namespace {

// Neumaier's sum: the error stays that of the terms, however many there are.
class Sum {
public:
    void add(double x)
    {
        const double t = sum_ + x;
        rest_ += std::fabs(sum_) >= std::fabs(x) ? (sum_ - t) + x : (x - t) + sum_;
        sum_ = t;
    }
    void add(const Sum& other)
    {
        add(other.sum_);
        rest_ += other.rest_;
    }
    double value() const { return sum_ + rest_; }

private:
    double sum_ = 0.0;
    double rest_ = 0.0;
};

// Integrals over the cone from the origin to a surface: of 1, of x_i, of x_i x_j; and over the
// surface: of 1, of x_i.
struct Integrals {
    Sum one;
    std::array<Sum, 3> linear;
    std::array<std::array<Sum, 3>, 3> quadratic;  // upper triangle
    Sum area;
    std::array<Sum, 3> area_linear;

    void add(const Integrals& other)
    {
        one.add(other.one);
        area.add(other.area);
        for (std::size_t i = 0; i < 3; ++i) {
            linear[i].add(other.linear[i]);
            area_linear[i].add(other.area_linear[i]);
            for (std::size_t j = i; j < 3; ++j) quadratic[i][j].add(other.quadratic[i][j]);
        }
    }

    // For a tetrahedron 0, a, b, c with d = det(a, b, c) and s = a + b + c:
    //   int 1 = d / 6,  int x_i = d s_i / 24,
    //   int x_i x_j = d (s_i s_j + a_i a_j + b_i b_j + c_i c_j) / 120.
    // The constant factors wait for the end.
    void add_face(const Vec3& a, const Vec3& b, const Vec3& c)
    {
        const double d = dot(a, cross(b, c));
        const Vec3 s = a + b + c;
        one.add(d);
        const double twice_area = norm(cross(b - a, c - a));
        area.add(twice_area);
        for (std::size_t i = 0; i < 3; ++i) {
            linear[i].add(d * s[i]);
            area_linear[i].add(twice_area * s[i]);
            for (std::size_t j = i; j < 3; ++j)
                quadratic[i][j].add(d * (s[i] * s[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]));
        }
    }
};

Vec3 middle_of(const IndexedMesh& mesh)
{
    const Box3 box = bounds(mesh);
    return box.empty() ? Vec3{} : box.center();
}

// Chunks are summed in their order, so the result does not depend on who summed which.
template <class Total, class AddFace>
Total sum_over_faces(const IndexedMesh& mesh, const AddFace& add_face)
{
    check_indices(TriangleSides(mesh), mesh.n_vertices());
    constexpr std::size_t kGrain = 16384;
    std::vector<Total> partial((mesh.n_faces() + kGrain - 1) / kGrain);
    parallel_for(mesh.n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
        Total& sum = partial[begin / kGrain];
        for (std::size_t f = begin; f < end; ++f) {
            const auto& [a, b, c] = mesh.faces[f];
            add_face(sum, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
        }
    });
    Total total;
    for (const Total& sum : partial) total.add(sum);
    return total;
}

void set_inertia(Measures& m, const Integrals& total, const Vec3& center)
{
    // Second moments about the centroid (Steiner), then the inertia tensor from them.
    std::array<std::array<double, 3>, 3> moment{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j)
            moment[i][j] = moment[j][i] =
                total.quadratic[i][j].value() / 120.0 - m.volume * center[i] * center[j];
    const double trace = moment[0][0] + moment[1][1] + moment[2][2];
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) m.inertia[i][j] = (i == j ? trace : 0.0) - moment[i][j];
}

}  // namespace

Measures measure(const IndexedMesh& mesh)
{
    const Vec3 origin = middle_of(mesh);
    const auto total = sum_over_faces<Integrals>(
        mesh, [&](Integrals& sum, const Vec3& a, const Vec3& b, const Vec3& c) {
            sum.add_face(a - origin, b - origin, c - origin);
        });
    Measures m;
    m.volume = total.one.value() / 6.0;
    m.area = total.area.value() / 2.0;
    Vec3 center;
    for (std::size_t i = 0; i < 3; ++i) {
        if (m.volume != 0.0)
            center[i] = total.linear[i].value() / (4.0 * total.one.value());
        else if (m.area > 0.0)
            center[i] = total.area_linear[i].value() / (3.0 * total.area.value());
    }
    m.centroid = origin + center;
    set_inertia(m, total, center);
    return m;
}

double volume(const IndexedMesh& mesh)
{
    const Vec3 origin = middle_of(mesh);
    const auto total =
        sum_over_faces<Sum>(mesh, [&](Sum& sum, const Vec3& a, const Vec3& b, const Vec3& c) {
            sum.add(dot(a - origin, cross(b - origin, c - origin)));
        });
    return total.value() / 6.0;
}

double area(const IndexedMesh& mesh)
{
    const auto total =
        sum_over_faces<Sum>(mesh, [](Sum& sum, const Vec3& a, const Vec3& b, const Vec3& c) {
            sum.add(norm(cross(b - a, c - a)));
        });
    return total.value() / 2.0;
}

}  // namespace genus
