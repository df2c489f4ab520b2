"""Expands the summands of an energy, here called bodies: in sum(f(i), i = lo..hi), the body is f.

A body is needed in two forms. One is the body at i = m. The other is needed for each member of a
family that occurs in the body, to add to the equation of motion of this member: the indices in the
body are shifted so that this member has the index m.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from ...graph.affine import ROW, Affine, extremes
from ...graph.graph import Node
from .expand import LoopExpander
from .indexed_ir import CELLS, REACHED, Group, PairForce, Part, Slot, Total, Unrolled
from .loops import Limit
from .pair_sums import M
from .terms import Term


class Gathered:
    """Contributions of L, the dissipation D and the forces to the equations of motion."""

    def __init__(self) -> None:
        # The contributions to a quantity, such as "momenta", of the members of a family. The keys
        # are (quantity, family).
        self.rows: dict[tuple[str, str], list[Part]] = defaultdict(list)
        # The contributions to a quantity of a scalar coordinate. The keys are (quantity, name).
        self.totals: dict[tuple[str, str], Total] = defaultdict(Total)
        # Entries of M; see Band.
        self.entries: dict[tuple[str, str, int], list[Part]] = defaultdict(list)
        self.border: dict[tuple[str, str], list[Part]] = defaultdict(list)
        self.corner: dict[tuple[str, str], Total] = defaultdict(Total)
        # The contributions to the equations of motion of double sums in L.
        self.pairs: list[PairForce] = []
        # The contributions to the equations of motion of double sums in D, and of generalized
        # forces that contain sums.
        self.drags: list[PairForce] = []
        self.limits: list[Limit] = []
        self.wraps: dict[str, int] = {}


class Bodies:
    """Expands bodies. Records the conditions (limits) on the sizes of the model, such as N in
    q[1..N], under which all members exist that occur in a body."""

    def __init__(self, x: LoopExpander, found: Gathered):
        self.x = x
        self.found = found

    def views(self, term: Term) -> Iterator[tuple[str, Affine, Node]]:
        """For each member of a family that occurs in a term's body, yields (family, offset, body).
        The indices in this body are shifted so that the member, which had the index m + offset, has
        the index m."""
        body = self.at_row(term)
        for names, at in self._moved(body):
            shift, seen = at, body
            if at is not None and term.ranges:
                shift = at - M
                seen = self.x.totals.throughout(term.at(self.x, M - shift))
            for name in names if at is not None else ():
                yield name, shift, seen
        self.x.members.clear()

    def _moved(self, body: Node) -> list[tuple[tuple[str, ...], Affine | None]]:
        """Returns the coordinates on which a body depends, as pairs (names, index of the member).
        There are several names if the body depends on a quaternion, which belongs to the three
        coordinates of a rotation."""
        slots = [slot for slot in self.x.slots.below(body) if slot.kind in CELLS]
        return list(dict.fromkeys((self.x.rotations.moved(slot), slot.at) for slot in slots))

    def at_row(self, term: Term) -> Node:
        """Returns the body of a term at i = m. Records the conditions on sizes under which its
        members exist."""
        values = (M,) if term.ranges else ()
        self.x.members.clear()
        body = term.at(self.x, *values)
        lo = hi = None
        if term.ranges:
            body = self.x.totals.throughout(body)
            (_, lo, hi) = term.ranges[0]
        self.found.limits += self.x.limits_over(lo, hi)
        for slot in self.x.slots.below(body):
            if term.ranges:
                self.member(slot, lo, hi)
        return body

    def member(self, slot: Slot, lo: Affine, hi: Affine) -> None:
        """Raises Unrolled if a member's index is not m plus a constant. Records the conditions on
        sizes under which the member exists for m = lo..hi."""
        if slot.kind in REACHED and slot.at is not None:
            self._relative(slot)
            self.in_reach(slot, lo, hi)

    def _relative(self, slot: Slot) -> None:
        if slot.at.factor(ROW) != 1 or not (slot.at - M).is_constant:
            reached = f"{slot.name}[{slot.at.text({ROW: 'i'})}]"
            raise Unrolled(f"a sum reaches {reached} from its index i")

    def in_reach(self, slot: Slot, lo: Affine | None, hi: Affine | None) -> None:
        """Records the conditions on the sizes of the model under which a member exists for all m =
        lo..hi, where the value of a member beyond a fixed end is given. For a periodic family,
        records instead how far the index goes beyond the ends."""
        if slot.kind not in REACHED or slot.at is None or lo is None:
            return
        group = self.x.coordinates[slot.name]
        first, last = extremes(slot.at, {ROW: (lo, hi)})
        below, above = first - group.lo, group.hi - last
        if group.periodic:
            for beyond in (-below, -above):
                if beyond.is_constant:
                    for name in (slot.name, *self.x.rotations.moved(slot)):
                        known = self.found.wraps.get(name, 0)
                        self.found.wraps[name] = max(known, beyond.constant)
                else:
                    self.found.limits.append(Limit(-beyond, hi - lo))
            return
        self.found.limits.append(Limit(below + _given(group, -1), hi - lo))
        self.found.limits.append(Limit(above + _given(group, 1), hi - lo))

    def scalars(self, body: Node) -> list[str]:
        return [name for names, at in self._moved(body) if at is None for name in names]


def _given(group: Group, side: int) -> int:
    """Returns the number of consecutive indices beyond the lower (side -1) or upper end of a family
    for which the model gives values."""
    at = {index for index, _ in group.ends}
    count = 0
    while (group.lo - (count + 1) if side < 0 else group.hi + (count + 1)) in at:
        count += 1
    return count
