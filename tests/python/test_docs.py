"""Examples in docstrings, in README.md and in CONTRIBUTING.md run and give what they show."""

import doctest
import re
import shutil
import subprocess
import sys

import genus
import pytest
from genus import _core


def documented():
    """Every docstring with an example: name and text."""
    objects = {name: getattr(_core, name) for name in dir(_core) if not name.startswith("_")}
    for cls in [o for o in objects.values() if isinstance(o, type)]:
        objects |= {f"{cls.__name__}.{n}": o for n, o in vars(cls).items() if not n.startswith("_")}
    texts = {name: o.__doc__ or "" for name, o in objects.items()}
    texts["genus"] = genus.__doc__
    return {name: text for name, text in texts.items() if ">>>" in text}


@pytest.mark.parametrize("name", documented())
def test_examples_of_docstrings(name, tmp_path, monkeypatch, models):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(models, tmp_path / "models")
    example = doctest.DocTestParser().get_doctest(
        documented()[name], {"genus": genus}, name, None, 0
    )
    report: list[str] = []
    doctest.DocTestRunner().run(example, out=report.append)
    assert report == []


def blocks(path, language) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(), re.M | re.S)


def test_python_of_the_readme(root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(root / "models", tmp_path / "models")
    examples = blocks(root / "README.md", "python")
    assert examples
    names = {}
    for example in examples:
        exec(compile(example, "README.md", "exec"), names)


def test_commands_of_the_readme(root, tmp_path):
    shutil.copytree(root / "models", tmp_path / "models")
    for name, text in zip(
        re.findall(r"^`(\w+\.scad)`:$", (root / "README.md").read_text(), re.M),
        blocks(root / "README.md", "openscad"),
        strict=True,
    ):
        (tmp_path / name).write_text(text)
    commands = [
        line
        for block in blocks(root / "README.md", "sh")
        for line in block.splitlines()
        if line.startswith("genus ")
    ]
    assert commands
    for command in commands:
        arguments = [sys.executable, "-m", *command.partition("#")[0].split()]
        result = subprocess.run(arguments, cwd=tmp_path, capture_output=True, text=True)
        assert result.returncode == 0, f"{command}: {result.stderr}"


def test_files_that_the_docs_name_exist(root):
    for page in ("README.md", "CONTRIBUTING.md"):
        text = (root / page).read_text()
        for link in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (root / link).exists(), f"{page}: {link}"
