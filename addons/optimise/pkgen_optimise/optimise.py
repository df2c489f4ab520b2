"""Finds the inputs, parameters, starts and the duration at which an objective is optimal."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy

from pkgen.api import arguments
from pkgen.api.arguments import in_words
from pkgen.api.model import Model
from pkgen.run import named
from pkgen.run.library import load
from pkgen.run.values import Values
from pkgen.system.exits import UsageError

from .optimum import Optimum
from .problem import INTEGRAL, Problem, Range, checked, ranges, units, whole
from .shooting import BEGIN, SLOPE, Shooting
from .solve import SOLVERS, Programme, solved

INTERVALS, ITERATIONS = 20, 300


def optimise(model: Model, minimise: str = "", **more: Any) -> Optimum:
    """Returns the motion with the least (or largest) objective: the last value of the column
    `minimise` (or `maximise`; "t" is the duration) plus the integral over time of `integral`.
    Without `maximise` the objective is made least; with it, largest, the integral too.

    `inputs` and `free` have ranges (least, largest) of inputs and parameters by name, None for no
    end; inputs are constant in each of `intervals` intervals, or with `linear` linear there.
    `free_start` names coordinates, rates and states whose start is free. `end` has terminal
    constraints, values or ranges of columns; `path` has path constraints, at the ends of all
    intervals. Columns `periodic` end with their start values; {"theta": "after"}: theta starts with
    the end value of the column `after`. `until` is a duration or a range of it. `guess` has (first,
    last) values by name: the first guess is linear between them; of "t" it is their mean, of a
    parameter the first. `solver` is "ipopt" or "slsqp", `iterations` their most. Other
    arguments are those of Model.run(). The optimum is a local one.

    Raises UsageError, NumericsFailed."""
    with in_words():
        given = {k: more.pop(k) for k in [*more] if k in optimised.__kwdefaults__}
        return optimised(model, arguments.options(model, more), minimise, **given)


def optimised(
    model: Model,
    options: argparse.Namespace,
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
    intervals: int = INTERVALS,
    linear: bool = False,
    guess: Mapping[str, Any] | None = None,
    solver: str = "",
    iterations: int = ITERATIONS,
) -> Optimum:
    """Does the work of optimise(); `options` are those of the runs. Messages name options."""
    if minimise and maximise:
        raise UsageError("--minimise and --maximise: give one of them")
    if solver and solver not in SOLVERS:
        raise UsageError(f"--solver {solver}: {', '.join(SOLVERS)}")
    if not (minimise or maximise or integral):
        raise UsageError("--minimise: name a column, or give --integral")
    if integral:
        model = model.extended(f"observe {INTEGRAL} = integral({integral})\n", {})
    of = model.compilation
    if not of.equations.dense:
        raise UsageError("optimise: there is none for families kept as loops")
    problem = Problem(
        column=minimise or maximise,
        sign=-1.0 if maximise else 1.0,
        integral=bool(integral),
        inputs=ranges(of, "--input", inputs or {}, "input"),
        parameters=ranges(of, "--free", free or {}, "parameter"),
        starts=tuple(arguments.several(free_start)),
        end=ranges(of, "--end", end or {}, "column"),
        path=ranges(of, "--path", path or {}, "column"),
        periodic=_pairs(periodic),
        duration=_duration(of, until),
        guess=ranges(of, "--guess", guess or {}, "quantity"),
        intervals=whole("--intervals", intervals, 1000),
        linear=linear,
    )
    problem = checked(problem, of)
    return _found(model, problem, solver, whole("--iterations", iterations, 10**6), options)


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
    model: Model, problem: Problem, solver: str, iterations: int, options: argparse.Namespace
) -> Optimum:
    inner, sets = model, list(options.set)
    if problem.linear and problem.inputs:
        lines, of_unit, time = "", units(model.compilation), Values(model.compilation).time
        for j, name in enumerate(problem.inputs):
            begin, slope = BEGIN.format(j), SLOPE.format(j)
            unit = of_unit[name]
            rate = f" [{unit}/s]" if unit and time else f" [1/{time}]" if time else ""
            lines += f"param {begin} = 0{f' [{unit}]' if unit else ''}\nparam {slope} = 0{rate}\n"
            sets.append(f"{name}={begin} + {slope}*t")
        inner = model.extended(lines, {})
    h = repr(problem.duration[1] / problem.intervals)
    of_run = argparse.Namespace(**{**vars(options), "until": h, "every": h, "set": sets})
    with warnings.catch_warnings():  # of lines that a scene alone uses
        warnings.simplefilter("ignore")
        prepared = inner.taped(of_run)
    given = load(prepared.library).run(prepared.settings, idle=True).given()
    shooting = Shooting(prepared, problem)
    values = [*given["q"][: shooting.q.count], *given["v"]]  # an integral comes last
    now = dict(zip(shooting.moving, values, strict=False))
    places = named.parameters(prepared.compilation)
    now |= {name: float(given["parameters"][places[name][0]]) for name in problem.parameters}
    programme = Programme(shooting, *_bounded(shooting, now))
    z, name, said = solved(programme, solver, iterations)
    return Optimum(model, shooting, z, name, said)


def _bounded(
    s: Shooting, now: dict[str, float]
) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Returns a first guess of z, and its bounds; `now` has the model's own values. States go
    straight from their start to their end."""
    problem, z = s.problem, numpy.zeros(s.size)
    lower, upper = numpy.full(s.size, -math.inf), numpy.full(s.size, math.inf)
    part = numpy.linspace(0, 1, problem.intervals + 1)
    for i, name in enumerate(s.moving):
        first = last = now[name]
        if name in problem.end:
            last = min(max(first, problem.end[name][0]), problem.end[name][1])
        if name in problem.guess:
            first, last = problem.guess[name]
        z[s.states[:, i]] += first + part * (last - first)
        if name in s.q and (rate := f"{name}'") in s.moving and rate not in problem.guess:
            z[s.states[:, s.moving.index(rate)]] += (last - first) / (sum(problem.duration) / 2)
        if name in problem.path:
            lower[s.states[:, i]], upper[s.states[:, i]] = problem.path[name]
        if name not in problem.starts:
            place = s.states[0, i]
            z[place] = lower[place] = upper[place] = now[name]
    for j, name in enumerate(s.inputs):
        low, high = problem.inputs[name]
        lower[s.u[:, j]], upper[s.u[:, j]] = low, high
        ends = problem.guess.get(name, (min(max(0.0, low), high),) * 2)
        z[s.u[:, j]] = numpy.linspace(*ends, len(s.u))
    for k, name in enumerate(s.parameters):
        lower[s.p[k]], upper[s.p[k]] = low, high = problem.parameters[name]
        z[s.p[k]] = min(max(problem.guess.get(name, (now[name],))[0], low), high)
    lower[s.T], upper[s.T] = problem.duration
    z[s.T] = sum(problem.guess["t"]) / 2 if "t" in problem.guess else sum(problem.duration) / 2
    return z, lower, upper
