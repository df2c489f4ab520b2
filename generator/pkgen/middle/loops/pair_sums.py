"""Double sums over pairs of members: the summand for a pair (m, j), and its derivatives by both
members."""

from __future__ import annotations

from dataclasses import replace

from ...graph.affine import OTHER, ROW, Affine, extremes, variable
from ...graph.differentiate import gradient
from ...graph.graph import BIT, MINUS_ONE, ZERO, Graph, Kind, Node
from .expand import LoopExpander
from .indexed_ir import CELLS, REACHED, PairForce, Unrolled
from .loops import Limit
from .terms import Term

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE]
RATES = BIT[Kind.RATE]
ATTITUDES = BIT[Kind.STATE]
M, J = variable(ROW), variable(OTHER)


def signed(g: Graph, node: Node, sign: int) -> Node:
    return node if sign > 0 else g.multiply(MINUS_ONE, node)


def pair_ranges(term: Term) -> tuple[Affine, Affine, Affine, Affine]:
    (own, lo, hi), (_, first, last) = term.ranges
    return lo, hi, first.replaced({own: M}), last.replaced({own: M})


def pair_body(x: LoopExpander, term: Term, limits: list[Limit]) -> Node:
    x.members.clear()
    body = x.totals.throughout(term.at(x, M, J))
    _in_reach(x, body, pair_ranges(term), limits)
    return body


def pair_row(
    x: LoopExpander, name: str, lo: Affine, hi: Affine, term: Term, limits: list[Limit]
) -> PairForce:
    """Returns the contribution of a sum over j to the force on each member m = lo..hi of a family,
    or to the time derivative of each state m."""
    (_, first, last) = term.ranges[0]
    over = lo, hi, first, last
    x.members.clear()
    body = x.totals.throughout(term.at(x, J))
    _in_reach(x, body, over, limits)
    return PairForce(*over, ((name, body),), (), ())


def _in_reach(
    x: LoopExpander, body: Node, over: tuple[Affine, Affine, Affine, Affine], limits: list[Limit]
) -> None:
    lo, hi, first, last = over
    # The least and greatest values of indices are valid only if both ranges are not empty.
    at = {OTHER: (first, last), ROW: (lo, hi)}
    limits += x.limits_of(hi - lo, at)
    for slot in x.slots.below(body):
        if slot.kind not in REACHED or slot.at is None:
            continue
        if slot.at not in (M, J):
            raise Unrolled("a pair sum reaches beside its own members")
        group = x.coordinates[slot.name]
        low, high = (lo, hi) if slot.at == M else (first, last)
        for needs in (low - group.lo, group.hi - high):
            limits.append(Limit(extremes(needs, {ROW: (lo, hi)})[0], hi - lo))


def pair_force(x: LoopExpander, term: Term, body: Node, drag: bool) -> PairForce:
    if x.graph.depends[body] & RATES and not drag:
        raise Unrolled("a pair sum has rates in it: M would be dense")
    by = gradient(x.graph, body, RATES if drag else STATE | ATTITUDES)
    sides: dict[Affine | None, list[tuple[str, Node]]] = {M: [], J: [], None: []}
    slots = [slot for slot in x.slots.below(body) if slot.kind in ("v" if drag else CELLS)]
    cells = dict.fromkeys((n, slot.at) for slot in slots for n in x.rotations.moved(slot))
    for name, at in cells:
        own = by.get(x.slots.node("v", name, at), ZERO)
        node = own if drag else x.rotations.slope(by, name, at, False)
        if node != ZERO:
            sides[at].append((name, node))
    return PairForce(*pair_ranges(term), tuple(sides[M]), tuple(sides[J]), tuple(sides[None]))


def scaled(g: Graph, factor: Node, force: PairForce) -> PairForce:
    def times(side: tuple[tuple[str, Node], ...]) -> tuple[tuple[str, Node], ...]:
        return tuple((name, g.multiply(factor, node)) for name, node in side)

    sides = ("by_row", "by_other", "by_scalar")
    return replace(force, **{side: times(getattr(force, side)) for side in sides})
