#include "bind.h"
#include "genus/base/parallel.h"

namespace genus::python {

void bind_base(py::module_& m)
{
    m.def("thread_count", &thread_count,
          "Threads that long calls use: what set_thread_count said, else GENUS_THREADS, else the\n"
          "processors of the machine.");
    m.def("set_thread_count", &set_thread_count, py::arg("threads"),
          "At least 1. Results never depend on it.");
}

}  // namespace genus::python
