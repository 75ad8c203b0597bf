#include "genus/io/height_map.h"

#include <algorithm>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/io/input_file.h"
#include "genus/io/png.h"
#include "genus/io/text.h"

namespace genus {

namespace {

constexpr std::size_t kMostValues = 25'000'000;

void set_floor(HeightMap& map)
{
    for (const double z : map.heights) map.floor = std::min(map.floor, z - 1.0);
}

HeightMap from_picture(const io::Picture& picture, bool invert)
{
    HeightMap map;
    map.columns = static_cast<int>(picture.width);
    map.rows = static_cast<int>(picture.height);
    map.heights.reserve(std::size_t{picture.width} * picture.height);
    for (int y = map.rows; y-- > 0;)
        for (int x = 0; x < map.columns; ++x) {
            const std::uint8_t* p =
                picture.rgb.data() + 3 * (static_cast<std::size_t>(y) * picture.width + x);
            const double grey = 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
            map.heights.push_back(100.0 / 255.0 * (invert ? 1.0 - grey : grey));
        }
    set_floor(map);
    return map;
}

std::vector<std::vector<double>> number_rows(std::string_view text)
{
    std::vector<std::vector<double>> rows;
    std::size_t n_values = 0;
    io::TextCursor cursor(text);
    while (!cursor.at_end()) {
        std::vector<double> row;
        while (cursor.skip_blanks(), !cursor.at_line_end()) {
            if (++n_values > kMostValues)
                throw io::TextFault{cursor.p, "more than 25 million heights"};
            row.push_back(cursor.number("a height"));
        }
        cursor.skip_comment();
        if (!cursor.at_end()) ++cursor.p;  // the end of the line
        if (!row.empty()) rows.push_back(std::move(row));
    }
    return rows;
}

HeightMap from_text(std::string_view text, const std::string& name)
{
    const auto rows = io::with_lines(text, name, [&] { return number_rows(text); });
    HeightMap map;
    std::size_t columns = 0;
    for (const auto& row : rows) columns = std::max(columns, row.size());
    if (rows.size() * columns > kMostValues) throw FileError(name, "more than 25 million heights");
    for (const auto& row : rows)
        for (const double z : row) map.floor = std::min(map.floor, z - 1.0);
    map.rows = static_cast<int>(rows.size());
    map.columns = static_cast<int>(columns);
    for (std::size_t y = rows.size(); y-- > 0;) {
        map.heights.insert(map.heights.end(), rows[y].begin(), rows[y].end());
        map.heights.resize(map.heights.size() + columns - rows[y].size(), 0.0);
    }
    return map;
}

}  // namespace

HeightMap read_height_map(const std::string& path, bool invert)
{
    const io::InputFile file(path);
    if (io::is_png(file.bytes())) return from_picture(io::read_png(file.bytes(), path), invert);
    return from_text(io::as_text(file.bytes()), path);
}

PolygonMesh height_map_mesh(const HeightMap& map, bool center)
{
    PolygonMesh mesh;
    const int nx = map.columns, ny = map.rows;
    if (nx < 2 || ny < 2) return mesh;
    require(std::size_t(nx) * ny <= kMostValues, "surface: more than 25 million heights");
    const double x0 = center ? -0.5 * (nx - 1) : 0.0, y0 = center ? -0.5 * (ny - 1) : 0.0;
    const auto top = [&](int x, int y) { return static_cast<std::int32_t>(y * nx + x); };
    for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x)
            mesh.vertices.push_back({{x0 + x, y0 + y, map.heights[top(x, y)]}});
    for (int y = 0; y + 1 < ny; ++y) {
        current_progress().check();
        for (int x = 0; x + 1 < nx; ++x) {
            const std::int32_t corners[] = {top(x, y), top(x + 1, y), top(x + 1, y + 1),
                                            top(x, y + 1)};
            double sum = 0.0;
            for (const std::int32_t corner : corners) sum += map.heights[corner];
            const auto middle = static_cast<std::int32_t>(mesh.vertices.size());
            mesh.vertices.push_back({{x0 + x + 0.5, y0 + y + 0.5, 0.25 * sum}});
            for (int i = 0; i < 4; ++i) {
                const std::int32_t face[] = {corners[i], corners[(i + 1) % 4], middle};
                mesh.add_face(face);
            }
        }
    }
    // Round the border, counterclockwise seen from above.
    std::vector<std::int32_t> border;
    for (int x = 0; x + 1 < nx; ++x) border.push_back(top(x, 0));
    for (int y = 0; y + 1 < ny; ++y) border.push_back(top(nx - 1, y));
    for (int x = nx; x-- > 1;) border.push_back(top(x, ny - 1));
    for (int y = ny; y-- > 1;) border.push_back(top(0, y));
    const auto low = static_cast<std::int32_t>(mesh.vertices.size());
    const auto n = static_cast<std::int32_t>(border.size());
    for (const std::int32_t v : border)
        mesh.vertices.push_back({{mesh.vertices[v][0], mesh.vertices[v][1], map.floor}});
    std::vector<std::int32_t> bottom;
    for (std::int32_t i = 0; i < n; ++i) {
        const std::int32_t j = (i + 1) % n;
        const std::int32_t wall[] = {low + i, low + j, border[j], border[i]};
        mesh.add_face(wall);
        bottom.push_back(low + n - 1 - i);
    }
    mesh.add_face(bottom);
    return mesh;
}

}  // namespace genus
