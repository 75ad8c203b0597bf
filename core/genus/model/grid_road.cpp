#include "genus/model/grid_road.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "genus/base/error.h"
#include "genus/implicit/jump_parts.h"
#include "genus/mesh/validate.h"
#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/csg_field.h"
#include "genus/model/deviation.h"
#include "genus/model/mesh_bound.h"
#include "genus/model/sign_formula.h"
#include "genus/model/specks.h"
#include "genus/model/stage_clock.h"
#include "genus/model/surface_form.h"
#include "genus/volume/extended_marching_cubes.h"
#include "genus/volume/marching_cubes.h"

namespace genus {

namespace {

// A little more on one side than on the other: planes through the middle of a box, where formulas
// like to jump, then do not pass through samples.
Box3 room_round(const Box3& box)
{
    const double d = box.diagonal();
    return {box.min - Vec3{{0.0100, 0.0093, 0.0087}} * d,
            box.max + Vec3{{0.0089, 0.0098, 0.0095}} * d};
}

class GridRoad {
public:
    GridRoad(const Solid& solid, const Box3& box, const MeshOptions& options,
             const std::optional<Vec3>& jump, MeshedSolid& result)
        : options_(options),
          result_(result),
          clock_(result.seconds),
          field_(solid),
          formula_(field_),
          box_(room_round(box)),
          cube_(cell_cube(box_)),
          jump_(jump)
    {
        for (const Surface& s : field_.surfaces()) {
            forms_.emplace_back(s, cube_);
            is_polynomial_ = is_polynomial_ && !s.function;
        }
        is_plain_ = jump_ && options.method == MeshMethod::Auto;
        clock_.end("field");
    }

    void run()
    {
        const Vec3 size = box_.size();
        double cell = std::max({size[0], size[1], size[2]}) / 15.7;
        double reached = std::numeric_limits<double>::infinity();
        std::int64_t expected = 0;
        // `before` is the error of the grid before the last that was halved.
        double finer = kHalf, before = std::numeric_limits<double>::infinity();
        int n_stuck = 0, n_slow = 0, n_between = 0;
        int n_sound = 0;
        for (int attempt = 0; attempt <= kMaxGrids;
             attempt += n_between == 0 ? 1 : 0, cell *= finer) {
            const bool was_halved = n_between == 0;
            finer = kHalf;
            if (expected > most_triangles() || n_sound == kMostProofs) break;
            const bool was_plain = is_plain_;
            IndexedMesh found = on_grid(cell);
            n_specks_ = leave_out_specks(found, field_, cell, result_.tolerance / kReserve);
            SurfaceMesh mesh = labelled(std::move(found));
            clock_.end("mesh");
            expected = 4 * static_cast<std::int64_t>(mesh.mesh.n_faces());
            const double measured =
                measure_deviation(mesh, formula_, forms_, box_, jump_.has_value());
            clock_.end("measure");
            reached = kReserve * measured;
            // At the edge of a jump the error falls with the cell.
            if (jump_ && attempt > 1 && reached > result_.tolerance)
                expected =
                    std::max(expected,
                             static_cast<std::int64_t>(static_cast<double>(mesh.mesh.n_faces()) *
                                                       std::pow(reached / result_.tolerance, 2.0)));
            if (was_halved) {
                // As where a function changes the faster the nearer one looks.
                n_stuck = reached > kStuck * before ? n_stuck + 1 : 0;
                // Sharp features that are none: plain marching cubes is always sound.
                if (reached > kSlow * before) ++n_slow;
                if (n_slow == kMostSlow && !is_polynomial_ && options_.method == MeshMethod::Auto)
                    is_plain_ = true;
            }
            if (n_stuck == kMostStuck && !(reached <= result_.tolerance)) break;
            if (!(reached <= result_.tolerance)) {
                if (n_between < kMostBetween) finer = step_after(reached, before);
                n_between = finer > kHalf ? n_between + 1 : 0;
                if (was_halved) before = reached;
                const auto n_faces = static_cast<double>(mesh.mesh.n_faces());
                if (finer > kHalf) expected = static_cast<std::int64_t>(n_faces / (finer * finer));
                continue;
            }
            n_between = 0;
            if (was_halved) before = reached;
            const bool sound = validate(mesh.mesh).ok();
            clock_.end("gate");
            if (!sound) {  // features of one grid run into each other, those of another may not
                finer = kOtherGrid;
                continue;
            }
            const Proof proof = is_polynomial_ ? prove(mesh, measured) : Proof{false};
            clock_.end("certify");
            if (proof.exceeded > 0.0) {
                reached = proof.exceeded;
                continue;
            }
            const bool is_proven = proof.is_given;
            ++n_sound;
            if (!is_proven && n_sound > 1) continue;  // the first is as good
            if (!is_proven) {
                const double sampled = kReserve * measured;
                result_.error = {sampled,
                                 false,
                                 measured,
                                 {{"sampled", sampled}},
                                 "distances were sampled only"};
            }
            result_.mesh = std::move(mesh.mesh);
            if (was_plain) result_.method = "mc";
            taken_ = report_;
            n_specks_taken_ = n_specks_;
            if (is_proven || !is_polynomial_) break;
        }
        if (n_sound > 0) {
            result_.explanation.add("samples of the grid decided by bounds of blocks",
                                    taken_.decided, "samples");
            if (taken_.confined + taken_.left_out > 0)
                result_.explanation.add("sharp features moved or left out, for faces would cross",
                                        taken_.confined + taken_.left_out, "cells");
            result_.explanation.add("specks of the grid left out, for they are the end of a wedge",
                                    n_specks_taken_, "parts");
            return;
        }
        give_up(reached);
    }

private:
    [[noreturn]] void give_up(double reached) const
    {
        std::string text =
            "mesh: no grid within the limits reaches the tolerance " + to_text(result_.tolerance);
        if (!jump_) throw ToleranceNotMet(text, result_.tolerance, reached, {box_});
        const Vec3& p = *jump_;
        text += "; a formula changes its sign without a zero, as at (" + to_text(p[0]) + ", " +
                to_text(p[1]) + ", " + to_text(p[2]) + ")";
        const Box3 place = Box3{p, p}.inflated(box_.diagonal() / 64.0);
        throw ToleranceNotMet(text, result_.tolerance, reached, {place});
    }

    // How much finer the next grid is after one that is too coarse. Between two that are halved
    // there may be others: where a little less is enough, as edges that are kept leave an error
    // that falls with the square of the cell; and where it did not fall, for an edge that runs
    // along a plane of samples, within a fraction of a cell of it, is in no cell that could keep
    // it, and of the next grid no plane may be so near.
    double step_after(double reached, double before) const
    {
        const bool is_cut = options_.method == MeshMethod::Mc || is_plain_;
        if (jump_) return kHalf;
        if (!is_cut && is_polynomial_ && reached > kSlow * before) return kOtherGrid;
        const double share = kEnough * result_.tolerance / reached;
        if (!(share > kHalf * kHalf)) return kHalf;
        return std::clamp(is_cut ? share : std::sqrt(share), kHalf, kOtherGrid);
    }

    std::int64_t most_triangles() const
    {
        if (is_polynomial_) return options_.max_triangles;
        return std::min(jump_ ? kMostAtJump : kMostOfFunction, options_.max_triangles);
    }

    static constexpr double kReserve = 1.5, kEnough = 0.8;
    static constexpr double kHalf = 0.5;
    static constexpr int kMostBetween = 6;
    static constexpr int kMaxGrids = 10, kMostStuck = 3;
    // Triangles without a proof.
    static constexpr std::int64_t kMostOfFunction = 1'500'000, kMostAtJump = 600'000;
    static constexpr double kStuck = 0.9;
    static constexpr int kMostSlow = 2;
    static constexpr double kSlow = 0.4;  // what halving a grid leaves, a quarter being right
    static constexpr double kOtherGrid = 0.87;
    // Grids of which a proof is tried, and boxes for one, a face.
    static constexpr int kMostProofs = 2;
    static constexpr std::int64_t kMostBoxes = 24;

    struct Proof {
        bool is_given;
        double exceeded = 0.0;  // more than the tolerance, if a place so far away was found
    };

    /// Proves a bound within the tolerance: by a sandwich, as good as the mesh where it is smooth,
    /// else by boxes, which sharp edges that plain marching cubes cut off do not disturb.
    Proof prove(const SurfaceMesh& mesh, double measured)
    {
        const auto given = [&](double bound, std::vector<std::pair<std::string, double>> parts) {
            if (measured > bound) return Proof{false};
            result_.error = {bound, true, measured, std::move(parts), ""};
            return Proof{true};
        };
        const double tolerance = result_.tolerance;
        const Certificate c = certify(mesh, formula_, forms_, cube_, tolerance);
        if (c.n_failed == 0) return given(c.bound, c.parts());
        const auto n_faces = static_cast<std::int64_t>(mesh.mesh.n_faces());
        const double enough = std::max(kReserve * measured, 0.5 * tolerance);
        const MeshBound found = bound_by_boxes(mesh.mesh, formula_, forms_, box_, enough, tolerance,
                                               kMostBoxes * n_faces);
        if (!found.bound) return {false, found.exceeded};
        return given(*found.bound, {{"boxes", *found.bound}});
    }

    IndexedMesh on_grid(double cell)
    {
        if (options_.method == MeshMethod::Mc || is_plain_) {
            MarchingCubesOptions grid;
            grid.cell_size = cell;
            grid.report = &report_;
            return marching_cubes(field_, box_, grid);
        }
        ExtendedMarchingCubesOptions grid;
        grid.cell_size = cell;
        grid.report = &report_;
        return extended_marching_cubes(field_, box_, grid);
    }

    // Each face takes the surface that is active at its middle.
    SurfaceMesh labelled(IndexedMesh&& mesh) const
    {
        SurfaceMesh result;
        result.mesh = std::move(mesh);
        result.surfaces_of_vertex.assign(result.mesh.n_vertices(), {-1, -1, -1});
        for (const Triangle& t : result.mesh.faces) {
            const std::vector<Vec3>& v = result.mesh.vertices;
            const auto active = field_.active((v[t[0]] + v[t[1]] + v[t[2]]) / 3.0);
            result.surface_of_face.push_back(2 * active.surface + (active.sign < 0.0 ? 1 : 0));
            for (const std::int32_t corner : t)
                for (std::int32_t& place : result.surfaces_of_vertex[corner]) {
                    if (place == active.surface) break;
                    if (place >= 0) continue;
                    place = active.surface;
                    break;
                }
        }
        return result;
    }

    const MeshOptions& options_;
    MeshedSolid& result_;
    StageClock clock_;
    CsgField field_;
    SignFormula formula_;
    Box3 box_, cube_;
    SamplingReport report_;  // of the last grid
    std::optional<Vec3> jump_;
    bool is_plain_ = false;
    bool is_polynomial_ = true;
    SamplingReport taken_;  // of the grid that was taken
    std::int64_t n_specks_ = 0, n_specks_taken_ = 0;
    std::vector<SurfaceForm> forms_;
};

}  // namespace

std::optional<Vec3> jump_at_border(const CsgField& field, const Box3& box)
{
    for (const Surface& s : field.surfaces())
        if (s.function && may_jump(s.function->expression()))
            return jump_at_border(static_cast<const Implicit&>(field), box);
    return std::nullopt;
}

void mesh_over_grid(const Solid& solid, const Box3& box, const MeshOptions& options,
                    const std::optional<Vec3>& jump, MeshedSolid& result)
{
    GridRoad(solid, box, options, jump, result).run();
}

}  // namespace genus
