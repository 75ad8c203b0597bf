"""Fixtures shared by all Python tests."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "models"


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def models() -> Path:
    return MODELS


@pytest.fixture(scope="session")
def part_of():
    """The solid of a model's Python script, by the model's name."""

    def part(name: str):
        spec = importlib.util.spec_from_file_location(f"model_{name}", MODELS / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.part()

    return part


@pytest.fixture
def run(tmp_path):
    """Runs the command line in a folder of its own; gives status, stdout and stderr."""

    def command(*arguments, **options) -> subprocess.CompletedProcess:
        return subprocess.run(
            [sys.executable, "-m", "genus", *map(str, arguments)],
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
            timeout=120,
            cwd=options.pop("cwd", tmp_path),
            **options,
        )

    return command
