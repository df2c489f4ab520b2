"""Contours of one of the model's outputs over two coordinates. All other coordinates and rates have
their initial values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy

from .camera import Camera
from .motion import Motion

GRID = 90
LINES = 14


def levels(shape: dict, motion: Motion, camera: Camera) -> Iterator[numpy.ndarray]:
    """Yields contours as lines in space, of shape (n, 3); low values have denser contours."""
    from contourpy import contour_generator

    i, j = shape["x"], shape["y"]
    half = numpy.array(camera.size) / camera.scale / 2
    centre = camera.centre[:2]
    x = numpy.linspace(centre[0] - half[0], centre[0] + half[0], GRID)
    y = numpy.linspace(centre[1] - half[1], centre[1] + half[1], GRID)
    a, b = numpy.meshgrid(x, y)
    q = numpy.repeat(motion.q[:1], a.size, axis=0)
    v = numpy.repeat(motion.v[:1], a.size, axis=0)
    q[:, i], q[:, j] = a.ravel(), b.ravel()
    entry = shape["value"]
    if not isinstance(entry, dict):
        return
    z = motion.idle.evaluate("outputs", motion.t[:1], q, v)[:, entry["output"]].reshape(a.shape)
    good = z[numpy.isfinite(z)]
    if not len(good) or not numpy.ptp(good):
        return
    low = float(good.min())
    top = max(float(numpy.percentile(good, 60)), low + 1e-12)
    maker = contour_generator(x, y, numpy.where(numpy.isfinite(z), z, good.max()))
    for part in numpy.linspace(0, 1, LINES + 1)[1:]:
        for line in maker.lines(low + (top - low) * part**1.5):
            yield numpy.column_stack([line, numpy.zeros(len(line))])
