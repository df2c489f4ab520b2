"""The bodies of terms at i = m, and relative to the rows of the members in them."""

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
    """The sums of contributions of L, D and forces, by family and by scalar coordinate."""

    def __init__(self) -> None:
        self.rows: dict[tuple[str, str], list[Part]] = defaultdict(list)  # by quantity and family
        self.totals: dict[tuple[str, str], Total] = defaultdict(Total)  # by quantity and scalar
        self.entries: dict[tuple[str, str, int], list[Part]] = defaultdict(list)
        self.border: dict[tuple[str, str], list[Part]] = defaultdict(list)
        self.corner: dict[tuple[str, str], Total] = defaultdict(Total)
        self.pairs: list[PairForce] = []  # of L
        self.drags: list[PairForce] = []  # of D
        self.limits: list[Limit] = []
        self.wraps: dict[str, int] = {}


class Bodies:
    """Expands bodies, and adds the limits on sizes under which all their members exist."""

    def __init__(self, x: LoopExpander, found: Gathered):
        self.x = x
        self.found = found

    def views(self, term: Term) -> Iterator[tuple[str, Affine, Node]]:
        """Yields (family, offset, body) for each family slot, the body relative to its row."""
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
        """Returns the coordinates, each with a member's index, that a body depends on."""
        slots = [slot for slot in self.x.slots.below(body) if slot.kind in CELLS]
        return list(dict.fromkeys((self.x.rotations.moved(slot), slot.at) for slot in slots))

    def at_row(self, term: Term) -> Node:
        """Returns the body at i = m. Checks that its members exist, and adds limits on sizes."""
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
        """Checks that a member is at a fixed distance from its row, and exists for rows lo..hi."""
        if slot.kind in REACHED and slot.at is not None:
            self._relative(slot)
            self.in_reach(slot, lo, hi)

    def _relative(self, slot: Slot) -> None:
        if slot.at.factor(ROW) != 1 or not (slot.at - M).is_constant:
            reached = f"{slot.name}[{slot.at.text({ROW: 'i'})}]"
            raise Unrolled(f"a sum reaches {reached} from its index i")

    def in_reach(self, slot: Slot, lo: Affine | None, hi: Affine | None) -> None:
        """Adds limits for a member, or a given one beyond an end, to exist; records wraps."""
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
    """Returns the number of given cells beyond an end, counted without a gap."""
    at = {index for index, _ in group.ends}
    count = 0
    while (group.lo - (count + 1) if side < 0 else group.hi + (count + 1)) in at:
        count += 1
    return count
