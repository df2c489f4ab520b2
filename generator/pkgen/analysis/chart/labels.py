"""Places the names of curves without overlaps: each gets the free position nearest to its anchor,
the most important name first.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy

from ...record import record

if TYPE_CHECKING:
    from matplotlib.transforms import Bbox

PAD = 1.0  # margin around a label, in points
# Vertical offsets of a label from its anchor, in label heights, in the order of preference. Each
# offset is tried to the left and to the right of the anchor.
REACH = (0.0, 0.6, -0.6, 1.1, -1.1, 1.7, -1.7, 2.4, -2.4, 3.2, -3.2, 4.2, -4.2, 5.5, -5.5, 7, -7)
# A label takes the position with the least cost. Each point of a curve under the label costs
# COVERED, each label height of vertical distance from the anchor costs FAR. A full overlap with
# another label costs 4.
COVERED = 0.35
FAR = 0.12


@record
class Label:
    text: str
    x: float  # in data coordinates
    y: float
    colour: str
    size: float
    bold: bool = False


def place(axes, labels: list[Label], curves: list[tuple[list[float], list[float]]]) -> None:
    """Writes the labels into the axes, not over the `curves` if possible. The limits of the axes
    and the layout of the figure must be final."""
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    scale = figure.dpi / 72
    frame = axes.get_window_extent(renderer)
    along = [_along(axes.transData.transform, xs, ys) for xs, ys in curves]
    covered = numpy.concatenate([numpy.empty((0, 2)), *along])
    taken: list[Bbox] = []
    for label in labels:
        weight = "bold" if label.bold else "normal"
        text = axes.text(
            0, 0, label.text, fontsize=label.size, weight=weight, color=label.colour, zorder=9
        )
        text.set_bbox({"fc": axes.get_facecolor(), "ec": "none", "alpha": 0.7, "pad": 0.3})
        extent = text.get_window_extent(renderer)
        width, height = extent.width, extent.height * 0.85
        x, y = axes.transData.transform((label.x, label.y))
        best, price = None, math.inf
        for box in _places(x, y, width, height, 5 * scale):
            found = _price(box, taken, covered, frame) + FAR * abs(box.y0 + height / 2 - y) / height
            if box.x0 > x:
                found += 0.3
            if found < price:
                best, price = box, found
        assert best is not None
        taken.append(best)
        inverse = axes.transData.inverted()
        text.set_position(inverse.transform((best.x0, (best.y0 + best.y1) / 2)))
        text.set_verticalalignment("center")
        if abs((best.y0 + best.y1) / 2 - y) > 0.9 * height:
            near = (best.x0 if best.x0 > x else best.x1, (best.y0 + best.y1) / 2)
            ends = inverse.transform([(x, y), near])
            axes.plot(*zip(*ends, strict=True), color=label.colour, lw=0.4, zorder=8, clip_on=False)


def _places(x: float, y: float, width: float, height: float, gap: float) -> Iterator[Bbox]:
    from matplotlib.transforms import Bbox

    for reach in REACH:
        bottom = y + (reach - 0.5) * height
        for left in (x - gap - abs(reach) * 1.5 - width, x + gap):
            yield Bbox.from_bounds(left, bottom, width, height).padded(PAD)


def _price(box: Bbox, taken: list[Bbox], covered: numpy.ndarray, room: Bbox) -> float:
    shared = (box.intersection(box, other) for other in taken)
    price = sum(4.0 * x.width * x.height / (box.width * box.height) for x in shared if x)
    inside = ((covered >= box.min) & (covered <= box.max)).all(axis=1)
    price += COVERED * min(3, inside.sum())
    if box.x0 < room.x0 or box.x1 > room.x1 or box.y0 < room.y0 or box.y1 > room.y1:
        price += 5.0
    return price


def _along(transform, xs: list[float], ys: list[float]) -> numpy.ndarray:
    """Returns points along a curve, in pixels. Successive points are closer together than the size
    of a label."""
    ends = transform(numpy.column_stack([xs, ys]))
    parts = [numpy.linspace(a, b, 1 + int(math.dist(a, b) / 6)) for a, b in pairwise(ends)]
    return numpy.concatenate([*parts, ends[-1:]])
