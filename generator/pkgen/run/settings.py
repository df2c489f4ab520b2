"""The settings of one run. All values are in SI."""

from __future__ import annotations

from dataclasses import replace

from ..record import record


@record
class PartSettings:
    """Settings of one block of coordinates that is integrated by itself."""

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
    """A relation between columns."""

    text: str  # the text of the expectation in the model
    relation: str  # =, < or >
    a: Shown
    b: Shown
    within: Shown | None  # tolerance
    at: float | None  # time of the check
    event: int | None  # event of the check; if both are None: in all rows


@record
class Watched:
    """Relations to check and drifts to measure, of outputs by index or of the energy (None).
    `hidden` outputs exist only for this."""

    compared: tuple[Compared, ...] = ()
    drifts: tuple[int | None, ...] = ()
    hidden: tuple[int, ...] = ()

    def columns(self) -> list[Shown]:
        """Returns both sides of each relation, each named with the text of the relation."""
        sides = ((c.text, side) for c in self.compared for side in (c.a, c.b))
        return [replace(side, name=text) for text, side in sides]


NOTHING = Watched()


@record
class Settings:
    """Settings of one run, in SI units. Indices count flattened quantities in declaration order; if
    families are kept as loops, parameters are counted by declared name."""

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
    members: tuple[tuple[int, int, float], ...]  # in loops over families: (index, position, value)
    inputs: tuple[tuple[int, float], ...]
    start_q: tuple[tuple[int, float], ...]
    start_v: tuple[tuple[int, float], ...]
    show: tuple[Shown, ...] = ()  # the columns after t; (): all
    at: int | None = None  # the event whose occurrences are rows
    # Ensemble members: "events" detects events, "times" also reports first times. "": neither.
    # "none": neither, and no drifts.
    watch: str = ""
    diagnose: tuple[str, ...] = ()
    watched: Watched = NOTHING  # expectations of a scene
    rows: str = ""  # "land": steps end at rows; "dense": dense output; "": whichever is better
    accuracy: float | None = None  # promised accuracy, while the method is still to be chosen
    compiled_for: tuple[str, ...] = ()  # methods with inlined steps; (): `method` and of `parts`
    parts: tuple[PartSettings, ...] = ()  # (): all coordinates together
    units: bool = False  # whether the CSV header has units
