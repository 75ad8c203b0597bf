"""What the benchmarks share: peers that may be missing, and CPU seconds of a call."""

from __future__ import annotations

import importlib
import math
import sys
import time
from collections.abc import Callable
from typing import Any

Call = Callable[[], Any]


def optional(name: str) -> Any:
    """The module, None with a note if it is not there."""
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: its columns are left out", file=sys.stderr)
        return None


def cpu_seconds(call: Call, repeats: int = 3, enough: float = math.inf) -> tuple[float, Any]:
    """Of the fastest run, all threads added, and its result; no further run after `enough` s."""
    best, spent, result = math.inf, 0.0, None
    for _ in range(repeats):
        result = None  # not two results at a time
        start = time.process_time()
        result = call()
        seconds = time.process_time() - start
        best, spent = min(best, seconds), spent + seconds
        if spent >= enough:
            break
    return best, result
