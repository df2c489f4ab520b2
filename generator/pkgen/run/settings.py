"""The settings of one run, in SI units."""

from __future__ import annotations

from dataclasses import replace

from ..record import record


@record
class PartSettings:
    """Settings of one block of coordinates that is integrated separately."""

    method: str
    step: float | None
    rtol: float
    max_step: float | None = None


@record
class Shown:
    """A column of the rows: its kind, and its index among the columns of that kind."""

    kind: str  # q, v, observed, energy
    index: int
    name: str


@record
class Compared:
    """A relation between two columns that a run checks."""

    text: str  # text of the expectation in the model
    relation: str  # =, < or >
    a: Shown
    b: Shown
    within: Shown | None  # tolerance
    at: float | None  # time of the check
    event: int | None  # event of the check; without time and event it is in all rows


@record
class Watched:
    """Relations to check, and drifts to measure: those of outputs, given by index, or of the energy
    (None). The outputs `hidden` are computed only for this."""

    compared: tuple[Compared, ...] = ()
    drifts: tuple[int | None, ...] = ()
    hidden: tuple[int, ...] = ()

    def columns(self) -> list[Shown]:
        """Returns both sides of each relation as columns, named by the text of the relation."""
        sides = ((c.text, side) for c in self.compared for side in (c.a, c.b))
        return [replace(side, name=text) for text, side in sides]


NOTHING = Watched()


@record
class Settings:
    """Settings of one run, in SI units. Indices count single quantities in declaration order; if
    families are kept as loops, indices of parameters count declarations."""

    method: str
    until: float
    every: float | None  # None: rows only at event `at`, or final states of an ensemble
    step: float | None
    rtol: float
    atol: float | None  # None: chosen from the motion
    iteration: str
    max_steps: int
    max_step: float | None
    parameters: tuple[tuple[int, float], ...]
    members: tuple[tuple[int, int, float], ...]  # families kept as loops: (index, position, value)
    inputs: tuple[tuple[int, float], ...]
    start_q: tuple[tuple[int, float], ...]
    start_v: tuple[tuple[int, float], ...]
    show: tuple[Shown, ...] = ()  # the columns after t; (): all columns
    at: int | None = None  # index of the event at which rows are written
    # For ensembles: "events" detects events, "times" also reports first times, "" does neither,
    # "none" does neither and measures no drifts.
    watch: str = ""
    diagnose: tuple[str, ...] = ()
    watched: Watched = NOTHING  # checks of a scene's expectations
    rows: str = ""  # "land": steps end at rows; "dense": dense output; "": whichever is better
    accuracy: float | None = None  # promised accuracy, if the method is still to be chosen
    compiled_for: tuple[str, ...] = ()  # with inlined steps; (): `method` and those of `parts`
    parts: tuple[PartSettings, ...] = ()  # (): all coordinates are integrated together
    units: bool = False  # whether the CSV header has units
