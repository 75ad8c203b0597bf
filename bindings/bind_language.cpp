#include <cmath>
#include <string>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bind.h"
#include "genus/base/error.h"
#include "genus/language/model.h"
#include "long_call.h"
#include "paths.h"

namespace genus::python {

namespace {

using Defines = std::vector<std::pair<std::string, std::string>>;

std::string quoted(const std::string& text)
{
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n')
            out += "\\n";
        else
            out += c;
    }
    return out + '"';
}

// A value of Python as an expression of the text language.
std::string to_expression(const py::handle& value)
{
    if (value.is_none()) return "undef";
    if (PyBool_Check(value.ptr())) return value.cast<bool>() ? "true" : "false";
    if (py::isinstance<py::str>(value)) return quoted(value.cast<std::string>());
    if (PySequence_Check(value.ptr())) {
        std::string list = "[";
        for (const py::handle item : value) list += to_expression(item) + ",";
        return list + "]";
    }
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred()) throw py::error_already_set();
    if (std::isnan(number)) return "(0/0)";
    if (std::isinf(number)) return number > 0 ? "(1/0)" : "(-1/0)";
    return to_text(number);
}

Defines to_defines(const py::dict& values, const py::dict& expressions)
{
    Defines defines;
    for (const auto& [name, value] : values)
        defines.emplace_back(name.cast<std::string>(), to_expression(value));
    for (const auto& [name, text] : expressions)
        defines.emplace_back(name.cast<std::string>(), text.cast<std::string>());
    return defines;
}

// A str with a semicolon, a brace or a line's end is a text; all else is a path.
bool is_text(const py::object& source)
{
    if (!py::isinstance<py::str>(source)) return false;
    return source.cast<std::string>().find_first_of(";{}\n") != std::string::npos;
}

TextModel run_model(const py::object& source, const ModelOptions& options,
                    const py::object& progress)
{
    if (is_text(source))
        return long_call([text = source.cast<std::string>(),
                          &options] { return read_model_text(text, "<text>", options); },
                         progress);
    const auto path = source.cast<Path>();
    return long_call([&] { return read_model(path.text, options); }, progress);
}

void append_texts(const py::object& list, const std::vector<Message>& messages)
{
    if (list.is_none()) return;
    for (const Message& message : messages) list.attr("append")(message.text);
}

TextModel run_scad(const py::object& source, const py::dict& defines, const py::dict& expressions,
                   std::optional<double> tolerance, bool solid, bool plane,
                   const py::object& messages, const py::object& progress)
{
    std::vector<Message> said;
    ModelOptions options;
    options.defines = to_defines(defines, expressions);
    options.tolerance = tolerance;
    options.solid = solid;
    options.plane = plane;
    options.messages = &said;
    try {
        TextModel model = run_model(source, options, progress);
        append_texts(messages, said);
        return model;
    } catch (...) {
        append_texts(messages, said);
        throw;
    }
}

Solid read_scad(const py::object& source, const py::dict& defines, std::optional<double> tolerance,
                const py::object& progress)
{
    return run_scad(source, defines, {}, tolerance, true, false, py::none(), progress).solid;
}

std::vector<std::string> texts(const TextModel& model)
{
    std::vector<std::string> lines;
    for (const Message& message : model.messages) lines.push_back(message.text);
    return lines;
}

}  // namespace

void bind_language(py::module_& m)
{
    py::class_<TextModel>(m, "TextModel", "What running a text model gave.")
        .def_readonly("solid", &TextModel::solid, "The solid it describes.")
        .def_readonly("region", &TextModel::region,
                      "The Region of a plane model, where the call allows that, else None.")
        .def_property_readonly("messages", &texts, "Its echoes and warnings, in order.")
        .def_property_readonly(
            "echo", [](const TextModel& t) { return echo_text(t.messages); },
            "The same as one text, a line each.")
        .def_property_readonly(
            "csg", [](const TextModel& t) { return to_csg(t.tree); },
            "The tree it came to as a flat text model.")
        .def_readonly("tolerance", &TextModel::tolerance,
                      "$tolerance as the call or the model set it, else None.")
        .def("__repr__", [](const TextModel& t) {
            return "<genus.TextModel: " + std::to_string(t.messages.size()) + " messages>";
        });

    m.def("run_scad", &run_scad, py::arg("path_or_text"), py::kw_only(),
          py::arg("defines") = py::dict(), py::arg("expressions") = py::dict(),
          py::arg("tolerance") = py::none(), py::arg("solid") = true, py::arg("plane") = false,
          py::arg("messages") = py::none(), py::arg("progress") = py::none(),
          R"(Run a text model in the OpenSCAD language and return all that it gave, a TextModel.

Parameters
----------
path_or_text : a path, or a text if it is a str with a semicolon, a brace or a line's end
defines : values that replace variables of the model
expressions : the same, each value the text of an expression
tolerance : $tolerance of the model; None for its own or, where it sets none, the polyhedra that
    $fn, $fa and $fs ask for
solid : whether to make the solid
plane : whether the model may be a plane shape, which the region of the TextModel then is
messages : a list that gets the echoes and warnings, also where the call fails

Raises
------
ModelError with file, line and column of the mistake; FileError for the model itself

>>> model = genus.run_scad("echo(x = 6 * n); cube(n);", defines={"n": 7})
>>> model.messages, model.tolerance
(['ECHO: x = 42'], None))");
    m.def("read_scad", &read_scad, py::arg("path_or_text"), py::arg("defines") = py::dict(),
          py::kw_only(), py::arg("tolerance") = 0.01, py::arg("progress") = py::none(),
          R"(Read a text model and return the solid it describes.

Parameters
----------
path_or_text : a path, or a text if it is a str with a semicolon, a brace or a line's end
defines : values that replace variables of the model
tolerance : $tolerance of the model, which makes round shapes without $fn exact, whatever its value;
    None for the polyhedra that $fn, $fa and $fs ask for

Raises
------
ModelError with file, line and column of the mistake; FileError for the model itself

>>> genus.read_scad("models/die.scad", defines={"side": 20}).bounds().tolist()
[[-10.0, -10.0, -10.0], [10.0, 10.0, 10.0]])");
}

}  // namespace genus::python
