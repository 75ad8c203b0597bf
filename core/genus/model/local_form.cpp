#include "genus/model/local_form.h"

#include <algorithm>
#include <cmath>

#include "genus/base/error.h"

namespace genus {
namespace {

constexpr double kUnit = std::numeric_limits<double>::epsilon();
// Sums of positive bounds are made a little larger, which covers their own rounding.
constexpr double kUp = 1.0 + 1e-12;

using EnclosedVec3 = std::array<Enclosure, 3>;

EnclosedVec3 enclosed(const Vec3& v)
{
    return {v[0], v[1], v[2]};
}

Enclosure dot(const EnclosedVec3& a, const EnclosedVec3& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Interval radius_of(double r)
{
    return {-r, r};
}

/// x^T m x + 2 v.x + c about `origin`, m symmetric, in the frame.
EnclosedQuadratic framed(const std::array<EnclosedVec3, 3>& m, const EnclosedVec3& v,
                         const Enclosure& c, const EnclosedVec3& origin, const Frame& frame)
{
    EnclosedVec3 d;
    for (int i = 0; i < 3; ++i) d[i] = Enclosure(frame.o[i]) - origin[i];
    EnclosedVec3 md;
    for (int i = 0; i < 3; ++i) md[i] = dot(m[i], d);
    EnclosedQuadratic q;
    q.c = dot(md, d) + Enclosure(2.0) * dot(v, d) + c;
    std::array<EnclosedVec3, 3> m_axis;
    for (int k = 0; k < 3; ++k) {
        const EnclosedVec3 axis = enclosed(frame.axis[k]);
        for (int i = 0; i < 3; ++i) m_axis[k][i] = dot(m[i], axis);
        q.g[k] = Enclosure(2.0) * (dot(md, axis) + dot(v, axis));
        q.a[k] = dot(m_axis[k], axis);
    }
    for (int i = 0; i < 3; ++i)
        for (int j = i + 1; j < 3; ++j)
            q.a[mixed(i, j)] = Enclosure(2.0) * dot(m_axis[i], enclosed(frame.axis[j]));
    return q;
}

EnclosedQuadratic framed(const Quadric& quadric, const Frame& frame)
{
    const std::array<double, 10>& q = quadric.local();
    return framed({{{q[0], q[1], q[2]}, {q[1], q[4], q[5]}, {q[2], q[5], q[7]}}},
                  {q[3], q[6], q[8]}, q[9], enclosed(quadric.origin()), frame);
}

/// Sum of the absolute values of a quadratic's terms where |x| <= X and so on.
double magnitude(const std::array<double, 6>& a, double x, double y, double z)
{
    return std::fabs(a[0]) * x * x + std::fabs(a[1]) * y * y + std::fabs(a[2]) * z * z +
           std::fabs(a[3]) * y * z + std::fabs(a[4]) * x * z + std::fabs(a[5]) * x * y;
}

/// The same quadratic in (x, y, zeta) with z = a x + b y + zeta.
std::array<double, 6> sheared(const std::array<double, 6>& q, double a, double b)
{
    return {q[0] + a * (q[4] + a * q[2]),
            q[1] + b * (q[3] + b * q[2]),
            q[2],
            q[3] + 2.0 * b * q[2],
            q[4] + 2.0 * a * q[2],
            q[5] + a * q[3] + b * q[4] + 2.0 * a * b * q[2]};
}

/// Bounds of the derivatives of a quadratic where |x| <= X and so on.
Vec3 slopes(const std::array<double, 6>& q, const Vec3& d)
{
    Vec3 sum;
    for (int k = 0; k < 3; ++k) {
        sum[k] = 2.0 * std::fabs(q[k]) * d[k];
        for (int j = 0; j < 3; ++j)
            if (j != k) sum[k] += std::fabs(q[mixed(j, k)]) * d[j];
    }
    return sum;
}

/// Bounds of the derivatives of what an expansion has beyond its linear part.
Vec3 nonlinear_slopes(const LocalForm::Expansion& x, const Vec3& d)
{
    Vec3 sum = slopes(x.a, d);
    const Vec3 du = slopes(x.u, d);
    const double u = magnitude(x.u, d[0], d[1], d[2]);
    double linear = 0.0;
    for (int k = 0; k < 3; ++k) linear += std::fabs(x.sigma[k]) * d[k];
    for (int k = 0; k < 3; ++k) sum[k] += 2.0 * (std::fabs(x.sigma[k]) * u + (linear + u) * du[k]);
    return sum;
}

}  // namespace

FramedSurface::FramedSurface(const Surface& surface, const Frame& frame)
    : quartic(surface.kind == Surface::Kind::Torus)
{
    if (!quartic) {
        s = framed(surface.quadric, frame);
        return;
    }
    // s = |x|^2 + R^2 - r^2 and t = 4 R^2 (x^2 + y^2) with x = to_local p, an affine function.
    const Torus& torus = *surface.torus;
    const Enclosure R(torus.R()), r(torus.r());
    std::array<EnclosedVec3, 3> rows, all, flat;
    EnclosedVec3 shift;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) rows[i][k] = Enclosure(torus.to_local().m[i][k]);
        shift[i] = Enclosure(torus.to_local().m[i][3]);
    }
    EnclosedVec3 all_v, flat_v;
    const auto column = [&](int j) { return EnclosedVec3{rows[0][j], rows[1][j], rows[2][j]}; };
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) {
            const EnclosedVec3 a = column(j), b = column(k);
            flat[j][k] = a[0] * b[0] + a[1] * b[1];
            all[j][k] = flat[j][k] + a[2] * b[2];
        }
        flat_v[j] = column(j)[0] * shift[0] + column(j)[1] * shift[1];
        all_v[j] = flat_v[j] + column(j)[2] * shift[2];
    }
    const Enclosure flat_c = shift[0] * shift[0] + shift[1] * shift[1];
    const EnclosedVec3 zero{};
    s = framed(all, all_v, flat_c + shift[2] * shift[2] + R * R - r * r, zero, frame);
    t = framed(flat, flat_v, flat_c, zero, frame);
    const Enclosure four = Enclosure(4.0) * R * R;
    t.c = four * t.c;
    for (Enclosure& x : t.g) x = four * x;
    for (Enclosure& x : t.a) x = four * x;
}

// ---- One quadratic in a cell

double LocalForm::Part::linear(const Vec3& e) const
{
    return g[0] * e[0] + g[1] * e[1] + g[2] * e[2];
}

double LocalForm::Part::quadratic(const Vec3& e) const
{
    return e[0] * (a[0] * e[0] + a[5] * e[1] + a[4] * e[2]) + e[1] * (a[1] * e[1] + a[3] * e[2]) +
           a[2] * e[2] * e[2];
}

Vec3 LocalForm::Part::slope_of_quadratic(const Vec3& e) const
{
    return {{2.0 * a[0] * e[0] + a[5] * e[1] + a[4] * e[2],
             a[5] * e[0] + 2.0 * a[1] * e[1] + a[3] * e[2],
             a[4] * e[0] + a[3] * e[1] + 2.0 * a[2] * e[2]}};
}

std::array<double, 2> LocalForm::Part::linear_along(int axis, const Vec3& e) const
{
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    return {g[i] * e[i] + g[j] * e[j], g[axis]};
}

std::array<double, 3> LocalForm::Part::quadratic_along(int axis, const Vec3& e) const
{
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    return {e[i] * (a[i] * e[i] + a[mixed(i, j)] * e[j]) + a[j] * e[j] * e[j],
            a[mixed(axis, i)] * e[i] + a[mixed(axis, j)] * e[j], a[axis]};
}

Interval LocalForm::Part::range(const Box3& box) const
{
    const IntervalVec3 e = genus::to_intervals(box);
    const Interval slope = radius_of(eg), bend = radius_of(ea);
    Interval sum = Interval(c) + radius_of(ec);
    for (int k = 0; k < 3; ++k) {
        sum = sum + (Interval(g[k]) + slope) * e[k] + (Interval(a[k]) + bend) * square(e[k]);
        for (int j = 0; j < k; ++j) sum = sum + (Interval(a[mixed(j, k)]) + bend) * (e[j] * e[k]);
    }
    return sum;
}

Interval LocalForm::Part::slope_range(int axis, const Box3& box) const
{
    const IntervalVec3 e = genus::to_intervals(box);
    const Interval bend = radius_of(ea);
    Interval sum = Interval(g[axis]) + radius_of(eg);
    for (int k = 0; k < 3; ++k) {
        const Interval a_k = k == axis ? Interval(2.0) * (Interval(a[k]) + bend)
                                       : Interval(a[mixed(axis, k)]) + bend;
        sum = sum + a_k * e[k];
    }
    return sum;
}

double LocalForm::Part::reach_of_linear(double reach) const
{
    return kUp * reach * (std::fabs(g[0]) + std::fabs(g[1]) + std::fabs(g[2]) + 3.0 * eg);
}

double LocalForm::Part::reach_of_quadratic(double reach) const
{
    double bends = 6.0 * ea;
    for (const double x : a) bends += std::fabs(x);
    return kUp * reach * reach * bends;
}

double LocalForm::Part::reach_of_slope(double reach) const
{
    double slope = 0.0;
    for (int k = 0; k < 3; ++k) slope = std::max(slope, std::fabs(g[k]));
    return kUp * (slope + eg + reach * bend());
}

double LocalForm::Part::slack(double reach) const
{
    const double size = std::fabs(c) + ec + reach_of_linear(reach) + reach_of_quadratic(reach);
    return kUp * (ec + reach * (3.0 * eg + reach * 6.0 * ea)) + 8.0 * kUnit * size;
}

double LocalForm::Part::gradient_slack(double reach) const
{
    return kUp * (eg + 4.0 * reach * ea) + 8.0 * kUnit * reach_of_slope(reach);
}

double LocalForm::Part::bend() const
{
    double most = 0.0;
    for (int i = 0; i < 3; ++i) {
        double sum = 2.0 * std::fabs(a[i]);
        for (int j = 0; j < 3; ++j)
            if (j != i) sum += std::fabs(a[mixed(i, j)]);
        most = std::max(most, sum);
    }
    return kUp * (most + 4.0 * ea);
}

EnclosedQuadratic LocalForm::local(const EnclosedQuadratic& q, const Vec3& center, double half)
{
    const EnclosedVec3 at = enclosed(center);
    const Enclosure h(half), hh = h * h;
    EnclosedQuadratic r;
    r.c = q.c;
    for (int k = 0; k < 3; ++k) {
        // The slope at the middle, and half of what of it the quadratic terms make.
        Enclosure slope = q.g[k] + Enclosure(2.0) * q.a[k] * at[k];
        Enclosure half_slope = q.g[k] + q.a[k] * at[k];
        for (int j = 0; j < 3; ++j) {
            if (j == k) continue;
            const Enclosure product = q.a[mixed(j, k)] * at[j];
            slope = slope + product;
            if (j < k) half_slope = half_slope + product;
        }
        r.c = r.c + half_slope * at[k];
        r.g[k] = h * slope;
    }
    for (std::size_t k = 0; k < 6; ++k) r.a[k] = hh * q.a[k];
    return r;
}

LocalForm::Part LocalForm::rounded(const EnclosedQuadratic& q)
{
    Part part;
    const auto middle = [](const Enclosure& x, double& error) {
        double own = 0.0;
        const double m = x.rounded(own);
        if (!(own <= error)) error = own;  // one that is not a number stays
        return m;
    };
    part.c = middle(q.c, part.ec);
    for (int k = 0; k < 3; ++k) part.g[k] = middle(q.g[k], part.eg);
    for (std::size_t k = 0; k < 6; ++k) part.a[k] = middle(q.a[k], part.ea);
    return part;
}

// ---- The surface in a cell

LocalForm::LocalForm(const FramedSurface& surface, const Vec3& center, double half)
    : quartic_(surface.quartic)
{
    EnclosedQuadratic s = local(surface.s, center, half);
    if (!quartic_) {
        part_ = rounded(s);
        return;
    }
    // (s0 + sigma.e + u)^2 - t, by the order of its terms.
    const EnclosedQuadratic t = local(surface.t, center, half);
    const Enclosure two_s = Enclosure(2.0) * s.c;
    EnclosedQuadratic q;
    q.c = s.c * s.c - t.c;
    for (int k = 0; k < 3; ++k) q.g[k] = two_s * s.g[k] - t.g[k];
    for (std::size_t k = 0; k < 6; ++k) q.a[k] = two_s * s.a[k] - t.a[k];
    for (int k = 0; k < 3; ++k) {
        q.a[k] = q.a[k] + s.g[k] * s.g[k];
        for (int j = 0; j < k; ++j)
            q.a[mixed(j, k)] = q.a[mixed(j, k)] + Enclosure(2.0) * s.g[j] * s.g[k];
    }
    part_ = rounded(q);
    s.c = Enclosure();
    rest_ = rounded(s);
}

LocalForm LocalForm::permuted(const std::array<int, 3>& order) const
{
    const auto turned = [&](const Part& from) {
        Part to = from;
        for (int k = 0; k < 3; ++k) {
            to.g[k] = from.g[order[k]];
            to.a[k] = from.a[order[k]];
            for (int j = 0; j < k; ++j) to.a[mixed(j, k)] = from.a[mixed(order[j], order[k])];
        }
        return to;
    };
    LocalForm result;
    result.quartic_ = quartic_;
    result.part_ = turned(part_);
    result.rest_ = turned(rest_);
    return result;
}

bool LocalForm::is_linear() const
{
    return !quartic_ && part_.bend() == 0.0;
}

double LocalForm::value(const Vec3& e) const
{
    const double low = part_.c + part_.linear(e) + part_.quadratic(e);
    if (!quartic_) return low;
    const double u = rest_.quadratic(e);
    return low + u * (2.0 * rest_.linear(e) + u);
}

Vec3 LocalForm::gradient(const Vec3& e) const
{
    const Vec3 low = part_.g + part_.slope_of_quadratic(e);
    if (!quartic_) return low;
    const double u = rest_.quadratic(e);
    return low + 2.0 * (u * rest_.g + (rest_.linear(e) + u) * rest_.slope_of_quadratic(e));
}

AxisLine LocalForm::along(int axis, const Vec3& e) const
{
    AxisLine line;
    line.low = part_.quadratic_along(axis, e);
    const std::array<double, 2> linear = part_.linear_along(axis, e);
    line.low[0] += part_.c + linear[0];
    line.low[1] += linear[1];
    if (!quartic_) return line;
    line.u = rest_.quadratic_along(axis, e);
    line.l = rest_.linear_along(axis, e);
    return line;
}

Interval LocalForm::range() const
{
    const Interval low = part_.range({Box3::filled(-1.0), Box3::filled(1.0)});
    if (!quartic_) return low;
    const double l = rest_.reach_of_linear(1.0), u = rest_.reach_of_quadratic(1.0);
    return low + radius_of(kUp * (2.0 * l + u) * u);
}

Interval LocalForm::slope_range(int axis, const Box3& box) const
{
    if (!quartic_) return part_.slope_range(axis, box);
    const Expansion x = about(box.center());
    const Vec3 half = 0.5 * box.size();
    double reach = 0.0;
    for (int k = 0; k < 3; ++k)
        reach = std::max({reach, std::fabs(box.min[k]), std::fabs(box.max[k])});
    return Interval(x.gradient[axis]) +
           radius_of(kUp * (nonlinear_slopes(x, half)[axis] + gradient_slack(reach)));
}

double LocalForm::slack(double reach) const
{
    const double low = part_.slack(reach);
    if (!quartic_) return low;
    const double l = rest_.reach_of_linear(reach), u = rest_.reach_of_quadratic(reach);
    const double dl = 3.0 * rest_.eg * reach, du = 6.0 * rest_.ea * reach * reach;
    return kUp * (low + 2.0 * (u * dl + (l + u) * du) + 16.0 * kUnit * (2.0 * l + u) * u);
}

double LocalForm::gradient_slack(double reach) const
{
    const double low = part_.gradient_slack(reach);
    if (!quartic_) return low;
    const double l = rest_.reach_of_linear(reach), u = rest_.reach_of_quadratic(reach);
    const double dl = 3.0 * rest_.eg * reach, du = 6.0 * rest_.ea * reach * reach;
    const double s = rest_.reach_of_slope(0.0), slope = reach * rest_.bend();
    const double moved =
        rest_.eg * u + s * du + (dl + du) * slope + (l + u) * 4.0 * reach * rest_.ea;
    return kUp * (low + 2.0 * moved + 32.0 * kUnit * (s * u + (l + u) * slope));
}

double LocalForm::bend(double reach) const
{
    if (!quartic_) return part_.bend();
    const double l = rest_.reach_of_linear(reach), u = rest_.reach_of_quadratic(reach);
    const double s = rest_.reach_of_slope(0.0), slope = reach * rest_.bend();
    return kUp * (part_.bend() + 2.0 * ((2.0 * s + slope) * 3.0 * slope + (l + u) * rest_.bend()));
}

LocalForm::Expansion LocalForm::about(const Vec3& p) const
{
    Expansion x{value(p), gradient(p), part_.a, {}, {}};
    if (!quartic_) return x;
    // u(p + d) is u + n.d + u(d) and sigma.(p + d) is l + sigma.d.
    const double l = rest_.linear(p), u = rest_.quadratic(p);
    const Vec3 n = rest_.slope_of_quadratic(p), m = 2.0 * rest_.g + n;
    x.sigma = rest_.g + n;
    x.u = rest_.a;
    for (std::size_t k = 0; k < 6; ++k) x.a[k] += 2.0 * (l + u) * rest_.a[k];
    for (int k = 0; k < 3; ++k) {
        x.a[k] += n[k] * m[k];
        for (int j = 0; j < k; ++j) x.a[mixed(j, k)] += n[j] * m[k] + n[k] * m[j];
    }
    return x;
}

// ---- Graphs

std::optional<double> zero_on_axis(const LocalForm& form)
{
    constexpr double kFar = 8.0;
    double z = 0.0;
    for (int step = 0; step < 30; ++step) {
        const double slope = form.gradient({{0, 0, z}})[2];
        const double next = z - form.value({{0, 0, z}}) / slope;
        if (!(std::fabs(next) <= kFar)) return std::nullopt;
        if (std::fabs(next - z) <= 4.0 * kUnit) return next;
        z = next;
    }
    return std::nullopt;
}

std::optional<Graph> graph_over(const LocalForm& form, double z0, double R)
{
    const LocalForm::Expansion x = form.about({{0, 0, z0}});
    Graph graph;
    graph.z0 = z0;
    graph.slope = x.gradient[2];
    const double lambda = std::fabs(graph.slope);
    if (!(lambda > 0.0)) return std::nullopt;
    graph.a = -x.gradient[0] / graph.slope;
    graph.b = -x.gradient[1] / graph.slope;
    LocalForm::Expansion y = x;
    y.a = sheared(x.a, graph.a, graph.b);
    y.u = sheared(x.u, graph.a, graph.b);
    y.sigma[0] += graph.a * x.sigma[2];
    y.sigma[1] += graph.b * x.sigma[2];
    const double rest = std::fabs(x.gradient[0] + graph.a * graph.slope) +
                        std::fabs(x.gradient[1] + graph.b * graph.slope) +
                        8.0 * kUnit * (std::fabs(x.gradient[0]) + std::fabs(x.gradient[1]));
    const double rise = (std::fabs(graph.a) + std::fabs(graph.b)) * R;
    const auto reach = [&](double r) { return std::max(R, std::fabs(z0) + rise + r); };
    // The products of the shear are rounded too.
    const auto nonlinear = [&](double r) {
        const double u = magnitude(y.u, R, R, r);
        const double linear =
            (std::fabs(y.sigma[0]) + std::fabs(y.sigma[1])) * R + std::fabs(y.sigma[2]) * r;
        const double shear = 16.0 * kUnit * magnitude(x.a, R, R, rise + r);
        return magnitude(y.a, R, R, r) + 2.0 * linear * u + u * u + shear;
    };
    const auto needed = [&](double r) {
        return kUp * (std::fabs(x.value) + rest * R + nonlinear(r) + form.slack(reach(r))) / lambda;
    };
    double r = needed(0.0);
    bool settled = false;
    for (int step = 0; step < 12 && !settled && r <= 4.0 * R; ++step) {
        const double next = needed(r);
        settled = next <= r;
        if (!settled) r = 1.05 * next;
    }
    if (!settled) return std::nullopt;
    const double slack =
        form.gradient_slack(reach(r)) + 64.0 * kUnit * form.bend(reach(r)) * reach(r);
    const Vec3 turn = kUp * (nonlinear_slopes(y, {{R, R, r}}) + Box3::filled(slack));
    graph.r = r;
    graph.least_slope = lambda - turn[2];
    if (!(graph.least_slope > 0.1 * lambda)) return std::nullopt;
    // dz/dx = a - N_x / (slope + N_zeta) with the rest N.
    graph.rise_x = (turn[0] + rest + std::fabs(graph.a) * slack) / graph.least_slope;
    graph.rise_y = (turn[1] + rest + std::fabs(graph.b) * slack) / graph.least_slope;
    return graph;
}

Vec3 gradient_variation(const LocalForm& form, const Graph& graph, double R)
{
    const double rise = (std::fabs(graph.a) + std::fabs(graph.b)) * R + graph.r;
    const double slack = form.gradient_slack(std::max(R, std::fabs(graph.z0) + rise));
    return kUp *
           (nonlinear_slopes(form.about({{0, 0, graph.z0}}), {{R, R, rise}}) + Box3::filled(slack));
}

}  // namespace genus
