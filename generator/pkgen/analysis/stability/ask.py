"""Questions about a compiled model (pk/stability.h), and its answers as data."""

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

ZERO = 1e-7  # of the largest rate at any equilibrium: below, the linear terms decide nothing
SLOW = 0.01  # of the duration: what turns or grows by less in it is round-off, or nothing
UNDECIDED = "not decided by the linear terms"
TRIES = 100  # starts from which equilibria are sought
Made = TypeVar("Made")


@record
class Mode:
    """exp(lambda t) with lambda = growth + i frequency; the shape's real and imaginary parts."""

    growth: float
    frequency: float
    re: tuple[float, ...]
    im: tuple[float, ...]
    on_group: bool = False  # of bodies that turn, as methods on the group see it

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
    status: str = "PK_DONE"  # of the modes
    slack: int = 0  # directions in which equilibria go on: it is one of a continuum

    @property
    def stable(self) -> bool:
        """The modes are known, there is one that moves or none at all, and none grows."""
        moves = not self.modes or any(mode.rate > 0 for mode in self.modes)
        return self.status == "PK_DONE" and moves and not self._grows

    @property
    def _grows(self) -> bool:
        return any(mode.growth > 0 for mode in self.modes)

    @property
    def verdict(self) -> str:
        """In words. A mode that neither returns nor leaves is left to terms of higher order."""
        if self.status != "PK_DONE":
            return f"modes: {self.status}"
        if self._grows:
            return "unstable"
        if any(mode.rate == 0 for mode in self.modes):
            return "one of a continuum" if self.slack else UNDECIDED
        return "stable"

    @property
    def oscillating(self) -> list[int]:
        """Numbers of the modes that oscillate and do not grow."""
        return [k for k, m in enumerate(self.modes) if m.frequency > 0 and m.growth <= 0]


@record
class Rest:
    """What was found of equilibria."""

    status: str
    equilibria: tuple[Equilibrium, ...]
    failed: int
    singular: int
    more: bool
    turns: tuple[bool, ...] = ()  # of each coordinate: q + 2 pi is the same place
    middle: tuple[float, ...] = ()  # each was sought in middle +- box, or further (docs/maps.md)
    box: tuple[float, ...] = ()

    def beside(self, q: float, place: float, i: int) -> float:
        """q_i; of an angle by whole turns next to a place."""
        turns = bool(self.turns) and self.turns[i]
        return q + 2 * math.pi * round((place - q) / (2 * math.pi)) if turns else q


@record
class Motion:
    """The motion itself: how far it goes, its first energy, the range of v.p, how it began."""

    status: str
    t: float
    energy: float
    scale: float
    q: tuple[float, ...]
    v: tuple[float, ...]
    parameters: tuple[float, ...]
    leaves: bool = False  # it is still going away at the end
    horizon: float = math.inf  # up to when a looser tolerance agrees
    by_norm: bool = False  # first-order variables move: judged by its distance from the start
    condition: dict | None = None  # how singular its equations become: `report.condition` of a run
    warning: str | None = None  # of that

    @property
    def judges(self) -> bool:
        """A method's motion can be told by it."""
        return self.status == "PK_DONE" and not self.leaves


@record
class Point:
    """What becomes of the motion by a method at a step; rise and away in units of its scale."""

    method: str
    h: float
    kind: str
    status: str
    steps: int
    rise: float | None
    away: float | None
    cond: float | None  # of the equations of its last step; 0: there are none
    # docs/maps.md; None of a method that fails
    exchange: float | None = None  # how many times as far a coordinate swings as in the motion
    moved: float | None = None  # of a constant, which is named
    follows: float | None = None  # part of the time over which it stays beside the motion
    constant: str = ""

    @property
    def shown(self) -> str:
        """Its class on a map."""
        if self.kind == "bounded" and self.follows is not None and self.follows < 1:
            return "out of phase"
        if self.kind == "drifting" and self.away is not None and self.away < 0.01:
            return "drifting by less than 1 %"
        return self.kind


@record
class Close:
    """How a motion went that began close to an equilibrium."""

    status: str
    steps: int
    growth: float  # of the displacement; it is not followed further than 1000
    turn: float  # mean angle a step


class TimeUp(Exception):
    """Nothing more is asked."""


class Asker:
    """Asks about one model; `settings` are those of a run."""

    def __init__(self, program: Path, settings: Settings, left: Callable[[], float] | None = None):
        self.program, self.settings, self._left = program, settings, left
        self._stability = Stability(load(program), settings)

    def with_settings(self, settings: Settings) -> Asker:
        return Asker(self.program, settings, self._left)

    def within(self, left: Callable[[], float]) -> Asker:
        """Asks while any seconds are left; then TimeUp."""
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
        if self._left() <= 0:  # it may have been cut off
            raise TimeUp
        return found

    def rest(self, tries: int = TRIES) -> Rest:
        return _rest(self.ask("equilibria", count=tries))

    def start(self) -> Motion:
        """None of it yet: where it begins."""
        return made(Motion, self.ask("start"), status="motion")

    def motion(self) -> Motion:
        return made(Motion, self.ask("motion"), status="motion")

    def point(self, method: str, h: float) -> Point:
        answer = self.ask("point", method=method, h=h)
        return made(Point, answer, method="point", kind="class")

    def rates(self) -> tuple[Mode, ...]:
        """Of the equations linearised at states along the motion the fastest of each: what decays,
        if nothing grows half as fast; and of all others, as if it did not decay."""
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
        """That with settings `begun`, the start of which is put onto the constraints by the
        shortest way; the own start is `whole`. Raises UsageError where there is none."""
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
        """Asks from there."""
        q, v = tuple(enumerate(place.q)), tuple(enumerate(place.v))
        return self.with_settings(replace(self.settings, start_q=q, start_v=v))

    def near(self, **question: object) -> Close:
        """From at() an equilibrium."""
        a = self.ask("near", **question)
        growth = math.inf if a["growth"] is None else a["growth"]
        return made(Close, a | {"growth": growth, "turn": a["turn"] or 0.0})


def _floats(xs: list[float]) -> tuple[float, ...]:
    return tuple(map(float, xs))  # JSON has 0 as an integer


def made(cls: type[Made], answer: dict, /, **renamed: str) -> Made:
    """A record of an answer, which has its fields, but for those that are `renamed`."""
    named = ((f.name, renamed.get(f.name, f.name)) for f in fields(cls))
    values = {name: answer[of] for name, of in named if of in answer}
    return cls(**{name: _floats(x) if isinstance(x, list) else x for name, x in values.items()})


def _rest(answer: dict) -> Rest:
    modes = [made(Mode, m) for e in answer["equilibria"] for m in e["modes"]]
    fastest = max((mode.rate for mode in modes), default=0.0)

    def cleared(mode: Mode) -> Mode:
        """Sets modes near 0 to 0: inexact roots make vanishing linear terms small numbers."""
        slow = mode.rate <= ZERO * fastest
        return replace(mode, growth=0, frequency=0) if slow else mode

    found = [
        made(Equilibrium, e | {"modes": tuple(cleared(made(Mode, m)) for m in e["modes"])})
        for e in answer["equilibria"]
    ]
    turns = tuple(map(bool, answer["turns"]))
    return made(Rest, answer | {"equilibria": tuple(found), "turns": turns})
