"""The content of a picture, independent of rendering: panels of lines over axes."""

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
    """Points in order. `kind`: "line", "points", or "back", a pale line that belongs to the
    previous line. `colour` is an index of the palette. A line of many trajectories has `strands`,
    the index at which each begins."""

    label: str
    x: numpy.ndarray
    y: numpy.ndarray
    colour: int = 0
    kind: str = "line"
    z: numpy.ndarray | None = None
    strands: numpy.ndarray | None = None
    marked: bool = False  # whether begin and end are marked


@record(eq=False)
class Image:
    """A family over time: `values` has a column per time, a row per member."""

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
    equal: bool = False  # whether the axes have equal scales
    colours: tuple[float, float, str] | None = None  # colour bar of strands: range and label
    tight: bool = False  # whether the x axis ends where the lines end


@record(eq=False)
class Picture:
    """Panels below each other, with a common x axis if `shared`."""

    title: str
    panels: tuple[Panel, ...]
    shared: bool = True
    wide: bool = True
    notes: tuple[str, ...] = field(default=())  # messages
