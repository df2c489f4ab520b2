"""Converts the shapes of a drawing to tracks: points in pixels at each frame.

A track has the same number of points in all frames, so that an animated SVG can move them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy

from pkgen.plot.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, SKY
from pkgen.record import record

from .camera import Camera, fitted, turn_of
from .levels import levels
from .meshes import Mesh, mesh
from .motion import Motion

COLOURS = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)
BOB = 0.018  # Default radius of a bob, relative to the picture's shorter side.
ARROW = 9.0  # Length of an arrow's head in pixels, in a picture 720 pixels high.
NAMED = 6  # If a drawing has more bobs than this, the names of bobs are not shown.
BESIDE = 6.0  # Pixels from a bob to its name, in a picture 720 pixels high.
TURNS = 40  # Number of points by which a circle is drawn.
TONES = ((0.36, 0.60, 0.80), (0.93, 0.88, 0.76))
LIGHT = numpy.array([-0.4, 0.75, 0.55]) / numpy.linalg.norm([-0.4, 0.75, 0.55])
REST = 1e-9


@record(eq=False)
class Track:
    """A shape in all frames. `points`, of shape (frames, n, 2), is in pixels from the lower left
    corner; `depth` has a number per frame. A disc has one point and a radius. A trail has the
    points of all samples, and `span` has the indices of its first and last point in each frame."""

    kind: str  # path, disc, trail, cloud, or graph (a trail that does not fade)
    points: numpy.ndarray
    depth: numpy.ndarray
    colour: str
    width: float = 1.5
    fill: str = ""
    closed: bool = False
    radius: float = 0.0
    span: numpy.ndarray | None = None
    alpha: float = 1.0
    label: str = ""  # text next to a disc


def tracks(drawing: dict, motion: Motion, size: tuple[int, int]) -> tuple[list[Track], Camera]:
    """Returns the tracks of all shapes, those of the background first; and the camera."""
    made = _Maker(drawing, motion, size)
    found = [track for shape in made.shapes for track in made.tracks(shape)]
    return found, made.camera


class _Maker:
    def __init__(self, drawing: dict, motion: Motion, size: tuple[int, int]):
        self.motion, self.view = motion, drawing["view"]
        self.shapes = sorted(drawing["shapes"], key=lambda s: _BEHIND.get(s["kind"], 1))
        self.frames = slice(None, None, motion.fine)
        self.unit = min(size) / 720  # scale factor of line widths
        self.colours: dict[str, str] = {}
        bobs = sum(shape["kind"] == "bob" for shape in self.shapes)
        self.many, self.named = bobs > len(COLOURS), bobs <= NAMED
        width = drawing["view"]["width"]
        self.given = None if width is None else float(motion.number(width)[0])
        self.camera = fitted(turn_of(self.view), self._extent(), size, self.given)

    # -- extent --------------------------------------------------------------------------------

    def _extent(self) -> numpy.ndarray:
        """Returns all points of all frames, including the extents of bodies and circles."""
        found = [numpy.zeros((0, 3))]
        for shape in self.shapes:
            for points, reach in self._places(shape):
                found += [points + offset for offset in _offsets(reach)]
        return numpy.concatenate(found)

    def _places(self, shape: dict) -> Iterator[tuple[numpy.ndarray, float]]:
        point, number = self.motion.point, self.motion.number
        match shape["kind"]:
            case "rod" | "spring" | "line":
                yield point(shape["from"]), 0.0
                yield point(shape["to"]), 0.0
            case "bob" | "circle":
                radius = shape.get("radius")
                most = 0.0 if radius is None else float(numpy.nanmax(number(radius)))
                yield point(shape["at"]), most
            case "trail":
                yield point(shape["at"]), 0.0
            case "arrow":
                yield point(shape["at"]), 0.0
                yield point(shape["at"]) + point(shape["vector"]), 0.0
            case "body":
                corners = self._corners(shape, mesh(shape["form"], self._sizes(shape)))
                yield corners.reshape(-1, 3), 0.0
            case "curve":
                for entries in shape["points"]:
                    yield point(entries), 0.0

    # -- tracks ------------------------------------------------------------------------------

    def tracks(self, shape: dict) -> Iterator[Track]:
        make = getattr(self, f"_{shape['kind']}", None)
        if make is not None:
            yield from make(shape)

    def _colour(self, shape: dict) -> str:
        """Returns the colour of a shape. A bob and a trail of the same point have the same colour.
        If the drawing has many bobs, all bobs have one colour."""
        key = repr((shape.get("at"), shape.get("vector")))
        if self.many and shape["kind"] == "bob":
            return BLUE
        return self.colours.setdefault(key, COLOURS[len(self.colours) % len(COLOURS)])

    def _path(self, points: numpy.ndarray, colour: str, width: float, **more: object) -> Track:
        """Returns the track of a line through points in space, of shape (samples, n, 3)."""
        seen = self.camera.seen(points[self.frames])
        return Track(
            "path", seen[..., :2], seen[..., 2].mean(axis=1), colour, width * self.unit, **more
        )

    def _both(self, shape: dict) -> numpy.ndarray:
        return numpy.stack([self.motion.point(shape["from"]), self.motion.point(shape["to"])], 1)

    def _rod(self, shape: dict) -> Iterator[Track]:
        yield self._path(self._both(shape), INK, 4.5)
        yield from self._pivots(shape)

    def _line(self, shape: dict) -> Iterator[Track]:
        yield self._path(self._both(shape), GREY, 1.5)

    def _spring(self, shape: dict) -> Iterator[Track]:
        seen = self.camera.seen(self._both(shape)[self.frames])
        a, b = seen[:, 0, :2], seen[:, 1, :2]
        along = b - a
        length = numpy.linalg.norm(along, axis=1, keepdims=True)
        side = numpy.stack([-along[:, 1], along[:, 0]], 1) / numpy.maximum(length, REST)
        turns = int(shape.get("turns") or 8)
        parts = numpy.array([0.0, 0.06, *((k + 0.5) / (2 * turns) * 0.88 + 0.06
                                          for k in range(2 * turns)), 0.94, 1.0])  # fmt: skip
        swing = numpy.zeros(len(parts))
        swing[2:-2] = [(-1) ** k for k in range(2 * turns)]
        wide = min(12.0, 0.04 * float(numpy.nanmedian(length)) + 5.0) * self.unit
        points = a[:, None] + parts[None, :, None] * along[:, None]
        points = points + wide * swing[None, :, None] * side[:, None]
        yield Track("path", points, seen[..., 2].mean(axis=1), INK, 1.8 * self.unit)
        yield from self._pivots(shape)

    def _pivots(self, shape: dict) -> Iterator[Track]:
        """Yields a dot at each end of the rod or spring `shape` that does not move."""
        for end in ("from", "to"):
            points = self.motion.point(shape[end])
            if numpy.ptp(points, axis=0).max() <= REST:
                seen = self.camera.seen(points[self.frames][:, None])
                yield Track("disc", seen[..., :2], seen[:, 0, 2], INK, 1.2 * self.unit, "#FFFFFF",
                            radius=5 * self.unit)  # fmt: skip

    def _bob(self, shape: dict) -> Iterator[Track]:
        seen = self.camera.seen(self.motion.point(shape["at"])[self.frames][:, None])
        radius = BOB * min(self.camera.size)
        if shape.get("radius") is not None:
            given = float(self.motion.number(shape["radius"])[0]) * self.camera.scale
            radius = max(given, 2.0 * self.unit)
        colour = self._colour(shape)
        label = str(shape.get("label") or shape.get("name") or "") if self.named else ""
        yield Track("disc", seen[..., :2], seen[:, 0, 2], INK, 0.8 * self.unit, colour,
                    radius=radius, label=label)  # fmt: skip

    def _circle(self, shape: dict) -> Iterator[Track]:
        normal = numpy.array(shape.get("normal") or [0, 0, 1], float)
        normal /= numpy.linalg.norm(normal)
        first = numpy.cross(normal, numpy.eye(3)[int(numpy.abs(normal).argmin())])
        first /= numpy.linalg.norm(first)
        second = numpy.cross(normal, first)
        angle = numpy.linspace(0, 2 * numpy.pi, TURNS, endpoint=False)
        ring = numpy.cos(angle)[:, None] * first + numpy.sin(angle)[:, None] * second
        radius = self.motion.number(shape["radius"])
        points = self.motion.point(shape["at"])[:, None] + radius[:, None, None] * ring[None]
        yield self._path(points, GREY, 1.6, closed=True)

    def _arrow(self, shape: dict) -> Iterator[Track]:
        at = self.motion.point(shape["at"])
        both = numpy.stack([at, at + self.motion.point(shape["vector"])], 1)
        seen = self.camera.seen(both[self.frames])
        a, b = seen[:, 0, :2], seen[:, 1, :2]
        length = numpy.linalg.norm(b - a, axis=1, keepdims=True)
        along = (b - a) / numpy.maximum(length, REST)
        side = numpy.stack([-along[:, 1], along[:, 0]], 1)
        head = numpy.minimum(ARROW * self.unit, 0.5 * length)
        left, right = b - head * along + 0.5 * head * side, b - head * along - 0.5 * head * side
        points = numpy.stack([a, b, left, b, right], 1)
        colour = self._colour(shape)
        yield Track("path", points, seen[..., 2].max(axis=1), colour, 2.6 * self.unit)

    def _curve(self, shape: dict) -> Iterator[Track]:
        points = numpy.stack([self.motion.point(p) for p in shape["points"]], 1)
        moves = bool((numpy.ptp(points, axis=0) > REST).any())
        yield self._path(points, BLUE if moves else GREY, 2.2 if moves else 1.0)

    def _trail(self, shape: dict) -> Iterator[Track]:
        """Yields the trail of a point: its path during the last `lasting` seconds of the motion,
        through all samples."""
        seen = self.camera.seen(self.motion.point(shape["at"]))
        count = len(self.motion.t)
        step = self.motion.t[1] - self.motion.t[0] if count > 1 else 1.0
        lasting = shape.get("lasting")  # None: the trail starts at time 0
        parts = count if lasting is None else float(self.motion.number(lasting)[0]) / step
        back = int(min(count, max(1, round(parts))))
        ends = numpy.arange(0, count, self.motion.fine)
        span = numpy.stack([numpy.maximum(0, ends - back), ends], 1)
        depth = seen[self.frames, 2]
        yield Track("trail", seen[None, :, :2], depth, self._colour(shape), 2.0 * self.unit,
                    span=span, alpha=0.75)  # fmt: skip

    def _ground(self, shape: dict) -> Iterator[Track]:
        at, axis = float(self.motion.number(shape["at"])[0]), "xyz".index(shape["axis"])
        centre = self.camera.centre @ self.camera.turn
        reach = 2.0 * max(self.camera.size) / self.camera.scale
        if self.view["kind"] == "space":
            yield from self._floor(axis, at, centre)
            return
        inside = [k for k in range(3) if "xyz"[k] in self.view["axes"] and k != axis]
        if len(inside) != 1 or "xyz"[axis] not in self.view["axes"]:
            return
        ends = numpy.repeat(centre[None], 2, axis=0)
        ends[:, axis] = at
        ends[:, inside[0]] += [-reach, reach]
        down = ends[::-1].copy()
        down[:, axis] = at - reach
        corners = numpy.concatenate([ends, down])
        every = numpy.broadcast_to(corners, (len(self.motion.t), 4, 3))
        track = self._path(every, "", 0.0, fill="#EFEFEA", closed=True)
        yield replace(track, depth=track.depth - 1e9)
        edge = numpy.broadcast_to(ends, (len(self.motion.t), 2, 3))
        line = self._path(edge, GREY, 1.6)
        yield replace(line, depth=line.depth - 1e9 + 1)

    def _floor(self, axis: int, at: float, centre: numpy.ndarray) -> Iterator[Track]:
        """Yields the grid of the ground, somewhat wider than the motion."""
        others = [k for k in range(3) if k != axis]
        extent = self._extent()
        for across, along in (others, others[::-1]):
            low, high = numpy.nanmin(extent, axis=0), numpy.nanmax(extent, axis=0)
            pad = 0.25 * max((high - low)[others])
            for place in numpy.linspace(low[across] - pad, high[across] + pad, 9):
                ends = numpy.zeros((2, 3))
                ends[:, axis], ends[:, across] = at, place
                ends[:, along] = low[along] - pad, high[along] + pad
                every = numpy.broadcast_to(ends, (len(self.motion.t), 2, 3))
                track = self._path(every, "#CFCFC8", 1.0)
                yield replace(track, depth=track.depth - 1e9)

    def _level(self, shape: dict) -> Iterator[Track]:
        for points in levels(shape, self.motion, self.camera):
            every = numpy.broadcast_to(points, (len(self.motion.t), *points.shape))
            track = self._path(every, "#C9C4B8", 1.0)
            yield replace(track, depth=track.depth - 1e9)

    def _body(self, shape: dict) -> Iterator[Track]:
        motion, camera = self.motion, self.camera
        solid = mesh(shape["form"], self._sizes(shape))
        at = motion.point(shape["at"])[self.frames]
        seen = camera.seen(self._corners(shape, solid))
        depth = camera.seen(at[:, None])[:, 0, 2]
        for face, tone in zip(solid.faces, solid.tones, strict=True):
            points = seen[:, list(face)]
            normal = _normals(points)
            towards = normal[:, 2]
            shown = towards > 0
            if not shown.any():
                continue
            # A face that is turned away is reduced to one point, which is invisible.
            flat = numpy.where(shown[:, None, None], points[..., :2], points[:, :1, :2])
            shade = float(numpy.mean(0.72 + 0.28 * numpy.clip(normal[shown] @ LIGHT, 0, 1)))
            fill = _hex(shade * numpy.array(TONES[tone]))
            yield Track("path", flat, depth, INK if len(solid.faces) == 6 else fill,
                        0.9 * self.unit, fill, closed=True)  # fmt: skip

    def _sizes(self, shape: dict) -> list[float]:
        return [float(self.motion.number(s)[0]) for s in shape["sizes"]]

    def _corners(self, shape: dict, solid: Mesh) -> numpy.ndarray:
        """Returns the corners of a body in each frame, of shape (frames, n, 3)."""
        at = self.motion.point(shape["at"])[self.frames]
        if shape.get("turn") is None:
            return at[:, None] + solid.corners[None]
        columns = numpy.stack([self.motion.number(x)[self.frames] for x in shape["turn"]], 1)
        # The rows of this array are the columns of the rotation matrix.
        turn = columns.reshape(len(at), 3, 3)
        return at[:, None] + numpy.einsum("fji,nj->fni", turn, solid.corners)

    def _graph(self, shape: dict) -> Iterator[Track]:
        """Yields graphs of coordinates over time, for a model that has no drawing."""
        width, height = self.camera.size
        t = self.motion.t
        columns = shape["columns"]
        x = width * (0.08 + 0.84 * (t - t[0]) / max(float(t[-1] - t[0]), REST))
        for k, column in enumerate(columns[: len(COLOURS)]):
            q = self.motion.q[:, column]
            low, high = float(numpy.nanmin(q)), float(numpy.nanmax(q))
            lane = 0.84 * height / min(len(columns), len(COLOURS))
            base = 0.92 * height - (k + 0.95) * lane
            y = base + 0.85 * lane * (q - low) / max(high - low, REST)
            points = numpy.stack([x, y], 1)
            ends = numpy.arange(0, len(t), self.motion.fine)
            span = numpy.stack([numpy.zeros_like(ends), ends], 1)
            depth = numpy.zeros(len(ends))
            colour = COLOURS[k]
            yield Track("trail", points[None], depth, colour, 2.0 * self.unit, span=span)
            at = points[self.frames][:, None]
            yield Track("disc", at, depth + 1, INK, 0.8 * self.unit, colour, radius=5 * self.unit)


_BEHIND = {"ground": 0, "level": 0}


def _offsets(reach: float) -> numpy.ndarray:
    if not reach:
        return numpy.zeros((1, 3))
    return reach * numpy.array([*numpy.eye(3), *-numpy.eye(3)])


def _normals(points: numpy.ndarray) -> numpy.ndarray:
    """Returns the outward unit normals of a face in each frame, in the axes of the camera."""
    found = numpy.zeros((len(points), 3))
    # The normal is a sum over triangles of the face: a single triangle may have two equal corners.
    for k in range(1, points.shape[1] - 1):
        found += numpy.cross(points[:, k] - points[:, 0], points[:, k + 1] - points[:, 0])
    return found / numpy.maximum(numpy.linalg.norm(found, axis=1, keepdims=True), REST)


def _hex(colour: numpy.ndarray) -> str:
    return "#" + "".join(f"{int(255 * min(1.0, max(0.0, c)) + 0.5):02X}" for c in colour)
