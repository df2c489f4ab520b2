"""Fits parameters and starts of a model to measured motions."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy

from pkgen.api import arguments
from pkgen.api.arguments import in_words
from pkgen.api.model import Model
from pkgen.compiler import Compilation
from pkgen.run import named
from pkgen.run.values import Values
from pkgen.system.exits import UsageError
from pkgen.system.near import near

from .data import Experiment, read
from .fitted import Fitted
from .problem import Problem, Unknown
from .search import STEPS, TRIES, local, solve

ROUNDS = 4  # of fits whose weights are the residuals of the one before
LEAST = 1e-12  # least standard deviation, relative to the data


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
    """Returns the values of the parameters and inputs `free`, and of the starts `free_start` of
    each experiment, at which the motion is nearest to the data by least squares.

    `data` is a CSV file, columns by name, or a list of these, one for each experiment; NaN is a
    missing sample. An input among the columns is recorded: between samples it is linear, and its
    free value is an offset. `bounds` has (least, largest), `priors` (value, standard deviation),
    `sigma` the standard deviation of a column (default: of its residuals). With `huber`, outliers
    count less. `tries` are starts besides that of the model. `more` are arguments of Model.run().

    Raises UsageError, RunError."""
    with in_words():
        arguments.checked(free=free, free_start=free_start, tries=tries)
        pairs = {"bounds": bounds, "priors": priors}
        known = {k: _numbers(k, x, (2,)) for k, x in pairs.items()}
        known["sigma"] = _numbers("sigma", sigma, ())
        several = data if isinstance(data, list | tuple) else [data]
        names = arguments.several(free), arguments.several(free_start)
        return fitted(model, several, *names, known, huber, tries, more)


def _numbers(option: str, given: Any, shape: tuple[int, ...]) -> dict[str, Any]:
    """Returns the numbers of an argument by name. Raises UsageError."""
    if not isinstance(given or {}, Mapping):
        raise UsageError(f"{option}={arguments.brief(given)}: give a dictionary by name")
    found = {}
    for name, x in (given or {}).items():
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
    known: Mapping[str, dict[str, Any]],
    huber: bool,
    tries: int,
    more: dict[str, Any],
) -> Fitted:
    """Does the work of fit(); `known` has bounds, priors and sigma. Messages name options."""
    experiments = [read(one, model.compilation) for one in data]
    problem = _problem(model, experiments, free, free_start, **known, more=more)
    x = solve(problem, tries, huber)
    estimated = [name for name in problem.columns if name not in known["sigma"]]
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
    bounds: dict[str, tuple[float, float]],
    priors: dict[str, tuple[float, float]],
    sigma: dict[str, float],
    more: dict[str, Any],
) -> Problem:
    columns = {name for e in experiments for name in e.columns}
    for name, x in sigma.items():
        if name not in columns:
            raise UsageError(f"--sigma {name}: {near(name, sorted(columns), 'column')}")
        if not x > 0:
            raise UsageError(f"--sigma {name}={x:g}: a standard deviation is above 0")
    recorded = {name for e in experiments for name in e.inputs}
    unknowns = [_parameter(model, name, bounds, priors, recorded) for name in free]
    for k, e in enumerate(experiments):
        unknowns += [_start(model, e, k, name, bounds, priors) for name in free_start]
    if not unknowns:
        raise UsageError("--free: name parameters, or starts by --free-start")
    if twice := [u.name for i, u in enumerate(unknowns) if u in unknowns[:i]]:
        raise UsageError(f"--free {twice[0]}: it is there twice")
    known = {u.name for u in unknowns}
    for option, given in (("--bound", bounds), ("--prior", priors)):
        for name in given:
            if name not in known:
                raise UsageError(f"{option} {name}: it is not free")
    compilation, runs = model.compilation, []
    for e in experiments:
        lines, tables, sets = _recorded(e, compilation)
        of = model.extended(lines, tables) if lines else model
        end = float(e.t[-1])
        options = arguments.options(of, {**more, "until": end, "every": end})
        options.set += sets
        with warnings.catch_warnings():  # of lines that a scene alone uses
            warnings.simplefilter("ignore")
            runs.append(of.taped(options))
    scale = {name: sigma.get(name) or _size(experiments, name) for name in sorted(columns)}
    problem = Problem(runs, experiments, unknowns, scale)
    samples = sum(int(numpy.isfinite(x).sum()) for e in experiments for x in e.columns.values())
    if samples + len(priors) < len(unknowns):
        raise UsageError(f"{samples} samples are fewer than the {len(unknowns)} unknowns")
    return problem


def _parameter(
    model: Model,
    name: str,
    bounds: Mapping[str, tuple[float, float]],
    priors: Mapping[str, tuple[float, float]],
    recorded: set[str],
) -> Unknown:
    of = model.compilation
    parameters, inputs = named.parameters(of), named.inputs(of)
    if name in inputs:
        unit, value, ends = inputs[name][1].unit, 0.0, (-math.inf, math.inf)
    elif name in parameters:
        k, quantity = parameters[name]
        unit, value, ends = quantity.unit, model.params[name], _declared(of, k)
    else:
        raise UsageError(f"--free {name}: {near(name, [*parameters, *inputs], 'parameter')}")
    found = _unknown(name, unit, value, ends, bounds, priors, None)
    return replace(found, of=f"{name}_offset") if name in recorded else found


def _recorded(
    e: Experiment, compilation: Compilation
) -> tuple[str, dict[str, tuple[numpy.ndarray, ...]], list[str]]:
    """Returns lines of a model by which its inputs are those of an experiment and an offset, their
    tables, and the values of the option --set."""
    lines, tables, sets = "", {}, []
    time = "" if compilation.model.dimensionless else " [s]"
    for name, values in e.inputs.items():
        quantity = named.inputs(compilation)[name][1]
        unit = f" [{quantity.unit}]" if quantity.unit else ""
        lines += f'table {name}_data = "data.csv" t{time}, {name}{unit} linear hold\n'
        lines += f"param {name}_offset = 0{unit}\n"
        tables[f"{name}_data"] = (e.t, values)
        sets.append(f"{name}={name}_data(t) + {name}_offset")
    return lines, tables, sets


def _declared(of: Compilation, k: int) -> tuple[float, float]:
    """Returns the bounds of a parameter that are numbers in the model."""
    e = of.equations
    slot = e.parameters[k]
    low, high = (None if x is None else e.graph.value(x) for x in (slot.lo, slot.hi))
    return (-math.inf if low is None else float(low), math.inf if high is None else float(high))


def _start(
    model: Model,
    e: Experiment,
    k: int,
    name: str,
    bounds: Mapping[str, tuple[float, float]],
    priors: Mapping[str, tuple[float, float]],
) -> Unknown:
    q, v = (named.coordinates(model.compilation, rates=x) for x in (False, True))
    if name not in q and name not in v:
        raise UsageError(f"--free-start {name}: {near(name, [*q, *v], 'coordinate or rate')}")
    unit = (q if name in q else v)[name][1].unit
    names = [*q.names(), *v.names()]
    value = float(model.start[names.index(name)])
    shown = _shown(e, name)
    ends = (-math.inf, math.inf)
    return _unknown(name, unit, value if shown is None else shown, ends, bounds, priors, k)


def _shown(e: Experiment, name: str) -> float | None:
    """Returns the start that the first samples show, of a rate by the slope, or None."""
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
    bounds: Mapping[str, tuple[float, float]],
    priors: Mapping[str, tuple[float, float]],
    experiment: int | None,
) -> Unknown:
    low, high = bounds.get(name, ends)
    if not low < high:
        raise UsageError(f"--bound {name}={low:g}:{high:g}: the first is to be below the second")
    if name in priors and not priors[name][1] > 0:
        raise UsageError(f"--prior {name}: its standard deviation is to be above 0")
    value = min(max(value, low), high)
    return Unknown(name, unit, value, low, high, experiment, priors.get(name))


def read_number(compilation: Compilation, option: str, text: str, name: str) -> float:
    """Returns a value of a named quantity in SI."""
    units = named.units(compilation)
    units |= {x.quantity.name: x.quantity.unit for x in compilation.equations.parameters}
    if name not in units:
        raise UsageError(f"{option} {name}: {near(name, [*units], 'quantity')}")
    return Values(compilation).value(option, text, units[name], name)
