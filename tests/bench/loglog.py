"""Curves of the benchmarks, both axes logarithmic."""

from __future__ import annotations

from collections.abc import Sequence

Curve = tuple[str, str, Sequence[float], Sequence[float]]  # label, style, x, y


def loglog(path: str, curves: Sequence[Curve], *, title: str, x: str, y: str) -> None:
    """Draws the curves into a picture file."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.6, 3.6), dpi=110)
    for label, style, across, up in curves:
        axes.loglog(list(across), list(up), style, label=label, markersize=4)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10)
    axes.grid(True, which="both", alpha=0.25)
    axes.legend(frameon=False, fontsize=9)
    figure.tight_layout()
    figure.savefig(path)
