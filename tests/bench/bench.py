"""Genus and its peers side by side: start-up, error against run time, a region of a large scene.

    python tests/bench/bench.py [--finest T] [--peers NAME ...] [--json FILE] [--plot FILE]

Times are wall seconds round one call, best of three; all run on this machine, one after the other.
Errors of all are measured by the same function, on points of the faces against the exact surfaces.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import genus
import numpy as np
from genus.report.table import columns, number
from loglog import loglog

BALL, BORE, LENGTH = 50.0, 15.0, 120.0


def genus_part() -> genus.Solid:
    """A ball less two crossing bores."""
    bore = genus.cylinder(h=LENGTH, r=BORE, center=True)
    return genus.sphere(BALL) - bore - bore.rotate([90, 0, 0])


Arrays = tuple[np.ndarray, np.ndarray]  # vertices, faces


class Genus:
    """Asked for the tolerance; what it answers is proven."""

    label, style, finest = "genus, certified", "o-", 0.0

    def mesh(self, tolerance: float) -> Arrays:
        mesh = genus_part().mesh(tolerance, measure=False)
        return mesh.vertices, mesh.faces


def segments(r: float, sagitta: float) -> int:
    """Sides of a circle, a multiple of four."""
    return max(8, 4 * math.ceil(math.pi / math.acos(1 - min(sagitta, r / 2) / r) / 4))


class Manifold:
    """With so many facets that their sagitta is the tolerance."""

    label, style, finest = "manifold3d, facets by sagitta", "s--", 0.0

    def __init__(self) -> None:
        import manifold3d

        self.solid = manifold3d.Manifold

    def mesh(self, tolerance: float) -> Arrays:
        n = segments(BORE, tolerance)
        bore = self.solid.cylinder(LENGTH, BORE, BORE, n, True)
        ball = self.solid.sphere(BALL, segments(BALL, tolerance))
        mesh = (ball - bore - bore.rotate([90, 0, 0])).to_mesh64()
        return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)


class Trueform:
    """The same facets, cut by trueform."""

    label, style, finest = "trueform, facets by sagitta", "d--", 0.0

    def __init__(self) -> None:
        import trueform

        self.lib = trueform

    def mesh(self, tolerance: float) -> Arrays:
        n, m = segments(BALL, tolerance), segments(BORE, tolerance)
        ball = self.lib.Mesh(*self.lib.make_sphere_mesh(BALL, n // 2, n, dtype=np.float64))
        faces, vertices = self.lib.make_cylinder_mesh(BORE, LENGTH, m, dtype=np.float64)
        turned = np.ascontiguousarray(vertices[:, [0, 2, 1]] * [1, -1, 1])
        for cutter in (self.lib.Mesh(faces, vertices), self.lib.Mesh(faces, turned)):
            ball = self.lib.Mesh(*self.lib.boolean_difference(ball, cutter)[0])
        return np.asarray(ball.points, float), np.asarray(ball.faces)


class OpenCascade:
    """Exact surfaces; its deflection is no bound."""

    label, style, finest = "OpenCascade, by deflection", "^--", 1 / 64  # minutes beyond

    def __init__(self) -> None:
        from OCP import BRep, BRepAlgoAPI, BRepMesh, BRepPrimAPI, TopAbs, TopExp, TopLoc, TopoDS, gp

        self.gp, self.make, self.cut = gp, BRepPrimAPI, BRepAlgoAPI.BRepAlgoAPI_Cut
        self.tessellate, self.face_kind = BRepMesh.BRepMesh_IncrementalMesh, TopAbs.TopAbs_FACE
        self.explorer, self.location = TopExp.TopExp_Explorer, TopLoc.TopLoc_Location
        self.face, self.tool = TopoDS.TopoDS.Face, BRep.BRep_Tool

    def mesh(self, tolerance: float) -> Arrays:
        gp, half = self.gp, LENGTH / 2
        solid = self.make.BRepPrimAPI_MakeSphere(BALL).Shape()
        for x, y, z in ((0, 0, 1), (0, 1, 0)):
            axis = gp.gp_Ax2(gp.gp_Pnt(-x * half, -y * half, -z * half), gp.gp_Dir(x, y, z))
            bore = self.make.BRepPrimAPI_MakeCylinder(axis, BORE, LENGTH).Shape()
            solid = self.cut(solid, bore).Shape()
        self.tessellate(solid, tolerance, False, 0.5, False)
        parts, faces, explorer, count = [], [], self.explorer(solid, self.face_kind), 0
        while explorer.More():
            found = self.tool.Triangulation_s(self.face(explorer.Current()), self.location())
            points = [found.Node(i + 1).Coord() for i in range(found.NbNodes())]
            corners = [found.Triangle(i + 1).Get() for i in range(found.NbTriangles())]
            parts.append(np.array(points))
            faces.append(np.array(corners) - 1 + count)
            count += len(points)
            explorer.Next()
        return np.concatenate(parts), np.concatenate(faces)


class Fidget:
    """Dual contouring in 32-bit floats, by depth; built from its crate where there is a cargo."""

    label, style, finest = "fidget, by depth", "v--", 1 / 64

    def __init__(self) -> None:
        source = Path(__file__).parent / "fidget"
        self.folder = tempfile.TemporaryDirectory()
        if not shutil.which("cargo"):
            raise ImportError("there is no cargo")
        build = ["cargo", "build", "--release", "--quiet", "--target-dir", self.folder.name]
        done = subprocess.run([*build, "--manifest-path", source / "Cargo.toml"], check=False)
        if done.returncode:
            raise ImportError("its crate does not build")
        self.program = f"{self.folder.name}/release/fidget-peer"

    def timed(self, tolerance: float) -> tuple[float, Arrays]:
        """Its own best of three and the mesh; each halving of the tolerance is one level."""
        path = Path(self.folder.name) / "mesh.bin"
        depth = round(math.log2(4 / tolerance)) // 2 + 3
        command = [self.program, str(depth), path]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        data = path.read_bytes()
        n_vertices, n_faces = np.frombuffer(data[:16], np.uint64).astype(int)
        vertices = np.frombuffer(data, np.float32, 3 * n_vertices, 16).reshape(-1, 3)
        faces = np.frombuffer(data, np.uint32, 3 * n_faces, 16 + 12 * n_vertices).reshape(-1, 3)
        return float(done.stdout), (vertices.astype(float), faces)


PEERS = {
    "genus": Genus,
    "manifold3d": Manifold,
    "trueform": Trueform,
    "opencascade": OpenCascade,
    "fidget": Fidget,
}


def installed(names: list[str]) -> dict[str, Any]:
    """The libraries that can be loaded."""
    found = {}
    for name in names:
        try:
            found[name] = PEERS[name]()
        except ImportError as problem:
            print(f"{name} is left out: {problem}", file=sys.stderr)
    return found


def true_error(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Largest distance of points on the faces from the nearest of the exact surfaces."""
    weights = np.array([(i, j, 6 - i - j) for i in range(7) for j in range(7 - i)]) / 6
    worst = 0.0
    for start in range(0, len(faces), 100_000):
        corners = vertices[faces[start : start + 100_000].astype(np.int64)]
        p = np.einsum("wc,fcx->fwx", weights, corners).reshape(-1, 3)
        from_ball = np.abs(np.linalg.norm(p, axis=1) - BALL)
        from_z = np.abs(np.hypot(p[:, 0], p[:, 1]) - BORE)
        from_y = np.abs(np.hypot(p[:, 0], p[:, 2]) - BORE)
        worst = max(worst, np.minimum(np.minimum(from_ball, from_z), from_y).max())
    return float(worst)


def best_of(call: Callable[[], Any], repeats: int = 3) -> tuple[float, Any]:
    """Shortest time and the last result."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - start)
    return min(times), result


def sweep(peers: dict[str, Any], finest: float) -> list[dict[str, Any]]:
    """One row a tolerance, with seconds, triangles and true error of each peer."""
    rows, tolerance = [], 1.0
    while tolerance >= finest * 0.999:
        row: dict[str, Any] = {"tolerance": tolerance}
        for name, peer in peers.items():
            if tolerance < 0.999 * peer.finest:
                continue
            if hasattr(peer, "timed"):
                seconds, arrays = peer.timed(tolerance)
            else:
                seconds, arrays = best_of(partial(peer.mesh, tolerance))
            error = true_error(*arrays)
            row[name] = {"seconds": seconds, "triangles": len(arrays[1]), "error": error}
        rows.append(row)
        tolerance /= 2
    return rows


def start_up() -> dict[str, float]:
    """Median wall seconds of fresh processes."""

    def seconds(*arguments: str) -> float:
        times = []
        for _ in range(9):
            start = time.perf_counter()
            subprocess.run([sys.executable, *arguments], check=True, capture_output=True)
            times.append(time.perf_counter() - start)
        return statistics.median(times)

    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "cube.scad"
        model.write_text("cube(1);")
        bare = seconds("-c", "pass")
        return {
            "python alone": bare,
            "import genus, beyond it": seconds("-c", "import genus") - bare,
            "import numpy, beyond it": seconds("-c", "import numpy") - bare,
            "genus --version": seconds("-m", "genus", "--version"),
            "genus build of one cube": seconds(
                "-m", "genus", "build", str(model), "-o", f"{folder}/cube.stl"
            ),
        }


def region_of_scene(n: int = 100, side: int = 10) -> dict[str, float]:
    """Processor seconds for n by n bored balls, no two alike, and for a box with side by side."""

    def part(i: int, j: int) -> genus.Solid:
        r = 0.3 + 0.1 * math.sin(1.0 + i + 0.37 * j)
        bored = genus.sphere(r) - genus.cylinder(h=2, r=0.4 * r, center=True)
        return bored.translate([i + 0.5, j + 0.5, 0])

    scene = genus.union(*(part(i, j) for i in range(n) for j in range(n)))
    low = (n - side) // 2
    box = [[low, low, -1], [low + side, low + side, 1]]

    def seconds(**options: Any) -> float:
        start = time.process_time()
        scene.mesh(0.02, measure=False, **options)
        return time.process_time() - start

    whole, region = seconds(), seconds(region=box)
    return {
        f"{n * n} parts": whole,
        f"the {side * side} in a box": region,
        "share": region / whole,
    }


def table(rows: list[dict[str, Any]]) -> str:
    """The sweep for people."""
    peers = [name for name in PEERS if name in rows[0]]
    header = ["tolerance"] + [f"{p} {c}" for p in peers for c in ("s", "triangles", "error")]
    lines = []
    for row in rows:
        cells = [number(row["tolerance"])]
        for peer in peers:
            if r := row.get(peer):
                cells += [f"{r['seconds']:.4f}", str(r["triangles"]), f"{r['error']:.2g}"]
            else:
                cells += ["", "", ""]
        lines.append(cells)
    return columns(header, lines)


def plot(rows: list[dict[str, Any]], path: str) -> None:
    """Error against run time."""
    curves = []
    for name, peer in PEERS.items():
        points = [row[name] for row in rows if name in row]
        if points:
            x, y = [p["seconds"] for p in points], [p["error"] for p in points]
            curves.append((peer.label, peer.style, x, y))
    loglog(
        path,
        curves,
        title="ball of radius 50 less two crossing bores",
        x="seconds",
        y="true error, model units",
    )


def main() -> int:
    """Measure, print, save what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--finest", type=float, default=1 / 128, help="last tolerance of the sweep")
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--plot", metavar="FILE")
    parser.add_argument(
        "--peers", nargs="*", choices=list(PEERS), default=list(PEERS), metavar="NAME"
    )
    args = parser.parse_args()
    times, rows = start_up(), sweep(installed(args.peers), args.finest)
    print("start-up, seconds")
    print(columns(["what", "s"], [[name, f"{s:.3f}"] for name, s in times.items()]))
    print("error against run time")
    print(table(rows))
    region = region_of_scene()
    print("region of a scene, processor seconds")
    print(columns(["what", "s"], [[name, f"{s:.3f}"] for name, s in region.items()]))
    if args.json:
        data = {"start_up": times, "sweep": rows, "region": region}
        Path(args.json).write_text(json.dumps(data, indent=2) + "\n")
    if args.plot:
        plot(rows, args.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
