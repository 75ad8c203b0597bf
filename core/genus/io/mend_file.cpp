#include "genus/io/mend_file.h"

#include <algorithm>
#include <string>
#include <utility>

#include "genus/base/error.h"
#include "genus/io/raw_mesh.h"

namespace genus {

namespace {

struct NamedUnit {
    std::string_view name;
    double millimetres;
};

constexpr NamedUnit kUnits[] = {
    {"millimeter", 1.0}, {"mm", 1.0},   {"centimeter", 10.0},  {"cm", 10.0},
    {"meter", 1000.0},   {"m", 1000.0}, {"micron", 0.001},     {"um", 0.001},
    {"inch", 25.4},      {"in", 25.4},  {"micrometer", 0.001}, {"foot", 304.8},
    {"feet", 304.8},     {"ft", 304.8},
};

// Colours in the order of new elements; white for none.
std::vector<Rgba> picked(const std::vector<Rgba>& colors, const std::vector<std::int32_t>& sources)
{
    std::vector<Rgba> out;
    if (colors.empty()) return out;
    out.reserve(sources.size());
    for (const std::int32_t i : sources)
        out.push_back(i >= 0 ? colors[static_cast<std::size_t>(i)] : Rgba{});
    return out;
}

}  // namespace

double unit_millimetres(std::string_view name)
{
    for (const NamedUnit& unit : kUnits)
        if (unit.name == name) return unit.millimetres;
    throw InvalidInput("unit is \"" + std::string(name) +
                       "\", must be one of mm, cm, m, um, in, ft or their full names");
}

void scale_file(MeshFile& file, double factor)
{
    for (Vec3& v : file.mesh.vertices) v *= factor;
}

std::int64_t weld_file(MeshFile& file, double tolerance)
{
    const PolygonMesh& mesh = file.mesh;
    const std::vector<std::int32_t> target = weld_targets(mesh.vertices, tolerance);
    PolygonMesh out;
    std::vector<std::int32_t> kept_faces, kept_vertices, number(target.size(), -1), face;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        face.clear();
        for (const std::int32_t v : mesh.face(f)) {
            const std::int32_t t = target[static_cast<std::size_t>(v)];
            if (face.empty() || face.back() != t) face.push_back(t);
        }
        while (face.size() > 1 && face.front() == face.back()) face.pop_back();
        if (face.size() < 3) continue;
        out.add_face(face);
        kept_faces.push_back(static_cast<std::int32_t>(f));
        for (const std::int32_t v : face) number[static_cast<std::size_t>(v)] = 0;
    }
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        number[v] = static_cast<std::int32_t>(out.n_vertices());
        out.vertices.push_back(mesh.vertices[v]);
        kept_vertices.push_back(static_cast<std::int32_t>(v));
    }
    for (std::int32_t& v : out.corners) v = number[static_cast<std::size_t>(v)];
    const auto gone = static_cast<std::int64_t>(mesh.n_vertices() - out.n_vertices());
    file.mesh = std::move(out);
    file.vertex_colors = picked(file.vertex_colors, kept_vertices);
    file.face_colors = picked(file.face_colors, kept_faces);
    return gone;
}

RepairReport repair_file(MeshFile& file, const RepairOptions& options)
{
    io::ColoredTriangles triangles = io::to_colored_triangles(file);
    RepairedMesh repaired =
        repair(IndexedMesh{std::move(file.mesh.vertices), std::move(triangles.faces)}, options);
    file.vertex_colors = picked(file.vertex_colors, repaired.source_vertex);
    file.face_colors = picked(triangles.colors, repaired.source_face);
    file.mesh = to_polygons(repaired.mesh);
    return repaired.report;
}

}  // namespace genus
