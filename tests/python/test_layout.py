"""Walls of the house: what may include what, and papers that are cited exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "core" / "genus"
SOURCES = sorted([*CORE.rglob("*.h"), *CORE.rglob("*.cpp")])

# A folder includes only folders above it.
ORDER = [
    "base", "polygon", "mesh", "patch", "deform", "implicit", "volume", "boolean", "model",
    "render", "io", "language",
]  # fmt: skip

# Python modules lower down may import those above.
PYTHON_ORDER = ["", "_core", "notebook", "report", "cli"]


def includes(source: Path) -> list[str]:
    return re.findall(r'^#include "([^"]+)"', source.read_text(), re.MULTILINE)


def test_every_folder_of_core_has_its_place():
    assert {p.name for p in CORE.iterdir() if p.is_dir() and any(p.iterdir())} <= set(ORDER)
    assert len(SOURCES) > 50


@pytest.mark.parametrize("folder", ORDER)
def test_a_folder_includes_only_folders_above_it(folder):
    above = ORDER[: ORDER.index(folder) + 1]
    wrong = [
        f"{source.relative_to(ROOT)} includes {name}"
        for source in SOURCES
        if source.relative_to(CORE).parts[0] == folder
        for name in includes(source)
        if not name.startswith("genus/") or name.split("/")[1] not in above
    ]
    assert wrong == []


def test_a_folder_names_all_the_folders_it_uses():
    """What CMake links a folder's tests with is what its sources include, headers followed."""
    for listing in CORE.glob("*/CMakeLists.txt"):
        folder = listing.parent.name
        uses = re.search(r"USES\s+([\w\s]+)\)", listing.read_text())
        declared = set(uses.group(1).split()) if uses else set()
        own = [s for s in SOURCES if s.parent.name == folder]
        direct = {name.split("/")[1] for source in own for name in includes(source)} - {folder}
        assert direct <= declared, folder


def test_cited_papers_are_in_the_bibliography():
    keys = set(re.findall(r"^@\w+\{(\w+),", (ROOT / "core/references.bib").read_text(), re.M))
    cited: dict[str, str] = {}
    for source in SOURCES:
        for block in re.findall(r"Implements\b(?:[^.]|\.\w)*", source.read_text()):
            for key in re.findall(r"\[([a-z]\w+\d{4}\w?)\]", block):
                cited[key] = source.name
    assert len(cited) > 10
    assert {k: v for k, v in cited.items() if k not in keys} == {}


def test_no_key_is_in_the_bibliography_twice():
    keys = re.findall(r"^@\w+\{(\w+),", (ROOT / "core/references.bib").read_text(), re.M)
    assert sorted(set(keys)) == sorted(keys)


def test_python_modules_import_only_those_above():
    package = ROOT / "python" / "genus"
    wrong = []
    for source in package.rglob("*.py"):
        parts = source.relative_to(package).with_suffix("").parts
        own = parts[0] if parts[0] in PYTHON_ORDER else ""
        if parts[0] == "__main__":
            continue  # the door into the command line
        for name in re.findall(r"(?:from|import) genus\.(\w+)", source.read_text()):
            if PYTHON_ORDER.index(name) > max(PYTHON_ORDER.index(own), 1):
                wrong.append(f"{source.name} imports {name}")
    assert wrong == []


def test_core_neither_prints_nor_exits():
    bad = re.compile(r"std::(cout|cerr|clog|exit|abort|quick_exit)\b|\b(printf|puts|perror)\(")
    lines = [
        f"{source.relative_to(ROOT)}: {line.strip()}"
        for source in SOURCES
        for line in source.read_text().splitlines()
        if bad.search(line) and not line.lstrip().startswith("//")
    ]
    assert lines == []
