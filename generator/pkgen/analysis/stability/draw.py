"""Draws the picture: one map per method, with predictions. Maps are pixels to keep files small."""

from __future__ import annotations

import textwrap
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.legend_handler import HandlerTuple
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from ...plot import names, style
from ...plot.style import Look
from ...run import named
from . import classes, overlay
from .map import StabilityMap
from .misses import unpredicted

SAID = 12  # the caption has at most this many parameters and initial values
LETTER = 1.32  # mean width of a letter at 7 points, in millimetres
BETWEEN = 0.08  # inches above and below the caption
MOST_COLUMNS = 4  # largest number of columns of the legend
WITHIN = 0.95  # the legend may take this fraction of the page width, as fonts in files may be wider
WIDE = 120.0  # least page width for three maps side by side, in millimetres
SMALL = 6.5  # font size of secondary axes, in points
APART = 3.0  # least pixels between tick labels


def pictures(made: StabilityMap, stem: Path, look: Look) -> list[Path]:
    """Writes the picture as SVG and in the formats of `look`; returns the paths of the files."""
    return style.written(lambda look: figure(made, look), stem, look)


def figure(made: StabilityMap, look: Look) -> plt.Figure:
    """Draws the figure; the style of `look` must already be active."""
    methods = list(made.steps)
    columns = min(3 if look.width >= WIDE else 2, len(methods))
    rows = -(-len(methods) // columns)
    maps = (1.75 if columns > 1 else 2.4) * rows + 0.25
    page, grid = plt.subplots(
        rows, columns, figsize=(look.inches, maps), squeeze=False, layout="constrained"
    )
    page.get_layout_engine().set(w_pad=0.03, h_pad=0.03)
    used: set[str] = set()
    later = []
    for k, name in enumerate(methods):
        last = k % columns == columns - 1 or k == len(methods) - 1 < columns
        there, after = _panel(grid[k // columns][k % columns], made, name, look, k % columns, last)
        used |= there
        later.append(after)
    for axes in grid.flat[len(methods) :]:
        axes.set_visible(False)
    legend = _legend(page, used, look)
    words = _words(page, made, look)
    below = legend + _inches(page, words) + BETWEEN
    page.set_size_inches(look.inches, maps + below)
    words.set_y((legend + BETWEEN / 2) / (maps + below))
    bottom = below / (maps + below)
    page.get_layout_engine().set(rect=(0, bottom, 1, 1 - bottom))
    page.draw_without_rendering()  # computes the layout of the figure
    page.set_layout_engine("none")
    for after in later:
        after()
    return page


def _words(page: plt.Figure, made: StabilityMap, look: Look) -> Text:
    """Draws the title, and below the maps a caption with the model's settings."""
    title, *said = titles(made)
    wrap = int(look.width / LETTER)
    lines = [line for text in said for line in textwrap.wrap(text, wrap)]
    left = {"x": 0.06 / look.inches, "ha": "left"}
    bold = textwrap.fill(title, int(0.8 * wrap))
    page.suptitle(bold, **left, fontsize=8.5, fontweight="bold")
    text = page.text(y=0, s="\n".join(lines), **left, va="bottom", fontsize=7)
    text.set_in_layout(False)
    return text


def _inches(page: plt.Figure, of: Artist) -> float:
    """Returns the height of an artist in inches."""
    return of.get_window_extent(page.canvas.get_renderer()).height / page.dpi


def titles(made: StabilityMap) -> list[str]:
    """Returns the title, then the lines of the caption: settings, duration, remarks."""
    time, per = ("", "") if made.compilation.model.dimensionless else ("s", "rad/s")
    values = [
        *zip(named.parameters(made.compilation).columns(64), made.motion.parameters, strict=False),
        *zip(named.coordinates(made.compilation).columns(64), made.motion.q, strict=False),
        *zip(named.coordinates(made.compilation, True).columns(64), made.motion.v, strict=False),
    ]
    count = len(made.motion.parameters)
    said = [
        f"{names.shown(quantity.name)}{'' if k < count else '(0)'} = "
        f"{names.amount(three(x), quantity.unit)}".replace(" ", "\u00a0")
        for k, (quantity, x) in enumerate(values)
        if (k < count or x != 0) and quantity.name != made.asked.axis.name
    ]
    more = ", ..." if len(said) > SAID else ""
    why = unpredicted(made)
    judged = "distance from the start" if made.motion.by_norm else "energy"
    rate, ends = fastest(made), {steps[-1] for steps in made.steps.values()}
    fast = f"{overlay.omega(0)} = {names.amount(three(rate), per)}" if rate else ""
    mode = f" {fast}, the fastest mode.".replace(" = ", "\u00a0=\u00a0") if rate else ""
    mode += " Steps of each method have their own range." if len(ends) > 1 else ""
    return [
        f"{made.compilation.model.name.replace('_', ' ')}: where each method fails",
        f"Each point: t = {names.amount(three(made.until), time)} of motion, told from its "
        f"{judged}. {', '.join(said[:SAID])}{more}.{mode}",
        *([f"{made.interrupted.capitalize()}."] if made.interrupted else []),
        *([f"Nothing is predicted here: {why}."] if why else []),
    ]


def _panel(axes: plt.Axes, made: StabilityMap, name: str, look: Look, column: int, last: bool):
    """Draws a method's map. Returns the names of everything drawn, for the legend, and a function
    to be called after the layout of the figure."""
    hs, xs = np.array(made.steps[name]), np.array(made.asked.axis.values)
    kinds = [[p.shown for p in row.points if p.method == name] for row in made.rows]
    used = classes.fill(axes, hs, xs, kinds, look)
    axes.set_xlim(*classes.edges(hs)[[0, -1]])
    axes.set_ylim(*classes.edges(xs)[[0, -1]])
    drawn, labels = overlay.lines(axes, made, name, look)
    if overlay.measured(axes, made, name, look):
        drawn.add("measured")
    drawn |= overlay.ghosts(axes, made, name, look)
    axes.set_title(name, fontweight="bold", loc="left", pad=3)
    axes.spines[["top", "right"]].set_visible(True)
    unit = "" if made.compilation.model.dimensionless else "s"
    axes.set_xlabel(names.label("step h", unit), labelpad=1)
    if column == 0:
        axes.set_ylabel(made.asked.axis.label)
    _second_axes(axes, made, last)

    def after() -> None:
        _ticks(axes)
        classes.glyphs(axes, hs, xs, kinds, look)
        overlay.label(axes, labels, look)

    return used | drawn, after


def _ticks(axes: plt.Axes) -> None:
    """Sets up to five ticks per axis, as many as fit. Call it after the layout of the figure."""
    for axis in (axes.xaxis, *(other.xaxis for other in axes.child_axes)):
        for count in range(5, 0, -1):
            axis.set_major_locator(MaxNLocator(count))
            low, high = sorted(axis.get_view_interval())
            boxes = [
                number.get_window_extent()
                for number in axis.get_majorticklabels()
                if number.get_text() and low <= number.get_position()[0] <= high
            ]
            apart = all(a.x1 + APART < b.x0 for a, b in pairwise(boxes))
            if apart and all(b.x1 < axes.figure.bbox.x1 for b in boxes):
                break


def _second_axes(axes: plt.Axes, made: StabilityMap, last: bool) -> None:
    rate = fastest(made)
    if rate:
        top = axes.secondary_xaxis("top", functions=(lambda h: h * rate, lambda y: y / rate))
        top.tick_params(labelsize=SMALL, pad=1, length=2)
        axes.set_title(f"h {overlay.omega(0)}", fontsize=SMALL, loc="right", pad=3)
    by_energy = made.asked.axis.kind == "amplitude" and not made.motion.by_norm
    if not last or not by_energy or made.primary is None:
        return
    rest = made.rest.equilibria[made.primary].energy
    energies = np.array([row.motion.energy - rest for row in made.rows])
    if len(energies) < 4 or not (np.diff(energies) > 0).all():
        return
    right = axes.twinx()
    right.set_ylim(axes.get_ylim())
    ticks = np.linspace(0, len(energies) - 1, 4).astype(int)
    right.set_yticks(
        np.array(made.asked.axis.values)[ticks], [three(x, True) for x in energies[ticks]]
    )
    right.tick_params(labelsize=SMALL, pad=2, length=2)
    unit = "" if made.compilation.model.dimensionless else "J"
    right.set_ylabel(names.label("energy above rest", unit), fontsize=SMALL)


def three(x: float, zeros: bool = False) -> str:
    """Formats x with three significant digits (1050); `zeros` keeps trailing zeros (2.50)."""
    rounded = float(f"{x:.3g}")
    return f"{rounded:#.3g}".rstrip(".") if zeros and abs(rounded) < 1000 else f"{rounded:g}"


def fastest(made: StabilityMap) -> float | None:
    """Returns the highest frequency of the modes of the primary equilibrium. Returns None if there
    is no primary equilibrium, or none of its modes oscillates."""
    if made.primary is None:
        return None
    rates = [m.frequency for m in made.rest.equilibria[made.primary].modes]
    return max(rates, default=0.0) or None


def _legend(page: plt.Figure, used: set[str], look: Look) -> float:
    """Draws the legend along the lower edge, in as many columns as fit; returns its height."""
    entries = [*classes.handles(used, look), *overlay.handles(used, look)]
    signs, words = zip(*entries, strict=True)
    how = {
        "loc": "lower left",
        "frameon": False,
        "handler_map": {tuple: HandlerTuple(ndivide=1)},
        "borderpad": 0.2,
        "borderaxespad": 0.1,
        "columnspacing": 1.2,
        "handlelength": 1.8,
    }
    for columns in range(MOST_COLUMNS, 0, -1):
        # matplotlib before 3.7 lacks "outside lower left".
        legend = page.legend(signs, words, ncols=columns, **how)
        box = legend.get_window_extent(page.canvas.get_renderer())
        if box.x1 <= WITHIN * page.bbox.x1 or columns == 1:
            break
        legend.remove()
    return _inches(page, legend)
