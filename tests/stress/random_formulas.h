#pragma once

// Random formulas over random solids in bad positions, and what theory promises of each: a sound
// mesh, volumes that add up, the same bits on any number of threads.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/boolean/shapes.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/boolean/mesh_boolean.h"

namespace genus::random_formulas {

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

inline IndexedMesh random_solid(Dice& dice)
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

inline BooleanFormula random_formula(Dice& dice, int n_operands)
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

/// Operands from sizes of 10^-9 to 10^9, at offsets of up to 10^15 sizes.
struct Case {
    std::vector<IndexedMesh> solids;
    BooleanFormula formula;
    int other;    // an operand that the result of the formula is joined with
    double size;  // of all operands
    double unit;  // of rounding at the largest coordinate
};

inline Case random_case(std::uint32_t seed)
{
    Case made;
    Dice dice(seed);
    const int n = 2 + dice.below(4);
    for (int i = 0; i < n; ++i) made.solids.push_back(random_solid(dice));
    const double scale = dice.one_in(3) ? std::pow(10.0, dice.below(19) - 9) : 1.0;
    const double offset = dice.one_in(3) ? scale * std::pow(10.0, dice.below(16)) : 0.0;
    for (IndexedMesh& mesh : made.solids)
        mesh = moved(scaled(mesh, scale), {{offset, 0.0, -offset}});
    made.size = 0.0;
    for (const IndexedMesh& mesh : made.solids)
        for (const Vec3& p : mesh.vertices)
            made.size = std::max(made.size, norm(p - made.solids[0].vertices[0]));
    made.unit = (made.size + std::sqrt(2.0) * offset) * 2.3e-16;
    made.formula = random_formula(dice, n);
    made.other = dice.below(n);
    return made;
}

struct Outcome {
    std::string refused;  // what the error says, empty for none
    std::string wrong;    // what is not as theory promises, empty for nothing
    std::int64_t n_mended = 0;
};

inline bool same_bits(const MeshBooleanResult& a, const MeshBooleanResult& b)
{
    return a.mesh.vertices == b.mesh.vertices && a.mesh.faces == b.mesh.faces &&
           a.operand == b.operand && a.source_face == b.source_face;
}

/// f or g, f and g, f less g, g less f for a random formula f and one of its operands, g.
/// Each is solved on 1 thread, and on 2 and 8 if `all_threads`, and once more with operands of
/// which earlier results are known.
inline Outcome try_formula(std::uint32_t seed, bool all_threads)
{
    Outcome outcome;
    Case made = random_case(seed);
    const auto f = static_cast<std::int32_t>(made.formula.instructions.size()) - 1;
    const auto fail = [&](const std::string& what) {
        outcome.wrong += (outcome.wrong.empty() ? "" : "; ") + what;
    };
    std::vector<BooleanOperand> known;
    for (const IndexedMesh& mesh : made.solids)
        known.emplace_back(std::make_shared<const IndexedMesh>(mesh));
    const auto volume_of = [&](bool is_intersection, bool not_f, bool not_g) {
        BooleanFormula pair = made.formula;
        pair.add(is_intersection, {{f, false, not_f}, {made.other, true, not_g}});
        const MeshBooleanResult r = mesh_boolean(made.solids, pair);
        const Validation checked = validate(r.mesh);
        for (const Finding& finding : checked.findings) fail(finding.text);
        if (!checked.topology.closed || !checked.topology.manifold) fail("not closed and manifold");
        if (r.operand.size() != r.mesh.faces.size() || r.source_face.size() != r.mesh.faces.size())
            fail("faces without a source");
        if (!same_bits(r, mesh_boolean(known, pair))) fail("other bits with known operands");
        if (all_threads) {
            const int before = thread_count();
            for (const int threads : {2, 8}) {
                set_thread_count(threads);
                if (!same_bits(r, mesh_boolean(made.solids, pair)))
                    fail("other bits on " + std::to_string(threads) + " threads");
            }
            set_thread_count(before);
        }
        // Rounding moves a corner by up to a unit in the last place of the largest coordinate,
        // snapping by what the report says.
        made.unit = std::max(made.unit, r.report.largest_snap);
        outcome.n_mended += r.report.n_mended;
        return volume(r.mesh);
    };
    try {
        const double v_or = volume_of(false, false, false);
        const double v_and = volume_of(true, false, false);
        const double v_f = volume_of(true, false, true);
        const double v_g = volume_of(true, true, false);
        const double tolerance = 200.0 * made.size * made.size * made.unit;
        if (!(std::abs(v_or - (v_and + v_f + v_g)) <= tolerance)) fail("volumes do not add up");
        if (!(std::min({v_and, v_f, v_g}) >= -tolerance)) fail("a volume is negative");
    } catch (const Error& error) {
        outcome.refused = error.what();
    }
    return outcome;
}

/// So many operands that they are combined in groups first: boxes between whole coordinates, which
/// touch in every way, and in every second case other solids among them.
struct Crowd {
    std::vector<IndexedMesh> solids;
    BooleanFormula formula;  // the union of the first `n_united` of them less the others
    double cells = -1.0;     // its volume where all are such boxes, counted cell by cell
    double unit = 1.0;       // of the coordinates, a cell's side
};

inline Crowd random_crowd(std::uint32_t seed)
{
    Crowd made;
    Dice dice(seed);
    const int n = 40 + dice.below(160), side = 3 + dice.below(4);
    const int n_united = dice.one_in(2) ? n : n / 2;
    const bool all_boxes = dice.one_in(2);
    made.unit = dice.one_in(2) ? 1.0 : 1.0 / 3.0;
    std::vector<char> inside(static_cast<std::size_t>(side * side * side), 0);
    for (int i = 0; i < n; ++i) {
        std::array<int, 3> low, high;
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = dice.below(side);
            high[k] = std::min(side, low[k] + 1 + dice.below(2));
        }
        for (int x = low[0]; x < high[0]; ++x)
            for (int y = low[1]; y < high[1]; ++y)
                for (int z = low[2]; z < high[2]; ++z)
                    inside[static_cast<std::size_t>((x * side + y) * side + z)] = i < n_united;
        const auto corner = [&](const std::array<int, 3>& c) {
            return Vec3{{made.unit * c[0], made.unit * c[1], made.unit * c[2]}};
        };
        const bool is_box = all_boxes || dice.one_in(2);
        made.solids.push_back(is_box ? box(corner(low), corner(high))
                                     : moved(scaled(random_solid(dice), made.unit), corner(low)));
    }
    BooleanFormula& formula = made.formula;
    std::vector<BooleanFormula::Term> united, rest;
    for (int i = 0; i < n; ++i) (i < n_united ? united : rest).push_back({i, true, i >= n_united});
    const std::int32_t first = formula.add(false, united);
    rest.push_back({first, false, false});
    formula.add(true, rest);
    if (all_boxes) made.cells = static_cast<double>(std::count(inside.begin(), inside.end(), 1));
    return made;
}

/// A crowd in groups and all at once: sound meshes of one form and volume, known for boxes; the
/// same bits on 2 and 8 threads if `all_threads`.
inline Outcome try_crowd(std::uint32_t seed, bool all_threads)
{
    Outcome outcome;
    const auto fail = [&](const std::string& what) {
        outcome.wrong += (outcome.wrong.empty() ? "" : "; ") + what;
    };
    const Crowd made = random_crowd(seed);
    try {
        MeshBooleanOptions at_once;
        at_once.largest_union = 1000;
        const MeshBooleanResult a = mesh_boolean(made.solids, made.formula, at_once);
        const MeshBooleanResult b = mesh_boolean(made.solids, made.formula);
        for (const MeshBooleanResult* r : {&a, &b}) {
            const Validation checked = validate(r->mesh);
            for (const Finding& finding : checked.findings) fail(finding.text);
            if (!checked.topology.closed || !checked.topology.manifold)
                fail("not closed and manifold");
            outcome.n_mended += r->report.n_mended;
        }
        const double cell = made.unit * made.unit * made.unit;
        const double snap =
            std::max({a.report.largest_snap, b.report.largest_snap, 10.0 * made.unit * 2.3e-16});
        const double tolerance = 1e4 * made.unit * made.unit * snap;
        if (!(std::abs(volume(a.mesh) - volume(b.mesh)) <= tolerance))
            fail("another volume in groups");
        if (made.cells >= 0.0) {
            if (!(std::abs(volume(b.mesh) - made.cells * cell) <= tolerance))
                fail("a volume of " + std::to_string(volume(b.mesh) / cell) + " cells, not " +
                     std::to_string(made.cells));
            if (genus_of(a.mesh) != genus_of(b.mesh) || parts_of(a.mesh) != parts_of(b.mesh))
                fail("another form in groups");
        }
        if (all_threads) {
            const int before = thread_count();
            for (const int threads : {2, 8}) {
                set_thread_count(threads);
                if (!same_bits(b, mesh_boolean(made.solids, made.formula)))
                    fail("other bits on " + std::to_string(threads) + " threads");
            }
            set_thread_count(before);
        }
    } catch (const Error& error) {
        outcome.refused = error.what();
    }
    return outcome;
}

}  // namespace genus::random_formulas
