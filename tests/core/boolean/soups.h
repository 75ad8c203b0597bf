#pragma once

// Meshes as soups, on the grid of a frame round them.

#include <vector>

#include "genus/boolean/closed_operand.h"
#include "genus/boolean/frame.h"
#include "genus/boolean/soup.h"

namespace genus::shapes {

inline exact::Frame frame_round(const std::vector<IndexedMesh>& meshes)
{
    Box3 box;
    for (const IndexedMesh& mesh : meshes)
        for (const Vec3& p : mesh.vertices) box.add(p);
    return exact::Frame(box);
}

/// Each mesh is an operand that may cross itself.
inline exact::Soup soup_of(const std::vector<IndexedMesh>& meshes)
{
    const exact::Frame frame = frame_round(meshes);
    exact::Soup soup;
    for (const IndexedMesh& mesh : meshes) {
        const auto operand = static_cast<std::int32_t>(soup.crosses_itself.size());
        const auto first_point = static_cast<std::int32_t>(soup.points.size());
        const auto first_face = static_cast<std::int32_t>(soup.faces.size());
        double off = 0.0;
        for (const Vec3& p : mesh.vertices) soup.points.push_back(frame.to_grid(p, off));
        std::vector<std::int32_t> twin;
        exact::find_twins(mesh.vertices.size(), mesh.faces, twin);
        for (const std::int32_t h : twin) soup.twin.push_back(h < 0 ? -1 : 3 * first_face + h);
        for (std::int32_t f = 0; f < static_cast<std::int32_t>(mesh.faces.size()); ++f) {
            const Triangle& t = mesh.faces[f];
            soup.faces.push_back({t[0] + first_point, t[1] + first_point, t[2] + first_point});
            soup.operand.push_back(operand);
            soup.given.push_back({operand, f});
        }
        soup.crosses_itself.push_back(1);
    }
    return soup;
}

}  // namespace genus::shapes
