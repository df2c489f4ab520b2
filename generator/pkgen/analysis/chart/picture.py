"""Draws the default picture of a chart: one panel, at most six methods, the answers as sentences.

It fits a journal: it is as wide as a column or a page, with fonts of 7 to 8 points, colours for any
usual colour vision, and a marker for each method for print in grey.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from pathlib import Path

from ...plot import methods, names, style
from ...plot.style import Look
from . import text
from .answer import Answer
from .chart import Chart
from .front import drawn
from .panel import UNITS, Curve, Style, draw

MOST = 6  # most methods
PALE = "Pale: runs that another of the same method beats, or that may be luck."
SIZE = 2.8
SPREAD = 0.35  # opacity of the bar from the least to the largest error of several starts
# In millimetres: the mean width of a letter at 7 points, and the sum of both side margins.
LETTER, SIDES = 1.32, 18.0
COLUMN = 120.0  # pictures at least this wide, in millimetres, are higher than narrower ones


def sentence(answers: Sequence[Answer]) -> str:
    """Returns the answers for one measure of cost as a sentence, from low to high accuracy."""
    told = []
    for a in answers:
        if a.method is None or a.point is None:
            told.append(f"{names.number(a.accuracy)}: {a.reason}")
            continue
        cost = text.seconds(a.point.seconds or 0) if a.axis == "seconds" else f"{a.point.work:,}"
        set_to = f"{a.method.setting} {names.number(a.point.setting)}"
        told.append(f"{names.number(a.accuracy)}: {a.method.name}, {set_to}, {cost}")
    said = f"Least {text.AXIS[answers[0].axis]} for an error of " + "; ".join(told) + "."
    return re.sub(r"(?<=\d) (?=\D?s\b)|(?<=step|rtol) ", "\u00a0", said)


def picture(chart: Chart, axis: str, look: Look):
    """Draws the chart and returns the figure. The style of `look` must be active. `axis`, a key of
    UNITS, is the measure of cost."""
    from matplotlib import pyplot

    inches, width = look.inches, look.width
    asked = axis if axis in ("seconds", "work") else "work"
    said = sentence([a for a in chart.answers if a.axis == asked]) + _beside(chart)
    said += f" {text.interrupted(chart).capitalize()}." if chart.interrupted else ""
    said = f"{said} {chart.kind.beside} {PALE}"
    lines = textwrap.wrap(said, int((width - SIDES) / LETTER))
    below = 0.52 + 0.125 * len(lines)
    height = (2.6 if width < COLUMN else 3.4) + below
    figure, axes = pyplot.subplots(figsize=(inches, height))
    chosen = drawn(chart, MOST)
    styles = {n: Style(*methods.mark(n, look.dark), True, size=SIZE) for n in chosen}
    tracks = [t for t in chart.tracks if t.method.name in styles]
    curves = [Curve(t, axis, lambda p: p.error, chart.spectrum.limit(t.method)) for t in tracks]
    named = draw(axes, curves, styles, chart, False)
    for track in tracks if chart.starts > 1 else ():
        _spread(axes, track.good, axis, styles[track.method.name].colour)
    axes.set(xlabel=chart.kind.axis, ylabel=UNITS[axis])
    title = f"{chart.model.replace('_', ' ')}, {chart.time}"
    axes.set_title(title, loc="left", weight="bold")
    left = 0.62 / inches
    beside = {"ha": "left", "va": "bottom", "fontsize": 7, "linespacing": 1.25}
    figure.text(left, 0.06 / height, "\n".join(lines), **beside)
    top = 1 - 0.28 / height
    figure.subplots_adjust(left=left, right=1 - 0.1 / inches, bottom=below / height, top=top)
    named()
    return figure


def _beside(chart: Chart) -> str:
    """Returns a sentence with the times of other packages, relative to the time of pkgen for the
    same accuracy, from low to high accuracy."""
    told = []
    for b in chart.beside:
        ratios = [chart.times(a) for a in b.answers]
        if any(ratios):
            times = ", ".join(f"{r:.3g}×" if r else "none" for r in ratios)
            told.append(f"{b.version} {times}")
    return f" Other packages take, in that order: {'; '.join(told)}." if told else ""


def _spread(axes, points, axis: str, colour: str) -> None:
    for p in points:
        cost = p.cost(axis)
        if p.least and p.most and cost:
            axes.plot([p.least, p.most], [cost, cost], color=colour, lw=2.5, alpha=SPREAD, zorder=2)


def write(chart: Chart, stem: Path, look: Look, axis: str) -> list[Path]:
    """Writes the picture as SVG, which the HTML page needs, and in the formats of `look`. Returns
    the paths of the files."""
    return style.written(lambda look: picture(chart, axis, look), stem, look)
