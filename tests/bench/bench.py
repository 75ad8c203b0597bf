"""Genus and its peers side by side: start-up, and error against run time.

    python tests/bench/bench.py [--finest T] [--json FILE] [--plot FILE]

Times are wall seconds round one call, best of three; both run in one process, one after the other.
Errors of both are measured by the same function, on points of the faces against the exact surfaces.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
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


def manifold_part(tolerance: float) -> Any:
    """The same with so many facets that their sagitta is the tolerance."""
    import manifold3d

    def segments(r: float) -> int:
        return max(8, 4 * math.ceil(math.pi / math.acos(1 - min(tolerance, r / 2) / r) / 4))

    bore = manifold3d.Manifold.cylinder(LENGTH, BORE, BORE, segments(BORE), True)
    ball = manifold3d.Manifold.sphere(BALL, segments(BALL))
    mesh = (ball - bore - bore.rotate([90, 0, 0])).to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)


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


def sweep(finest: float) -> list[dict[str, Any]]:
    """One row a tolerance; peers that are not installed are left out."""
    rows, tolerance = [], 1.0
    while tolerance >= finest * 0.999:
        seconds, mesh = best_of(lambda t=tolerance: genus_part().mesh(t, measure=False))
        row = {
            "tolerance": tolerance,
            "genus": {
                "seconds": seconds,
                "triangles": len(mesh),
                "error": true_error(mesh.vertices, mesh.faces),
                "bound": mesh.error.bound,
            },
        }
        try:
            seconds, (vertices, faces) = best_of(lambda t=tolerance: manifold_part(t))
        except ImportError:
            print("manifold3d is not installed: its columns are left out", file=sys.stderr)
        else:
            error = true_error(vertices, faces)
            row["manifold3d"] = {"seconds": seconds, "triangles": len(faces), "error": error}
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


def table(rows: list[dict[str, Any]]) -> str:
    """The sweep for people."""
    peers = [name for name in ("genus", "manifold3d") if name in rows[0]]
    header = ["tolerance"] + [f"{p} {c}" for p in peers for c in ("s", "triangles", "error")]
    lines = []
    for row in rows:
        cells = [number(row["tolerance"])]
        for peer in peers:
            r = row[peer]
            cells += [f"{r['seconds']:.4f}", str(r["triangles"]), f"{r['error']:.2g}"]
        lines.append(cells)
    return columns(header, lines)


def plot(rows: list[dict[str, Any]], path: str) -> None:
    """Error against run time."""
    curves = []
    for name, style in (("genus", "o-"), ("manifold3d", "s--")):
        if name in rows[0]:
            label = "genus, certified" if name == "genus" else f"{name}, facets by sagitta"
            x, y = [r[name]["seconds"] for r in rows], [r[name]["error"] for r in rows]
            curves.append((label, style, x, y))
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
    args = parser.parse_args()
    times, rows = start_up(), sweep(args.finest)
    print("start-up, seconds")
    print(columns(["what", "s"], [[name, f"{s:.3f}"] for name, s in times.items()]))
    print("error against run time")
    print(table(rows))
    if args.json:
        Path(args.json).write_text(json.dumps({"start_up": times, "sweep": rows}, indent=2) + "\n")
    if args.plot:
        plot(rows, args.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
