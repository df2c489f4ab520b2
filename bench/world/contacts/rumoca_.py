"""Modelica by Rumoca: `when` and `reinit`; where a motion comes to rest, a state says so."""

from __future__ import annotations

from pathlib import Path

import rumoca

from ..rumoca_ import BEST, VERSION  # noqa: F401
from .cases import LESS, OVER, TIMES
from .cases import __file__ as here

BDF = rumoca.SimConfig(solver="bdf", rtol=1e-12, atol=1e-14)


def _case(name: str, columns: str, means: str, says: str, runs=({},), best=BEST, dt=None) -> tuple:
    file, columns, step = (
        Path(here).parent / f"mo/{name}.mo",
        columns.split(),
        0.1 if name == "ball" else 0.5,
    )

    def prepare(way: str):
        model = rumoca.Session().loads(file.read_text(encoding="utf-8"), model=name)
        config, times = None if way == "default" else best, TIMES[name]
        every = dt if dt and way == "best" else step

        def go():
            end = []
            for params in runs:
                found = model.simulate(t=(0, times[-1]), dt=every, config=config, params=params)
                for t in times:  # the last of the rows at t, those of events among them
                    row = max(i for i, x in enumerate(found.time) if abs(x - t) < 1e-9)
                    end += [found[c][row] for c in columns]
            return end

        return go

    return prepare, (file,), means, says


STOPS, SLOPES = ({"less": LESS}, {"less": -LESS}), ({"over": -OVER}, {"over": OVER})
X, V = "x1 x2 x3 x4 x5 ", "v1 v2 v3 v4 v5"
CASES = {
    "ball": _case(
        "ball",
        "y v",
        "when, reinit, own state of rest",
        "falls through; own rule of rest",
        best=BDF,
    ),
    "cradle": _case("cradle", X + V, "when, reinit", "one by one, by own rule"),
    "rock": _case("rock", "a w", "when, reinit, own state of rest", "own rule of rest"),
    "box": _case("box", "x v", "when, own state of slip", "own rule of stick", SLOPES),
    "belt": _case("belt", "x v", "when, own state of slip", "own rule of stick"),
    "graze": _case(
        "graze", "x v", "when, reinit", "passed silently / steps of 1 ms", STOPS, dt=1e-3
    ),
}
