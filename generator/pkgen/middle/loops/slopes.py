"""Derivatives of the momenta and of p' by coordinates and rates, as rows: a band with a border.

Where forces of constraints are in p', or the equations are solved for a (see `solved` of
LoopEquations), these derivatives are dense. a and the multipliers lambda are unknowns too then,
with equations of their own, whose derivatives are a band again:

    M a - f - J^T lambda = 0,   (J v + j0)' = J a + what is there at a = 0 = 0
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TypeVar

from ...graph.affine import ROW, Affine, variable
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ONE, ZERO, Kind, Node
from ...record import record
from .loops import LoopEquations
from .parts import Band, Bound, Group, Part, Row, Total, Unrolled, Vector
from .slots import Slots

M = variable(ROW)
Unknown = tuple[str, str]  # "v", "a" or "lambda", and of which family or scalar
BY_PLACE, BY_RATE = ("q",), ("v", "s", "d")  # slots; "d" is the rate of a cell that is not given
BY_MORE = ("a", "lambda")
_OF = {**dict.fromkeys((*BY_PLACE, *BY_RATE), "v"), **{kind: kind for kind in BY_MORE}}
_MASKS = {
    BY_PLACE: BIT[Kind.COORDINATE],
    BY_RATE: BIT[Kind.RATE] | BIT[Kind.STATE],
    BY_MORE: BIT[Kind.INPUT],
}
_By = dict[tuple[Unknown, Affine | None], Node]
K = TypeVar("K")


@record
class Matrix:
    """Entry (family, other, d) of `entries` is of cell m of one by m + d of the other; `right` is
    of a family's cell m by a scalar, `bottom` of a scalar by a family's cell m."""

    entries: dict[tuple[Unknown, Unknown, int], Row]
    right: dict[tuple[Unknown, Unknown], Row]
    bottom: dict[tuple[Unknown, Unknown], Row]
    corner: dict[tuple[Unknown, Unknown], Total]

    def __or__(self, other: Matrix) -> Matrix:
        """With the entries of another one, which are elsewhere."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Matrix(*(one | more for one, more in pairs))


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
    def all(self) -> tuple[Matrix, ...]:
        closed = (self.closed,) if self.closed else ()
        return self.mass, *closed, self.p_q, self.pdot_q, self.pdot_v


@record
class _Equations:
    """Quantities with a row for each index, and single ones."""

    rows: dict[Unknown, Row]
    totals: dict[Unknown, Total]


def slopes_of(e: LoopEquations, slots: Slots) -> Slopes:
    """Raises Unrolled where a row reaches members at no fixed distance."""
    derive = _Derive(slots)
    families = [(("v", g.name), g) for g in e.families]
    scalars = [("v", g.name) for g in e.scalars]
    if not (e.bound or e.solved):
        p, pdot = _of_vector(e.momenta, "v"), _of_vector(e.pdot, "v")
        found = [derive.matrix(p, BY_PLACE), *map(derive.by(pdot), (BY_PLACE, BY_RATE))]
        return Slopes(tuple(families), tuple(scalars), _symmetric(e.mass), None, *found, None)
    families += [(("a", g.name), g) for g in e.families if not g.is_state]
    families += [(("lambda", x.group.name), x.group) for x in e.bound if not x.is_single]
    scalars += [("a", g.name) for g in e.scalars if not g.is_state]
    scalars += [("lambda", x.group.name) for x in e.bound if x.is_single]
    motion = _Motion(e, slots)
    pull = motion.pull()
    own = _Equations(
        motion.balance(pull) | motion.constraint_rows(),
        motion.balances(pull) | motion.single_rows(),
    )
    if e.solved:
        mass, p_q = motion.unit(), _nothing()
        pdot = motion.accelerations()
    else:
        mass, p_q = _symmetric(e.mass), derive.matrix(_of_vector(e.momenta, "v"), BY_PLACE)
        pdot = motion.with_pull(_of_vector(e.pdot, "v"), pull)
    closed = mass | derive.matrix(own, BY_RATE) | derive.matrix(own, BY_MORE)
    return Slopes(
        tuple(families),
        tuple(scalars),
        mass,
        closed,
        p_q | derive.matrix(own, BY_PLACE),
        derive.matrix(pdot, BY_PLACE),
        derive.matrix(pdot, BY_RATE) | derive.matrix(pdot, BY_MORE),
        None if e.solved else {name: x for (_, name), x in (pull.rows | pull.totals).items()},
    )


def _of_vector(vector: Vector, kind: str) -> _Equations:
    if vector.pairs or any(total.pairs for total in vector.totals.values()):
        raise Unrolled("a sum over all members makes the derivatives dense")
    return _Equations(
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

    def __init__(self, e: LoopEquations, slots: Slots):
        self.e, self.slots, self.g = e, slots, slots.graph

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

    def pull(self) -> _Equations:
        """J^T lambda."""
        rows: dict[Unknown, list[Part]] = {("v", g.name): [] for g in self.e.families}
        totals: dict[Unknown, list[Total]] = {("v", g.name): [] for g in self.e.scalars}
        for bound in self.e.bound:
            for (name, shift), row in bound.entries.items():
                parts = self.times(row, self.force(bound))
                if shift is None:
                    totals["v", name].append(Total(ZERO, parts))
                else:
                    rows["v", name] += [_seen_from(self.slots, part, shift) for part in parts]
            for name, row in bound.border.items():
                rows["v", name] += self.times(row, self.force(bound))
            for name, total in bound.corner.items():
                totals["v", name].append(self.total_times(total, self.force(bound)))
        return _Equations(
            {key: Row(tuple(parts)) for key, parts in rows.items()},
            {key: self.sum(found) for key, found in totals.items()},
        )

    def with_pull(self, pdot: _Equations, pull: _Equations) -> _Equations:
        return _Equations(
            {key: Row((*row.parts, *pull.rows[key].parts)) for key, row in pdot.rows.items()},
            {key: self.sum([x, pull.totals[key]]) for key, x in pdot.totals.items()},
        )

    def balance(self, pull: _Equations) -> dict[Unknown, Row]:
        """M a - f - J^T lambda, of families."""
        force, found = _of_vector(self.e.force, "v"), {}
        for g in (g for g in self.e.families if not g.is_state):
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

    def balances(self, pull: _Equations) -> dict[Unknown, Total]:
        """The same of scalar coordinates."""
        force, found = _of_vector(self.e.force, "v"), {}
        for g in (g for g in self.e.scalars if not g.is_state):
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

    def accelerations(self) -> _Equations:
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
        raise Unrolled("a sum over all members makes the derivatives dense")


class _Derive:
    def __init__(self, slots: Slots):
        self.slots, self.g = slots, slots.graph

    def by(self, of: _Equations) -> Callable[[tuple[str, ...]], Matrix]:
        return lambda kinds: self.matrix(of, kinds)

    def matrix(self, of: _Equations, kinds: tuple[str, ...]) -> Matrix:
        entries: dict[tuple[Unknown, Unknown, int], list[Part]] = defaultdict(list)
        right: dict[tuple[Unknown, Unknown], list[Part]] = defaultdict(list)
        bottom: dict[tuple[Unknown, Unknown], list[Part]] = defaultdict(list)
        corner: dict[tuple[Unknown, Unknown], Total] = defaultdict(Total)
        for family, row in of.rows.items():
            for part in row.parts:
                for (name, at), found in self._by_part(part, kinds).items():
                    if at is None:
                        right[family, name].append(found)
                    else:
                        entries[family, name, _distance(at, part)].append(found)
        for scalar, total in of.totals.items():
            for (name, at), node in self._by(total.constant, kinds).items():
                if at is None:
                    corner[scalar, name] = self._with(corner[scalar, name], node)
                else:
                    bottom[scalar, name].append(Part(at, at, node, node))
            for part in total.parts:
                for (name, at), found in self._by_part(part, kinds).items():
                    if at is None:
                        known = corner[scalar, name]
                        corner[scalar, name] = Total(known.constant, (*known.parts, found))
                    else:
                        found = _seen_from(self.slots, found, _distance(at, part))
                        bottom[scalar, name].append(found)
        return Matrix(_rows(entries), _rows(right), _rows(bottom), dict(corner))

    def _by_part(
        self, part: Part, kinds: tuple[str, ...]
    ) -> dict[tuple[Unknown, Affine | None], Part]:
        inner = self._by(part.node if part.inner is None else part.inner, kinds)
        return {
            key: Part(part.lo, part.hi, node, inner.get(key, ZERO))
            for key, node in self._by(part.node, kinds).items()
        }

    def _by(self, node: Node, kinds: tuple[str, ...]) -> _By:
        """The derivatives that are not zero, by the member or the scalar of each."""
        found: _By = {}
        for symbol, slope in gradient(self.g, node, _MASKS[kinds]).items():
            slot = self.slots.of(symbol)
            if slope != ZERO and slot is not None and slot.kind in kinds:
                key = (_OF[slot.kind], slot.name), slot.at
                found[key] = self.g.add(found.get(key, ZERO), slope)
        return found

    def _with(self, total: Total, node: Node) -> Total:
        return Total(self.g.add(total.constant, node), total.parts)


def _seen_from(slots: Slots, part: Part, distance: int) -> Part:
    """From the row of the cell that is so far away."""
    node, inner = (slots.shifted(x, -distance) for x in (part.node, part.inner))
    return Part(part.lo + distance, part.hi + distance, node, inner)


def _distance(at: Affine, part: Part) -> int:
    """Of a member from the cell whose row it is in."""
    apart = at - (M if at.factor(ROW) or part.lo != part.hi else part.lo)
    if not apart.is_constant:
        raise Unrolled("two members far apart feel each other")
    return apart.constant


def _rows(found: dict[K, Iterable[Part]]) -> dict[K, Row]:
    return {key: Row(tuple(parts)) for key, parts in found.items()}
