"""Finds closed orbits of a method's step map (pk/gsl_orbits.h), and their multipliers."""

from __future__ import annotations

import math

from ...equations import Equations
from ...graph.differentiate import reachable
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, Kind, Op
from ...record import record
from .ask import Asker

WAVES = ("sin", "cos")
MOST_PERIODS = 24  # longest common period, in periods of the slowest driver
ROUNDED = 1e-6  # round-off of a modulus of 1
STILL = 1e-3  # largest |log| of a multiplier that is 1 up to round-off


@record
class Orbit:
    """An orbit that closes after `steps` steps of size h. A state is q, then v."""

    steps: int
    h: float
    states: tuple[tuple[float, ...], ...]
    multipliers: tuple[complex, ...]  # the largest modulus first
    rests: bool  # the equations rest there too: no ghost
    residual: float

    @property
    def growth(self) -> float:
        """Returns the largest modulus of the multipliers."""
        return max(map(abs, self.multipliers), default=0.0)

    @property
    def holds(self) -> bool:
        """Whether it attracts or is neutral."""
        return self.growth < 1 + ROUNDED

    def beyond(self, trivial: int) -> complex:
        """Returns the multiplier of largest modulus, without the `trivial` ones nearest to 1; 0:
        none."""
        others = sorted(self.multipliers, key=lambda z: abs(z - 1))[trivial:]
        return max(others, key=abs, default=0j)


def closed(asker: Asker, **question: object) -> tuple[Orbit, ...]:
    """Returns the orbits found; none if the question is refused."""
    answer = asker.ask("orbits", **question)
    found = []
    for one in answer["orbits"]:
        pairs = zip(one.pop("re"), one.pop("im"), strict=True)
        multipliers = tuple(complex(a or 0.0, b or 0.0) for a, b in pairs)
        states = tuple(tuple(map(float, state)) for state in one.pop("states"))
        found.append(Orbit(states=states, multipliers=multipliers, **one))
    return tuple(found)


def driven_period(equations: Equations, parameters: tuple[float, ...]) -> float | None:
    """Returns the common period of all sines and cosines of time, or None. Time may also occur
    elsewhere: the program checks whether the equations have this period."""
    g = equations.graph
    roots = [*equations.force, *equations.state_rates, *(x for row in equations.mass for x in row)]
    waves = [
        g.args[node][0]
        for node in reachable(g, roots, BIT[Kind.TIME])
        if g.op[node] is Op.CALL and g.data[node] in WAVES
    ]
    values = dict.fromkeys((g.data[n] for n in reachable(g, waves) if g.op[n] is Op.SYMBOL), 0.5)
    for symbol in values:
        if symbol.kind == Kind.PARAMETER:
            values[symbol] = parameters[symbol.index]
    phases = []
    for t in (0.0, 1.0, 2.0):
        at = {s: t if s.kind == Kind.TIME else x for s, x in values.items()}
        phases.append(evaluate(g, waves, at))
    rates = {abs(b - a) for a, b in zip(phases[0], phases[1], strict=True) if b != a}
    if not rates or not all(map(math.isfinite, rates)):
        return None
    slowest = min(rates)
    for k in range(1, MOST_PERIODS + 1):
        turns = [k * rate / slowest for rate in rates]
        if all(abs(x - round(x)) < 1e-9 * x for x in turns):
            return 2 * math.pi * k / slowest
    return None
