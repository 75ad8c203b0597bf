"""The frame of a run over random cases."""

from __future__ import annotations

import argparse
from collections.abc import Callable


def run_rounds(try_seed: Callable[[int], str], description: str, rounds: int, wrong: str) -> int:
    """Tries seed after seed, prints how often each outcome came; 1 if any was `wrong`."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=rounds)
    parser.add_argument("--first", type=int, default=0)
    args = parser.parse_args()
    counts: dict[str, int] = {}
    for seed in range(args.first, args.first + args.rounds):
        kind = try_seed(seed)
        counts[kind] = counts.get(kind, 0) + 1
    for kind, count in sorted(counts.items()):
        print(f"{count:8d}  {kind}")
    return 1 if counts.get(wrong) else 0
