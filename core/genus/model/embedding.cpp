#include "genus/model/embedding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "genus/base/parallel.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/triangle_intersection.h"
#include "genus/mesh/validate.h"

namespace genus {

namespace {

constexpr double kMostDoubtful = 0.05;  // of the faces

using Corners = std::array<Vec3, 3>;

double largest(const Vec3& v)
{
    return std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
}

double largest_coordinate(const IndexedMesh& mesh)
{
    double most = 0.0;
    for (const Vec3& p : mesh.vertices) most = std::max(most, largest(p));
    return most;
}

// The map from the prism over `below` and `above` keeps orientation everywhere, for all corners
// within `blur` of these in each coordinate.
bool keeps_orientation(const Corners& below, const Corners& above, double blur)
{
    const Vec3 a = below[1] - below[0], b = below[2] - below[0];
    const Vec3 c = above[1] - above[0], d = above[2] - above[0];
    const std::array<Vec3, 3> normals{cross(a, b), cross(a, d) + cross(c, b), cross(c, d)};
    const Corners fibres{above[0] - below[0], above[1] - below[1], above[2] - below[2]};
    const double side = std::max({largest(a), largest(b), largest(c), largest(d)});
    const double fibre = std::max({largest(fibres[0]), largest(fibres[1]), largest(fibres[2])});
    // Each of the 12 products of three factors in a coefficient errs by the blur of each factor,
    // twice that of a corner, and a few roundings of itself.
    const double error = 12.0 * side * (2.5 * blur * (side + 2.0 * fibre) + 0x1p-49 * side * fibre);
    for (const Vec3& n : normals)
        for (const Vec3& f : fibres)
            if (!(dot(n, f) > error)) return false;
    return true;
}

class PrismsOfFaces {
public:
    PrismsOfFaces(const CoarseShell& shell, const FineMesh& fine)
        : fine_(fine),
          blur_(kShellRounding *
                std::max(largest_coordinate(shell.inner), largest_coordinate(shell.outer)))
    {
    }

    // Boxes round the two prisms of each face for which a determinant is not shown to be positive.
    std::vector<Box3> doubtful() const
    {
        std::vector<char> bad(n_faces(), 0);
        parallel_for(n_faces(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const std::array<Corners, 3> c = corners(f);
                bad[f] =
                    keeps_orientation(c[0], c[1], blur_) && keeps_orientation(c[1], c[2], blur_)
                        ? 0
                        : 1;
            }
        });
        std::vector<Box3> boxes;
        for (std::size_t f = 0; f < n_faces(); ++f)
            if (bad[f] != 0) boxes.push_back(box(f));
        return boxes;
    }

private:
    std::size_t n_faces() const { return fine_.surface.mesh.n_faces(); }

    // On K-, of the face, and on K+.
    std::array<Corners, 3> corners(std::size_t f) const
    {
        std::array<Corners, 3> c;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int32_t v = fine_.surface.mesh.faces[f][i];
            c[0][i] = fine_.shell[v][0];
            c[1][i] = fine_.surface.mesh.vertices[v];
            c[2][i] = fine_.shell[v][1];
        }
        return c;
    }

    Box3 box(std::size_t f) const
    {
        Box3 box;
        for (const Corners& three : corners(f))
            for (const Vec3& p : three) box.add(p);
        return box.inflated(blur_);
    }

    const FineMesh& fine_;
    double blur_;
};

// The faces that meet one of the boxes do not cross each other, and each component of the mesh,
// given by those of the coarse one, has faces that meet none.
bool sound_within(const std::vector<Box3>& boxes, const FineMesh& fine, const Topology& coarse)
{
    const IndexedMesh& mesh = fine.surface.mesh;
    const BoxTree tree(boxes);
    IndexedMesh near;
    near.vertices = mesh.vertices;
    std::vector<char> seen(coarse.components.size(), 0);
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        Box3 box;
        for (const std::int32_t v : mesh.faces[f]) box.add(mesh.vertices[v]);
        bool any = false;
        tree.visit_overlapping(box, [&](std::int32_t) { any = true; });
        if (any)
            near.faces.push_back(mesh.faces[f]);
        else
            for (const std::int32_t v : mesh.faces[f])
                if (static_cast<std::size_t>(v) < coarse.component_of_vertex.size())
                    seen[coarse.component_of_vertex[v]] = 1;
    }
    return std::find(seen.begin(), seen.end(), 0) == seen.end() &&
           std::none_of(near.faces.begin(), near.faces.end(),
                        [&](const Triangle& t) {
                            return has_no_area(
                                {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
                        }) &&
           self_intersections(near).pairs.empty();
}

}  // namespace

bool proven_embedded(const CoarseShell& shell, const FineMesh& fine)
{
    const std::vector<Box3> doubtful = PrismsOfFaces(shell, fine).doubtful();
    if (doubtful.size() > kMostDoubtful * static_cast<double>(fine.surface.mesh.n_faces()))
        return false;
    const Validation inner = validate(shell.inner);
    return inner.ok() && validate(shell.outer).ok() &&
           (doubtful.empty() || sound_within(doubtful, fine, inner.topology));
}

}  // namespace genus
