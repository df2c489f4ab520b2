"""Motions that begin close to an equilibrium q*, v*, displaced along its modes by the amplitude A:

q = q* + A sum Re(u), v = v* + A sum Re(lambda u)

Here u is the shape of a mode times exp(lambda t). Two numbers are measured. The growth is that of
the largest displacement of a non-cyclic coordinate. The angle is the mean rotation per step of the
mode's leading coordinate about q* in the plane (q, -v/omega). If the start has a second mode, the
growth is that of the second mode's part of the displacement, hypot(u.M (q - q*), u.M v/omega), with
the mass matrix M.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy

from ...record import record
from ..linear.rest import Mode
from ..linear.system import EXACT, System
from .unknowns import Placed

FAR = 1e3  # growth factor at which the steps end


def _displacement(system: System, modes: Sequence[Mode], amplitude: float) -> numpy.ndarray:
    """Returns the displacement of the start along `modes`, each with the same amplitude."""
    n, m = system.n, system.m
    moved = numpy.zeros(2 * n)
    for mode in modes:
        shape = numpy.array(mode.re) + 1j * numpy.array(mode.im)
        rates = mode.value * shape
        moved[:m] += amplitude * shape.real[:m]
        moved[n:] += amplitude * numpy.where(numpy.arange(n) < m, rates.real, shape.real)
    return moved


def _settled(system: System, state: numpy.ndarray) -> numpy.ndarray:
    """Projects a state onto the constraints. A state displaced along a mode fulfils them only
    approximately, since the mode is tangential to the constraints."""
    return system.reference().projected(state)[1] if system.bound else state


def _largest(system: System, states: numpy.ndarray) -> numpy.ndarray:
    """Returns for each state the largest displacement of an unknown from the start. Unknowns on
    which no rate depends are left out."""
    return abs(system.apart(states)[:, ~system.idle]).max(1, initial=0.0)


def _turn(angles: numpy.ndarray, half: int) -> float:
    """Returns the mean increase per step of angles modulo 2 pi. In the plane (q, -v/omega) the
    orbit is no circle. Therefore the angle is not proportional to time, but oscillates about a
    straight line. The slope of this line is computed from the means of the angle in the first and
    in the second `half` of the steps, in which oscillations nearly cancel."""
    turns = numpy.diff(angles)
    turned = numpy.cumsum(turns + 2 * math.pi * (turns < 0))
    if half and len(turned) >= 2 * half:
        return float(turned[half : 2 * half].sum() - turned[:half].sum()) / half**2
    return float(turned[-1]) / len(turned) if len(turned) else 0.0


@record
class Close:
    """A run of a method that starts near an equilibrium."""

    status: str
    steps: int
    growth: float  # growth factor of the displacement; the run ends when it exceeds 1000
    turn: float  # mean rotation angle per step


@numpy.errstate(all="ignore")
def near(
    system: Placed,
    *,
    method: str,
    h: float,
    amplitude: float,
    count: int,
    mode: int = -1,
    other: int | None = None,
    seed: float = 0.0,
) -> Close:
    """Makes `count` steps from a state near the start, an equilibrium. The state is displaced by
    `amplitude` along the mode with index `mode` or, if this is -1, along all modes that move and do
    not grow; and by `seed` along the mode with index `other`."""
    modes = system.place.modes
    some = [m for m in modes if m.growth <= 0 and m.rate > 0] if mode < 0 else [modes[mode]]
    state = system.start + _displacement(system, some, amplitude)
    state = _settled(system, state)
    if other is not None:
        state = state + _displacement(system, [modes[other]], seed)
        mass = system.kernel("mass", 0.0, system.start).reshape(system.n, system.n)
        weights = mass @ numpy.array(modes[other].re)

    def size(states: numpy.ndarray) -> numpy.ndarray:
        if other is None:
            return _largest(system, states)
        rates = system.v(states - system.start)[:, : system.m] @ weights[: system.m]
        return numpy.hypot(system.apart(states) @ weights, rates / modes[other].frequency)

    leading = modes[max(mode, 0)]
    lead = int((abs(numpy.array(leading.re)) * ~system.idle).argmax())

    def angle(states: numpy.ndarray) -> numpy.ndarray:
        moved = states - system.start
        q, v = system.q(moved)[:, lead], system.v(moved)[:, lead]
        return numpy.arctan2(-v, leading.frequency * q)

    it = system.begin(method, state, h=h)
    first, grown, made = float(size(state[None])[0]), 1.0, 0
    angles = [angle(state[None])]
    while made < count and grown < FAR and not it.failed:
        states = it.steps((count + 1) * h, count - made)[:, 1:]
        growth = numpy.fmax.accumulate(numpy.fmax(size(states) / first, grown))
        states = states[: int((growth < FAR).sum()) + 1]
        if len(states):
            angles.append(angle(states))
            grown, made = float(growth[len(states) - 1]), made + len(states)
    status = it.status if it.failed and grown < FAR else "PK_DONE"
    return Close(status, made, grown, _turn(numpy.concatenate(angles), count // 2))


@numpy.errstate(all="ignore")
def leave(system: Placed, mode: int, amplitude: float) -> float:
    """Returns the growth rate of the reference motion that starts at an equilibrium, displaced by
    `amplitude` along a growing mode."""
    modes = system.place.modes
    of, most = modes[mode], max(m.growth for m in modes)
    until = math.log(FAR) / most  # later, round-off has grown along a faster mode
    if of.frequency > 0:  # the time is whole periods, so that the phase of the mode has no effect
        period = 2 * math.pi / of.frequency
        until = math.ceil(until / period) * period
    state = _settled(system, system.start + _displacement(system, [of], amplitude))
    it = system.begin(EXACT, state, rtol=1e-13, atol=1e-13 * amplitude)
    if not it.to(until):
        return 0.0
    first, last = _largest(system, numpy.stack([state, it.state]))
    return math.log(last / first) / until
