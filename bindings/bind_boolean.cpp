#include <span>
#include <vector>

#include "bind.h"
#include "genus/boolean/mesh_boolean.h"
#include "long_call.h"

namespace genus::python {

namespace {

using Operation = IndexedMesh (*)(std::span<const IndexedMesh>);

template <Operation operation>
Mesh combine(const Mesh& a, const Mesh& b)
{
    return Mesh(long_call([&] {
        const std::vector<IndexedMesh> operands{*a.triangles, *b.triangles};
        return operation(operands);
    }));
}

}  // namespace

void bind_boolean(py::class_<Mesh>& mesh)
{
    mesh.def("__add__", &combine<unite>, py::is_operator())
        .def("__or__", &combine<unite>, py::is_operator())
        .def("__sub__", &combine<subtract>, py::is_operator())
        .def("__and__", &combine<intersect>, py::is_operator());
}

}  // namespace genus::python
