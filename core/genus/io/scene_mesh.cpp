#include "genus/io/scene_mesh.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace genus::io {

bool SceneMesh::add_points(std::span<const Vec3> points, std::span<const Rgba> colors,
                           std::vector<std::int32_t>& numbers)
{
    const std::size_t before = weld_ ? table_.size() : raw_.vertices.size();
    if (points.size() > limit_ - n_points_) return false;
    n_points_ += points.size();
    numbers.resize(points.size());
    if (weld_) {
        const auto point = [&](std::size_t i) { return points[i]; };
        if (!number_corners(table_, points.size(), point, numbers.data())) return false;
    } else {
        raw_.vertices.insert(raw_.vertices.end(), points.begin(), points.end());
        std::iota(numbers.begin(), numbers.end(), static_cast<std::int32_t>(before));
    }
    if (colors.empty() && raw_.vertex_colors.empty()) return true;
    std::vector<Rgba>& known = raw_.vertex_colors;
    known.resize(before);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Rgba color = colors.empty() ? Rgba{} : colors[i];
        const auto number = static_cast<std::size_t>(numbers[i]);
        if (number == known.size())
            known.push_back(color);
        else
            colors_clash_ |= known[number] != color;
    }
    return true;
}

RawMesh SceneMesh::take() &&
{
    if (weld_) raw_.vertices = std::move(table_).take_points();
    return std::move(raw_);
}

std::vector<Vec3> mapped(const Transform& map, std::span<const Vec3> points)
{
    std::vector<Vec3> images(points.begin(), points.end());
    if (!map.is_identity())
        for (Vec3& p : images) p = apply(map, p);
    return images;
}

}  // namespace genus::io
