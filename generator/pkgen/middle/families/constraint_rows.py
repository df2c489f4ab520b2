"""Makes the constraint rows J v + j0 = 0 of models with loops, from `constraint` and `rolling`.

A statement with an index i has one row for each i = m, which contains members with indices m plus a
constant. A statement without an index has a single row, which may contain sums over members.
"""

from __future__ import annotations

from dataclasses import replace

from ...graph.affine import Affine
from ...graph.differentiate import gradient
from ...graph.graph import ZERO, Node
from ...graph.rounding import sizes
from ...indices import multipliers
from ...model import Constraint
from .expand import FamilyExpander
from .indexed_ir import Addend, Bound, Cell, Group, NotKept, Over, Sum, merged
from .rows import RATES, Assembler
from .slots import M
from .terms import terms


def bound_of(x: FamilyExpander, assembler: Assembler) -> tuple[Bound, ...]:
    """Returns all constraint rows, those of holonomic constraints first. `x` then knows the names
    of the multipliers of these rows."""
    declared = sorted(x.model.constraints, key=lambda item: not item.holonomic)
    found = tuple(_bound(x, assembler, item, str(k)) for k, item in enumerate(declared))
    for rows in found:
        # No row is redundant, so that lambda_NAME and least_lambda_NAME are the same multiplier.
        for name in multipliers(rows.name):
            x.multipliers.setdefault(name, []).append(rows.group)
    return found


def _bound(x: FamilyExpander, assembler: Assembler, item: Constraint, key: str) -> Bound:
    lo, hi, loop = x.over(item.range, item.index)
    group, single = Group(replace(item, name=key), lo, hi), item.range is None
    if single:
        found = terms(x, item.value, loop)
        if any(len(term.ranges) > 1 for term in found):
            raise NotKept(f"a sum over two indices stands in '{item.name}'")
        bodies = assembler.bodies(found)
    else:
        bodies = (_of_each(x, assembler, item, lo, hi, loop),)
    row = (key, None if single else M)
    values: list[list[Addend]] = [[] for _ in range(5)]
    jacobian: list[Addend] = []
    for body in bodies:
        position, rate, coasting, of = _values(x, assembler, item, body.node)
        for found, node in zip(values, (position, rate, coasting, *of), strict=True):
            found.append(Addend(body.over, node, (row,)))
        jacobian += _entries(x, item, body.over, rate, row)
    whole: Sum = merged(jacobian, x.graph)
    if not whole:
        raise NotKept(f"nothing moves in '{item.name}'")
    if not single and all(at is None for _, (_, at) in (entry.to for entry in whole)):
        raise NotKept(f"no member of a family moves in each row of '{item.name}'")
    position, rate, coasting, *of = (merged(found, x.graph) for found in values)
    return Bound(item.name, group, single, position, rate, coasting, tuple(of), whole)


def _of_each(
    x: FamilyExpander, assembler: Assembler, item: Constraint, lo: Affine, hi: Affine, loop
) -> Addend:
    node = x.scalar(item.value, loop)
    assembler.reach((lo, hi), node)
    return Addend((lo, hi), node)


def _values(
    x: FamilyExpander, assembler: Assembler, item: Constraint, node: Node
) -> tuple[Node, Node, Node, tuple[Node, ...]]:
    """Returns four results: phi (0 for `rolling`); J v + j0; the time derivative of J v + j0 if all
    accelerations are 0; and bounds of the rounding errors of phi and of J v + j0."""
    rate = x.derivative(node) if item.holonomic else node
    position = node if item.holonomic else ZERO
    if x.totals.moving(rate, position):
        raise NotKept(f"a sum stands inside a function in '{item.name}'")
    return position, rate, assembler.coast(rate), sizes(x.graph, (position, rate))


def _entries(
    x: FamilyExpander, item: Constraint, over: Over, rate: Node, row: Cell
) -> list[Addend]:
    found = []
    for symbol, node in gradient(x.graph, rate, RATES).items():
        if x.graph.depends[node] & RATES:
            raise NotKept(f"'{item.name}' was not seen to be affine in the rates")
        slot = x.slots.of(symbol)
        found.append(Addend(over, node, (row, (slot.name, slot.at))))
    return found
