#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/implicit/function.h"
#include "genus/implicit/parse_expression.h"
#include "genus/model/solid.h"
#include "long_call.h"

namespace genus::python {

namespace {

/// An Expression or what Python takes for one number; nothing for anything else.
std::optional<Expression> to_expression(const py::handle& value)
{
    if (py::isinstance<Expression>(value)) return value.cast<Expression>();
    const bool is_number = PyFloat_Check(value.ptr()) || PyLong_Check(value.ptr()) ||
                           (PyNumber_Check(value.ptr()) && !PyComplex_Check(value.ptr()) &&
                            !PySequence_Check(value.ptr()));
    if (!is_number) return std::nullopt;
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        return std::nullopt;
    }
    return Expression(number);
}

Expression needed(const py::handle& value, const std::string& function)
{
    auto e = to_expression(value);
    if (!e)
        throw py::type_error(function + ": expected a number or a genus.Expression, got " +
                             std::string(py::str(py::type::handle_of(value).attr("__name__"))));
    return *e;
}

using OneOperand = Expression (*)(const Expression&);
using TwoOperands = Expression (*)(const Expression&, const Expression&);

template <Operation operation>
Expression one(const Expression& a)
{
    return Expression::apply(operation, a);
}

template <Operation operation>
Expression two(const Expression& a, const Expression& b)
{
    return Expression::apply(operation, a, b);
}

// Names as numpy has them: methods of an Expression, functions of the module, and what
// numpy.sin(genus.x) comes to.
const std::unordered_map<std::string, OneOperand>& functions_of_one()
{
    static const std::unordered_map<std::string, OneOperand> map{
        {"sin", &one<Operation::Sin>},         {"cos", &one<Operation::Cos>},
        {"tan", &one<Operation::Tan>},         {"arcsin", &one<Operation::Asin>},
        {"arccos", &one<Operation::Acos>},     {"arctan", &one<Operation::Atan>},
        {"sinh", &one<Operation::Sinh>},       {"cosh", &one<Operation::Cosh>},
        {"tanh", &one<Operation::Tanh>},       {"exp", &one<Operation::Exp>},
        {"log", &one<Operation::Log>},         {"sqrt", &one<Operation::Sqrt>},
        {"cbrt", &one<Operation::Cbrt>},       {"square", &one<Operation::Square>},
        {"absolute", &one<Operation::Abs>},    {"fabs", &one<Operation::Abs>},
        {"sign", &one<Operation::Sign>},       {"floor", &one<Operation::Floor>},
        {"ceil", &one<Operation::Ceil>},       {"rint", &one<Operation::Round>},
        {"negative", &one<Operation::Negate>},
    };
    return map;
}

const std::unordered_map<std::string, TwoOperands>& functions_of_two()
{
    static const std::unordered_map<std::string, TwoOperands> map{
        {"add", [](const Expression& a, const Expression& b) { return a + b; }},
        {"subtract", [](const Expression& a, const Expression& b) { return a - b; }},
        {"multiply", [](const Expression& a, const Expression& b) { return a * b; }},
        {"divide", [](const Expression& a, const Expression& b) { return a / b; }},
        {"true_divide", [](const Expression& a, const Expression& b) { return a / b; }},
        {"power", &genus::pow},
        {"float_power", &genus::pow},
        {"remainder", &genus::mod},
        {"mod", &genus::mod},
        {"minimum", &genus::min},
        {"maximum", &genus::max},
        {"fmin", &genus::min},
        {"fmax", &genus::max},
        {"hypot", &genus::hypot},
        {"arctan2", &two<Operation::Atan2>},
    };
    return map;
}

py::object not_implemented()
{
    return py::reinterpret_borrow<py::object>(Py_NotImplemented);
}

// numpy hands over what one of its functions is asked to do with an Expression.
py::object array_ufunc(const py::object&, const py::object& ufunc, const std::string& method,
                       const py::args& inputs, const py::kwargs& options)
{
    if (method != "__call__" || !options.empty()) return not_implemented();
    std::vector<Expression> operands;
    for (const py::handle& input : inputs) {
        const auto e = to_expression(input);
        if (!e) return not_implemented();
        operands.push_back(*e);
    }
    const auto name = ufunc.attr("__name__").cast<std::string>();
    if (operands.size() == 1)
        if (const auto f = functions_of_one().find(name); f != functions_of_one().end())
            return py::cast(f->second(operands[0]));
    if (operands.size() == 2)
        if (const auto f = functions_of_two().find(name); f != functions_of_two().end())
            return py::cast(f->second(operands[0], operands[1]));
    return not_implemented();
}

template <typename F>
auto operator_of(F f)
{
    return [f](const Expression& a, const py::object& b) -> py::object {
        const auto e = to_expression(b);
        return e ? py::cast(f(a, *e)) : not_implemented();
    };
}

template <typename F>
auto reflected(F f)
{
    return [f](const Expression& a, const py::object& b) -> py::object {
        const auto e = to_expression(b);
        return e ? py::cast(f(*e, a)) : not_implemented();
    };
}

py::array values_at(const Expression& e, const py::object& points)
{
    const PointArray array = to_point_array(points, "points");
    return to_array(long_call([&] {
        const Function f(e);
        const auto at = rows(array);
        std::vector<double> values(at.size());
        parallel_for(at.size(), 4096, [&](std::size_t begin, std::size_t end) {
            f.values(at.subspan(begin, end - begin), std::span(values).subspan(begin, end - begin));
        });
        return values;
    }));
}

py::array gradients_at(const Expression& e, const py::object& points)
{
    const PointArray array = to_point_array(points, "points");
    return to_array(long_call([&] {
        const Function f(e);
        const auto at = rows(array);
        std::vector<Vec3> gradients(at.size());
        parallel_for(at.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) gradients[i] = f.gradient(at[i]);
        });
        return gradients;
    }));
}

py::tuple bound_on(const Expression& e, const py::object& box)
{
    const Interval bound = Function(e).bound(to_box(box, "box"));
    return py::make_tuple(bound.lo, bound.hi);
}

Solid make_implicit(const py::object& f, const py::object& bounds)
{
    const Box3 box = to_box(bounds, "bounds");
    if (py::isinstance<py::str>(f)) return implicit(parse_expression(f.cast<std::string>()), box);
    if (const auto e = to_expression(f)) return implicit(*e, box);
    if (!PyCallable_Check(f.ptr()))
        throw py::type_error(
            "implicit: expected a text, a genus.Expression or a function of three");
    const py::object made = f(Expression::x(), Expression::y(), Expression::z());
    return implicit(needed(made, "implicit: result of the function"), box);
}

Expression folded(const py::args& values, TwoOperands f, const std::string& name)
{
    if (values.empty()) throw py::type_error(name + ": expected one value or more");
    Expression result = needed(values[0], name);
    for (std::size_t i = 1; i < values.size(); ++i) result = f(result, needed(values[i], name));
    return result;
}

void bind_expression(py::module_& m)
{
    py::class_<Expression> e(
        m, "Expression",
        "A formula in genus.x, genus.y and genus.z, for genus.implicit. Operators, the functions "
        "of\n"
        "this module and those of numpy of the same names make larger ones; angles are radians.\n"
        "What is not defined somewhere, as the root of a negative number, is outside there.");
    e.def("__add__", operator_of([](const Expression& a, const Expression& b) { return a + b; }))
        .def("__radd__", reflected([](const Expression& a, const Expression& b) { return a + b; }))
        .def("__sub__", operator_of([](const Expression& a, const Expression& b) { return a - b; }))
        .def("__rsub__", reflected([](const Expression& a, const Expression& b) { return a - b; }))
        .def("__mul__", operator_of([](const Expression& a, const Expression& b) { return a * b; }))
        .def("__rmul__", reflected([](const Expression& a, const Expression& b) { return a * b; }))
        .def("__truediv__",
             operator_of([](const Expression& a, const Expression& b) { return a / b; }))
        .def("__rtruediv__",
             reflected([](const Expression& a, const Expression& b) { return a / b; }))
        .def("__mod__", operator_of(&genus::mod))
        .def("__rmod__", reflected(&genus::mod))
        .def("__pow__", operator_of(&genus::pow))
        .def("__rpow__", reflected(&genus::pow))
        .def("__neg__", [](const Expression& a) { return -a; })
        .def("__pos__", [](const Expression& a) { return a; })
        .def("__abs__", &one<Operation::Abs>)
        .def("__bool__",
             [](const Expression&) -> bool {
                 throw py::type_error(
                     "a formula is neither true nor false; use genus.minimum, genus.maximum");
             })
        .def("__repr__", [](const Expression& a) { return to_text(a); })
        .def("__array_ufunc__", &array_ufunc)
        .def("value", &values_at, py::arg("points"),
             R"(For points (n, 3), (n,) float64; infinite where it is not defined.

>>> (genus.x**2 + genus.y).value([[3, 1, 0], [0, 2, 5]]).tolist()
[10.0, 2.0])")
        .def("gradient", &gradients_at, py::arg("points"),
             "For points (n, 3), (n, 3) float64; zero where it is not defined.")
        .def("bound", &bound_on, py::arg("box"),
             R"(Smallest and largest value in a box (2, 3), as a proven bound.

>>> low, high = (genus.x * genus.y).bound([[1, 2, 0], [3, 4, 0]])
>>> low <= 2 and high >= 12
True)");
}

void bind_functions(py::module_& m)
{
    m.attr("x") = Expression::x();
    m.attr("y") = Expression::y();
    m.attr("z") = Expression::z();
    for (const char* name :
         {"sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "log",
          "sqrt", "cbrt", "square", "absolute", "sign", "floor", "ceil", "rint"}) {
        const OneOperand f = functions_of_one().at(name);
        m.def(
            name, [f, name](const py::object& a) { return f(needed(a, name)); }, py::arg("a"),
            "Of an Expression, as numpy's of a number; rint rounds halves up.");
    }
    for (const char* name : {"arctan2", "power", "mod"}) {
        const TwoOperands f = functions_of_two().at(name);
        m.def(
            name,
            [f, name](const py::object& a, const py::object& b) {
                return f(needed(a, name), needed(b, name));
            },
            py::arg("a"), py::arg("b"), "Of Expressions, as numpy's of numbers.");
    }
    for (const char* name : {"minimum", "maximum", "hypot"}) {
        const TwoOperands f = functions_of_two().at(name);
        m.def(
            name, [f, name](const py::args& values) { return folded(values, f, name); },
            "Of one Expression or more. The minimum of two solids' formulas is their union, the\n"
            "maximum their intersection.");
    }
    m.def(
        "clip",
        [](const py::object& a, const py::object& low, const py::object& high) {
            return clamp(needed(a, "clip"), needed(low, "clip"), needed(high, "clip"));
        },
        py::arg("a"), py::arg("low"), py::arg("high"), "The nearest value of low .. high.");
    m.def(
        "mix",
        [](const py::object& a, const py::object& b, const py::object& t) {
            return mix(needed(a, "mix"), needed(b, "mix"), needed(t, "mix"));
        },
        py::arg("a"), py::arg("b"), py::arg("t"), "a + t (b - a).");
    m.def(
        "smooth_minimum",
        [](const py::object& a, const py::object& b, const py::object& width) {
            const char* name = "smooth_minimum";
            return smooth_min(needed(a, name), needed(b, name), needed(width, name));
        },
        py::arg("a"), py::arg("b"), py::arg("width"),
        "The smaller of two, blended where they differ by less than width: a union with a fillet.");
    m.def(
        "smooth_maximum",
        [](const py::object& a, const py::object& b, const py::object& width) {
            const char* name = "smooth_maximum";
            return smooth_max(needed(a, name), needed(b, name), needed(width, name));
        },
        py::arg("a"), py::arg("b"), py::arg("width"),
        "The larger of two, blended where they differ by less than width.");
    m.def(
        "repeat",
        [](const py::object& a, const py::object& period) {
            return repeat(needed(a, "repeat"), needed(period, "repeat"));
        },
        py::arg("a"), py::arg("period"),
        R"(a less the nearest multiple of the period: what is made of it repeats for ever.

>>> genus.repeat(genus.x, 2).value([[0.5, 0, 0], [2.5, 0, 0], [-1.5, 0, 0]]).tolist()
[0.5, 0.5, 0.5])");
}

}  // namespace

void bind_implicit(py::module_& m)
{
    bind_expression(m);
    bind_functions(m);
    m.def("implicit", &make_implicit, py::arg("f"), py::arg("bounds"),
          R"(All points of the box where a formula is not positive.

Parameters
----------
f : a text in x, y and z such as "x^2 + y^2 + sin(z) - 1" or "x^2 + y^2 <= 1", an Expression made
    from genus.x, genus.y and genus.z, or a function that makes one from these three
bounds : (2, 3), the box to which the solid is cut

A text may use + - * / % ^ and the functions sin cos tan asin acos atan atan2 sinh cosh tanh exp log
log2 log10 sqrt cbrt abs sign square floor ceil round pow mod min max hypot clamp mix smin smax
repeat; angles are radians. Its mesh has a proven error bound where bounds of the formula and its
gradient give one, else an estimate (mesh.error.certified).

Raises
------
InvalidInput : naming the column of what cannot be read

>>> ball = genus.implicit("x^2 + y^2 + z^2 - 1", [[-2, -2, -2], [2, 2, 2]])
>>> ball.contains([[0, 0, 0.9], [1, 1, 0]]).tolist()
[True, False]
>>> same = genus.implicit(genus.x**2 + genus.y**2 + genus.z**2 - 1, [[-2, -2, -2], [2, 2, 2]])
>>> same == ball
True)");
}

}  // namespace genus::python
