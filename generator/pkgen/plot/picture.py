"""The content of a picture, independent of rendering: panels with axes and lines."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from ..record import record

if TYPE_CHECKING:
    import numpy


@record
class Axis:
    label: str
    log: bool = False
    limits: tuple[float, float] | None = None


@record(eq=False)
class Line:
    """Points in order. `kind` is "line", "points", or "back": a pale line behind the line before
    it. `colour` is an index in the palette. If the points are of many trajectories, `strands` has
    the index at which each trajectory begins."""

    label: str
    x: numpy.ndarray
    y: numpy.ndarray
    colour: int = 0
    kind: str = "line"
    z: numpy.ndarray | None = None
    strands: numpy.ndarray | None = None
    marked: bool = False  # whether both ends of the line have a marker


@record(eq=False)
class Image:
    """A family over time as an image: `values` has a column per time and a row per member."""

    values: numpy.ndarray
    x: numpy.ndarray
    y: numpy.ndarray
    label: str


@record(eq=False)
class Panel:
    x: Axis
    y: Axis
    lines: tuple[Line, ...] = ()
    z: Axis | None = None
    image: Image | None = None
    equal: bool = False  # Whether x and y have equal scales.
    # Colour bar of strands: value at the lower end, value at the upper end, label.
    colours: tuple[float, float, str] | None = None
    tight: bool = False  # Whether the x axis ends where the lines end.

    @property
    def named(self) -> list[Line]:
        """The lines of the legend."""
        return [line for line in self.lines if line.label and line.kind != "back"]


@record(eq=False)
class Picture:
    """Panels one below another, with a common x axis if `shared`."""

    title: str
    panels: tuple[Panel, ...]
    shared: bool = True
    wide: bool = True
    notes: tuple[str, ...] = field(default=())  # messages
