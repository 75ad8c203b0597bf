"""Formats beyond those of core, through meshio where it is installed (the extra genus[formats])."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np

import genus
from genus.cli.common import FURTHER_FORMATS, extension

_FACES = ("triangle", "quad", "polygon")


def convert(
    source: str,
    target: str,
    *,
    progress: Callable[[str, float], object] | None = None,
    stream: bool | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Read or write through meshio; between the two, all that core's convert does."""
    if stream:
        raise genus.InvalidInput("only binary STL files to STL, PLY, OBJ or OFF can be streamed")
    with tempfile.TemporaryDirectory() as folder:
        between = source
        if extension(source) in FURTHER_FORMATS:
            between = os.path.join(folder, "between.ply")
            read(source).save(between)
        made = target
        if extension(target) in FURTHER_FORMATS:
            made = os.path.join(folder, "made.ply")
            options["ascii"], text = False, options.get("ascii", False)
        try:
            counts = dict(genus.convert(between, made, progress=progress, **options))
        except genus.FileError as error:  # of the file that was named, not the one in between
            raise fault(source if error.path == between else target, error.problem) from None
        if made != target:
            write(genus.load_polygons(made), target, text)
        return counts


def fault(path: str, problem: str) -> genus.FileError:
    """The error that core raises for files."""
    error = genus.FileError(f"{path}: {problem}")
    error.path, error.problem, error.line, error.byte = path, problem, None, None
    return error


def meshio(path: str) -> Any:
    """The library, or one line that says what to install."""
    try:
        import meshio as library
    except ImportError:
        raise fault(
            path, f".{extension(path)} files need the package meshio: pip install 'genus[formats]'"
        ) from None
    return library


def quietly(path: str, verb: str, call: Callable[[], Any]) -> Any:
    """The result of a call to meshio, which prints its errors and ends the program."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return call()
    except OSError as error:
        error.filename = path
        raise
    except (Exception, SystemExit) as error:
        words = [line for line in said.getvalue().splitlines() if line] or [str(error)]
        raise fault(path, f"meshio cannot {verb} it: {words[0]}") from None


def read(path: str) -> genus.PolygonMesh:
    """The triangles, quadrilaterals and polygons of a file; other cells are left out."""
    library = meshio(path)
    if not os.path.exists(path):
        raise FileNotFoundError(2, os.strerror(2), path)
    mesh = quietly(path, "read", lambda: library.read(path))
    faces = [
        face
        for block in mesh.cells
        if block.type in _FACES
        for face in np.asarray(block.data).tolist()
    ]
    if not faces and len(mesh.points):
        raise fault(path, "has no triangles, quadrilaterals or polygons")
    points = np.asarray(mesh.points, dtype=float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    return genus.PolygonMesh(points, faces)


def write(mesh: genus.PolygonMesh, path: str, text: bool) -> None:
    """Write a file whole or not at all; faces by their number of corners."""
    library = meshio(path)
    cells: dict[int, list[Any]] = {}
    for face in mesh.faces:
        cells.setdefault(len(face), []).append(np.asarray(face))
    blocks = [
        ({3: "triangle", 4: "quad"}.get(n, "polygon"), np.array(faces))
        for n, faces in sorted(cells.items())
    ]
    folder, name = os.path.split(path)
    partial = os.path.join(folder, f".{os.getpid()}.{name}")  # keeps the extension
    options = {"binary": not text} if extension(path) in ("vtk", "vtu", "msh") else {}
    made = library.Mesh(np.asarray(mesh.vertices), blocks)
    try:
        quietly(path, "write", lambda: made.write(partial, **options))
        os.replace(partial, path)
    finally:
        if os.path.exists(partial):
            os.unlink(partial)
