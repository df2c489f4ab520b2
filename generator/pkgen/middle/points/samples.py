"""Makes sample states at which claims of `conserve` statements are tested. All values have few
digits, so that a person can check a counterexample."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction

from ...equations import Equations, ParameterSlot, Row
from ...graph.balls import Ball, Balls
from ...graph.differentiate import reachable, symbols_in
from ...graph.evaluate import evaluate
from ...graph.graph import BIT, VARIABLE, Graph, Kind, Node, Symbol
from ...record import record
from .singularities import defaults
from .squares import bounds_of

# The largest number of states. In the first half, parameters have their default values.
TRIED = 72
# The largest number of evaluations of nodes for all samples. So many evaluations take about 2 s.
EFFORT = 100_000
# Values near constants in the equations are tried if the constants have magnitudes in this range.
LEAST, MOST = 1e-3, 1e6


@record
class Sample:
    values: dict[Symbol, Ball]
    # A part of `values`, without accelerations, and without parameters that have their default
    # values.
    chosen: dict[Symbol, Fraction]
    # Whether a parameter has another value than its default.
    varied: bool


def samples(equations: Equations, balls: Balls, g: Graph, nodes: list[Node]) -> Iterator[Sample]:
    """Yields sample states, with values for all symbols in the nodes. The states alternate between
    three kinds: values near the initial values, values of magnitude 1, and values near constants
    that occur in the nodes. If the nodes contain accelerations, these are computed from the
    equations of motion."""
    draw = random.Random(2385)
    solved = any(g.depends[node] & BIT[Kind.ACCELERATION] for node in nodes)
    if solved:
        nodes = [*nodes, *equations.force, *sum(equations.mass, ())]
    below = reachable(g, nodes)
    symbols = symbols_in(g, nodes, VARIABLE & ~BIT[Kind.ACCELERATION])
    used = {s.index for s in symbols_in(g, nodes, BIT[Kind.PARAMETER])}
    starts = equations.start_q, equations.start_v, equations.state_start
    start = started(equations.graph, equations.parameters, starts)
    numbers = _numbers(g, below, start)
    effort = 1 + len(below) + (2 * len(equations.force) ** 3 if solved else 0)
    tried = max(2, min(TRIED, EFFORT // effort))
    for k in range(tried):
        turn, how = divmod(k, 3)
        chosen = {}
        for i, s in enumerate(symbols):
            at = _short(start.get(s, 0.0)) * Fraction(draw.randint(12, 20), 16)
            at = (at, Fraction(0), numbers[(turn + i) % len(numbers)])[how]
            apart = Fraction(draw.choice((-1, 1)) * draw.randint(1, 16), (16, 8, 16)[how])
            chosen[s] = at + apart or apart  # avoids 0, where terms may vanish by chance
        varied = {}
        if k >= tried // 2:
            varied = _varied(equations, draw, used)
            chosen |= varied
        elif not symbols and k:
            continue
        values = _parameters(equations, balls, varied)
        if values is None:
            continue
        values |= {s: balls.number(x) for s, x in chosen.items()}
        more = accelerations(equations, g, balls, values) if solved else {}
        if more is not None:
            yield Sample(values | more, chosen, bool(varied))


def started(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    starts: tuple[Row, Row, Row],
    change: Callable[[int, float], float] = lambda _, value: value,
) -> dict[Symbol, float]:
    """Returns the values of all symbols at the start: the initial values `starts` of coordinates,
    rates and states, the default values of parameters with `change`, and t = 0."""
    values = defaults(g, parameters, change)
    kinds = (Kind.COORDINATE, Kind.RATE, Kind.STATE)
    found = {
        Symbol(kind, i): x
        for kind, row in zip(kinds, starts, strict=True)
        for i, x in enumerate(evaluate(g, row, values))
    }
    return values | found | {Symbol(Kind.TIME): 0.0}


def _numbers(g: Graph, below: list[Node], fixed: dict[Symbol, float]) -> list[Fraction]:
    """Returns the constants in the nodes, and their negatives. If x - 7 occurs, for example, values
    of x near 7 are tried."""
    values = evaluate(g, [n for n in below if not g.depends[n] & VARIABLE], fixed)
    sizes = {abs(_short(value)) for value in values if LEAST < abs(value) < MOST} | {Fraction(8)}
    return sorted(sign * size for size in sizes for sign in (-1, 1))


def _short(value: float) -> Fraction:
    """Returns a value rounded to 3 digits; 0 if the value is infinite or NaN."""
    return Fraction(f"{value:.3g}") if math.isfinite(value) else Fraction(0)


def _varied(equations: Equations, draw: random.Random, used: set[int]) -> dict[Symbol, Fraction]:
    """Returns values other than the defaults for the parameters in `used`, within their bounds.
    Parameters whose default is an expression are left out."""
    g, found = equations.graph, {}
    for k, slot in enumerate(equations.parameters):
        value = g.value(slot.default)
        factor, apart = Fraction(draw.randint(4, 16), 8), Fraction(draw.randint(1, 8), 8)
        if k not in used or value is None:
            continue
        new = value * factor if value else apart
        bounds = bounds_of(g, slot)
        numeric = all(end is None or g.value(end) is not None for end in (slot.lo, slot.hi))
        if numeric and bounds.lo < new < bounds.hi:
            found[Symbol(Kind.PARAMETER, k)] = new
    return found


def _parameters(
    equations: Equations, balls: Balls, varied: dict[Symbol, Fraction]
) -> dict[Symbol, Ball] | None:
    values: dict[Symbol, Ball] = {}
    for k, slot in enumerate(equations.parameters):
        symbol = Symbol(Kind.PARAMETER, k)
        if symbol in varied:
            ball = balls.number(varied[symbol])
        else:
            (ball,) = balls.values(equations.graph, [slot.default], values)
        if ball is None:
            return None
        values[symbol] = ball
    return values


def accelerations(
    equations: Equations, g: Graph, balls: Balls, values: Mapping[Symbol, Ball]
) -> dict[Symbol, Ball] | None:
    """Solves M a = f at one state, with a rigorous bound of the error. Returns the accelerations by
    symbol; None if an entry of M or f has no value, or if M may be nearly singular.

    Let R be an approximate inverse of M, and x an approximate solution, both computed from the
    midpoints of the balls. Then, in the maximum norm,

        |x - a| <= |R| |f - M x| / (1 - |I - R M|)     if |I - R M| < 1.

    Reference: S. M. Rump, Verification methods: rigorous results using floating-point arithmetic,
    Acta Numerica 19 (2010) 287-449, section 10.
    """
    n = len(equations.force)
    entries = balls.values(g, [*sum(equations.mass, ()), *equations.force], values)
    if None in entries:
        return None
    mass = [entries[i * n : (i + 1) * n] for i in range(n)]
    force = entries[n * n :]
    mp = balls.mp
    matrix = mp.matrix([[entry.mid for entry in row] for row in mass])
    try:
        inverse = matrix**-1
    except ZeroDivisionError:
        return None
    x = [Ball(value, mp.mpf(0)) for value in inverse * mp.matrix([f.mid for f in force])]
    minus = balls.number(-1)
    residual = [
        balls.total([f, *(balls.product(minus, m, v) for m, v in zip(row, x, strict=True))])
        for row, f in zip(mass, force, strict=True)
    ]
    size = mp.mnorm(inverse, mp.inf)
    # A bound of the rounding errors of the product inverse * matrix, plus the radii of the entries
    # of M.
    blur = n * balls.tiny * mp.mnorm(matrix, mp.inf) + max(sum(m.rad for m in row) for row in mass)
    contraction = mp.mnorm(inverse * matrix - mp.eye(n), mp.inf) + size * blur
    if contraction >= mp.mpf(1) / 2:
        return None
    error = size * max(entry.most for entry in residual) / (1 - contraction) * (1 + balls.tiny)
    return {Symbol(Kind.ACCELERATION, i): Ball(x[i].mid, error) for i in range(n)}
