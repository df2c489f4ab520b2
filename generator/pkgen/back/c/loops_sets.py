"""Rows and totals as sets of blocks: a body for the interior, guarded parts for the ends."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ...graph.affine import Affine
from ...graph.graph import ONE, ZERO, Node
from ...middle.loops.loops import Group, LoopEquations, PairForce, PairPart, Row, Total
from ..targets import ADD, RETURN, STORE, Target
from .loops import EDGE, INNER, PAIR, Block, Lowering, flux_place
from .loops_interior import Interior


@dataclass
class Guarded:
    """Parts of a row that share a condition: r[k] += ... where lo <= m <= hi."""

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
    scale: Block | None = None  # of the interior's r[0], the same in every row
    below: int = 0  # ghosts on each side
    above: int = 0


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
        self.sets = Interior(e)
        self.lowering: Lowering | None = None

    # Two passes: `plan` grows the graph, `begin` freezes it, the rest registers blocks.

    def plan_rows(self, name: str, group: Group, rows: list[Row], quotient: bool = False) -> dict:
        nodes, lows, highs = self.sets.interior(rows, group)
        flux: list[Node] = []
        span = 0
        if quotient:
            flux, span, total = self.sets.fluxes(rows[0])
            flux = [self.sets.factored(node) for node in flux]
            nodes[0] = self.sets.factored(total if flux else nodes[0])
        mass = nodes[1] if quotient else ZERO
        scale = ONE
        if mass != ZERO:
            scale, nodes[0] = self.sets.scaled(self.sets.g.divide(nodes[0], mass))
        number = self.sets.g.value(mass)
        return {
            "name": name,
            "group": group,
            "rows": rows,
            "nodes": nodes,  # as derived: expanded, differences of neighbours would lose digits
            "lows": lows,
            "highs": highs,
            "plain": number is not None and number > 0,
            "scale": scale,
            "flux": flux,
            "span": span,
        }

    def plan_total(self, name: str, total: Total, as_derived: bool = False) -> dict:
        parts = [Row(total.parts)]
        nodes, lows, highs = self.sets.interior(parts, None)
        return {
            "name": name,
            "total": total,
            "rows": parts,
            "nodes": nodes if as_derived else self.sets.shortest(nodes),
            "lows": lows,
            "highs": highs,
        }

    def begin(self, libm: bool) -> None:
        self.e = replace(self.e, slots=tuple(self.sets.slots.all))
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
            scale=self._scale(plan["scale"]),
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
            (pair, self._block([Target(STORE, "r[0]", (pair.node,))], PAIR)) for pair in total.pairs
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
        targets = [Target(STORE, flux_place(k, 0), (node,)) for k, node in enumerate(plan["flux"])]
        return self._block(targets, INNER) if targets else None

    def _scale(self, node: Node) -> Block | None:
        return None if node == ONE else self._block([Target(RETURN, "", (node,))], INNER)

    def _guarded(self, rows: list[Row]) -> list[Guarded]:
        conditions: dict[tuple[Affine, Affine], list[Target]] = {}
        for k, row in enumerate(rows):
            for part in row.parts:
                targets = conditions.setdefault((part.lo, part.hi), [])
                targets.append(Target(ADD, f"r[{k}]", (part.node,)))
        return [
            Guarded(lo, hi, self._block(targets, EDGE)) for (lo, hi), targets in conditions.items()
        ]
