"""Asks questions about a compiled model (pk/stability.h), and returns the answers as data."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import TypeVar

from ...record import record
from ...run.library import Stability, load
from ...run.settings import Settings
from ...system.exits import UsageError

ZERO = 1e-7  # relative to the largest rate at any equilibrium; a lower rate counts as 0
SLOW = 0.01  # radians or e-foldings in the duration; a lower rate counts as round-off
UNDECIDED = "not decided by the linear terms"
TRIES = 100  # starts from which equilibria are sought
Made = TypeVar("Made")


@record
class Mode:
    """exp(lambda t), lambda = growth + i frequency; real and imaginary parts of the shape."""

    growth: float
    frequency: float
    re: tuple[float, ...]
    im: tuple[float, ...]
    on_group: bool = False  # rotation rate of a body, seen by methods on the group

    @property
    def rate(self) -> float:
        """|lambda|."""
        return math.hypot(self.growth, self.frequency)


@record
class Equilibrium:
    q: tuple[float, ...]
    v: tuple[float, ...]
    energy: float
    modes: tuple[Mode, ...]  # fastest first
    status: str = "PK_DONE"  # status of the computation of modes
    slack: int = 0  # dimension of the continuum of equilibria it belongs to

    @property
    def stable(self) -> bool:
        """Whether the modes are known, none grows, and not all have rate 0."""
        moves = not self.modes or any(mode.rate > 0 for mode in self.modes)
        return self.status == "PK_DONE" and moves and not self._grows

    @property
    def _grows(self) -> bool:
        return any(mode.growth > 0 for mode in self.modes)

    @property
    def verdict(self) -> str:
        """Describes the stability. A mode of rate 0 is undecided by the linear terms."""
        if self.status != "PK_DONE":
            return f"modes: {self.status}"
        if self._grows:
            return "unstable"
        if any(mode.rate == 0 for mode in self.modes):
            return "one of a continuum" if self.slack else UNDECIDED
        return "stable"

    @property
    def oscillating(self) -> list[int]:
        """Returns the indices of modes that oscillate and do not grow."""
        return [k for k, m in enumerate(self.modes) if m.frequency > 0 and m.growth <= 0]


@record
class Rest:
    """The equilibria found, and the region searched."""

    status: str
    equilibria: tuple[Equilibrium, ...]
    failed: int
    singular: int
    more: bool
    turns: tuple[bool, ...] = ()  # of each coordinate: whether it has the period 2 pi
    middle: tuple[float, ...] = ()  # search region: middle +- box, or further (docs/maps.md)
    box: tuple[float, ...] = ()

    def beside(self, q: float, place: float, i: int) -> float:
        """Returns q_i; an angle is shifted by whole turns to lie nearest to `place`."""
        turns = bool(self.turns) and self.turns[i]
        return q + 2 * math.pi * round((place - q) / (2 * math.pi)) if turns else q


@record
class Motion:
    """The motion itself: its end time, first energy, scale (the range of v.p), and start."""

    status: str
    t: float
    energy: float
    scale: float
    q: tuple[float, ...]
    v: tuple[float, ...]
    parameters: tuple[float, ...]
    leaves: bool = False  # it still moves away at the end
    horizon: float = math.inf  # time up to which a looser tolerance agrees
    by_norm: bool = False  # first-order variables matter: judged by distance from the start
    condition: dict | None = None  # condition numbers: `report.condition` of a run
    warning: str | None = None  # warning of an ill-conditioned motion

    @property
    def judges(self) -> bool:
        """Whether methods can be judged by this motion."""
        return self.status == "PK_DONE" and not self.leaves


@record
class Point:
    """A method's motion at step size h; rise and away are in units of the motion's scale."""

    method: str
    h: float
    kind: str
    status: str
    steps: int
    rise: float | None
    away: float | None
    cond: float | None  # condition number of the last step's equations; 0: no equations
    # The next three are None if the method fails (docs/maps.md).
    exchange: float | None = None  # largest swing of a coordinate over the motion's
    moved: float | None = None  # drift of the constant of motion that moved most
    follows: float | None = None  # part of the time in which it stays near the motion
    constant: str = ""

    @property
    def shown(self) -> str:
        """Returns its class on a map."""
        if self.kind == "bounded" and self.follows is not None and self.follows < 1:
            return "out of phase"
        if self.kind == "drifting" and self.away is not None and self.away < 0.01:
            return "drifting by less than 1 %"
        return self.kind


@record
class Close:
    """A method's motion that starts near an equilibrium."""

    status: str
    steps: int
    growth: float  # factor on the displacement; runs end at 1000
    turn: float  # mean angle per step


class TimeUp(Exception):
    """Raised when the time for questions is used up."""


class Asker:
    """Asks questions about one model with the `settings` of a run."""

    def __init__(self, program: Path, settings: Settings, left: Callable[[], float] | None = None):
        self.program, self.settings, self._left = program, settings, left
        self._stability = Stability(load(program), settings)

    def with_settings(self, settings: Settings) -> Asker:
        return Asker(self.program, settings, self._left)

    def within(self, left: Callable[[], float]) -> Asker:
        """Returns an asker that raises TimeUp when left() returns no more seconds."""
        return Asker(self.program, self.settings, left)

    def check(self) -> None:
        """Raises UsageError where the settings are wrong."""
        self.ask("start")

    def ask(self, what: str, **question: object) -> dict:
        if self._left is None:
            return self._stability.ask(what, **question)
        if (left := self._left()) <= 0:
            raise TimeUp
        found = self._stability.ask(what, cap=left, **question)
        if self._left() <= 0:  # the answer may be incomplete
            raise TimeUp
        return found

    def rest(self, tries: int = TRIES) -> Rest:
        return _rest(self.ask("equilibria", count=tries))

    def start(self) -> Motion:
        """Returns the start of the motion only."""
        return made(Motion, self.ask("start"), status="motion")

    def motion(self) -> Motion:
        return made(Motion, self.ask("motion"), status="motion")

    def point(self, method: str, h: float) -> Point:
        answer = self.ask("point", method=method, h=h)
        return made(Point, answer, method="point", kind="class")

    def rates(self) -> tuple[Mode, ...]:
        """Returns the fastest rates of the equations linearised at states along the motion. Each
        state gives the fastest decay, if no growth is half as fast, and the fastest other rate, a
        decay counted as growth. Adds the rotation rate of bodies; drops rates below ZERO or SLOW.
        """
        found, states = [], self.ask("rates")["rates"]
        for at in states:
            modes = [Mode(g, f, (), ()) for g, f in zip(at["growth"], at["frequency"], strict=True)]
            grows = max((m.growth for m in modes), default=0.0)
            decays = [m for m in modes if -m.growth > max(2 * grows, 0.0)]
            others = [replace(m, growth=abs(m.growth)) for m in modes if m not in decays]
            for some in (decays, others):
                found += [max(some, key=lambda m: m.rate)] if some else []
        most = max((m.rate for m in found), default=0.0)
        turns = Mode(0.0, max((at["turns"] for at in states), default=0.0), (), (), True)
        found += [turns] if turns.rate > 0 else []
        least = max(ZERO * most, SLOW / self.settings.until)
        return tuple(m for m in found if m.rate > least)

    def onto(self, begun: Settings, whole: Motion) -> Asker:
        """Returns an asker with settings `begun`, whose start is projected onto the constraints.
        `whole` is the model's start. Raises UsageError if the projection fails."""
        q = tuple((dict(enumerate(whole.q)) | dict(begun.start_q)).values())
        v = tuple((dict(enumerate(whole.v)) | dict(begun.start_v)).values())
        on = self.ask("place", state=(*q, *v))
        if on["status"] != "PK_DONE":
            raise UsageError(
                f"no start next to q = {q}, v = {v} fulfils the constraints ({on['status']}): "
                "vary by --vary NAME=LO..HI what they leave free"
            )
        q, v = tuple(enumerate(_floats(on["q"]))), tuple(enumerate(_floats(on["v"])))
        return self.with_settings(replace(begun, start_q=q, start_v=v))

    def at(self, place: Equilibrium) -> Asker:
        """Returns an asker whose start is an equilibrium."""
        q, v = tuple(enumerate(place.q)), tuple(enumerate(place.v))
        return self.with_settings(replace(self.settings, start_q=q, start_v=v))

    def near(self, **question: object) -> Close:
        """Runs some steps near the start, which is an equilibrium: see at()."""
        a = self.ask("near", **question)
        growth = math.inf if a["growth"] is None else a["growth"]
        return made(Close, a | {"growth": growth, "turn": a["turn"] or 0.0})


def _floats(xs: list[float]) -> tuple[float, ...]:
    return tuple(map(float, xs))  # JSON writes 0 as an integer


def made(cls: type[Made], answer: dict, /, **renamed: str) -> Made:
    """Returns a record of an answer; `renamed` maps field names to other keys of the answer."""
    named = ((f.name, renamed.get(f.name, f.name)) for f in fields(cls))
    values = {name: answer[of] for name, of in named if of in answer}
    return cls(**{name: _floats(x) if isinstance(x, list) else x for name, x in values.items()})


def _rest(answer: dict) -> Rest:
    modes = [made(Mode, m) for e in answer["equilibria"] for m in e["modes"]]
    fastest = max((mode.rate for mode in modes), default=0.0)

    def cleared(mode: Mode) -> Mode:
        """Sets rates near 0 to 0: inexact roots make vanishing linear terms small numbers."""
        slow = mode.rate <= ZERO * fastest
        return replace(mode, growth=0, frequency=0) if slow else mode

    found = [
        made(Equilibrium, e | {"modes": tuple(cleared(made(Mode, m)) for m in e["modes"])})
        for e in answer["equilibria"]
    ]
    turns = tuple(map(bool, answer["turns"]))
    return made(Rest, answer | {"equilibria": tuple(found), "turns": turns})
