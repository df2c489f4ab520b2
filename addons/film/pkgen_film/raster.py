"""Draws frames by matplotlib's Agg renderer, without figures: a frame takes a few milliseconds."""

from __future__ import annotations

from itertools import pairwise

import matplotlib
import numpy
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgba
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, IdentityTransform

from pkgen.plot.style import GREY, INK

from .tracks import BESIDE, Track

Label = tuple[str, float, float]  # a text and its position, in pixels from the lower left

FADES = 6  # A trail is drawn in this number of pieces; older pieces are paler.
CIRCLE = Path.unit_circle()


class Raster:
    def __init__(self, tracks: list[Track], size: tuple[int, int], texts: list[Label]):
        self.tracks, self.size, self.texts = tracks, size, texts
        self.renderer = RendererAgg(*size, 72)
        self.unit = min(size) / 720
        self.font = FontProperties(family="DejaVu Sans", size=22 * self.unit)
        self.small = FontProperties(family="DejaVu Sans", size=16 * self.unit)
        self.named = [t for t in tracks if t.label]
        self.depth = numpy.stack([t.depth for t in tracks]) if tracks else numpy.zeros((0, 1))

    def frame(self, k: int, time: str) -> numpy.ndarray:
        """Returns frame k as RGBA, of shape (height, width, 4)."""
        self.renderer.clear()
        self._background()
        for index in numpy.argsort(self.depth[:, k], kind="stable"):
            self._track(self.tracks[index], k)
        with matplotlib.rc_context({"text.parse_math": False}):
            if time:
                self._text(time, 20 * self.unit, 20 * self.unit, INK)
            for track in self.named:
                self._name(track, k)
            for text, x, y in self.texts:
                self._text(text, x, y, GREY)
        return numpy.array(self.renderer.buffer_rgba())

    def _background(self) -> None:
        width, height = self.size
        page = numpy.array([[0, 0], [width, 0], [width, height], [0, height], [0, 0]], float)
        self._draw(page, "", 0.0, "#FFFFFF")

    def _track(self, track: Track, k: int) -> None:
        if track.kind == "trail":
            self._trail(track, k)
            return
        if track.kind == "graph":
            self._draw(track.points[0, : track.span[k, 1] + 1], track.colour, track.width, "")
            return
        points = track.points[k]
        points = points[numpy.isfinite(points).all(axis=1)] if track.kind == "cloud" else points
        if not numpy.isfinite(points).all():
            return
        if track.kind == "disc":
            turn = Affine2D().scale(track.radius).translate(*points[0])
            self._stroke(CIRCLE, turn, track.colour, track.width, track.fill, 1.0)
            return
        if track.kind == "cloud":
            self._cloud(points, track)
            return
        if track.closed:
            points = numpy.concatenate([points, points[:1]])
        self._draw(points, track.colour, track.width, track.fill)

    def _cloud(self, points: numpy.ndarray, track: Track) -> None:
        gc = self.renderer.new_gc()
        gc.set_linewidth(0)
        gc.set_alpha(track.alpha)
        small = Affine2D().scale(track.radius)
        fill = to_rgba(track.colour, track.alpha)
        self.renderer.draw_markers(gc, CIRCLE, small, Path(points), IdentityTransform(), fill)
        gc.restore()

    def _trail(self, track: Track, k: int) -> None:
        a, b = track.span[k]
        cuts = numpy.linspace(a, b, FADES + 1).round().astype(int)
        for part, (i, j) in enumerate(pairwise(cuts)):
            if j > i:
                points = track.points[0, i : j + 1]
                points = points[numpy.isfinite(points).all(axis=1)]
                alpha = track.alpha * (part + 1) / FADES
                self._draw(points, track.colour, track.width, "", alpha)

    def _draw(
        self, points: numpy.ndarray, colour: str, width: float, fill: str, alpha: float = 1.0
    ) -> None:
        self._stroke(Path(points), IdentityTransform(), colour, width, fill, alpha)

    def _stroke(
        self, path: Path, turn: object, colour: str, width: float, fill: str, alpha: float
    ) -> None:
        gc = self.renderer.new_gc()
        gc.set_capstyle("round")
        gc.set_joinstyle("round")
        gc.set_linewidth(width if colour else 0.0)
        gc.set_foreground(colour or fill)
        gc.set_alpha(alpha)
        self.renderer.draw_path(gc, path, turn, to_rgba(fill) if fill else None)
        gc.restore()

    def _name(self, track: Track, k: int) -> None:
        (x, y), unit = track.points[k][0], self.unit
        if numpy.isfinite([x, y]).all():
            beside = x + track.radius + BESIDE * unit
            self._text(track.label, beside, y + BESIDE * unit, GREY, self.small)

    def _text(
        self, text: str, x: float, y: float, colour: str, font: FontProperties | None = None
    ) -> None:
        gc = self.renderer.new_gc()
        gc.set_foreground(colour)
        self.renderer.draw_text(gc, x, self.size[1] - y, text, font or self.font, 0)
        gc.restore()
