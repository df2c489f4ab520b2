"""The picture: a map a method, predictions over it. SVG (maps rasterised, so files stay small) and
PNG. Each class has a hatch beside its colour."""

from __future__ import annotations

import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from ...plot import style
from ...run import named
from . import overlay
from .map import StabilityMap
from .misses import unpredicted

# Class -> colour, hatch (of lines: dots would make files large). In the order of the legend.
CLASSES = {
    "bounded": ("#DCEBF5", ""),
    "drifting by less than 1 %": ("#FAF6C8", ""),
    "drifting": (style.YELLOW, "--"),
    "growing": (style.ORANGE, "////"),
    "wrong branch": (style.BLUE, "\\\\\\\\"),
    "not converged": (style.PURPLE, 4 * "x"),
    "not finite": ("#333333", ""),
    "singular": (style.GREEN, "||||"),
    "failed": ("#999999", "++"),
    "not judged": ("#FFFFFF", "////"),
}
SAID_OF = {"not judged": "not judged: the motion itself leaves"}  # in the legend
NARROWEST = 7.4  # inches: titles and legend fit
SAID = 12  # values in the title


def pictures(made: StabilityMap, stem: Path) -> list[Path]:
    """STEM.svg and STEM.png."""
    with plt.rc_context({**style.FILES, "font.size": 8}):
        figure = _figure(made)
        files = style.saved(figure, stem, ("svg", "png"), dpi=150)
        plt.close(figure)
    return files


def _figure(made: StabilityMap) -> plt.Figure:
    names = list(made.steps)
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    width = max(3.5 * columns + 0.4, NARROWEST)
    figure, grid = plt.subplots(
        rows, columns, figsize=(width, 2.9 * rows + 1.15), squeeze=False, layout="constrained"
    )
    used: set[str] = set()
    for k, name in enumerate(names):
        last = k % columns == columns - 1 or k == len(names) - 1
        used |= _panel(grid[k // columns][k % columns], made, name, k % columns == 0, last)
    for axes in grid.flat[len(names) :]:
        axes.set_visible(False)
    lines = [line for title in titles(made) for line in textwrap.wrap(title, int(14 * width))]
    figure.suptitle("\n".join(lines), fontsize=9)
    _legend(figure, used, int(width / 2.1))
    return figure


def titles(made: StabilityMap) -> list[str]:
    """Model, what it is set to, for how long."""
    unit = "" if made.compilation.model.dimensionless else " s"
    values = [
        *zip(named.parameters(made.compilation).columns(64), made.motion.parameters, strict=False),
        *zip(named.coordinates(made.compilation).columns(64), made.motion.q, strict=False),
        *zip(named.coordinates(made.compilation, True).columns(64), made.motion.v, strict=False),
    ]
    count = len(made.motion.parameters)
    said = [
        f"{quantity.name}{'' if k < count else '(0)'} = {x:.6g} {quantity.unit}".rstrip()
        for k, (quantity, x) in enumerate(values)
        if (k < count or x != 0) and quantity.name != made.asked.axis.name
    ]
    more = ", ..." if len(said) > SAID else ""
    why = unpredicted(made)
    return [
        f"{made.compilation.model.name}: where each method fails; "
        f"each point {made.until:.4g}{unit} of motion, told from its energy",
        ", ".join(said[:SAID]) + more,
        *([f"nothing is predicted here: {why}"] if why else []),
    ]


def _grid(made: StabilityMap, name: str) -> np.ndarray:
    order = {kind: k for k, kind in enumerate(CLASSES)}
    return np.array([[order[p.kind] for p in row.points if p.method == name] for row in made.rows])


def edges(values: np.ndarray) -> np.ndarray:
    """Borders of cells about ascending values."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middles = (values[1:] + values[:-1]) / 2
    first, last = values[0] - (middles[0] - values[0]), values[-1] + (values[-1] - middles[-1])
    return np.concatenate([[first], middles, [last]])


def _panel(axes: plt.Axes, made: StabilityMap, name: str, first: bool, last: bool) -> set[str]:
    """One method's map; which classes and lines are on it."""
    cells = _grid(made, name)
    hs = np.array(made.steps[name])
    xs = np.array(made.asked.axis.values)
    kinds = list(CLASSES)
    colours = ListedColormap([CLASSES[kind][0] for kind in kinds])
    norm = BoundaryNorm(np.arange(len(kinds) + 1) - 0.5, len(kinds))
    axes.pcolormesh(edges(hs), edges(xs), cells, cmap=colours, norm=norm, rasterized=True)
    here = {kinds[k] for k in np.unique(cells)}
    for kind in kinds:  # in order, not in that of a set: files are the same from run to run
        if kind in here and CLASSES[kind][1]:
            _hatch(axes, hs, xs, cells == kinds.index(kind), CLASSES[kind][1])
    axes.set_xlim(edges(hs)[0], edges(hs)[-1])
    axes.set_ylim(edges(xs)[0], edges(xs)[-1])
    drawn = overlay.lines(axes, made, name)
    if overlay.measured(axes, made, name):
        drawn.add("measured")
    axes.set_title(name, fontsize=9, fontweight="bold", loc="left", pad=3)
    unit = "" if made.compilation.model.dimensionless else " [s]"
    axes.set_xlabel(f"step h{unit}", labelpad=1)
    if first:
        axes.set_ylabel(made.asked.axis.label)
    _second_axes(axes, made, last)
    return here | drawn


def _hatch(axes: plt.Axes, hs: np.ndarray, xs: np.ndarray, cells: np.ndarray, hatch: str) -> None:
    """Hatches whole cells: each is drawn by its four corners, drawn in by a hair."""
    across, up = (np.repeat(edges(values), 2)[1:-1] for values in (hs, xs))
    for ends in (across, up):
        hair = 1e-4 * (ends[-1] - ends[0]) * np.tile([1.0, -1.0], len(ends) // 2)
        hair[[0, -1]] = 0
        ends += hair
    mask = np.repeat(np.repeat(cells.astype(float), 2, axis=0), 2, axis=1)
    axes.contourf(across, up, mask, levels=[0.5, 1.5], colors="none", hatches=[hatch])


def _second_axes(axes: plt.Axes, made: StabilityMap, last: bool) -> None:
    rate = fastest(made)
    if rate:
        top = axes.secondary_xaxis("top", functions=(lambda h: h * rate, lambda y: y / rate))
        top.tick_params(labelsize=6.5, pad=1)
        top.set_xlabel(f"h {overlay.omega(0)}", fontsize=7, labelpad=2)
    energies = np.array([row.motion.energy for row in made.rows])
    if last and made.asked.axis.kind == "amplitude" and len(energies) > 3:
        right = axes.twinx()
        right.set_ylim(axes.get_ylim())
        ticks = np.linspace(0, len(energies) - 1, 5).astype(int)
        right.set_yticks(np.array(made.asked.axis.values)[ticks], _told_apart(energies[ticks]))
        right.tick_params(labelsize=6.5)
        unit = "" if made.compilation.model.dimensionless else " [J]"
        right.set_ylabel(f"energy{unit}", fontsize=7)


def _told_apart(values: np.ndarray) -> list[str]:
    """With as many digits as it takes."""
    for digits in range(3, 17):
        texts = [f"{x:.{digits}g}" for x in values]
        if len(set(texts)) == len(set(values)):
            break
    return texts


def fastest(made: StabilityMap) -> float | None:
    """The fastest mode of the equilibrium about which the motion is."""
    if made.primary is None:
        return None
    rates = [m.frequency for m in made.rest.equilibria[made.primary].modes]
    return max(rates, default=0.0) or None


def _legend(figure: plt.Figure, used: set[str], columns: int) -> None:
    handles: list = [
        Patch(fc=colour, hatch=hatch, ec="#666666", lw=0.4, label=SAID_OF.get(kind, kind))
        for kind, (colour, hatch) in CLASSES.items()
        if kind in used
    ]
    handles += overlay.handles(used)
    legend = figure.legend(
        handles=handles, loc="lower center", ncols=min(columns, len(handles)), frameon=False
    )
    # "outside lower center" is not known to matplotlib before 3.7.
    height = legend.get_window_extent(figure.canvas.get_renderer()).height / figure.bbox.height
    figure.get_layout_engine().set(rect=(0, height, 1, 1 - height))
