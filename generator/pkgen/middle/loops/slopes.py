"""Derivatives of the momenta and of p' by coordinates and rates, as rows: a band with a border.

Where forces of constraints or rates of states are in p', or the equations are solved for a (see
`solved` of LoopEquations), these derivatives are dense. a, with those rates, and the multipliers
lambda are unknowns too then, with equations of their own, whose derivatives are a band again:

    M a - f - J^T lambda = 0,   (J v + j0)' = J a + what is there at a = 0 = 0

So is each total that members feel, S - sum over members = 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ...graph.graph import ONE, ZERO, Node
from ...record import record
from .facts import total_nodes, vector_nodes
from .loops import LoopEquations
from .matrices import (
    BY_MORE,
    BY_PLACE,
    BY_RATE,
    BY_TOTALS,
    Derive,
    K,
    M,
    Matrix,
    Stated,
    Unknown,
    seen_from,
)
from .parts import Band, Bound, Group, Part, Row, Total, Unrolled, Vector
from .slots import Slots

DENSE = "a sum over all members makes the derivatives dense"


@record
class Slopes:
    families: tuple[tuple[Unknown, Group], ...]  # unknowns with a value for each index
    scalars: tuple[Unknown, ...]
    mass: Matrix
    closed: Matrix | None  # M, and what a and lambda are: where these are unknowns
    p_q: Matrix
    pdot_q: Matrix
    pdot_v: Matrix
    pull: dict[str, Row | Total] | None  # the forces of constraints, where p' has them

    @property
    def answered(self) -> bool:
        """Whether a and lambda are among the unknowns."""
        unknowns = [*(unknown for unknown, _ in self.families), *self.scalars]
        return any(kind in ("a", "lambda") for kind, _ in unknowns)

    @property
    def all(self) -> tuple[Matrix, ...]:
        closed = (self.closed,) if self.closed else ()
        return self.mass, *closed, self.p_q, self.pdot_q, self.pdot_v


def slopes_of(e: LoopEquations, slots: Slots) -> Slopes:
    """Raises Unrolled where a row reaches members at no fixed distance."""
    vectors = (e.momenta, e.pdot, e.force)
    nodes = [node for vector in vectors for node in vector_nodes(vector)]
    nodes += [part.node for row in e.mass.entries.values() for part in row.parts]
    totals = _totals(e, slots, nodes)
    nodes += [node for k in totals for node in total_nodes([e.sums[k]])]
    derive = Derive(slots, e.fixed)
    families = [(("v", g.name), g) for g in e.families]
    scalars = [("v", g.name) for g in e.scalars]
    used = {s.name for s in slots.below(*nodes) if s.kind == "a"}  # states whose rates others have
    if not (e.bound or e.solved or used or totals):
        p, pdot = _of_vector(e.momenta, "v"), _of_vector(e.pdot, "v")
        found = [derive.matrix(p, BY_PLACE), *map(derive.by(pdot), (BY_PLACE, BY_RATE))]
        return Slopes(tuple(families), tuple(scalars), _symmetric(e.mass), None, *found, None)
    answered = bool(e.bound or e.solved or used)  # a and lambda are unknowns
    if answered:
        families += [(("a", g.name), g) for g in e.families if not g.is_state or g.name in used]
        families += [(("lambda", x.group.name), x.group) for x in e.bound if not x.is_single]
        scalars += [("a", g.name) for g in e.scalars if not g.is_state or g.name in used]
        scalars += [("lambda", x.group.name) for x in e.bound if x.is_single]
    scalars += [("sum", str(k)) for k in totals]
    motion = _Motion(e, slots, used)
    pull = motion.pull()
    own = Stated({}, motion.total_rows(totals))
    if answered:
        rows = motion.balance(pull) | motion.constraint_rows()
        own = Stated(rows, motion.balances(pull) | motion.single_rows() | own.totals)
    if e.solved:
        mass, p_q = motion.unit(), _nothing()
        pdot = motion.accelerations()
    else:
        mass, p_q = _symmetric(e.mass), derive.matrix(_of_vector(e.momenta, "v"), BY_PLACE)
        pdot = motion.with_pull(_of_vector(e.pdot, "v"), pull)
    closed = mass | derive.matrix(own, BY_RATE) | derive.matrix(own, BY_MORE)
    if totals and not e.solved:
        closed = closed | derive.matrix(_of_vector(e.momenta, "v"), BY_TOTALS)
    return Slopes(
        tuple(families),
        tuple(scalars),
        mass,
        closed,
        p_q | derive.matrix(own, BY_PLACE),
        derive.matrix(pdot, BY_PLACE),
        derive.matrix(pdot, BY_RATE) | derive.matrix(pdot, BY_MORE),
        None
        if e.solved or not e.bound
        else {name: x for (_, name), x in (pull.rows | pull.totals).items()},
    )


def _totals(e: LoopEquations, slots: Slots, nodes: Iterable[Node]) -> list[int]:
    """The totals below some nodes that change along a motion."""
    found: set[int] = set()
    while nodes:
        below = {int(slot.name) for slot in slots.below(*nodes) if slot.kind == "sum"}
        new = below - found - e.fixed
        found |= new
        nodes = total_nodes([e.sums[k] for k in new])
    return sorted(found)


def _of_vector(vector: Vector, kind: str) -> Stated:
    if vector.pairs or any(total.pairs for total in vector.totals.values()):
        raise Unrolled(DENSE)
    return Stated(
        {(kind, name): row for name, row in vector.rows.items()},
        {(kind, name): total for name, total in vector.totals.items()},
    )


def _symmetric(mass: Band) -> Matrix:
    def of(*names: str) -> tuple[Unknown, ...]:
        return tuple(("v", name) for name in names)

    return Matrix(
        {(*of(own, other), shift): row for (own, other, shift), row in mass.entries.items()},
        {of(family, scalar): row for (scalar, family), row in mass.border.items()},
        {of(*key): row for key, row in mass.border.items()},
        {of(*key): total for key, total in mass.corner.items()},
    )


def _nothing() -> Matrix:
    return Matrix({}, {}, {}, {})


class _Motion:
    """What a and lambda are: equations in which they stand as slots."""

    def __init__(self, e: LoopEquations, slots: Slots, used: set[str]):
        self.e, self.slots, self.g, self.used = e, slots, slots.graph, used

    def a(self, name: str, shift: int | None = None) -> Node:
        return self.slots.node("a", name, None if shift is None else M + shift)

    def force(self, rows: Bound, shift: int = 0) -> Node:
        """The multiplier of the row so far away."""
        at = None if rows.is_single else M + shift
        return self.slots.node("lambda", rows.group.name, at)

    def times(self, row: Row, factor: Node) -> tuple[Part, ...]:
        def product(node: Node | None) -> Node:
            return self.g.multiply(ZERO if node is None else node, factor)

        return tuple(
            Part(part.lo, part.hi, product(part.node), product(part.inner)) for part in row.parts
        )

    def total_times(self, total: Total, factor: Node) -> Total:
        _no_pairs(total)
        return Total(self.g.multiply(total.constant, factor), self.times(Row(total.parts), factor))

    def sum(self, totals: Iterable[Total]) -> Total:
        totals = list(totals)
        for total in totals:
            _no_pairs(total)
        constant = self.g.sum([total.constant for total in totals])
        return Total(constant, tuple(part for total in totals for part in total.parts))

    def minus(self, x: K) -> K:
        scaled = self.times(Row(x.parts), self.g.number(-1))
        if isinstance(x, Row):
            return Row(scaled)
        _no_pairs(x)
        return Total(self.g.negate(x.constant), scaled)

    def pull(self) -> Stated:
        """J^T lambda."""
        rows: dict[Unknown, list[Part]] = {("v", g.name): [] for g in self.e.families}
        totals: dict[Unknown, list[Total]] = {("v", g.name): [] for g in self.e.scalars}
        for bound in self.e.bound:
            for (name, shift), row in bound.entries.items():
                parts = self.times(row, self.force(bound))
                if shift is None:
                    totals["v", name].append(Total(ZERO, parts))
                else:
                    rows["v", name] += [seen_from(self.slots, part, shift) for part in parts]
            for name, row in bound.border.items():
                rows["v", name] += self.times(row, self.force(bound))
            for name, total in bound.corner.items():
                totals["v", name].append(self.total_times(total, self.force(bound)))
        return Stated(
            {key: Row(tuple(parts)) for key, parts in rows.items()},
            {key: self.sum(found) for key, found in totals.items()},
        )

    def with_pull(self, pdot: Stated, pull: Stated) -> Stated:
        return Stated(
            {key: Row((*row.parts, *pull.rows[key].parts)) for key, row in pdot.rows.items()},
            {key: self.sum([x, pull.totals[key]]) for key, x in pdot.totals.items()},
        )

    def balance(self, pull: Stated) -> dict[Unknown, Row]:
        """M a - f - J^T lambda, of families."""
        force, found = _of_vector(self.e.force, "v"), {}
        for g in (g for g in self.e.families if not g.is_state or g.name in self.used):
            parts = [
                *self.minus(force.rows["v", g.name]).parts,
                *self.minus(pull.rows["v", g.name]).parts,
            ]
            for (own, other, shift), row in self.e.mass.entries.items():
                parts += self.times(row, self.a(other, shift)) if own == g.name else ()
            for (scalar, own), row in self.e.mass.border.items():
                parts += self.times(row, self.a(scalar)) if own == g.name else ()
            found["a", g.name] = Row(tuple(parts))
        return found

    def balances(self, pull: Stated) -> dict[Unknown, Total]:
        """The same of scalar coordinates."""
        force, found = _of_vector(self.e.force, "v"), {}
        for g in (g for g in self.e.scalars if not g.is_state or g.name in self.used):
            totals = [self.minus(force.totals["v", g.name]), self.minus(pull.totals["v", g.name])]
            for (scalar, family), row in self.e.mass.border.items():
                if scalar == g.name:
                    totals.append(Total(ZERO, self.times(row, self.a(family, 0))))
            for (own, other), total in self.e.mass.corner.items():
                if own == g.name:
                    totals.append(self.total_times(total, self.a(other)))
            found["a", g.name] = self.sum(totals)
        return found

    def constraint_rows(self) -> dict[Unknown, Row]:
        found = {}
        for bound in self.e.bound:
            if bound.is_single:
                continue
            parts = [*bound.coasting.parts]
            for (name, shift), row in bound.entries.items():
                parts += self.times(row, self.a(name, shift))
            found["lambda", bound.group.name] = Row(tuple(parts))
        return found

    def single_rows(self) -> dict[Unknown, Total]:
        found = {}
        for bound in self.e.bound:
            if bound.is_single:
                of = [Total(ZERO, self.times(x, self.a(n, 0))) for n, x in bound.border.items()]
                of += [self.total_times(x, self.a(n)) for n, x in bound.corner.items()]
                found["lambda", bound.group.name] = self.sum([bound.coasting, *of])
        return found

    def total_rows(self, totals: Iterable[int]) -> dict[Unknown, Total]:
        """What a total is, less what it sums up."""
        found = {}
        for k in totals:
            own, minus = self.slots.node("sum", str(k)), self.minus(self.e.sums[k])
            constant = self.g.add(own, minus.constant)
            found["sum", str(k)] = replace(minus, constant=constant)
        return found

    def accelerations(self) -> Stated:
        """p' where p is v."""
        own = _of_vector(self.e.force, "v")
        for g in (g for g in self.e.coordinates if not g.is_state):
            if g.is_family:
                a = self.a(g.name, 0)
                own.rows["v", g.name] = Row((Part(g.lo, g.hi, a, a),))
            else:
                own.totals["v", g.name] = Total(self.a(g.name))
        return own

    def unit(self) -> Matrix:
        return replace(
            _nothing(),
            entries={
                (("v", g.name), ("v", g.name), 0): Row((Part(g.lo, g.hi, ONE, ONE),))
                for g in self.e.families
            },
            corner={(("v", g.name), ("v", g.name)): Total(ONE) for g in self.e.scalars},
        )


def _no_pairs(total: Total) -> None:
    if total.pairs:
        raise Unrolled(DENSE)
