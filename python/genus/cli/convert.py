"""Convert mesh files between all formats that are known.

genus convert part.stl part.ply
genus convert "*.stl" --to ply --out-dir converted
"""

from __future__ import annotations

import argparse
import glob
import os
from typing import Any

import genus
from genus.cli.common import FURTHER_FORMATS, MESH_FORMATS, extension, finite, positive, progress

UNITS = ("mm", "cm", "m", "um", "in", "ft")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """IN OUT, or many files with --to or --out-dir."""
    parser.add_argument(
        "files", nargs="+", metavar="FILE", help="IN OUT, or inputs and patterns with --to"
    )
    parser.add_argument("--to", type=str.lower, metavar="FORMAT", help="format of all outputs")
    parser.add_argument("--out-dir", metavar="D", help="folder for the outputs, made if missing")
    parser.add_argument(
        "--ascii", action="store_true", help="text where STL or PLY could be binary"
    )
    parser.add_argument(
        "--scale", type=positive, default=1.0, metavar="S", help="factor on all lengths"
    )
    parser.add_argument("--unit", choices=UNITS, help="unit of the numbers in the output")
    parser.add_argument(
        "--from-unit", choices=UNITS, help="unit of the numbers in the input, if it states none"
    )
    parser.add_argument(
        "--weld", type=not_negative, metavar="T", help="join vertices within this distance"
    )
    parser.add_argument(
        "--repair",
        action="store_true",
        help="orient, cut at T-junctions and non-manifold places, close holes",
    )
    parser.add_argument(
        "--check", action="store_true", help="fail unless the result is the border of a solid"
    )
    parser.add_argument(
        "--stream",
        action="store_true",
        help="binary STL to STL, PLY, OBJ, OFF piece by piece, vertices not shared",
    )
    parser.add_argument("--json", action="store_true", help="what was done, as JSON")
    parser.set_defaults(usage_error=parser.error)


def not_negative(text: str) -> float:
    """A finite number, zero or above."""
    value = finite(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is below zero")
    return value


def run(args: argparse.Namespace) -> int:
    """Convert one file after another; a bad one is reported and the others still done."""
    from genus.cli.__main__ import AT_FAULT, DONE, complain, text_of

    if args.stream and (args.weld is not None or args.repair or args.check or args.unit):
        args.usage_error("--weld, --repair, --check and --unit need the whole file, not a --stream")
    status, done = DONE, []
    for source, target in pairs(args):
        try:
            counts = convert(source, target, args)
        except (genus.Error, OSError) as error:
            status = complain(text_of(error), AT_FAULT)
            done.append({"from": source, "to": None, "error": text_of(error)})
            continue
        done.append({"from": source, "to": target, **counts})
        if not args.json:
            print(
                f"{target}: {counts['vertices']} vertices, {counts['faces']} faces{extra(counts)}"
            )
    if args.json:
        import json

        print(json.dumps(done, indent=2))
    return status


def convert(source: str, target: str, args: argparse.Namespace) -> dict[str, Any]:
    """One file; by the further formats where ours do not do."""
    options: dict[str, Any] = {
        "ascii": args.ascii,
        "scale": args.scale,
        "unit": args.unit,
        "from_unit": args.from_unit,
        "weld": args.weld,
        "repair": args.repair,
        "check": args.check,
        "stream": True if args.stream else None,
    }
    with progress() as bar:
        if is_ours(source) and is_ours(target):
            return genus.convert(source, target, progress=bar, **options)
        from genus.cli import further_formats

        return further_formats.convert(source, target, progress=bar, **options)


def is_ours(path: str) -> bool:
    """Whether core reads and writes it; of files without a known extension core looks inside."""
    return extension(path) not in FURTHER_FORMATS


def extra(counts: dict[str, Any]) -> str:
    """What was mended, in words; empty if nothing was."""
    mended = {k: v for k, v in counts.get("repair", {}).items() if v}
    if counts.get("welded_vertices"):
        mended["welded_vertices"] = counts["welded_vertices"]
    if counts.get("streamed"):
        return "; vertices not shared"
    return "".join(f"; {k.replace('_', ' ')} {v}" for k, v in mended.items())


def pairs(args: argparse.Namespace) -> list[tuple[str, str]]:
    """Inputs with their outputs; ends the program where the command line does not say them."""
    known = (*MESH_FORMATS, *FURTHER_FORMATS)
    if args.to is not None and args.to not in known:
        args.usage_error(f"--to {args.to}: must be one of {', '.join(known)}")
    if args.to is None and args.out_dir is None:
        if len(args.files) != 2:
            args.usage_error("give IN OUT, or --to FORMAT and --out-dir D for many files")
        if extension(args.files[1]) not in known:
            args.usage_error(f"{args.files[1]}: the extension must be one of {', '.join(known)}")
        return [(args.files[0], args.files[1])]
    sources = [match for pattern in args.files for match in expanded(pattern)]
    jobs = [(source, output_of(source, args, known)) for source in sources]
    outputs = [target for _, target in jobs]
    twice = next((t for i, t in enumerate(outputs) if t in outputs[:i]), None)
    if twice is not None:
        args.usage_error(f"{twice} would be written twice")
    if args.out_dir is not None:
        os.makedirs(args.out_dir, exist_ok=True)
    return jobs


def expanded(pattern: str) -> list[str]:
    """The files that a pattern matches, sorted; a name that is no pattern, or exists, as it is."""
    if os.path.exists(pattern) or not glob.has_magic(pattern):
        return [pattern]
    matches = sorted(path for path in glob.glob(pattern, recursive=True) if os.path.isfile(path))
    if not matches:
        raise FileNotFoundError(2, "no file matches", pattern)
    return matches


def output_of(source: str, args: argparse.Namespace, known: tuple[str, ...]) -> str:
    """The input's name with the new extension, in the output folder where one is given."""
    folder, name = os.path.split(source)
    suffix = args.to or extension(source)
    if suffix not in known:
        args.usage_error(f"{source}: give the format with --to")
    return os.path.join(args.out_dir or folder, f"{os.path.splitext(name)[0]}.{suffix}")
