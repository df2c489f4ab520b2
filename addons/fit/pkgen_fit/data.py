"""Experiments: measured columns over time, in SI units."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from pkgen.compiler import Compilation
from pkgen.front import data as csv
from pkgen.record import record
from pkgen.run import named
from pkgen.run.values import Values
from pkgen.system.exits import UsageError
from pkgen.system.near import near

if TYPE_CHECKING:
    from numpy.typing import NDArray

TIMES = ("t", "time")


@record
class Experiment:
    """Measured columns by name, and recorded inputs; NaN is a missing sample."""

    name: str
    t: NDArray[Any]
    columns: dict[str, NDArray[Any]]
    inputs: dict[str, NDArray[Any]]


def read(given: Any, compilation: Compilation) -> Experiment:
    """Reads a CSV file, or columns by name in SI units (a dictionary or a data frame). Units stand
    in the titles, `theta [deg]`. Raises UsageError."""
    if isinstance(given, str | os.PathLike):
        name = os.fspath(given)
        columns = _of_file(Path(given), compilation)
    else:
        name = "data"
        try:
            columns = {str(key): numpy.asarray(given[key], float) for key in given}
        except (TypeError, ValueError) as error:
            raise UsageError(f"data: columns of numbers by name are wanted: {error}") from None
    return _checked(name, columns, compilation)


def _of_file(path: Path, compilation: Compilation) -> dict[str, NDArray[Any]]:
    try:
        cells = csv.read(path)
    except csv.WrongData as wrong:
        raise UsageError(str(wrong)) from None
    if not cells.titles:
        raise UsageError(f"{path}: the first line names the columns, e.g. t,theta [deg]")
    units, found = _units(compilation), {}
    for k, (title, unit) in enumerate(cells.titles):
        if title in found:
            raise UsageError(f"{path}: there are two columns '{title}'")
        factor = 1.0
        if unit and title in units:
            option = f"{path}: column {title}"
            factor = Values(compilation).value(option, f"1 [{unit}]", units[title], title)
        found[title] = factor * numpy.array([_number(cells, i, k) for i in range(len(cells.rows))])
    return found


def _number(cells: csv.Cells, row: int, column: int) -> float:
    texts = cells.rows[row]
    text = texts[column].strip() if column < len(texts) else ""
    try:
        return float(text) if text else math.nan
    except ValueError:
        raise UsageError(str(cells.wrong(row, column, f"'{text[:40]}' is no number"))) from None


def _units(compilation: Compilation) -> dict[str, str]:
    return named.units(compilation) | dict.fromkeys(TIMES, Values(compilation).time)


def _checked(
    name: str, columns: Mapping[str, NDArray[Any]], compilation: Compilation
) -> Experiment:
    units, inputs = _units(compilation), named.inputs(compilation)
    t = next((columns[x] for x in TIMES if x in columns), None)
    if t is None:
        raise UsageError(f"{name}: there is no column t, the time")
    if any(x.shape != t.shape or x.ndim != 1 for x in columns.values()):
        raise UsageError(f"{name}: the columns differ in length")
    if not len(t) or not numpy.isfinite(t).all() or t[0] < 0 or (numpy.diff(t) < 0).any():
        raise UsageError(f"{name}: times must rise, from t = 0 on, where the motion starts")
    if not t[-1] > 0:
        raise UsageError(f"{name}: there is no time after t = 0")
    measured, given = {}, {}
    for title, values in columns.items():
        if title in TIMES:
            continue
        if title not in units:
            known = [x for x in units if x not in TIMES]
            raise UsageError(f"{name}: column {title}: {near(title, known, 'column')}")
        if numpy.isinf(values).any():
            raise UsageError(f"{name}: column {title}: a value is not finite")
        if title in inputs:
            if numpy.isnan(values).any():
                raise UsageError(f"{name}: column {title}: an input lacks a sample")
            if (numpy.diff(t) == 0).any():
                raise UsageError(f"{name}: column {title}: an input has two samples at one time")
            given[title] = values
        elif numpy.isfinite(values).any():
            measured[title] = values
    if not measured:
        raise UsageError(
            f"{name}: no column is measured: {', '.join(x for x in units if x not in inputs)}"
        )
    return Experiment(name, t, measured, given)
