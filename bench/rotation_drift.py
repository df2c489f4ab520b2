"""What many steps leave of what a rigid body keeps: energy, angular momentum, unit length.

A row a method: its step or tolerance; µs a step and a second of motion, so that methods can be
compared at what they cost; and the largest change at ROWS times of a million steps (of SciPy's
fewer), of the energy beside the largest kinetic energy, of L beside its length: the vector where
nothing turns the body, else its vertical part. All from the rows alone, by the same lines for
all. Rows of pkgen's methods are those of `pkgen run`, its times those of the methods alone.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from . import tables
from .attitudes import angles_to_quaternion
from .builds import Broken, Unavailable
from .peers import forms, quaternion
from .peers.own import pkgen_python
from .rotation_cases import INERTIA, ROOT, TOP, Case, Form

STEPS, FEWER, QUICK = 1_000_000, 100_000, 20_000
ROWS = 1000
SHORT = 2000  # steps to be timed
HEAD = ("after", "step, tolerance", "steps", "µs a step", "a second", "energy", "L", "length")
# Of each motion: a scene without events to be watched, and a step for all methods of fixed ones.
SCENE = {"heavy top": "reference", "free body": "tumbling"}
STEP = {"heavy top": 0.01, "free body": 0.05}
TOLERANCE, TIGHTEST = 1e-12, 1e-15
FIXED = ("lie_midpoint", "lie_midpoint4", "lie_midpoint6", "gauss4", "rkmk4", "rkmk8")


@dataclass(frozen=True)
class Run:
    method: str
    setting: str
    steps: int
    each: float  # seconds a step
    until: float
    states: np.ndarray  # a row a time: quaternion, body rates

    def cells(self, case: Case) -> tuple[str, ...]:
        energy, momentum, length = kept(case, self.states)
        return (
            self.method,
            self.setting,
            f"{self.steps:.1e}",
            f"{1e6 * self.each:.2g}",
            f"{1e6 * self.each * self.steps / self.until:.3g}",
            *(f"{x:.1e}" for x in (energy, momentum, length)),
        )


def drifts(case: Case, steps: int = STEPS) -> str:
    rows = []
    for run in (*of_pkgen(case, steps), *of_peers(case, steps)):
        rows.append(run.cells(case))
        print(" | ".join(rows[-1]), file=sys.stderr, flush=True)
    return tables.table(HEAD, rows)


def kept(case: Case, states: np.ndarray) -> tuple[float, float, float]:
    top = case.name == "heavy top"
    inertia = np.array((TOP["I1"], TOP["I1"], TOP["I3"]) if top else INERTIA)
    w, x, y, z, *rates = states.T
    rates = np.array(rates)
    rows = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    kinetic = (inertia[:, None] * rates**2).sum(axis=0) / 2
    energy = kinetic + (TOP["Mgl"] * rows[2, 2] if top else 0)
    momentum = np.einsum("ijt,jt->it", rows, inertia[:, None] * rates)
    size = np.linalg.norm(momentum, axis=0).max()
    moved = momentum - momentum[:, :1]
    moved = abs(moved[2]) if top else np.linalg.norm(moved, axis=0)
    return (
        float(abs(energy - energy[0]).max() / kinetic.max()),
        float(moved.max() / size),
        float(abs(np.sqrt(w * w + x * x + y * y + z * z) - 1).max()),
    )


def of_pkgen(case: Case, steps: int) -> Iterator[Run]:
    h = STEP[case.name]
    for method in FIXED:
        each, _ = timed(case, method, h, SHORT * h)
        yield pkgen(case, method, ("--step", h), f"h = {h}", h * steps, each)
    for method, tolerance in (("dop853", TOLERANCE), ("gauss", TOLERANCE), ("gauss", TIGHTEST)):
        each, pilot = timed(case, method, tolerance, case.t_end)
        options = ("--rtol", tolerance, "--atol", tolerance)
        until = round(steps / pilot * case.t_end)
        yield pkgen(case, method, options, f"{tolerance:.0e}", until, each)


def timed(case: Case, method: str, setting: float, until: float) -> tuple[float, float]:
    """Seconds a step, and the steps."""
    session = forms.opened(_form(case), method, case, ())[0]
    seconds, _ = session.integrate(setting, case.start, until, 0.05)
    session.close()
    steps, _ = session.took[setting]
    return seconds / steps, steps


def _form(case: Case) -> Form:
    return next(form for form in case.forms if form.name == "rotation")


def pkgen(case: Case, method: str, options: tuple, setting: str, until: float, each: float) -> Run:
    """From the start of the case; what the scene expects of its own is missed (exit code 4)."""
    columns = [f"R.{a}" for a in "wxyz"] + [f"omega(R).{a}" for a in "xyz"]
    start = zip(columns, angles_to_quaternion(case.start), strict=True)
    words = ["run", _form(case).path, "--scene", SCENE[case.name], "--record", ",".join(columns)]
    words += [word for name, x in start for word in ("--start", f"{name}={x!r}")]
    words += ["--method", method, *options, "--until", repr(until), "--every", repr(until / ROWS)]
    command = [pkgen_python(), "-m", "pkgen", *map(str, words), "--json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        raise Broken(f"{method}: {done.stdout[:300]}{done.stderr[:300]}")
    told = json.loads(done.stdout)
    if told["report"]["status"] != "PK_DONE":
        raise Broken(f"{method}: {told['report']['reason']}")
    states = np.array(told["rows"])[:, 1:]
    return Run(f"rotation: {method}", setting, told["report"]["steps"], each, until, states)


def of_peers(case: Case, steps: int) -> Iterator[Run]:
    start = angles_to_quaternion(case.start)
    try:
        yield heyoka(case, start, TOLERANCE, steps)
        yield heyoka(case, start, TIGHTEST, steps)
    except ImportError:
        print("drift: heyoka is not installed", file=sys.stderr)
    try:
        yield scipy(case, start, min(steps, FEWER))
    except (ImportError, Unavailable) as reason:
        print(f"drift: SciPy: {reason}", file=sys.stderr)


def heyoka(case: Case, start, tolerance: float, steps: int) -> Run:
    integrator = quaternion.taylor(case, start, tolerance)
    until = round(steps / integrator.propagate_until(case.t_end)[3] * case.t_end)
    integrator.time, integrator.state[:] = 0.0, start
    begin = time.perf_counter()
    found = integrator.propagate_grid(list(np.linspace(0, until, ROWS + 1)))
    seconds = time.perf_counter() - begin
    setting = f"{tolerance:.0e}"
    return Run("by hand: heyoka", setting, found[3], seconds / found[3], until, np.array(found[-1]))


def scipy(case: Case, start, steps: int) -> Run:
    """numba's right-hand side; rows are the ends of steps."""
    from scipy.integrate import solve_ivp

    f = quaternion.right_hand_side(case, True)
    options = {"method": "DOP853", "rtol": TOLERANCE, "atol": TOLERANCE}
    pilot = solve_ivp(f, (0, case.t_end), start, **options)
    until = round(steps / (pilot.t.size - 1) * case.t_end)
    begin = time.perf_counter()
    found = solve_ivp(f, (0, until), start, **options)
    seconds = time.perf_counter() - begin
    method, taken = "by hand: SciPy DOP853 + numba", found.t.size - 1
    return Run(method, f"{TOLERANCE:.0e}", taken, seconds / taken, until, found.y.T)
