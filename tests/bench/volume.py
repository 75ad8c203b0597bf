"""Marching cubes of genus beside trueform, VTK and scikit-image, in one run.

    python tests/bench/volume.py [--samples N ...] [--json FILE] [--plot FILE]

CPU seconds of all threads, best of three, arrays to arrays; peers that are not installed are left
out with a note. Three tables: a ball of float32 samples; a box with a bore, whose edges marching
cubes cuts off; and what keeping them costs, with the largest angle between a face and the surface
under it, which `--plot` draws.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import genus
import numpy as np
from genus.report.table import columns, number
from timing import cpu_seconds, optional

RADIUS, BORE = 0.8, 0.6
HALF = 1.3
Arrays = tuple[np.ndarray, np.ndarray]  # vertices, faces


def axis_coordinates(n: int, half: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    a = np.linspace(-half, half, n, dtype=np.float32)
    return a[:, None, None], a[None, :, None], a[None, None, :]


def ball(n: int) -> np.ndarray:
    x, y, z = axis_coordinates(n, 1.0)
    return np.sqrt(x * x + y * y + z * z) - np.float32(RADIUS)


def bored_box(n: int) -> np.ndarray:
    x, y, z = axis_coordinates(n, HALF)
    box = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(z)) - np.float32(1)
    return np.maximum(box, np.float32(BORE) - np.sqrt(x * x + y * y))


def ball_calls(values: np.ndarray) -> dict[str, Callable[[], Any]]:
    n = values.shape[0]
    h = 2.0 / (n - 1)
    calls: dict[str, Callable[[], Any]] = {
        "genus": lambda: genus.marching_cubes(values, origin=(-1, -1, -1), spacing=h)
    }
    if trueform := optional("trueform"):
        volume = trueform.Volume(np.asfortranarray(values), (h, h, h), (-1, -1, -1))
        calls["trueform"] = lambda: trueform.isosurface(volume, 0.0)
    if skimage := optional("skimage.measure"):
        calls["skimage"] = lambda: skimage.marching_cubes(values, 0.0, spacing=(h, h, h))
    if vtk := optional("vtk"):
        from vtk.util.numpy_support import numpy_to_vtk

        image = vtk.vtkImageData()
        image.SetDimensions(n, n, n)
        image.SetSpacing(h, h, h)
        image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=False))

        def flying_edges() -> Any:
            surface = vtk.vtkFlyingEdges3D()
            surface.SetInputData(image)
            surface.SetValue(0, 0.0)
            surface.ComputeNormalsOff()
            surface.Update()
            return surface.GetOutput()

        calls["vtk"] = flying_edges
    return calls


def edge_error(vertices: np.ndarray, cell: float) -> tuple[float, float]:
    """Of the vertices within a cell of a place on the rims of the bore the one nearest to a rim:
    how far it is, largest and mean over many places."""
    angle = np.linspace(0, 2 * np.pi, 1000, endpoint=False)
    rho = np.hypot(vertices[:, 0], vertices[:, 1])
    errors = []
    for side in (-1, 1):
        away = np.hypot(rho - BORE, vertices[:, 2] - side)
        near = vertices[away < 0.1]
        rim = np.stack([BORE * np.cos(angle), BORE * np.sin(angle), np.full_like(angle, side)], 1)
        for p in rim:
            q = near[((near - p) ** 2).sum(axis=1) < cell * cell]
            off = np.hypot(np.hypot(q[:, 0], q[:, 1]) - BORE, q[:, 2] - side)
            errors.append(float(off.min(initial=cell)))
    return max(errors), sum(errors) / len(errors)


def part() -> genus.Solid:
    return genus.cube(2, center=True) - genus.cylinder(h=4, r=BORE, center=True)


def sharp_calls(n: int) -> dict[str, Callable[[], Arrays]]:
    cell = 2 * HALF / (n - 1)

    def arrays(mesh: genus.Mesh) -> Arrays:
        return np.asarray(mesh.vertices), np.asarray(mesh.faces)

    solid = part()
    calls: dict[str, Callable[[], Arrays]] = {
        "genus": lambda: arrays(genus.extended_marching_cubes(solid, cell_size=cell)),
        "genus, plain": lambda: arrays(genus.marching_cubes(solid, cell_size=cell)),
    }
    if trueform := optional("trueform"):
        values = np.asfortranarray(bored_box(n))
        volume = trueform.Volume(values, (cell,) * 3, (-HALF,) * 3)

        def dual() -> Arrays:
            faces, points = trueform.isosurface(volume, 0.0, method="dual_contouring")
            return points, faces

        calls["trueform"] = dual
    return calls


def largest_angle(mesh: genus.Mesh, cell: float) -> float:
    """Between the normal of a face and that of the nearest of the surfaces under its middle."""
    corner = mesh.vertices[mesh.faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(normal, axis=1)
    kept = size > 1e-6 * cell * cell
    normal, middle = normal[kept] / size[kept, None], corner.mean(axis=1)[kept]
    rho = np.hypot(middle[:, 0], middle[:, 1])
    inward = -np.stack([middle[:, 0] / rho, middle[:, 1] / rho, 0 * rho], axis=1)
    cosine = np.where(np.abs(rho - BORE) < cell, (normal * inward).sum(axis=1), -1.0)
    for axis in range(3):
        flat = np.sign(middle[:, axis]) * normal[:, axis]
        on_side = np.abs(np.abs(middle[:, axis]) - 1) < cell
        cosine = np.maximum(cosine, np.where(on_side, flat, -1.0))
    return float(np.degrees(np.arccos(np.clip(cosine.min(), -1, 1))))


def cost_of_features(n: int) -> dict[str, Any]:
    cell = 2 * HALF / (n - 1)
    solid = part()
    plain_seconds, plain = cpu_seconds(lambda: genus.marching_cubes(solid, cell_size=cell))
    sharp_seconds, sharp = cpu_seconds(lambda: genus.extended_marching_cubes(solid, cell_size=cell))
    return {
        "samples": n,
        "plain": plain_seconds,
        "extended": sharp_seconds,
        "ratio": sharp_seconds / plain_seconds,
        "angle, plain": largest_angle(plain, cell),
        "angle, extended": largest_angle(sharp, cell),
    }


def side_by_side(work: str, seconds: dict[str, float]) -> dict[str, Any]:
    own = seconds["genus"]
    return {"work": work, **seconds, "ratios": {k: s / own for k, s in seconds.items()}}


def show(rows: list[dict[str, Any]], keys: list[str]) -> None:
    table = [
        [r[k] if isinstance(r.get(k), str) else number(r[k]) if k in r else "-" for k in keys]
        for r in rows
    ]
    print(columns(keys, table), flush=True)


def plot(rows: list[dict[str, Any]], path: str) -> None:
    from loglog import loglog

    cells = [2 * HALF / (r["samples"] - 1) for r in rows]
    curves = [
        ("marching cubes", "o-", cells, [r["angle, plain"] for r in rows]),
        ("extended marching cubes", "s-", cells, [r["angle, extended"] for r in rows]),
    ]
    loglog(
        path,
        curves,
        title="Box with a bore: largest angle between face and surface",
        x="cell size",
        y="degrees",
    )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--samples", type=int, nargs="+", default=[256])
    parser.add_argument("--features", type=int, nargs="*", default=[32, 64, 128, 256])
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot")
    options = parser.parse_args()
    result: dict[str, Any] = {"ball": [], "bored box": [], "features": []}
    for n in options.samples:
        values = ball(n)
        seconds = {name: cpu_seconds(call)[0] for name, call in ball_calls(values).items()}
        result["ball"].append(side_by_side(f"ball, {n}^3 float32", seconds))
        show(result["ball"][-1:], ["work", *seconds])
        row: dict[str, Any] = {"work": f"bored box, {n}^3"}
        for name, call in sharp_calls(n).items():
            spent, (vertices, faces) = cpu_seconds(call)
            most, mean = edge_error(np.asarray(vertices), 2 * HALF / (n - 1))
            row |= {name: spent, f"{name}: edge error": most, f"{name}: mean": mean}
            row[f"{name}: triangles"] = float(len(faces))
        result["bored box"].append(row)
        show([row], list(row))
    for n in options.features:
        result["features"].append(cost_of_features(n))
    if result["features"]:
        show(result["features"], list(result["features"][0]))
    if options.json:
        options.json.write_text(json.dumps(result, indent=1))
    if options.plot:
        plot(result["features"], options.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
