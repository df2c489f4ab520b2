"""Places the names of curves without overlaps: each gets the free position nearest to its anchor,
the most important name first.
"""

from __future__ import annotations

import math
from itertools import pairwise

from ...record import record

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


@record
class _Box:
    x0: float
    y0: float
    x1: float
    y1: float

    def shared(self, other: _Box) -> float:
        """Returns the area that this box shares with the other one, relative to this box."""
        w = min(self.x1, other.x1) - max(self.x0, other.x0)
        h = min(self.y1, other.y1) - max(self.y0, other.y0)
        if w <= 0 or h <= 0:
            return 0.0
        return w * h / ((self.x1 - self.x0) * (self.y1 - self.y0))

    def holds(self, x: float, y: float) -> bool:
        return self.x0 <= x <= self.x1 and self.y0 <= y <= self.y1


def place(axes, labels: list[Label], curves: list[tuple[list[float], list[float]]]) -> None:
    """Writes the labels into the axes, not over the `curves` if possible. The limits of the axes
    and the layout of the figure must be final."""
    figure = axes.figure
    renderer = figure.canvas.get_renderer()
    scale = figure.dpi / 72
    frame = axes.get_window_extent(renderer)
    room = _Box(frame.x0, frame.y0, frame.x1, frame.y1)
    covered = [p for xs, ys in curves for p in _along(axes.transData.transform, xs, ys)]
    taken: list[_Box] = []
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
            found = _price(box, taken, covered, room) + FAR * abs(box.y0 + height / 2 - y) / height
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


def _places(x: float, y: float, width: float, height: float, gap: float):
    for reach in REACH:
        middle = y + reach * height
        for left in (x - gap - abs(reach) * 1.5 - width, x + gap):
            pad = PAD
            yield _Box(
                left - pad, middle - height / 2 - pad, left + width + pad, middle + height / 2 + pad
            )


def _price(box: _Box, taken: list[_Box], covered: list[tuple[float, float]], room: _Box) -> float:
    price = sum(4.0 * box.shared(other) for other in taken)
    price += COVERED * min(3, sum(box.holds(*p) for p in covered))
    if box.x0 < room.x0 or box.x1 > room.x1 or box.y0 < room.y0 or box.y1 > room.y1:
        price += 5.0
    return price


def _along(transform, xs: list[float], ys: list[float]) -> list[tuple[float, float]]:
    """Returns points along a curve, in pixels. Successive points are closer together than the size
    of a label."""
    ends = [tuple(transform((x, y))) for x, y in zip(xs, ys, strict=True)]
    found = ends[:1]
    for (x0, y0), (x1, y1) in pairwise(ends):
        pieces = max(1, int(math.hypot(x1 - x0, y1 - y0) / 6))
        found += [
            (x0 + (x1 - x0) * k / pieces, y0 + (y1 - y0) * k / pieces) for k in range(1, pieces + 1)
        ]
    return found
