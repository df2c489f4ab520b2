"""A graph next to the motion: a column over time, which grows during the film."""

from __future__ import annotations

import numpy

from pkgen.equations import Quantity
from pkgen.plot.style import BLUE

from .motion import Motion
from .tracks import Track

SCENE = 0.6  # fraction of the picture's width for the motion
PALE = "#CCCCCC"


def graph(
    motion: Motion, quantity: Quantity, size: tuple[int, int]
) -> tuple[list[Track], list[tuple[str, float, float]]]:
    """Returns the graph as tracks (lines at both limits, a line at 0 if 0 is between them, the
    curve), and its texts (the name of the quantity, and both limits)."""
    width, height = size
    unit = min(size) / 720
    left, right = (SCENE + 0.08) * width, width - 24 * unit
    low, high = 0.2 * height, 0.8 * height
    values = motion.beside
    least, most = float(values.min()), float(values.max())
    middle, span = (least + most) / 2, (most - least) or 1.0
    frames = len(motion.t[:: motion.fine])
    # Shapes are drawn in order of depth; this depth draws the graph last, above the motion.
    depth = numpy.full(frames, numpy.inf)

    def at(value: numpy.ndarray | float) -> numpy.ndarray:
        return (low + high) / 2 + (numpy.asarray(value) - middle) / span * (high - low)

    def line(y: float) -> Track:
        points = numpy.tile([[left, y], [right, y]], (frames, 1, 1))
        return Track("path", points, depth, PALE, 1.5 * unit)

    found = [line(float(at(y))) for y in (least, most)]
    if least < 0 < most:
        found.append(line(float(at(0.0))))
    x = left + (right - left) * (motion.t - motion.t[0]) / ((motion.t[-1] - motion.t[0]) or 1.0)
    last = numpy.arange(frames) * motion.fine
    span_of = numpy.stack([numpy.zeros(frames, int), last], axis=1)
    curve = numpy.stack([x, at(values)], axis=1)[None]
    found.append(Track("graph", curve, depth, BLUE, 2.5 * unit, span=span_of))
    point = numpy.stack([x[last], at(values)[last]], axis=1)[:, None]
    found.append(Track("disc", point, depth, BLUE, 0.0, BLUE, radius=5 * unit))
    name = f"{quantity.name} [{quantity.unit}]" if quantity.unit else quantity.name
    texts = [(name, left, high + 44 * unit)]
    texts += [(f"{most:.3g}", left, high + 8 * unit)]
    texts += [(f"{least:.3g}", left, low - 26 * unit)] if least < most else []
    return found, texts
