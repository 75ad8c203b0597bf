#include "genus/model/mesh_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/validate.h"
#include "genus/model/boolean_road.h"
#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/deviation.h"
#include "genus/model/embedding.h"
#include "genus/model/fans.h"
#include "genus/model/fibres.h"
#include "genus/model/fine_certificate.h"
#include "genus/model/fine_mesh.h"
#include "genus/model/first_mesh.h"
#include "genus/model/flat_faces.h"
#include "genus/model/freeform_mesh.h"
#include "genus/model/grid_road.h"
#include "genus/model/parts_apart.h"
#include "genus/model/planar_functions.h"
#include "genus/model/queries.h"
#include "genus/model/refine.h"
#include "genus/model/sign_formula.h"
#include "genus/model/solid_field.h"
#include "genus/model/stage_clock.h"
#include "genus/model/surface_form.h"
#include "genus/model/widen.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxAttempts = 12;
constexpr double kSmallerCells = 0.3;
constexpr int kInsistingAttempts = 3;
constexpr double kSteep = 0.05;  // gradient, beside that of the leaf
constexpr double kFiner = 0.4;
// Where a place stays doubtful at ever finer cells, this many faces in all are tried.
constexpr std::size_t kFacesAttempt = 20'000, kGrowthOfFaces = 10;
constexpr int kMaxPasses = 6;
constexpr std::size_t kMaxPlaces = 256;
constexpr double kEdgeShare = 0.7;  // of the tolerance; the middle of a face errs 4/3 as much
constexpr double kTighter = 0.6, kTighterFunction = 0.35;
// Bounds of functions that are no polynomials are wider by about this, in places more.
constexpr double kFunctionShare = 0.5;
constexpr std::int64_t kMostFunctionCells = 400'000, kMostSmallFunctionCells = 50'000;
// The mesh in which a fine one is cut: its tolerance as a share of the diagonal, and what that must
// be beside the tolerance asked for.
constexpr double kSandwichWidth = 1.0 / 48, kLeastSandwich = 4.0;
constexpr double kWideShare = 0.5;     // of that, between a face made wide and its surface
constexpr double kThickness = 0.03;    // of a sandwich, of its tolerance
constexpr double kShortFibre = 0.125;  // of the tolerance
constexpr int kQuickAttempts = 3, kWideAttempts = 2, kMostHalvings = 5;
constexpr double kOnSurface = 1e-12;                                    // of the diagonal
constexpr double kUnsettled = 0.125, kFlatCrease = 0.5, kTouch = 0.25;  // of the tolerance
constexpr double kWideCosine = 0.82, kWideCosineSeveral = 0.9;
constexpr double kCreaseShare = 0.15;   // sagitta of a curve beside the height of a face
constexpr double kCoarsest = 1.0 / 32;  // of the diagonal, as a tolerance to work to
// Bounds tried once the deviation is measured, as shares of it, if one is as much smaller.
constexpr std::array<double, 2> kCloser{1.5, 2.5};
constexpr double kWorthwhile = 0.8;
constexpr double kCoarsestFunction = 1.0 / 128;  // second derivatives are bounded in small faces

void append(IndexedMesh& all, const IndexedMesh& mesh)
{
    require(all.n_vertices() + mesh.n_vertices() <=
                static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()),
            "mesh: too many vertices");
    const auto first = static_cast<std::int32_t>(all.n_vertices());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const Triangle& t : mesh.faces)
        all.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
}

bool any_function(const CsgField& field)
{
    return std::any_of(field.surfaces().begin(), field.surfaces().end(),
                       [](const Surface& s) { return s.function != nullptr; });
}

// One solid on its way to a mesh.
class Road {
public:
    Road(const Solid& solid, const Box3& box, const MeshOptions& options, MeshedSolid& result)
        : solid_(solid),
          options_(options),
          result_(result),
          clock_(result.seconds),
          field_(solid),
          formula_(field_),
          cube_(cell_cube(box))
    {
        for (const Surface& s : field_.surfaces()) forms_.emplace_back(s, cube_);
        clock_.end("field");
    }

    bool has_function() const { return has_function_; }
    /// Where the border is a jump nothing can be proven.
    std::optional<Vec3> jump(const Box3& box) const { return jump_at_border(field_, box); }

    void run()
    {
        // The finer the tolerance the more the short way saves.
        const double finer = kSandwichWidth * cube_.diagonal() / result_.tolerance;
        const int attempts = has_function_ || finer < kLeastSandwich ? 0
                             : finer < 8.0 * kLeastSandwich          ? kQuickAttempts
                                                                     : 2 * kQuickAttempts;
        if (!has_function_ && !options_.round_faces && guessed(attempts > 0)) return;
        if (meshed(attempts, wide_cells(), [&](SurfaceMesh& mesh) {
                // There is no sandwich round an edge along which the solid touches itself.
                hopeless_ = !mesh.touch_of_vertex.empty();
                return !hopeless_ && cut_within_sandwich(mesh);
            }))
            return;
        hopeless_ = false;
        if (!meshed(has_function_ ? 2 * kQuickAttempts : kMaxAttempts, CellDemands{},
                    [&](SurfaceMesh& mesh) { return reach_tolerance(mesh); }))
            give_up("the tolerance was not reached");
    }

private:
    // A guess at the coarse mesh takes a fraction of the time of cells, and most often will do: to
    // cut a mesh within its sandwich, or for large tolerances refined itself.
    bool guessed(bool sandwich)
    {
        SurfaceMesh mesh;
        try {
            if (!made_of_guess(sandwich, mesh)) return false;
        } catch (const Cancelled&) {
            throw;
        } catch (const Error&) {
            // Coarse leaves may meet as no mesh can say, or too many faces be needed between them.
            // What that means for the solid cells will tell.
            return false;
        }
        result_.explanation.add("cells not made, a boolean of coarse leaves in their place",
                                static_cast<std::int64_t>(forms_.size()), "surfaces");
        finish(std::move(mesh));
        return true;
    }

    bool made_of_guess(bool sandwich, SurfaceMesh& mesh)
    {
        current_progress().report("mesh", 0.0);
        std::optional<SurfaceMesh> guess = first_mesh(solid_, forms_, cube_);
        const bool usable = guess && separate_fans(*guess) && guess->touch_of_vertex.empty();
        clock_.end("mesh");
        if (!usable) return false;
        mesh = std::move(*guess);
        insists_ = true;
        if (!sandwich) return reach_tolerance(mesh);
        settle_all(mesh, forms_, kUnsettled * result_.tolerance);
        return cut_within_halved(coarse_mesh(mesh, true, true), mesh);
    }

    double edge_share() const { return has_function_ ? kFunctionShare * kEdgeShare : kEdgeShare; }

    // What is asked of the cells of a mesh that only has to have the right form.
    CellDemands wide_cells() const
    {
        CellDemands demands;
        demands.min_cosine = kWideCosine;
        demands.min_cosine_several = kWideCosineSeveral;
        demands.touch = kTouch * result_.tolerance;
        return demands;
    }

    // Cells are made finer where `attempt` leaves trouble, until it succeeds. False if it does not
    // within that number of times.
    template <class Attempt>
    bool meshed(int attempts, CellDemands demands, const Attempt& succeeds)
    {
        CellMesher mesher(formula_, forms_, cube_);
        demands.max_error = cube_.diagonal();
        demands.min_size = 0.125 * result_.tolerance;
        if (has_function_) demands.max_small = kMostSmallFunctionCells;
        std::size_t work = 0, budget = 0, n_splits = 0;
        for (int attempt = 0; attempt < attempts; ++attempt) {
            current_progress().report("mesh", static_cast<double>(attempt) / attempts);
            mesher.refine(demands,
                          has_function_ ? kMostFunctionCells : 4 * options_.max_triangles + 1000);
            // At an apex cells of one size may do where those of another do not.
            if (attempt > 0 && mesher.n_splits() == n_splits) {
                demands.min_size *= kSmallerCells;
                continue;
            }
            n_splits = mesher.n_splits();
            SurfaceMesh mesh = mesher.extract();
            const bool closed = separate_fans(mesh);
            clock_.end("mesh");
            budget += kFacesAttempt + (attempt == 0 ? kGrowthOfFaces * mesh.mesh.n_faces() : 0);
            insists_ = attempt < kInsistingAttempts;
            if (!insists_) work += mesh.mesh.n_faces();
            if (work > budget) return false;
            trouble_ = {{cube_, 0.0}};
            if (closed && succeeds(mesh)) {
                finish(std::move(mesh));
                return true;
            }
            if (hopeless_) return false;
            if (closed)
                demands.finer.insert(demands.finer.end(), trouble_.begin(), trouble_.end());
            else  // other cells everywhere, so that the same roundings do not meet again
                demands.min_cosine_several = 0.5 + 0.5 * demands.min_cosine_several;
        }
        return false;
    }

    // Brings a mesh with the right combination of faces to the tolerance and through all checks.
    // Where that fails, `trouble_` says where.
    bool reach_tolerance(SurfaceMesh& surface)
    {
        settle_all(surface, forms_, kOnSurface * cube_.diagonal());
        if (insists_ && asks_for_room(surface)) return false;
        std::vector<double> factors;
        double failed_before = kInfinity;
        for (int pass = 0; pass < kMaxPasses; ++pass) {
            FlexibleMesh mesh(std::move(surface));
            if (pass == 0) coarsen(mesh, forms_);
            const std::size_t before = mesh.n_vertices();
            current_progress().report("refine", 0.0);
            const std::vector<Box3> stuck = subdivide(
                mesh, forms_, edge_share() * result_.tolerance, factors, options_.max_triangles);
            const bool grew = mesh.n_vertices() > before;
            if (pass == 0) factors.clear();
            surface = mesh.release();
            clock_.end("refine");
            current_progress().report("certify", 0.0);
            const Certificate c = certify(surface, formula_, forms_, cube_, result_.tolerance);
            clock_.end("certify");
            if (c.n_failed == 0) return passes(surface, c);
            last_ = surface;
            note_trouble(surface, c);
            const bool better = static_cast<double>(c.n_failed) < 0.6 * failed_before;
            if (c.failed_faces.empty() || (pass > 0 && !(grew && better))) return false;
            failed_before = static_cast<double>(c.n_failed);
            factors.resize(surface.mesh.n_vertices(), 1.0);
            std::vector<char> again(factors.size(), 0);
            for (const std::int32_t f : c.failed_faces)
                for (const std::int32_t v : surface.mesh.faces[f]) again[v] = 1;
            for (std::size_t v = 0; v < factors.size(); ++v)
                if (again[v] != 0) factors[v] *= has_function_ ? kTighterFunction : kTighter;
        }
        return false;
    }

    // True, and trouble noted, if vertices could not move onto their surfaces for want of room.
    bool asks_for_room(const SurfaceMesh& surface)
    {
        std::vector<char> is_off(surface.mesh.n_vertices(), 0);
        for (std::size_t v = 0; v < is_off.size(); ++v)
            for (const std::int32_t s : surface.surfaces_of_vertex[v]) {
                if (s < 0) continue;
                const Vec3& p = surface.mesh.vertices[v];
                const double value = std::fabs(forms_[s].value(p));
                const double slope = norm(forms_[s].gradient(p));
                // Next to an apex there is no room at any size.
                if (slope > kSteep && value > kOnSurface * cube_.diagonal() * slope) is_off[v] = 1;
            }
        Certificate c;
        for (std::size_t f = 0; f < surface.mesh.n_faces(); ++f)
            for (const std::int32_t v : surface.mesh.faces[f])
                if (is_off[v] != 0) {
                    c.failed_faces.push_back(static_cast<std::int32_t>(f));
                    break;
                }
        if (c.failed_faces.empty()) return false;
        note_trouble(surface, c);
        return true;
    }

    // The short way to a tolerance far below the size of the features: a certificate for a mesh
    // much coarser, within which a mesh is then cut finely. Where that fails, `surface` is as
    // before and `trouble_` says where cells should be finer.
    bool cut_within_sandwich(SurfaceMesh& surface)
    {
        SurfaceMesh settled = surface;
        settle_all(settled, forms_, kUnsettled * result_.tolerance);
        // The wider the faces the fewer they are in the end; of smaller ones more can be proven.
        for (const bool wide : {true, false}) {
            if (wide && n_wide_ == kWideAttempts) continue;
            n_wide_ += wide ? 1 : 0;
            if (cut_within(coarse_mesh(settled, wide), false, surface)) return true;
        }
        return false;
    }

    // Faces that are too large for a proof are halved, as long as they do not get more by that.
    bool cut_within_halved(SurfaceMesh coarse, SurfaceMesh& surface)
    {
        std::size_t most = coarse.mesh.n_faces();
        for (int halvings = 0;; ++halvings) {
            too_large_.clear();
            if (cut_within(coarse, true, surface)) return true;
            if (too_large_.empty() || too_large_.size() > most || halvings == kMostHalvings)
                return false;
            most = std::max(halvings == 0 ? 0 : most, too_large_.size() + too_large_.size() / 2);
            FlexibleMesh mesh(std::move(coarse));
            if (halve_faces(mesh, forms_, too_large_) == 0) return false;
            coarse = mesh.release();
        }
    }

    // `insists`: there is no other mesh, of smaller cells, to try next.
    bool cut_within(const SurfaceMesh& coarse, bool insists, SurfaceMesh& surface)
    {
        clock_.end("refine");
        current_progress().report("certify", 0.0);
        Sandwich sandwich;
        double short_fibre = 0.0;
        Certificate c = prove(coarse, sandwich_width(), insists, sandwich, short_fibre);
        clock_.end("certify");
        if (c.n_failed > 0 || !c.failed_faces.empty()) {
            note_trouble(coarse, c);
            return false;
        }
        const CoarseShell shell = shell_round(coarse, sandwich);
        FineMesh fine = cut_finely(coarse, sandwich, shell, forms_, result_.tolerance - short_fibre,
                                   options_.max_triangles);
        clock_.end("refine");
        c.failed_faces = fine.stuck;
        if (fine.stuck.empty())
            c = certify_within(sandwich, coarse, fine, formula_, forms_, result_.tolerance,
                               short_fibre);
        clock_.end("certify");
        if (!c.failed_faces.empty()) {
            note_trouble(coarse, c);
            return false;
        }
        const bool embedded = proven_embedded(shell, fine);
        clock_.end("gate");
        if (embedded) {
            note_bound(c);
        } else if (!passes(fine.surface, c)) {
            for (std::int32_t& f : too_large_) f = coarse_face(fine, f);
            std::sort(too_large_.begin(), too_large_.end());
            too_large_.erase(std::unique(too_large_.begin(), too_large_.end()), too_large_.end());
            return false;
        }
        surface = std::move(fine.surface);
        result_.explanation.add(
            "faces proven through those of a coarser mesh",
            static_cast<std::int64_t>(surface.mesh.n_faces() - coarse.mesh.n_faces()), "faces");
        return true;
    }

    static std::int32_t coarse_face(const FineMesh& fine, std::int32_t f)
    {
        const auto after = std::upper_bound(fine.first_face.begin(), fine.first_face.end(), f);
        return static_cast<std::int32_t>(after - fine.first_face.begin()) - 1;
    }

    double sandwich_width() const { return kSandwichWidth * cube_.diagonal(); }

    // A sandwich is to be thin for its fibres; if that leaves boxes without ways to it, or its
    // fibres at exact corners without a length, thick.
    Certificate prove(const SurfaceMesh& coarse, double width, bool insists, Sandwich& sandwich,
                      double& short_fibre) const
    {
        Certificate c;
        for (const double thickness : {0.0, kThickness}) {
            sandwich.thickness = thickness;
            c = certify(coarse, formula_, forms_, cube_, width, &sandwich);
            if (c.n_failed > 0 && c.failed_faces.empty()) continue;
            if (c.n_failed > 0) break;
            DoubtfulPrisms doubtful = doubtful_prisms(coarse, sandwich, formula_, forms_,
                                                      kShortFibre * result_.tolerance);
            c.failed_faces = std::move(doubtful.faces);
            short_fibre = doubtful.longest_short;
            if (c.failed_faces.empty() || !insists) break;
        }
        return c;
    }

    // With curves flat beside the faces along them.
    SurfaceMesh coarse_mesh(const SurfaceMesh& settled, bool wide, bool round_planes = false) const
    {
        FlexibleMesh mesh{SurfaceMesh(settled)};
        if (wide) widen(mesh, forms_, kWideShare * sandwich_width(), kTouch * result_.tolerance);
        if (round_planes) round_flat_faces(mesh, forms_);
        std::vector<double> factors;
        subdivide(mesh, forms_, kEdgeShare * sandwich_width(), factors, options_.max_triangles,
                  {kCreaseShare, kFlatCrease * result_.tolerance});
        return mesh.release();
    }

    bool passes(const SurfaceMesh& mesh, const Certificate& c)
    {
        const Validation validation = validate(mesh.mesh);
        clock_.end("gate");
        trouble_.clear();
        for (const Finding& finding : validation.findings) {
            Box3 box;
            double size = kInfinity;
            too_large_.insert(too_large_.end(), finding.faces.begin(), finding.faces.end());
            for (const std::int32_t f : finding.faces)
                for (const std::int32_t v : mesh.mesh.faces[f]) {
                    box.add(mesh.mesh.vertices[v]);
                    size = std::min(size, mesh.cell_size[v]);
                }
            if (!box.empty()) trouble_.emplace_back(box, 0.5 * size);
        }
        if (!validation.ok()) return false;
        note_bound(c);
        return true;
    }

    void note_bound(const Certificate& c)
    {
        result_.error.bound = c.bound;
        result_.error.certified = true;
        result_.error.parts = c.parts();
    }

    void finish(SurfaceMesh&& mesh)
    {
        if (options_.measure) {
            result_.error.measured = measure_deviation(
                mesh, formula_, forms_, bounds(mesh.mesh).inflated(result_.tolerance));
            clock_.end("measure");
            tighten_bound(mesh);
            clock_.end("certify");
        }
        result_.mesh = std::move(mesh.mesh);
    }

    // A certificate looks for no better bound than the tolerance asks for. Where samples are much
    // nearer than what was shown, a closer one may hold as well.
    void tighten_bound(const SurfaceMesh& mesh)
    {
        for (const double share : kCloser) {
            const double closer = share * result_.error.measured;
            if (!(closer < kWorthwhile * result_.error.bound)) return;
            const Certificate c = certify(mesh, formula_, forms_, cube_, closer);
            if (c.n_failed == 0 && c.bound < result_.error.bound) return note_bound(c);
        }
    }

    // Asks for cells of half the size round these faces, and for boxes of half theirs.
    void note_trouble(const SurfaceMesh& mesh, const Certificate& c)
    {
        trouble_.clear();
        for (const std::int32_t f : c.failed_faces) {
            Box3 box;
            double size = kInfinity;
            for (const std::int32_t v : mesh.mesh.faces[f]) {
                box.add(mesh.mesh.vertices[v]);
                size = std::min(size, mesh.cell_size[v]);
            }
            trouble_.emplace_back(box.inflated(0.25 * box.diagonal()), kFiner * size);
        }
        too_large_ = c.failed_faces;
        if (trouble_.empty())
            for (const Box3& box : c.failed) trouble_.emplace_back(box, 0.5 * box.diagonal());
    }

    [[noreturn]] void give_up(const std::string& why) const
    {
        std::vector<Box3> places;
        for (const auto& [box, size] : trouble_)
            if (places.size() < kMaxPlaces) places.push_back(box);
        const double reached = bound_reached();
        const std::string within = std::isinf(reached) ? "" : ", within " + to_text(reached);
        throw ToleranceNotMet("mesh: " + why + within + ", asked for " + to_text(result_.tolerance),
                              result_.tolerance, reached, std::move(places));
    }

    // What can be proven of the last mesh: of ever larger tolerances the first that holds.
    double bound_reached() const
    {
        for (double wider = 4.0; !last_.mesh.faces.empty() && wider <= 64.0; wider *= 4.0) {
            const Certificate c =
                certify(last_, formula_, forms_, cube_, wider * result_.tolerance);
            if (c.n_failed == 0) return c.bound;
        }
        return kInfinity;
    }

    const Solid& solid_;
    const MeshOptions& options_;
    MeshedSolid& result_;
    StageClock clock_;
    CsgField field_;
    SignFormula formula_;
    bool has_function_ = any_function(field_);
    Box3 cube_;
    std::vector<SurfaceForm> forms_;
    bool insists_ = false;                          // on all vertices being on their surfaces
    int n_wide_ = 0;                                // attempts with wide faces
    bool hopeless_ = false;                         // finer cells will not help this way
    std::vector<std::int32_t> too_large_;           // faces that something could not be proven of
    SurfaceMesh last_;                              // the last one without a certificate
    std::vector<std::pair<Box3, double>> trouble_;  // where, and how small the cells must be
};

// Bounds of a function may be too wide to prove what is so, as next to a pole: then its mesh comes
// from a grid, with the error sampled.
void mesh_curved(const Solid& solid, const Box3& box, const MeshOptions& options,
                 MeshedSolid& result)
{
    Road road(solid, box, options, result);
    const std::optional<Vec3> jump = road.jump(box);
    const auto over_grid = [&] {
        result.method = "emc";
        mesh_over_grid(solid, box, options, jump, result);
    };
    if (jump) return over_grid();
    const double asked = result.tolerance;
    if (road.has_function())
        result.tolerance = std::min(result.tolerance, kCoarsestFunction * box.diagonal());
    try {
        road.run();
    } catch (const ToleranceNotMet&) {
        if (!road.has_function()) throw;
        result.tolerance = asked;
        over_grid();
    }
}

// Meshes of solids whose boxes are farther apart than twice the tolerance, side by side.
void mesh_apart(const std::vector<Solid>& parts, const MeshOptions& options, MeshedSolid& result)
{
    MeshOptions part_options = options;
    part_options.tolerance = result.tolerance;
    part_options.region.reset();
    result.method.clear();
    for (const Solid& part : parts) {
        const MeshedSolid made = mesh_solid(part, part_options);
        part_options.max_triangles -= static_cast<std::int64_t>(made.mesh.n_faces());
        append(result.mesh, made.mesh);
        result.error.bound = std::max(result.error.bound, made.error.bound);
        result.error.measured = std::max(result.error.measured, made.error.measured);
        if (result.error.certified) result.error.doubt = made.error.doubt;
        result.error.certified = result.error.certified && made.error.certified;
        for (const auto& [cause, share] : made.error.parts)
            entry(result.error.parts, cause) = std::max(entry(result.error.parts, cause), share);
        for (const auto& [stage, seconds] : made.seconds) entry(result.seconds, stage) += seconds;
        for (const Explanation::Entry& e : made.explanation.entries)
            result.explanation.add(e.what, e.count, e.unit);
        if (result.method.empty() || made.method != "boolean") result.method = made.method;
    }
    std::stable_sort(result.error.parts.begin(), result.error.parts.end(),
                     [](const auto& x, const auto& y) { return x.second > y.second; });
    result.explanation.add("parts that are apart meshed one by one",
                           static_cast<std::int64_t>(parts.size()), "parts");
}

// By the exact boolean, if functions are all planes: not certified where corners had to be rounded.
// Nothing if another way was asked for, or the solid is no such.
std::optional<MeshedSolid> mesh_planes(const Solid& solid, const MeshOptions& options,
                                       const MeshedSolid& planned)
{
    if (options.method != MeshMethod::Auto && options.method != MeshMethod::Boolean)
        return std::nullopt;
    const std::optional<Solid> polyhedra = as_polyhedra(solid);
    if (!polyhedra) return std::nullopt;
    MeshOptions own = options;
    own.plan = false;
    own.region.reset();
    own.tolerance = planned.tolerance;
    MeshedSolid result = mesh_solid(*polyhedra, own);
    result.explanation.entries.insert(result.explanation.entries.begin(),
                                      planned.explanation.entries.begin(),
                                      planned.explanation.entries.end());
    return result;
}

// Coordinates of curved solids are rounded; what is asked for must leave room for that.
void require_above_rounding(double tolerance, const Box3& box)
{
    double reach = 0.0;
    for (int i = 0; i < 3; ++i)
        reach = std::max({reach, std::fabs(box.min[i]), std::fabs(box.max[i])});
    const double least = 0x1p-49 * reach;
    if (tolerance >= least) return;
    throw ToleranceNotMet("mesh: " + to_text(tolerance) +
                              " is below the rounding of coordinates of this size, about " +
                              to_text(least),
                          tolerance, least, {box});
}

// What of the solid is in the region.
Solid cut_out(const Solid& solid, const std::optional<Box3>& region)
{
    if (!region) return solid;
    const Vec3 size = region->size();
    require(region->bounded() && size[0] > 0.0 && size[1] > 0.0 && size[2] > 0.0,
            "mesh: region is no box with a positive size along each axis");
    return intersect({solid, transformed(cube(size), translation(region->min))});
}

}  // namespace

MeshedSolid mesh_solid(const Solid& solid, const MeshOptions& options)
{
    if (options.tolerance)
        require(*options.tolerance > 0.0 && std::isfinite(*options.tolerance), "mesh: tolerance",
                *options.tolerance, "positive");
    require(options.max_triangles > 0, "mesh: max_triangles must be positive");
    MeshedSolid result;
    result.method = "cells";
    StageClock clock(result.seconds);
    Solid planned = cut_out(solid, options.region);
    if (options.plan) {
        Plan p = plan(planned);
        planned = p.solid;
        result.explanation = std::move(p.explanation);
    }
    clock.end("plan");
    const Box3 box = require_bounded(planned);
    result.tolerance = options.tolerance.value_or(1e-3 * box.diagonal());
    result.error.certified = true;
    if (planned.is_empty() || box.empty() || box.diagonal() == 0.0) return result;
    std::optional<MeshedSolid> flat = mesh_planes(planned, options, result);
    if (flat && flat->error.certified) return *flat;
    if (options.method == MeshMethod::Auto && !is_polyhedral(planned)) {
        const std::vector<Solid> parts = parts_apart(planned, 2.0 * result.tolerance);
        if (parts.size() > 1) {
            mesh_apart(parts, options, result);
            return result;
        }
    }
    if (!is_polyhedral(planned)) require_above_rounding(result.tolerance, box);
    const SmoothMesher mesh_smooth_part = [&](const Solid& part, double tolerance) -> SmoothMesh {
        if (is_lone_freeform(part)) {
            FreeformSource::Meshed made =
                mesh_freeform(part, tolerance, {options.max_triangles, false, true});
            return {std::move(made.mesh), made.bound, made.certified, std::move(made.to_surface),
                    std::move(made.doubt)};
        }
        MeshedSolid made;
        made.tolerance = tolerance;
        MeshOptions part_options = options;
        part_options.measure = false;
        mesh_curved(part, require_bounded(part), part_options, made);
        return {std::move(made.mesh), made.error.bound, made.error.certified,
                [field = std::make_shared<const CsgField>(part)](const Vec3& p) {
                    return to_zero(*field, p);
                },
                made.error.doubt};
    };
    // A tolerance of the size of the solid asks for nothing; work is done to one that does.
    const double asked = result.tolerance;
    result.tolerance = std::min(asked, kCoarsest * box.diagonal());
    try {
        const bool lone = is_lone_freeform(planned) && options.method != MeshMethod::Boolean;
        if (lone && mesh_freeform_alone(planned, options, result)) {
            clock.end("mesh");
        } else if (options.method == MeshMethod::Boolean ||
                   (options.method == MeshMethod::Auto &&
                    (is_polyhedral(planned) || !is_smooth(planned)))) {
            mesh_by_boolean(planned, box, mesh_smooth_part, result);
        } else if (options.method == MeshMethod::Emc || options.method == MeshMethod::Mc) {
            result.method = options.method == MeshMethod::Mc ? "mc" : "emc";
            mesh_over_grid(planned, box, options, jump_at_border(CsgField(planned), box), result);
        } else {
            mesh_curved(planned, box, options, result);
        }
    } catch (const ToleranceNotMet& failure) {
        if (flat) return *flat;
        throw ToleranceNotMet(failure.what(), asked, failure.reached(), failure.where());
    }
    result.tolerance = asked;
    return result;
}

}  // namespace genus
