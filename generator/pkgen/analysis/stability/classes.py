"""Colours of the classes of points, and sparse glyphs that distinguish them in grey prints."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from ...plot import style
from ...plot.style import Look
from ...record import record


@record
class Class:
    colour: str
    dark: str
    glyph: str = ""  # matplotlib marker
    says: str = ""  # the text in the legend, if not the name of the class


# The legend lists the classes in this order.
CLASSES = {
    "bounded": Class("#DCEBF5", "#22333F"),
    "out of phase": Class("#B5D3E8", "#33566E", says="bounded, the phase is lost"),
    "exchange": Class("#E8A58C", style.RED, "v", "exchange between coordinates"),
    "constant lost": Class("#B98A5E", "#8A5F38", "+", "another constant is lost"),
    "drifting by less than 1 %": Class("#F7F1B5", "#4A4726", "_"),
    "drifting": Class("#D8C41C", "#A79A1F", ">"),
    "wrong amplitude": Class("#C9DDB4", "#4C6238", "<", "it settles at a wrong amplitude"),
    "growing": Class("#D98A00", style.ORANGE, "^"),
    "wrong branch": Class(style.BLUE, "#2E7FB8", "d"),
    "not converged": Class(style.PURPLE, style.PURPLE, "x"),
    "not finite": Class("#444444", "#000000", "o"),
    "singular": Class(style.GREEN, style.GREEN, "|"),
    "off constraints": Class("#9C6BA0", "#7A4E80", "*"),
    "failed": Class("#999999", "#777777", "s"),
    "not judged": Class("#FFFFFF", style.DARK_GROUND, ".", "not judged: it leaves by itself"),
}
SIZE = 2.6  # size of a glyph, in points
# Least distances, in points: of two glyphs of the same class, and of any two glyphs.
APART, CLEAR = 17.0, 8.0
MARGIN = 0.25  # an isolated cell is drawn as a smaller square with this margin, relative to a cell
UNCONFIRMED = "unconfirmed"
DEEP = 2  # radius in cells of the neighbourhood that measures the depth inside a region


def edges(values: np.ndarray) -> np.ndarray:
    """Returns the borders of the cells of a row or column, whose centres are the ascending
    `values`."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middles = (values[1:] + values[:-1]) / 2
    first, last = values[0] - (middles[0] - values[0]), values[-1] + (values[-1] - middles[-1])
    return np.concatenate([[first], middles, [last]])


def _cells(kinds: list[list[str]]) -> np.ndarray:
    """Returns the classes of a map as their places in CLASSES."""
    order = list(CLASSES)
    return np.array([[order.index(kind) for kind in row] for row in kinds])


def fill(axes: plt.Axes, hs: np.ndarray, xs: np.ndarray, kinds: list[list[str]], look: Look) -> set:
    """Colours the cells of a map, each by the class of its point. `kinds` has the classes, with a
    row for each element of xs and a column for each element of hs. Returns the classes drawn."""
    order = list(CLASSES)
    cells = _cells(kinds)
    colours = ListedColormap([_colour(kind, look) for kind in order])
    norm = BoundaryNorm(np.arange(len(order) + 1) - 0.5, len(order))
    alone = _alone(cells)
    around = np.where(alone, _around(cells), cells)
    how = {"cmap": colours, "norm": norm, "rasterized": True}
    axes.pcolormesh(edges(hs), edges(xs), around, **how)
    h, x, parts = edges(hs), edges(xs), np.argwhere(alone)
    left, wide = h[:-1] + MARGIN * np.diff(h), (1 - 2 * MARGIN) * np.diff(h)
    low, high = x[:-1] + MARGIN * np.diff(x), (1 - 2 * MARGIN) * np.diff(x)
    squares = [Rectangle((left[j], low[i]), wide[j], high[i]) for i, j in parts]
    fills = [_colour(order[cells[i, j]], look) for i, j in parts]
    axes.add_collection(PatchCollection(squares, fc=fills, lw=0, rasterized=True))
    used = {order[k] for k in np.unique(cells)}
    return used | {UNCONFIRMED} if alone.any() else used


def _alone(cells: np.ndarray) -> np.ndarray:
    """Returns for each cell of a map whether no neighbour has the same class. The class of such an
    isolated cell may be accidental."""
    return (_count(cells, cells, 1) == 1) & (min(cells.shape) > 1)


def _around(cells: np.ndarray) -> np.ndarray:
    """Returns the most frequent class among each cell's neighbours."""
    counts = [_count(cells, np.array(k), 1) - (cells == k) for k in range(cells.max() + 1)]
    return np.argmax(counts, axis=0)


def _count(cells: np.ndarray, kinds: np.ndarray, radius: int) -> np.ndarray:
    """Returns for each cell of a map the number of cells within `radius` that have the class in
    `kinds`: that of the cell itself, or one class for all cells."""
    padded = np.pad(cells, radius, constant_values=-1)
    near = np.lib.stride_tricks.sliding_window_view(padded, (2 * radius + 1,) * 2)
    return (near == kinds[..., None, None]).sum(axis=(2, 3))


def glyphs(
    axes: plt.Axes, hs: np.ndarray, xs: np.ndarray, kinds: list[list[str]], look: Look
) -> None:
    """Draws sparse glyphs that tell the classes of the cells. The first glyphs are placed deep
    inside the region of a class. Call this function after the layout of the figure."""
    cells, order = _cells(kinds), list(CLASSES)
    alone = _alone(cells).ravel()
    h, x = np.meshgrid(hs, xs)
    page = axes.transData.transform(np.column_stack([h.ravel(), x.ravel()])) * 72 / axes.figure.dpi
    deep = _count(cells, cells, DEEP).ravel()  # largest deep inside the region of a class
    placed: list[tuple[float, float, str]] = []
    found: dict[str, list[int]] = {}
    for k in np.argsort(-deep, kind="stable"):
        kind, (a, b) = order[cells.ravel()[k]], page[k]
        if not CLASSES[kind].glyph or alone[k]:
            continue
        if all(
            (a - p) ** 2 + (b - q) ** 2 > (APART if kind == of else CLEAR) ** 2
            for p, q, of in placed
        ):
            placed.append((a, b, kind))
            found.setdefault(kind, []).append(k)
    for kind in (kind for kind in CLASSES if kind in found):
        at = found[kind]
        axes.plot(h.ravel()[at], x.ravel()[at], **_glyph(kind, look), clip_on=True, zorder=1.5)


def _colour(kind: str, look: Look) -> str:
    return CLASSES[kind].dark if look.dark else CLASSES[kind].colour


def _glyph(kind: str, look: Look) -> dict[str, object]:
    red, green, blue = to_rgb(_colour(kind, look))
    bright = 0.3 * red + 0.59 * green + 0.11 * blue > 0.35
    ink = style.INK if bright else "#FFFFFF"
    how = {"ms": SIZE, "mec": ink, "mfc": "none", "mew": 0.5, "ls": ""}
    return {"marker": CLASSES[kind].glyph, **how}


def handles(used: set[str], look: Look) -> list[tuple]:
    """Returns legend entries: the colour and glyph of each class, and its name."""
    found = []
    for kind in (kind for kind in CLASSES if kind in used):
        patch = Patch(fc=_colour(kind, look), ec=style.GREY, lw=0.4)
        marks = (Line2D([], [], **_glyph(kind, look)),) if CLASSES[kind].glyph else ()
        found.append(((patch, *marks), CLASSES[kind].says or kind))
    if UNCONFIRMED in used:
        square = Line2D([], [], marker="s", ls="", ms=3, color=style.GREY)
        words = "unconfirmed: no cell around is alike"
        found.append(((Patch(fc="none", ec=style.GREY, lw=0.4), square), words))
    return found
