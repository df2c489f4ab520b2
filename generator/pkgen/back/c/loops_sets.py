"""Rows and totals as blocks of code: one for the interior, and guarded parts near the ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from ...graph.affine import Affine
from ...graph.collect import fewest
from ...graph.graph import ONE, ZERO, Node
from ...middle.loops.indexed_ir import Group, PairForce, PairPart, Row, Total
from ...middle.loops.loops import LoopEquations
from ..targets import ADD, RETURN, STORE, Target
from .loops import EDGE, INNER, PAIR, Block, Places, flux_place
from .loops_interior import Interior


@dataclass
class Guarded:
    """Parts of rows that have the same condition. `block` adds them to r[k] if lo <= m <= hi."""

    lo: str
    hi: str
    block: Block


@dataclass
class Summing:
    """A sum that is computed once and stored: `place` is its C variable, `ranges` are the loop
    variables with first and last index, `block` is its term, `inside` are sums in the term."""

    place: str
    ranges: list[tuple[str, str, str]]
    block: Block
    inside: list[Summing]

    @property
    def blocks(self) -> list[Block]:
        return [self.block, *(block for x in self.inside for block in x.blocks)]


@dataclass
class Assignment:
    """An assignment to the members lo..hi of a family, or to a scalar if lo is "". The sums
    `before` are computed once, the sums `each` again for every member."""

    lo: str
    hi: str
    before: list[Summing]
    each: list[Summing]
    block: Block

    @property
    def blocks(self) -> list[Block]:
        return [self.block, *(block for x in (*self.before, *self.each) for block in x.blocks)]


@dataclass
class RowSet:
    """The rows of one family, with `outputs` values r[k] for each member m, or the terms of a
    total.

    In the interior m is at least each of `lows` and at most each of `highs`, which are C text.
    """

    name: str
    outputs: int
    inner: Block
    guarded: list[Guarded]
    lows: list[str]
    highs: list[str]
    group: dict = field(default_factory=dict)  # Template variables of the family.
    ghosts: bool = False  # whether rows of ghost cells are added to those of the members they copy
    below: int = 0  # Number of ghost cells below the range.
    above: int = 0  # Number of ghost cells above the range.
    plain: bool = False  # The mass r[1] is a positive number, so it needs no check.
    scale: Block | None = None  # factor by which r[0] is multiplied in the interior
    flux: Block | None = None  # computes the forces of a bond, flux[k * stride]
    span: int = 0  # A bond is between members m and m - span.

    @property
    def blocks(self) -> list[Block]:
        found = [self.inner, *(g.block for g in self.guarded), self.scale, self.flux]
        return [block for block in found if block is not None]

    @property
    def flux_trig(self) -> bool:
        return bool(self.flux and self.flux.trig)

    @property
    def trig(self) -> bool:
        return self.inner.trig or self.flux_trig

    @property
    def bonds(self) -> bool:
        """Returns whether all bond forces of a block of rows are computed before the rows."""
        return bool(self.flux) and not self.flux_trig

    @property
    def n_flux(self) -> int:
        return len(self.flux.targets) if self.flux else 0

    @property
    def firsts(self) -> list[str]:
        return list(dict.fromkeys(g.lo for g in self.guarded))

    @property
    def lasts(self) -> list[str]:
        return list(dict.fromkeys(g.hi for g in self.guarded))


@dataclass
class PairSet:
    """A double loop over pairs of members (m, j). The block computes values r[k]. For forces, `own`
    has for k the array element to which the sum of r[k] over j is added, and `other` the array
    element to which each r[k] is added, in C."""

    lo: str
    hi: str
    first: str
    last: str
    block: Block
    own: dict[int, str] = field(default_factory=dict)  # k -> array element
    other: dict[int, str] = field(default_factory=dict)


@dataclass
class TotalSet:
    """A total as a C function: a constant, loops over members, loops over pairs."""

    name: str
    constant: Block
    rows: RowSet | None
    pairs: list[PairSet]

    @property
    def blocks(self) -> list[Block]:
        rows = self.rows.blocks if self.rows else []
        return [*rows, *(pair.block for pair in self.pairs), self.constant]


class Builder:
    """Makes blocks from rows, pairs and totals; may add nodes to the graph."""

    def __init__(self, e: LoopEquations, places: Places):
        self.e, self.places = e, places
        self.interior = Interior(e)

    def rows(
        self, name: str, group: Group, rows: list[Row], quotient: bool = False, ghosts: bool = True
    ) -> RowSet:
        """Returns the RowSet of the given rows. With `quotient` there are two: a force and a mass;
        r[0] in the interior is then force / mass."""
        interior = self.interior
        nodes, lows, highs = interior.interior(rows, group)
        flux: list[Node] = []
        span, mass, scale = 0, ZERO, ONE
        if quotient:
            flux, span, total = interior.fluxes(rows[0])
            flux = [interior.factored(node) for node in flux]
            nodes[0] = interior.factored(total if flux else nodes[0])
            mass = nodes[1]
        if mass != ZERO:
            scale, nodes[0] = interior.scaled(interior.g.divide(nodes[0], mass))
        number = interior.g.value(mass)
        below, above = self._beyond(group)
        mapped = group.periodic or any(end.kind == "free" for _, end in group.ends)
        found = self._set(name, rows, nodes, lows, highs)  # A difference of neighbours is not
        found.group = self.places.group(group)  # expanded, since that would lose digits.
        found.below, found.above = below, above
        found.ghosts = ghosts and mapped and bool(below or above)
        found.plain = number is not None and number > 0
        found.span = span
        if scale != ONE:
            found.scale = Block.of(RETURN, "", [scale], INNER)
        if flux:
            targets = [Target(STORE, flux_place(k, 0), (node,)) for k, node in enumerate(flux)]
            found.flux = Block(targets, INNER)
        return found

    def _beyond(self, group: Group) -> tuple[int, int]:
        """Returns the number of ghost cells below the first member of a family, and the number
        above the last one."""
        below = above = self.e.wraps.get(group.name, 0)
        for at, _ in group.ends:
            low, high = group.lo - at, at - group.hi
            if low.is_constant and low.constant > 0:
                below = max(below, low.constant)
            elif high.is_constant:
                above = max(above, high.constant)
        return below, above

    def total(self, name: str, total: Total, as_derived: bool = False) -> TotalSet:
        rows = [Row(total.parts)]
        nodes, lows, highs = self.interior.interior(rows, None)
        nodes = nodes if as_derived else fewest(self.interior.g, nodes)
        found = self._set(name, rows, nodes, lows, highs) if total.parts else None
        pairs = [self._pair(p, Block.of(STORE, "r[0]", [p.node], PAIR)) for p in total.pairs]
        return TotalSet(name, Block.of(STORE, "total", [total.constant], INNER), found, pairs)

    def pair(self, force: PairForce) -> PairSet:
        sides = [*force.by_row, *force.by_other, *force.by_scalar]
        found = self._pair(force, Block.of(STORE, "r[{}]", [node for _, node in sides], PAIR))
        cells = ["cell"] * len(force.by_row) + ["other"] * len(force.by_other)
        cells += ["first"] * len(force.by_scalar)
        for k, ((name, _), cell) in enumerate(zip(sides, cells, strict=True)):
            places = found.other if cell == "other" else found.own
            places[k] = self.places.group(self.e.group(name))[cell]
        return found

    def _pair(self, over: PairForce | PairPart, block: Block) -> PairSet:
        return PairSet(*self._texts((over.lo, over.hi, over.first, over.last)), block)

    def _texts(self, indices: Iterable[Affine]) -> Iterator[str]:
        return map(self.places.index, indices)

    def _set(
        self, name: str, rows: list[Row], nodes: list[Node], lows: list[Affine], highs: list[Affine]
    ) -> RowSet:
        conditions: dict[tuple[Affine, Affine], list[Target]] = {}
        for k, row in enumerate(rows):
            for part in row.parts:
                targets = conditions.setdefault((part.lo, part.hi), [])
                targets.append(Target(ADD, f"r[{k}]", (part.node,)))
        return RowSet(
            name=name,
            outputs=len(rows),
            inner=Block.of(STORE, "r[{}]", nodes, INNER),
            guarded=[Guarded(*self._texts(over), Block(x, EDGE)) for over, x in conditions.items()],
            lows=list(self._texts(lows)),
            highs=list(self._texts(highs)),
        )
