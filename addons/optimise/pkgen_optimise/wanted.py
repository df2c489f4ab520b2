"""The problem in numbers: the aim, what is free, and what must hold, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pkgen.compiler import Compilation
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
    pieces: int
    linear: bool


INTEGRAL = "integral_of_aim"


def units(compilation: Compilation) -> dict[str, str]:
    e = compilation.equations
    found = {x.name: x.unit for x in (*e.coordinates, *e.rates, *e.states, *e.inputs)}
    found |= {x.name: x.unit for x in e.observed_names}
    found["t"] = "" if compilation.model.dimensionless else "s"
    return found | {x.quantity.name: x.quantity.unit for x in e.parameters}


def ranges(
    compilation: Compilation, option: str, given: Mapping[str, Any], kinds: str
) -> dict[str, Range]:
    """Returns ranges by name. A range is a number, a text such as `-1 [N]:1 [N]`, a pair, or None:
    free. Raises UsageError."""
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
        found[name] = (low, high)
    return found


def checked(wanted: Wanted, compilation: Compilation) -> Wanted:
    """Raises UsageError for names of another kind than is wanted."""
    q, v = (named.coordinates(compilation, rates=x) for x in (False, True))
    moving = [*q.names(), *v.names()]
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
    if not (wanted.inputs or wanted.parameters or wanted.starts or low < high):
        raise UsageError("nothing is free: give --input, --free, --free-start or --until LOW:HIGH")
    if not 1 <= wanted.pieces <= 1000:
        raise UsageError(f"--pieces {wanted.pieces}: from 1 to 1000")
    return wanted
