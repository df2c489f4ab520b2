"""The settings of one run, and the lines in which the driver reads them."""

from __future__ import annotations

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class PartSettings:
    """How a block of coordinates is integrated by itself."""

    method: str
    step: float | None
    rtol: float
    max_step: float | None = None

    def lines(self, k: int) -> list[str]:
        said = [f"part {k} method {self.method}"]
        if self.step is not None:
            return [*said, f"part {k} step {self.step.hex()}"]
        said.append(f"part {k} rtol {self.rtol.hex()}")
        if self.max_step is not None:
            said.append(f"part {k} h_max {self.max_step.hex()}")
        return said


@dataclass(frozen=True)
class Shown:
    """A column of the rows: the driver's word for its kind, the index there."""

    kind: str  # q, v, observed, z, energy
    index: int
    name: str

    @property
    def word(self) -> str:
        """One word for both, as lines of what is expected have it."""
        return f"{self.kind[0]}{self.index}"


@dataclass(frozen=True)
class Compared:
    """A relation between columns, as the driver reads it."""

    text: str  # the expectation as it is written
    relation: str
    a: Shown
    b: Shown
    within: Shown | None
    at: float | None  # a time
    event: int | None  # with neither: in all rows

    def line(self) -> str:
        when = "rows"
        if self.at is not None:
            when = f"t {self.at.hex()}"
        elif self.event is not None:
            when = f"event {self.event}"
        allowed = "-" if self.within is None else self.within.word
        return f"expect {self.relation} {self.a.word} {self.b.word} {allowed} {when}"


@dataclass(frozen=True)
class Watched:
    """What the driver is to measure; a drift is of an output, or of the energy (None). Outputs that
    are hidden are made for this alone."""

    compared: tuple[Compared, ...] = ()
    drifts: tuple[int | None, ...] = ()
    hidden: tuple[int, ...] = ()

    def columns(self) -> list[Shown]:
        """Both sides of each relation, under the name of the whole."""
        sides = ((c.text, side) for c in self.compared for side in (c.a, c.b))
        return [replace(side, name=text) for text, side in sides]

    def lines(self) -> list[str]:
        drifts = ("energy" if d is None else d for d in self.drifts)
        return [
            *(f"hidden {i}" for i in self.hidden),
            *(c.line() for c in self.compared),
            *(f"drift {d}" for d in drifts),
        ]


NOTHING = Watched()


@dataclass(frozen=True)
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
    watch: str = ""  # of members "events", or "times" too, are looked for; "": none
    diagnose: tuple[str, ...] = ()
    watched: Watched = NOTHING  # what a scene expects
    rows: str = ""  # land or dense: by steps that end there, or between steps; "": as it is best
    accuracy: float | None = None  # promised, by a method that is yet to be chosen
    compiled_for: tuple[str, ...] = ()  # methods that are fastest in the program; none: its own
    parts: tuple[PartSettings, ...] = ()  # none: all as the whole
    units: bool = False  # in the header

    def lines(self) -> list[str]:
        """As the driver reads them; numbers in hexadecimal, so that none is rounded."""
        said = [
            f"method {self.method}",
            f"until {self.until.hex()}",
            f"rtol {self.rtol.hex()}",
            f"iteration {self.iteration}",
            f"max_steps {self.max_steps}",
        ]
        if self.atol is not None:
            said.append(f"atol {self.atol.hex()}")
        if self.every is not None:
            said.append(f"every {self.every.hex()}")
        if self.step is not None:
            said.append(f"step {self.step.hex()}")
        if self.max_step is not None:
            said.append(f"h_max {self.max_step.hex()}")
        said += [f"param {i} {x.hex()}" for i, x in self.parameters]
        said += [f"param {i} {x.hex()} {k}" for i, k, x in self.members]
        said += [f"input {i} {x.hex()}" for i, x in self.inputs]
        said += [f"start q {i} {x.hex()}" for i, x in self.start_q]
        said += [f"start v {i} {x.hex()}" for i, x in self.start_v]
        said += [f"show {c.kind} {c.index}".replace("energy 0", "energy") for c in self.show]
        if self.rows:
            said.append(f"rows {self.rows}")
        if self.at is not None:
            said.append(f"at {self.at}")
        if self.watch:
            said.append(f"watch {self.watch}")
        said += [f"diagnose {name}" for name in self.diagnose]
        said += self.watched.lines()
        for k, part in enumerate(self.parts):
            said += part.lines(k)
        return said
