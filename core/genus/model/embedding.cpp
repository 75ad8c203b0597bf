#include "genus/model/embedding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

// A face on K-, in the fine mesh or on K+: its first two sides from corner 0, and its normal.
struct Layer {
    Vec3 a, b, normal;

    explicit Layer(const Corners& c) : a(c[1] - c[0]), b(c[2] - c[0]), normal(cross(a, b)) {}
};

// The map from the prism between two layers keeps orientation everywhere, for all corners within
// `blur` of these in each coordinate. With n and m the normals of the layers and u_k the fibres,
// the mixed product of normals is n + m less that of the differences of the sides, and the latter
// has the same product with all three fibres: their determinant.
bool keeps_orientation(const Layer& below, const Layer& above, const Corners& fibres, double side,
                       double blur)
{
    const Vec3 mixed = cross(above.a - below.a, above.b - below.b);
    const double twist = dot(mixed, fibres[0]);
    double fibre = 0.0, least = std::numeric_limits<double>::infinity();
    for (const Vec3& f : fibres) {
        const double first = dot(below.normal, f), last = dot(above.normal, f);
        least = std::min({least, first, last, first + last - twist});
        fibre = std::max(fibre, largest(f));
    }
    // Each of the 36 products of three factors in a coefficient errs by the blur of each factor, up
    // to four times that of a corner, and a few roundings of itself.
    const double error = 72.0 * side * (2.5 * blur * (side + 2.0 * fibre) + 0x1p-49 * side * fibre);
    return least > error;
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
        constexpr std::size_t kGrain = 1024;
        std::vector<std::vector<Box3>> found(n_faces() / kGrain + 1);
        parallel_for(n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f)
                if (const auto c = corners(f); !keeps_orientation(c))
                    found[begin / kGrain].push_back(box(c));
        });
        std::vector<Box3> boxes;
        for (const auto& some : found) boxes.insert(boxes.end(), some.begin(), some.end());
        return boxes;
    }

private:
    std::size_t n_faces() const { return fine_.surface.mesh.n_faces(); }

    bool keeps_orientation(const std::array<Corners, 3>& c) const
    {
        const Layer inner(c[0]), middle(c[1]), outer(c[2]);
        double side = 0.0;
        for (const Layer* layer : {&inner, &middle, &outer})
            side = std::max({side, largest(layer->a), largest(layer->b)});
        Corners in, out;
        for (std::size_t i = 0; i < 3; ++i) {
            in[i] = c[1][i] - c[0][i];
            out[i] = c[2][i] - c[1][i];
        }
        return genus::keeps_orientation(inner, middle, in, side, blur_) &&
               genus::keeps_orientation(middle, outer, out, side, blur_);
    }

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

    Box3 box(const std::array<Corners, 3>& c) const
    {
        Box3 box;
        for (const Corners& three : c)
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
    const auto meets = [&](const Box3& box) {
        bool any = false;
        tree.visit_overlapping(box, [&](std::int32_t) { any = true; });
        return any;
    };
    // Most faces of the coarse mesh are clear of the boxes with all that was cut from them.
    const std::size_t n = fine.first_face.size() - 1;
    std::vector<char> is_near(n, 0);
    parallel_for(n, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t part = begin; part < end; ++part) {
            Box3 box;
            for (std::int64_t f = fine.first_face[part]; f < fine.first_face[part + 1]; ++f)
                for (const std::int32_t v : mesh.faces[f]) box.add(mesh.vertices[v]);
            is_near[part] = meets(box) ? 1 : 0;
        }
    });
    IndexedMesh near;
    near.vertices = mesh.vertices;
    std::vector<char> seen(coarse.components.size(), 0);
    for (std::size_t part = 0; part < n; ++part)
        for (std::int64_t f = fine.first_face[part]; f < fine.first_face[part + 1]; ++f) {
            const auto box_of_face = [&] {
                Box3 box;
                for (const std::int32_t v : mesh.faces[f]) box.add(mesh.vertices[v]);
                return box;
            };
            if (is_near[part] != 0 && meets(box_of_face()))
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
