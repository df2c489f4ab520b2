"""Makes the constraint rows J v + j0 = 0 of models with loops, from `constraint` and `rolling`.

A statement with an index i has one row for each i = m, which contains members with indices m plus a
constant. A member beyond an end of its family has a given value, or is identified with a member of
the family, to whose column of J its derivatives are added. A statement without an index has a
single row, which may contain sums over members.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

from ...graph.differentiate import gradient
from ...graph.graph import ZERO, Node
from ...graph.rounding import sizes
from ...indices import multipliers
from ...model import Constraint
from .expand import LoopExpander
from .indexed_ir import Bound, Group, Part, Row, Total, Unrolled
from .pair_sums import RATES, M
from .rows import Gather
from .terms import Term, terms


def bound_of(x: LoopExpander, gather: Gather) -> tuple[Bound, ...]:
    """Returns all constraint rows, those of holonomic constraints first. `x` then knows the names
    of the multipliers of these rows."""
    declared = sorted(x.model.constraints, key=lambda item: not item.holonomic)
    found = tuple(_bound(x, gather, item, str(k)) for k, item in enumerate(declared))
    for rows in found:
        # No row is redundant, so that lambda_NAME and least_lambda_NAME are the same multiplier.
        for name in multipliers(rows.name):
            x.multipliers.setdefault(name, []).append(rows.group)
    return found


def _bound(x: LoopExpander, gather: Gather, item: Constraint, key: str) -> Bound:
    lo, hi, loop = x.over(item.range, item.index)
    group = Group(replace(item, name=key), lo, hi)
    if item.range is None:
        return _single(x, gather, item, group, terms(x, item.value, loop))
    node = x.scalar(item.value, loop)
    gather.found.limits += x.limits_over(lo, hi)
    for slot in x.slots.below(node):
        gather.bodies.member(slot, lo, hi)
    position, rate, coasting, of = _values(x, gather, item, node)

    def row(value: Node) -> Row:
        return Row((Part(lo, hi, value, gather.inner(value)),))

    entries = {}
    for symbol, value in gradient(x.graph, rate, RATES).items():
        slot = x.slots.of(symbol)
        if value != ZERO:
            _check_affine(x, item, value)
            shift = None if slot.at is None else (slot.at - M).constant
            entries[slot.name, shift] = row(value)
    if all(shift is None for _, shift in entries):
        raise Unrolled(f"no member of a family moves in each row of '{item.name}'")
    sized = tuple(map(row, of))
    return Bound(item.name, group, row(position), row(rate), row(coasting), sized, entries)


def _values(
    x: LoopExpander, gather: Gather, item: Constraint, node: Node
) -> tuple[Node, Node, Node, tuple[Node, ...]]:
    """Returns four results: phi (0 for `rolling`); J v + j0; the time derivative of J v + j0 if all
    accelerations are 0; and bounds of the rounding errors of phi and of J v + j0."""
    rate = x.derivative(node) if item.holonomic else node
    position = node if item.holonomic else ZERO
    if x.totals.moving(rate, position):
        raise Unrolled(f"a sum stands inside a function in '{item.name}'")
    return position, rate, gather.coast(rate), sizes(x.graph, (position, rate))


def _check_affine(x: LoopExpander, item: Constraint, entry: Node) -> None:
    if x.graph.depends[entry] & RATES:
        raise Unrolled(f"'{item.name}' was not seen to be affine in the rates")


def _single(
    x: LoopExpander, gather: Gather, item: Constraint, group: Group, found: list[Term]
) -> Bound:
    g = x.graph
    border, corner = defaultdict(list), defaultdict(Total)
    totals = [Total() for _ in range(5)]
    for term in found:
        if len(term.ranges) > 1:
            raise Unrolled(f"a sum over two indices stands in '{item.name}'")
        for family, shift, body in gather.bodies.views(term):
            rate = _values(x, gather, item, body)[1]
            at = M if term.ranges else shift
            value = gradient(g, rate, RATES).get(x.slots.node("v", family, at), ZERO)
            if value != ZERO:
                _check_affine(x, item, value)
                gather.add(border[family], term, shift, value)
        body = gather.bodies.at_row(term)
        position, rate, coasting, of = _values(x, gather, item, body)
        for name in gather.bodies.scalars(body):
            value = gradient(g, rate, RATES).get(x.slots.node("v", name), ZERO)
            if value != ZERO:
                _check_affine(x, item, value)
                corner[name] = gather.with_(corner[name], term, value)
        values = (position, rate, coasting, *of)
        totals = [gather.with_(*each) for each in zip(totals, [term] * 5, values, strict=True)]
    if not (border or corner):
        raise Unrolled(f"nothing moves in '{item.name}'")
    rows = {name: Row(tuple(parts)) for name, parts in border.items()}
    position, rate, coasting, *of = totals
    single = Bound(item.name, group, position, rate, coasting, tuple(of))
    return replace(single, border=rows, corner=dict(corner))
