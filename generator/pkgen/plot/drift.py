"""Pictures of drifts: the deviation of constants of the motion from their initial values, over
time, on logarithmic axes. The slope of a line is 1/2 for a random walk of round-off, 1 for a steady
loss, and 0 for the bounded error of a symplectic method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy

from ..system.exits import UsageError
from .members import FEW
from .names import shown
from .picture import Axis, Line, Panel, Picture
from .table import Table, finite

SHORT = 24  # A longer description of how the drift grows is left out of the legend.
LEAST = 1e-19  # Smallest relative drift that is drawn.


def picture(tables: Sequence[Table], names: list[str]) -> Picture:
    lines: list[Line] = []
    notes, drawn = [], set()
    for table in tables:
        for name in names or constants(table):
            told = table.drifts.get(name, {})
            line = _drift(table, name, told, len(lines) // 2)
            if line is None:
                notes.append(f"drift({name}) of {table.label} is 0, or cannot be told: not drawn")
                continue
            words = [table.label.removesuffix(".csv")] if len(tables) > 1 else []
            words += [shown(name)] if len(tables) == 1 or len(names or constants(table)) > 1 else []
            growth = str(told.get("growth", ""))
            said = ", ".join(words) + (f": {growth}" if 0 < len(growth) <= SHORT else "")
            lines += _both(table, line, said)
            drawn.add(name)
    if not lines:
        raise UsageError(f"--drift: {'; '.join(notes)}")
    if len(tables) == 1:
        lines = lines[: 2 * FEW]
    said = f"relative drift of {shown(*drawn)}" if len(drawn) == 1 else "relative drift"
    if not any(table.several for table in tables):
        said += "\n(strong: the largest so far)"
    panel = Panel(tables[0].axis(log=True), Axis(said, log=True), tuple(lines), tight=True)
    return Picture("", (panel,), notes=tuple(notes))


def constants(table: Table) -> list[str]:
    """Returns the columns that the run reports as constant. Raises UsageError if there are none."""
    found = [n for n in table.names if n in table.drifts or n == "energy"]
    if not found:
        raise UsageError(
            f"--drift: {table.label} has no energy, nor another column that is known to be "
            "constant; --columns says which are"
        )
    return found


def _drift(table: Table, name: str, told: dict[str, object], colour: int) -> Line | None:
    """Returns a line of |x - x(0)| for the column x, relative to the scale in the run's report, or
    else to max |x|. Returns None if all drifts are too small to be drawn."""
    order, begins = table.by_member()
    x, t = table[name][order], table.time[order]
    first = x[begins][table.member[order]]
    scale = told.get("scale")
    if not isinstance(scale, int | float) or not scale > 0:
        scale = numpy.abs(finite(x)).max(initial=0.0)
    # The report has no other scale than the drift itself.
    if told.get("first") == 0 and told.get("max") == 1:
        return None
    off = numpy.abs(x - first) / scale if scale else numpy.zeros(len(x))
    drawn = (t > 0) & (off > LEAST)
    if not drawn.any():
        return None
    strands = begins if table.several else None
    return Line("", t, numpy.where(drawn, off, numpy.nan), colour, "back", None, strands)


def _both(table: Table, line: Line, words: str) -> list[Line]:
    """Returns two lines: the running maximum of the drift, and behind it the drift itself as a pale
    line."""
    if table.several:
        strong = replace(line, label=words, kind="line")
        return [strong, Line("", line.x[:0], line.y[:0], line.colour, "back")]
    return [Line(words, line.x, numpy.fmax.accumulate(line.y), line.colour), line]
