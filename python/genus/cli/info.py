"""Say what is in mesh files: topology, defects, size, volume and area."""

from __future__ import annotations

import argparse
from collections import Counter
from typing import Any

import genus
from genus.cli.common import progress
from genus.cli.convert import expanded


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One file or many."""
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--json", action="store_true", help="one JSON list for all files")
    parser.add_argument(
        "--no-intersections", action="store_true", help="do not look for self-intersections"
    )


def run(args: argparse.Namespace) -> int:
    """Describe every file; a bad one is reported and the others still done."""
    from genus.cli.__main__ import AT_FAULT, DONE, complain, text_of

    status, described = DONE, []
    for path in [match for pattern in args.files for match in expanded(pattern)]:
        try:
            described.append(describe(path, not args.no_intersections))
        except (genus.Error, OSError) as error:
            status = complain(text_of(error), AT_FAULT)
            continue
        if not args.json:
            show(path, described[-1])
    if args.json:
        import json

        print(json.dumps(described, indent=2))
    return status


def describe(path: str, intersections: bool) -> dict[str, Any]:
    """Plain values, with the defects counted by kind and the first of each kind in words."""
    with progress() as bar:
        polygons = genus.load_polygons(path, progress=bar)
        mesh = polygons.triangles()
        findings = mesh.validate(self_intersections=intersections, max_findings=1000, progress=bar)
    first = {finding.defect: str(finding) for finding in reversed(findings)}
    counts = Counter(finding.defect for finding in findings)
    defects = [
        {"kind": kind, "count": count, "more": count == 1000, "first": first[kind]}
        for kind, count in counts.items()
    ]
    return {
        "file": path,
        "polygons": len(polygons),
        **mesh.report(),
        "mean_valence": mesh.topology.mean_valence,
        "defects": defects,
    }


def show(path: str, described: dict[str, Any]) -> None:
    """The table of one file."""
    from genus.report.table import render, surface_rows

    rows = surface_rows(described)
    if described["polygons"] != described["faces"]:
        rows.insert(0, ("polygons", str(described["polygons"])))
    if described["vertices"] > 0:
        v, e, f = (described[key] for key in ("vertices", "edges", "faces"))
        ratios = f"{f / v:.3f} faces, {e / v:.3f} edges, valence {described['mean_valence']:.3f}"
        rows.append(("per vertex", ratios))
    if not described["defects"]:
        rows.append(("defects", "none"))
    for defect in described["defects"]:
        count = f"{defect['count']}{' or more' if defect['more'] else ''}"
        rows.append(("defect", f"{count} x {defect['kind']}, first: {defect['first']}"))
    print(path)
    print(render(rows))
