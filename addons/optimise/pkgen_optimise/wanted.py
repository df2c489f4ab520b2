"""The problem in numbers: the aim, what is free, and what must hold, in SI units."""

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
class Wanted:
    """`minimise` names a column whose last value is the aim, or "t"; "" if an integral alone is.
    Ranges are (least, largest), equal for a value. `duration` is a range, too."""

    minimise: str
    sign: float  # -1: the aim is maximised
    integral: bool  # whether the state INTEGRAL is added to the aim
    inputs: dict[str, Range]
    parameters: dict[str, Range]
    starts: tuple[str, ...]
    end: dict[str, Range]
    path: dict[str, Range]
    periodic: dict[str, str]  # by the name of a start, the column that ends there
    duration: Range
    guess: dict[str, Range]  # the first and the last value
    pieces: int
    linear: bool


INTEGRAL = "integral_of_aim"


def units(compilation: Compilation) -> dict[str, str]:
    found = named.units(compilation)
    found["t"] = "" if compilation.model.dimensionless else "s"
    return found | {x.quantity.name: x.quantity.unit for x in compilation.equations.parameters}


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
            raise UsageError(f"{option} {name}: the first is to be below the second")
        if math.isfinite(low) + math.isfinite(high) < ENDS[option]:
            raise UsageError(f"{option} {name}: give a value or LOW:HIGH")
        found[name] = (low, high)
    return found


def checked(wanted: Wanted, compilation: Compilation) -> Wanted:
    """Raises UsageError for names of another kind than is wanted."""
    q, v = (named.coordinates(compilation, rates=x) for x in (False, True))
    moving = [x for x in (*q.names(), *v.names()) if x != INTEGRAL]
    outputs = [x.name for x in compilation.equations.observed_names]
    inputs, parameters = named.inputs(compilation), named.parameters(compilation)
    kinds = [
        ("--input", wanted.inputs, [*inputs.names()], "input"),
        ("--free", wanted.parameters, [*parameters.names()], "parameter"),
        ("--free-start", wanted.starts, moving, "coordinate or rate"),
        ("--periodic", wanted.periodic, moving, "coordinate or rate"),
        ("--periodic", wanted.periodic.values(), [*moving, *outputs], "column"),
        ("--end", wanted.end, [*moving, *outputs], "column"),
        ("--path", wanted.path, [*moving, *outputs], "column"),
        ("--guess", wanted.guess, [*wanted.inputs, *wanted.parameters, *moving, "t"], "unknown"),
    ]
    for option, names, known, what in kinds:
        for name in names:
            if name not in known:
                raise UsageError(f"{option} {name}: {near(name, known, what)}")
    columns = ["t", *moving, *outputs]
    if wanted.minimise and wanted.minimise not in columns:
        raise UsageError(
            f"--minimise {wanted.minimise}: {near(wanted.minimise, columns, 'column')}"
        )
    low, high = wanted.duration
    if not (0 < low <= high < math.inf):
        raise UsageError("--until: give a duration above 0, or LOW:HIGH")
    if wanted.minimise == "t" and low == high:
        raise UsageError("--minimise t: the duration is fixed; give --until LOW:HIGH")
    free = [*wanted.inputs.values(), *wanted.parameters.values(), wanted.duration]
    if not (wanted.starts or any(low < high for low, high in free)):
        raise UsageError("nothing is free: give --input, --free, --free-start or --until LOW:HIGH")
    _refuse(wanted, compilation)
    return replace(wanted, parameters=_within(wanted.parameters, compilation))


def whole(option: str, x: int, most: int) -> int:
    if not isinstance(x, Integral) or not 1 <= x <= most:
        raise UsageError(f"{option} {x}: a whole number from 1 to {most}")
    return int(x)


def _within(parameters: dict[str, Range], compilation: Compilation) -> dict[str, Range]:
    """Returns the ranges within the bounds of the model that are numbers. Raises UsageError."""
    e, found = compilation.equations, {}
    for name, (low, high) in parameters.items():
        slot = e.parameters[named.parameters(compilation)[name][0]]
        lo, hi = (None if x is None else e.graph.value(x) for x in (slot.lo, slot.hi))
        low, high = (
            max(low, -math.inf if lo is None else lo),
            min(high, math.inf if hi is None else hi),
        )
        if low > high:
            raise UsageError(f"--free {name}: the model has other bounds of {name}")
        found[name] = float(low), float(high)
    return found


def _refuse(wanted: Wanted, compilation: Compilation) -> None:
    """Raises UsageError for models whose motion cannot be cut into pieces."""
    e = compilation.equations
    if e.constraints or e.noise:
        raise UsageError("optimise: there is none for models with constraints, contacts or noise")
    used = {*wanted.end, *wanted.path, *wanted.periodic.values(), wanted.minimise}
    names = [x.name for x in e.observed_names]
    nodes = [*e.force, *e.state_rates, *(x for row in (*e.mass, *e.resets) for x in row)]
    nodes += [*e.events, *(x.node for x in e.switches)]
    nodes += [node for name, node in zip(names, e.observed, strict=True) if name in used]
    if any(e.graph.depends[node] & BIT[Kind.TIME] for node in nodes):
        raise UsageError(
            "the model depends on time, and pieces of the motion all begin at t = 0: write a clock "
            "into the model in place of t: 'state clock', 'rate clock = 1'"
        )
