"""Build a text model: a closed mesh, a plane shape, or its echo or flat text form.

genus build part.scad -o part.stl --tolerance 0.05
genus build part.scad -o part.ply -D length=40 -D 'name="left"'
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING, Any

import genus
from genus.cli.common import MESH_FORMATS, extension, positive, progress, write_text

if TYPE_CHECKING:
    from genus import Mesh, Region, TextModel

TEXT_FORMATS = ("echo", "csg")
PLANE_FORMATS = ("svg", "dxf")
FORMATS = (*MESH_FORMATS, *PLANE_FORMATS, *TEXT_FORMATS)
KNOWN = ", ".join(FORMATS)
METHODS = ("auto", "boolean", "emc", "mc")


def definition(text: str) -> tuple[str, str]:
    """name=value, the value an expression of the text language."""
    name, equals, value = text.partition("=")
    name = name.strip()
    if not equals or not value.strip() or not name.removeprefix("$").isidentifier():
        raise argparse.ArgumentTypeError(f"{text!r} is not name=value")
    return name, value.strip()


def output(path: str) -> str:
    """A path whose extension says what to write."""
    if extension(path) not in FORMATS:
        raise argparse.ArgumentTypeError(f"{path}: the extension must be one of {KNOWN}")
    return path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Model, output, and what the mesh has to be."""
    parser.add_argument("model", metavar="MODEL.scad")
    parser.add_argument(
        "-o", "--output", required=True, type=output, metavar="OUT", help=f"file to write: {KNOWN}"
    )
    parser.add_argument(
        "--tolerance",
        type=positive,
        metavar="T",
        help="largest distance from the exact solid, model units; round shapes"
        " without $fn are exact then",
    )
    parser.add_argument(
        "-D",
        dest="defines",
        action="append",
        default=[],
        type=definition,
        metavar="NAME=VALUE",
        help="replace a variable of the model",
    )
    parser.add_argument("--method", choices=METHODS, default="auto", help="road to the mesh")
    parser.add_argument(
        "--ascii", action="store_true", help="text where STL or PLY could be binary"
    )
    parser.add_argument("--explain", action="store_true", help="say what was left out of the work")
    parser.add_argument(
        "--report", metavar="FILE", help="write the report: JSON for .json, else a table"
    )
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(args: argparse.Namespace) -> int:
    """Evaluate, mesh, write, report. Warnings and echoes go to standard error."""
    start = time.perf_counter()
    model = evaluate(args)
    evaluated = time.perf_counter() - start
    kind = extension(args.output)
    if kind in TEXT_FORMATS:
        write_text(args.output, model.echo if kind == "echo" else model.csg)
        return 0
    if kind in PLANE_FORMATS:
        plane_shape(args, model).save(args.output)
        return 0
    mesh = make_mesh(args, model)
    start = time.perf_counter()
    with progress() as bar:
        mesh.save(args.output, ascii=args.ascii, progress=bar)
    written = time.perf_counter() - start
    tell(args, full_report(args, mesh, evaluated, written))
    return 0


def evaluate(args: argparse.Namespace) -> TextModel:
    """Run the text model; what it says goes to standard error, also if it fails."""
    messages: list[str] = []
    try:
        with progress() as bar:
            return genus.run_scad(
                args.model,
                expressions=dict(args.defines),
                solid=extension(args.output) not in TEXT_FORMATS,
                plane=extension(args.output) in PLANE_FORMATS,
                tolerance=args.tolerance,
                messages=messages,
                progress=bar,
            )
    finally:
        for message in messages:
            print(message, file=sys.stderr)


def plane_shape(args: argparse.Namespace, model: TextModel) -> Region:
    """The shape of a plane model; a model of nothing is one, too."""
    if model.region is not None:
        return model.region
    if model.solid.is_empty:
        return genus.Region()
    raise genus.InvalidInput(f"{args.model}: the model is a solid; project it to a plane shape")


def make_mesh(args: argparse.Namespace, model: TextModel) -> Mesh:
    """Mesh it within the tolerance of the command line or, without that, of the model."""
    with progress() as bar:
        return model.solid.mesh(model.tolerance, args.method, progress=bar)


def full_report(
    args: argparse.Namespace, mesh: Mesh, evaluated: float, written: float
) -> dict[str, Any]:
    """The mesh's report with the model, the file, and the seconds spent outside the mesher."""
    report = mesh.report()
    seconds = report["seconds"]
    meshing = seconds.pop("total")
    stages = {"text model": evaluated, **seconds, "write": written}
    report["seconds"] = {**stages, "total": evaluated + meshing + written}
    report["model"], report["output"] = args.model, args.output
    return report


def tell(args: argparse.Namespace, report: dict[str, Any]) -> None:
    """Print and write the report as the options say."""
    if args.json or (args.report and extension(args.report) == "json"):
        import json

        as_json = json.dumps(report, indent=2) + "\n"
    table = f"{args.model} -> {args.output}\n{report}\n"
    if args.explain:
        table += f"left out\n{left_out(report)}\n"
    if args.report:
        write_text(args.report, as_json if extension(args.report) == "json" else table)
    sys.stdout.write(as_json if args.json else table)


def left_out(report: dict[str, Any]) -> str:
    """One line for each thing that planning and pruning made unnecessary."""
    from genus.report.table import render

    rows = [(what, f"{count} {unit}") for what, count, unit in report["left_out"]]
    return render(rows) if rows else "  nothing"
