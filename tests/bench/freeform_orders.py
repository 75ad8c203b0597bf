"""Orders of convergence of curves and patches, measured and drawn.

    python tests/bench/freeform_orders.py [--out docs/pictures/freeform_orders.png]

Halving a Bezier curve brings its control polygon four times nearer; a patch cut into twice as many
cells a side is followed four times as closely. The orders are asserted in
tests/python/test_freeform.py.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import genus
import numpy as np
from loglog import loglog


def polygon_gaps(halvings: int) -> tuple[np.ndarray, np.ndarray]:
    """Pieces, and the largest distance from a control point to the curve at k / n."""
    pieces = [genus.BezierCurve(np.random.default_rng(5).standard_normal((8, 3)))]
    counts, gaps = [], []
    for _ in range(halvings):
        t = np.arange(8) / 7
        gaps.append(max(np.linalg.norm(c.evaluate(t) - c.points, axis=1).max() for c in pieces))
        counts.append(len(pieces))
        pieces = [half for c in pieces for half in c.split(0.5)]
    return np.array(counts), np.array(gaps)


def tessellation_errors(quarters: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells a side, about, with the bound and the error measured."""
    rng = np.random.default_rng(10)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 2, indexing="ij"), axis=-1)
    patch = genus.TensorPatch(np.concatenate([grid, 0.3 * rng.standard_normal((4, 4, 1))], axis=2))
    meshes = [patch.mesh(1.6e-2 / 4**k) for k in range(quarters)]
    cells = np.sqrt([len(mesh) / 2 for mesh in meshes])
    return (
        cells,
        np.array([mesh.error.bound for mesh in meshes]),
        np.array([mesh.error.measured for mesh in meshes]),
    )


def order(across: np.ndarray, error: np.ndarray) -> float:
    """Of the last steps."""
    return float(-np.polyfit(np.log(across[-4:]), np.log(error[-4:]), 1)[0])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/freeform_orders.png"))
    arguments = parser.parse_args()
    pieces, gaps = polygon_gaps(11)
    cells, bounds, measured = tessellation_errors(7)
    print(f"control polygon to curve: order {order(pieces, gaps):.2f}")
    print(f"mesh to patch, measured: order {order(cells, measured):.2f}")
    print(f"mesh to patch, bound: order {order(cells, bounds):.2f}")
    loglog(
        str(arguments.out),
        [
            ("control polygon to curve, by pieces", "o-", pieces, gaps),
            ("mesh to patch, bound, by cells a side", "s--", cells, bounds),
            ("mesh to patch, measured", "s-", cells, measured),
            ("order 2", "k:", pieces, gaps[3] * (pieces[3] / pieces) ** 2),
        ],
        title="Halving divides the error by four",
        x="pieces, cells a side",
        y="distance",
    )


if __name__ == "__main__":
    main()
