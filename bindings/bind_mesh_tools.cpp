#include <algorithm>
#include <string>

#include <pybind11/stl.h>

#include "forms.h"
#include "genus/base/error.h"
#include "genus/base/parallel.h"
#include "genus/base/progress.h"
#include "genus/mesh/aabb_tree.h"
#include "genus/mesh/repair.h"
#include "genus/mesh/simplify.h"
#include "long_call.h"

namespace genus::python {

namespace {

// ---- to other meshes --------------------------------------------------------------------------

Mesh simplify_mesh(const Mesh& mesh, const std::optional<double>& tolerance,
                   const std::optional<std::int64_t>& faces, bool certify,
                   const py::object& progress)
{
    SimplifyOptions options;
    if (tolerance) options.tolerance = *tolerance;
    options.max_faces = faces;
    options.certify = certify;
    const double start = seconds_now();
    SimplifiedMesh simplified = long_call(
        [&, triangles = mesh.triangles] { return simplify(*triangles, options); }, progress);
    MeshedSolid made;
    made.mesh = std::move(simplified.mesh);
    made.tolerance = tolerance.value_or(0.0);
    made.method = "simplify";
    made.error.bound = simplified.bound;
    made.error.certified = simplified.certified;
    made.error.measured = simplified.measured;
    made.error.parts = {{"simplification", simplified.bound}};
    const double seconds = seconds_now() - start;
    made.seconds = {{"simplify", seconds}};
    Mesh out(std::move(made));
    out.seconds = seconds;
    out.was_measured = true;
    return out;
}

NonManifold to_non_manifold(const std::string& name)
{
    if (name == "keep") return NonManifold::Keep;
    if (name == "split") return NonManifold::Split;
    if (name == "drop") return NonManifold::Drop;
    throw InvalidInput("repair: non_manifold is \"" + name +
                       "\", must be one of keep, split, drop");
}

py::tuple repair_mesh(const Mesh& mesh, double weld, bool t_junctions, bool orient,
                      const std::string& non_manifold, std::int64_t max_hole,
                      const py::object& progress)
{
    RepairOptions options;
    options.weld = weld;
    options.t_junctions = t_junctions;
    options.orient = orient;
    options.non_manifold = to_non_manifold(non_manifold);
    options.max_hole = max_hole;
    RepairedMesh repaired = long_call(
        [&, triangles = mesh.triangles] { return repair(*triangles, options); }, progress);
    const RepairReport& r = repaired.report;
    py::dict done;
    done["welded_vertices"] = r.welded_vertices;
    done["degenerate_faces"] = r.degenerate_faces;
    done["duplicate_faces"] = r.duplicate_faces;
    done["t_junctions"] = r.t_junctions;
    done["turned_faces"] = r.turned_faces;
    done["split_vertices"] = r.split_vertices;
    done["dropped_faces"] = r.dropped_faces;
    done["closed_holes"] = r.closed_holes;
    done["added_faces"] = r.added_faces;
    done["open_edges"] = r.open_edges;
    return py::make_tuple(Mesh(std::move(repaired.mesh)), done);
}

// ---- where points and rays are ----------------------------------------------------------------

py::tuple nearest_points(const Mesh& mesh, const ArrayLike& points, const py::object& progress)
{
    const PointArray array = to_point_array(points, "points");
    const std::span<const Vec3> at = rows(array);
    std::vector<Vec3> closest(at.size());
    std::vector<std::int32_t> faces(at.size());
    std::vector<double> distances(at.size());
    long_call(
        [&, triangles = mesh.triangles] {
            const MeshTree tree(*triangles);
            parallel_for(at.size(), 256, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const ClosestPoint c = tree.nearest(at[i]);
                    closest[i] = c.point;
                    faces[i] = c.face;
                    distances[i] = c.distance;
                }
            });
        },
        progress);
    return py::make_tuple(to_array(std::move(closest)), to_array(std::move(distances)),
                          to_array(std::move(faces)));
}

py::array contains(const Mesh& mesh, const ArrayLike& points, const py::object& progress)
{
    const PointArray array = to_point_array(points, "points");
    const std::span<const Vec3> at = rows(array);
    if (!topology_of(mesh).closed || !topology_of(mesh).oriented)
        throw InvalidInput("contains: the mesh is not closed and oriented");
    py::array_t<bool> inside(static_cast<py::ssize_t>(at.size()));
    bool* out = inside.mutable_data();
    long_call(
        [&, triangles = mesh.triangles] {
            const MeshTree tree(*triangles);
            parallel_for(at.size(), 256, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    out[i] = tree.winding_number(at[i]).value_or(1) != 0;  // the border counts
            });
        },
        progress);
    return inside;
}

py::tuple cast_rays(const Mesh& mesh, const ArrayLike& origins, const ArrayLike& directions,
                    const py::object& progress)
{
    const PointArray from = to_point_array(origins, "origins");
    const PointArray along = to_point_array(directions, "directions");
    if (from.shape(0) != along.shape(0))
        throw py::value_error("origins and directions must be as many, got " +
                              std::to_string(from.shape(0)) + " and " +
                              std::to_string(along.shape(0)));
    const auto n = static_cast<std::size_t>(from.shape(0));
    std::vector<std::vector<RayHit>> hits(n);
    long_call(
        [&, triangles = mesh.triangles] {
            const MeshTree tree(*triangles);
            parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    hits[i] = tree.ray_hits(rows(from)[i], rows(along)[i]);
            });
        },
        progress);
    std::vector<std::int64_t> ray;
    std::vector<double> t;
    std::vector<std::int32_t> face;
    for (std::size_t i = 0; i < n; ++i)
        for (const RayHit& hit : hits[i]) {
            ray.push_back(static_cast<std::int64_t>(i));
            t.push_back(hit.t);
            face.push_back(hit.face);
        }
    return py::make_tuple(to_array(std::move(ray)), to_array(std::move(t)),
                          to_array(std::move(face)));
}

}  // namespace

void bind_mesh_tools(py::class_<Mesh>& mesh)
{
    mesh.def("simplify", &simplify_mesh, py::arg("tolerance") = py::none(), py::kw_only(),
             py::arg("faces") = py::none(), py::arg("certify") = true,
             py::arg("progress") = py::none(),
             R"(Fewer triangles for nearly the same surface, by quadric error metrics.

tolerance : largest distance between the surfaces, both ways, model units
faces : stop at so many; one of the two must be given
certify : prove the bound; else points are sampled, and the tolerance is met as far as they tell

The topology stays. error tells bound and measured distance of the result.

>>> ball = genus.icosphere(r=10, parts=20)
>>> rough = ball.simplify(0.5)
>>> len(rough) < len(ball) / 20, rough.error.certified, rough.error.bound <= 0.5
(True, True, True))")
        .def(
            "weld",
            [](const Mesh& x, double tolerance) {
                return Mesh(long_call([&, t = x.triangles] { return weld(*t, tolerance); }));
            },
            py::arg("tolerance") = 0.0,
            "Join vertices within the tolerance of each other; vertices without a face go.")
        .def("repair", &repair_mesh, py::kw_only(), py::arg("weld") = 0.0,
             py::arg("t_junctions") = true, py::arg("orient") = true,
             py::arg("non_manifold") = "split", py::arg("max_hole") = 64,
             py::arg("progress") = py::none(),
             R"(Mend what can be mended without moving vertices farther than the welding tolerance:
(mesh, what was done), the latter a dict of counts.

weld : join vertices within this distance, model units
t_junctions : cut faces where a vertex lies within an open edge
orient : make neighbours agree; closed parts turn outward, cavities inward
non_manifold : "split" the mesh apart at edges of more than two faces and vertices of more than
    one fan, "drop" the faces too many, or "keep" them
max_hole : longest hole to close, in edges; at most 500

>>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> mesh, done = genus.Mesh(corners, [[0, 2, 1], [0, 1, 3], [1, 3, 2]]).repair()
>>> mesh.is_closed, done["closed_holes"], done["turned_faces"]
(True, 1, 1))")
        .def(
            "nearest", &nearest_points, py::arg("points"), py::kw_only(),
            py::arg("progress") = py::none(),
            "(points, distances, faces): for each of the (n, 3) points the nearest of the surface.")
        .def("contains", &contains, py::arg("points"), py::kw_only(),
             py::arg("progress") = py::none(),
             R"((n,) bool: whether points are inside a closed mesh or on it, by winding numbers.

>>> genus.icosphere(parts=4).contains([[0, 0, 0], [2, 0, 0]]).tolist()
[True, False])")
        .def("ray_cast", &cast_rays, py::arg("origins"), py::arg("directions"), py::kw_only(),
             py::arg("progress") = py::none(),
             "(ray, t, face): all hits of the rays origin + t direction, t >= 0, by ray, then t.");
}

}  // namespace genus::python
