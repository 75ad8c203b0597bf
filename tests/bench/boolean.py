"""Mesh booleans of genus and its peers side by side: time, error, peak memory, growth with size.

    python tests/bench/boolean.py [--cases A,B] [--largest N] [--bunny FILE] [--memory]
                                  [--edits N] [--json FILE] [--plot FILE]

Times are CPU seconds of the process, all threads added, medians of three: from arrays to arrays,
and the operation alone. All libraries run in one process, one after the other. The error is that of
the volume: against the closed form where there is one, else how far V(a - b) + V(a & b) is from
V(a) for two operands, else the difference from what genus says. Peak memory is that of a process
of its own for each library. Peers that are not installed are left out.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import genus
import numpy as np
from genus.report.table import columns, number
from loglog import loglog

Arrays = tuple[np.ndarray, np.ndarray]
REPEATS = 3
SLOW = 20.0  # seconds after which a call is not repeated
GIVE_UP = 60.0  # a peer that took longer in a row of growing cases is left out of the next


class NoSuchCall(Exception):
    """A peer has no call for a case, or none that ends in reasonable time: no row."""


class Case(NamedTuple):
    """Operands 0 .. n_first - 1 united, less all others united."""

    name: str
    operands: list[Arrays]
    n_first: int
    volume: float | None = None  # where a closed form is known


# ---- the solids ------------------------------------------------------------------------------


def box(low: Any, high: Any) -> Arrays:
    """An axis-parallel box."""
    is_high = np.arange(8)[:, None] >> np.arange(3) & 1
    corners = np.where(is_high == 1, np.asarray(high, float), np.asarray(low, float))
    faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]]
    faces += [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    return corners, np.array(faces, np.int32)


def sphere(parts: int) -> Arrays:
    """A unit ball of 20 parts^2 triangles."""
    mesh = genus.icosphere(1.0, parts)
    return np.array(mesh.vertices), np.array(mesh.faces)


def lattice_sphere(rings: int) -> Arrays:
    """A unit ball of 2 rings (rings - 1) triangles by latitude and longitude."""
    latitude = math.pi * (np.arange(1, rings) / rings - 0.5)
    longitude = 2 * math.pi * np.arange(rings) / rings
    x = np.cos(latitude)[:, None] * np.cos(longitude)
    y = np.cos(latitude)[:, None] * np.sin(longitude)
    z = np.broadcast_to(np.sin(latitude)[:, None], x.shape)
    vertices = np.concatenate([[[0, 0, -1]], np.stack([x, y, z], -1).reshape(-1, 3), [[0, 0, 1]]])
    j = np.arange(rings)
    k = (j + 1) % rings
    top = len(vertices) - 1
    last = 1 + (rings - 2) * rings
    faces = [np.stack([0 * j, 1 + k, 1 + j], -1), np.stack([0 * j + top, last + j, last + k], -1)]
    for ring in range(rings - 2):
        a, b = 1 + ring * rings, 1 + (ring + 1) * rings
        faces += [np.stack([a + j, a + k, b + j], -1), np.stack([a + k, b + k, b + j], -1)]
    return vertices, np.concatenate(faces).astype(np.int32)


def turned(arrays: Arrays, axis: int, degrees: float) -> Arrays:
    """Turned about a coordinate axis."""
    t = math.radians(degrees)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    vertices = arrays[0].copy()
    vertices[:, u] = math.cos(t) * arrays[0][:, u] - math.sin(t) * arrays[0][:, v]
    vertices[:, v] = math.sin(t) * arrays[0][:, u] + math.cos(t) * arrays[0][:, v]
    return vertices, arrays[1]


def placed(arrays: Arrays, scale: float, at: Any) -> Arrays:
    """Scaled, then moved."""
    return arrays[0] * scale + np.asarray(at), arrays[1]


def menger(depth: int) -> Case:
    """A cube less the prisms of a Menger sponge: volume (20 / 27)^depth."""
    parts = [box([0, 0, 0], [1, 1, 1])]
    for level in range(depth):
        n = 3**level
        s = 1.0 / (3 * n)
        for i, j in np.ndindex(n, n):
            x, y, hole = i, j, False
            while x or y:
                hole = hole or (x % 3 == 1 and y % 3 == 1)
                x, y = x // 3, y // 3
            if hole:
                continue
            a, b = (3 * i + 1) * s, (3 * j + 1) * s
            parts.append(box([a, b, -0.1], [a + s, b + s, 1.1]))
            parts.append(box([a, -0.1, b], [a + s, 1.1, b + s]))
            parts.append(box([-0.1, a, b], [1.1, a + s, b + s]))
    return Case(f"Menger {depth}", parts, 1, (20 / 27) ** depth)


def random_spheres(n: int) -> list[Arrays]:
    """Balls of radius 0.05 to 0.1 in the unit cube."""
    random = np.random.default_rng(1)
    ball = lattice_sphere(16)
    return [placed(ball, 0.05 + 0.05 * random.random(), random.random(3)) for _ in range(n)]


def shifted_spheres(triangles: int) -> Case:
    """A ball less itself, shifted."""
    ball = sphere(max(1, round(math.sqrt(triangles / 20))))
    return Case(f"spheres {triangles}", [ball, placed(ball, 1.0, [0.1, 0.2, 0.3])], 1)


def closed_mesh(path: str) -> Arrays:
    """A mesh file with its holes filled."""
    mesh, _ = genus.load(path).repair(max_hole=500)
    return np.array(mesh.vertices), np.array(mesh.faces)


def cases(bunny: str | None) -> Iterator[tuple[str, Callable[[], Case]]]:
    """Names and makers: the arrays of a case are made when its turn comes."""
    for n in (20_000, 200_000, 2_000_000):
        yield f"spheres {n}", lambda n=n: shifted_spheres(n)
    if bunny:
        mesh = closed_mesh(bunny)
        yield "bunny", lambda: Case("bunny", [mesh, turned(mesh, 1, 5.0)], 1)
    for depth in (3, 4):
        yield f"Menger {depth}", lambda d=depth: menger(d)
    yield "1000 spheres", lambda: Case("1000 spheres", random_spheres(1000), 1000)
    yield (
        "carve",
        lambda: Case("carve", [box([0, 0, 0], [1, 1, 1]), *random_spheres(1000)], 1),
    )
    bar = box([-1, -0.05, -0.1], [1, 0.05, 0.1])
    bars = [turned(bar, 2, 180 * i / 200) for i in range(200)]
    yield "gears", lambda: Case("gears", bars + [turned(b, 2, 0.45) for b in bars], 200)


# ---- the libraries ---------------------------------------------------------------------------


class Genus:
    """This library."""

    def load(self, arrays: Arrays) -> Any:
        return genus.Mesh(*arrays)

    def solve(self, solids: list[Any], n_first: int) -> Any:
        n = len(solids)
        first = ("+", *range(n_first)) if n_first > 1 else 0
        return genus.boolean(("-", first, *range(n_first, n)), solids)

    def common(self, a: Any, b: Any) -> Any:
        return a & b

    def unload(self, solid: Any) -> Arrays:
        return np.asarray(solid.vertices), np.asarray(solid.faces)


class Manifold:
    """manifold3d, double precision."""

    def __init__(self) -> None:
        import manifold3d

        self.lib = manifold3d

    def load(self, arrays: Arrays) -> Any:
        vertices, faces = arrays
        mesh = self.lib.Mesh64(
            vert_properties=np.ascontiguousarray(vertices, np.float64),
            tri_verts=np.ascontiguousarray(faces, np.uint64),
        )
        return self.lib.Manifold(mesh)

    def solve(self, solids: list[Any], n_first: int) -> Any:
        batch, op = self.lib.Manifold.batch_boolean, self.lib.OpType
        first = batch(solids[:n_first], op.Add) if n_first > 1 else solids[0]
        result = batch([first, *solids[n_first:]], op.Subtract) if n_first < len(solids) else first
        result.num_tri()  # forces the work
        return result

    def common(self, a: Any, b: Any) -> Any:
        return a ^ b

    def unload(self, solid: Any) -> Arrays:
        mesh = solid.to_mesh64()
        return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)


class Trueform:
    """trueform: two operands at a time."""

    def __init__(self) -> None:
        import trueform

        self.lib = trueform

    def load(self, arrays: Arrays) -> Any:
        return self.lib.Mesh(
            np.ascontiguousarray(arrays[1], np.int32), np.ascontiguousarray(arrays[0], np.float64)
        )

    def solve(self, solids: list[Any], n_first: int) -> Any:
        if len(solids) != 2 or n_first != 1:
            raise NoSuchCall("two operands only")
        return self.lib.boolean_difference(*solids)[0]

    def common(self, a: Any, b: Any) -> Any:
        return self.lib.boolean_intersection(a, b)[0]

    def unload(self, solid: Any) -> Arrays:
        faces, vertices = solid
        return np.asarray(vertices), np.asarray(faces)


class Cgal:
    """CGAL's corefinement through its wheel."""

    def __init__(self) -> None:
        from CGAL import CGAL_Polygon_mesh_processing, CGAL_Polyhedron_3

        self.pmp, self.poly = CGAL_Polygon_mesh_processing, CGAL_Polyhedron_3

    def load(self, arrays: Arrays) -> Any:
        from CGAL.CGAL_Kernel import Point_3

        if len(arrays[1]) > 300_000:
            raise NoSuchCall("goes in point by point: too slow")

        points = self.pmp.Point_3_Vector()
        for x, y, z in arrays[0].tolist():
            points.append(Point_3(x, y, z))
        polygons = self.pmp.Polygon_Vector()
        for face in arrays[1].tolist():
            polygon = self.pmp.Int_Vector()
            for v in face:
                polygon.append(v)
            polygons.append(polygon)
        polyhedron = self.poly.Polyhedron_3()
        self.pmp.polygon_soup_to_polygon_mesh(points, polygons, polyhedron)
        return polyhedron

    def solve(self, solids: list[Any], n_first: int) -> Any:
        if len(solids) != 2 or n_first != 1:
            raise NoSuchCall("two operands only")
        result = self.poly.Polyhedron_3()
        self.pmp.corefine_and_compute_difference(*(s.deepcopy() for s in solids), result)
        return result

    def common(self, a: Any, b: Any) -> Any:
        result = self.poly.Polyhedron_3()
        self.pmp.corefine_and_compute_intersection(a.deepcopy(), b.deepcopy(), result)
        return result

    def unload(self, solid: Any) -> Arrays:
        number_of: dict[Any, int] = {}
        vertices = []
        for i, v in enumerate(solid.vertices()):
            number_of[v] = i
            vertices.append((v.point().x(), v.point().y(), v.point().z()))
        faces = []
        for facet in solid.facets():
            h = facet.halfedge()
            faces.append([number_of[g.vertex()] for g in (h, h.next(), h.next().next())])
        return np.array(vertices), np.array(faces, np.int32)


LIBRARIES = {"genus": Genus, "manifold3d": Manifold, "trueform": Trueform, "cgal": Cgal}


def installed() -> dict[str, Any]:
    """The libraries that can be loaded, genus first."""
    found = {}
    for name, library in LIBRARIES.items():
        try:
            found[name] = library()
        except ImportError:
            print(f"{name} is not installed: its rows are left out", file=sys.stderr)
    return found


# ---- measuring -------------------------------------------------------------------------------


def volume(arrays: Arrays) -> float:
    """Signed volume of a closed mesh."""
    vertices, faces = arrays
    if len(faces) == 0:
        return 0.0
    a, b, c = (vertices[faces[:, i].astype(np.int64)] - vertices.mean(axis=0) for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def measure(library: Any, case: Case) -> dict[str, Any]:
    """Times of one case in one library, and what it made."""
    whole, alone = [], []
    result: Arrays = (np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    for _ in range(REPEATS):
        start = time.process_time()
        solids = [library.load(arrays) for arrays in case.operands]
        loaded = time.process_time()
        solid = library.solve(solids, case.n_first)
        solved = time.process_time()
        result = library.unload(solid)
        whole.append(time.process_time() - start)
        alone.append(solved - loaded)
        if whole[-1] > SLOW:
            break
    row = {
        "seconds": statistics.median(whole),
        "operation": statistics.median(alone),
        "triangles": len(result[1]),
        "volume": volume(result),
    }
    if case.volume is not None:
        row["error"] = abs(row["volume"] - case.volume) / case.volume
    elif len(case.operands) == 2 and case.n_first == 1:
        a = volume(case.operands[0])
        common = volume(library.unload(library.common(*solids)))
        row["error"] = abs(row["volume"] + common - a) / abs(a)
    return row


def measure_all(libraries: dict[str, Any], case: Case) -> dict[str, Any]:
    """One case in all libraries."""
    rows: dict[str, Any] = {}
    for name, library in libraries.items():
        try:
            rows[name] = measure(library, case)
        except NoSuchCall:
            continue
        except Exception as error:  # a peer that fails is a result, not the end of the run
            if name == "genus":
                raise
            rows[name] = {"failed": str(error)}
            continue
        rows[name].setdefault(
            "error", abs(rows[name]["volume"] / rows["genus"]["volume"] - 1) if rows else 0.0
        )
    return rows


def peak_memory(libraries: dict[str, Any], triangles: int) -> dict[str, float]:
    """Megabytes that a process of its own needs for two shifted spheres, beyond its operands."""
    peaks = {}
    for name in libraries:
        run = [sys.executable, __file__, "--peak", f"{name}:{triangles}"]
        done = subprocess.run(run, check=False, capture_output=True, text=True)
        if done.returncode == 0:
            peaks[name] = float(done.stdout.split()[-1])
    return peaks


def print_peak(what: str) -> None:
    """In a process of its own: what the peak grew by once the operands were there as arrays."""
    name, triangles = what.split(":")
    case = shifted_spheres(int(triangles))
    library = LIBRARIES[name]()
    library.unload(library.solve([library.load(a) for a in shifted_spheres(100).operands], 1))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    library.unload(library.solve([library.load(a) for a in case.operands], case.n_first))
    print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024)


# ---- telling ---------------------------------------------------------------------------------


def table(results: dict[str, dict[str, Any]]) -> str:
    """All cases for people; ratios are those of arrays to arrays."""
    lines = []
    for case, rows in results.items():
        for name, row in rows.items():
            if "failed" in row:
                lines.append([case, name, "failed", "", "", "", ""])
                continue
            ratio = row["seconds"] / rows["genus"]["seconds"]
            cells = [f"{row['seconds']:.3f}", f"{row['operation']:.3f}", f"{ratio:.2f}"]
            lines.append([case, name, *cells, str(row["triangles"]), f"{row['error']:.1g}"])
    header = ["case", "library", "s", "op alone", "ratio", "triangles", "volume error"]
    return columns(header, lines)


def sweep(libraries: dict[str, Any], largest: int) -> dict[str, dict[int, float]]:
    """Seconds from arrays to arrays for two shifted spheres of 1000 triangles and more."""
    seconds: dict[str, dict[int, float]] = {name: {} for name in libraries}
    left = dict(libraries)
    triangles = 1000
    while triangles <= largest:
        case = shifted_spheres(triangles)
        for name, row in measure_all(left, case).items():
            if "failed" in row:
                continue
            seconds[name][len(case.operands[0][1])] = row["seconds"]
            if row["seconds"] > GIVE_UP and name != "genus":
                left.pop(name)
        triangles *= 4
    return seconds


def edits(library: Any, triangles: int) -> dict[str, float]:
    """Seconds of small cuts into a ball: the first, the median of the next ones into the same ball,
    and the median of those each into what the last one left. Operands are loaded beforehand."""
    ball = library.load(sphere(max(1, round(math.sqrt(triangles / 20)))))
    tools = [
        library.load(turned(box([0.2, 0.0, 0.8], [0.4, 0.2, 1.1]), 2, 40.0 * i)) for i in range(6)
    ]

    def cut(solid: Any, tool: Any) -> tuple[float, Any]:
        start = time.process_time()
        result = library.solve([solid, tool], 1)
        return time.process_time() - start, result

    same = [cut(ball, tool)[0] for tool in tools]
    chain, solid = [], ball
    for tool in tools:
        seconds, solid = cut(solid, tool)
        chain.append(seconds)
    return {
        "first": same[0],
        "same ball": statistics.median(same[1:]),
        "chain": statistics.median(chain[1:]),
    }


def plot(seconds: dict[str, dict[int, float]], path: str) -> None:
    """Cost against size."""
    styles = ("o-", "s--", "^:", "d-.")
    loglog(
        path,
        [
            (name, style, list(points), list(points.values()))
            for (name, points), style in zip(seconds.items(), styles, strict=False)
        ],
        title="sphere less shifted sphere",
        x="triangles of each operand",
        y="CPU seconds, arrays to arrays",
    )


def main() -> int:
    """Measure, print, save what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", help="names of cases, with commas between; all if not given")
    parser.add_argument("--bunny", metavar="FILE", help="a mesh for a case of its own")
    parser.add_argument("--largest", type=int, default=0, help="last size of the sweep; 0: none")
    parser.add_argument("--memory", type=int, default=0, metavar="N", help="peak for N triangles")
    parser.add_argument("--edits", type=int, default=0, metavar="N", help="cuts into N triangles")
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--plot", metavar="FILE", help="the sweep as a picture")
    parser.add_argument("--peak", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.peak:
        print_peak(args.peak)
        return 0
    libraries = installed()
    wanted = args.cases.split(",") if args.cases is not None else None
    results = {
        name: measure_all(libraries, make())
        for name, make in cases(args.bunny)
        if wanted is None or name in wanted
    }
    if results:
        print(table(results))
    seconds = sweep(libraries, args.largest)
    for name, points in seconds.items():
        if points:
            print(f"{name}: " + ", ".join(f"{n}: {number(s)} s" for n, s in points.items()))
    peaks = peak_memory(libraries, args.memory) if args.memory else {}
    for name, megabytes in peaks.items():
        print(f"{name}: {megabytes:.0f} MB beyond the operands")
    cuts = {name: edits(lib, args.edits) for name, lib in libraries.items()} if args.edits else {}
    for name, row in cuts.items():
        print(f"{name}, a cut: " + ", ".join(f"{what} {s:.3f} s" for what, s in row.items()))
    if args.json:
        report = {"cases": results, "sweep": seconds, "memory": peaks, "edits": cuts}
        Path(args.json).write_text(json.dumps(report, indent=2) + "\n")
    if args.plot:
        plot(seconds, args.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
