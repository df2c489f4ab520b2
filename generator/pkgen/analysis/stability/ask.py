"""Numerical experiments on a compiled model; the results are records."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy

from ...record import record
from ...run import integration
from ...run.settings import Settings
from ...system.exits import UsageError
from ..linear.equilibria import TRIES, rest
from ..linear.rest import ZERO, Equilibrium, Mode, Rest
from ..linear.system import MOST_STEPS, floats
from . import distances, near, orbits, points
from .points import Point
from .reference import Reference
from .unknowns import Placed

SLOW = 0.01  # least rate, in radians or e-foldings per run; a lower rate is round-off
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


class Asker(Placed):
    """Makes experiments on one model with the `settings` of a run, in one thread at a time."""

    near, leave = near.near, near.leave
    orbits, returns = orbits.orbits, distances.returns
    beside, resolved = distances.beside, distances.resolved
    motion_followed: Reference | None = None

    def with_settings(self, settings: Settings) -> Asker:
        return Asker(self.program, settings, self.left)

    def within(self, left: Callable[[], float]) -> Asker:
        """Returns an asker that raises TimeUp when left() returns no more seconds."""
        return Asker(self.program, self.settings, left)

    def rest(self, tries: int = TRIES) -> Rest:
        return rest(self, tries)

    @numpy.errstate(all="ignore")
    def initial(self) -> Motion:
        """Returns a Motion that only has the initial state: nothing is integrated."""
        return self._told(Reference(self))

    @numpy.errstate(all="ignore")
    def motion(self) -> Motion:
        self.motion_followed = Reference(self)
        self.motion_followed.follow_whole()
        return self._told(self.motion_followed)

    def _told(self, motion: Reference) -> Motion:
        records, report = motion.records, motion.report()
        return Motion(
            status=motion.status,
            t=float(records[-1, 0]),
            energy=float(records[0, 1]),
            scale=motion.summary(self.until if motion.followed else 0.0).scale,
            q=floats(self.q(self.start)),
            v=floats(self.v(self.start)),
            parameters=floats(numpy.array(self.given["parameters"], float)),
            leaves=motion.leaves,
            horizon=motion.known,
            by_norm=self.by_norm,
            condition=report.get("condition"),
            warning=report.get("warning"),
        )

    def point(self, method: str, h: float) -> Point:
        """Classifies a method's run. Call motion() before."""
        return points.classified(self.motion_followed, method, h)

    @numpy.errstate(all="ignore")
    def rates(self) -> tuple[Mode, ...]:
        """Returns the fastest eigenvalues of the equations linearised at states along the motion,
        as modes. Each state contributes its fastest decaying mode, unless a mode grows at least
        half as fast, and its fastest other mode, whose rate counts as growth. The rotation rate of
        bodies is a further mode. Modes with rates below ZERO or SLOW are left out."""
        found, turns = [], 0.0
        for t, state in self._along():
            turns = max(turns, self.turning_rate(state))
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
        kept, stride, step, motion = [(0.0, self.start)], 1, 0, self.reference()
        while not motion.failed and motion.t < self.until and step < MOST_STEPS:
            for row in motion.steps(self.until, MOST_STEPS):
                step += 1
                if step % stride == 0 and len(kept) == MOST_RATES:
                    kept, stride = kept[::2], 2 * stride
                if step % stride == 0:
                    kept.append((float(row[0]), row[1:]))
        return kept

    def _eigenvalues(self, t: float, state: numpy.ndarray) -> list[complex]:
        matrix = self.linearised(t, state)
        found = numpy.linalg.eigvals(matrix) if numpy.isfinite(matrix).all() else []
        return [z for z in found if not z.imag < 0]

    def onto(self, begun: Settings, whole: Motion) -> Asker:
        """Returns an asker with the settings `begun`. Its start is that of `begun`, completed by
        that of `whole`, and projected onto the constraints. Raises UsageError if the projection
        fails."""
        q = tuple((dict(enumerate(whole.q)) | dict(begun.start_q)).values())
        v = tuple((dict(enumerate(whole.v)) | dict(begun.start_v)).values())
        status, on = self.reference().projected(numpy.array([*q, *v]))
        if status != "PK_DONE":
            raise UsageError(
                f"no start next to q = {q}, v = {v} fulfils the constraints ({status}): "
                "vary by --vary NAME=LO..HI what they leave free"
            )
        q, v = tuple(enumerate(floats(self.q(on)))), tuple(enumerate(floats(self.v(on))))
        return self.with_settings(replace(begun, start_q=q, start_v=v))

    def at(self, place: Equilibrium) -> Asker:
        """Returns an asker whose runs start at the equilibrium `place`, for near() and leave()."""
        q, v = tuple(enumerate(place.q)), tuple(enumerate(place.v))
        found = self.with_settings(replace(self.settings, start_q=q, start_v=v))
        found.place = place
        return found

    def spring(self, method: str, stiffness: float, damping: float, h: float) -> numpy.ndarray:
        """Returns the 2 x 2 matrix by which a step of the method maps (q, v) of the oscillator q''
        = -stiffness q - damping q', with v = q'."""
        found = integration.spring(self.run, method, stiffness, damping, h)
        return numpy.array(found).reshape(2, 2)
