#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "genus/base/transform.h"
#include "genus/io/raw_mesh.h"
#include "genus/io/weld.h"

namespace genus::io {

/// One mesh out of the parts of a scene, each placed by a map: what the readers of glTF, 3MF and
/// AMF fill. Parts may be placed many times, and a file of a few bytes could so ask for any amount
/// of memory and time: points and corners are counted against a limit.
class SceneMesh {
public:
    /// `file_bytes` is the size of the file: a larger one may make more.
    SceneMesh(std::size_t file_bytes, bool weld) : limit_(kLimit + 4 * file_bytes), weld_(weld) {}

    /// Numbers of the points in the mesh; where welding, equal points share one. False where there
    /// are too many. `colors` is empty or has one entry for each point.
    bool add_points(std::span<const Vec3> points, std::span<const Rgba> colors,
                    std::vector<std::int32_t>& numbers);

    /// False where there are too many.
    bool add_face(const Triangle& face)
    {
        raw_.faces.add(face);
        return 3 * raw_.faces.size() <= limit_;
    }
    bool add_face(const Triangle& face, const Rgba& color)
    {
        add_color(raw_.face_colors, raw_.faces.size(), color);
        return add_face(face);
    }

    /// Points at one place have got different colours, and only the first is kept.
    bool colors_clash() const { return colors_clash_; }

    RawMesh take() &&;

private:
    static constexpr std::size_t kLimit = std::size_t{1} << 23;

    std::size_t limit_;
    std::size_t n_points_ = 0;  // before welding
    bool weld_;
    bool colors_clash_ = false;
    PointTable table_{0};
    RawMesh raw_;
};

/// Transformed by `map`; triangles have to be turned round where it mirrors.
std::vector<Vec3> mapped(const Transform& map, std::span<const Vec3> points);

}  // namespace genus::io
