"""Measures long runs: the drift of each constant by each fixed-step method in 10, 100, ... steps.

All methods have the same step size, a fraction of the shortest period. A run of 10^k steps is like
a run of `pkgen run`, which finds how the drift grows with time (pk/diagnostics.h): bounded, or like
sqrt(t), t or t^2. The number of steps of a method is increased until the next run would take more
than the method's share of the time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from ...compiler import Compilation
from ...record import record
from ...run.build import build_library
from ...run.settings import Settings
from ...system import children
from ...system.exits import NumericsFailed, UsageError
from ...system.progress import Show
from . import spectrum
from .measure import Program
from .points import ChartedMethod
from .reference import PRECISE, best
from .sweep import Effort

PERIOD = 32  # number of steps in one period of the fastest oscillation
SAFE = 0.5  # largest step size, relative to the smallest stability limit
DECADES = range(1, 8)
LEAST = 0.1  # every method may take at least these seconds


@record
class Decade:
    steps: int
    t: float
    seconds: float
    status: str
    drifts: dict[str, float]


@record
class Drifting:
    """The runs of a method within its share of the time. For each constant of motion, `growth` (in
    words) and `exponents` (of t) describe how the drift grows with time in the longest run."""

    method: ChartedMethod
    decades: tuple[Decade, ...]
    growth: dict[str, str]
    exponents: dict[str, float | None]
    reason: str = ""  # why longer runs are missing


@record
class Long:
    model: str
    unit: str
    step: float
    drifting: list[Drifting]
    refused: dict[str, str]

    @property
    def constants(self) -> list[str]:
        longest = max((d.decades for d in self.drifting), key=len, default=())
        return list(longest[0].drifts) if longest else []


def measure(
    compilation: Compilation,
    settings: Settings,
    chosen: list[ChartedMethod],
    effort: Effort,
    step: float | None,
    show: Show,
) -> Long:
    """Measures the drifts of the model's constants of motion. Raises NumericsFailed if there is no
    constant, or if no method can run."""
    name = compilation.model.name
    fixed = [m for m in chosen if m.fixed and "exact" not in m.flags]
    show(0.0, "compiling")
    if not fixed:
        raise UsageError("--long follows methods with fixed steps, and --methods names none")
    own = compilation.model.methods
    path = build_library(compilation.files, name, *(m.name for m in fixed), able=PRECISE, own=own)
    program = Program(path, settings, own)
    if step is None:
        follower = best(compilation.structure)
        found = spectrum.find(program, follower, settings.until, False)
        limits = [limit for m in fixed if (limit := found.limit(m))]
        step = min(2 * math.pi / found.fastest / PERIOD, SAFE * min(limits, default=math.inf))
        step = float(f"{step:.2g}")

    def lasting(until: float) -> Program:
        return Program(path, replace(settings, until=until, every=None), own)

    drifting, refused = [], {}
    with suppress(KeyboardInterrupt):  # after Ctrl-C, the methods measured so far are returned
        for k, method in enumerate(fixed):
            show(k / len(fixed), method.name)
            share = effort.left() / (len(fixed) - k)
            one = _decades(lasting, method, step, share)
            if one.decades:
                drifting.append(one)
            else:
                refused[method.name] = one.reason
    if not drifting:
        if children.ended():
            raise KeyboardInterrupt
        raise NumericsFailed(f"no method with fixed steps runs: {next(iter(refused.values()), '')}")
    long = Long(name, "" if compilation.model.dimensionless else "s", step, drifting, refused)
    if not long.constants:
        raise NumericsFailed(f"{name} has no constant of the motion whose drift could be followed")
    return long


def _decades(
    program: Callable[[float], Program], method: ChartedMethod, step: float, share: float
) -> Drifting:
    found: list[Decade] = []
    drifts: list[dict] = []
    reason = ""
    for decade in DECADES:
        if found and 10 * found[-1].seconds > share:
            reason = f"the next decade would take some {10 * found[-1].seconds:.2g} s (--seconds)"
            break
        steps = 10**decade
        told = program(steps * step).run(method.name, step, bare=1, cap=max(share, LEAST)).report
        if told["status"] == "PK_REFUSED":
            return Drifting(method, (), {}, {}, told["reason"])
        if told["slow"]:
            reason = f"{steps} steps take more than {max(share, LEAST):.2g} s (--seconds)"
            break
        drifts = told["drifts"]
        largest = {d["name"]: math.inf if d["max"] is None else float(d["max"]) for d in drifts}
        found.append(Decade(steps, told["t"], told["processor"], told["status"], largest))
        if told["status"] != "PK_DONE":
            reason = told["reason"]
            break
    growth = {d["name"]: d["growth"] for d in drifts}
    exponents = {d["name"]: d.get("exponent") for d in drifts}
    return Drifting(method, tuple(found), growth, exponents, reason)
