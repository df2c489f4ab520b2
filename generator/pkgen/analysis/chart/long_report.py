"""Writes the result of `pkgen chart --long` as a text table, as CSV and as a picture."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

from ...plot import methods, style
from ...plot.names import label
from ...plot.style import Look
from ...system.columns import aligned
from .labels import Label, place
from .long import Drifting, Long

MOST = 6  # largest number of methods whose drift is drawn in one panel
HEADINGS = ("method", "constant", "steps", "largest drift", "growth")


def _growth(one: Drifting, constant: str) -> str:
    exponent = one.exponents.get(constant)
    said = one.growth.get(constant, "")
    return said if exponent is None else f"{said} (t^{exponent:.2f})"


def text(long: Long) -> str:
    """Returns the table, with a row for each method and constant."""
    rows = [HEADINGS]
    for one in long.drifting:
        last = one.decades[-1]
        for constant in long.constants:
            drift = f"{last.drifts.get(constant, math.inf):.1e}"
            steps = f"{last.steps:,}"
            rows.append((one.method.name, constant, steps, drift, _growth(one, constant)))
    unit = f" {long.unit}".rstrip()
    head = f"{long.model}: drifts over decades of steps of {long.step:g}{unit}, relative"
    lines = [head, "", *aligned(rows, right=(2, 3))]
    early = [f"{one.method.name}: {one.reason}" for one in long.drifting if one.reason]
    return "\n".join([*lines, "", *early]).rstrip() + "\n"


def as_csv(long: Long) -> str:
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = [f"drift({name})" for name in long.constants]
    writer.writerow(["method", "order", "step", "steps", "t", "seconds", "status", *columns])
    for one in long.drifting:
        for d in one.decades:
            cells = [d.drifts.get(name, math.inf) for name in long.constants]
            head = [one.method.name, one.method.order, long.step, d.steps, d.t]
            writer.writerow([*head, d.seconds, d.status, *cells])
    return file.getvalue()


def record(long: Long) -> dict[str, object]:
    return {
        "model": long.model,
        "step": long.step,
        "refused": long.refused,
        "methods": [
            {
                "method": one.method.name,
                "order": one.method.order,
                "growth": one.growth,
                "exponents": one.exponents,
                "reason": one.reason,
                "decades": [
                    vars(d)
                    | {"drifts": {k: v if math.isfinite(v) else None for k, v in d.drifts.items()}}
                    for d in one.decades
                ],
            }
            for one in long.drifting
        ],
    }


def write(long: Long, stem: Path, look: Look) -> list[Path]:
    return style.written(lambda look: _figure(long, look), stem, look)


def _figure(long: Long, look: Look):
    """Draws a panel for each constant: drift against time, both logarithmic."""
    from matplotlib import pyplot

    count = len(long.constants)
    inches, height = look.inches, 0.5 + 2.4 * count
    figure, grid = pyplot.subplots(count, 1, figsize=(inches, height), squeeze=False, sharex=True)
    names = [
        _panel(axes, long, constant, look.dark)
        for axes, constant in zip(grid[:, 0], long.constants, strict=True)
    ]
    grid[-1, 0].set_xlabel(label("t", long.unit))
    title = f"{long.model.replace('_', ' ')}, steps of {long.step:g} {long.unit}".rstrip()
    grid[0, 0].set_title(title, loc="left", weight="bold")
    ends = {"bottom": 0.42 / height, "top": 1 - 0.28 / height}
    figure.subplots_adjust(left=0.62 / inches, right=1 - 0.1 / inches, hspace=0.12, **ends)
    for name in names:
        name()
    return figure


def _panel(axes, long: Long, constant: str, dark: bool):
    """Draws the drift of MOST methods: for each kind of growth the method with the least drift,
    then further methods with little drift. Returns a function that places the labels."""
    finite = [d for d in long.drifting if math.isfinite(d.decades[-1].drifts.get(constant, 0.0))]
    ranked = sorted(finite, key=lambda d: d.decades[-1].drifts.get(constant, math.inf))
    kinds = list({d.growth.get(constant): d for d in reversed(ranked)}.values())
    shown = list({id(d): d for d in [*kinds, *ranked]}.values())[:MOST]
    drawn, labels = [], []
    for one in shown:
        colour, marker = methods.mark(one.method.name, dark)
        t = [d.t for d in one.decades]
        y = [max(d.drifts.get(constant, 0.0), 1e-17) for d in one.decades]
        axes.plot(t, y, color=colour, marker=marker, ms=2.8)
        drawn.append((t, y))
        name = f"{one.method.name}: {_growth(one, constant)}"
        labels.append(Label(name, t[-1], y[-1], colour, 7))
    axes.set(xscale="log", yscale="log", ylabel=f"drift of {constant}")
    axes.grid(True, which="major", lw=0.6)
    least = long.step
    axes.set_xlim(5 * least, 3e7 * least)
    return lambda: place(axes, labels, drawn)
