"""The settings of one run, in SI units."""

from __future__ import annotations

from dataclasses import replace

from ..functions.tables import Data
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
    """A column of the output rows: its kind, and its index among the quantities of this kind."""

    kind: str  # "q", "v", "observed" or "energy"
    index: int
    name: str


@record
class Compared:
    """A relation between two columns that a run checks."""

    text: str  # the expectation as it is written in the model's file
    relation: str  # =, < or >
    a: Shown
    b: Shown
    within: Shown | None  # the tolerance of the relation
    at: float | None  # the time at which the relation is checked
    event: int | None  # the event at which it is checked; in all rows if `at` and `event` are None


@record
class Watched:
    """Relations that a run checks, and drifts that it measures. `drifts` has the indices of the
    outputs whose drift is measured; None in it means the energy. The outputs in `hidden` are only
    computed for these checks, and are no columns."""

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
    every: float | None  # time between rows; None: rows at event `at`, or final states
    step: float | None
    rtol: float
    atol: float | None  # absolute tolerance; None: it is chosen from the motion
    iteration: str
    max_steps: int
    max_step: float | None
    parameters: tuple[tuple[int, float], ...]
    members: tuple[tuple[int, int, float], ...]  # (family, member, value)
    inputs: tuple[tuple[int, float], ...]
    start_q: tuple[tuple[int, float], ...]
    start_v: tuple[tuple[int, float], ...]
    show: tuple[Shown, ...] = ()  # the columns after t; (): all columns
    at: int | None = None  # index of the event at which rows are written
    # For ensembles: with "events" the members detect events, with "times" they also report when
    # each event first occurs, with "" they do neither, with "none" they moreover measure no drifts.
    watch: str = ""
    diagnose: tuple[str, ...] = ()
    tables: tuple[tuple[int, Data], ...] = ()  # those that are not written in C
    watched: Watched = NOTHING  # relations and drifts of the scene's expectations
    rows: str = ""  # "land": steps end at rows; "dense": dense output; "": whichever is better
    accuracy: float | None = None  # if it is set, the method is still to be chosen
    compiled_for: tuple[str, ...] = ()  # methods with inlined steps; (): those that run
    parts: tuple[PartSettings, ...] = ()  # (): all coordinates are integrated together
    seed: int = 0  # of noise
    units: bool = False  # whether the CSV header has units

    @property
    def methods(self) -> tuple[str, ...]:
        """The methods whose steps are inlined."""
        return self.compiled_for or (self.method, *(part.method for part in self.parts))
