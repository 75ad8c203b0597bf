#include "genus/model/mesh_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "genus/base/error.h"
#include "genus/base/progress.h"
#include "genus/mesh/validate.h"
#include "genus/model/cell_mesh.h"
#include "genus/model/certificate.h"
#include "genus/model/deviation.h"
#include "genus/model/refine.h"
#include "genus/model/sign_formula.h"
#include "genus/model/surface_form.h"

namespace genus {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMaxAttempts = 8;

// Adds the seconds since construction, or since the last call, to a named stage.
class StageClock {
public:
    explicit StageClock(std::vector<std::pair<std::string, double>>& stages)
        : stages_(stages), last_(seconds_now())
    {
    }
    void end(const char* stage)
    {
        const double now = seconds_now();
        const auto at = std::find_if(stages_.begin(), stages_.end(),
                                     [&](const auto& s) { return s.first == stage; });
        if (at == stages_.end())
            stages_.emplace_back(stage, now - last_);
        else
            at->second += now - last_;
        last_ = now;
    }

private:
    std::vector<std::pair<std::string, double>>& stages_;
    double last_;
};

// One solid on its way to a mesh.
class Road {
public:
    Road(const Solid& solid, const MeshOptions& options, MeshedSolid& result)
        : options_(options),
          result_(result),
          clock_(result.seconds),
          field_(solid),
          formula_(field_),
          cube_(cell_cube(solid.bounds()))
    {
        for (const Surface& s : field_.surfaces()) forms_.emplace_back(s, cube_);
        clock_.end("field");
    }

    void run()
    {
        CellMesher mesher(formula_, forms_, cube_);
        CellDemands demands;
        demands.max_error = 0.45 * result_.tolerance;
        demands.min_size = 0.25 * result_.tolerance;
        for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
            current_progress().report("mesh", static_cast<double>(attempt) / kMaxAttempts);
            mesher.refine(demands, 4 * options_.max_triangles + 1000);
            SurfaceMesh mesh = mesher.extract();
            if (static_cast<std::int64_t>(mesh.mesh.n_faces()) > options_.max_triangles)
                give_up("the mesh would have more than max_triangles triangles");
            const bool closed = separate_fans(mesh);
            settle(mesh, forms_);
            clock_.end("mesh");
            if (closed && passes(mesh)) {
                finish(std::move(mesh));
                return;
            }
            if (!closed) places_ = {cube_};
            look_closer(demands, attempt);
        }
        give_up("the tolerance was not reached");
    }

private:
    bool passes(const SurfaceMesh& mesh)
    {
        const Certificate c = certify(mesh, formula_, forms_, cube_, result_.tolerance);
        clock_.end("certify");
        places_ = c.failed;
        if (c.n_failed > 0) return false;
        const Validation validation = validate(mesh.mesh);
        clock_.end("gate");
        for (const Finding& finding : validation.findings) {
            Box3 box;
            box.add(finding.at);
            places_.push_back(box);
        }
        if (!validation.ok()) return false;
        result_.error.bound = c.bound;
        result_.error.certified = true;
        result_.error.parts = {
            {"faces", c.faces}, {"edges and corners", c.creases}, {"rounding", c.rounding}};
        std::stable_sort(result_.error.parts.begin(), result_.error.parts.end(),
                         [](const auto& a, const auto& b) { return a.second > b.second; });
        return true;
    }

    void finish(SurfaceMesh&& mesh)
    {
        if (options_.measure) {
            result_.error.measured = measure_deviation(
                mesh, formula_, forms_, bounds(mesh.mesh).inflated(result_.tolerance));
            clock_.end("measure");
        }
        result_.mesh = std::move(mesh.mesh);
    }

    void look_closer(CellDemands& demands, int attempt)
    {
        const double error = demands.max_error * std::ldexp(1.0, -2 * (attempt + 1));
        demands.min_size = std::min(demands.min_size, 0.5 * error);
        for (const Box3& place : places_)
            demands.finer.emplace_back(place.inflated(2.0 * result_.tolerance), error);
    }

    [[noreturn]] void give_up(const std::string& why) const
    {
        throw ToleranceNotMet("mesh: " + why + ", asked for " + to_text(result_.tolerance),
                              result_.tolerance, kInfinity, places_);
    }

    const MeshOptions& options_;
    MeshedSolid& result_;
    StageClock clock_;
    CsgField field_;
    SignFormula formula_;
    Box3 cube_;
    std::vector<SurfaceForm> forms_;
    std::vector<Box3> places_;
};

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
    Solid planned = solid;
    if (options.plan) {
        Plan p = plan(solid);
        planned = p.solid;
        result.explanation = std::move(p.explanation);
    }
    clock.end("plan");
    const Box3& box = planned.bounds();
    if (!box.bounded()) throw UnboundedSolid("mesh: the solid reaches to infinity");
    result.tolerance = options.tolerance.value_or(1e-3 * box.diagonal());
    result.error.certified = true;
    if (planned.is_empty() || box.empty() || box.diagonal() == 0.0) return result;
    Road(planned, options, result).run();
    return result;
}

}  // namespace genus
