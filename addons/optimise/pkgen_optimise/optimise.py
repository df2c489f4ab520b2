"""Finds the inputs, parameters, starts and the duration at which a motion is best."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy

from pkgen.api import arguments
from pkgen.api.arguments import in_words
from pkgen.api.model import Model
from pkgen.graph.graph import BIT, Kind
from pkgen.system.exits import UsageError

from .optimum import Optimum
from .shooting import SLOPE, Shooting
from .solve import SOLVERS, Programme, solved
from .wanted import INTEGRAL, Range, Wanted, checked, ranges, units

PIECES, ITERATIONS = 20, 300


def optimise(model: Model, minimise: str = "", **more: Any) -> Optimum:
    """Returns the motion at which the last value of the column `minimise` (or of `maximise`; "t" is
    the duration), plus the integral over time of the expression `integral`, is least.

    `inputs` and `free` have ranges (least, largest) of inputs and parameters by name, None for no
    end; inputs are constant in each of `pieces` pieces, or with `linear` linear there. `free_start`
    names starts that are free. `end` has values or ranges of columns at the end, `path` at the ends
    of all pieces. Columns `periodic` end as they start; {"theta": "after"}: theta starts where the
    column `after` ends. `until` is a duration or a range of it. `guess` has (first, last) values by
    name, between which the search begins. `solver` is "ipopt" or "slsqp", `iterations` their most.
    Other arguments are those of Model.run(). A local optimum is found.

    Raises UsageError, NumericsFailed."""
    with in_words():
        return optimised(model, minimise, **more)


def optimised(
    model: Model,
    minimise: str = "",
    *,
    maximise: str = "",
    integral: str = "",
    inputs: Mapping[str, Any] | None = None,
    free: Mapping[str, Any] | None = None,
    free_start: arguments.Names = (),
    end: Mapping[str, Any] | None = None,
    path: Mapping[str, Any] | None = None,
    periodic: arguments.Names | Mapping[str, str] = (),
    until: Any = None,
    pieces: int = PIECES,
    linear: bool = False,
    guess: Mapping[str, Any] | None = None,
    solver: str = "",
    iterations: int = ITERATIONS,
    **more: Any,
) -> Optimum:
    """Does the work of optimise(). Messages name options."""
    if minimise and maximise:
        raise UsageError("--minimise and --maximise: give one of them")
    if solver and solver not in SOLVERS:
        raise UsageError(f"--solver {solver}: {', '.join(SOLVERS)}")
    if not (minimise or maximise or integral):
        raise UsageError("--minimise: name a column, or give --integral")
    if integral:
        lines = f"state {INTEGRAL}\nrate {INTEGRAL} = {integral}\nstart {INTEGRAL} = 0\n"
        model = model.extended(lines, {})
    of = model.compilation
    wanted = Wanted(
        minimise or maximise,
        -1.0 if maximise else 1.0,
        bool(integral),
        ranges(of, "--input", inputs or {}, "input"),
        ranges(of, "--free", free or {}, "parameter"),
        tuple(arguments.several(free_start)),
        ranges(of, "--end", end or {}, "column"),
        ranges(of, "--path", path or {}, "column"),
        _pairs(periodic),
        _duration(of, until),
        pieces,
        linear,
    )
    guesses = ranges(of, "--guess", guess or {}, "quantity")
    return _found(model, checked(wanted, of), guesses, solver, iterations, more)


def _pairs(periodic: Any) -> dict[str, str]:
    if isinstance(periodic, Mapping):
        return dict(periodic)
    parts = [text.partition("=") for text in arguments.several(periodic)]
    return {name.strip(): (end or name).strip() for name, _, end in parts}


def _duration(of: Any, until: Any) -> Range:
    from pkgen.run.values import Values

    values = Values(of)
    ends = until.split(":") if isinstance(until, str) else until
    ends = list(ends) if isinstance(ends, list | tuple) else [ends]
    if until is None or len(ends) > 2:
        raise UsageError("--until: give a duration, or LOW:HIGH")
    numbers = [
        values.value("--until", x, values.time, "until") if isinstance(x, str) else float(x)
        for x in ends
    ]
    return numbers[0], numbers[-1]


def _found(
    model: Model,
    wanted: Wanted,
    guesses: dict[str, Range],
    solver: str,
    iterations: int,
    more: dict[str, Any],
) -> Optimum:
    inner, sets = model, []
    if wanted.linear and wanted.inputs:
        lines, of_unit = "", units(model.compilation)
        time = "" if model.compilation.model.dimensionless else "s"
        for name in wanted.inputs:
            unit = of_unit[name]
            rate = f" [{unit}/s]" if unit and time else f" [1/{time}]" if time else ""
            lines += f"param {name}_begin = 0{f' [{unit}]' if unit else ''}\n"
            lines += f"param {SLOPE.format(name)} = 0{rate}\n"
            sets.append(f"{name}={name}_begin + {SLOPE.format(name)}*t")
        inner = model.extended(lines, {})
    h = wanted.duration[1] / wanted.pieces
    options = arguments.options(inner, {**more, "until": h, "every": h})
    options.set += sets
    with warnings.catch_warnings():  # of lines that a scene alone uses
        warnings.simplefilter("ignore")
        prepared = inner.taped(options)
    _refuse_time(model)
    names = [*inner.coordinates, *inner.rates]
    start = dict(zip(names, map(float, inner.start), strict=True))
    start |= {k: float(x) for k, x in _given(prepared, names).items()}
    shooting = Shooting(prepared, wanted, start)
    programme = Programme(shooting, *_bounded(shooting, guesses))
    z, name, said = solved(programme, solver, iterations)
    return Optimum(model, shooting, z, name, said)


def _refuse_time(model: Model) -> None:
    e = model.compilation.equations
    nodes = [*e.force, *e.state_rates, *(x for row in e.mass for x in row)]
    if any(e.graph.depends[node] & BIT[Kind.TIME] for node in nodes):
        raise UsageError("the equations depend on time: pieces of the motion all begin at t = 0")


def _given(prepared: Any, names: list[str]) -> dict[str, float]:
    """Returns the starts that options set."""
    settings, count = prepared.settings, len(prepared.compilation.equations.seen)
    found = {names[i]: x for i, x in settings.start_q}
    return found | {names[count + i]: x for i, x in settings.start_v}


def _bounded(
    s: Shooting, guesses: dict[str, Range]
) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Returns a first guess of z, and its bounds. States go straight from their start to their
    end."""
    w, z = s.wanted, numpy.zeros(s.size)
    lower, upper = numpy.full(s.size, -math.inf), numpy.full(s.size, math.inf)
    part = numpy.linspace(0, 1, w.pieces + 1)
    for i, name in enumerate(s.moving):
        first = last = s.start[i]
        if name in w.end:
            last = min(max(first, w.end[name][0]), w.end[name][1])
        if name in guesses:
            first, last = guesses[name]
        z[s.states[:, i]] += first + part * (last - first)
        if name in s.q and (rate := f"{name}'") in s.moving and rate not in guesses:
            z[s.states[:, s.moving.index(rate)]] += (last - first) / (sum(w.duration) / 2)
        if name in w.path:
            lower[s.states[:, i]], upper[s.states[:, i]] = w.path[name]
        if name not in w.starts:
            place = s.states[0, i]
            z[place] = lower[place] = upper[place] = s.start[i]
    for j, name in enumerate(s.inputs):
        low, high = w.inputs[name]
        lower[s.u[:, j]], upper[s.u[:, j]] = low, high
        ends = guesses.get(name, (min(max(0.0, low), high),) * 2)
        z[s.u[:, j]] = numpy.linspace(*ends, len(s.u))
    values = s.prepared.compilation
    for k, name in enumerate(s.parameters):
        low, high = w.parameters[name]
        lower[s.p[k]], upper[s.p[k]] = low, high
        now = guesses.get(name, (_now(s, values, name),))[0]
        z[s.p[k]] = min(max(now, low), high)
    lower[s.T], upper[s.T] = w.duration
    z[s.T] = sum(guesses["t"]) / 2 if "t" in guesses else sum(w.duration) / 2
    return z, lower, upper


def _now(s: Shooting, compilation: Any, name: str) -> float:
    from pkgen.run import named
    from pkgen.run.library import load

    run = load(s.prepared.library).run(s.prepared.settings, idle=True)
    return float(run.given()["parameters"][named.parameters(compilation)[name][0]])
