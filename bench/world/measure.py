"""`python -m bench.world.measure PACKAGE`: one package in its own Python, as JSON on the output.

It has the CPU time of the set-up (compilers too), that of the run, the shortest of several, and the
final state, for each model and way to run it. A package's CASES have for each model a function of
the way, which returns the run; what a user writes (functions, texts, files); its means; what
happens at the kink. The ways are "default", "best" and, of ACROSS, "across": as best, but over the
kinks.
"""

from __future__ import annotations

import importlib
import inspect
import json
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

BUDGET = 2.0  # CPU seconds for the repetitions of a run


def _cpu() -> float:
    """Of this process and of the compilers that it has started."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def lines(parts: tuple) -> int:
    """Neither blank lines, comments and doc strings nor scenes and drawings of .lag files."""
    count, hidden = 0, False
    for part in parts:
        text = part.read_text(encoding="utf-8") if isinstance(part, Path) else part
        text = inspect.getsource(part) if callable(part) else text
        for line in filter(None, map(str.strip, text.splitlines())):
            word = line.split()[0]
            hidden |= isinstance(part, Path) and word == "scene"
            apart = word in ("draw", "view", "observe", "event") and isinstance(part, Path)
            count += not (hidden or apart or line.startswith(("#", '"""', "//")))
            hidden &= line != "end"
    return count


def run(prepare: Callable, way: str) -> dict:
    begin = _cpu()
    go = prepare(way)
    found = [float(x) for x in go()]  # the first run compiles what waits for it
    setup, times, inner = _cpu() - begin, [], []
    while not times or (sum(times) < BUDGET and len(times) < 50):
        begin = _cpu()
        found = [float(x) for x in go()]
        times.append(_cpu() - begin)
        inner += [go.seconds] if hasattr(go, "seconds") else []
    call, seconds = min(times), min(inner or times)
    return {"setup": max(0.0, setup - call), "seconds": seconds, "call": call, "end": found}


def main(name: str, model: str) -> None:
    package = importlib.import_module(f".{name}", __package__)
    prepare, counted, means, kink = package.CASES[model]
    getattr(package, "ready", lambda: None)()
    across = ["across"] if model in getattr(package, "ACROSS", ()) else []
    told = {"version": package.VERSION, "means": means, "kink": kink, "lines": lines(counted)}
    told["ways"] = {way: run(prepare, way) for way in ["default", *across, "best"]}
    print(json.dumps(told))


if __name__ == "__main__":
    main(*sys.argv[1:])
