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

from collections.abc import Iterator

from ...graph.graph import MINUS_ONE, ONE, ZERO
from .equations import FamilyEquations
from .indexed_ir import Addend, Carried, NotKept, Sum, nodes_of
from .jacobians import BY_MORE, BY_PLACE, BY_RATE, Motion, Slopes, Unknown, read_of
from .slots import M, Slots


def made(e: FamilyEquations, slots: Slots, item: Carried, rates: bool = False) -> Sum:
    """Returns the entries of the matrix C, or with `rates` of its rate C', in the rows of one
    recurrence X = Phi. In C, the entries for X itself, which are 1, come first."""
    row, found = (item.group.name, M), []
    if not rates:
        found += [Addend((p.lo, p.hi), ONE, (row, row)) for p in item.pieces]
    for slot in dict.fromkeys(z for piece in item.pieces for z in piece.by):
        for p in item.pieces:
            node = (p.by_rate if rates else p.by).get(slot, ZERO)
            if node != ZERO:
                minus = slots.graph.negate(node)
                found.append(Addend((p.lo, p.hi), minus, (row, (slot.name, slot.at))))
    return tuple(found)


def of_chain(e: FamilyEquations, slots: Slots) -> Slopes:
    """Returns the Jacobians of a model with recurrences X = Phi. Raises NotKept if they are not
    banded."""
    totals, used = read_of(e, slots)
    if e.bound or e.solved or used:
        raise NotKept("carried values stand beside accelerations as unknowns")
    return _Chain(e, slots, set()).slopes_of(totals)


class _Chain(Motion):
    def unknown(self, name: str) -> Unknown:
        return ("rate" if name in self.names else "v"), name

    def gone_over(self, kind: str, rates: bool = False) -> Sum:
        """Returns -C^T x, or -C'^T x with `rates`, for the matrix C of the recurrences. `kind` says
        which unknowns x are: the momenta P ("hung_p") or the forces F ("hung_f")."""
        entries = [x for item in self.e.carried for x in made(self.e, self.slots, item, rates)]
        return self.minus(self.times(x, self.slots.node(kind, *x.to[0]), x.to[1]) for x in entries)

    def defined(self) -> Iterator[Addend]:
        """Yields the equations X - Phi and X' - Phi'."""
        for item in self.e.carried:
            name = item.group.name
            for kind, slot, what in (("place", "q", "value"), ("rate", "v", "rate")):
                own = self.slots.node(slot, name, M)
                for p in item.pieces:
                    node = self.g.subtract(own, getattr(p, what))
                    yield Addend((p.lo, p.hi), node, (((kind, name), M),))

    def named(self, of: Sum, kind: str) -> Sum:
        """Returns addends to unknowns: those of recurrences have this kind, others are rates."""
        return tuple(
            Addend(x.over, x.node, ((self._unknown(name, kind), at),))
            for x in of
            for name, at in x.to
        )

    def _unknown(self, name: str, kind: str) -> Unknown:
        return (kind if name in self.names else "v"), name

    def mass(self) -> Sum:
        """Returns the matrix [M C^T; C 0]. Its columns belong to the rates of coordinates, to X'
        and to the unknowns P. In C, the diagonal of unknowns that are no coordinates is 1 at first,
        which is taken away here."""
        found = [
            Addend((g.lo, g.hi), MINUS_ONE, (((kind, g.name), M),) * 2)
            for g in self.e.carried_groups
            for kind in ("rate", "hung_p")
        ]
        found += [
            Addend(x.over, x.node, tuple((self.unknown(name), at) for name, at in x.to))
            for x in self.e.mass
        ]
        for item in self.e.carried:
            for x in made(self.e, self.slots, item):
                (own, at), (name, other) = x.to
                row, column = (("hung_p", own), at), (self.unknown(name), other)
                found += [Addend(x.over, x.node, to) for to in ((row, column), (column, row))]
        return tuple(found)

    def slopes_of(self, totals: list[int]) -> Slopes:
        e = self.e
        p = (*e.momenta, *self.gone_over("hung_p"))
        pdot = (*e.pdot, *self.gone_over("hung_f"), *self.gone_over("hung_p", rates=True))
        below = self.slots.below(*nodes_of(p, pdot))
        if any(s.kind == "w" and s.name in self.names for s in below):
            raise NotKept("a momentum or p' has the acceleration of a carried value in it")
        hung = [*self.named(p, "hung_p"), *self.named(pdot, "hung_f")]
        rows = (*self.defined(), *(x for x in hung if x.to[0][0][0] != "v"))
        rows += self.total_rows(totals)
        p, pdot = ([x for x in self.named(of, "") if x.to[0][0][0] == "v"] for of in (p, pdot))
        own = [(("v", g.name), g) for g in e.families]
        rate, *more = ([((kind, g.name), g) for g in e.carried_groups] for kind in _KINDS)
        families = (*rate, *own, *(unknown for found in more for unknown in found))
        scalars = (*(("v", g.name) for g in e.scalars), *(("sum", str(k)) for k in totals))
        by, both = self.slopes, (*p, *rows)
        return Slopes(
            families,
            scalars,
            self.mass(),
            (*by(both, BY_RATE), *by(both, BY_MORE)),
            by(both, BY_PLACE),
            by(tuple(pdot), BY_PLACE),
            (*by(tuple(pdot), BY_RATE), *by(tuple(pdot), BY_MORE)),
            None,
        )


_KINDS = ("rate", "hung_p", "place", "hung_f")
