"""Projects space to the picture by parallel rays. A plane view looks perpendicularly at its plane;
a view of space looks from the side, slightly from above.
"""

from __future__ import annotations

import numpy

from pkgen.record import record

AZIMUTH, ELEVATION = numpy.radians(-62.0), numpy.radians(20.0)
ROOM = 0.88  # fraction of the picture that the motion fills


@record(eq=False)
class Camera:
    """A camera. The rows of `turn` are the axes of the camera: right, up, and towards the viewer.
    `centre` is the centre of the picture in coordinates along these axes. `scale` is in pixels per
    unit; `size` is (width, height) in pixels."""

    turn: numpy.ndarray
    size: tuple[int, int]
    centre: numpy.ndarray
    scale: float

    def seen(self, points: numpy.ndarray) -> numpy.ndarray:
        """Projects points (..., 3). Returns for each point its x and y in pixels from the lower
        left corner, and its depth, which is larger for nearer points."""
        found = points @ self.turn.T - self.centre
        found = found * self.scale
        found[..., 0] += self.size[0] / 2
        found[..., 1] += self.size[1] / 2
        return found


def turn_of(view: dict) -> numpy.ndarray:
    if view["kind"] == "plane":
        right, up = (numpy.eye(3)["xyz".index(axis)] for axis in view["axes"])
        return numpy.stack([right, up, numpy.cross(right, up)])
    a, e = AZIMUTH, ELEVATION
    towards = numpy.array([numpy.cos(a) * numpy.cos(e), numpy.sin(a) * numpy.cos(e), numpy.sin(e)])
    right = numpy.array([-numpy.sin(a), numpy.cos(a), 0.0])
    return numpy.stack([right, numpy.cross(towards, right), towards])


def fitted(
    turn: numpy.ndarray, points: numpy.ndarray, size: tuple[int, int], width: float | None
) -> Camera:
    """Returns a camera that shows all `points` (n, 3), and at least the given `width`."""
    seen = points[numpy.isfinite(points).all(axis=1)] @ turn.T
    if not len(seen):
        seen = numpy.zeros((1, 3))
    low, high = seen.min(axis=0), seen.max(axis=0)
    spans = numpy.maximum(high - low, 1e-9 * max(1e-9, float(numpy.abs(seen).max())))
    across = max(width or 0.0, spans[0]) if width else spans[0]
    scale = ROOM * min(size[0] / across, size[1] / spans[1])
    if not numpy.isfinite(scale) or spans[:2].max() <= 0:
        scale = 0.3 * min(size)
    return Camera(turn, size, (low + high) / 2, float(scale))
