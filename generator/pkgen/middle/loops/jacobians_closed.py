"""The equations of additional unknowns: accelerations a, multipliers lambda, and sums over members.
See jacobians.py."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ...graph.graph import ONE, ZERO, Node
from .indexed_ir import Bound, Part, Row, Total, Unrolled, Vector
from .loops import LoopEquations
from .matrices import K, M, Matrix, Stated, Unknown, seen_from
from .slots import Slots

DENSE = "a sum over all members makes the derivatives dense"


def of_vector(vector: Vector, kind: str) -> Stated:
    if vector.pairs or any(total.pairs for total in vector.totals.values()):
        raise Unrolled(DENSE)
    return Stated(
        {(kind, name): row for name, row in vector.rows.items()},
        {(kind, name): total for name, total in vector.totals.items()},
    )


def nothing() -> Matrix:
    return Matrix({}, {}, {}, {})


class Motion:
    """Makes the equations in which the accelerations a and the multipliers lambda are unknowns."""

    def __init__(self, e: LoopEquations, slots: Slots, used: set[str]):
        self.e, self.slots, self.g, self.used = e, slots, slots.graph, used

    def a(self, name: str, shift: int | None = None) -> Node:
        return self.slots.node("a", name, None if shift is None else M + shift)

    def force(self, rows: Bound, shift: int = 0) -> Node:
        """Returns the multiplier lambda of constraint row m + shift; if the constraint has a single
        row, the multiplier of this row."""
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
        """Returns the constraint forces J^T lambda."""
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
        """Returns the rows of M a - f - J^T lambda that belong to families."""
        force, found = of_vector(self.e.force, "v"), {}
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
        """Returns the rows of M a - f - J^T lambda that belong to scalar coordinates."""
        force, found = of_vector(self.e.force, "v"), {}
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
        """Returns for each sum over members (Total) the equation S - (sum over members) = 0, where
        S is an unknown."""
        found = {}
        for k in totals:
            own, minus = self.slots.node("sum", str(k)), self.minus(self.e.sums[k])
            constant = self.g.add(own, minus.constant)
            found["sum", str(k)] = replace(minus, constant=constant)
        return found

    def accelerations(self) -> Stated:
        """Returns p' for equations in solved form: there p = v, and p' = a."""
        own = of_vector(self.e.force, "v")
        for g in (g for g in self.e.coordinates if not g.is_state):
            if g.is_family:
                a = self.a(g.name, 0)
                own.rows["v", g.name] = Row((Part(g.lo, g.hi, a, a),))
            else:
                own.totals["v", g.name] = Total(self.a(g.name))
        return own

    def unit(self) -> Matrix:
        return replace(
            nothing(),
            entries={
                (("v", g.name), ("v", g.name), 0): Row((Part(g.lo, g.hi, ONE, ONE),))
                for g in self.e.families
            },
            corner={(("v", g.name), ("v", g.name)): Total(ONE) for g in self.e.scalars},
        )


def _no_pairs(total: Total) -> None:
    if total.pairs:
        raise Unrolled(DENSE)
