"""Sums in initial values and parameters, such as `start q[i] = a[i] - sum(a[j], j = 1..N)`.

Each sum becomes a loop of its own in C. The loop is placed as far outside as its terms allow:
before the loop over the members of the statement, inside this loop, or inside the loop of another
sum.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from ...graph.affine import COUNTERS, ROW, Affine, variable
from ...graph.graph import Node
from ...tree import Sum
from .equations import Assigned, Limit, Summed
from .expand import FamilyExpander, free_names
from .indexed_ir import CELLS, NotKept, Slot
from .indices import Loop

Range = tuple[str, Affine, Affine]
MOVES = (*CELLS, "a", "input", "sum")  # kinds of symbols that initial values must not contain


@dataclass
class _Scope:
    """One level of nested loops. `ranges` has the ranges of the loop variables of this level, by
    name. `found` has the sums that are computed at this level."""

    ranges: dict[str, Range] = field(default_factory=dict)
    found: list[Summed] = field(default_factory=list)


class Once:
    """Collects the sums in one statement about the members lo..hi of a name, or about a scalar."""

    def __init__(self, x: FamilyExpander, lo: Affine | None, hi: Affine | None, loop: Loop):
        self.x = x
        self.limits: list[Limit] = []
        members = {n: (ROW, lo, hi) for n, at in loop.items() if at.factor(ROW)}
        self.scopes = [_Scope(), _Scope(members)]

    def of(self, expr: Sum, loop: Loop) -> Node:
        """Returns the node that stands for the value of a sum."""
        x, names = self.x, free_names(expr)
        depth = max((k for k, s in enumerate(self.scopes) if s.ranges.keys() & names), default=0)
        outer, self.scopes = self.scopes, self.scopes[: depth + 1]
        taken = sum(r[0] in COUNTERS for s in self.scopes for r in s.ranges.values())
        ranges, inside = {}, dict(loop)
        for number, item in enumerate(expr.ranges, taken):
            if number == len(COUNTERS):
                raise NotKept("sums within sums, too deep for loops")
            lo, hi = x.index(item.lo, inside), x.index(item.hi, inside)
            ranges[item.variable] = (COUNTERS[number], lo, hi)
            inside[item.variable] = variable(COUNTERS[number])
        own = _Scope(ranges)
        self.scopes.append(own)
        met, x.members = x.members, []
        node = x.scalar(expr.body, inside)
        over = [r for scope in reversed(self.scopes) for r in reversed(scope.ranges.values())]
        self.limits += x.limits_of(
            None, {name: (lo, hi) for name, lo, hi in over if lo is not None}
        )
        x.members, self.scopes = met, outer
        place = x.slots.node("place", f"once[{x.summed}]")
        made = Summed(x.summed, tuple(ranges.values()), node, tuple(own.found))
        self.scopes[depth].found.append(made)
        x.summed += 1
        return place

    @property
    def before(self) -> tuple[Summed, ...]:
        return tuple(self.scopes[0].found)

    @property
    def each(self) -> tuple[Summed, ...]:
        return tuple(self.scopes[1].found)


def assigned(
    x: FamilyExpander, name: str, order: int, over: tuple, expr, limits: list[Limit]
) -> tuple[Assigned, list[Node]]:
    """Returns the assignment of the expression `expr` to the members lo..hi of a name, and all
    nodes of this assignment. `over` is (lo, hi, map from the variables in indices to values)."""
    lo, hi, loop = over
    if lo is not None and lo == hi:  # a single member needs no loop
        loop = {name: lo if at == variable(ROW) else at for name, at in loop.items()}
    x.once = Once(x, lo, hi, loop)
    try:
        node = x.plain(expr, loop)
    finally:
        once, x.once = x.once, None
    limits += once.limits
    found = Assigned(name, order, lo, hi, node, once.before, once.each)
    return found, [node, *(s.node for x in (*once.before, *once.each) for s in within(x))]


def within(summed: Summed) -> Iterator[Summed]:
    """Yields a sum and all sums inside it."""
    yield summed
    for inner in summed.inside:
        yield from within(inner)


def moving(slots: list[Slot]) -> bool:
    return any(slot.kind in MOVES for slot in slots)
