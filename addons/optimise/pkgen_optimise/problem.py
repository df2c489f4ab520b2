"""The problem in numbers: the objective, the unknowns and the constraints, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from numbers import Integral
from typing import Any

from pkgen.compiler import Compilation
from pkgen.graph.graph import BIT, Kind
from pkgen.record import record
from pkgen.run import named
from pkgen.run.values import Values
from pkgen.system.exits import UsageError
from pkgen.system.near import near

Range = tuple[float, float]


@record
class Problem:
    """`column` names a column whose last value is the objective, or "t"; "" if an integral alone
    is. Ranges are (least, largest), equal for a value. `duration` is a range, too."""

    column: str
    sign: float  # -1: the objective is maximised
    integral: bool  # whether the state INTEGRAL is added to the objective
    inputs: dict[str, Range]
    parameters: dict[str, Range]
    starts: tuple[str, ...]
    end: dict[str, Range]  # terminal constraints
    path: dict[str, Range]  # path constraints
    periodic: dict[str, str]  # by the name of a start, the column that ends there
    duration: Range
    guess: dict[str, Range]  # the first and the last value
    intervals: int  # number of shooting intervals
    linear: bool


INTEGRAL = "integral_of_objective"


def units(compilation: Compilation) -> dict[str, str]:
    found = named.units(compilation, named.parameters(compilation))
    return found | {"t": Values(compilation).time}


# How many ends of a range are needed.
ENDS = {"--input": 0, "--free": 0, "--end": 1, "--path": 1, "--guess": 2}


def ranges(
    compilation: Compilation, option: str, given: Mapping[str, Any], kinds: str
) -> dict[str, Range]:
    """Returns ranges by name. A range is a number, a text such as `-1 [N]:1 [N]`, a pair, or None:
    no end. Raises UsageError."""
    if not isinstance(given, Mapping):
        raise UsageError(f"{option} {given}: give a dictionary by name")
    values, known = Values(compilation), units(compilation)

    def number(name: str, x: Any) -> float:
        if x is None or (isinstance(x, str) and not x.strip()):
            return math.inf
        return values.value(option, x, known[name], name) if isinstance(x, str) else float(x)

    found = {}
    for name, x in given.items():
        if name not in known:
            raise UsageError(f"{option} {name}: {near(name, [*known], kinds)}")
        ends = x.split(":") if isinstance(x, str) else x
        ends = list(ends) if isinstance(ends, list | tuple) else [ends]
        if len(ends) > 2:
            raise UsageError(f"{option} {name}={x}: give a value or LOW:HIGH")
        low, high = number(name, ends[0]), number(name, ends[-1])
        if ends[0] is None or (isinstance(ends[0], str) and not ends[0].strip()):
            low = -math.inf
        if not low <= high and option != "--guess":
            raise UsageError(f"{option} {name}: LOW must not exceed HIGH")
        if math.isfinite(low) + math.isfinite(high) < ENDS[option]:
            raise UsageError(f"{option} {name}: give a value or LOW:HIGH")
        found[name] = (low, high)
    return found


def checked(problem: Problem, compilation: Compilation) -> Problem:
    """Returns the problem, with parameters within the bounds of the model. Raises UsageError."""
    q, v = (named.coordinates(compilation, rates=x) for x in (False, True))
    moving = [x for x in (*q.names(), *v.names()) if x != INTEGRAL]
    outputs = [x.name for x in compilation.equations.observed_names]
    inputs, parameters = named.inputs(compilation), named.parameters(compilation)
    kinds = [
        ("--input", problem.inputs, [*inputs.names()], "input"),
        ("--free", problem.parameters, [*parameters.names()], "parameter"),
        ("--free-start", problem.starts, moving, "coordinate, rate or state"),
        ("--periodic", problem.periodic, moving, "coordinate, rate or state"),
        ("--periodic", problem.periodic.values(), [*moving, *outputs], "column"),
        ("--end", problem.end, [*moving, *outputs], "column"),
        ("--path", problem.path, [*moving, *outputs], "column"),
        ("--guess", problem.guess, [*problem.inputs, *problem.parameters, *moving, "t"], "unknown"),
    ]
    for option, names, known, what in kinds:
        for name in names:
            if name not in known:
                raise UsageError(f"{option} {name}: {near(name, known, what)}")
    columns = ["t", *moving, *outputs]
    if problem.column and problem.column not in columns:
        raise UsageError(f"--minimise {problem.column}: {near(problem.column, columns, 'column')}")
    low, high = problem.duration
    if not (0 < low <= high < math.inf):
        raise UsageError("--until: give a duration above 0, or LOW:HIGH")
    if problem.column == "t" and low == high:
        raise UsageError("--minimise t: the duration is fixed; give --until LOW:HIGH")
    free = [*problem.inputs.values(), *problem.parameters.values(), problem.duration]
    if not (problem.starts or any(low < high for low, high in free)):
        raise UsageError("nothing is free: give --input, --free, --free-start or --until LOW:HIGH")
    _refuse(problem, compilation)
    return replace(problem, parameters=_within(problem.parameters, compilation))


def whole(option: str, x: int, most: int) -> int:
    if not isinstance(x, Integral) or not 1 <= x <= most:
        raise UsageError(f"{option} {x}: a whole number from 1 to {most}")
    return int(x)


def _within(parameters: dict[str, Range], compilation: Compilation) -> dict[str, Range]:
    """Returns the ranges within the bounds of the model that are numbers. Raises UsageError."""
    found = {}
    for name, (low, high) in parameters.items():
        lowest, highest = named.bounds(compilation, name)
        low, high = max(low, lowest), min(high, highest)
        if low > high:
            raise UsageError(f"--free {name}: the model has other bounds of {name}")
        found[name] = low, high
    return found


def _refuse(problem: Problem, compilation: Compilation) -> None:
    """Raises UsageError for models whose motion cannot be cut into intervals."""
    e = compilation.equations
    if e.constraints or e.noise:
        raise UsageError("optimise: there is none for models with constraints, contacts or noise")
    used = {*problem.end, *problem.path, *problem.periodic.values(), problem.column}
    names = [x.name for x in e.observed_names]
    nodes = [*e.force, *e.state_rates, *(x for row in (*e.mass, *e.resets) for x in row)]
    nodes += [*e.events, *(x.node for x in e.switches)]
    nodes += [node for name, node in zip(names, e.observed, strict=True) if name in used]
    if any(e.graph.depends[node] & BIT[Kind.TIME] for node in nodes):
        raise UsageError(
            "the model depends on time, and all intervals begin at t = 0: write a clock into the "
            "model in place of t: 'state clock', 'rate clock = 1'"
        )
