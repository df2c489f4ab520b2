"""Jacobians of the momenta p and of p' in models with carried values X (see `Carried`).

X[m] depends on all lower members, so that the Jacobians by coordinates are dense. With additional
unknowns they are banded: X, X', and for each X a momentum P and a force F, named "hung_p" and
"hung_f" in the code, by which X acts on the variables in its recurrence X = Phi. Let C be the
matrix of the recurrences, C z' = 0 with z = (X, q), and C' its time derivative. The additional
equations are

    X - Phi = 0,  X' - Phi' = 0,  C^T P = p_X,  C^T F + C'^T P = p'_X.

The momenta of the coordinates are p_q - C^T P, and their time derivatives p'_q - C^T F - C'^T P.
"""

from __future__ import annotations

from ...graph.graph import ONE, ZERO, Node
from .indexed_ir import Carried, Part, Row, Total, Unrolled
from .jacobians_closed import Motion, nothing, of_vector
from .loops import LoopEquations
from .matrices import BY_MORE, BY_PLACE, BY_RATE, Derive, M, Matrix, Stated, Unknown, seen_from
from .slots import Slots

# Maps (name, shift) to the entry in row m of C for member m + shift; shift is None for a scalar.
Entries = dict[tuple[str, int | None], Row]
HUNG = ("hung_p", "hung_f")


def made(e: LoopEquations, slots: Slots, item: Carried, rates: bool = False) -> Entries:
    """Returns the rows of the matrix C for one recurrence X = Phi, or with `rates` those of C'. In
    C, the entries for X itself, which are 1, come first."""
    carried = [g.name for g in e.carried_groups]

    def part(lo, hi, node: Node) -> Part:
        return Part(lo, hi, node, slots.inside(node, carried))

    found: Entries = {}
    if not rates:
        found[item.group.name, 0] = Row(tuple(part(p.lo, p.hi, ONE) for p in item.pieces))
    for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
        by = [(p, (p.by_rate if rates else p.by).get(slot, ZERO)) for p in item.pieces]
        parts = tuple(part(p.lo, p.hi, slots.graph.negate(x)) for p, x in by if x != ZERO)
        if parts:
            found[slot.name, None if slot.at is None else (slot.at - M).constant] = Row(parts)
    return found


class Chain(Motion):
    """Makes the Jacobians of a model with recurrences X = Phi."""

    def __init__(self, e: LoopEquations, slots: Slots, totals: list[int]):
        super().__init__(e, slots, set())
        self.totals = totals
        self.names = frozenset(g.name for g in e.carried_groups)
        self.derive = Derive(slots, e.fixed, self.names)

    @property
    def families(self) -> tuple:
        def of(kind: str) -> list:
            return [((kind, g.name), g) for g in self.e.carried_groups]

        own = [(("v", g.name), g) for g in self.e.families]
        return (*of("rate"), *own, *of("hung_p"), *of("place"), *of("hung_f"))

    def unknown(self, name: str) -> Unknown:
        return ("rate" if name in self.names else "v"), name

    # -- rows ---------------------------------------------------------------------------------

    def gone_over(self, kind: str, rates: bool = False) -> Stated:
        """Returns C^T x, or C'^T x with `rates`, for the matrix C of the recurrences. `kind` says
        which unknowns x are: the momenta P ("hung_p") or the forces F ("hung_f")."""
        rows: dict[str, list[Part]] = {g.name: [] for g in self.e.rows}
        totals: dict[str, list[Total]] = {g.name: [] for g in self.e.scalars}
        for item in self.e.carried:
            factor = self.slots.node(kind, item.group.name, M)
            for (name, shift), row in made(self.e, self.slots, item, rates).items():
                parts = self.times(row, factor)
                if shift is None:
                    totals[name].append(Total(ZERO, parts))
                else:
                    rows[name] += [seen_from(self.slots, part, shift) for part in parts]
        return Stated(
            {("v", name): Row(tuple(parts)) for name, parts in rows.items()},
            {("v", name): self.sum(found) for name, found in totals.items()},
        )

    def less(self, of: Stated, gone: Stated) -> Stated:
        rows = {k: Row((*x.parts, *self.minus(gone.rows[k]).parts)) for k, x in of.rows.items()}
        totals = {k: self.sum([x, self.minus(gone.totals[k])]) for k, x in of.totals.items()}
        return Stated(rows, totals)

    def own(self, of: Stated) -> Stated:
        """Returns the rows of `of` that belong to coordinates. Leaves out the rows that belong to
        the values X of recurrences."""
        rows = {key: row for key, row in of.rows.items() if key[1] not in self.names}
        return Stated(rows, of.totals)

    def hanging(self, of: Stated, kind: str) -> dict[Unknown, Row]:
        return {(kind, name): row for (_, name), row in of.rows.items() if name in self.names}

    def defined(self) -> dict[Unknown, Row]:
        """Returns the equations X - Phi and X' - Phi'."""
        found = {}
        for item in self.e.carried:
            for kind, slot, what in (("place", "q", "value"), ("rate", "v", "rate")):
                own = self.slots.node(slot, item.group.name, M)
                nodes = [(p, self.g.subtract(own, getattr(p, what))) for p in item.pieces]
                parts = tuple(Part(p.lo, p.hi, node, node) for p, node in nodes)
                found[kind, item.group.name] = Row(parts)
        return found

    # -- matrices -----------------------------------------------------------------------------

    def mass(self) -> Matrix:
        """Returns the matrix [M C^T; C 0]. Its columns belong to the rates of coordinates, to X'
        and to the unknowns P."""
        e, found = self.e, nothing()
        of = self.unknown
        for (own, other, shift), row in e.mass.entries.items():
            found.entries[of(own), of(other), shift] = row
        for (scalar, family), row in e.mass.border.items():
            found.right[of(family), of(scalar)] = found.bottom[of(scalar), of(family)] = row
        for (a, b), total in e.mass.corner.items():
            found.corner[of(a), of(b)] = total
        for item in e.carried:
            hung = ("hung_p", item.group.name)
            for (name, shift), row in made(e, self.slots, item).items():
                if shift is None:
                    found.right[hung, of(name)] = found.bottom[of(name), hung] = row
                else:
                    back = tuple(seen_from(self.slots, part, shift) for part in row.parts)
                    found.entries[hung, of(name), shift] = row
                    found.entries[of(name), hung, -shift] = Row(back)
        return found

    def by_all(self, of: Stated) -> Matrix:
        return self.derive.matrix(of, BY_RATE) | self.derive.matrix(of, BY_MORE)

    def matrices(self) -> list[Matrix]:
        """Returns the fields `mass`, `closed`, `p_q`, `pdot_q` and `pdot_v` of Slopes, in this
        order."""
        e = self.e
        p = self.less(of_vector(e.momenta, "v"), self.gone_over("hung_p"))
        pdot = self.less(of_vector(e.pdot, "v"), self.gone_over("hung_f"))
        pdot = self.less(pdot, self.gone_over("hung_p", rates=True))
        nodes = [x.node for row in (*p.rows.values(), *pdot.rows.values()) for x in row.parts]
        if any(s.kind == "w" and s.name in self.names for s in self.slots.below(*nodes)):
            raise Unrolled("a momentum or p' has the acceleration of a carried value in it")
        hung = self.hanging(p, "hung_p") | self.hanging(pdot, "hung_f")
        rows = Stated(self.defined() | hung, self.total_rows(self.totals))
        p, pdot = self.own(p), self.own(pdot)
        by_place = self.derive.matrix(p, BY_PLACE) | self.derive.matrix(rows, BY_PLACE)
        closed = self.by_all(p) | self.by_all(rows)
        return [
            self.mass(),
            closed,
            by_place,
            self.derive.matrix(pdot, BY_PLACE),
            self.by_all(pdot),
        ]
