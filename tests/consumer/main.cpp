#include <cstdio>

#include "genus/io/write_mesh.h"
#include "genus/mesh/topology.h"
#include "genus/model/mesh_solid.h"
#include "genus/model/solid.h"

// Bores a ball, meshes it and writes it to the file named on the command line. Fails unless the
// mesh is closed, has one handle and is as near the solid as was asked.
int main(int argc, char** argv)
{
    if (argc != 2) return 2;
    const genus::Solid solid =
        genus::subtract({genus::sphere(10.0), genus::cylinder(30.0, 3.0, 3.0, true)});
    genus::MeshOptions options;
    options.tolerance = 0.1;
    const genus::MeshedSolid result = genus::mesh_solid(solid, options);
    const genus::Topology topology = genus::topology(result.mesh);
    genus::write_mesh(argv[1], result.mesh);
    std::printf("%zu triangles, genus %lld, bound %g\n", result.mesh.n_faces(),
                static_cast<long long>(topology.genus.value_or(-1)), result.error.bound);
    const bool good = topology.closed && topology.genus == 1 && result.error.bound <= 0.1;
    return good ? 0 : 1;
}
