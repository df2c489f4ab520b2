"""The interior of families: there a row (the equation of a member) is a single expression.

The force of a bond between two members is computed once for both.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...graph.affine import ROW, Affine, variable
from ...graph.collect import rewritten, settled
from ...graph.count import operations
from ...graph.graph import MINUS_ONE, ONE, ZERO, Node
from ...graph.normal import WORK
from ...graph.policies import linear
from ...middle.loops.indexed_ir import REACHED, Group, Part, Row
from ...middle.loops.loops import LoopEquations
from ...middle.loops.slots import Slots
from .loops import WIDEST_BOND

M = variable(ROW)


class Interior:
    """The rows of a model away from their families' ends. This adds nodes to the graph, so it is
    used before Lowering, which copies the graph."""

    def __init__(self, e: LoopEquations):
        self.e = e
        self.g = e.graph
        self.slots = Slots(self.g, e.slots)

    def fluxes(self, row: Row) -> tuple[list[Node], int, Node]:
        """Splits off the forces of bonds: row(m) = sum of F_k(m) - F_k(m - s), plus a remainder.

        The forces of a bond on its two members, m and m - s, are opposite (Newton's third law).
        Returns the F_k, the distance s, and the interior of the row as an expression in the F_k.
        """
        bulk = [part for part in row.parts if not part.is_point]
        found: list[Node] = []
        span = 0
        total = ZERO
        while bulk:
            part = bulk.pop(0)
            partner = next((b for b in bulk if self._opposite(part, b, span)), None)
            if partner is None:
                total = self.g.add(total, part.inner)
                continue
            bulk.remove(partner)
            near, far = (part, partner) if (partner.lo - part.lo).constant > 0 else (partner, part)
            span = (far.lo - near.lo).constant
            ends = [self.slots.node("flux", str(len(found)), M - k) for k in (0, span)]
            found.append(near.inner)
            total = self.g.add(total, self.g.subtract(*ends))
        return found, span, total

    def _opposite(self, a: Part, b: Part, span: int) -> bool:
        """Returns whether b(m) = -a(m - s) or a(m) = -b(m - s)."""
        distance = b.lo - a.lo
        if not distance.is_constant or b.hi - a.hi != distance or a.inner == ZERO:
            return False
        size = abs(distance.constant)
        if not 1 <= size <= WIDEST_BOND or (span and size != span):
            return False
        total = self.g.add(self.slots.shifted(a.inner, -distance.constant), b.inner)
        return total == ZERO or settled(self.g, [total])[0] == ZERO

    def interior(
        self, rows: Sequence[Row], group: Group | None
    ) -> tuple[list[Node], list[Affine], list[Affine]]:
        """Returns three lists: for each row its expression in the interior (the sum of its parts
        that apply there), then the lower and the upper bounds of the interior. The interior is the
        range of the index without special cases at the ends."""
        lows: list[Affine] = [] if group is None else [group.lo]
        highs: list[Affine] = [] if group is None else [group.hi]
        nodes = []
        for row in rows:
            bulk = []
            for part in row.parts:
                if group is not None and part.is_point:
                    self._exclude(part, group, lows, highs)
                    continue
                bulk.append(part.inner)
                lows.append(part.lo)
                highs.append(part.hi)
            nodes.append(self.g.sum(bulk))
        # `inner` leaves out the rates and accelerations of cells whose motion is prescribed. The
        # bounds that these need are found in the full parts.
        ends = [part.node for row in rows for part in row.parts if part.node != part.inner]
        for kinds, found in ((REACHED, nodes), (("d", "w"), [*nodes, *ends])):
            for slot in (slot for node in found for slot in self.slots.below(node)):
                if slot.kind in kinds and slot.at is not None:
                    other, shift = self.e.group(slot.name), slot.at.without(ROW)
                    if slot.at.factor(ROW):
                        lows.append(other.lo - shift)
                        highs.append(other.hi - shift)
        if group is not None:
            beyond = self.e.wraps.get(group.name, 0)
            beyond = max(beyond, int(any(end.kind == "free" for _, end in group.ends)))
            if beyond:
                lows.append(group.lo + beyond)
                highs.append(group.hi - beyond)
        return nodes, _pruned(lows, 1), _pruned(highs, -1)

    def _exclude(self, part: Part, group: Group, lows: list[Affine], highs: list[Affine]) -> None:
        if (part.hi - group.lo).is_constant:
            lows.append(part.hi + 1)
        else:
            highs.append(part.lo - 1)

    def factored(self, node: Node) -> Node:
        """Returns a node or, if shorter, its factored form: d (k + b d^2) for k d + b d^3."""
        found = rewritten(self.g, [node], linear, WORK) or [node]
        return min(node, found[0], key=lambda n: operations(self.g, [n]))

    def scaled(self, node: Node) -> tuple[Node, Node]:
        """Returns a node's constant factor, or 1 if it saves no operation, and the rest."""
        scale, rest = self.g.split(node)
        return (ONE, node) if scale in (ONE, MINUS_ONE) or rest == ONE else (scale, rest)


def _pruned(found: list[Affine], sign: int) -> list[Affine]:
    """Returns the lower bounds (sign 1) or upper bounds (sign -1) without those that another bound
    implies."""
    kept: list[Affine] = []
    for at in dict.fromkeys(found):
        if any((k - at).is_constant and (k - at).constant * sign >= 0 for k in kept):
            continue
        kept = [k for k in kept if not ((at - k).is_constant and (at - k).constant * sign >= 0)]
        kept.append(at)
    return kept
