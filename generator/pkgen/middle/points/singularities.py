"""Finds singularities of the equations of motion: divisors, and arguments of roots and logarithms,
that depend on the state and may vanish.

Each such expression is split into factors: r sin(theta) vanishes where r or sin(theta) does.
Factors that are proved nonzero by interval arithmetic are left out. A pivot of M that is a sum,
such as m1 + m2 sin(theta1 - theta2)^2 for a double pendulum, counts as a singularity only if a
search finds a state where M is singular or indefinite, for parameters at their defaults, at their
bounds, or between these. If the search misses such a state, the runtime reports an error where the
acceleration cannot be computed.
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
from ...graph.graph import BIT, ONE, VARIABLE, Graph, Kind, Node, Op, Symbol
from ...graph.ranges import Ranges
from ...graph.solve import Pivots
from ...graph.wording import wording
from .cuts import half_cosine, is_call, jumping_angles
from .squares import bounds_of, definite_by_squares, summands

# The number of random states at which the pivots of M are evaluated.
SAMPLES = 25
# The largest number of evaluations of nodes in the search for the smallest pivot. So many
# evaluations take about 0.05 s.
EFFORT = 50_000
# The largest number of states with random parameters.
SCATTER = 200
# A random value of a parameter without bounds is its default value times a factor between 1/WIDE
# and WIDE.
WIDE = 1e3
# Each pivot is divided by its diagonal entry of M. The usual value of this ratio is found from this
# number of random states.
USUAL = 4
# Each pivot is divided by its diagonal entry of M. M counts as singular at a state if this ratio is
# at most NEARLY times its usual value.
NEARLY = 1e-4


def singularities_of(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    pivots: Pivots,
    outputs: Iterable[Node],
    name: Callable[[Symbol], str],
    lagrangian: Node,
) -> tuple[Singularity, ...]:
    """Returns the singularities of the expressions `outputs`. Singularities of M, at which the
    coordinates are singular, come first."""
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
        anyhow = _at_random(defaults(g, parameters), _moving(g, sum(rows, ()))[0], USUAL)
        usual = [max(0.0, *some) for some in zip(*map(ratios_at, anyhow), strict=True)]
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
        if node not in squares  # if both sqrt(x) and x are singularities, only sqrt(x) is kept
    )


def squared(g: Graph, node: Node) -> tuple[Node, ...]:
    """Returns the argument of a square root as a tuple; () for any other node."""
    return g.args[node] if is_call(g, node, "sqrt") else ()


def dangerous(g: Graph, ranges: Ranges, outputs: Iterable[Node]) -> Iterator[tuple[Node, str]]:
    """Yields the nodes at whose zeros the outputs may be infinite or not smooth, each with the
    reason as in `Singularity.use`. A node in a branch of an `if` counts only where the branch is
    chosen."""
    for node, chosen in _with_conditions(g, outputs):
        for vanishing, use in _dangerous(g, ranges, node):
            if chosen != ONE:
                size = g.call("abs", vanishing) if use == DIVISOR else vanishing
                vanishing = g.call("select", chosen, size, ONE)
            yield vanishing, use


def _with_conditions(g: Graph, outputs: Iterable[Node]) -> Iterator[tuple[Node, Node]]:
    """Yields the nodes below the outputs, each with the condition under which it is used: ONE, or a
    node that is 1 where the branches of `if` in which it stands are chosen, and 0 elsewhere. A node
    that is used in several ways has ONE."""
    found = dict.fromkeys(outputs, ONE)
    order = reachable(g, [*found], VARIABLE)
    for node in reversed(order):
        chosen, args = found[node], g.args[node]
        ways = [chosen] * len(args)
        if is_call(g, node, "select"):
            c = args[0]
            ways = [chosen, g.multiply(chosen, c), g.multiply(chosen, g.subtract(ONE, c))]
        for a, way in zip(args, ways, strict=True):
            found[a] = way if found.get(a, way) == way else ONE
    yield from ((node, found[node]) for node in order)


def _dangerous(g: Graph, ranges: Ranges, node: Node) -> Iterator[tuple[Node, str]]:
    first = g.args[node][0] if g.args[node] else node
    if g.op[node] is Op.POWER:
        if g.data[node] < 0 or (g.data[node].denominator > 1 and not ranges(first).not_negative):
            yield first, DIVISOR if g.data[node] < 0 else ROOT
    elif g.op[node] is Op.CALL and (singular := FUNCTIONS[g.data[node]].singular):
        vanishing, use = singular(g, *g.args[node])
        # The root of a nonnegative argument, such as a sum of squares, is real everywhere, and has
        # at most a kink where it vanishes.
        if use != ROOT or not ranges(vanishing).not_negative:
            yield vanishing, use


def about(g: Graph, singularity: Node) -> Node:
    """Returns the expression that messages show for a singularity: an angle in place of the cosine
    of its half, the base in place of a power."""
    if is_call(g, singularity, "cos"):  # the cosine of half an angle atan2(y, x)
        _, angle = g.split(g.args[singularity][0])
        singularity = angle if is_call(g, angle, "atan2") else singularity
    if is_call(g, singularity, "select"):
        singularity = g.args[singularity][1]
    return g.args[g.args[singularity][0]][0] if is_call(g, singularity, "pow") else singularity


def zeros(g: Graph, ranges: Ranges, node: Node) -> Iterator[tuple[Node, bool]]:
    """Yields pairs: a factor of the node that may vanish, and whether this factor is a sum. If a
    factor is a function that vanishes where its argument does, yields the factors of the argument
    instead."""
    for base, _ in g.factors(node):
        if not g.depends[base] & VARIABLE or ranges(base).never_zero:
            continue
        op, first = g.op[base], (g.args[base] or (base,))[0]
        inside = op is Op.POWER or (op is Op.CALL and FUNCTIONS[g.data[base]].like_argument)
        if inside and not (is_call(g, base, "sqrt") and ranges(first).not_negative):
            yield from zeros(g, ranges, first)
        elif op is Op.ADD:
            common, rest = _common(g, base)
            for factor in common:
                yield from zeros(g, ranges, factor)
            if not ranges(rest).never_zero:
                yield rest, True
        elif is_call(g, base, "pow") and not is_call(g, first, "abs"):
            yield where_positive(g, first, g.args[base][1]), False
        else:
            yield base, False


def _common(g: Graph, node: Node) -> tuple[list[Node], Node]:
    """Returns the factors that all terms of a sum have in common, and the sum divided by these."""
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
    """Returns the symbols in the nodes that are no parameters, and the indices of the parameters in
    the nodes."""
    parameters = symbols_in(g, nodes, BIT[Kind.PARAMETER])
    return symbols_in(g, nodes, VARIABLE), [x.index for x in parameters]


def _drawn(draw: random.Random, symbol: Symbol) -> float:
    return draw.uniform(-3, 3) * (0.3 if symbol.kind == Kind.RATE else 1)


def _at_random(
    fixed: dict[Symbol, float], moving: list[Symbol], count: int
) -> list[dict[Symbol, float]]:
    draw = random.Random(2385)
    return [fixed | {symbol: _drawn(draw, symbol) for symbol in moving} for _ in range(count)]


def defaults(
    g: Graph,
    parameters: tuple[ParameterSlot, ...],
    change: Callable[[int, float], float] = lambda _, value: value,
) -> dict[Symbol, float]:
    """Returns the default values of the parameters. The function `change` is called with the index
    and the default value of each parameter, and returns the value to be used. Default values that
    depend on this parameter follow the change."""
    fixed: dict[Symbol, float] = {}
    for k, slot in enumerate(parameters):
        fixed[Symbol(Kind.PARAMETER, k)] = change(k, evaluate(g, [slot.default], fixed)[0])
    return fixed


def _anywhere(
    g: Graph, parameters: tuple[ParameterSlot, ...], nodes: list[Node]
) -> Iterator[dict[Symbol, float]]:
    """Yields random states with random parameters. A parameter with two bounds gets a value between
    them. Any other parameter gets its default value times a factor between 1/WIDE and WIDE; if this
    is beyond a bound of the parameter, it gets the bound."""
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

    count = max(SAMPLES, min(SCATTER, EFFORT // len(reachable(g, nodes)))) if used else 0
    for _ in range(count):
        fixed = defaults(g, parameters, change)
        yield fixed | {symbol: _drawn(draw, symbol) for symbol in moving}


def _ratios(g: Graph, pivots: Iterable[tuple[Node, Node]]) -> Callable[..., list[float]]:
    """Returns a function that returns, for a state, the ratios of the pivots to their diagonal
    entries of M. A ratio is -1 if the pivot or the entry is not positive."""
    values_at = Evaluator(g, [x for pair in pivots for x in pair])

    def ratios(state: dict[Symbol, float]) -> list[float]:
        values = iter(values_at(state))
        return [p / size if p > 0 < size else -1.0 for p, size in zip(values, values, strict=True)]

    return ratios


def _least_definite(
    g: Graph, parameters: tuple[ParameterSlot, ...], pivots: Pivots
) -> Iterator[dict[Symbol, float]]:
    """Searches for states at which M is closest to singular, and yields one for each choice of
    parameters. In the first choice all parameters have their default values. In each further
    choice, one parameter has one of its bounds, if it can attain this bound."""
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
    states = _at_random(fixed, moving, SAMPLES)
    least, best = min((ratio(state), k) for k, state in enumerate(states))
    state, width = states[best], 1.0
    for k in range((left - SAMPLES) // 2):  # a coordinate search with decreasing steps
        symbol = moving[k % len(moving)]
        for step in (width, -width):
            moved = state | {symbol: state[symbol] + step}
            there = ratio(moved)
            if there < least:
                least, state = there, moved
        width *= 0.8 if symbol == moving[-1] else 1
    return state
