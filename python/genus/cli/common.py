"""What the commands share: arguments that are checked, text files written whole, progress."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from genus import mesh_formats

if TYPE_CHECKING:
    from tqdm import tqdm

MESH_FORMATS = tuple(mesh_formats())
# Extensions of surface meshes that meshio reads and writes and core does not.
FURTHER_FORMATS = ("vtk", "vtu", "mesh", "msh", "inp", "bdf", "nas", "su2", "xdmf", "avs", "tec")


def positive(text: str) -> float:
    """A finite number above zero."""
    value = finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not above zero")
    return value


def finite(text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a finite number")
    return value


def extension(path: str) -> str:
    """What follows the last dot of the file's name, in lower case."""
    return os.path.splitext(path)[1].lstrip(".").lower()


def write_text(path: str, text: str) -> None:
    """Write a file whole or not at all."""
    partial = f"{path}.{os.getpid()}.part"
    try:
        with open(partial, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
        os.replace(partial, path)
    except BaseException as error:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(partial)
        if isinstance(error, OSError):
            error.filename = path  # the name the user gave, not that of the passing file
        raise


class Progress:
    """A bar on standard error, drawn only if the call is still running after half a second."""

    patience = 0.5

    def __init__(self) -> None:
        """Start counting."""
        self._start = time.monotonic()
        self._bar: tqdm[Any] | None = None

    def __call__(self, stage: str, done: float) -> None:
        """Show how much of the stage is done."""
        if self._bar is None:
            if time.monotonic() - self._start < self.patience:
                return
            import shutil

            from tqdm import tqdm

            self._bar = tqdm(
                total=100,
                # Some terminals give their size as 0, in which tqdm draws nothing.
                ncols=min(shutil.get_terminal_size().columns, 80),
                nrows=shutil.get_terminal_size().lines,
                leave=False,
                file=sys.stderr,
                bar_format="{desc} {percentage:3.0f}% {bar}",
            )
        self._bar.set_description_str(stage, refresh=False)
        self._bar.n = round(100 * done)
        self._bar.refresh()

    def close(self) -> None:
        """Remove the bar."""
        if self._bar is not None:
            self._bar.close()


@contextlib.contextmanager
def progress() -> Iterator[Progress | None]:
    """The bar on a terminal, None in a pipe."""
    if not sys.stderr.isatty():
        yield None
        return
    bar = Progress()
    try:
        yield bar
    finally:
        bar.close()
