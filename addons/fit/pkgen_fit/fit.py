"""Fits parameters and starts of a model to measured motions."""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy

from pkgen.api import arguments
from pkgen.api.arguments import in_words
from pkgen.api.model import Model
from pkgen.api.prepare import Prepared
from pkgen.compiler import Compilation
from pkgen.record import record
from pkgen.run import named
from pkgen.run.library import load
from pkgen.run.values import Values
from pkgen.system.exits import UsageError
from pkgen.system.near import near

from .data import Experiment, read
from .fitted import Fitted
from .problem import Problem, Unknown
from .search import STEPS, TRIES, local, solve

ROUNDS = 4  # fits whose weights are the residuals of the one before
LEAST = 1e-12  # least standard deviation, relative to the data
UNBOUNDED = (-math.inf, math.inf)
Pairs = dict[str, tuple[float, float]]


@record
class Known:
    """Bounds and priors of the unknowns, and deviations of the data, by name, in SI units."""

    bounds: Pairs  # least and largest value
    priors: Pairs  # value and standard deviation
    sigma: dict[str, float]  # standard deviation of a column


def fit(
    model: Model,
    data: Any,
    free: arguments.Names = (),
    free_start: arguments.Names = (),
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    sigma: Mapping[str, float] | None = None,
    huber: bool = False,
    tries: int = TRIES,
    **more: Any,
) -> Fitted:
    """Fits the parameters and inputs `free`, and the start values `free_start` of each experiment,
    to measured data by least squares.

    `data` is a CSV file, columns by name, or a list of these, one for each experiment; NaN is a
    missing sample. An input among the columns is recorded: between samples it is linear, and its
    free value is an offset. `free_start` names coordinates, rates and states. `bounds` has (least,
    largest), None for no bound, `priors` (value, standard deviation), `sigma` the standard
    deviation of a column (default: the rms of its residuals). With `huber`, outliers count less.
    The search has `tries` starts besides the model's values. `more` are arguments of Model.run().

    Raises UsageError, RunError."""
    with in_words():
        arguments.checked(free=free, free_start=free_start, tries=tries)
        pairs = _numbers("bounds", bounds, (2,)), _numbers("priors", priors, (2,))
        known = Known(*pairs, _numbers("sigma", sigma, ()))
        several = data if isinstance(data, list | tuple) else [data]
        names = arguments.several(free), arguments.several(free_start)
        options = arguments.options(model, more)
        return fitted(model, several, *names, known, options, huber=huber, tries=tries)


def _numbers(option: str, given: Any, shape: tuple[int, ...]) -> dict[str, Any]:
    """Returns the numbers of an argument by name. Raises UsageError."""
    if not isinstance(given or {}, Mapping):
        raise UsageError(f"{option}={arguments.brief(given)}: give a dictionary by name")
    found = {}
    for name, x in (given or {}).items():
        if option == "bounds" and isinstance(x, list | tuple) and len(x) == 2:
            x = [end if one is None else one for one, end in zip(x, UNBOUNDED, strict=True)]
        (values,) = arguments.arrays(**{f"{option} of {name}": x})
        if values.shape != shape:
            count = "two numbers" if shape else "one number"
            raise UsageError(f"{option} of {name}={arguments.brief(x)}: give {count}")
        found[name] = values.tolist()
    return found


def fitted(
    model: Model,
    data: Sequence[Any],
    free: Sequence[str],
    free_start: Sequence[str],
    known: Known,
    options: argparse.Namespace,
    *,
    huber: bool,
    tries: int,
) -> Fitted:
    """Does the work of fit(); `options` are those of the runs. Messages name options."""
    experiments = [read(one, model.compilation) for one in data]
    problem = _problem(model, experiments, free, free_start, known, options)
    x = solve(problem, tries, huber)
    estimated = [name for name in problem.columns if name not in known.sigma]
    for _ in range(ROUNDS if estimated else 0):
        before, rms = dict(problem.scale), problem.rms(x)
        for name in estimated:
            problem.scale[name] = max(rms[name], LEAST * _size(experiments, name))
        if all(abs(problem.scale[n] / before[n] - 1) < 1e-3 for n in estimated):
            break
        again = local(problem, x, 1.0, STEPS[-1], huber)
        x = x if again is None else again[1]
    return Fitted(problem, x, bool(estimated))


def _size(experiments: Sequence[Experiment], name: str) -> float:
    values = numpy.concatenate([e.columns[name] for e in experiments if name in e.columns])
    spread = float(numpy.nanstd(values)) if numpy.isfinite(values).sum() > 1 else 0.0
    return spread or float(numpy.nanmax(abs(values))) or 1.0


def _problem(
    model: Model,
    experiments: Sequence[Experiment],
    free: Sequence[str],
    free_start: Sequence[str],
    known: Known,
    options: argparse.Namespace,
) -> Problem:
    columns = {name for e in experiments for name in e.columns}
    for name, x in known.sigma.items():
        if name not in columns:
            raise UsageError(f"--sigma {name}: {near(name, sorted(columns), 'column')}")
        if not x > 0:
            raise UsageError(f"--sigma {name}={x:g}: a standard deviation is above 0")
    if not (free or free_start):
        raise UsageError("--free: name parameters, or starts by --free-start")
    for option, names in (("--free", free), ("--free-start", free_start)):
        if twice := [name for i, name in enumerate(names) if name in names[:i]]:
            raise UsageError(f"{option} {twice[0]}: it is there twice")
    for option, given in (("--bound", known.bounds), ("--prior", known.priors)):
        if wrong := [name for name in given if name not in {*free, *free_start}]:
            raise UsageError(f"{option} {wrong[0]}: it is not free")
    runs = [_prepared(model, e, options) for e in experiments]
    recorded = {name for e in experiments for name in e.inputs}
    values = _values(runs[0])
    unknowns = [_parameter(model.compilation, values, name, known, recorded) for name in free]
    for k, e in enumerate(experiments):
        unknowns += [_start(model.compilation, values, e, k, name, known) for name in free_start]
    scale = {name: known.sigma.get(name) or _size(experiments, name) for name in sorted(columns)}
    samples = sum(int(numpy.isfinite(x).sum()) for e in experiments for x in e.columns.values())
    if samples + len(known.priors) < len(unknowns):
        raise UsageError(f"{samples} samples are fewer than the {len(unknowns)} unknowns")
    return Problem(runs, experiments, unknowns, scale)


def _prepared(model: Model, e: Experiment, options: argparse.Namespace) -> Prepared:
    """Prepares the run of an experiment, with its recorded inputs."""
    lines, tables, sets = _recorded(e, model.compilation)
    of = model.extended(lines, tables) if lines else model
    end = repr(float(e.t[-1]))
    own = {"until": end, "every": end, "set": [*options.set, *sets]}
    with warnings.catch_warnings():  # of lines that a scene alone uses
        warnings.simplefilter("ignore")
        return of.taped(argparse.Namespace(**{**vars(options), **own}))


def _values(run: Prepared) -> dict[str, float]:
    """Returns the values of parameters, coordinates, rates, states and inputs in a run, by name."""
    of, given = run.compilation, load(run.library).run(run.settings, idle=True).given()
    held = dict(run.settings.inputs)
    found = {name: held.get(named.inputs(of)[name][0], 0.0) for name in named.inputs(of).names()}
    q, v = (named.coordinates(of, rates=x) for x in (False, True))
    for names, values in ((named.parameters(of), "parameters"), (q, "q"), (v, "v")):
        found |= {name: float(given[values][names[name][0]]) for name in names.names()}
    return found


def _parameter(
    of: Compilation, values: Mapping[str, float], name: str, known: Known, recorded: set[str]
) -> Unknown:
    parameters, inputs = named.parameters(of), named.inputs(of)
    if name in recorded:
        offset = _unknown(name, inputs[name][1].unit, 0.0, UNBOUNDED, known, None)
        return replace(offset, of=f"{name}_offset")
    if name in inputs:
        unit, ends = inputs[name][1].unit, UNBOUNDED
    elif name in parameters:
        unit, ends = parameters[name][1].unit, named.bounds(of, name)
    else:
        raise UsageError(f"--free {name}: {near(name, [*parameters, *inputs], 'parameter')}")
    return _unknown(name, unit, values[name], ends, known, None)


def _recorded(
    e: Experiment, compilation: Compilation
) -> tuple[str, dict[str, tuple[numpy.ndarray, ...]], list[str]]:
    """Returns lines of a model by which its inputs are those of an experiment and an offset, their
    tables, and the values of the option --set."""
    lines, tables, sets = "", {}, []
    time = " [s]" if Values(compilation).time else ""
    for name, values in e.inputs.items():
        quantity = named.inputs(compilation)[name][1]
        unit = f" [{quantity.unit}]" if quantity.unit else ""
        lines += f'table {name}_data = "data.csv" t{time}, {name}{unit} linear hold\n'
        lines += f"param {name}_offset = 0{unit}\n"
        tables[f"{name}_data"] = (e.t, values)
        sets.append(f"{name}={name}_data(t) + {name}_offset")
    return lines, tables, sets


def _start(
    of: Compilation, values: Mapping[str, float], e: Experiment, k: int, name: str, known: Known
) -> Unknown:
    q, v = (named.coordinates(of, rates=x) for x in (False, True))
    if name not in q and name not in v:
        hint = near(name, [*q, *v], "coordinate, rate or state")
        raise UsageError(f"--free-start {name}: {hint}")
    unit = (q if name in q else v)[name][1].unit
    estimated = _estimated_start(e, name)
    value = values[name] if estimated is None else estimated
    return _unknown(name, unit, value, UNBOUNDED, known, k)


def _estimated_start(e: Experiment, name: str) -> float | None:
    """Returns the start value estimated from the first five samples (the slope, for a rate), or
    None."""
    of = name if name in e.columns else name.removesuffix("'")
    if of not in e.columns:
        return None
    known = numpy.flatnonzero(numpy.isfinite(e.columns[of]))[:5]
    if len(known) < 2:
        return None
    slope, value = numpy.polyfit(e.t[known], e.columns[of][known], 1)
    return float(value if of == name else slope)


def _unknown(
    name: str,
    unit: str,
    value: float,
    ends: tuple[float, float],
    known: Known,
    experiment: int | None,
) -> Unknown:
    low, high = known.bounds.get(name, UNBOUNDED)
    if not low < high:
        raise UsageError(f"--bound {name}={low:g}:{high:g}: LOW must be below HIGH")
    low, high = max(low, ends[0]), min(high, ends[1])
    if not low < high:
        raise UsageError(f"--bound {name}: the model has other bounds of {name}")
    if name in known.priors and not known.priors[name][1] > 0:
        raise UsageError(f"--prior {name}: its standard deviation is to be above 0")
    value = min(max(value, low), high)
    return Unknown(name, unit, value, low, high, experiment, known.priors.get(name))
