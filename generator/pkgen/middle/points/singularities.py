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

from ...equations import Matrix, ParameterSlot, Quantity, Singularity
from ...functions import FUNCTIONS
from ...functions.interval import INF, Range
from ...functions.row import COORDINATES, DIVISOR, ROOT
from ...functions.smooth import where_positive
from ...graph.differentiate import reachable, symbols_in
from ...graph.evaluate import Evaluator, evaluate
from ...graph.graph import BIT, VARIABLE, Graph, Kind, Node, Op, Symbol
from ...graph.ranges import Ranges
from ...graph.wording import wording

SAMPLES = 25  # states at which the pivots of M are looked at,
EFFORT = 50_000  # values computed in the search for a worse one: some 0.05 s
SCATTER = 200  # and at most so many states with parameters anywhere,
WIDE = 1e3  # so far from their defaults where nothing bounds them
NEARLY = 1e-4  # a pivot beside its diagonal entry: M is singular nearby


def singularities_of(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    mass: Matrix,
    outputs: Iterable[Node],
    pivots: Iterable[Node],
    name: Callable[[Symbol], str],
) -> tuple[Singularity, ...]:
    """The singularities of the equations that `outputs` are; those of the chart first."""
    ranges = Ranges(g, [bounds_of(g, slot) for slot in parameters])
    of_mass = {i: p for i, p in enumerate(pivots) if g.depends[p] & VARIABLE}
    charts: dict[Node, None] = {}
    motions: dict[Node, str] = {}
    unsure: dict[Node, int] = {}
    for i, pivot in of_mass.items():
        for node, rest in zeros(g, ranges, pivot):
            if rest and pivot != mass[i][i]:
                unsure[node] = i
            else:
                charts[node] = None
    if unsure:
        rows = list(unsure.values())
        wanted = [of_mass[i] for i in rows] + [mass[i][i] for i in rows]
        suspects = [(state, NEARLY) for state in _least_definite(g, parameters, mass)]
        suspects += [(state, 0.0) for state in _anywhere(g, parameters, wanted)]
        pivots_at = Evaluator(g, wanted)
        for state, limit in suspects:
            values = pivots_at(state)
            for node, pivot, diagonal in zip(unsure, values, values[len(rows) :], strict=False):
                if not pivot > limit * diagonal:
                    charts[node] = None
    known = {g.split(p)[1] for p in of_mass.values()}
    for base, use in dangerous(g, ranges, [*outputs, *of_mass.values()]):
        if g.split(base)[1] not in known:
            for node, _ in zeros(g, ranges, base):
                if node not in motions or use == DIVISOR:
                    motions[node] = use
    found = dict.fromkeys(charts, COORDINATES)
    found |= {node: use for node, use in motions.items() if node not in charts}
    squares = {square for node in found for square in squared(g, node)}
    return tuple(
        Singularity(Quantity(wording(g, about(g, node), name), "", ""), node, use)
        for node, use in found.items()
        if node not in squares  # r, not r^2 too
    )


def bounds_of(g: Graph, slot: ParameterSlot) -> Range:
    lo = -INF if slot.lo is None or g.value(slot.lo) is None else float(g.value(slot.lo))
    hi = INF if slot.hi is None or g.value(slot.hi) is None else float(g.value(slot.hi))
    return Range(lo, hi, slot.lo_open, slot.hi_open)


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


def summands(g: Graph, node: Node) -> list[Node]:
    """The terms of a sum, of sums within it too."""
    terms, stack = [], [node]
    while stack:
        part = stack.pop()
        if g.op[part] is Op.ADD:
            stack.extend(g.args[part])
        else:
            terms.append(part)
    return terms


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


def _least_definite(
    g: Graph, parameters: tuple[ParameterSlot, ...], mass: Matrix
) -> Iterator[dict[Symbol, float]]:
    """The state, of many, at which M is nearest to singular: with the parameters' defaults, then
    with each at a bound that it may have."""
    _, used = _moving(g, [x for row in mass for x in row])
    cases: list[tuple[int, float]] = [(-1, 0.0)]
    for k in used:
        at = bounds_of(g, parameters[k])
        cases += [(k, at.lo)] if not at.above and at.lo > -INF else []
        cases += [(k, at.hi)] if not at.below and at.hi < INF else []
    for which, bound in cases:
        fixed = defaults(g, parameters, {which: bound}.get)
        yield _least_definite_at(g, fixed, mass, EFFORT // len(cases))


def _least_definite_at(
    g: Graph, fixed: dict[Symbol, float], mass: Matrix, effort: int
) -> dict[Symbol, float]:
    entries = [x for i, row in enumerate(mass) for x in row[: i + 1]]
    draw = random.Random(2385)
    moving, _ = _moving(g, entries)
    left = max(SAMPLES, effort // (len(reachable(g, entries)) + len(mass) ** 3))

    entries_at = Evaluator(g, entries)

    def ratio(state: dict[Symbol, float]) -> float:
        return _least_ratio(len(mass), entries_at(state))

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


def _least_ratio(n: int, entries: list[float]) -> float:
    """The least pivot of M = L D L^T beside its diagonal entry; negative where one is not positive.
    `entries` are those of the lower triangle, row by row."""
    flat = iter(entries)
    rows = [[next(flat) for _ in range(i + 1)] for i in range(n)]
    least = INF
    for j in range(n):
        diagonal = rows[j][j]
        pivot = diagonal - sum(rows[j][k] ** 2 * rows[k][k] for k in range(j))
        if not (pivot > 0 and diagonal > 0):
            return -1.0
        least = min(least, pivot / diagonal)
        rows[j][j] = pivot
        for i in range(j + 1, n):
            inner = sum(rows[i][k] * rows[j][k] * rows[k][k] for k in range(j))
            rows[i][j] = (rows[i][j] - inner) / pivot
    return least
