"""The table of short-forces.md: what is seen of a force whose width is a small part of a step.

    PKGEN=.venv/bin/pkgen build/bench/venv/bin/python -m bench.short_forces

SciPy and heyoka get the same equations at the same tolerance, 1e-10, and their default steps; of
constraints, whose equations are those of the held coordinate, pkgen's alone are run. The right ends
are closed forms, quadratures, and for ramps SciPy's DOP853 by steps of a quarter of the width.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import tempfile
from pathlib import Path

import heyoka as hy
import numpy as np
from scipy.integrate import quad, solve_ivp

TOLERANCE, END, WRONG, STEP = 1e-10, 10.0, 1e-4, "0.01"
WIDTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
PENDULUM = (
    "kinetic ((X' + cos(a)*a')^2 + (sin(a)*a')^2)/2 + X'^2/2\npotential -9.81*cos(a)\n"
    "start a = 0.5\n"
)
MODELS = {
    "time pulse": "coord x\nkinetic x'^2/2\nforce x = exp(-((t - 5.3)/w)^2)/w/sqrt(pi)\n"
    "scene s\n  record x, x'",
    "space barrier": "coord x\nkinetic x'^2/2\npotential 0.8*exp(-((x - 3.3)/w)^2)\n"
    "start x' = 1\nscene s\n  record x, x'",
    "ramp, held": f"coord a, X\n{PENDULUM}scene s\n  hold X = tanh((t - 5.2)/w)/2\n  record a, a'",
    "ramp, constraint": f"coord a, X\n{PENDULUM}start X = -0.5\n"
    "constraint c: X = tanh((t - 5.2)/w)/2\nscene s\n  record a, a'",
}
STEADY = solve_ivp(
    lambda t, y: (y[1], -9.81 * np.sin(y[0])), (0, END), (0.5, 0.0), rtol=1e-10, atol=1e-10
).y[:, -1]
WITHOUT = {"time pulse": (0.0, 0.0), "space barrier": (END, 1.0)}
STARTS = {"time pulse": (0.0, 0.0), "space barrier": (0.0, 1.0), "ramp, held": (0.5, 0.0)}


def force(name: str, f, w: float):
    """The acceleration, of functions of numpy or heyoka."""
    if name == "time pulse":
        return lambda t, x, _: f.exp(-(((t - 5.3) / w) ** 2)) / (w * math.sqrt(math.pi))
    if name == "space barrier":
        return lambda t, x, _: 1.6 * (x - 3.3) / w**2 * f.exp(-(((x - 3.3) / w) ** 2))

    def pendulum(t, a, _):
        s = f.tanh((t - 5.2) / w)
        return f.cos(a) * s * (1 - s * s) / w**2 - 9.81 * f.sin(a)

    return pendulum


def scipy(name: str, w: float, method: str, y=None, span=(0.0, END), rtol=TOLERANCE, **more):
    a = force(name, np, w)
    y = STARTS[name] if y is None else y
    slope = lambda t, y: (y[1], a(t, *y))  # noqa: E731
    return solve_ivp(slope, span, y, method=method, rtol=rtol, atol=rtol, **more).y[:, -1]


def heyoka(name: str, w: float):
    x, v = hy.make_vars("x", "v")
    system = [(x, v), (v, force(name, hy, w)(hy.time, x, v))]
    it = hy.taylor_adaptive(system, list(STARTS[name]), tol=TOLERANCE)
    it.propagate_until(END)
    return it.state


def pkgen(name: str, w: float, *more: str) -> tuple[list[float], bool]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "m.lag")
        path.write_text(f"model m\nparam w = {w}\n{MODELS[name]}\n  until {END}\nend\n")
        command = [os.environ.get("PKGEN", "pkgen"), "run", path, "--scene", "s", "--json"]
        done = subprocess.run([*command, "--every", "10", *more], capture_output=True, text=True)
    found = json.loads(done.stdout)
    return found["rows"][-1][1:3], bool(found["report"]["passed_over"])


def right(name: str, w: float):
    if name == "time pulse":
        return END - 5.3, 1.0
    if name == "space barrier":  # turned back; s = turn + k^2 takes the root away
        turn = math.sqrt(math.log(1.6))
        slow, _ = quad(
            lambda k: 2 * k / math.sqrt(abs(1 - 1.6 * math.exp(-((turn + k * k) ** 2)))),
            1e-9,
            math.sqrt(9 - turn),
        )
        return 3.3 - 9 * w - (END - (3.3 - 9 * w) - 2 * w * slow), -1.0
    y, legs = None, ((0, 5.2 - 20 * w, np.inf), (5.2 - 20 * w, 5.2 + 20 * w, w / 4))
    for begin, end, step in (*legs, (5.2 + 20 * w, END, np.inf)):
        y = scipy("ramp, held", w, "DOP853", y, (begin, end), 1e-13, max_step=step)
    return y


def word(found, true, without, warned: bool = False) -> str:
    """Whether the end is right, or that of a motion without the force, or neither."""
    error, as_without = (
        max(abs(a - b) / max(1, abs(b)) for a, b in zip(found, end, strict=True))
        for end in (true, without)
    )
    silent = "**missed**" if as_without < 1e-2 else "**inexact**"
    return "seen" if error < WRONG else "warned of" if warned else silent


def main() -> None:
    peers = {
        "heyoka": heyoka,
        "SciPy DOP853": lambda name, w: scipy(name, w, "DOP853"),
        "SciPy LSODA": lambda name, w: scipy(name, w, "LSODA"),
    }
    own = {
        "gauss": (),
        "dop853": ("--method", "dop853"),
        f"rk4, step {STEP}": ("--method", "rk4", "--step", STEP),
    }
    print("| | width |", " | ".join((*own, *peers)), "|\n|---|---|" + "---|" * 6)
    for name in MODELS:
        for w in WIDTHS:
            true, without = right(name, w), WITHOUT.get(name, STEADY)
            cells = []
            for more in own.values():
                found, warned = pkgen(name, w, *more)
                cells.append(word(found, true, without, warned))
            cells += [
                word(f(name, w), true, without) if name in STARTS else "" for f in peers.values()
            ]
            print(f"| {name} | {w:.0e} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
