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
#include "genus/model/two_lanes.h"

namespace genus {

namespace {

constexpr double kMostDoubtful = 0.05;  // of the faces

double largest_coordinate(const std::vector<Vec3>& points)
{
    double most = 0.0;
    for (const Vec3& p : points)
        for (const double x : p.c) most = std::max(most, std::fabs(x));
    return most;
}

// A face in one layer of two prisms each, that from K- to the fine mesh and that from there to K+:
// its corners, its first two sides from corner 0 and its normal.
struct Layers {
    std::array<TwoVec, 3> corners;
    TwoVec a = corners[1] - corners[0], b = corners[2] - corners[0], normal = cross(a, b);

    Two longest_side() const { return greater(largest(a), largest(b)); }
};

// By how much a determinant may err, with corners within `blur` in each coordinate, sides and
// fibres no larger than these in any: each of the 36 products of three factors in a coefficient
// errs by the blur of each factor, up to four times that of a corner, and a few roundings of
// itself.
template <class Number>
Number error_of(double blur, double side, const Number& fibre)
{
    return 72.0 * side * (2.5 * blur * (side + 2.0 * fibre) + 0x1p-49 * side * fibre);
}

// The maps from both prisms keep orientation everywhere, for all corners within `blur` of these.
// With n and m the normals of the layers and u_k the fibres, the mixed product of normals is n + m
// less that of the differences of the sides, and the latter has the same product with all three
// fibres: their determinant. `most` is the error of the largest prism that there can be.
bool keep_orientation(const Layers& below, const Layers& above, double blur, double most)
{
    const std::array<TwoVec, 3> fibres{above.corners[0] - below.corners[0],
                                       above.corners[1] - below.corners[1],
                                       above.corners[2] - below.corners[2]};
    const Two twist = dot(cross(above.a - below.a, above.b - below.b), fibres[0]);
    Two least = both(std::numeric_limits<double>::infinity());
    for (const TwoVec& f : fibres) {
        const Two first = dot(below.normal, f), last = dot(above.normal, f);
        least = lesser(least, lesser(first + last - twist, lesser(first, last)));
    }
    if (least[0] > most && least[1] > most) return true;
    const Two fibre = greater(largest(fibres[0]), greater(largest(fibres[1]), largest(fibres[2])));
    const Two sides = greater(below.longest_side(), above.longest_side());
    const Two error = error_of(blur, std::max(sides[0], sides[1]), fibre);
    return least[0] > error[0] && least[1] > error[1];
}

class PrismsOfFaces {
public:
    PrismsOfFaces(const CoarseShell& shell, const FineMesh& fine) : fine_(fine)
    {
        const double reach = std::max(largest_coordinate(shell.inner.vertices),
                                      largest_coordinate(shell.outer.vertices));
        blur_ = kShellRounding * reach;
        const double most = 2.1 * std::max(reach, largest_coordinate(fine.surface.mesh.vertices));
        most_ = error_of(blur_, most, most);
    }

    // Boxes round the two prisms of each face for which a determinant is not shown to be positive.
    std::vector<Box3> doubtful() const
    {
        constexpr std::size_t kGrain = 1024;
        std::vector<std::vector<Box3>> found(n_faces() / kGrain + 1);
        parallel_for(n_faces(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f)
                if (!keeps_orientation(f)) found[begin / kGrain].push_back(box(f));
        });
        std::vector<Box3> boxes;
        for (const auto& some : found) boxes.insert(boxes.end(), some.begin(), some.end());
        return boxes;
    }

private:
    std::size_t n_faces() const { return fine_.surface.mesh.n_faces(); }

    // The points of a vertex: on K- and in the mesh, there and on K+.
    TwoVec below(std::int32_t v) const
    {
        return {fine_.shell[v][0], fine_.surface.mesh.vertices[v]};
    }
    TwoVec above(std::int32_t v) const
    {
        return {fine_.surface.mesh.vertices[v], fine_.shell[v][1]};
    }

    bool keeps_orientation(std::size_t f) const
    {
        const Triangle& t = fine_.surface.mesh.faces[f];
        return keep_orientation({{below(t[0]), below(t[1]), below(t[2])}},
                                {{above(t[0]), above(t[1]), above(t[2])}}, blur_, most_);
    }

    Box3 box(std::size_t f) const
    {
        Box3 box;
        for (const std::int32_t v : fine_.surface.mesh.faces[f]) {
            box.add(fine_.surface.mesh.vertices[v]);
            for (const Vec3& p : fine_.shell[v]) box.add(p);
        }
        return box.inflated(blur_);
    }

    const FineMesh& fine_;
    double blur_ = 0.0, most_ = 0.0;
};

// Some faces of a mesh, with their vertices.
IndexedMesh alone(const IndexedMesh& mesh, const std::vector<Triangle>& faces)
{
    std::vector<std::int32_t> used;
    for (const Triangle& t : faces) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    IndexedMesh result;
    for (const std::int32_t v : used) result.vertices.push_back(mesh.vertices[v]);
    const auto number = [&](std::int32_t v) {
        return static_cast<std::int32_t>(std::lower_bound(used.begin(), used.end(), v) -
                                         used.begin());
    };
    for (const Triangle& t : faces)
        result.faces.push_back({number(t[0]), number(t[1]), number(t[2])});
    return result;
}

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
    std::vector<Triangle> near;
    std::vector<char> seen(coarse.components.size(), 0);
    for (std::size_t part = 0; part < n; ++part)
        for (std::int64_t f = fine.first_face[part]; f < fine.first_face[part + 1]; ++f) {
            const auto box_of_face = [&] {
                Box3 box;
                for (const std::int32_t v : mesh.faces[f]) box.add(mesh.vertices[v]);
                return box;
            };
            if (is_near[part] != 0 && meets(box_of_face()))
                near.push_back(mesh.faces[f]);
            else
                for (const std::int32_t v : mesh.faces[f])
                    if (static_cast<std::size_t>(v) < coarse.component_of_vertex.size())
                        seen[coarse.component_of_vertex[v]] = 1;
        }
    return std::find(seen.begin(), seen.end(), 0) == seen.end() &&
           std::none_of(near.begin(), near.end(),
                        [&](const Triangle& t) {
                            return has_no_area(
                                {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
                        }) &&
           self_intersections(alone(mesh, near)).pairs.empty();
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
