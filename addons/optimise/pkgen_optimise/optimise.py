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
from pkgen.run.library import load
from pkgen.run.values import Values
from pkgen.system.exits import UsageError

from .optimum import Optimum
from .shooting import BEGIN, SLOPE, Shooting
from .solve import SOLVERS, Programme, solved
from .wanted import INTEGRAL, Range, Wanted, checked, ranges, units, whole

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
        model = model.extended(f"observe {INTEGRAL} = integral({integral})\n", {})
    of = model.compilation
    if of.looped:
        raise UsageError("optimise: there is none for families kept as loops")
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
        ranges(of, "--guess", guess or {}, "quantity"),
        whole("--pieces", pieces, 1000),
        linear,
    )
    return _found(
        model, checked(wanted, of), solver, whole("--iterations", iterations, 10**6), more
    )


def _pairs(periodic: Any) -> dict[str, str]:
    if isinstance(periodic, Mapping):
        return dict(periodic)
    parts = [text.partition("=") for text in arguments.several(periodic)]
    return {name.strip(): (end or name).strip() for name, _, end in parts}


def _duration(of: Any, until: Any) -> Range:
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
    solver: str,
    iterations: int,
    more: dict[str, Any],
) -> Optimum:
    inner, sets = model, []
    if wanted.linear and wanted.inputs:
        lines, of_unit = "", units(model.compilation)
        time = "" if model.compilation.model.dimensionless else "s"
        for j, name in enumerate(wanted.inputs):
            begin, slope = BEGIN.format(j), SLOPE.format(j)
            unit = of_unit[name]
            rate = f" [{unit}/s]" if unit and time else f" [1/{time}]" if time else ""
            lines += f"param {begin} = 0{f' [{unit}]' if unit else ''}\nparam {slope} = 0{rate}\n"
            sets.append(f"{name}={begin} + {slope}*t")
        inner = model.extended(lines, {})
    h = wanted.duration[1] / wanted.pieces
    options = arguments.options(inner, {**more, "until": h, "every": h})
    options.set += sets
    with warnings.catch_warnings():  # of lines that a scene alone uses
        warnings.simplefilter("ignore")
        prepared = inner.taped(options)
    given = load(prepared.library).run(prepared.settings, idle=True).given()
    shooting = Shooting(prepared, wanted)
    values = [*given["q"][: shooting.q.count], *given["v"]]  # an integral comes last
    now = dict(zip(shooting.moving, values, strict=False))
    now |= {name: model.params[name] for name in wanted.parameters}
    programme = Programme(shooting, *_bounded(shooting, now))
    z, name, said = solved(programme, solver, iterations)
    return Optimum(model, shooting, z, name, said)


def _bounded(
    s: Shooting, now: dict[str, float]
) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Returns a first guess of z, and its bounds; `now` has the model's own values. States go
    straight from their start to their end."""
    w, z = s.wanted, numpy.zeros(s.size)
    lower, upper = numpy.full(s.size, -math.inf), numpy.full(s.size, math.inf)
    part = numpy.linspace(0, 1, w.pieces + 1)
    for i, name in enumerate(s.moving):
        first = last = now[name]
        if name in w.end:
            last = min(max(first, w.end[name][0]), w.end[name][1])
        if name in w.guess:
            first, last = w.guess[name]
        z[s.states[:, i]] += first + part * (last - first)
        if name in s.q and (rate := f"{name}'") in s.moving and rate not in w.guess:
            z[s.states[:, s.moving.index(rate)]] += (last - first) / (sum(w.duration) / 2)
        if name in w.path:
            lower[s.states[:, i]], upper[s.states[:, i]] = w.path[name]
        if name not in w.starts:
            place = s.states[0, i]
            z[place] = lower[place] = upper[place] = now[name]
    for j, name in enumerate(s.inputs):
        low, high = w.inputs[name]
        lower[s.u[:, j]], upper[s.u[:, j]] = low, high
        ends = w.guess.get(name, (min(max(0.0, low), high),) * 2)
        z[s.u[:, j]] = numpy.linspace(*ends, len(s.u))
    for k, name in enumerate(s.parameters):
        lower[s.p[k]], upper[s.p[k]] = low, high = w.parameters[name]
        z[s.p[k]] = min(max(w.guess.get(name, (now[name],))[0], low), high)
    lower[s.T], upper[s.T] = w.duration
    z[s.T] = sum(w.guess["t"]) / 2 if "t" in w.guess else sum(w.duration) / 2
    return z, lower, upper
