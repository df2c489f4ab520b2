"""Rows and totals as sets of blocks: a body for the interior, guarded parts for the ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from ..middle.affine import LOOPS, ROW, Affine, variable
from ..middle.collect import fewest, settled
from ..middle.differentiate import reachable
from ..middle.graph import ZERO, Kind, Node, Op, Symbol
from ..middle.loops import Group, LoopEquations, PairForce, PairPart, Part, Row, Slot, Total
from ..middle.loops_expand import domain
from ..middle.loops_rows import substitute
from .loops import EDGE, INNER, PAIR, WIDEST_BOND, Block, Lowering, flux_place
from .program import STORE
from .schedule import Target

M = variable(ROW)

@dataclass
class Guarded:
    """Parts of a row that share a guard: r[k] += ... where lo <= m <= hi."""

    lo: Affine
    hi: Affine
    block: Block


@dataclass
class RowSet:
    """Some quantities of one family's cells, or terms of totals (group is None).

    Over [first, last] the interior is where m >= each of `lows` and <= each of `highs`.
    """

    name: str
    group: Group | None
    outputs: int
    inner: Block | None
    guarded: list[Guarded]
    first: Affine
    last: Affine
    lows: list[Affine]
    highs: list[Affine]
    ghosts: bool = False  # rows of ghosts are added to those of the cells they stand for
    flux: Block | None = None  # forces of bonds, into flux[k * stride], before the rows
    n_flux: int = 0
    span: int = 0  # a bond's ends are so far apart
    plain: bool = False  # r[1], a mass, is a positive number: no test
    below: int = 0  # ghosts on each side
    above: int = 0


class Sets:
    """Makes row sets; the graph may still grow, so before the Workspace of Lowering is used."""

    def __init__(self, e: LoopEquations):
        self.e = e
        self.g = e.graph
        self.slots = list(e.slots)
        self._symbols = {slot: k for k, slot in enumerate(self.slots)}

    def symbol(self, slot: Slot) -> Node:
        if slot not in self._symbols:
            self._symbols[slot] = len(self.slots)
            self.slots.append(slot)
        return self.g.symbol(Symbol(domain(slot), self._symbols[slot]))

    def shifted(self, node: Node, shift: int) -> Node:
        """The same expression in the row m + shift."""
        values = {}
        for n in reachable(self.g, [node]):
            data = self.g.data[n]
            if self.g.op[n] is not Op.SYMBOL or data.kind in (Kind.PI, Kind.TIME):
                continue
            slot = self.slots[data.index]
            if slot.kind == "index" and slot.name == ROW:
                values[n] = self.g.add(n, self.g.number(shift))
            elif slot.at is not None and slot.at.factor(ROW):
                at = slot.at + shift * slot.at.factor(ROW)
                values[n] = self.symbol(Slot(slot.kind, slot.name, at))
        return substitute(self.g, node, values)

    def fluxes(self, row: Row) -> tuple[list[Node], int, Node]:
        """Forces of bonds, each once: row(m) = sum of F_k(m) - F_k(m - s), and the rest.

        The bodies of a term seen from its two ends are opposite, the third law. Returns the F_k,
        the distance s that they have in common, and the interior of the row in terms of them.
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
            ends = [self.symbol(Slot("flux", str(len(found)), M - k)) for k in (0, span)]
            found.append(near.inner)
            total = self.g.add(total, self.g.subtract(*ends))
        return found, span, total

    def _opposite(self, a: Part, b: Part, span: int) -> bool:
        """Whether b(m) = -a(m - s), or the other way round."""
        distance = b.lo - a.lo
        if not distance.is_constant or b.hi - a.hi != distance or a.inner == ZERO:
            return False
        size = abs(distance.constant)
        if not 1 <= size <= WIDEST_BOND or (span and size != span):
            return False
        total = self.g.add(self.shifted(a.inner, -distance.constant), b.inner)
        return total == ZERO or settled(self.g, [total])[0] == ZERO

    def interior(
        self, rows: Sequence[Row], group: Group | None, least: Affine | None = None
    ) -> tuple[list[Node], list[Affine], list[Affine]]:
        """The sums of the parts of each row where every guard holds, and where that is."""
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
        for node in nodes:
            for slot in self._slots(node):
                if slot.kind in ("q", "v", "d", "w") and slot.at is not None:
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

    def _slots(self, node: Node):
        for n in reachable(self.g, [node]):
            data = self.g.data[n]
            if self.g.op[n] is Op.SYMBOL and data.kind.name not in ("PI", "TIME"):
                yield self.slots[data.index]

    def shortest(self, nodes: list[Node]) -> list[Node]:
        """The same with fewer operations, where that is found quickly."""
        return fewest(self.g, nodes) if nodes else nodes


def _pruned(found: list[Affine], sign: int) -> list[Affine]:
    """Of lower bounds (sign 1) or upper ones, those that no other implies."""
    kept: list[Affine] = []
    for at in dict.fromkeys(found):
        if any((k - at).is_constant and (k - at).constant * sign >= 0 for k in kept):
            continue
        kept = [
            k for k in kept if not ((at - k).is_constant and (at - k).constant * sign >= 0)
        ]
        kept.append(at)
    return kept


@dataclass
class TotalSet:
    """A total as a function: a constant block, loops, pair loops."""

    name: str
    constant: Block
    rows: RowSet | None
    pairs: list[tuple[PairPart, Block]] = field(default_factory=list)


@dataclass
class PairSet:
    """The double loop of a pair force: blocks that add to the accumulators of both ends."""

    force: PairForce
    block: Block


class Builder:
    """From vectors and totals to sets, once nodes are final: registers blocks."""

    def __init__(self, e: LoopEquations):
        self.e = e
        self.sets = Sets(e)
        self._planned: list = []
        self.lowering: Lowering | None = None

    # Two passes: `plan` grows the graph, `begin` freezes it, the rest registers blocks.

    def plan_rows(self, name: str, group: Group, rows: list[Row], quotient: bool = False) -> dict:
        nodes, lows, highs = self.sets.interior(rows, group)
        flux: list[Node] = []
        span = 0
        if quotient:
            flux, span, total = self.sets.fluxes(rows[0])
            nodes[0] = total if flux else nodes[0]
        mass = nodes[1] if quotient else ZERO
        if mass != ZERO:
            nodes[0] = self.sets.g.divide(nodes[0], mass)
        number = self.sets.g.value(mass)
        return {
            "name": name,
            "group": group,
            "rows": rows,
            "nodes": self.sets.shortest(nodes),
            "lows": lows,
            "highs": highs,
            "plain": number is not None and number > 0,
            "flux": self.sets.shortest(flux),
            "span": span,
        }

    def plan_total(self, name: str, total: Total) -> dict:
        parts = [Row(total.parts)]
        nodes, lows, highs = self.sets.interior(parts, None)
        return {
            "name": name,
            "total": total,
            "rows": parts,
            "nodes": self.sets.shortest(nodes),
            "lows": lows,
            "highs": highs,
        }

    def begin(self, libm: bool) -> None:
        self.e = replace(self.e, slots=tuple(self.sets.slots))
        self.lowering = Lowering(self.e, libm)

    def rows(self, plan: dict, ghosts: bool = True) -> RowSet:
        group = plan["group"]
        e = self.e
        below = above = e.wraps.get(group.name, 0)
        for at, _ in group.ends:
            low, high = group.lo - at, at - group.hi
            if low.is_constant and low.constant > 0:
                below = max(below, low.constant)
            elif high.is_constant:
                above = max(above, high.constant)
        mapped = group.periodic or any(end.kind == "free" for _, end in group.ends)
        return RowSet(
            name=plan["name"],
            group=group,
            outputs=len(plan["rows"]),
            inner=self._inner(plan["nodes"]),
            guarded=self._guarded(plan["rows"]),
            first=group.lo,
            last=group.hi,
            lows=plan["lows"],
            highs=plan["highs"],
            ghosts=ghosts and mapped and bool(below or above),
            below=below,
            above=above,
            plain=plan["plain"],
            flux=self._flux(plan),
            n_flux=len(plan["flux"]),
            span=plan["span"],
        )

    def total(self, plan: dict) -> TotalSet:
        total: Total = plan["total"]
        rows = None
        if total.parts:
            rows = RowSet(
                name=plan["name"],
                group=None,
                outputs=1,
                inner=self._inner(plan["nodes"]),
                guarded=self._guarded(plan["rows"]),
                first=Affine(),
                last=Affine(),
                lows=plan["lows"],
                highs=plan["highs"],
            )
        pairs = [
            (pair, self._block([Target(STORE, "r[0]", (pair.node,))], PAIR))
            for pair in total.pairs
        ]
        constant = self._block([Target(STORE, "total", (total.constant,))], INNER)
        return TotalSet(plan["name"], constant, rows, pairs)

    def pair(self, force: PairForce) -> PairSet:
        sides = [*force.by_row, *force.by_other, *force.by_scalar]
        targets = [Target(STORE, f"r[{k}]", (node,)) for k, (_, node) in enumerate(sides)]
        return PairSet(force, self._block(targets, PAIR))

    def _block(self, targets: list[Target], where: str) -> Block:
        assert self.lowering is not None
        return self.lowering.block(targets, where)

    def _inner(self, nodes: list[Node]) -> Block:
        return self._block(
            [Target(STORE, f"r[{k}]", (node,)) for k, node in enumerate(nodes)], INNER
        )

    def _flux(self, plan: dict) -> Block | None:
        targets = [
            Target(STORE, flux_place(k, 0), (node,))
            for k, node in enumerate(plan["flux"])
        ]
        return self._block(targets, INNER) if targets else None

    def _guarded(self, rows: list[Row]) -> list[Guarded]:
        guards: dict[tuple[Affine, Affine], list[Target]] = {}
        for k, row in enumerate(rows):
            for part in row.parts:
                targets = guards.setdefault((part.lo, part.hi), [])
                targets.append(Target("add", f"r[{k}]", (part.node,)))
        return [
            Guarded(lo, hi, self._block(targets, EDGE)) for (lo, hi), targets in guards.items()
        ]


__all__ = ["LOOPS", "Builder", "PairSet", "RowSet", "Sets", "TotalSet"]
