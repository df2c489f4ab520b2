"""Renders pictures by matplotlib as SVG, PNG or PDF. Names are plain text, also with a `$`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, MaxNLocator

from . import style
from .picture import Axis, Image, Line, Panel, Picture
from .table import ends

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

# Panels whose lines have more points than this are rasterized, even in vector files.
HEAVY = 40_000
HEAVY_POINTS = 3000  # Panels with more separate points than this are rasterized.
# A legend with more entries than this is to the right of its panel, any other legend above it.
BESIDE = 5
TOP = 0.22  # Height of a title in inches.


def draw(picture: Picture, width: float | None = None) -> Figure:
    """Renders a picture. `width` is in inches; by default it is the width of a page for wide
    pictures, and of a column for others."""
    width = width or (style.PAGE if picture.wide else style.COLUMN)
    with matplotlib.rc_context(style.LOOK):
        figure = Figure(figsize=(width, _height(picture, width)), layout="constrained")
        FigureCanvasAgg(figure)
        space = {"projection": "3d"} if any(p.z for p in picture.panels) else {}
        cells = figure.subplots(
            len(picture.panels),
            1,
            squeeze=False,
            sharex=picture.shared and not space,
            subplot_kw=space,
        )[:, 0]
        figure.get_layout_engine().set(h_pad=0.03, w_pad=0.03, hspace=0.03)
        for k, (axes, panel) in enumerate(zip(cells, picture.panels, strict=True)):
            last = k == len(cells) - 1 or not picture.shared
            _panel(figure, axes, panel, last)
        if picture.title:
            title = figure.suptitle(picture.title, x=0.01, ha="left", fontsize=8, color=style.GREY)
            title.set_parse_math(False)
        figure.align_ylabels(list(cells))
    return figure


def encoded(
    picture: Picture, kind: str, width: float | None = None, dpi: float | None = None
) -> bytes:
    """Returns the content of a file of the picture, in one of style.FORMATS."""
    figure = draw(picture, width)
    with matplotlib.rc_context(style.LOOK):
        usual = style.DPI if kind == "png" else style.DPI_WITHIN
        return style.encoded(figure, kind, dpi or usual)


def _height(picture: Picture, width: float) -> float:
    count = len(picture.panels)
    if any(panel.z for panel in picture.panels):
        return 0.95 * width
    if not picture.wide:
        return _of_plane(picture.panels[0], width)
    one = {1: 2.5, 2: 1.9, 3: 1.55}.get(count, 1.35)
    return TOP * bool(picture.title) + 0.35 + one * count * min(1.0, (width / style.PAGE) ** 0.5)


def _of_plane(panel: Panel, width: float) -> float:
    """Returns the height, in inches, of a panel in which y is drawn over x. If both axes must have
    equal scales, the height follows from the ranges, within limits."""
    if not panel.equal:
        return 0.86 * width
    x0, x1 = panel.x.limits or _span(panel.lines, "x")
    y0, y1 = panel.y.limits or _span(panel.lines, "y")
    ratio = (y1 - y0) / (x1 - x0) if x1 > x0 else 1.0
    return min(1.7, max(0.3, ratio)) * (width - 0.7) + 0.75


def _span(lines: tuple[Line, ...], name: str) -> tuple[float, float]:
    return ends(numpy.concatenate([getattr(line, name) for line in lines] or [numpy.zeros(0)]))


def _panel(figure: Figure, axes: Axes, panel: Panel, last: bool) -> None:
    axes.set_axisbelow(True)
    if panel.image is not None:
        _image(figure, axes, panel.image)
    else:
        axes.grid(True)
    # Too many points for a vector file.
    points = sum(len(line.x) for line in panel.lines if line.kind == "points")
    heavy = points > HEAVY_POINTS or sum(len(line.x) for line in panel.lines) > HEAVY
    for line in panel.lines:
        _line(axes, panel, line, heavy)
    if panel.colours is not None:
        low, high, what = panel.colours
        range_ = matplotlib.colors.Normalize(low, high)
        bar = _bar(figure, axes, matplotlib.cm.ScalarMappable(range_, style.SEQUENTIAL), what)
        bar.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    _axis(axes, "x", panel.x, last)
    _axis(axes, "y", panel.y, True)
    if panel.z is not None:
        _space(axes, panel)
    if panel.tight:
        axes.margins(x=0.0)
    if panel.equal and panel.z is None:
        axes.set_aspect("equal", adjustable="box", anchor="W")
    _legend(axes, panel)


def _bar(figure: Figure, axes: Axes, shown: ScalarMappable, label: str) -> Axes:
    bar = figure.colorbar(shown, ax=axes, pad=0.01, aspect=28, fraction=0.05)
    bar.outline.set_visible(False)
    bar.ax.set_ylabel(label, parse_math=False)
    return bar.ax


def _axis(axes: Axes, which: str, axis: Axis, named: bool) -> None:
    if axis.log:
        getattr(axes, f"set_{which}scale")("log")
        of = getattr(axes, f"{which}axis")
        of.set_major_locator(LogLocator(numticks=8))
    if axis.limits is not None:
        getattr(axes, f"set_{which}lim")(*axis.limits)
    if named:
        getattr(axes, f"set_{which}label")(axis.label, parse_math=False)


def _line(axes: Axes, panel: Panel, line: Line, heavy: bool) -> None:
    colour, space = style.colour(line.colour), panel.z is not None
    points = numpy.stack([line.x, line.y, line.z] if space else [line.x, line.y])
    if line.kind == "points":
        many = len(line.x)
        size = 9.0 if many < 60 else 4.0 if many < 1000 else 1.2 if many < 20000 else 0.3
        look = {"s": 2.0, "depthshade": False} if space else {"s": size, "rasterized": heavy}
        colours = {"color": colour}
        if line.strands is not None and panel.colours is not None:
            colours = {"c": _numbers(line, panel), "cmap": style.SEQUENTIAL}
        axes.scatter(*points, lw=0, **look, **colours)
    elif line.strands is not None and not space:
        _strands(axes, panel, line, heavy)
    else:
        look = {"lw": 0.9} if space else {"rasterized": heavy}
        look |= {"lw": 0.5, "alpha": 0.45, "zorder": 1.5} if line.kind == "back" else {}
        dashes = style.dashes(line.colour, _over(panel) and line.kind != "back")
        ends = () if line.strands is None else line.strands[1:]
        axes.plot(*numpy.insert(points, ends, numpy.nan, axis=1), color=colour, ls=dashes, **look)
    if line.marked:
        good = numpy.flatnonzero(numpy.isfinite(points.sum(axis=0)))
        for at, face in zip(good[[0, -1]] if len(good) else (), ("white", colour), strict=False):
            look = {"ms": 3.6, "mec": colour, "mfc": face, "mew": 0.9, "zorder": 4}
            axes.plot(*points[:, [at]], "o", **look)


def _numbers(line: Line, panel: Panel) -> numpy.ndarray:
    """Returns, for each point of the line, the number of its member. The colour of the point shows
    this number."""
    low, high, _ = panel.colours
    counts = numpy.diff([*line.strands, len(line.x)])
    return numpy.repeat(numpy.linspace(low, high, len(counts)), counts)


def _strands(axes: Axes, panel: Panel, line: Line, heavy: bool) -> None:
    points = numpy.column_stack([line.x, line.y])
    parts = numpy.split(points, line.strands[1:])
    count, colours = len(parts), style.colour(line.colour)
    look = {"lw": 0.9 if count < 30 else 0.5, "alpha": max(0.06, min(0.9, 12 / count**0.75))}
    if panel.colours is not None:
        colours = matplotlib.colormaps[style.SEQUENTIAL](numpy.linspace(0, 1, count))
    axes.add_collection(LineCollection(parts, colors=colours, rasterized=heavy, **look))
    axes.autoscale_view()


def _space(axes: Axes, panel: Panel) -> None:
    axes.set_zlabel(panel.z.label, parse_math=False)
    axes.tick_params(pad=-2, labelsize=6.5)
    for of in (axes.xaxis, axes.yaxis, axes.zaxis):
        of.labelpad = -3
        of.set_major_locator(MaxNLocator(5))
        of.set_pane_color((1, 1, 1, 0))
        of._axinfo["grid"].update(color=style.PALE, linewidth=0.5)
    if not panel.equal:
        return
    spans = [_span(panel.lines, name) for name in "xyz"]
    longest = max(b - a for a, b in spans) or 1.0
    # No side of the box is much shorter than the longest, even if the curve is nearly flat.
    halves = [((a + b) / 2, max((b - a) * 1.04, 0.4 * longest) / 2) for a, b in spans]
    spans = [(middle - half, middle + half) for middle, half in halves]
    longest = max(b - a for a, b in spans)
    for which, (a, b) in zip("xyz", spans, strict=True):
        getattr(axes, f"set_{which}lim")(a, b)
        few = MaxNLocator(max(2, round(5 * (b - a) / longest)))
        getattr(axes, f"{which}axis").set_major_locator(few)
    axes.set_box_aspect([b - a for a, b in spans], zoom=0.85)


def coloured(values: numpy.ndarray) -> tuple[str, float, float]:
    """Returns the name of an image's colour map, and the values at its lower and upper end."""
    low, high = ends(values)
    most = max(abs(low), abs(high)) or 1.0
    if min(-low, high) > 0.1 * most:
        return style.DIVERGING, -most, most
    return style.SEQUENTIAL, low, high


def _image(figure: Figure, axes: Axes, image: Image) -> None:
    colours, low, high = coloured(image.values)
    look = {"cmap": colours, "vmin": low, "vmax": high, "shading": "nearest", "rasterized": True}
    shown = axes.pcolormesh(image.x, image.y, image.values, **look)
    _bar(figure, axes, shown, image.label)
    axes.yaxis.set_major_locator(MaxNLocator(6, integer=True))


def _legend(axes: Axes, panel: Panel) -> None:
    named = panel.named
    if len(named) < 2 and not (named and panel.z is None and named[0].kind == "points"):
        named = [] if len(panel.lines) < 3 else named
    if not named:
        return
    handles = [_handle(line, _over(panel)) for line in named]
    beside = len(named) > BESIDE or sum(len(line.label) for line in named) > 70
    place = (
        {"loc": "upper left", "bbox_to_anchor": (1.0, 1.03)}
        if beside
        else {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": len(named)}
    )
    # Labels are set later: legend() ignores labels that begin with an underscore.
    legend = axes.legend(
        handles,
        ["x"] * len(named),
        frameon=False,
        handlelength=1.6,
        columnspacing=1.2,
        handletextpad=0.5,
        borderaxespad=0.1,
        borderpad=0.2,
        **place,
    )
    for text, line in zip(legend.get_texts(), named, strict=True):
        text.set_parse_math(False)
        text.set_text(line.label)


def _over(panel: Panel) -> bool:
    return any(line.kind == "back" for line in panel.lines)


def _handle(line: Line, over: bool) -> Line2D:
    colour = style.colour(line.colour)
    if line.kind == "points":
        return Line2D([], [], color=colour, ls="", marker="o", ms=3)
    return Line2D([], [], color=colour, ls=style.dashes(line.colour, over), lw=1.4)
