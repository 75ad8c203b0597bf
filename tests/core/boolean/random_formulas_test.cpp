#include <cstdlib>

#include "genus/base/error.h"
#include "shapes.h"

// Random formulas over random solids in bad positions. What theory promises of each: a sound
// mesh, and volumes that add up. GENUS_LONG=n runs n rounds in place of the short form.

namespace genus {
namespace {

using namespace shapes;

class Dice {
public:
    explicit Dice(std::uint32_t seed) : random_(seed) {}
    int below(int n) { return static_cast<int>(random_() % static_cast<std::uint32_t>(n)); }
    double unit() { return static_cast<double>(random_()) / 4294967296.0; }
    double within(double a, double b) { return a + (b - a) * unit(); }
    bool one_in(int n) { return below(n) == 0; }

private:
    std::mt19937 random_;
};

IndexedMesh random_solid(Dice& dice)
{
    const auto whole = [&] { return static_cast<double>(dice.below(5)) - 2.0; };
    IndexedMesh mesh;
    switch (dice.below(7)) {
        case 0:
        case 1:
            mesh = cube(1.0 + dice.below(2), {{whole(), whole(), whole()}});
            break;
        case 2:
            mesh = prism(3 + dice.below(6), 1.0, dice.one_in(2) ? 1.0 : 0.5, -1.0, 1.0);
            break;
        case 3:
            mesh = sphere(4, 6, 1.0);
            break;
        case 4:
            mesh = torus(6, 4, 1.5, 0.5);
            break;
        case 5:
            while (!(std::abs(volume(mesh)) > 0.0)) {
                const auto corner = [&] { return Vec3{{whole(), whole(), whole()}}; };
                mesh = tetrahedron(corner(), corner(), corner(), corner());
            }
            break;
        default:
            mesh = joined(cube(2.0), moved(cube(1.0), {{whole() / 2, whole() / 2, whole()}}));
    }
    switch (dice.below(5)) {
        case 0:
            break;
        case 1:  // nearly where it was
            mesh = turned(mesh, {{dice.unit(), dice.unit(), 1.0}},
                          std::pow(10.0, -1 - dice.below(16)));
            break;
        case 2:
            mesh = turned(mesh, {{dice.unit() - 0.5, dice.unit() - 0.5, dice.unit() - 0.5}},
                          dice.within(0, 360));
            break;
        case 3:  // onto a common plane, a common edge, a common corner
            mesh = turned(mesh, {{0, 0, 1}}, 90.0 * dice.below(4));
            mesh = moved(mesh, {{whole() / 2, whole() / 2, whole() / 2}});
            break;
        default:
            mesh = moved(mesh, {{dice.unit(), dice.unit(), dice.unit()}});
    }
    if (dice.one_in(10)) mesh = inside_out(mesh);
    return mesh;
}

BooleanFormula random_formula(Dice& dice, int n_operands)
{
    BooleanFormula formula;
    while (true) {
        formula = {};
        const int n = 1 + dice.below(4);
        for (int i = 0; i < n; ++i) {
            std::vector<BooleanFormula::Term> terms;
            const int n_terms = 1 + dice.below(3);
            for (int t = 0; t < n_terms; ++t) {
                const bool operand = i == 0 || dice.one_in(2);
                terms.push_back({dice.below(operand ? n_operands : i), operand, dice.one_in(3)});
            }
            formula.add(dice.one_in(2), terms);
        }
        try {
            formula.check(n_operands);
            return formula;
        } catch (const InvalidInput&) {  // holds at infinity
        }
    }
}

int rounds(int short_form)
{
    const char* text = std::getenv("GENUS_LONG");
    return text ? std::atoi(text) : short_form;
}

int first_seed()
{
    const char* text = std::getenv("GENUS_SEED");
    return text ? std::atoi(text) : 0;
}

// What theory promises of one random case. True if it was refused.
bool try_formula(int seed)
{
    SCOPED_TRACE("seed " + std::to_string(seed));
    bool refused = false;
    Dice dice(static_cast<std::uint32_t>(seed));
    std::vector<IndexedMesh> solids;
    const int n = 2 + dice.below(4);
    for (int i = 0; i < n; ++i) solids.push_back(random_solid(dice));
    const double scale = dice.one_in(3) ? std::pow(10.0, dice.below(19) - 9) : 1.0;
    const double offset = dice.one_in(3) ? scale * std::pow(10.0, dice.below(16)) : 0.0;
    for (IndexedMesh& mesh : solids) mesh = moved(scaled(mesh, scale), {{offset, 0.0, -offset}});
    double size = 0.0;
    for (const IndexedMesh& mesh : solids)
        for (const Vec3& p : mesh.vertices) size = std::max(size, norm(p - solids[0].vertices[0]));
    // Rounding moves a corner by up to a unit in the last place of the largest coordinate,
    // snapping by what the report says.
    double unit = (size + std::sqrt(2.0) * offset) * 2.3e-16;
    const BooleanFormula formula = random_formula(dice, n);
    // f and g, f or g, f less g, g less f for two formulas that share operands
    BooleanFormula whole = formula;
    const auto f = static_cast<std::int32_t>(whole.instructions.size()) - 1;
    const int g = dice.below(n);
    const auto result = [&](bool is_intersection, bool not_f, bool not_g) {
        BooleanFormula pair = formula;
        pair.add(is_intersection, {{f, false, not_f}, {g, true, not_g}});
        const MeshBooleanResult r = mesh_boolean(solids, pair);
        expect_sound(r.mesh);
        unit = std::max(unit, r.report.largest_snap);
        EXPECT_EQ(r.operand.size(), r.mesh.faces.size());
        EXPECT_EQ(r.source_face.size(), r.mesh.faces.size());
        return volume(r.mesh);
    };
    try {
        const double v_or = result(false, false, false);
        const double v_and = result(true, false, false);
        const double v_f = result(true, false, true);
        const double v_g = result(true, true, false);
        const double tolerance = 200.0 * size * size * unit;
        EXPECT_NEAR(v_or, v_and + v_f + v_g, tolerance);
        EXPECT_GE(v_and, -tolerance);
        EXPECT_GE(v_f, -tolerance);
        EXPECT_GE(v_g, -tolerance);
    } catch (const Error& error) {
        refused = true;
        if (std::getenv("GENUS_VERBOSE"))
            std::printf("seed %d scale %g offset %g: %s\n", seed, scale, offset, error.what());
    }
    return refused;
}

TEST(RandomFormulas, SoundAndAddingUp)
{
    int refused = 0;
    const int n_rounds = rounds(300);
    for (int seed = first_seed(); seed < first_seed() + n_rounds; ++seed) {
        refused += try_formula(seed);
        if (::testing::Test::HasFailure()) return;
    }
    RecordProperty("refused", refused);
    std::printf("refused %d of %d\n", refused, n_rounds);
    EXPECT_LE(refused, n_rounds / 20);
}

TEST(RandomFormulas, CasesThatWereWrong)
{
    // 30162, 40480: thin parts that touch others were taken for doubled ones. 78908: a sliver that
    // rounding turned inside out.
    for (const int seed : {30162, 40480, 78908}) EXPECT_FALSE(try_formula(seed)) << seed;
}

}  // namespace
}  // namespace genus
