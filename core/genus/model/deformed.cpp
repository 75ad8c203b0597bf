#include "genus/model/deformed.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>

#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/deform/deform_mesh.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/distance.h"
#include "genus/model/certificate.h"
#include "genus/model/csg_field.h"
#include "genus/model/freeform.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/queries.h"
#include "genus/model/sign_formula.h"
#include "genus/model/solid_field.h"
#include "genus/model/surface_form.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(std::int32_t i)
{
    return static_cast<std::size_t>(i);
}

// Takes points of space to (s, t, u).
Transform to_local(const Lattice& lattice)
{
    Transform t;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) t.m[r][c] = lattice.axes()[c][r];
        t.m[r][3] = lattice.origin()[r];
    }
    return inverse(t);
}

bool in_unit_cube(const Vec3& s)
{
    return Box3{{}, {{1, 1, 1}}}.contains(s);
}

// Which point goes where: cells of the lattice with boxes round their images.
class InverseMap {
public:
    explicit InverseMap(const Lattice& lattice)
        : lattice_(lattice), rests_(lattice.border_continuity() >= 0)
    {
        for (int i = 0; i < kCells; ++i)
            for (int j = 0; j < kCells; ++j)
                for (int k = 0; k < kCells; ++k) {
                    const Vec3 low{{double(i), double(j), double(k)}};
                    const Box3 stu{low / kCells, (low + Vec3{{1, 1, 1}}) / kCells};
                    const Vec3 middle = lattice.global(stu.center());
                    cells_.push_back({lattice.image_of_local(stu), space_of(stu), middle,
                                      lattice.apply(middle)});
                }
    }

    /// The point that is taken to y, if any.
    std::optional<Vec3> operator()(const Vec3& y) const
    {
        // A border that rests keeps the lattice a map of its parallelepiped onto itself.
        if (rests_ && !in_unit_cube(lattice_.local(y))) return y;
        // The nearest first: others may lead astray.
        std::vector<std::pair<double, const Cell*>> near;
        for (const Cell& cell : cells_)
            if (cell.image.contains(y)) near.emplace_back(distance(cell.middle_image, y), &cell);
        std::sort(near.begin(), near.end());
        for (const auto& [far, cell] : near)
            if (const auto x = lattice_.solve(y, cell->middle)) return x;
        return std::nullopt;
    }

    /// Calls `visit` with boxes that together hold all that is taken into `box`.
    template <class Visit>
    void visit_sources(const Box3& box, const Visit& visit) const
    {
        for (const Cell& cell : cells_)
            if (overlap(cell.image, box)) visit(cell.space);
        if (rests_) visit(box);
    }
    /// True if nothing may be taken to some of it.
    bool may_miss(const Box3&) const { return !rests_; }

private:
    static constexpr int kCells = 8;
    struct Cell {
        Box3 image, space;
        Vec3 middle, middle_image;
    };

    Box3 space_of(const Box3& stu) const
    {
        Box3 box;
        for (std::size_t k = 0; k < 8; ++k) box.add(lattice_.global(stu.corner(k)));
        return box.inflated(1e-12 * (norm(box.min) + norm(box.max)));
    }

    const Lattice& lattice_;
    bool rests_;
    std::vector<Cell> cells_;
};

// F at the place that is taken to a point. Where nothing is, it is outside.
class DeformedField final : public Implicit {
public:
    DeformedField(const Solid& part, const Lattice& lattice)
        : field_(solid_field(part)),
          lattice_(lattice),
          inverse_(lattice_),
          outside_(part.bounds().diagonal())
    {
    }

    double value(const Vec3& y) const override
    {
        const auto x = inverse_(y);
        return x ? field_->value(*x) : outside_;
    }
    Vec3 gradient(const Vec3& y) const override
    {
        const auto x = inverse_(y);
        return x ? pushed(*x, field_->gradient(*x)) : Vec3{};
    }
    Interval bound(const Box3& box) const override
    {
        Interval range(kInfinity, -kInfinity);
        inverse_.visit_sources(
            box, [&](const Box3& source) { range = hull(range, field_->bound(source)); });
        if (inverse_.may_miss(box)) range = hull(range, Interval(outside_));
        return range;
    }
    IntervalVec3 gradient_bound(const Box3&) const override
    {
        return {Interval::everything(), Interval::everything(), Interval::everything()};
    }
    std::int32_t piece(const Vec3& y) const override
    {
        const auto x = inverse_(y);
        return x ? field_->piece(*x) : -1;
    }
    double piece_value(std::int32_t surface, const Vec3& y) const override
    {
        const auto x = inverse_(y);
        return x && surface >= 0 ? field_->piece_value(surface, *x) : outside_;
    }
    Vec3 piece_gradient(std::int32_t surface, const Vec3& y) const override
    {
        const auto x = inverse_(y);
        return x && surface >= 0 ? pushed(*x, field_->piece_gradient(surface, *x)) : Vec3{};
    }

    /// Back, to the surface that is active there, and forth.
    std::optional<Vec3> to_surface(const Vec3& y) const
    {
        const auto x = inverse_(y);
        const auto p = x ? to_zero(*field_, *x) : std::nullopt;
        return p ? std::optional(lattice_.apply(*p)) : std::nullopt;
    }
    const InverseMap& inverse() const { return inverse_; }

private:
    // Gradients go by the inverse transposed.
    Vec3 pushed(const Vec3& x, const Vec3& gradient) const
    {
        const Columns3 j = lattice_.jacobian(x);
        const double d = dot(j[0], cross(j[1], j[2]));
        return (gradient[0] * cross(j[1], j[2]) + gradient[1] * cross(j[2], j[0]) +
                gradient[2] * cross(j[0], j[1])) /
               d;
    }

    std::shared_ptr<const Implicit> field_;
    Lattice lattice_;
    InverseMap inverse_;
    double outside_;
};

class DeformedSource final : public FreeformSource {
public:
    DeformedSource(const Solid& part, const Lattice& lattice)
        : part_(part), lattice_(lattice), source_box_(require_bounded(part))
    {
        bounds_ = lattice.image_bounds(source_box_);
        hash_ = part.hash();
        for (const Vec3& d : lattice.moves())
            for (const double c : d.c) mix(c);
        for (const double c : lattice.origin().c) mix(c);
        for (const Vec3& a : lattice.axes())
            for (const double c : a.c) mix(c);
    }

    Box3 bounds() const override { return bounds_; }
    std::string describe() const override
    {
        return "deformed " + genus::describe(part_.node().shape);
    }
    std::uint64_t hash() const override { return hash_; }
    bool equals(const FreeformSource& other) const override
    {
        const auto* o = dynamic_cast<const DeformedSource*>(&other);
        return o && hash_ == o->hash_ && lattice_.same(o->lattice_) && part_ == o->part_;
    }

    Meshed mesh(double tolerance, const Limits& limits) const override
    {
        require_no_fold();
        const double stretch = lattice_.stretch(source_box_);
        MeshOptions options;
        options.tolerance = 0.5 * tolerance / stretch;
        options.measure = false;
        options.max_triangles = limits.max_triangles;
        options.round_faces = true;
        MeshedSolid flat = mesh_solid(part_, options);
        DeformedMesh image =
            deformed_within(std::move(flat.mesh), lattice_, 0.5 * tolerance, limits.max_triangles);
        Meshed made;
        made.bound = stretch * flat.error.bound + image.bound;
        made.doubt =
            !flat.error.certified ? "before the deformation: " + flat.error.doubt : doubt();
        made.certified = made.doubt.empty();
        made.mesh = std::move(image.mesh);
        if (limits.measure) made.measured = measured_distance(made.mesh, image.measured);
        if (limits.to_surface && is_exact(part_))
            made.to_surface = [field = deformed_field()](const Vec3& y) {
                return field->to_surface(y);
            };
        return made;
    }

    std::shared_ptr<const Implicit> field() const override { return deformed_field(); }
    bool has_exact_field() const override { return is_exact(part_); }

    std::optional<double> proven_distance(const IndexedMesh& mesh, double tolerance) const override
    {
        require_no_fold();
        if (!doubt().empty()) return std::nullopt;
        const auto source = pulled_back(mesh);
        if (!source) return std::nullopt;
        const double image = image_deviation(*source, mesh.vertices, lattice_);
        if (!(image < tolerance)) return std::nullopt;
        Box3 all = source_box_;
        all.add(genus::bounds(*source));
        const double stretch = lattice_.stretch(all) * (1.0 + 0x1p-40);
        const auto flat = proven_source_distance(*source, (tolerance - image) / stretch);
        if (!flat) return std::nullopt;
        return std::min(tolerance, stretch * *flat + image);
    }

    double sampled_distance(const IndexedMesh& mesh) const override
    {
        return std::max(from_mesh(mesh, *deformed_field()), from_solid(mesh));
    }

private:
    void mix(double value)
    {
        hash_ ^= std::bit_cast<std::uint64_t>(value + 0.0) + 0x9e3779b97f4a7c15U + (hash_ << 6U) +
                 (hash_ >> 2U);
        hash_ *= 0xbf58476d1ce4e5b9U;
    }

    // Throws where space is turned inside out.
    void require_no_fold() const
    {
        if (folds().kind == FoldReport::Kind::Folded)
            throw InvalidInput("deform: the lattice turns space inside out at " +
                               place(folds().where));
    }
    const FoldReport& folds() const
    {
        std::call_once(folds_known_, [&] { folds_ = lattice_.folds(); });
        return folds_;
    }

    // What keeps a bound from being proven: the image may run into itself by less than a mesh
    // shows. Empty if no two points of the solid are taken to one place.
    const std::string& doubt() const
    {
        std::call_once(compared_, [&] { doubt_ = find_doubt(); });
        return doubt_;
    }
    std::string find_doubt() const
    {
        if (folds().kind == FoldReport::Kind::Undecided)
            return "the lattice may turn space inside out near " + place(folds().where);
        // A border that rests leaves no other choice to a map without folds.
        if (lattice_.border_continuity() >= 0) return {};
        // What reaches out of the lattice, if only by rounding, does not go with it.
        const Box3 local = image_bounds(part_, to_local(lattice_));
        const Box3 all = Box3{{}, {{1, 1, 1}}}.inflated(1e-12);
        if (!all.contains(local.min) || !all.contains(local.max))
            return "the solid reaches out of a lattice whose border moves";
        const OneToOneReport r = lattice_.one_to_one(source_box_);
        if (r.kind == OneToOneReport::Kind::Yes) return {};
        return std::string("in the box of the solid, points near ") + place(r.points[0]) + " and " +
               place(r.points[1]) +
               (r.kind == OneToOneReport::Kind::No ? " go to one place" : " may go to one place");
    }
    static std::string place(const Vec3& p)
    {
        return "[" + to_text(p[0]) + ", " + to_text(p[1]) + ", " + to_text(p[2]) + "]";
    }

    std::shared_ptr<const DeformedField> deformed_field() const
    {
        std::call_once(field_made_,
                       [&] { field_ = std::make_shared<const DeformedField>(part_, lattice_); });
        return field_;
    }

    double measured_distance(const IndexedMesh& mesh, double between_meshes) const
    {
        // A function that comes from a mesh is no judge of one.
        return is_exact(part_) ? sampled_distance(mesh) : between_meshes;
    }

    // The mesh whose vertices are taken to those of `mesh`; nothing if there is none.
    std::optional<IndexedMesh> pulled_back(const IndexedMesh& mesh) const
    {
        const auto field = deformed_field();
        IndexedMesh source = mesh;
        std::vector<char> found(source.n_vertices(), 0);
        parallel_for(found.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v)
                if (const auto x = field->inverse()(mesh.vertices[v])) {
                    source.vertices[v] = *x;
                    found[v] = 1;
                }
        });
        const bool all = std::all_of(found.begin(), found.end(), [](char f) { return f != 0; });
        return all ? std::optional(std::move(source)) : std::nullopt;
    }

    // Of a mesh before the deformation: by signs of the functions of the solid, or beside a
    // certified mesh of the solid where it has none.
    std::optional<double> proven_source_distance(const IndexedMesh& mesh, double tolerance) const
    {
        if (has_formula(part_)) return proven_by_signs(mesh, tolerance);
        MeshOptions options;
        options.tolerance = 0.25 * tolerance;
        options.measure = false;
        const MeshedSolid other = mesh_solid(part_, options);
        if (!other.error.certified) return std::nullopt;
        DistanceOptions precise;
        precise.sufficient = 0.7 * tolerance;
        const double bound = mesh_distance(mesh, other.mesh, precise).bound + other.error.bound;
        return bound <= tolerance ? std::optional(bound) : std::nullopt;
    }

    std::optional<double> proven_by_signs(const IndexedMesh& mesh, double tolerance) const
    {
        const CsgField field(part_);
        const SignFormula formula(field);
        const Box3 cube = cell_cube(source_box_);
        std::vector<SurfaceForm> forms;
        for (const Surface& s : field.surfaces()) forms.emplace_back(s, cube);
        SurfaceMesh labelled;
        labelled.mesh = mesh;
        for (const Triangle& t : mesh.faces) {
            const auto active = field.active(
                (mesh.vertices[at(t[0])] + mesh.vertices[at(t[1])] + mesh.vertices[at(t[2])]) /
                3.0);
            if (active.surface < 0) return std::nullopt;
            labelled.surface_of_face.push_back(2 * active.surface + (active.sign < 0.0 ? 1 : 0));
        }
        const Certificate c = certify(labelled, formula, forms, cube, tolerance);
        return c.n_failed == 0 ? std::optional(c.bound) : std::nullopt;
    }

    // From middles of faces and sides.
    double from_mesh(const IndexedMesh& mesh, const DeformedField& field) const
    {
        constexpr std::size_t kMost = 20'000;
        const std::size_t stride = 1 + mesh.n_faces() / kMost;
        const std::size_t n = mesh.n_faces() / stride;
        std::vector<double> found(n, 0.0);
        parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Triangle& t = mesh.faces[i * stride];
                const Vec3 &a = mesh.vertices[at(t[0])], &b = mesh.vertices[at(t[1])],
                           &c = mesh.vertices[at(t[2])];
                for (const Vec3& y : {(a + b + c) / 3.0, 0.5 * (a + b)}) {
                    if (const auto p = field.to_surface(y))
                        found[i] = std::max(found[i], distance(*p, y));
                }
            }
        });
        return found.empty() ? 0.0 : *std::max_element(found.begin(), found.end());
    }

    // From points of the exact surface: vertices of another mesh of the solid.
    double from_solid(const IndexedMesh& mesh) const
    {
        if (mesh.faces.empty()) return 0.0;
        MeshOptions options;
        options.tolerance = 0.01 * source_box_.diagonal();
        options.measure = false;
        options.round_faces = true;
        const IndexedMesh points = mesh_solid(part_, options).mesh;
        const MeshTree tree(mesh);
        double largest = 0.0;
        const std::size_t stride = 1 + points.n_vertices() / 5000;
        for (std::size_t v = 0; v < points.n_vertices(); v += stride) {
            if (v % 256 == 0) current_progress().check();
            largest = std::max(largest, tree.nearest(lattice_.apply(points.vertices[v])).distance);
        }
        return largest;
    }

    Solid part_;
    Lattice lattice_;
    Box3 source_box_, bounds_;
    std::uint64_t hash_ = 0;
    mutable std::once_flag field_made_, folds_known_, compared_;
    mutable FoldReport folds_;
    mutable std::string doubt_;
    mutable std::shared_ptr<const DeformedField> field_;
};

}  // namespace

Solid deformed(const Solid& solid, const Lattice& lattice)
{
    if (solid.is_empty()) return solid;
    return freeform(std::make_shared<const DeformedSource>(solid, lattice));
}

}  // namespace genus
