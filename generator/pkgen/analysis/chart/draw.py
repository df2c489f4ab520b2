"""Draws the pictures of `--full`: one of all methods, in which the best have strong colours, and
one with a panel per family. Each curve has its name at its end.
"""

from __future__ import annotations

import math
from pathlib import Path

from ...plot.methods import mark
from ...plot.style import GREY, LOOK, saved
from . import table, text
from .chart import Chart
from .front import strong as foremost
from .panel import FAILED, UNITS, Curve, Style, draw
from .points import AXES, FAMILIES

STRONG_MOST = 10
NAMED_MOST = 14  # if there are more methods, the first picture names only the strong() ones
LINE = 165  # characters per line of the subtitle
FOOT = (
    "× failed, or lost: an error as large as the motion.   "
    "⋯ the step predicted to be the last stable one."
)


def pictures(chart: Chart, stem: Path) -> list[Path]:
    """Writes two pictures as SVG and PNG: `stem` followed by _full and by _families. Returns the
    paths of the files."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    files = []
    with pyplot.rc_context(LOOK):
        for name, make in (("full", _overview), ("families", _families)):
            figure = make(chart)
            files += saved(figure, stem.with_name(f"{stem.name}_{name}"), ("svg", "png"), dpi=120)
            pyplot.close(figure)
    return files


def _curves(chart: Chart, axis: str, measure) -> list[Curve]:
    return [Curve(t, axis, measure, chart.spectrum.limit(t.method)) for t in chart.tracks]


def _overview(chart: Chart):
    from matplotlib import pyplot

    strong = set(foremost(chart)[:STRONG_MOST])
    named = {t.method.name for t in chart.tracks} if len(chart.tracks) <= NAMED_MOST else strong
    styles = {
        m.name: Style(*mark(m.name), m.name in strong, m.name in named)
        for m in (t.method for t in chart.tracks)
    }
    measures = [(chart.kind.axis, lambda p: p.error)]
    kept = table.invariants(chart.tracks)
    if kept:
        invariants = ", ".join(kept if len(kept) < 5 else [*kept[:4], "…"])
        title = f"largest drift on the way ({invariants})"
        measures.append((title, lambda p: max(p.drifts.values(), default=None)))
    rows = len(measures)
    height = 1.9 + 4.0 * rows
    figure, grid = pyplot.subplots(rows, 2, figsize=(11, height), squeeze=False, sharey="col")
    names = []
    for row, (title, measure) in enumerate(measures):
        for axes, axis in zip(grid[row], AXES, strict=True):
            names.append(draw(axes, _curves(chart, axis, measure), styles, chart, row == 0))
            axes.set(xlabel=title, ylabel=UNITS[axis])
            if row == 0:
                _answers(axes, chart, axis)
    _legend(figure, len(strong) if len(named) < len(chart.tracks) else 0)
    return _framed(figure, chart, names, bottom=0.75, height=height, gaps=(0.24, 0.21))


def _families(chart: Chart):
    from matplotlib import pyplot

    members = {f: [t for t in chart.tracks if t.method.family == f] for f in FAMILIES}
    members = {family: tracks for family, tracks in members.items() if tracks}
    columns = min(len(members), 2 if len(members) < 5 else 3)
    rows = math.ceil(len(members) / columns)
    height = 1.7 + 3.6 * rows
    figure, grid = pyplot.subplots(
        rows, columns, figsize=(1 + 4.5 * columns, height), squeeze=False, sharey=True
    )
    names, cells = [], list(grid.flat)
    for axes in cells[len(members) :]:
        axes.axis("off")
    for axes, (family, tracks) in zip(cells, members.items(), strict=False):
        styles = {t.method.name: Style(*mark(t.method.name), True) for t in tracks}
        curves = _curves(chart, "seconds", lambda p: p.error)
        names.append(draw(axes, curves, styles, chart, True))
        axes.set_title(family)
        axes.set_xlabel(chart.kind.axis)
    for line in grid:
        line[0].set_ylabel(UNITS["seconds"])
    return _framed(figure, chart, names, bottom=0.3, height=height, gaps=(0.1, 0.31))


def _answers(axes, chart: Chart, axis: str) -> None:
    """Writes the cheapest method for each accuracy above the axes, alternately in two rows."""
    told = [answer for answer in chart.answers if answer.axis == axis]
    for k, answer in enumerate(told):
        look = {"ha": "center", "va": "bottom", "fontsize": 7.5, "textcoords": "offset points"}
        said = "none"
        if answer.point is not None and answer.method is not None:
            work, time = f"{answer.point.work:,}", text.seconds(answer.point.seconds or 0)
            said = f"{answer.method.name}\n{time if axis == 'seconds' else work}"
        at = (answer.accuracy, 1.0), (0, 3 + (k % 2) * 21)
        axes.annotate(said, *at, xycoords=("data", "axes fraction"), **look)
        axes.axvline(answer.accuracy, color="#999999", lw=0.6, ls="--", zorder=1)
    at = {"xycoords": "axes fraction", "textcoords": "offset points"}
    axes.annotate("cheapest", (0.0, 1.0), (-30, 3), **at, fontsize=7.5, style="italic")


def _legend(figure, strong: int) -> None:
    """Draws a legend for the curves without names. `strong` is the number of curves with names; if
    it is 0, there is no legend."""
    from matplotlib.lines import Line2D

    if strong:
        label = f"not among the {strong} foremost: named in the picture by families"
        line = Line2D([], [], color=GREY, lw=0.8, alpha=0.6, label=label)
        anchor = (0.5, 0.012 * 11 / figure.get_figheight() + 0.012)
        how = {"loc": "lower center", "frameon": False, "bbox_to_anchor": anchor}
        figure.legend(handles=[line], **how)


def _framed(figure, chart: Chart, names, bottom: float, height: float, gaps: tuple[float, float]):
    """Adds title, parameters and footer, then the curves' names. `height` is that of the figure and
    `bottom` the space below the panels, in inches; `gaps` between panels are relative to the size
    of a panel."""
    import textwrap

    width = figure.get_figwidth()
    lines = textwrap.wrap(f"{chart.subtitle()}; {chart.time}", int(LINE * width / 11))
    title = f"{chart.model.replace('_', ' ')}: accuracy against cost (left and low is better)"
    figure.suptitle(title, y=1 - 0.12 / height, va="top", fontsize=12, weight="bold")
    figure.text(0.5, 1 - 0.38 / height, "\n".join(lines), ha="center", va="top", fontsize=8)
    figure.text(0.5, 0.06 / height, FOOT, ha="center", va="bottom", fontsize=8, color=FAILED)
    top = 1.0 + 0.16 * len(lines)
    sides = {"left": 0.95 / width, "right": 1 - 0.3 / width}
    ends = {"bottom": (bottom + 0.5) / height, "top": 1 - top / height}
    figure.subplots_adjust(**sides, **ends, wspace=gaps[0], hspace=gaps[1])
    for name in names:
        name()
    return figure
