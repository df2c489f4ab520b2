"""`python -m bench.world.measure PACKAGE`: one package in its own Python, as JSON on the output.

Of each model and way to run it: the CPU time of its set-up (compilers too), that of the run, the
shortest of several, and the final state. An adapter has VERSION, MODELS: {model: f(way) -> run},
WAYS: {model: ways}, COUNTED: {model: functions, texts and files whose lines a user writes},
SAYS: {model: (means, what happens at the kink)}.
"""

from __future__ import annotations

import importlib
import inspect
import json
import resource
import sys
import time
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


def run(package, model: str, way: str) -> dict:
    begin = _cpu()
    go = package.MODELS[model](way)
    found = [float(x) for x in go()]  # the first run compiles what waits for it
    setup, times, inner = _cpu() - begin, [], []
    while not times or (sum(times) < BUDGET and len(times) < 50):
        begin = _cpu()
        found = [float(x) for x in go()]
        times.append(_cpu() - begin)
        inner += [go.seconds] if hasattr(go, "seconds") else []
    seconds = min(inner or times)
    return {"setup": max(0.0, setup - min(times)), "seconds": seconds, "call": min(times), "end": found}


def main(name: str, models: list[str]) -> None:
    package = importlib.import_module(f".{name}", __package__)
    told: dict = {"version": package.VERSION, "models": {}}
    for model in models:
        means, kink = package.SAYS[model]
        here = told["models"][model] = {"means": means, "kink": kink, "ways": {}}
        if model in package.MODELS:
            here["lines"] = lines(package.COUNTED[model])
            for way in package.WAYS[model]:
                here["ways"][way] = run(package, model, way)
    print(json.dumps(told))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
