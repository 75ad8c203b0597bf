"""Meshes in genus and in its peers, side by side in one run, with ratios.

    python tests/bench/mesh.py [--triangles N] [--points N] [--only WORD] [--json FILE]

Times are CPU seconds of the process, all threads added, best of three; a ratio above 1 means that
genus is faster. Peers that are not installed are left out and named. From PyPI: trimesh, libigl
(igl), fast-simplification, mapbox-earcut, triangle, cgal. In C++, by mesh_peers.cpp, which is
compiled where a compiler finds their headers: OpenMesh, CGAL.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import genus
import numpy as np
from genus.report.table import columns
from timing import cpu_seconds

PEERS = ("trimesh", "igl", "fast_simplification", "mapbox_earcut", "triangle", "CGAL")
# In C++: a header by which they are found, and what to link.
NATIVE_PEERS = {
    "openmesh": ("OpenMesh/Core/Mesh/Handles.hh", ["-lOpenMeshCore"]),
    "cgal": ("CGAL/version.h", ["-lgmp", "-lmpfr"]),
}
Seconds = float  # a peer that took its own time
PATIENCE = 300  # seconds for all that the C++ peers do of one kind


def installed(name: str) -> Any:
    """The module, None if it is not there."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


class NativePeers:
    """OpenMesh and CGAL, in a program of their own."""

    def __init__(self, folder: Path) -> None:
        """Compiled into a folder; `names` are those that are there."""
        self.compiler = os.environ.get("CXX") or shutil.which("c++")
        self.program, self.folder = folder / "mesh_peers", folder
        self.names = [n for n, (header, _) in NATIVE_PEERS.items() if self.finds(header)]
        if not self.names:
            return
        source = Path(__file__).with_name("mesh_peers.cpp")
        libraries = [flag for name in self.names for flag in NATIVE_PEERS[name][1]]
        print(f"compiling {source.name} for {', '.join(self.names)}", file=sys.stderr)
        subprocess.run(
            [self.compiler, "-std=c++17", "-O3", "-DNDEBUG", "-w", source, "-o", self.program]
            + libraries,
            check=True,
        )

    def finds(self, header: str) -> bool:
        """Whether the compiler finds it."""
        if self.compiler is None:
            return False
        text = f"#include <{header}>\n".encode()
        command = [self.compiler, "-xc++", "-std=c++17", "-fsyntax-only", "-"]
        return subprocess.run(command, input=text, capture_output=True).returncode == 0

    def run(self, *args: str | Path) -> dict[str, dict[str, float]]:
        """Numbers by peer and name, as far as they came in time."""
        out: dict[str, dict[str, float]] = {name: {} for name in self.names}
        if not self.names:
            return out
        command = [str(self.program), *map(str, args)]
        try:
            done = subprocess.run(
                command, check=True, stdout=subprocess.PIPE, cwd=self.folder, timeout=PATIENCE
            ).stdout
        except subprocess.TimeoutExpired as late:
            print(f"{args[0]}: {self.program.name} takes over {PATIENCE} s", file=sys.stderr)
            done = late.stdout or b""
        for line in done.decode().splitlines():
            peer, what, number = line.split()
            out[peer][what] = float(number)
        return out

    def soup(self, points: np.ndarray, faces: np.ndarray) -> Path:
        """A file that the program reads."""
        path = self.folder / "soup.bin"
        with path.open("wb") as file:
            file.write(np.array([len(points), len(faces)], np.int64).tobytes())
            file.write(np.ascontiguousarray(points, np.float64).tobytes())
            file.write(np.ascontiguousarray(faces, np.int32).tobytes())
        return path


class Table:
    """Rows of one piece of work each, with the seconds of everybody who can do it."""

    def __init__(self, only: str) -> None:
        """Rows whose name has `only` in it."""
        self.only, self.rows = only, []

    def row(
        self, work: str, calls: dict[str, Callable[[], Any] | Seconds | None], size: float = 0
    ) -> None:
        """Calls, or seconds measured elsewhere; `size` in MB gives a speed as well."""
        if self.only not in work:
            return
        seconds = {}
        for name, call in calls.items():
            if call is None or call is False:
                continue
            try:
                seconds[name] = call if isinstance(call, float) else cpu_seconds(call, enough=20)[0]
            except Exception as error:  # a peer that fails is part of the answer
                if name == "genus":
                    raise
                print(f"{work}: {name} fails: {type(error).__name__}: {error}", file=sys.stderr)
        self.rows.append({"work": work, "seconds": seconds, "MB": size})
        print(self.line(self.rows[-1]), flush=True)

    @staticmethod
    def line(row: dict[str, Any]) -> str:
        """One row for people."""
        own = row["seconds"]["genus"]
        speed = f" ({row['MB'] / own:.0f} MB/s)" if row["MB"] else ""
        peers = [
            f"{name} {s:.4g} s ({s / own:.1f}x)"
            for name, s in row["seconds"].items()
            if name != "genus"
        ]
        return f"{row['work']}: genus {own:.4g} s{speed}; {', '.join(peers) or 'no peer installed'}"


def sphere(triangles: int) -> genus.Mesh:
    """About so many."""
    return genus.icosphere(r=10, parts=max(1, round(math.sqrt(triangles / 20))))


def structure(table: Table, mesh: genus.Mesh, native: NativePeers) -> None:
    """Halfedges, one-rings, bytes, adjacency."""
    if table.only not in "halfedges of one-ring sums of positions bytes a vertex":
        return
    trimesh, igl = installed("trimesh"), installed("igl")
    v, f = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    theirs = native.run("mesh", native.soup(v, f))
    n = f"{len(mesh) / 1e6:.1f}M triangles"
    table.row(
        f"halfedges of {n}",
        {
            "genus": mesh.triangle_halfedge,
            "genus explicit": mesh.halfedge,
            "trimesh face_adjacency": trimesh
            and (lambda: trimesh.Trimesh(v, f, process=False).face_adjacency),
            "igl triangle_triangle_adjacency": igl and (lambda: igl.triangle_triangle_adjacency(f)),
            **{name: numbers["halfedges"] for name, numbers in theirs.items()},
        },
    )
    small, explicit = mesh.triangle_halfedge(), mesh.halfedge()
    matrix = igl.adjacency_matrix(f).astype(float) if igl else None
    table.row(
        f"one-ring sums of positions, {n}",
        {
            "genus": lambda: small.ring_sums(v),
            "genus explicit": lambda: explicit.ring_sums(v),
            "igl's sparse matrix, made before": None if matrix is None else (lambda: matrix @ v),
            **{name: numbers["rings"] for name, numbers in theirs.items()},
        },
    )
    sizes = {"genus": small.memory_bytes() / len(v), "explicit": explicit.memory_bytes() / len(v)}
    sizes |= {name: numbers["bytes"] for name, numbers in theirs.items()}
    print("bytes a vertex: " + ", ".join(f"{name} {size:.1f}" for name, size in sizes.items()))


def files(table: Table, mesh: genus.Mesh, folder: Path, native: NativePeers) -> None:
    """Reading and writing, and welding a soup."""
    if table.only not in "write read STL OBJ PLY OFF ASCII weld a soup":
        return
    trimesh, igl = installed("trimesh"), installed("igl")
    v, f = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    theirs = trimesh and trimesh.Trimesh(v, f, process=False)
    native_soup = native.soup(v, f)
    for name, ascii in (("b.stl", False), ("a.obj", True), ("b.ply", False), ("a.off", True),
                        ("a.stl", True)):  # fmt: skip
        path = str(folder / name)
        kind = "ASCII " if ascii and name.endswith("stl") else ""
        label = f"{kind}{name[2:].upper()}"
        file_type = "stl_ascii" if kind else name[2:]

        def write(path: str = path, ascii: bool = ascii) -> None:
            mesh.save(path, ascii=ascii)

        write()
        size = os.path.getsize(path) / 1e6
        other = path + ".peer" + name[1:]
        written = native.run("write", native_soup, other, "1" if ascii else "0")
        read = native.run("read", path)
        table.row(
            f"write {size:.0f} MB {label}",
            {
                "genus": write,
                "trimesh": theirs and (lambda o=other, k=file_type: theirs.export(o, file_type=k)),
                # It writes STL as text only.
                "igl": (lambda other=other: igl.write_triangle_mesh(other, v, f))
                if igl and name != "b.stl"
                else None,
                **{n: numbers["write"] for n, numbers in written.items() if "write" in numbers},
            },
            size,
        )
        table.row(
            f"read {size:.0f} MB {label}",
            {
                "genus": lambda path=path: genus.load(path),
                "trimesh": trimesh and (lambda path=path: trimesh.load(path)),
                "igl": igl and (lambda path=path: igl.read_triangle_mesh(path)),
                **{n: numbers["read"] for n, numbers in read.items() if "read" in numbers},
            },
            size,
        )
        for each in (path, other):
            if os.path.exists(each):
                os.unlink(each)
    soup = genus.Mesh(v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3))
    points, faces = np.array(soup.vertices), np.array(soup.faces, dtype=np.int64)
    table.row(
        f"weld a soup of {len(points) / 1e6:.1f}M points",
        {
            "genus": soup.weld,
            "trimesh": trimesh
            and (lambda: trimesh.Trimesh(points, faces, process=False).merge_vertices()),
            "igl": igl and (lambda: igl.remove_duplicate_vertices(points, faces, 0.0)),
        },
    )


def simplification(table: Table, mesh: genus.Mesh) -> None:
    """To a tenth of the faces; with the proven bound, and without measuring as the peer does."""
    fast = installed("fast_simplification")
    v, f = np.array(mesh.vertices, dtype=np.float32), np.array(mesh.faces)
    few = len(mesh) // 10
    table.row(
        f"simplify {len(mesh) / 1e6:.2f}M triangles to a tenth",
        {
            "genus": lambda: mesh.simplify(faces=few, certify=False),
            "genus certified": lambda: mesh.simplify(faces=few),
            "fast_simplification": fast and (lambda: fast.simplify(v, f, target_count=few)),
        },
    )


def ring(kind: str, n: int) -> np.ndarray:
    """Polygons of the table of numbers: spikes, teeth, a band wound up."""
    i = np.arange(n)
    if kind == "star":
        angle = 2 * np.pi * i / n
        r = np.where(i % 2, 0.3 + 0.2 * np.sin(7 * angle), 1.0)
        return np.column_stack([r * np.cos(angle), r * np.sin(angle)])
    if kind == "comb":
        k = np.arange(n - 2, -1, -1)
        teeth = np.column_stack([0.5 * k, np.where(k % 2, 10.0 + k % 7, 0.0)])
        return np.vstack([[0.5 * n, -1], teeth, [0, -1]])
    half, turns = n // 2, max(3.0, n / 200)
    s = np.arange(half) / half
    angle, out = 2 * np.pi * turns * s, []
    for start, order in ((1.5, 1), (1.0, -1)):
        r = start + turns * s
        out.append(np.column_stack([r * np.cos(angle), r * np.sin(angle)])[::order])
    return np.vstack(out)


def triangulation(table: Table, n: int, native: NativePeers) -> None:
    """Rings of n points."""
    earcut, triangle, cgal = (installed(m) for m in ("mapbox_earcut", "triangle", "CGAL"))

    def by_cgal(points: np.ndarray) -> None:
        from CGAL import CGAL_Kernel, CGAL_Triangulation_2

        cdt = CGAL_Triangulation_2.Constrained_Delaunay_triangulation_2()
        # The wheel has no call for all at once: a call costs about a microsecond.
        made = [cdt.insert(CGAL_Kernel.Point_2(x, y)) for x, y in points.tolist()]
        for a, b in zip(made, [*made[1:], made[0]], strict=True):
            cdt.insert_constraint(a, b)

    for kind in ("star", "comb", "spiral"):
        if table.only not in f"triangulate {kind}":
            continue
        points = ring(kind, n)
        theirs = native.run("polygon", native.soup(points, np.empty((0, 3))))
        m = len(points)
        segments = np.column_stack([np.arange(m), np.roll(np.arange(m), -1)])
        ends = np.array([m], dtype=np.uint32)
        quick = m <= 200_000
        wheel = cgal if quick and "cgal" not in native.names else None
        table.row(
            f"triangulate {kind} of {m} points",
            {
                "genus": lambda points=points: genus.triangulate(points),
                "genus delaunay": lambda points=points: genus.triangulate(points, (), "delaunay"),
                "earcut": (lambda p=points, e=ends: earcut.triangulate_float64(p, e))
                if earcut and quick
                else None,
                # Its time grows as the square on the star: minutes.
                "triangle": triangle
                and m <= 20_000
                and (lambda p=points, s=segments: triangle.triangulate(
                    {"vertices": p, "segments": s}, "p")),
                "cgal, edge by edge": wheel and (lambda points=points: by_cgal(points)),
                **{n: numbers["polygon"] for n, numbers in theirs.items() if "polygon" in numbers},
            },
        )  # fmt: skip


def main() -> int:
    """Measure, print, save what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--points", type=int, nargs="*", default=[10_000, 100_000, 1_000_000])
    parser.add_argument("--only", default="", help="rows with this word")
    parser.add_argument("--json", metavar="FILE")
    args = parser.parse_args()
    missing = [name for name in PEERS if installed(name) is None]
    table = Table(args.only)
    mesh = sphere(args.triangles)
    with tempfile.TemporaryDirectory() as folder:
        native = NativePeers(Path(folder))
        missing += [name for name in NATIVE_PEERS if name not in native.names]
        if missing:
            print(f"not installed, left out: {', '.join(missing)}", file=sys.stderr)
        structure(table, mesh, native)
        files(table, mesh, Path(folder), native)
        simplification(table, sphere(args.triangles // 10))
        for n in args.points:
            triangulation(table, n, native)
    rows = [
        [row["work"], f"{row['seconds']['genus']:.4f}"]
        + [", ".join(f"{k} {s:.4f}" for k, s in row["seconds"].items() if k != "genus")]
        for row in table.rows
    ]
    print(columns(["work", "genus, CPU s", "peers, CPU s"], rows))
    if args.json:
        Path(args.json).write_text(json.dumps(table.rows, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
