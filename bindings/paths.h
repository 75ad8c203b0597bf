#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace genus::python {

/// A path as the system has it: from str, bytes or anything with __fspath__.
struct Path {
    std::string text;
};

}  // namespace genus::python

namespace pybind11::detail {

template <>
struct type_caster<genus::python::Path> {
    PYBIND11_TYPE_CASTER(genus::python::Path, const_name("str | os.PathLike[str]"));

    bool load(handle source, bool)
    {
        PyObject* bytes = nullptr;
        if (PyUnicode_FSConverter(source.ptr(), &bytes) == 0) {
            // A path with a null byte is a ValueError of its own; any other type is no path.
            if (PyErr_ExceptionMatches(PyExc_ValueError)) throw error_already_set();
            PyErr_Clear();
            return false;
        }
        value.text = reinterpret_steal<pybind11::bytes>(bytes);
        return true;
    }
};

}  // namespace pybind11::detail
