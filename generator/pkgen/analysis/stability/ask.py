"""Numerical experiments on a compiled model; the results are records."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy

from ...record import record
from ...run import integration
from ...run.settings import Settings
from ...system.exits import UsageError
from . import distances, modes, near, orbits, points
from .orbits import Orbit
from .reference import Reference
from .rest import ZERO, Equilibrium, Mode, Rest
from .system import MOST_STEPS, System
from .unknowns import Unknowns

SLOW = 0.01  # least rate, in radians or e-foldings per run; a lower rate is round-off
TRIES = 100  # initial guesses of the search for equilibria
MOST_RATES = 128  # most states along the motion at which rates are computed


@record
class Motion:
    """A summary of the reference motion, with which runs of methods are compared. `t` is its final
    time, `energy` its initial energy, `scale` the range of v.p (the rates times the momenta), `q`
    and `v` its initial state."""

    status: str
    t: float
    energy: float
    scale: float
    q: tuple[float, ...]
    v: tuple[float, ...]
    parameters: tuple[float, ...]
    leaves: bool = False  # whether the motion still moves away at its end
    horizon: float = math.inf  # up to this time, a run at a looser tolerance agrees
    by_norm: bool = False  # methods are judged by the distance from the start, not energy
    condition: dict | None = None  # condition numbers, as `condition` in the report of a run
    warning: str | None = None  # warning of an ill-conditioned motion

    @property
    def judges(self) -> bool:
        """Whether methods can be judged by this motion."""
        return self.status == "PK_DONE" and not self.leaves


@record
class Point:
    """The result of a method's run at step size h: a point of the map. points.py explains `rise`
    and `away`, which are changes of the energy relative to Motion.scale."""

    method: str
    h: float
    kind: str
    status: str
    steps: int
    rise: float | None
    away: float | None
    cond: float | None  # condition number of the last step's equations; 0: it has none
    # `exchange`, `moved` and `follows` are None if the method fails (docs/maps.md).
    exchange: float | None = None  # largest ratio of a coordinate's amplitude to the reference's
    moved: float | None = None  # largest relative drift of a constant of motion
    follows: float | None = None  # fraction of the time that the run stays near the reference
    constant: str = ""

    @property
    def shown(self) -> str:
        """Returns the class that the map shows for this point."""
        if self.kind == "bounded" and self.follows is not None and self.follows < 1:
            return "out of phase"
        if self.kind == "drifting" and self.away is not None and self.away < 0.01:
            return "drifting by less than 1 %"
        return self.kind


@record
class Close:
    """A run of a method that starts near an equilibrium."""

    status: str
    steps: int
    growth: float  # growth factor of the displacement; the run ends when it exceeds 1000
    turn: float  # mean rotation angle per step


class TimeUp(Exception):
    """Raised when the time budget is used up."""


class Asker:
    """Makes experiments on one model with the `settings` of a run, in one thread at a time. Raises
    UsageError if the settings are wrong, TimeUp if left() returns no more seconds."""

    def __init__(self, program: Path, settings: Settings, left: Callable[[], float] | None = None):
        self.program, self.settings, self._left = program, settings, left
        self._place: Equilibrium | None = None
        self._reference: Reference | None = None

    @cached_property
    def system(self) -> System:
        return System(self.program, self.settings, self._look)

    @cached_property
    def unknowns(self) -> Unknowns:
        with numpy.errstate(all="ignore"):
            return Unknowns(self.system)

    def _look(self) -> None:
        if self._left is not None and self._left() <= 0:
            raise TimeUp

    def with_settings(self, settings: Settings) -> Asker:
        return Asker(self.program, settings, self._left)

    def within(self, left: Callable[[], float]) -> Asker:
        """Returns an asker that raises TimeUp when left() returns no more seconds."""
        return Asker(self.program, self.settings, left)

    def check(self) -> None:
        """Raises UsageError if the settings are wrong."""
        self.start()

    def rest(self, tries: int = TRIES) -> Rest:
        self._look()
        found = integration.equilibria(self.system.run, tries)
        turns = tuple(map(bool, found["turns"]))
        places = tuple(self._equilibrium(**e) for e in found["equilibria"])
        fastest = max((m.rate for e in places for m in e.modes), default=0.0)

        def cleared(mode: Mode) -> Mode:
            """Sets the growth and frequency of a slow mode to 0: they are numerical errors."""
            slow = mode.rate <= ZERO * fastest
            return replace(mode, growth=0.0, frequency=0.0) if slow else mode

        places = tuple(replace(e, modes=tuple(map(cleared, e.modes))) for e in places)
        region = {key: _floats(found[key]) for key in ("middle", "box")}
        return Rest(**found | region | {"equilibria": places, "turns": turns})

    @numpy.errstate(all="ignore")
    def _equilibrium(
        self, q: list[float], v: list[float], doubt: list[float], energy: float, slack: int
    ) -> Equilibrium:
        state = numpy.array([*q, *v], float)
        status, found = modes.settled(self.system, state, numpy.array(doubt, float))
        if self.system.by_norm:  # the energy of such a model is not used
            energy = 0.0
        return Equilibrium(_floats(q), _floats(v), float(energy), tuple(found), status, slack)

    @numpy.errstate(all="ignore")
    def start(self) -> Motion:
        """Returns a Motion that only has the initial state: nothing is integrated."""
        return self._told(Reference(self.system))

    @numpy.errstate(all="ignore")
    def motion(self) -> Motion:
        self._look()
        self._reference = Reference(self.system)
        self._reference.follow_whole()
        return self._told(self._reference)

    def _told(self, motion: Reference) -> Motion:
        system, records, report = self.system, motion.records, motion.report()
        return Motion(
            status=motion.status,
            t=float(records[-1, 0]),
            energy=float(records[0, 1]),
            scale=motion.summary(system.until if motion.followed else 0.0).scale,
            q=_floats(system.q(system.start)),
            v=_floats(system.v(system.start)),
            parameters=tuple(
                math.nan if x is None else float(x) for x in system.given["parameters"]
            ),
            leaves=motion.leaves,
            horizon=motion.known,
            by_norm=system.by_norm,
            condition=report.get("condition"),
            warning=report.get("warning"),
        )

    def point(self, method: str, h: float) -> Point:
        self._look()
        if self._reference is None:
            raise UsageError("ask for the motion first")
        return Point(**points.classified(self._reference, method, h))

    @numpy.errstate(all="ignore")
    def rates(self) -> tuple[Mode, ...]:
        """Returns the fastest eigenvalues of the equations linearised at states along the motion,
        as modes. Each state contributes its fastest decaying mode, unless a mode grows at least
        half as fast, and its fastest other mode, whose rate counts as growth. The rotation rate of
        bodies is a further mode. Modes with rates below ZERO or SLOW are left out."""
        found, turns = [], 0.0
        for t, state in self._along():
            turns = max(turns, self.system.turning_rate(state))
            modes = [
                Mode(float(z.real), float(z.imag), (), ()) for z in self._eigenvalues(t, state)
            ]
            grows = max((m.growth for m in modes), default=0.0)
            decays = [m for m in modes if -m.growth > max(2 * grows, 0.0)]
            others = [replace(m, growth=abs(m.growth)) for m in modes if m not in decays]
            for some in (decays, others):
                found += [max(some, key=lambda m: m.rate)] if some else []
        most = max((m.rate for m in found), default=0.0)
        found += [Mode(0.0, turns, (), (), True)] if turns > 0 else []
        least = max(ZERO * most, SLOW / self.settings.until)
        return tuple(m for m in found if m.rate > least)

    def _along(self) -> list[tuple[float, numpy.ndarray]]:
        """Returns up to MOST_RATES states along the motion, denser where rates are large."""
        system = self.system
        kept, stride, step, motion = [(0.0, system.start)], 1, 0, system.reference()
        while not motion.failed and motion.t < system.until and step < MOST_STEPS:
            for row in motion.steps(system.until, MOST_STEPS):
                step += 1
                if step % stride == 0 and len(kept) == MOST_RATES:
                    kept, stride = kept[::2], 2 * stride
                if step % stride == 0:
                    kept.append((float(row[0]), row[1:]))
        return kept

    def _eigenvalues(self, t: float, state: numpy.ndarray) -> list[complex]:
        matrix = self.system.linearised(t, state)
        found = numpy.linalg.eigvals(matrix) if numpy.isfinite(matrix).all() else []
        return [z for z in found if not z.imag < 0]

    def onto(self, begun: Settings, whole: Motion) -> Asker:
        """Returns an asker with the settings `begun`. Its start is that of `begun`, completed by
        that of `whole`, and projected onto the constraints. Raises UsageError if the projection
        fails."""
        q = tuple((dict(enumerate(whole.q)) | dict(begun.start_q)).values())
        v = tuple((dict(enumerate(whole.v)) | dict(begun.start_v)).values())
        status, on = self.system.reference().projected(numpy.array([*q, *v]))
        if status != "PK_DONE":
            raise UsageError(
                f"no start next to q = {q}, v = {v} fulfils the constraints ({status}): "
                "vary by --vary NAME=LO..HI what they leave free"
            )
        n = self.system.n
        q, v = tuple(enumerate(_floats(on[:n]))), tuple(enumerate(_floats(on[n:])))
        return self.with_settings(replace(begun, start_q=q, start_v=v))

    def at(self, place: Equilibrium) -> Asker:
        """Returns an asker whose runs start at the equilibrium `place`, for near() and leave()."""
        q, v = tuple(enumerate(place.q)), tuple(enumerate(place.v))
        found = self.with_settings(replace(self.settings, start_q=q, start_v=v))
        found._place = place
        return found

    def _modes(self) -> tuple[Mode, ...]:
        if self._place is None or self._place.status != "PK_DONE":
            raise UsageError(f"no modes here: {self._place and self._place.status}")
        return self._place.modes

    def near(self, **question: object) -> Close:
        """Makes some steps from a state near the start, which must be an equilibrium (see at())."""
        self._look()
        return Close(**near.near(self.system, self._modes(), **question))

    def leave(self, mode: int, amplitude: float) -> float:
        """Returns the growth rate of the reference motion that starts at the equilibrium of at(),
        displaced along a mode by `amplitude`."""
        self._look()
        return near.leave(self.system, self._modes(), mode, amplitude)

    def orbits(self, **question: object) -> tuple[Orbit, ...] | None:
        """Returns closed orbits as orbits.orbits() does, which explains the arguments and when the
        result is None."""
        self._look()
        return orbits.orbits(self.system, self.unknowns, **_with_state(question))

    def returns(self, period: float = 0.0) -> tuple[numpy.ndarray, list[float]]:
        self._look()
        return distances.returns(self.system, self.unknowns, period)

    def beside(self, **question: object) -> tuple[str, float, numpy.ndarray]:
        self._look()
        return distances.beside(self.system, self.unknowns, **_with_state(question))

    def resolved(self, method: str, h: float, count: int) -> tuple[str, float]:
        self._look()
        return distances.resolved(self.system, method, h, count)

    def spring(self, method: str, stiffness: float, damping: float, h: float) -> numpy.ndarray:
        """Returns the 2 x 2 matrix by which a step of the method maps (q, v) of the oscillator q''
        = -stiffness q - damping q', with v = q'."""
        found = integration.spring(self.system.run, method, stiffness, damping, h)
        return numpy.array(found).reshape(2, 2)


def _with_state(question: dict) -> dict:
    if question.get("state") is None:
        return question
    return question | {"state": numpy.array(question["state"], float)}


def _floats(xs: numpy.ndarray) -> tuple[float, ...]:
    return tuple(map(float, xs))
