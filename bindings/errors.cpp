#include <pybind11/pybind11.h>

#include "bind.h"
#include "genus/base/error.h"

namespace genus::python {

namespace {

// Owned by the module for the life of the interpreter.
struct ErrorTypes {
    PyObject* error;
    PyObject* invalid_input;
    PyObject* file_error;
    PyObject* model_error;
    PyObject* unbounded_solid;
    PyObject* tolerance_not_met;
};
ErrorTypes types;

PyObject* new_type(py::module_& m, const char* name, const char* doc, const py::tuple& bases)
{
    const std::string qualified = std::string("genus.") + name;
    PyObject* type = PyErr_NewExceptionWithDoc(qualified.c_str(), doc, bases.ptr(), nullptr);
    if (type == nullptr) throw py::error_already_set();
    m.attr(name) = py::handle(type);
    return type;
}

// Names of files need not be UTF-8: as Python does it, other bytes become lone surrogates.
py::object text(const std::string& bytes)
{
    const auto size = static_cast<py::ssize_t>(bytes.size());
    PyObject* string = PyUnicode_DecodeFSDefaultAndSize(bytes.data(), size);
    if (string == nullptr) throw py::error_already_set();
    return py::reinterpret_steal<py::object>(string);
}

py::object instance(PyObject* type, const std::exception& error)
{
    return py::handle(type)(text(error.what()));
}

void raise(PyObject* type, const py::object& error)
{
    PyErr_SetObject(type, error.ptr());
}

template <class T>
py::object or_none(const std::optional<T>& value)
{
    return value ? py::cast(*value) : py::none();
}

void raise(const FileError& error)
{
    const py::object e = instance(types.file_error, error);
    e.attr("path") = text(error.path());
    e.attr("line") = or_none(error.place().line);
    e.attr("byte") = or_none(error.place().byte);
    e.attr("problem") = text(error.problem());
    raise(types.file_error, e);
}

void raise(const ModelError& error)
{
    const py::object e = instance(types.model_error, error);
    e.attr("file") = text(error.file());
    e.attr("line") = error.line();
    e.attr("column") = error.column();
    e.attr("problem") = text(error.problem());
    raise(types.model_error, e);
}

py::tuple to_tuple(const Vec3& v)
{
    return py::make_tuple(v[0], v[1], v[2]);
}

void raise(const ToleranceNotMet& error)
{
    const py::object e = instance(types.tolerance_not_met, error);
    e.attr("asked") = error.asked();
    e.attr("reached") = error.reached();
    py::list where;
    for (const Box3& box : error.where())
        where.append(py::make_tuple(to_tuple(box.min), to_tuple(box.max)));
    e.attr("where") = py::tuple(where);
    raise(types.tolerance_not_met, e);
}

void translate(std::exception_ptr pointer)
{
    try {
        if (pointer) std::rethrow_exception(pointer);
    } catch (const InvalidInput& e) {
        raise(types.invalid_input, instance(types.invalid_input, e));
    } catch (const FileError& e) {
        raise(e);
    } catch (const ModelError& e) {
        raise(e);
    } catch (const UnboundedSolid& e) {
        raise(types.unbounded_solid, instance(types.unbounded_solid, e));
    } catch (const ToleranceNotMet& e) {
        raise(e);
    } catch (const Cancelled&) {
        PyErr_SetNone(PyExc_KeyboardInterrupt);
    } catch (const Error& e) {
        raise(types.error, instance(types.error, e));
    }
}

}  // namespace

void bind_errors(py::module_& m)
{
    const auto one = [](PyObject* a) { return py::make_tuple(py::handle(a)); };
    const auto two = [](PyObject* a, PyObject* b) {
        return py::make_tuple(py::handle(a), py::handle(b));
    };
    types.error = new_type(m, "Error", "Root of all errors of genus.", one(PyExc_Exception));
    types.invalid_input =
        new_type(m, "InvalidInput", "An argument outside what the function promises to take.",
                 two(types.error, PyExc_ValueError));
    types.file_error = new_type(
        m, "FileError",
        "A file that cannot be read or written: path, problem, and line (from 1) or byte (from 0)\n"
        "where known, else None.",
        two(types.error, PyExc_OSError));
    types.model_error = new_type(
        m, "ModelError", "A mistake in a text model: file, line and column (from 1), problem.",
        one(types.error));
    types.unbounded_solid =
        new_type(m, "UnboundedSolid",
                 "The solid reaches to infinity; the text names the leaf that makes it so.",
                 one(types.error));
    types.tolerance_not_met = new_type(
        m, "ToleranceNotMet",
        "The tolerance asked for was not reached: asked, reached, and where, a tuple of boxes\n"
        "((x, y, z), (x, y, z)) in model units.",
        one(types.error));
    py::register_exception_translator(translate);
}

}  // namespace genus::python
