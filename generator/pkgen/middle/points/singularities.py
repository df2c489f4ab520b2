"""Where the equations of motion end: what they divide by, or take a root or a logarithm of, as far
as that depends on the motion and can vanish.

Each such expression is taken apart into factors (r sin(theta) vanishes where r does, and where
sin(theta) does), and what interval arithmetic proves to be never zero is left out. A pivot of M
that is a sum, such as the double pendulum's m1 + m2 sin(theta1 - theta2)^2, is a singularity only
if a search finds M singular or indefinite somewhere, for parameters at their defaults, at a bound
that they may have, or anywhere else within their bounds: M of a sound model is positive definite
almost everywhere, and where it is not, the acceleration itself says so.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator

from ...equations import ParameterSlot, Quantity, Singularity
from ...functions import FUNCTIONS
from ...functions.interval import INF
from ...functions.row import COORDINATES, CUT, DIVISOR, ROOT
from ...functions.smooth import where_positive
from ...graph.differentiate import reachable, symbols_in
from ...graph.evaluate import Evaluator, evaluate
from ...graph.graph import BIT, VARIABLE, Graph, Kind, Node, Op, Symbol
from ...graph.ranges import Ranges
from ...graph.solve import Pivots
from ...graph.wording import wording
from .cuts import half_cosine, jumping_angles
from .squares import bounds_of, definite_by_squares, summands

SAMPLES = 25  # states at which the pivots of M are looked at,
EFFORT = 50_000  # values computed in the search for a worse one: some 0.05 s
SCATTER = 200  # and at most so many states with parameters anywhere,
WIDE = 1e3  # so far from their defaults where nothing bounds them
USUAL = 4  # states that say how small a pivot is beside its diagonal entry anyhow,
NEARLY = 1e-4  # and where it is so much smaller still, M is singular nearby


def singularities_of(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    pivots: Pivots,
    outputs: Iterable[Node],
    name: Callable[[Symbol], str],
    lagrangian: Node,
) -> tuple[Singularity, ...]:
    """The singularities of the equations that `outputs` are; those of the chart first."""
    ranges = Ranges(g, [bounds_of(g, slot) for slot in parameters])
    of_mass = [(p, size) for p, size in pivots if g.depends[p] & VARIABLE]
    charts: dict[Node, None] = {}
    motions: dict[Node, str] = {}
    unsure: dict[Node, tuple[Node, Node]] = {}
    for pivot, size in of_mass:
        for node, rest in zeros(g, ranges, pivot):
            if rest and pivot != size:
                unsure[node] = pivot, size
            else:
                charts[node] = None
    if unsure and not definite_by_squares(g, parameters, lagrangian, len(pivots)):
        rows = list(unsure.values())
        suspects = [(state, NEARLY) for state in _least_definite(g, parameters, pivots)]
        suspects += [(state, 0.0) for state in _anywhere(g, parameters, sum(rows, ()))]
        ratios_at = _ratios(g, rows)
        seen = map(ratios_at, _at_random(g, parameters, sum(rows, ()), USUAL))
        usual = [max(0.0, *some) for some in zip(*seen, strict=True)]
        for state, limit in suspects:
            for node, ratio, most in zip(unsure, ratios_at(state), usual, strict=True):
                if not ratio > limit * most:
                    charts[node] = None
    known = {g.split(p)[1] for p, _ in of_mass}
    for base, use in dangerous(g, ranges, [*outputs, *(p for p, _ in of_mass)]):
        if g.split(base)[1] not in known:
            for node, _ in zeros(g, ranges, base):
                if node not in motions or use == DIVISOR:
                    motions[node] = use
    found = dict.fromkeys(charts, COORDINATES)
    found |= {node: use for node, use in motions.items() if node not in charts}
    found |= dict.fromkeys(
        (half_cosine(g, x) for x in jumping_angles(g, [lagrangian], ranges)), CUT
    )
    squares = {square for node in found for square in squared(g, node)}
    return tuple(
        Singularity(Quantity(wording(g, about(g, node), name), "", ""), node, use)
        for node, use in found.items()
        if node not in squares  # r, not r^2 too
    )


def _is_call(g: Graph, node: Node, *functions: str) -> bool:
    return g.op[node] is Op.CALL and g.data[node] in functions


def squared(g: Graph, node: Node) -> tuple[Node, ...]:
    """What a root is taken of."""
    return g.args[node] if _is_call(g, node, "sqrt") else ()


def dangerous(g: Graph, ranges: Ranges, outputs: Iterable[Node]) -> Iterator[tuple[Node, str]]:
    """What must not vanish for the outputs to be finite and smooth, and how they use it."""
    for node in reachable(g, outputs, VARIABLE):
        first = g.args[node][0] if g.args[node] else node
        if g.op[node] is Op.POWER:
            if g.data[node] < 0 or (
                g.data[node].denominator > 1 and not ranges(first).not_negative
            ):
                yield first, DIVISOR if g.data[node] < 0 else ROOT
        elif g.op[node] is Op.CALL and (singular := FUNCTIONS[g.data[node]].singular):
            vanishing, use = singular(g, *g.args[node])
            # Of a sum of squares, a root alone is no more than a kink.
            if use != ROOT or not ranges(vanishing).not_negative:
                yield vanishing, use


def about(g: Graph, singularity: Node) -> Node:
    """What the singularity is about."""
    if _is_call(g, singularity, "cos"):  # of half an angle
        _, angle = g.split(g.args[singularity][0])
        singularity = angle if _is_call(g, angle, "atan2") else singularity
    return g.args[g.args[singularity][0]][0] if _is_call(g, singularity, "pow") else singularity


def zeros(g: Graph, ranges: Ranges, node: Node) -> Iterator[tuple[Node, bool]]:
    """The factors of a node that may vanish, down to what is no product; and whether it is a sum of
    which no more is known."""
    for base, _ in g.factors(node):
        if not g.depends[base] & VARIABLE or ranges(base).never_zero:
            continue
        op, first = g.op[base], (g.args[base] or (base,))[0]
        inside = op is Op.POWER or (op is Op.CALL and FUNCTIONS[g.data[base]].like_argument)
        if inside and not (_is_call(g, base, "sqrt") and ranges(first).not_negative):
            yield from zeros(g, ranges, first)
        elif op is Op.ADD:
            common, rest = _common(g, base)
            for factor in common:
                yield from zeros(g, ranges, factor)
            if not ranges(rest).never_zero:
                yield rest, True
        elif _is_call(g, base, "pow") and not _is_call(g, first, "abs"):
            yield where_positive(g, first, g.args[base][1]), False
        else:
            yield base, False


def _common(g: Graph, node: Node) -> tuple[list[Node], Node]:
    """The factors that all terms of a sum share, and the sum without them."""
    powers = [dict(g.factors(term)) for term in summands(g, node)]
    shared = {
        base: min(p[base] for p in powers)
        for base in powers[0]
        if g.value(base) is None and all(p.get(base, 0) > 0 for p in powers)
    }
    if not shared:
        return [], node
    divisor = {base: -power for base, power in shared.items()}
    rest = g.sum(g.product(g.power(b, e + divisor.get(b, 0)) for b, e in p.items()) for p in powers)
    return list(shared), rest


def _moving(g: Graph, nodes: Iterable[Node]) -> tuple[list[Symbol], list[int]]:
    """What the nodes depend on: the state's symbols, and the parameters."""
    parameters = symbols_in(g, nodes, BIT[Kind.PARAMETER])
    return symbols_in(g, nodes, VARIABLE), [x.index for x in parameters]


def _drawn(draw: random.Random, symbol: Symbol) -> float:
    return draw.uniform(-3, 3) * (0.3 if symbol.kind == Kind.RATE else 1)


def defaults(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    change: Callable[[int, float], float] = lambda _, value: value,
) -> dict[Symbol, float]:
    """Of parameters, each changed before others that follow from it."""
    fixed: dict[Symbol, float] = {}
    for k, slot in enumerate(parameters):
        fixed[Symbol(Kind.PARAMETER, k)] = change(k, evaluate(g, [slot.default], fixed)[0])
    return fixed


def _anywhere(
    g: Graph, parameters: tuple[ParameterSlot, ...], nodes: list[Node]
) -> Iterator[dict[Symbol, float]]:
    """States with the parameters anywhere within their bounds: between two of them, else up to
    WIDE times the default."""
    draw = random.Random(2385)
    moving, used = _moving(g, nodes)
    bounds = {k: bounds_of(g, parameters[k]) for k in used}

    def change(k: int, value: float) -> float:
        if k not in bounds:
            return value
        lo, hi = bounds[k].lo, bounds[k].hi
        if lo > -INF and hi < INF:
            return draw.uniform(lo, hi)
        return min(max(value * WIDE ** draw.uniform(-1, 1), lo), hi)

    if used:
        for _ in range(max(SAMPLES, min(SCATTER, EFFORT // len(reachable(g, nodes))))):
            fixed = defaults(g, parameters, change)
            yield fixed | {symbol: _drawn(draw, symbol) for symbol in moving}


def _at_random(
    g: Graph, parameters: tuple[ParameterSlot, ...], nodes: Iterable[Node], count: int
) -> Iterator[dict[Symbol, float]]:
    draw, fixed = random.Random(2385), defaults(g, parameters)
    moving, _ = _moving(g, nodes)
    for _ in range(count):
        yield fixed | {symbol: _drawn(draw, symbol) for symbol in moving}


def _ratios(g: Graph, pivots: Iterable[tuple[Node, Node]]) -> Callable[..., list[float]]:
    """Of each pivot beside its diagonal entry, at a state; negative where one is not positive."""
    values_at = Evaluator(g, [x for pair in pivots for x in pair])

    def ratios(state: dict[Symbol, float]) -> list[float]:
        values = iter(values_at(state))
        return [p / size if p > 0 < size else -1.0 for p, size in zip(values, values, strict=True)]

    return ratios


def _least_definite(
    g: Graph, parameters: tuple[ParameterSlot, ...], pivots: Pivots
) -> Iterator[dict[Symbol, float]]:
    """The state, of many, at which M is nearest to singular: with the parameters' defaults, then
    with each at a bound that it may have."""
    nodes = [x for pair in pivots for x in pair]
    moving, used = _moving(g, nodes)
    cases: list[tuple[int, float]] = [(-1, 0.0)]
    for k in used:
        at = bounds_of(g, parameters[k])
        cases += [(k, at.lo)] if not at.above and at.lo > -INF else []
        cases += [(k, at.hi)] if not at.below and at.hi < INF else []
    ratios_at = _ratios(g, pivots)
    left = max(SAMPLES, EFFORT // len(cases) // len(reachable(g, nodes)))
    for which, bound in cases:
        fixed = defaults(g, parameters, {which: bound}.get)
        yield _least_at(lambda state: min(ratios_at(state)), fixed, moving, left)


def _least_at(
    ratio: Callable[[dict[Symbol, float]], float],
    fixed: dict[Symbol, float],
    moving: list[Symbol],
    left: int,
) -> dict[Symbol, float]:
    draw = random.Random(2385)
    states = [fixed | {s: _drawn(draw, s) for s in moving} for _ in range(SAMPLES)]
    least, best = min((ratio(state), k) for k, state in enumerate(states))
    state, width = states[best], 1.0
    for k in range((left - SAMPLES) // 2):  # a coordinate at a time, by ever shorter steps
        symbol = moving[k % len(moving)]
        for step in (width, -width):
            moved = state | {symbol: state[symbol] + step}
            there = ratio(moved)
            if there < least:
                least, state = there, moved
        width *= 0.8 if symbol == moving[-1] else 1
    return state
