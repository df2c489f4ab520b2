"""The reference motion, with which the runs of methods are compared. It is integrated by dop853
with rtol = system.RTOL. It lasts as long as the method's run, which at long steps is longer than
the duration `until`.

No method can be judged by a motion that leaves. A motion leaves if it meets two conditions. First,
a coordinate that is not cyclic still moves away at `until`: its largest displacement grows by a
fifth in each of the last two quarters of the duration. Second, nothing returns: v.p (rates times
momenta) has no extremum in the last half or, if the energy is constant, the range of v.p grows by
half in each of the last two quarters. Solutions of x'' = x, a fall and a free flight leave. A
driven resonance and a vibrating, drifting chain do not.
"""

from __future__ import annotations

import math

import numpy

from ...record import record
from ...run.integration import CONDITION, CONSTANTS
from ..linear.system import MOST_STEPS, System

LOOSER = 1e3  # factor on rtol of a second run; while both runs agree, the motion is known
SLIGHT = 1e-3  # the scale of energies is at least this part of the largest |v.p|
APART = 0.5  # two motions differ from this part of the largest displacement on: pi/3 in phase
SHARE = 1e-4  # a coordinate is compared if its |v_i p_i| is at least this part of the largest one
MOST_REALS = 4_000_000  # most numbers stored of past states


@record
class Summary:
    """Energies of the reference motion up to the end of a method's run."""

    scale: float  # range of v.p
    size: float  # largest |v.p| + |L|, to which round-off of the energy is relative
    low: float  # least energy in the last quarter; the initial energy if energy is constant
    high: float  # largest energy in the last quarter; likewise
    top: float  # largest energy of the motion; the initial energy if energy is constant


class Watch:
    """Largest |v_i p_i| and |v_i| of each coordinate along a motion."""

    def __init__(self, system: System):
        self.share, self.swift = numpy.zeros(system.m), numpy.zeros(system.m)

    def look(self, system: System, states: numpy.ndarray, parts: numpy.ndarray) -> None:
        if parts.size:
            self.share = numpy.fmax(self.share, parts.max(0))
            self.swift = numpy.fmax(self.swift, abs(system.v(states)[:, : system.m]).max(0))


class Reference:
    """The reference motion. follow() extends it; `judges` is known after follow_whole()."""

    def __init__(self, system: System):
        if system.by_norm:
            system.cover()
        self.system = system
        self._it = system.reference(watch=CONDITION | (0 if system.by_norm else CONSTANTS))
        self.watch = Watch(system)
        self.far = numpy.zeros(system.n)  # largest distance of each unknown from the start
        self.leaves, self.horizon, self.followed = False, math.inf, False
        self._kept: list[numpy.ndarray] = []  # rows of t, energy, v.p, and |v.p| + |L|
        self._states: list[numpy.ndarray] = []
        self._reported: tuple[int, dict] = 0, {}  # number of records, and report on them
        self._room = MOST_REALS // (2 * system.n)
        self._keep(numpy.array([[0.0, *system.start]]))

    @property
    def status(self) -> str:
        return self._it.status if self._it.failed else "PK_DONE"

    @property
    def judges(self) -> bool:
        """Whether the motion neither ends early nor leaves, so that methods are judged by it."""
        return self.followed and not self.leaves and not self._it.failed

    def report(self) -> dict:
        if self._reported[0] != len(self.records):
            self._reported = len(self.records), self._it.report()
        return self._reported[1]

    @property
    def records(self) -> numpy.ndarray:
        """Returns a row for each time t of the motion: t, energy, v.p, and |v.p| + |L|."""
        if len(self._kept) > 1:
            self._kept = [numpy.concatenate(self._kept)]
        return self._kept[0]

    def _keep(self, rows: numpy.ndarray) -> None:
        t, states = rows[:, 0], rows[:, 1:]
        energy, vp, size, parts = self.system.energies(t, states)
        self._kept.append(numpy.stack([t, energy, vp, size], 1))
        self.watch.look(self.system, states, parts)
        if self._room > 0:
            self._states.append(states[: self._room])
            self._room -= len(states)

    def follow(self, until: float) -> None:
        """Extends the motion to `until`, or until it fails."""
        left = MOST_STEPS - len(self.records)
        while not self._it.failed and self._it.t < until and left > 0:
            rows = self._it.steps(until, left)
            if not len(rows):
                break
            self._keep(rows)
            self.far = numpy.fmax(self.far, abs(self.system.apart(rows[:, 1:])).max(0))
            left -= len(rows)
        if left <= 0:
            self._it.give_up()

    @numpy.errstate(all="ignore")
    def follow_whole(self) -> None:
        """Extends the motion to its full duration; finds whether it leaves, and up to which time it
        is known."""
        until, far, scales = self.system.until, [], []
        for part in (0.5, 0.75, 1.0):
            self.follow(part * until)
            far.append(self.far)
            scales.append(self.summary(part * until).scale)
        self.horizon = self._horizon()
        self.leaves = not self._it.failed and self._leaves(far, scales)
        self.followed = True

    def summary(self, until: float) -> Summary:
        records = self.records
        t, energy, vp, size = records[: numpy.searchsorted(records[:, 0], until, "right")].T
        least, most = float(vp.min()), float(vp.max())
        scale = max(most - least, SLIGHT * max(abs(most), abs(least)))
        if not self.system.by_norm and self.system.given["conservative"]:
            first = float(energy[0])
            return Summary(scale, float(size.max()), first, first, first)
        late = energy[t >= 0.75 * until]
        late = late if len(late) else energy[-1:]
        ends = float(late.min()), float(late.max())
        return Summary(scale, float(size.max()), *ends, float(energy.max()))

    def _leaves(self, far: list[numpy.ndarray], scales: list[float]) -> bool:
        half, more, whole = far
        conservative = self.system.given["conservative"]
        away = ((more > 1.2 * half) & (whole > 1.2 * more))[~self.system.idle].any()
        faster = scales[1] > 1.5 * scales[0] and scales[2] > 1.5 * scales[1]
        # If a model has rotations or constraints, not all cyclic coordinates are known to be
        # cyclic. Therefore a constant v.p, as in a steady motion, does not mean that it leaves.
        evenly = self.system.bound and conservative
        faster = faster and conservative and not self.system.by_norm
        return bool(away) and (faster or (not evenly and self._turns_no_more()))

    def _turns_no_more(self) -> bool:
        """Whether v.p is monotonic in the last half of the duration, up to round-off."""
        records = self.records
        vp = records[records[:, 0] >= self.system.until / 2, 2]
        if not len(vp):
            return True
        most = max(abs(vp.max()), abs(vp.min()))
        return abs(numpy.diff(vp)).sum() <= 1.01 * (vp.max() - vp.min()) + 1e-6 * most

    def _horizon(self) -> float:
        """Returns the time up to which the motion is known, since a second run at a looser
        tolerance agrees with it."""
        until = self.system.until
        other = self.system.reference(LOOSER)
        while not other.failed and other.t < until:
            rows = other.steps(until, MOST_STEPS)
            lost = self.apart_at(rows)
            if lost is not None:
                return lost
        return other.t if other.failed and other.t > 0 else math.inf

    @property
    def known(self) -> float:
        """The time up to which the motion is known."""
        return min(self.horizon, self.system.until)

    def apart_at(self, rows: numpy.ndarray) -> float | None:
        """Returns the first time, up to `until`, at which the states in `rows` are apart from the
        motion: a coordinate by more than APART times its largest displacement in the motion, or a
        rate by more than the largest magnitude of this rate. The motion is interpolated: positions
        by cubic Hermite polynomials, rates linearly."""
        if len(self._states) > 1:
            self._states = [numpy.concatenate(self._states)]
        states, times = self._states[0], self.records[: len(self._states[0]), 0]
        m = self.system.m
        counts = self.watch.share > SHARE * self.watch.share.max(initial=0.0)
        if len(states) < 2 or not counts.any():
            return None
        t, now = rows[:, 0], rows[:, 1:]
        k = numpy.clip(numpy.searchsorted(times, t) - 1, 0, len(times) - 2)
        h = (times[k + 1] - times[k])[:, None]
        x = (t[:, None] - times[k][:, None]) / h
        y = 1 - x
        (q0, v0), (q1, v1) = (self._parts(states[at], counts, m) for at in (k, k + 1))
        place = y * y * ((1 + 2 * x) * q0 + x * h * v0) + x * x * ((1 + 2 * y) * q1 - y * h * v1)
        q, v = self._parts(now, counts, m)
        near = abs(q - place) <= APART * self.far[:m][counts]
        near &= abs(v - (y * v0 + x * v1)) <= self.watch.swift[counts]
        lost = ~near.all(1) & (t <= self.system.until) & (times[k + 1] >= t)
        return float(t[lost.argmax()]) if lost.any() else None

    def _parts(
        self, states: numpy.ndarray, counts: numpy.ndarray, m: int
    ) -> tuple[numpy.ndarray, numpy.ndarray]:
        return self.system.q(states)[:, :m][:, counts], self.system.v(states)[:, :m][:, counts]
