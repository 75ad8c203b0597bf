#include <span>
#include <string>
#include <vector>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/boolean/formula_text.h"
#include "genus/boolean/mesh_boolean.h"
#include "genus/boolean/operand_cache.h"
#include "genus/boolean/split.h"
#include "genus/mesh/hull.h"
#include "genus/model/boolean_road.h"
#include "genus/model/construct.h"
#include "long_call.h"

namespace genus::python {

namespace {

using Term = BooleanFormula::Term;

constexpr int kDeepest = 200;  // levels of a formula given as a tree

// Meshes of Python never change: what a boolean found out about one holds for the next.
OperandCache& known_operands()
{
    static OperandCache cache;
    return cache;
}

Mesh to_mesh(MeshBooleanResult result)
{
    Mesh mesh(std::move(result.mesh));
    mesh.origin = std::make_shared<const MeshOrigin>(MeshOrigin{
        std::move(result.operand), std::move(result.source_face), explain_boolean(result.report)});
    if (result.clean) known_operands().find(mesh.triangles, true);
    return mesh;
}

Mesh solve(const std::vector<const Mesh*>& meshes, const BooleanFormula& formula,
           bool merge_coplanar, const py::object& progress)
{
    MeshBooleanOptions options;
    options.merge_coplanar = merge_coplanar;
    std::vector<std::shared_ptr<const IndexedMesh>> kept;
    std::vector<BooleanOperand> operands;
    for (const Mesh* mesh : meshes) {
        kept.push_back(mesh->triangles);
        operands.push_back(known_operands().find(mesh->triangles));
    }
    return to_mesh(long_call([&] { return mesh_boolean(operands, formula, options); }, progress));
}

using Operation = BooleanFormula (*)(std::int32_t);

template <Operation operation>
Mesh combine(const Mesh& a, const Mesh& b)
{
    return solve({&a, &b}, operation(2), true, py::none());
}

// ---- Operators on any number of solids, or of meshes, one by one or in one list.

std::vector<py::object> operands_of(const py::args& args)
{
    py::object items = args;
    if (args.size() == 1 && !py::isinstance<Solid>(args[0]) && !py::isinstance<Mesh>(args[0]))
        items = args[0];
    std::vector<py::object> list;
    for (const py::handle item : items) list.push_back(py::reinterpret_borrow<py::object>(item));
    return list;
}

template <class T>
std::vector<T> all_of(const std::vector<py::object>& items, const std::string& kind)
{
    std::vector<T> list;
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (!py::isinstance<T>(items[i]))
            throw py::type_error("operand " + std::to_string(i) + " is a " +
                                 Py_TYPE(items[i].ptr())->tp_name + ", not a " + kind +
                                 "; all must be of one kind");
        list.push_back(items[i].cast<T>());
    }
    return list;
}

std::vector<Solid> to_solids(const std::vector<py::object>& items)
{
    return all_of<Solid>(items, "genus.Solid");
}

template <Operation of_meshes>
py::object combine_all(const py::args& args, Solid (*of_solids)(std::vector<Solid>))
{
    const std::vector<py::object> items = operands_of(args);
    if (items.empty() || !py::isinstance<Mesh>(items[0]))
        return py::cast(of_solids(to_solids(items)));
    const std::vector<Mesh> list = all_of<Mesh>(items, "genus.Mesh");
    std::vector<const Mesh*> meshes;
    for (const Mesh& mesh : list) meshes.push_back(&mesh);
    return py::cast(
        solve(meshes, of_meshes(static_cast<std::int32_t>(meshes.size())), true, py::none()));
}

// ---- Formulas

// A formula as nested tuples: ("-", "plate", ("+", 1, 2)).
class FormulaTree {
public:
    FormulaTree(const std::vector<std::string>& names, std::int32_t n_operands)
        : names_(names), n_operands_(n_operands)
    {
    }

    BooleanFormula run(const py::handle& tree)
    {
        const Term top = term(tree, 0);
        const auto last = static_cast<std::int32_t>(formula_.instructions.size()) - 1;
        if (top.is_operand || top.negated || top.index != last) formula_.add(false, {top});
        return std::move(formula_);
    }

private:
    Term term(const py::handle& item, int depth)
    {
        if (depth > kDeepest) throw InvalidInput("boolean: formula nested over 200 levels deep");
        if (py::isinstance<py::str>(item) || PyIndex_Check(item.ptr())) return operand(item);
        if (!py::isinstance<py::tuple>(item) && !py::isinstance<py::list>(item))
            throw InvalidInput(
                "boolean: a formula is a text, an operand, or a tuple of an "
                "operator and its parts");
        const auto node = py::reinterpret_borrow<py::sequence>(item);
        if (node.size() < 2 || !py::isinstance<py::str>(node[0]))
            throw InvalidInput("boolean: a tuple needs an operator, | + & or -, and its parts");
        const auto sign = node[0].cast<std::string>();
        const bool subtracts = sign == "-", intersects = sign == "&";
        if (!subtracts && !intersects && sign != "+" && sign != "|")
            throw InvalidInput("boolean: \"" + sign + "\" is no operator, | + & or -");
        std::vector<Term> terms;
        for (std::size_t i = 1; i < node.size(); ++i) {
            terms.push_back(term(node[i], depth + 1));
            if (subtracts && i > 1) terms.back().negated = !terms.back().negated;
        }
        return {formula_.add(subtracts || intersects, std::move(terms)), false, false};
    }

    Term operand(const py::handle& item) const
    {
        if (py::isinstance<py::str>(item)) {
            const auto name = item.cast<std::string>();
            for (std::size_t i = 0; i < names_.size(); ++i)
                if (names_[i] == name) return {static_cast<std::int32_t>(i), true, false};
            throw InvalidInput("boolean: '" + name + "' is no operand");
        }
        const auto number = item.cast<std::int64_t>();
        if (number < 0 || number >= n_operands_)
            throw InvalidInput("boolean: there is no operand " + std::to_string(number) +
                               " among the " + std::to_string(n_operands_));
        return {static_cast<std::int32_t>(number), true, false};
    }

    const std::vector<std::string>& names_;
    std::int32_t n_operands_;
    BooleanFormula formula_;
};

// Operands of a list are called a, b, ..., z where they are no more than that.
std::vector<std::string> letters(std::size_t n)
{
    std::vector<std::string> names;
    for (std::size_t i = 0; i < n && n <= 26; ++i)
        names.emplace_back(1, static_cast<char>('a' + i));
    return names;
}

Mesh boolean(const py::object& formula, const py::object& meshes, bool merge_coplanar,
             const py::object& progress)
{
    std::vector<std::string> names;
    std::vector<py::object> items;
    if (py::isinstance<py::dict>(meshes)) {
        for (const auto& [name, mesh] : meshes.cast<py::dict>()) {
            names.push_back(name.cast<std::string>());
            items.push_back(py::reinterpret_borrow<py::object>(mesh));
        }
    } else {
        for (const py::handle mesh : meshes)
            items.push_back(py::reinterpret_borrow<py::object>(mesh));
        names = letters(items.size());
    }
    std::vector<const Mesh*> operands;
    for (const py::object& item : items) operands.push_back(&item.cast<const Mesh&>());
    const auto n = static_cast<std::int32_t>(operands.size());
    const BooleanFormula parsed = py::isinstance<py::str>(formula)
                                      ? parse_formula(formula.cast<std::string>(), names, n)
                                      : FormulaTree(names, n).run(formula);
    return solve(operands, parsed, merge_coplanar, progress);
}

// ---- Hull, sum, split

Mesh hull_of_points(std::span<const Vec3> points)
{
    return Mesh(long_call([&] { return to_triangles(convex_hull(points)); }));
}

Mesh hull_of_meshes(const std::vector<Mesh>& meshes)
{
    std::vector<Vec3> points;
    for (const Mesh& mesh : meshes) {
        const std::vector<Vec3>& more = mesh.triangles->vertices;
        points.insert(points.end(), more.begin(), more.end());
    }
    return hull_of_points(points);
}

// Whether the only argument is no operand and no list of operands.
bool is_array_of_points(const py::args& args)
{
    if (args.size() != 1) return false;
    if (py::isinstance<py::array>(args[0])) return true;
    if (!py::isinstance<py::list>(args[0]) && !py::isinstance<py::tuple>(args[0])) return false;
    const auto rows = py::reinterpret_borrow<py::sequence>(args[0]);
    return rows.size() > 0 && py::isinstance<py::sequence>(rows[0]);
}

py::object hull_of(const py::args& args, std::optional<double> tolerance)
{
    if (is_array_of_points(args)) {
        const PointArray points = to_point_array(args[0], "points");
        return py::cast(hull_of_points(rows(points)));
    }
    const std::vector<py::object> items = operands_of(args);
    if (!items.empty() && py::isinstance<Mesh>(items[0]))
        return py::cast(hull_of_meshes(all_of<Mesh>(items, "genus.Mesh")));
    const std::vector<Solid> solids = to_solids(items);
    return py::cast(long_call([&] { return hull(solids, tolerance); }));
}

Solid sum_of(const Solid& a, const Solid& b, std::optional<double> tolerance)
{
    const std::vector<Solid> solids{a, b};
    return long_call([&] { return minkowski(solids, tolerance); });
}

py::tuple split_mesh(const Mesh& mesh, const VectorLike& normal, double offset)
{
    const Vec3 n = to_vec3(normal, "normal");
    SplitMesh parts =
        long_call([&, triangles = mesh.triangles] { return split(*triangles, n, offset); });
    return py::make_tuple(to_mesh(std::move(parts.below)), to_mesh(std::move(parts.above)));
}

py::object numbers_of(const Mesh& mesh, std::vector<std::int32_t> MeshOrigin::*numbers)
{
    if (!mesh.origin) return py::none();
    py::array array = to_array((*mesh.origin).*numbers);
    array.attr("flags").attr("writeable") = false;
    return array;
}

void bind_module(py::module_& m)
{
    m.def(
        "union",
        [](const py::args& operands) {
            return combine_all<&BooleanFormula::union_of>(operands, &unite);
        },
        R"(All that is in any of the solids, given one by one or as one list. Of meshes it is a mesh,
made at once.

>>> genus.union(genus.cube(1), genus.cube(2)).bounds().tolist()
[[0.0, 0.0, 0.0], [2.0, 2.0, 2.0]])");
    m.def(
        "intersection",
        [](const py::args& operands) {
            return combine_all<&BooleanFormula::intersection_of>(operands, &intersect);
        },
        R"(All that is in every one of the solids, given one by one or as one list. Of meshes it is a
mesh, made at once.

>>> genus.intersection(genus.cube(1), genus.cube(2)).bounds().tolist()
[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])");
    m.def(
        "difference",
        [](const py::args& operands) {
            return combine_all<&BooleanFormula::difference_of>(operands, &subtract);
        },
        R"(The first solid less all the others, given one by one or as one list. Of meshes it is a
mesh, made at once.

>>> genus.difference(genus.cube(2), genus.cube(1)).contains([[0.5, 0.5, 0.5]]).tolist()
[False])");
    m.def(
        "hull", &hull_of, py::kw_only(), py::arg("tolerance") = py::none(),
        R"(Convex hull of solids, given one by one or as one list. Of meshes, or of an array (n, 3)
of points, it is a mesh.

tolerance : of curved parts, model units; a quarter of a thousandth of the diagonal if left out

>>> tip = genus.cube(1).translate([0, 0, 1])
>>> genus.hull(genus.cube(1), tip).mesh().volume
2.0
>>> len(genus.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 0.1]]))
4)");
    m.def("minkowski", &sum_of, py::arg("a"), py::arg("b"), py::kw_only(),
          py::arg("tolerance") = py::none(),
          R"(All sums of a point of one solid and a point of the other.

tolerance : of curved solids, model units; a quarter of a thousandth of the diagonal if left out

>>> genus.minkowski(genus.cube(1), genus.cube([1, 2, 3])).bounds().tolist()
[[0.0, 0.0, 0.0], [2.0, 3.0, 4.0]])");
    m.def("boolean", &boolean, py::arg("formula"), py::arg("meshes"), py::kw_only(),
          py::arg("merge_coplanar") = true, py::arg("progress") = py::none(),
          R"doc(A boolean formula of closed meshes, solved exactly and at once.

Parameters
----------
formula : a text such as "a - (b | c)" with the operators of Python, + - & ^ | ~, or nested tuples
    such as ("-", 0, ("|", 1, 2))
meshes : a list, whose operands are called by number or, up to 26 of them, by the letters a, b,
    ..., or a dict of names
merge_coplanar : join faces of one plane and triangulate them anew

Raises
------
InvalidInput for a formula that is none, and for an operand that is not closed

>>> a, b = genus.cube(2).mesh(), genus.cube(1).mesh()
>>> genus.boolean("a - b", [a, b]).volume, genus.boolean("x & y", {"x": a, "y": b}).volume
(7.0, 1.0))doc");
}

}  // namespace

void bind_boolean(py::module_& m, py::class_<Mesh>& mesh)
{
    constexpr auto unites = &combine<&BooleanFormula::union_of>;
    mesh.def("__add__", unites, py::is_operator())
        .def("__or__", unites, py::is_operator())
        .def("__sub__", &combine<&BooleanFormula::difference_of>, py::is_operator())
        .def("__and__", &combine<&BooleanFormula::intersection_of>, py::is_operator())
        .def_property_readonly(
            "source_operand",
            [](const Mesh& self) { return numbers_of(self, &MeshOrigin::operand); },
            R"((m,) int32: of each face of a boolean's result, the operand that it comes from; None
for other meshes.)")
        .def_property_readonly(
            "source_face", [](const Mesh& self) { return numbers_of(self, &MeshOrigin::face); },
            "(m,) int32: the number of that face in its operand; None for other meshes.")
        .def("split", &split_mesh, py::arg("normal"), py::arg("offset") = 0.0,
             R"(The two closed parts into which a plane cuts the solid inside: where
normal . p <= offset, and the rest. Faces of the cut have source_operand 1.

>>> low, high = genus.cube(2).mesh().split([0, 0, 1], 0.5)
>>> low.volume, high.volume
(2.0, 6.0))");
    bind_module(m);
}

}  // namespace genus::python
