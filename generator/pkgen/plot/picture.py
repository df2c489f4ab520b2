"""What a picture has, before anybody draws it: panels of lines over axes."""

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
    """Points in order. `kind`: "line", "points", or "back", a pale line that belongs to the one
    before it. `colour` counts in the palette; lines of many trajectories have `strands`, the index
    at which each begins."""

    label: str
    x: numpy.ndarray
    y: numpy.ndarray
    colour: int = 0
    kind: str = "line"
    z: numpy.ndarray | None = None
    strands: numpy.ndarray | None = None
    marked: bool = False  # where it begins and ends


@record(eq=False)
class Image:
    """A family over time: a column a time, a row a member."""

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
    equal: bool = False  # one length for a unit of either axis
    colours: tuple[float, float, str] | None = None  # of strands: from, to, and of what
    tight: bool = False  # its first axis ends where its lines do


@record(eq=False)
class Picture:
    """Panels below each other share their first axis where `shared`."""

    title: str
    panels: tuple[Panel, ...]
    shared: bool = True
    wide: bool = True
    notes: tuple[str, ...] = field(default=())  # what there is to say besides
