#include "genus/model/first_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "genus/base/halves.h"
#include "genus/boolean/mesh_boolean.h"
#include "genus/mesh/shapes.h"
#include "genus/model/csg_lowering.h"
#include "genus/model/leaf_mesh.h"

namespace genus {

namespace {

constexpr int kSides = 12;          // round a cylinder, and a torus
constexpr int kTubeSides = 8;       // of a torus
constexpr std::int32_t kParts = 3;  // of an icosahedron's edges
constexpr std::int32_t kNone = -1;

// A leaf as a closed mesh, and which of its surfaces each face stands for: kNone for those far
// outside, that close half-spaces.
struct CoarseLeaf {
    IndexedMesh mesh;
    std::vector<std::int32_t> role;
};

// Convex faces as fans.
void append(CoarseLeaf& leaf, std::span<const std::int32_t> face, std::int32_t role)
{
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        leaf.mesh.faces.push_back({face[0], face[i], face[i + 1]});
        leaf.role.push_back(role);
    }
}

CoarseLeaf of_one_role(IndexedMesh mesh)
{
    std::vector<std::int32_t> role(mesh.n_faces(), 0);
    return {std::move(mesh), std::move(role)};
}

// Round is 0, top 1, bottom 2.
CoarseLeaf coarse(const Cylinder& s)
{
    Cylinder sided = s;
    sided.fragments = kSides;
    const PolygonMesh mesh = facet_mesh(sided);
    const double middle = s.center ? 0.0 : 0.5 * s.h;
    CoarseLeaf leaf;
    leaf.mesh.vertices = mesh.vertices;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
        const auto face = mesh.face(f);
        const bool cap = face.size() == static_cast<std::size_t>(kSides);
        append(leaf, face, !cap ? 0 : mesh.vertices[face[0]][2] > middle ? 1 : 2);
    }
    return leaf;
}

// Each face is a plane, but for the degenerate.
std::optional<CoarseLeaf> coarse_polyhedron(const PolygonMesh& mesh, std::size_t n_surfaces)
{
    CoarseLeaf leaf;
    leaf.mesh.vertices = mesh.vertices;
    if (mesh.n_faces() != n_surfaces) return std::nullopt;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f)
        append(leaf, mesh.face(f), static_cast<std::int32_t>(f));
    return leaf;
}

// In the order of leaf_surfaces: +x, -x, +y, -y, +z, -z; faces come the other way round.
CoarseLeaf coarse(const Cube& s)
{
    const PolygonMesh mesh = facet_mesh(s);
    CoarseLeaf leaf;
    leaf.mesh.vertices = mesh.vertices;
    constexpr std::array<std::int32_t, 6> roles{5, 4, 3, 2, 1, 0};
    for (std::size_t f = 0; f < 6; ++f) append(leaf, mesh.face(f), roles[f]);
    return leaf;
}

std::optional<CoarseLeaf> coarse(const Shape& shape, std::size_t n_surfaces)
{
    if (const auto* box = std::get_if<Cube>(&shape)) return coarse(*box);
    if (const auto* given = std::get_if<Polyhedron>(&shape))
        return coarse_polyhedron(*given->mesh, n_surfaces);
    if (is_faceted(shape)) return coarse_polyhedron(facet_mesh(shape), n_surfaces);
    if (const auto* ball = std::get_if<Sphere>(&shape))
        return of_one_role(icosphere(kParts, ball->r));
    if (const auto* egg = std::get_if<Ellipsoid>(&shape)) {
        IndexedMesh mesh = icosphere(kParts);
        for (Vec3& v : mesh.vertices)
            for (std::size_t i = 0; i < 3; ++i) v[i] *= egg->radii[i];
        return of_one_role(std::move(mesh));
    }
    if (const auto* round = std::get_if<Cylinder>(&shape)) return coarse(*round);
    if (const auto* ring = std::get_if<TorusShape>(&shape))
        return of_one_role(to_triangles(torus_mesh(ring->R, ring->r, kSides, kTubeSides)));
    return std::nullopt;
}

// All of its boolean.
class Guess {
public:
    Guess(const TreeOfLeaves& tree, const std::vector<SurfaceForm>& forms, const Box3& cube)
        : tree_(tree), forms_(forms), cube_(cube)
    {
    }

    std::optional<SurfaceMesh> mesh()
    {
        for (const PlacedLeaf& leaf : tree_.leaves)
            if (!add(leaf)) return std::nullopt;
        MeshBooleanOptions options;
        options.operands_may_cross_themselves = false;
        const MeshBooleanResult made = mesh_boolean(operands_, formula(), options);
        if (!labelled(made)) return std::nullopt;
        return std::move(result_);
    }

private:
    bool add(const PlacedLeaf& placed)
    {
        std::optional<CoarseLeaf> leaf;
        if (std::holds_alternative<HalfSpace>(placed.node->shape)) {
            leaf = coarse_half_space(placed.surfaces[0]);
        } else {
            leaf = coarse(placed.node->shape, placed.surfaces.size());
            if (!leaf) return false;
            for (Vec3& v : leaf->mesh.vertices) v = apply(placed.map, v);
            if (determinant(placed.map) < 0.0)
                for (Triangle& t : leaf->mesh.faces) std::swap(t[1], t[2]);
        }
        operands_.push_back(std::move(leaf->mesh));
        roles_.push_back(std::move(leaf->role));
        return true;
    }

    // A box with one face in the plane, larger than the cube.
    CoarseLeaf coarse_half_space(const CsgField::Term& plane) const
    {
        const SurfaceForm& form = forms_[plane.index];
        const Vec3 middle = cube_.center(), gradient = form.gradient(middle);
        const double size = 2.0 * cube_.diagonal();
        const Vec3 foot = middle - form.value(middle) / dot(gradient, gradient) * gradient;
        const Vec3 out = (plane.negated ? -1.0 : 1.0) * normalized(gradient);
        Vec3 axis;
        axis[longest_axis({{-std::fabs(out[0]), -std::fabs(out[1]), -std::fabs(out[2])}})] = 1.0;
        const Vec3 u = normalized(cross(axis, out)), v = cross(out, u);
        CoarseLeaf leaf = coarse(Cube{Box3::filled(2.0 * size), true});
        for (Vec3& p : leaf.mesh.vertices) p = foot + p[0] * u + p[1] * v + (p[2] - size) * out;
        constexpr std::int32_t kTop = 4;  // of the roles of a cube
        for (std::int32_t& role : leaf.role) role = role == kTop ? 0 : kNone;
        return leaf;
    }

    BooleanFormula formula() const
    {
        BooleanFormula formula;
        for (const CsgField::Instruction& i : tree_.instructions) {
            std::vector<BooleanFormula::Term> terms;
            for (const CsgField::Term& t : i.terms)
                terms.push_back({t.index, t.is_surface, t.negated});
            formula.add(i.is_max, std::move(terms));
        }
        return formula;
    }

    // Faces and vertices get the surfaces they stand for.
    bool labelled(const MeshBooleanResult& made)
    {
        result_.mesh = made.mesh;
        const std::size_t n = made.mesh.n_vertices();
        result_.surfaces_of_vertex.assign(n, {-1, -1, -1});
        result_.cell_size.assign(n, std::numeric_limits<double>::infinity());
        for (std::size_t f = 0; f < made.mesh.n_faces(); ++f) {
            const std::int32_t i = made.operand[f], source = made.source_face[f];
            const std::int32_t role = roles_[i][source];
            if (role == kNone) return false;
            const std::int32_t s = tree_.leaves[i].surfaces[role].index;
            const auto [a, b, c] = corners(made.mesh, made.mesh.faces[f]);
            const bool turned =
                dot(cross(b - a, c - a), forms_[s].gradient((a + b + c) / 3.0)) < 0.0;
            result_.surface_of_face.push_back(2 * s + (turned ? 1 : 0));
            const double size = size_of(i, source);
            for (const std::int32_t v : made.mesh.faces[f]) {
                if (!note(result_.surfaces_of_vertex[v], s)) return false;
                result_.cell_size[v] = std::min(result_.cell_size[v], size);
            }
        }
        return true;
    }

    static std::array<Vec3, 3> corners(const IndexedMesh& mesh, const Triangle& t)
    {
        return {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    }

    // Of the face of an operand: its shortest side.
    double size_of(std::int32_t operand, std::int32_t face) const
    {
        const auto [a, b, c] = corners(operands_[operand], operands_[operand].faces[face]);
        return std::min({distance(a, b), distance(b, c), distance(c, a)});
    }

    // Ascending; false if there are three already.
    static bool note(std::array<std::int32_t, 3>& at, std::int32_t s)
    {
        if (std::find(at.begin(), at.end(), s) != at.end()) return true;
        const auto free = std::find(at.begin(), at.end(), -1);
        if (free == at.end()) return false;
        *free = s;
        std::sort(at.begin(), free + 1);
        return true;
    }

    const TreeOfLeaves& tree_;
    const std::vector<SurfaceForm>& forms_;
    const Box3& cube_;
    std::vector<IndexedMesh> operands_;
    std::vector<std::vector<std::int32_t>> roles_;
    SurfaceMesh result_;
};

}  // namespace

std::optional<SurfaceMesh> first_mesh(const Solid& solid, const std::vector<SurfaceForm>& forms,
                                      const Box3& cube)
{
    const std::optional<TreeOfLeaves> tree = lower_to_leaves(solid);
    if (!tree) return std::nullopt;
    return Guess(*tree, forms, cube).mesh();
}

}  // namespace genus
