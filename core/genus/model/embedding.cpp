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

double largest_coordinate(const Vec3& p)
{
    return std::max({std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2])});
}

double largest_coordinate(const std::vector<Vec3>& points)
{
    double most = 0.0;
    for (const Vec3& p : points) most = std::max(most, largest_coordinate(p));
    return most;
}

// By how much a determinant may err, with corners within `blur` in each coordinate, sides and
// fibres no larger than these in any: each of the 36 products of three factors in a coefficient
// errs by the blur of each factor, up to four times that of a corner, and a few roundings of
// itself.
template <class Number>
Number error_of(double blur, double side, const Number& fibre)
{
    return 72.0 * side * (2.5 * blur * (side + 2.0 * fibre) + 0x1p-49 * side * fibre);
}

// From K- to a vertex, and from there to K+.
using Fibres = TwoVec;

Fibres fibres_at(const Vec3& p, const TwoVec& shell)
{
    constexpr Two kWay{1.0, -1.0};
    return {kWay * (p[0] - shell.x), kWay * (p[1] - shell.y), kWay * (p[2] - shell.z)};
}

// The two prisms of a face. With n and m the normals of its triangles in the shell and in the mesh
// and u_k the fibres, the mixed product of normals is n + m less that of the differences of the
// sides, and the latter has the same product with all three fibres: their determinant.
class PrismsOfFace {
public:
    // The fibres are kept by reference.
    PrismsOfFace(const Vec3& a, const Vec3& b, const Vec3& c, const Fibres& at_a,
                 const Fibres& at_b, const Fibres& at_c)
        : origin_(a),
          side_{b - a, c - a},
          fibres_{&at_a, &at_b, &at_c},
          change_{at_b - at_a, at_c - at_a}
    {
    }

    // The least coefficient of each, given the products n . u_k.
    Two least(const std::array<Two, 3>& along) const
    {
        const Vec3 m = cross(side_[0], side_[1]);
        const TwoVec normal(m, m);
        const Two twist = dot(cross(change_[0], change_[1]), *fibres_[0]);
        Two least = both(std::numeric_limits<double>::infinity());
        for (std::size_t k = 0; k < 3; ++k) {
            const Two own = dot(normal, *fibres_[k]);
            least = lesser(least, lesser(own + along[k] - twist, lesser(own, along[k])));
        }
        return least;
    }

    // The products n . u_k.
    std::array<Two, 3> along() const
    {
        const TwoVec n = cross(side_in_shell(0), side_in_shell(1));
        return {dot(n, *fibres_[0]), dot(n, *fibres_[1]), dot(n, *fibres_[2])};
    }

    // By how much coefficients may err, with corners within `blur`.
    Two error(double blur) const
    {
        const Two fibre =
            greater(largest(*fibres_[0]), greater(largest(*fibres_[1]), largest(*fibres_[2])));
        double longest = 0.0;
        for (const std::size_t i : {0u, 1u}) {
            const Two in_shell = largest(side_in_shell(i));
            longest = std::max({longest, in_shell[0], in_shell[1], largest_coordinate(side_[i])});
        }
        return error_of(blur, longest, fibre);
    }

    Box3 box() const
    {
        Box3 box;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 p = k == 0 ? origin_ : origin_ + side_[k - 1];
            box.add(p);
            box.add(p - (*fibres_[k])[0]);
            box.add(p + (*fibres_[k])[1]);
        }
        return box;
    }

private:
    TwoVec side_in_shell(std::size_t i) const
    {
        const Vec3& own = side_[i];
        const TwoVec& d = change_[i];
        return {own - d[0], own + d[1]};
    }

    Vec3 origin_;
    std::array<Vec3, 2> side_;
    std::array<const Fibres*, 3> fibres_;
    std::array<TwoVec, 2> change_;
};

// What was cut from one face of the coarse mesh.
struct Part {
    Box3 box;
    std::vector<Box3> doubtful;  // round prisms with a determinant not shown to be positive
};

class Prisms {
public:
    Prisms(const CoarseShell& shell, const FineMesh& fine) : shell_(shell), fine_(fine)
    {
        reach_ = std::max(largest_coordinate(shell.inner.vertices),
                          largest_coordinate(shell.outer.vertices));
        blur_ = kShellRounding * reach_;
        border_.reserve(fine.border_shell.size());
        for (std::int64_t v = 0; v < n_border(); ++v) {
            reach_ = std::max(reach_, largest_coordinate(at(v)));
            const auto& [below, above] = fine.border_shell[v];
            border_.push_back(fibres_at(at(v), {below, above}));
        }
    }

    std::vector<Part> parts() const
    {
        std::vector<Part> parts(fine_.first_face.size() - 1);
        parallel_for(parts.size(), 16, [&](std::size_t begin, std::size_t end) {
            std::vector<Inner> inner;
            for (std::size_t part = begin; part < end; ++part) look_at(part, inner, parts[part]);
        });
        return parts;
    }

private:
    // At a vertex inside a part: its fibres, and their products with the normals of its two faces
    // in the shell.
    struct Inner {
        Fibres fibres;
        Two along;
    };

    std::int64_t n_border() const { return fine_.first_vertex[0]; }
    const Vec3& at(std::int64_t v) const { return fine_.surface.mesh.vertices[v]; }
    const Weights& place(std::int64_t v) const { return fine_.place[v - n_border()]; }

    void look_at(std::size_t part, std::vector<Inner>& inner, Part& found) const
    {
        look_inside(part, inner, found.box);
        const std::int64_t first = fine_.first_vertex[part];
        const double size =
            2.1 * (found.box.empty() ? reach_
                                     : std::max({reach_, largest_coordinate(found.box.min),
                                                 largest_coordinate(found.box.max)}));
        const double most = error_of(blur_, size, size);
        const auto fibres = [&](std::int32_t v) -> const Fibres& {
            return v >= first ? inner[v - first].fibres : border_[v];
        };
        for (std::int64_t f = fine_.first_face[part]; f < fine_.first_face[part + 1]; ++f) {
            const Triangle& t = fine_.surface.mesh.faces[f];
            const PrismsOfFace prisms(at(t[0]), at(t[1]), at(t[2]), fibres(t[0]), fibres(t[1]),
                                      fibres(t[2]));
            const bool is_inside = std::min({t[0], t[1], t[2]}) >= first;
            const Two least = prisms.least(is_inside ? along(t, inner, first) : prisms.along());
            if (!is_inside)
                for (const std::int32_t v : t) found.box.add(at(v));
            if (least[0] > most && least[1] > most) continue;
            const Two error = prisms.error(blur_);
            if (!(least[0] > error[0] && least[1] > error[1]))
                found.doubtful.push_back(prisms.box().inflated(blur_));
        }
    }

    void look_inside(std::size_t part, std::vector<Inner>& inner, Box3& box) const
    {
        const Triangle& coarse = shell_.inner.faces[part];
        const auto corner = [&](std::size_t k) {
            return TwoVec(shell_.inner.vertices[coarse[k]], shell_.outer.vertices[coarse[k]]);
        };
        const TwoVec origin = corner(0), u = corner(1) - origin, v = corner(2) - origin;
        const TwoVec normal = cross(u, v);
        inner.clear();
        for (std::int64_t i = fine_.first_vertex[part]; i < fine_.first_vertex[part + 1]; ++i) {
            box.add(at(i));
            const auto [s, t] = place(i);
            const Fibres fibres = fibres_at(at(i), origin + both(s) * u + both(t) * v);
            inner.push_back({fibres, dot(normal, fibres)});
        }
    }

    // For a face inside: its triangles in the shell are parts of two planes.
    std::array<Two, 3> along(const Triangle& t, const std::vector<Inner>& inner,
                             std::int64_t first) const
    {
        const Weights &a = place(t[0]), &b = place(t[1]), &c = place(t[2]);
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        return {area * inner[t[0] - first].along, area * inner[t[1] - first].along,
                area * inner[t[2] - first].along};
    }

    const CoarseShell& shell_;
    const FineMesh& fine_;
    double blur_ = 0.0, reach_ = 0.0;
    std::vector<Fibres> border_;  // at vertices there
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
bool sound_within(const std::vector<Box3>& boxes, const std::vector<Part>& parts,
                  const FineMesh& fine, const IndexedMesh& coarse, const Topology& topology)
{
    const IndexedMesh& mesh = fine.surface.mesh;
    const BoxTree tree(boxes);
    const auto meets = [&](const Box3& box) {
        bool any = false;
        tree.visit_overlapping(box, [&](std::int32_t) { any = true; });
        return any;
    };
    std::vector<Triangle> near;
    std::vector<char> seen(topology.components.size(), 0);
    for (std::size_t part = 0; part < parts.size(); ++part) {
        // Most faces of the coarse mesh are clear of the boxes with all that was cut from them.
        if (!meets(parts[part].box)) {
            seen[topology.component_of_vertex[coarse.faces[part][0]]] = 1;
            continue;
        }
        for (std::int64_t f = fine.first_face[part]; f < fine.first_face[part + 1]; ++f) {
            Box3 box;
            for (const std::int32_t v : mesh.faces[f]) box.add(mesh.vertices[v]);
            if (meets(box)) {
                near.push_back(mesh.faces[f]);
                continue;
            }
            for (const std::int32_t v : mesh.faces[f])
                if (static_cast<std::size_t>(v) < coarse.n_vertices())
                    seen[topology.component_of_vertex[v]] = 1;
        }
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
    const std::vector<Part> parts = Prisms(shell, fine).parts();
    std::vector<Box3> doubtful;
    for (const Part& part : parts)
        doubtful.insert(doubtful.end(), part.doubtful.begin(), part.doubtful.end());
    if (doubtful.size() > kMostDoubtful * static_cast<double>(fine.surface.mesh.n_faces()))
        return false;
    const Validation inner = validate(shell.inner);
    return inner.ok() && validate(shell.outer).ok() &&
           (doubtful.empty() || sound_within(doubtful, parts, fine, shell.inner, inner.topology));
}

}  // namespace genus
