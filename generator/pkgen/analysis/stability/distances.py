"""Distances of a motion from its past, of two runs from nearly the same start, and of a run from
the reference motion. Their unit, the box, is the width of the region that the motion covers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy

from ...run.integration import Integration
from .unknowns import Placed

SAMPLES, MOST_RETURNS = 8192, 8
RETURNED = 0.1  # largest distance, in boxes, that counts as a return
FAR = 1e3  # growth factor of the distance at which beside() stops
LOOKS = 16  # number of states along the motion from which resolved() compares steps
STILL = 0.1  # least box of a variable, relative to the largest box of its kind of variable


@numpy.errstate(all="ignore")
def returns(system: Placed, period: float) -> tuple[numpy.ndarray, list[float]]:
    """Returns the state of the motion at the end of its duration, and the times that elapse until
    the motion returns to this state. If `period` is not 0, the duration is rounded up to a multiple
    of it."""
    until = system.until
    until = math.ceil(until / period) * period if period > 0 else until
    it, times, before, last, most = system.reference(), [], 0.0, 0.0, 0.0
    it.to(until)
    begun = it.state.copy()
    for k in range(SAMPLES + 1, 2 * SAMPLES + 1):
        if len(times) == MOST_RETURNS or not it.to(until * k / SAMPLES):
            break
        d = float(abs(system.unknowns.apart(begun, it.state)).max(initial=0.0))
        if before > last and d >= last and last < RETURNED and last < most / 3:
            times.append(until * (k - 1 - SAMPLES) / SAMPLES)
        most, before, last = max(most, d), last, d
    return begun, times


@numpy.errstate(all="ignore")
def beside(
    system: Placed,
    *,
    method: str,
    h: float,
    count: int,
    amplitude: float,
    state: Sequence[float] | None = None,
) -> tuple[str, float, numpy.ndarray]:
    """Makes steps from `state` and from a second state, which differs by `amplitude` times the
    width of the search box in each unknown. Returns the status, the factor by which the distance of
    the two states has grown, and the second state after the last step."""
    unknowns, y = system.unknowns, system.start if state is None else numpy.array(state, float)
    other = y.copy()
    sign = numpy.where(numpy.arange(len(unknowns.of)) % 2, -1, 1)
    other[unknowns.of] += sign * amplitude * unknowns.box
    a, b = system.begin(method, y, h=h), system.begin(method, other, h=h)
    made, most = 0, 0.0
    while made < count and most < FAR * amplitude and not (a.failed or b.failed):
        rows = [it.steps((count + 1) * h, count - made)[:, 1:] for it in (a, b)]
        both = min(map(len, rows))
        if both:
            far = abs(unknowns.apart(rows[0][:both], rows[1][:both])).max(1, initial=0.0)
            most = float(numpy.fmax(most, numpy.fmax.reduce(far)))
            other = rows[1][both - 1]
        made += both
    bad = next((it.status for it in (a, b) if it.failed), "PK_DONE")
    return bad, most / amplitude, other


@numpy.errstate(all="ignore")
def resolved(system: Placed, method: str, h: float, count: int) -> tuple[str, float]:
    """Makes `count` steps of a method from each of several states along the motion. Returns the
    status, and the largest distance in boxes between the results and the motion. States are
    compared instead of energies, since a free body's energy may stay constant at any step size."""
    system.cover()
    motion, it = system.reference(), system.begin(method, h=h)
    most = 0.0
    for k in range(LOOKS):
        if it.failed or not motion.to(max(system.until * k / LOOKS, motion.t)):
            break
        it.restart(motion.state, motion.t)
        for row in it.steps(motion.t + (count + 1) * h, count):
            if not motion.to(float(row[0])):
                return "PK_DONE", most  # here the reference motion failed, not the method
            most = max(most, _off(system, row[1:], motion))
    return it.status if it.failed else "PK_DONE", most


def _off(system: Placed, state: numpy.ndarray, motion: Integration) -> float:
    most = 0.0
    for k, kind in enumerate(system.kinds()):
        box = system.box[kind.start : kind.stop]
        if len(box) and k != 1:  # the integrals of first-order variables are not compared
            off = abs(state - motion.state)[kind.start : kind.stop]
            off = off / numpy.fmax(box, STILL * box.max())
            most = max(most, math.inf if numpy.isnan(off).any() else float(off.max()))
    return most
