"""Curves, patches and lattices of genus beside OpenSubdiv, scipy, splinepy, geomdl and numpy.

    python tests/bench/freeform.py [--points N] [--json FILE]

CPU seconds of all threads, best of three, arrays to arrays; peers that are not installed are left
out with a note. geomdl works point by point and is timed on a thousandth of the points. OpenSubdiv
is driven by a C++ program beside this file, compiled on the way; it computes in single precision.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import genus
import numpy as np
from genus.report.table import columns, number
from timing import Call, cpu_seconds, optional


def opensubdiv_seconds(points: int) -> float | None:
    """Of points and unit normals on a regular bicubic patch, best of three."""
    compiler = shutil.which("c++")
    if not compiler or not Path("/usr/include/opensubdiv").exists():
        print("OpenSubdiv (libosd-dev) or a compiler is missing: left out", file=sys.stderr)
        return None
    source = Path(__file__).with_name("opensubdiv_peer.cpp")
    with tempfile.TemporaryDirectory() as folder:
        peer = Path(folder) / "peer"
        build = [compiler, "-O3", "-march=native", "-std=c++17", str(source), "-losdCPU"]
        subprocess.run([*build, "-o", str(peer)], check=True)
        run = [str(peer), "bench", str(points)]
        return float(subprocess.run(run, check=True, capture_output=True, text=True).stdout)


def bernstein(n: int, t: np.ndarray) -> np.ndarray:
    return np.array([math.comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)])


class Bench:
    """Each method is one row: a dict of names and (call, points it does)."""

    def __init__(self, points: int) -> None:
        self.n = points
        self.rng = np.random.default_rng(1)
        self.t = self.rng.uniform(0, 1, points)
        self.u, self.v = self.rng.uniform(0, 1, (2, points))
        self.scipy = optional("scipy.interpolate")
        self.linalg = optional("scipy.linalg")
        self.splinepy = optional("splinepy")
        self.geomdl = optional("geomdl.BSpline")

    def bicubic_with_normals(self) -> dict[str, tuple[Call, int]]:
        net = self.rng.standard_normal((4, 4, 3))
        patch = genus.TensorPatch(net)
        calls: dict[str, tuple[Call, int]] = {
            "genus": (lambda: patch.points_and_normals(self.u, self.v), self.n)
        }

        def unit(du: np.ndarray, dv: np.ndarray) -> np.ndarray:
            normal = np.cross(du, dv)
            return normal / np.linalg.norm(normal, axis=1)[:, None]

        if self.scipy:
            knots = np.array([0, 0, 0, 0, 1, 1, 1, 1.0])
            peer = self.scipy.NdBSpline((knots, knots), net, 3)
            at = np.column_stack([self.u, self.v])
            calls["scipy"] = (
                lambda: (peer(at), unit(peer(at, nu=(1, 0)), peer(at, nu=(0, 1)))),
                self.n,
            )
        if self.splinepy:
            # The first parameter runs fastest there.
            bezier = self.splinepy.Bezier([3, 3], net.transpose(1, 0, 2).reshape(-1, 3))
            at = np.column_stack([self.u, self.v])
            calls["splinepy"] = (
                lambda: (
                    bezier.evaluate(at),
                    unit(bezier.derivative(at, [1, 0]), bezier.derivative(at, [0, 1])),
                ),
                self.n,
            )
        if self.geomdl:
            operations = importlib.import_module("geomdl.operations")
            surface = self.geomdl.Surface()
            surface.degree_u = surface.degree_v = 3
            surface.set_ctrlpts(net.reshape(-1, 3).tolist(), 4, 4)
            surface.knotvector_u = surface.knotvector_v = [0, 0, 0, 0, 1, 1, 1, 1]
            few = max(1, self.n // 1000)
            pairs = np.column_stack([self.u, self.v])[:few].tolist()
            calls["geomdl"] = (
                lambda: [
                    (surface.evaluate_single(p), operations.normal(surface, p)) for p in pairs
                ],
                few,
            )
        return calls

    def cubic_spline_curve(self) -> dict[str, tuple[Call, int]]:
        points = self.rng.standard_normal((20, 3))
        curve = genus.BSpline(points, 3)
        calls: dict[str, tuple[Call, int]] = {"genus": (lambda: curve.evaluate(self.t), self.n)}
        if self.scipy:
            peer = self.scipy.BSpline(curve.knots, points, 3)
            calls["scipy"] = (lambda: peer(self.t), self.n)
        if self.splinepy:
            spline = self.splinepy.BSpline([3], [curve.knots.tolist()], points)
            at = self.t[:, None]
            calls["splinepy"] = (lambda: spline.evaluate(at), self.n)
        return calls

    def bezier_of_degree_20(self) -> dict[str, tuple[Call, int]]:
        points = self.rng.standard_normal((21, 3))
        curve = genus.BezierCurve(points)
        calls: dict[str, tuple[Call, int]] = {"genus": (lambda: curve.evaluate(self.t), self.n)}
        if self.splinepy:
            bezier = self.splinepy.Bezier([20], points)
            at = self.t[:, None]
            calls["splinepy"] = (lambda: bezier.evaluate(at), self.n)
        calls["numpy"] = (lambda: bernstein(20, self.t).T @ points, self.n)
        return calls

    def quartic_triangle(self) -> dict[str, tuple[Call, int]]:
        points = self.rng.standard_normal((15, 3))
        patch = genus.TrianglePatch(points, 4)
        u = np.minimum(self.u, self.v)
        v = np.maximum(self.u, self.v) - u

        def by_numpy() -> np.ndarray:
            total, row = np.zeros((self.n, 3)), 0
            for i in range(5):
                for j in range(5 - i):
                    c = math.comb(4, i) * math.comb(4 - i, j)
                    b = c * u**i * v**j * (1 - u - v) ** (4 - i - j)
                    total += b[:, None] * points[row]
                    row += 1
            return total

        return {
            "genus": (lambda: patch.evaluate(u, v), self.n),
            "numpy": (by_numpy, self.n),
        }

    def ffd(self, degree: int) -> dict[str, tuple[Call, int]]:
        lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(degree,) * 3)
        lattice.points += 0.1 * self.rng.standard_normal(lattice.points.shape)
        net = lattice.points.copy()
        x = self.rng.uniform(0, 1, (self.n, 3))

        def by_numpy() -> np.ndarray:
            b = [bernstein(degree, x[:, k]) for k in range(3)]
            return np.einsum("ip,jp,kp,ijkx->px", *b, net, optimize=True)

        few = self.n // 10 if degree > 3 else self.n
        calls: dict[str, tuple[Call, int]] = {"genus": (lambda: lattice.apply(x), self.n)}
        if self.splinepy:
            volume = self.splinepy.Bezier([degree] * 3, net.transpose(2, 1, 0, 3).reshape(-1, 3))
            calls["splinepy"] = (lambda: volume.evaluate(x[:few]), few)
        if degree <= 3:
            calls["numpy"] = (by_numpy, self.n)
        return calls

    def inverse_ffd(self) -> dict[str, tuple[Call, int]]:
        s = self.rng.uniform(0, 1, (200, 3))
        targets = s + 0.05 * self.rng.standard_normal((200, 3))

        def ours() -> np.ndarray:
            lattice = genus.Lattice([0, 0, 0], np.eye(3), degree=(7, 7, 7))
            lattice.fit(s, targets)
            return lattice.apply(s) - targets

        calls: dict[str, tuple[Call, int]] = {"genus": (ours, self.n)}

        def by_gelsy() -> np.ndarray:
            b = [bernstein(7, s[:, k]) for k in range(3)]
            matrix = np.einsum("ip,jp,kp->pijk", *b).reshape(200, -1)
            moves = self.linalg.lstsq(matrix, targets - s, lapack_driver="gelsy")[0]
            return matrix @ moves - (targets - s)

        if self.linalg:
            calls["scipy"] = (by_gelsy, self.n)
        return calls


def rows(points: int) -> list[dict[str, Any]]:
    bench = Bench(points)
    works: dict[str, tuple[Callable[[], dict[str, tuple[Call, int]]], float]] = {
        "bicubic patch, points and normals": (bench.bicubic_with_normals, 0.03),
        "cubic B-spline curve": (bench.cubic_spline_curve, 0.02),
        "Bezier curve, degree 20": (bench.bezier_of_degree_20, 0.06),
        "quartic triangle patch": (bench.quartic_triangle, 0.05),
        "FFD, 4^3 lattice": (lambda: bench.ffd(3), 0.04),
        "FFD, 8^3 lattice": (lambda: bench.ffd(7), 0.15),
        "inverse FFD, 200 constraints, 8^3": (bench.inverse_ffd, 0.03),
    }
    table = []
    for name, (make, goal) in works.items():
        row: dict[str, Any] = {"work": name, "goal": goal}
        for peer, (call, done) in make().items():
            seconds, result = cpu_seconds(call)
            row[peer] = seconds * points / done
            if name.startswith("inverse"):
                row[f"residual {peer}"] = float(np.abs(result).max())
        if name.startswith("bicubic") and (seconds := opensubdiv_seconds(points)):
            row["OpenSubdiv"] = seconds
        table.append(row)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    table = rows(arguments.points)
    peers = ["OpenSubdiv", "scipy", "splinepy", "geomdl", "numpy"]
    lines = [["work", "genus", *peers, "best peer / genus", "goal"]]
    for row in table:
        times = [row[p] for p in peers if p in row]
        lines.append(
            [
                row["work"],
                number(row["genus"]),
                *(number(row[p]) if p in row else "-" for p in peers),
                f"{min(times) / row['genus']:.1f}" if times else "-",
                number(row["goal"]),
            ]
        )
    print(columns(lines[0], lines[1:]))
    print({k: v for k, v in table[-1].items() if k.startswith("residual")})
    if arguments.json:
        arguments.json.write_text(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
