"""Text tables for people; the numbers in them are plain dicts and lists."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


class MeshReport(dict[str, Any]):
    """What a mesh is and what the call that made it reached.

    A dict of plain values, ready for JSON; as text, a table.
    """

    def __str__(self) -> str:
        return render([*surface_rows(self), *call_rows(self)])


def render(rows: Iterable[tuple[str, str]], indent: str = "  ") -> str:
    """Two columns, the first as wide as its longest entry."""
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join(f"{indent}{name:<{width}}  {value}".rstrip() for name, value in rows)


def columns(header: Sequence[str], rows: Iterable[Sequence[str]], indent: str = "  ") -> str:
    """Any number of right-aligned columns under a header."""
    table = [list(header), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in table) for i in range(len(header))]
    lines = (
        "  ".join(f"{cell:>{w}}" for cell, w in zip(row, widths, strict=True)) for row in table
    )
    return "\n".join(indent + line for line in lines)


def number(value: float) -> str:
    """Six digits, enough to compare by eye."""
    return f"{value:.6g}"


def surface_rows(r: dict[str, Any]) -> list[tuple[str, str]]:
    """Size, topology and measures."""
    size = [high - low for low, high in zip(*r["bounds"], strict=True)] if r["bounds"] else []
    state = [
        "closed" if r["closed"] else f"open, {r['boundary_loops']} boundary loops",
        "oriented" if r["oriented"] else "not oriented",
        "manifold" if r["manifold"] else "not manifold",
    ]
    euler = f"{r['vertices']} - {r['edges']} + {r['faces']} = {r['euler']}"
    return [
        ("triangles", f"{r['faces']}"),
        ("V - E + F", euler),
        ("genus", "undefined" if r["genus"] is None else str(r["genus"])),
        ("components", str(r["components"])),
        ("surface", ", ".join(state)),
        ("size", " x ".join(number(s) for s in size) or "empty"),
        ("volume", number(r["volume"])),
        ("area", number(r["area"])),
    ]


def call_rows(r: dict[str, Any]) -> list[tuple[str, str]]:
    """Error and time of the call that made the mesh; nothing for a mesh that was loaded."""
    if "error" not in r:
        return []
    error = r["error"]
    kind = "certified" if error["certified"] else "estimated"
    rows = [
        ("method", r["method"]),
        ("tolerance", number(r["tolerance"])),
        ("error bound", f"{number(error['bound'])}  {kind}"),
    ]
    rows += [(f"  {cause}", number(share)) for cause, share in error["parts"].items()]
    if error.get("doubt"):
        rows.append(("  not proven", error["doubt"]))
    if error["measured"] is not None:
        rows.append(("error measured", number(error["measured"])))
    rows.append(("seconds", f"{r['seconds']['total']:.3f}"))
    rows += [(f"  {stage}", f"{s:.3f}") for stage, s in r["seconds"].items() if stage != "total"]
    return rows
