"""Limit cycles and motions in phase with a driver: the step size at which a method loses them.

The orbit of the equations closes after a period T; its Floquet multipliers are the growth factors
of small displacements in a period. A method's orbit closes after m steps of size h = k T/m, in k
periods; if the period is unknown, Newton's method also solves for h. The prediction is the first h
at which a multiplier leaves the unit circle. Multipliers that are 1 for the exact orbit do not
count: they belong to displacements along it or along a family of orbits. The measurement is the h
at which the distance of two runs, initially 1e-6 of the motion's range, grows by a factor of 1000.

Reference: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, 1.5, 5.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ...equations import Equations
from ...graph.differentiate import reachable, symbols_in
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, Kind, Op, Symbol
from ...record import record
from .ask import Asker
from .orbits import Orbit
from .predict import Prediction

# The search begins with FINEST steps per period, and multiplies this number by COARSER.
FINEST, COARSER = 512, 0.8
FINE = 1000  # orbits that refine the limit have at least FINE steps: h has a precision of 1/FINE
GROWS = 1e-3  # a multiplier is outside the unit circle if the log of its modulus is larger
# A multiplier crosses the unit circle continuously if the last one inside has a smaller |log|.
CLOSE = 0.1
DISPLACED = 1e-6  # initial distance of two runs, relative to the range of the motion
STILL = 1e-3  # a cycle with multipliers of modulus below 1 + STILL is stable
WAVES = ("sin", "cos")
MOST_PERIODS = 24  # longest common period of all drivers, in periods of the slowest driver
LONG, SHORT = 300_000, 10_000  # steps of a measurement: LONG if the cycle is damped, else SHORT


@record
class Cycle:
    """A periodic orbit of the equations."""

    period: float
    driven: bool
    orbit: Orbit
    trivial: int  # number of Floquet multipliers that are 1 for every such orbit

    @property
    def stays(self) -> bool:
        """Whether the cycle is stable. A cycle whose multipliers are all trivial does not count."""
        rest = abs(self.orbit.beyond(self.trivial))
        return 0 < rest < 1 + STILL

    @property
    def damped(self) -> bool:
        return abs(math.prod(self.orbit.multipliers)) < 0.99


@record
class Lost:
    """The step size h at which a method loses the cycle. It is None if the method keeps the cycle
    at all step sizes that were searched.

    If `sharp` is true, a multiplier crosses the unit circle continuously at h. Otherwise the
    multiplier jumps, or no closed orbit is found at longer steps. Then h is only an estimate: the
    longest step at which the closed orbit was found.
    """

    method: str
    h: float | None
    multiplier: complex | None  # largest one at h; None: no closed orbit beyond h
    measured: float | None
    sharp: bool

    @property
    def how(self) -> str:
        if self.h is None:
            return "kept"
        if self.multiplier is None:
            return "no orbit was found to close beyond"
        if abs(self.multiplier.imag) > 1e-3 * abs(self.multiplier):
            return "turns and grows (a torus)"
        return "period doubling" if self.multiplier.real < 0 else "grows (a fold)"


def find(asker: Asker, period: float | None) -> Cycle | None:
    """Returns the cycle that the motion approaches, searched from its final state, or None.
    `period` is the driver's."""
    start, times = asker.returns(period or 0.0)
    for time in [period] if period is not None else times:
        for orbit in asker.orbits(state=start, h=time, count=1, free=period is None) or ():
            if orbit.rests or not 0.5 * time < orbit.h < 2 * time:
                continue
            driven = period is not None
            near = 1e-6 if driven else 0.01
            trivial = max(sum(abs(z - 1) < near for z in orbit.multipliers), not driven)
            return Cycle(orbit.h, driven, orbit, trivial)
    return None


def predictions(cycle: Cycle | None, lost: Lost | None) -> list[Prediction]:
    """Returns one prediction if the step size at which the cycle is lost is known, or if the method
    keeps the cycle at all step sizes searched; else none. The field `y` of the prediction is
    2 pi h/period."""
    if cycle is None or lost is None or not lost.sharp:
        return []
    y = None if lost.h is None else 2 * math.pi * lost.h / cycle.period
    known = lost.measured, lost.how
    return [Prediction("cycle", lost.method, None, None, None, lost.h, y, known=known)]


class _Search:
    """Finds orbits of one method that close after m steps in k periods."""

    def __init__(self, asker: Asker, method: str, cycle: Cycle):
        self.asker, self.method, self.cycle = asker, method, cycle
        self.period = cycle.period  # period of the last orbit that was found

    def orbit(self, k: int, m: int, beside: Orbit) -> Orbit | None:
        """Returns the method's orbit that closes after m steps in k periods, or None if none is
        found. The search starts from `beside`, an orbit at a similar step size."""
        h = k * self.period / m
        question = {"method": self.method, "h": h, "count": m, "free": not self.cycle.driven}
        found = self.asker.orbits(state=beside.states[0], **question)
        good = [o for o in found or () if not o.rests and abs(o.h / h - 1) < 0.3]
        if not good:
            return None
        self.period = good[0].h * m / k
        return good[0]

    def leaving(self, orbit: Orbit) -> float:
        """Returns the logarithm of the largest modulus of the orbit's multipliers, without trivial
        ones. If it is positive, displacements from the orbit grow."""
        rest = abs(orbit.beyond(self.cycle.trivial))
        return math.log(rest) if rest else -math.inf

    def outside(self, orbit: Orbit | None) -> bool:
        return orbit is None or self.leaving(orbit) > GROWS

    def parts(self, orbit: Orbit) -> bool:
        """Whether two runs of the method that start near each other, on the cycle, separate."""
        count = LONG if self.cycle.damped else SHORT
        question = {"method": self.method, "h": orbit.h, "count": count}
        state = orbit.states[0]
        status, growth, _ = self.asker.beside(state=state, amplitude=DISPLACED, **question)
        return status != "PK_DONE" or not growth < 1e3


def lost(asker: Asker, method: str, cycle: Cycle) -> Lost | None:
    """Returns the step size at which a method loses the cycle, as a Lost; None if the method has no
    stable cycle even at short steps."""
    search = _Search(asker, method, cycle)
    m, last = FINEST, search.orbit(1, FINEST, cycle.orbit)
    if last is None or search.outside(last):
        return None
    while m > 2:
        fewer = max(min(int(m * COARSER), m - 1), 2)
        found = search.orbit(1, fewer, last)
        if found is None:
            return Lost(method, last.h, None, None, False)
        if search.outside(found):
            return _refined(search, last, m, fewer)
        m, last = fewer, found
    return Lost(method, None, None, None, True)


@record
class _Side:
    k: int
    m: int
    orbit: Orbit | None

    def h(self, period: float) -> float:
        return self.orbit.h if self.orbit else period * self.k / self.m


def _refined(search: _Search, inside: Orbit, most: int, fewest: int) -> Lost:
    """Refines the step size at which the method loses the cycle. With `most` steps per period the
    cycle is kept (the orbit `inside`), with `fewest` steps it is lost. Step sizes in between need
    orbits that close after m steps in k periods. k is multiplied by 3 until neighbouring orbits are
    so close that Newton's method stays on one branch of solutions. k is odd, since after an even
    number of periods an orbit of twice the period would close too."""
    period = inside.h * most

    def narrowed(test: Callable[[Orbit | None], bool]) -> tuple[_Side, _Side]:
        k, search.period = 1, period
        stays, goes = _Side(1, most, inside), _Side(1, fewest, None)
        while True:
            low, high = stays.m * (k // stays.k), goes.m * (k // goes.k)
            while low - high > 1:
                m = (low + high) // 2
                side = _Side(k, m, search.orbit(k, m, stays.orbit or inside))
                if test(side.orbit):
                    goes, high = side, m
                else:
                    stays, low = side, m
            if low >= FINE:
                return stays, goes
            k *= 3

    def middle(stays: _Side, goes: _Side) -> float:
        return (stays.h(period) + goes.h(period)) / 2

    stays, goes = narrowed(search.outside)
    beyond = goes.orbit.beyond(search.cycle.trivial) if goes.orbit else None
    near = stays.orbit is not None and search.leaving(stays.orbit) / stays.k > -CLOSE
    sharp = beyond is not None and near
    measured = middle(*narrowed(lambda o: o is None or search.parts(o))) if sharp else None
    return Lost(search.method, middle(stays, goes), beyond, measured, sharp)


def driven_period(equations: Equations, parameters: tuple[float, ...]) -> float | None:
    """Returns the common period of all sines and cosines of time in the equations, or None. Other
    functions of time may occur in the equations too. Therefore orbits.py checks whether the
    equations really have this period."""
    g = equations.graph
    roots = [*equations.force, *equations.state_rates, *(x for row in equations.mass for x in row)]
    waves = [
        g.args[node][0]
        for node in reachable(g, roots, BIT[Kind.TIME])
        if g.op[node] is Op.CALL and g.data[node] in WAVES
    ]
    values = dict.fromkeys(symbols_in(g, waves), 0.5)
    values |= {s: parameters[s.index] for s in values if s.kind == Kind.PARAMETER}
    phases = [evaluate(g, waves, values | {Symbol(Kind.TIME): t}) for t in (0.0, 1.0)]
    rates = {abs(b - a) for a, b in zip(*phases, strict=True) if b != a}
    if not rates or not all(map(math.isfinite, rates)):
        return None
    slowest = min(rates)
    for k in range(1, MOST_PERIODS + 1):
        turns = [k * rate / slowest for rate in rates]
        if all(abs(x - round(x)) < 1e-9 * x for x in turns):
            return 2 * math.pi * k / slowest
    return None
