"""Modelica, by the compiler Rumoca and its own solvers; there is no standard library beside it."""

from __future__ import annotations

from pathlib import Path

import rumoca
from scipy.interpolate import CubicSpline

from .cases import UNTIL, road

VERSION = f"Rumoca {rumoca.version()}"
TEXTS = Path(__file__).parent / "mo"
BEST = rumoca.SimConfig(solver="rk-like", rtol=1e-12, atol=1e-14)


def _case(name: str, states: str, means: str, kink: str = "–") -> tuple:
    file, columns = TEXTS / f"{name}.mo", states.split()

    def prepare(way: str):
        text = file.read_text(encoding="utf-8")
        if "DATA" in text:
            rows = CubicSpline(*road()).c.T.tolist()
            data = ", ".join("{" + ", ".join(map(repr, row)) + "}" for row in rows)
            text = text.replace("DATA", data)
        model = rumoca.Session().loads(text, model=name)
        config = None if way == "default" else BEST

        def go():
            found = model.simulate(t=(0, UNTIL[name]), dt=UNTIL[name], config=config)
            return [found[x][-1] for x in columns]

        return go

    return prepare, (file,), means, kink


CASES = {
    "wind": _case("wind", "hip knee dhip dknee", "equations by hand"),
    "springs": _case("springs", "x v", "if", "located by itself"),
    "road": _case("road", "z w dz dw", "function, coefficients", "crossed silently"),
    "arm": _case("arm", "a b da db", "when sample", "stops by itself"),
    "motors": _case(
        "motors",
        "left.shaft.phi right.shaft.phi left.w right.w",
        "component twice, connect",
    ),
}
