#include "genus/model/patch_solid.h"

#include <bit>

#include "genus/base/error.h"
#include "genus/mesh/measure.h"
#include "genus/model/freeform.h"

namespace genus {

namespace {

std::uint64_t mixed(std::uint64_t hash, double value)
{
    hash ^= std::bit_cast<std::uint64_t>(value + 0.0) + 0x9e3779b97f4a7c15U + (hash << 6U) +
            (hash >> 2U);
    return hash * 0xbf58476d1ce4e5b9U;
}

class PatchSource final : public FreeformSource {
public:
    explicit PatchSource(const PatchModel& model) : model_(model), bounds_(model.bounds())
    {
        for (const Patch& patch : model.patches())
            std::visit(
                [&](const auto& p) {
                    for (const Vec3& x : p.points())
                        for (const double c : x.c) hash_ = mixed(hash_, c);
                    for (const double w : p.weights()) hash_ = mixed(hash_, w);
                },
                patch);
    }

    Box3 bounds() const override { return bounds_; }
    std::string describe() const override
    {
        return "solid of " + std::to_string(model_.patches().size()) + " patches";
    }
    std::uint64_t hash() const override { return hash_; }
    bool equals(const FreeformSource& other) const override
    {
        const auto* o = dynamic_cast<const PatchSource*>(&other);
        return o && hash_ == o->hash_ && model_.patches() == o->model_.patches();
    }
    Meshed mesh(double tolerance, const Limits& limits) const override
    {
        TessellatedPatches made = model_.tessellate({tolerance, limits.max_triangles});
        Meshed result;
        result.bound = made.bound;
        result.certified = true;
        if (limits.measure) result.measured = measured_deviation(model_.patches(), made);
        result.mesh = std::move(made.mesh);
        require(measure(result.mesh).volume > 0.0,
                "patches: the surface is turned inside out: exchange u and v of all patches");
        return result;
    }

private:
    PatchModel model_;
    Box3 bounds_;
    std::uint64_t hash_ = 0x94d049bb133111ebU;
};

std::string number_of(const PatchEdgeUse& use)
{
    return "edge " + std::to_string(use.edge) + " of patch " + std::to_string(use.patch);
}

void require_closed(const PatchModel& model)
{
    if (model.patches().empty()) throw InvalidInput("patches: there are none");
    for (const auto& users : model.edges()) {
        if (users.size() == 1)
            throw InvalidInput("patches: the surface is open at " + number_of(users[0]) +
                               " (both count from 0)");
        if (users.size() > 2)
            throw InvalidInput("patches: " + std::to_string(users.size()) +
                               " patches meet in one edge, " + number_of(users[0]) +
                               " (both count from 0)");
        if (users[0].forward == users[1].forward)
            throw InvalidInput("patches: " + number_of(users[0]) + " and " + number_of(users[1]) +
                               " run the same way: the front of one is inside (both count from 0)");
    }
}

}  // namespace

Solid patch_solid(const PatchModel& model)
{
    require_closed(model);
    return freeform(std::make_shared<const PatchSource>(model));
}

}  // namespace genus
