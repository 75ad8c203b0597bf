"""Convert mesh files between all formats that are known.

genus convert part.stl part.ply
genus convert *.stl --to ply --out-dir converted
"""

from __future__ import annotations

import argparse
import os

import genus
from genus.cli.common import MESH_FORMATS, extension, positive, progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """IN OUT, or many files with --to or --out-dir."""
    parser.add_argument("files", nargs="+", metavar="FILE", help="IN OUT, or inputs with --to")
    parser.add_argument("--to", choices=MESH_FORMATS, help="format of all outputs")
    parser.add_argument("--out-dir", metavar="D", help="folder for the outputs, made if missing")
    parser.add_argument(
        "--ascii", action="store_true", help="text where STL or PLY could be binary"
    )
    parser.add_argument(
        "--scale", type=positive, default=1.0, metavar="S", help="factor on all lengths"
    )
    parser.add_argument("--json", action="store_true", help="what was done, as JSON")
    parser.set_defaults(usage_error=parser.error)


def run(args: argparse.Namespace) -> int:
    """Convert one file after another; the first fault ends it."""
    done = []
    for source, target in pairs(args):
        with progress() as bar:
            counts = genus.convert(source, target, ascii=args.ascii, scale=args.scale, progress=bar)
        done.append({"from": source, "to": target, **counts})
        if not args.json:
            print(f"{target}: {counts['vertices']} vertices, {counts['faces']} faces")
    if args.json:
        import json

        print(json.dumps(done, indent=2))
    return 0


def pairs(args: argparse.Namespace) -> list[tuple[str, str]]:
    """Inputs with their outputs; ends the program where the command line does not say them."""
    if args.to is None and args.out_dir is None:
        if len(args.files) != 2:
            args.usage_error("give IN OUT, or --to FORMAT and --out-dir D for many files")
        if extension(args.files[1]) not in MESH_FORMATS:
            args.usage_error(
                f"{args.files[1]}: the extension must be one of {', '.join(MESH_FORMATS)}"
            )
        return [(args.files[0], args.files[1])]
    if args.out_dir is not None:
        os.makedirs(args.out_dir, exist_ok=True)
    jobs = [(source, output_of(source, args)) for source in args.files]
    outputs = [target for _, target in jobs]
    twice = next((t for i, t in enumerate(outputs) if t in outputs[:i]), None)
    if twice is not None:
        args.usage_error(f"{twice} would be written twice")
    return jobs


def output_of(source: str, args: argparse.Namespace) -> str:
    """The input's name with the new extension, in the output folder where one is given."""
    folder, name = os.path.split(source)
    suffix = args.to or extension(source)
    if suffix not in MESH_FORMATS:
        args.usage_error(f"{source}: give the format with --to")
    return os.path.join(args.out_dir or folder, f"{os.path.splitext(name)[0]}.{suffix}")
