"""The settings of one run. All values are in SI."""

from __future__ import annotations

from dataclasses import replace

from ..record import record


@record
class PartSettings:
    """How a block of coordinates is integrated by itself."""

    method: str
    step: float | None
    rtol: float
    max_step: float | None = None


@record
class Shown:
    """A column of the rows: its kind, the index there."""

    kind: str  # q, v, observed, energy
    index: int
    name: str


@record
class Compared:
    """A relation between columns."""

    text: str  # the expectation as it is written
    relation: str
    a: Shown
    b: Shown
    within: Shown | None
    at: float | None  # a time
    event: int | None  # with neither: in all rows


@record
class Watched:
    """What is to be measured; a drift is of an output, or of the energy (None). Outputs that
    are hidden are made for this alone."""

    compared: tuple[Compared, ...] = ()
    drifts: tuple[int | None, ...] = ()
    hidden: tuple[int, ...] = ()

    def columns(self) -> list[Shown]:
        """Both sides of each relation, under the name of the whole."""
        sides = ((c.text, side) for c in self.compared for side in (c.a, c.b))
        return [replace(side, name=text) for text, side in sides]


NOTHING = Watched()


@record
class Settings:
    """Of one run; values in SI. Indices count flattened quantities in declaration order, those of
    parameters declared names where families are loops."""

    method: str
    until: float
    every: float | None  # None: rows at an event, or an ensemble's final states, alone
    step: float | None
    rtol: float
    atol: float | None  # None: of the motion
    iteration: str
    max_steps: int
    max_step: float | None
    parameters: tuple[tuple[int, float], ...]
    members: tuple[tuple[int, int, float], ...]  # of families kept as loops: which one, position
    inputs: tuple[tuple[int, float], ...]
    start_q: tuple[tuple[int, float], ...]
    start_v: tuple[tuple[int, float], ...]
    show: tuple[Shown, ...] = ()  # the columns behind t; none: all
    at: int | None = None  # the event that has rows
    # Of members "events", or "times" too, are looked for, "": none; "none": no drifts either.
    watch: str = ""
    diagnose: tuple[str, ...] = ()
    watched: Watched = NOTHING  # what a scene expects
    rows: str = ""  # land or dense: by steps that end there, or between steps; "": as it is best
    accuracy: float | None = None  # promised, by a method that is yet to be chosen
    compiled_for: tuple[str, ...] = ()  # methods that are fastest in the program; none: its own
    parts: tuple[PartSettings, ...] = ()  # none: all as the whole
    units: bool = False  # in the header
