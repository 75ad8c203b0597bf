#include "genus/base/transform.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "genus/base/error.h"
#include "genus/base/expansion.h"

namespace genus {

namespace {

constexpr double kSingular = 1e-14;  // determinant relative to the product of the row lengths

void require_finite(const Vec3& v, const char* argument)
{
    for (double x : v.c) require(std::isfinite(x), argument, x, "finite");
}

Vec3 row(const Transform& t, int i)
{
    return {{t.m[i][0], t.m[i][1], t.m[i][2]}};
}

// Cofactors of the linear part: cofactor(i, j) belongs to m[i][j].
std::array<Vec3, 3> cofactors(const Transform& t)
{
    const Vec3 a = row(t, 0), b = row(t, 1), c = row(t, 2);
    return {cross(b, c), cross(c, a), cross(a, b)};
}

Transform inverse_affine(const Transform& t)
{
    const auto cofactor = cofactors(t);
    const double det = dot(row(t, 0), cofactor[0]);
    const double lengths = norm(row(t, 0)) * norm(row(t, 1)) * norm(row(t, 2));
    require(std::fabs(det) > kSingular * lengths && std::isfinite(det),
            "inverse: the map is singular, it flattens space");
    Transform result;
    const Vec3 shift{{t.m[0][3], t.m[1][3], t.m[2][3]}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) result.m[i][j] = cofactor[j][i] / det;
        result.m[i][3] = -dot(row(result, i), shift);
    }
    return result;
}

// Gauss-Jordan with row scaling and partial pivoting, for projections.
Transform inverse_general(const Transform& t)
{
    auto a = t.m;
    auto b = Transform{}.m;
    for (int i = 0; i < 4; ++i) {
        double largest = 0.0;
        for (double x : a[i]) largest = std::max(largest, std::fabs(x));
        require(largest > 0.0 && std::isfinite(largest), "inverse: the map is singular");
        for (int j = 0; j < 4; ++j) {
            a[i][j] /= largest;
            b[i][j] /= largest;
        }
    }
    for (int k = 0; k < 4; ++k) {
        int pivot = k;
        for (int i = k + 1; i < 4; ++i)
            if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
        require(std::fabs(a[pivot][k]) > kSingular, "inverse: the map is singular");
        std::swap(a[k], a[pivot]);
        std::swap(b[k], b[pivot]);
        for (int i = 0; i < 4; ++i) {
            if (i == k) continue;
            const double factor = a[i][k] / a[k][k];
            for (int j = 0; j < 4; ++j) {
                a[i][j] -= factor * a[k][j];
                b[i][j] -= factor * b[k][j];
            }
        }
    }
    Transform result;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) result.m[i][j] = b[i][j] / a[i][i];
    return result;
}

// Rotation by the angle with this sine and cosine in the plane of axes i and j, i towards j.
Transform plane_rotation(int i, int j, double degrees)
{
    require(std::isfinite(degrees), "rotation: degrees", degrees, "finite");
    const double s = sin_degrees(degrees), c = cos_degrees(degrees);
    Transform t;
    t.m[i][i] = c;
    t.m[i][j] = -s;
    t.m[j][i] = s;
    t.m[j][j] = c;
    return t;
}

// Taylor sums on [0, pi/4]: the first term left out is below 2^-60 of the result.
double sine_series(double x, double low)
{
    const double z = x * x;
    const double p =
        -1.0 / 6 +
        z * (1.0 / 120 +
             z * (-1.0 / 5040 +
                  z * (1.0 / 362880 +
                       z * (-1.0 / 39916800 +
                            z * (1.0 / 6227020800.0 +
                                 z * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0)))))));
    return x + (x * z * p + low * (1.0 - 0.5 * z));
}

double cosine_series(double x, double low)
{
    const double z = x * x;
    const double p =
        1.0 / 24 +
        z * (-1.0 / 720 +
             z * (1.0 / 40320 + z * (-1.0 / 3628800 + z * (1.0 / 479001600.0 +
                                                           z * (-1.0 / 87178291200.0 +
                                                                z * (1.0 / 20922789888000.0))))));
    return 1.0 - (0.5 * z - (z * z * p - x * low));
}

// Sine of `degrees` in [0, 90].
double sine_first_quadrant(double degrees)
{
    if (degrees == 30.0) return 0.5;
    const bool from_above = degrees > 45.0;
    const double rest = from_above ? 90.0 - degrees : degrees;  // exact: Sterbenz
    // pi / 180 in two doubles.
    constexpr double kHigh = 0.017453292519943295, kLow = 2.9486522708701687e-19;
    const TwoTerms radians = two_product(rest, kHigh);
    const double low = radians.low + rest * kLow;
    return from_above ? cosine_series(radians.high, low) : sine_series(radians.high, low);
}

}  // namespace

bool Transform::is_affine() const
{
    return m[3][0] == 0.0 && m[3][1] == 0.0 && m[3][2] == 0.0 && m[3][3] == 1.0;
}

Transform operator*(const Transform& a, const Transform& b)
{
    Transform c;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            double sum = 0.0;
            for (int k = 0; k < 4; ++k) sum += a.m[i][k] * b.m[k][j];
            c.m[i][j] = sum;
        }
    return c;
}

Transform translation(const Vec3& by)
{
    require_finite(by, "translation: by");
    Transform t;
    for (int i = 0; i < 3; ++i) t.m[i][3] = by[i];
    return t;
}

Transform scaling(const Vec3& factors)
{
    require_finite(factors, "scaling: factors");
    Transform t;
    for (int i = 0; i < 3; ++i) t.m[i][i] = factors[i];
    return t;
}

Transform shear(const std::array<double, 6>& factors)
{
    Transform t;
    int next = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            if (i == j) continue;
            require(std::isfinite(factors[next]), "shear: factor", factors[next], "finite");
            t.m[i][j] = factors[next++];
        }
    return t;
}

Transform rotation_x(double degrees)
{
    return plane_rotation(1, 2, degrees);
}

Transform rotation_y(double degrees)
{
    return plane_rotation(2, 0, degrees);
}

Transform rotation_z(double degrees)
{
    return plane_rotation(0, 1, degrees);
}

Transform rotation(const Vec3& degrees)
{
    return rotation_z(degrees[2]) * rotation_y(degrees[1]) * rotation_x(degrees[0]);
}

Transform rotation(double degrees, const Vec3& axis)
{
    require(std::isfinite(degrees), "rotation: degrees", degrees, "finite");
    require_finite(axis, "rotation: axis");
    const Vec3 u = normalized(axis);
    require(dot(u, u) > 0.0, "rotation: the axis is the zero vector");
    const double s = sin_degrees(degrees), c = cos_degrees(degrees);
    // u u^T by the square of the length, where that is no over- or underflow, and s [u]x divided
    // last: a third of a turn about (1, 1, 1) then permutes the axes exactly.
    const bool moderate = norm(axis) > 1e-100 && norm(axis) < 1e100;
    const Vec3 v = moderate ? axis : u;
    const double squared = dot(v, v), length = norm(v);
    // R = c I + s [u]x + (1 - c) u u^T
    const std::array<Vec3, 3> turn{
        {{{0.0, -v[2], v[1]}}, {{v[2], 0.0, -v[0]}}, {{-v[1], v[0], 0.0}}}};
    Transform t;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            t.m[i][j] =
                (i == j ? c : 0.0) + s * turn[i][j] / length + (1.0 - c) * (v[i] * v[j] / squared);
    return t;
}

Transform mirror(const Vec3& normal)
{
    require_finite(normal, "mirror: normal");
    const double squared = dot(normal, normal);
    require(squared > 0.0, "mirror: the normal is the zero vector");
    Transform t;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            t.m[i][j] = (i == j ? 1.0 : 0.0) - 2.0 * normal[i] * normal[j] / squared;
    return t;
}

Transform look_at(const Vec3& eye, const Vec3& target, const Vec3& up)
{
    require_finite(eye, "look_at: eye");
    const Vec3 back = normalized(eye - target);
    require(dot(back, back) > 0.0, "look_at: eye and target are the same point");
    const Vec3 right = normalized(cross(up, back));
    require(dot(right, right) > 0.0, "look_at: up is zero or along the view direction");
    const std::array<Vec3, 3> axes{right, cross(back, right), back};
    Transform t;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) t.m[i][j] = axes[i][j];
        t.m[i][3] = -dot(axes[i], eye);
    }
    return t;
}

Transform perspective(double field_of_view, double aspect, double near_plane, double far_plane)
{
    require(field_of_view > 0.0 && field_of_view < 180.0, "perspective: field_of_view",
            field_of_view, "between 0 and 180 degrees");
    require(aspect > 0.0 && std::isfinite(aspect), "perspective: aspect", aspect, "positive");
    require(near_plane > 0.0 && std::isfinite(near_plane), "perspective: near_plane", near_plane,
            "positive");
    require(far_plane > near_plane && std::isfinite(far_plane), "perspective: far_plane", far_plane,
            "beyond near_plane");
    const double half = 0.5 * field_of_view;
    const double f = cos_degrees(half) / sin_degrees(half);
    Transform t;
    t.m = {};
    t.m[0][0] = f / aspect;
    t.m[1][1] = f;
    t.m[2][2] = -(far_plane + near_plane) / (far_plane - near_plane);
    t.m[2][3] = -2.0 * far_plane * near_plane / (far_plane - near_plane);
    t.m[3][2] = -1.0;
    return t;
}

Transform orthographic(const Box3& box)
{
    require_finite(box.min, "orthographic: box");
    require_finite(box.max, "orthographic: box");
    Transform t;
    for (int i = 0; i < 3; ++i) {
        const double size = box.max[i] - box.min[i];
        require(size > 0.0, "orthographic: side of the box", size, "positive");
        // The camera looks along -z: the far side of the box, its least z, goes to +1.
        const double sign = i == 2 ? -1.0 : 1.0;
        t.m[i][i] = sign * 2.0 / size;
        t.m[i][3] = -sign * (box.max[i] + box.min[i]) / size;
    }
    return t;
}

double determinant(const Transform& t)
{
    return dot(row(t, 0), cofactors(t)[0]);
}

// The largest eigenvalue of M^T M is at most its largest sum of absolute values in a row.
double largest_stretch(const Transform& t)
{
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        double sum = 0.0;
        for (int j = 0; j < 3; ++j) {
            double entry = 0.0;
            for (int k = 0; k < 3; ++k) entry += t.m[k][i] * t.m[k][j];
            sum += std::fabs(entry);
        }
        largest = std::max(largest, sum);
    }
    return std::sqrt(largest);
}

Transform inverse(const Transform& t)
{
    return t.is_affine() ? inverse_affine(t) : inverse_general(t);
}

Vec3 apply(const Transform& t, const Vec3& point)
{
    Vec3 image = apply_vector(t, point);
    for (int i = 0; i < 3; ++i) image[i] += t.m[i][3];
    if (t.is_affine()) return image;
    const double w = t.m[3][0] * point[0] + t.m[3][1] * point[1] + t.m[3][2] * point[2] + t.m[3][3];
    return image / w;
}

Vec3 apply_vector(const Transform& t, const Vec3& vector)
{
    return {{dot(row(t, 0), vector), dot(row(t, 1), vector), dot(row(t, 2), vector)}};
}

Vec3 apply_normal(const Transform& t, const Vec3& normal)
{
    const auto cofactor = cofactors(t);
    const double sign = dot(row(t, 0), cofactor[0]) < 0.0 ? -1.0 : 1.0;
    return {{sign * dot(cofactor[0], normal), sign * dot(cofactor[1], normal),
             sign * dot(cofactor[2], normal)}};
}

Box3 apply(const Transform& t, const Box3& box)
{
    if (box.empty()) return box;
    Box3 image;
    for (int i = 0; i < 3; ++i) {
        double low = t.m[i][3], high = t.m[i][3];
        for (int j = 0; j < 3; ++j) {
            const double factor = t.m[i][j];
            if (factor == 0.0) continue;  // an infinite side does not matter here
            low += factor > 0.0 ? factor * box.min[j] : factor * box.max[j];
            high += factor > 0.0 ? factor * box.max[j] : factor * box.min[j];
        }
        image.min[i] = low;
        image.max[i] = high;
    }
    return image;
}

double sin_degrees(double degrees)
{
    if (!std::isfinite(degrees)) return std::nan("");
    double rest = std::fmod(std::fabs(degrees), 360.0);  // exact
    double sign = degrees < 0.0 ? -1.0 : 1.0;
    if (rest >= 180.0) {
        rest -= 180.0;
        sign = -sign;
    }
    if (rest > 90.0) rest = 180.0 - rest;
    return rest == 0.0 ? 0.0 : sign * sine_first_quadrant(rest);
}

double cos_degrees(double degrees)
{
    if (!std::isfinite(degrees)) return std::nan("");
    double rest = std::fmod(std::fabs(degrees), 360.0);
    if (rest > 180.0) rest = 360.0 - rest;
    // 90 - rest is exact from 45 up; below, the cosine series takes the angle itself.
    if (rest >= 45.0) {
        const double complement = 90.0 - rest;
        if (complement == 0.0) return 0.0;
        return complement > 0.0 ? sine_first_quadrant(complement)
                                : -sine_first_quadrant(-complement);
    }
    constexpr double kHigh = 0.017453292519943295, kLow = 2.9486522708701687e-19;
    const TwoTerms radians = two_product(rest, kHigh);
    return cosine_series(radians.high, radians.low + rest * kLow);
}

}  // namespace genus
