#include "genus/volume/feature_vertex.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace genus {

namespace {

using Matrix3 = std::array<Vec3, 3>;  // rows

struct Eigen3 {
    Vec3 values;
    Matrix3 vectors;  // one a row
};

// Jacobi rotations on a symmetric matrix.
Eigen3 eigen(Matrix3 a)
{
    Matrix3 v{{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};
    constexpr std::array<std::pair<int, int>, 3> kPairs{{{0, 1}, {0, 2}, {1, 2}}};
    for (int sweep = 0; sweep < 12; ++sweep) {
        bool diagonal = true;
        for (const auto& [p, q] : kPairs) {
            // Below rounding of the values beside it.
            if (std::fabs(a[p][q]) <= 1e-18 * std::fabs(a[p][p] + a[q][q])) continue;
            diagonal = false;
            const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            const double t =
                std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
            const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
            for (int k = 0; k < 3; ++k) {
                const double kp = a[k][p], kq = a[k][q];
                a[k][p] = c * kp - s * kq;
                a[k][q] = s * kp + c * kq;
            }
            for (int k = 0; k < 3; ++k) {
                const double pk = a[p][k], qk = a[q][k];
                a[p][k] = c * pk - s * qk;
                a[q][k] = s * pk + c * qk;
            }
            const Vec3 vp = v[p], vq = v[q];
            v[p] = vp * c - vq * s;
            v[q] = vp * s + vq * c;
        }
        if (diagonal) break;
    }
    return {{{a[0][0], a[1][1], a[2][2]}}, v};
}

enum class Feature { None, Edge, Corner };

Feature feature_kind(std::span<const TangentElement> elements, const FeatureOptions& options)
{
    double least = 1.0;
    std::pair<std::size_t, std::size_t> apart{0, 0};
    for (std::size_t i = 0; i < elements.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (const double c = dot(elements[i].normal, elements[j].normal); c < least) {
                least = c;
                apart = {i, j};
            }
    if (least >= options.theta_sharp) return Feature::None;
    const Vec3 axis =
        normalized(cross(elements[apart.first].normal, elements[apart.second].normal));
    double lean = 0.0;
    for (const TangentElement& e : elements) lean = std::max(lean, std::fabs(dot(e.normal, axis)));
    return lean > options.phi_corner ? Feature::Corner : Feature::Edge;
}

// x with n . (x - p) = 0 for each row (n, n . p), nearest to `start`; `rank` singular values count.
Vec3 nearest_solution(std::span<const TangentElement> elements, const Vec3& start, int rank)
{
    Matrix3 normal_matrix{};
    Vec3 right;
    for (const TangentElement& e : elements) {
        const double offset = dot(e.normal, e.point - start);
        for (int i = 0; i < 3; ++i) normal_matrix[i] += e.normal * e.normal[i];
        right += e.normal * offset;
    }
    const Eigen3 system = eigen(normal_matrix);
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return system.values[a] > system.values[b]; });
    Vec3 x = start;
    for (int k = 0; k < rank; ++k) {
        const int e = order[k];
        // Planes that nearly agree say nothing in this direction.
        if (system.values[e] <= 1e-9 * system.values[order[0]]) break;
        x += system.vectors[e] * (dot(system.vectors[e], right) / system.values[e]);
    }
    return x;
}

Vec3 mean_point(std::span<const TangentElement> elements)
{
    Vec3 sum;
    for (const TangentElement& e : elements) sum += e.point;
    return sum / static_cast<double>(elements.size());
}

// Newton steps of least norm towards the common zero of two or three pieces, on `held` if given.
std::optional<Vec3> meet(const Implicit& field, const std::vector<std::int32_t>& pieces, Vec3 x,
                         const Box3& region, const TangentElement* held = nullptr)
{
    constexpr int kMostSteps = 20;
    const double settled = 1e-15 * (norm(x) + region.diagonal());
    for (int step = 0; step < kMostSteps; ++step) {
        std::vector<TangentElement> planes;
        if (held) planes.push_back(*held);
        for (const std::int32_t piece : pieces) {
            const Vec3 g = field.piece_gradient(piece, x);
            const double length = norm(g);
            if (!(length > 0.0)) return std::nullopt;
            const Vec3 n = g / length;
            planes.push_back({x - n * (field.piece_value(piece, x) / length), n});
        }
        const Vec3 next = nearest_solution(planes, x, static_cast<int>(planes.size()));
        const double moved = distance(next, x);
        x = next;
        if (!region.contains(x)) return std::nullopt;
        if (moved <= settled) return x;
    }
    return std::nullopt;
}

Vec3 moved_into(Vec3 x, const Box3& box)
{
    for (std::size_t i = 0; i < 3; ++i) x[i] = std::clamp(x[i], box.min[i], box.max[i]);
    return x;
}

// The same within `room`: where an edge leaves it, if its nearest point is outside.
std::optional<Vec3> meet_within(const Implicit& field, const std::vector<std::int32_t>& pieces,
                                const Vec3& start, const Box3& room)
{
    const Box3 region{room.min - room.size(), room.max + room.size()};
    const auto free = meet(field, pieces, moved_into(start, room), region);
    if (!free || room.contains(*free)) return free;
    if (pieces.size() != 2) return std::nullopt;
    const Vec3 off = *free - moved_into(*free, room);
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (std::fabs(off[i]) > std::fabs(off[axis])) axis = i;
    TangentElement side{moved_into(*free, room), {}};
    side.normal[axis] = 1.0;
    auto held = meet(field, pieces, side.point, region, &side);
    if (held) (*held)[axis] = side.point[axis];
    return held && room.contains(*held) ? held : std::nullopt;
}

// Only asked for where there is a feature.
std::vector<std::int32_t> pieces_of(const Implicit& field, std::span<const TangentElement> elements)
{
    std::vector<std::int32_t> pieces;
    for (const TangentElement& e : elements)
        pieces.push_back(e.on_border ? -1 : field.piece(e.point));
    std::sort(pieces.begin(), pieces.end());
    pieces.erase(std::unique(pieces.begin(), pieces.end()), pieces.end());
    return pieces;
}

}  // namespace

std::optional<Vec3> feature_point(std::span<const TangentElement> elements,
                                  const FeatureOptions& options)
{
    const Feature kind = feature_kind(elements, options);
    if (kind == Feature::None) return std::nullopt;
    return nearest_solution(elements, mean_point(elements), kind == Feature::Corner ? 3 : 2);
}

std::optional<Vec3> feature_vertex(const Implicit& field, double level,
                                   std::span<const TangentElement> elements, const Box3& cell,
                                   const FeatureOptions& options, FeatureRoom room)
{
    const std::optional<Vec3> start = feature_point(elements, options);
    if (!start) return std::nullopt;
    const Vec3 quarter = cell.size() * 0.25, least = cell.size() / 64.0;
    const Box3 near{cell.min - quarter, cell.max + quarter};
    const Box3 inside{cell.min + least, cell.max - least};
    const std::vector<std::int32_t> pieces = pieces_of(field, elements);
    // A piece may enter negated, so which of its levels belongs to another level of the field than
    // zero is not known.
    if (pieces.front() >= 0 && (pieces.size() == 2 || pieces.size() == 3) && level == 0.0) {
        const auto exact = room == FeatureRoom::Near ? meet(field, pieces, *start, near)
                                                     : meet_within(field, pieces, *start, inside);
        if (exact) return exact;
    }
    return moved_into(*start, room == FeatureRoom::Near ? cell : inside);
}

}  // namespace genus
