"""Meshes in genus and in peers from PyPI, side by side in one run, with ratios.

    python tests/bench/mesh.py [--triangles N] [--points N] [--only WORD] [--json FILE]

Times are CPU seconds of the process, all threads added, best of three; a ratio above 1 means that
genus is faster. Peers that are not installed are left out and named: trimesh, libigl (igl),
openmesh, fast-simplification, mapbox-earcut, triangle, cgal.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import genus
import numpy as np
from genus.report.table import columns

PEERS = ("trimesh", "igl", "openmesh", "fast_simplification", "mapbox_earcut", "triangle", "CGAL")


def installed(name: str) -> Any:
    """The module, None if it is not there."""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def cpu_seconds(call: Callable[[], Any], repeats: int = 3) -> float:
    """Best of some; one call only where it takes long."""
    times: list[float] = []
    while len(times) < repeats and sum(times) < 20:
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


class Table:
    """Rows of one piece of work each, with the seconds of everybody who can do it."""

    def __init__(self, only: str) -> None:
        """Rows whose name has `only` in it."""
        self.only, self.rows = only, []

    def row(self, work: str, calls: dict[str, Callable[[], Any] | None], size: float = 0) -> None:
        """`size` in MB gives a speed as well."""
        if self.only not in work:
            return
        seconds = {}
        for name, call in calls.items():
            if call is None:
                continue
            try:
                seconds[name] = cpu_seconds(call)
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


def structure(table: Table, mesh: genus.Mesh) -> None:
    """Halfedges, one-rings, bytes, adjacency."""
    trimesh, igl, openmesh = (installed(n) for n in ("trimesh", "igl", "openmesh"))
    v, f = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    n = f"{len(mesh) / 1e6:.1f}M triangles"
    table.row(
        f"halfedges of {n}",
        {
            "genus": mesh.triangle_halfedge,
            "genus explicit": mesh.halfedge,
            "trimesh face_adjacency": trimesh
            and (lambda: trimesh.Trimesh(v, f, process=False).face_adjacency),
            "igl triangle_triangle_adjacency": igl and (lambda: igl.triangle_triangle_adjacency(f)),
            "openmesh": openmesh and (lambda: openmesh.TriMesh(v, f)),
        },
    )
    small, explicit = mesh.triangle_halfedge(), mesh.halfedge()
    matrix = igl.adjacency_matrix(f).astype(float) if igl else None
    table.row(
        f"one-ring sums of positions, {n}",
        {
            "genus": lambda: small.ring_sums(v),
            "genus explicit": lambda: explicit.ring_sums(v),
            "sparse matrix, made before": None if matrix is None else (lambda: matrix @ v),
        },
    )
    bytes_per_vertex = small.memory_bytes() / len(v)
    print(
        f"bytes a vertex: genus {bytes_per_vertex:.1f}, explicit layout "
        f"{explicit.memory_bytes() / len(v):.1f}"
    )


def files(table: Table, mesh: genus.Mesh, folder: Path) -> None:
    """Reading and writing, and welding a soup."""
    if table.only not in "write read STL OBJ PLY OFF ASCII weld a soup":
        return
    trimesh, igl = installed("trimesh"), installed("igl")
    v, f = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)
    theirs = trimesh and trimesh.Trimesh(v, f, process=False)
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
        table.row(
            f"write {size:.0f} MB {label}",
            {
                "genus": write,
                "trimesh": theirs and (lambda o=other, k=file_type: theirs.export(o, file_type=k)),
                # It writes STL as text only.
                "igl": (lambda other=other: igl.write_triangle_mesh(other, v, f))
                if igl and name != "b.stl"
                else None,
            },
            size,
        )
        table.row(
            f"read {size:.0f} MB {label}",
            {
                "genus": lambda path=path: genus.load(path),
                "trimesh": trimesh and (lambda path=path: trimesh.load(path)),
                "igl": igl and (lambda path=path: igl.read_triangle_mesh(path)),
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


def triangulation(table: Table, n: int) -> None:
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
        points = ring(kind, n)
        m = len(points)
        segments = np.column_stack([np.arange(m), np.roll(np.arange(m), -1)])
        ends = np.array([m], dtype=np.uint32)
        quick = m <= 100_000
        table.row(
            f"triangulate {kind} of {m} points",
            {
                "genus": lambda points=points: genus.triangulate(points),
                "genus delaunay": lambda points=points: genus.triangulate(points, (), "delaunay"),
                "earcut": (lambda p=points, e=ends: earcut.triangulate_float64(p, e))
                if earcut and quick
                else None,
                "triangle": triangle
                and (lambda p=points, s=segments: triangle.triangulate(
                    {"vertices": p, "segments": s}, "p")),
                "cgal, edge by edge": cgal and (lambda points=points: by_cgal(points)),
            },
        )  # fmt: skip


def main() -> int:
    """Measure, print, save what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--points", type=int, nargs="*", default=[10_000, 100_000])
    parser.add_argument("--only", default="", help="rows with this word")
    parser.add_argument("--json", metavar="FILE")
    args = parser.parse_args()
    missing = [name for name in PEERS if installed(name) is None]
    if missing:
        print(f"not installed, left out: {', '.join(missing)}", file=sys.stderr)
    table = Table(args.only)
    mesh = sphere(args.triangles)
    structure(table, mesh)
    with tempfile.TemporaryDirectory() as folder:
        files(table, mesh, Path(folder))
    simplification(table, sphere(args.triangles // 10))
    for n in args.points:
        triangulation(table, n)
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
