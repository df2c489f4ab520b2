"""Bodies as convex meshes; faces have two tones, so that rotation is visible."""

from __future__ import annotations

import numpy

from pkgen.record import record

ROUND = 20  # Number of faces around the axis of a round body.
BANDS = 8  # Bands of an ellipsoid, from pole to pole.


@record(eq=False)
class Mesh:
    """A mesh. Faces are indices of corners, anticlockwise seen from outside; tones are 0 or 1."""

    corners: numpy.ndarray  # (n, 3)
    faces: tuple[tuple[int, ...], ...]
    tones: tuple[int, ...]


def mesh(form: str, sizes: list[float]) -> Mesh:
    """Returns the mesh of a body's form; docs/dev/describe.md defines axes and sizes."""
    if form == "box":
        return _box(sizes)
    if form == "ellipsoid":
        return _ellipsoid(sizes)
    radius, height = sizes
    if form == "top":
        return _lathe([(0.0, 0.0), (radius, height)])
    return _lathe([(radius, -height / 2), (radius, height / 2)])


def _box(sizes: list[float]) -> Mesh:
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    corners = numpy.array(signs) * numpy.array(sizes) / 2
    faces = (
        (4, 6, 7, 5), (0, 1, 3, 2),
        (2, 3, 7, 6), (0, 4, 5, 1),
        (1, 5, 7, 3), (0, 2, 6, 4),
    )  # fmt: skip
    return Mesh(corners, faces, (0, 0, 0, 0, 1, 1))


def _lathe(profile: list[tuple[float, float]]) -> Mesh:
    """Returns a solid of revolution between two circles (radius, height); radius 0 is a tip."""
    angles = numpy.linspace(0, 2 * numpy.pi, ROUND, endpoint=False)
    rings = [numpy.stack([r * numpy.cos(angles), r * numpy.sin(angles), 0 * angles + z], 1)
             for r, z in profile]  # fmt: skip
    low, high = range(ROUND), range(ROUND, 2 * ROUND)
    faces: list[tuple[int, ...]] = []
    tones = []
    for k in range(ROUND):
        m = (k + 1) % ROUND
        faces.append((low[k], low[m], high[m], high[k]))
        tones.append(int(4 * k // ROUND) % 2)
    if profile[0][0]:
        faces.append(tuple(reversed(low)))
        tones.append(0)
    centre = numpy.array([[0.0, 0.0, profile[1][1]]])
    for k in range(ROUND):  # the upper cap is divided into sectors
        faces.append((2 * ROUND, high[k], high[(k + 1) % ROUND]))
        tones.append(int(4 * k // ROUND) % 2)
    return Mesh(numpy.concatenate([*rings, centre]), tuple(faces), tuple(tones))


def _ellipsoid(sizes: list[float]) -> Mesh:
    polar = numpy.linspace(0, numpy.pi, BANDS + 1)
    around = numpy.linspace(0, 2 * numpy.pi, ROUND, endpoint=False)
    unit = [[numpy.sin(p) * numpy.cos(a), numpy.sin(p) * numpy.sin(a), numpy.cos(p)]
            for p in polar for a in around]  # fmt: skip
    faces, tones = [], []
    for i in range(BANDS):
        for k in range(ROUND):
            m = (k + 1) % ROUND
            a, b = i * ROUND, (i + 1) * ROUND
            faces.append((a + k, b + k, b + m, a + m))
            tones.append((int(2 * i // BANDS) + int(4 * k // ROUND)) % 2)
    return Mesh(numpy.array(unit) * numpy.array(sizes), tuple(faces), tuple(tones))
