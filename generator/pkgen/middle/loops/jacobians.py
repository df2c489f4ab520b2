"""Jacobians of the momenta p and of p' for models with loops, as banded matrices with a border.

The Jacobians by coordinates and rates would be dense if p' contains constraint forces or time
derivatives of states, or if the equations are in solved form (see `solved` of LoopEquations). Then
the accelerations a, these time derivatives and the multipliers lambda are additional unknowns,
whose equations have banded Jacobians:

    M a - f - J^T lambda = 0,   J a + gamma = 0,  where gamma is (J v + j0)' at a = 0.

Each sum S over members that occurs in the equations of members is an additional unknown too, with
the equation S - (sum over members) = 0.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...graph.graph import Node
from ...record import record
from .facts import total_nodes, vector_nodes
from .indexed_ir import Band, Group, Row, Total, Unrolled
from .jacobians_closed import Motion, nothing, of_vector
from .jacobians_recurrences import Chain
from .loops import LoopEquations
from .matrices import BY_MORE, BY_PLACE, BY_RATE, BY_TOTALS, Derive, Matrix, Stated, Unknown
from .slots import Slots


@record
class Slopes:
    # The unknowns that have a value for each index of a family, each with its family.
    families: tuple[tuple[Unknown, Group], ...]
    scalars: tuple[Unknown, ...]
    mass: Matrix
    # The matrix M, extended by rows for the additional equations and by columns for the additional
    # unknowns (see the module). None if there are no additional unknowns.
    closed: Matrix | None
    p_q: Matrix
    pdot_q: Matrix
    pdot_v: Matrix
    # The constraint forces J^T lambda, if p' contains them.
    pull: dict[str, Row | Total] | None

    @property
    def answered(self) -> bool:
        """Whether accelerations or multipliers are additional unknowns."""
        unknowns = [*(unknown for unknown, _ in self.families), *self.scalars]
        return any(kind in ("a", "lambda") for kind, _ in unknowns)

    @property
    def all(self) -> tuple[Matrix, ...]:
        closed = (self.closed,) if self.closed else ()
        return self.mass, *closed, self.p_q, self.pdot_q, self.pdot_v


def slopes_of(e: LoopEquations, slots: Slots) -> Slopes:
    """Returns the Jacobians. Raises Unrolled if they are not banded."""
    vectors = (e.momenta, e.pdot, e.force)
    nodes = [node for vector in vectors for node in vector_nodes(vector)]
    nodes += [part.node for row in e.mass.entries.values() for part in row.parts]
    totals = _totals(e, slots, nodes)
    nodes += [node for k in totals for node in total_nodes([e.sums[k]])]
    derive = Derive(slots, e.fixed)
    families = [(("v", g.name), g) for g in e.families]
    scalars = [("v", g.name) for g in e.scalars]
    # The states whose time derivatives occur in the equations of motion.
    used = {s.name for s in slots.below(*nodes) if s.kind == "a"}
    if e.carried:
        if e.bound or e.solved or used:
            raise Unrolled("carried values stand beside accelerations as unknowns")
        chain = Chain(e, slots, totals)
        scalars += [("sum", str(k)) for k in totals]
        return Slopes(chain.families, tuple(scalars), *chain.matrices(), None)
    if not (e.bound or e.solved or used or totals):
        p, pdot = of_vector(e.momenta, "v"), of_vector(e.pdot, "v")
        found = [derive.matrix(p, BY_PLACE), *map(derive.by(pdot), (BY_PLACE, BY_RATE))]
        return Slopes(tuple(families), tuple(scalars), _symmetric(e.mass), None, *found, None)
    answered = bool(e.bound or e.solved or used)  # whether a and lambda are unknowns
    if answered:
        families += [(("a", g.name), g) for g in e.families if not g.is_state or g.name in used]
        families += [(("lambda", x.group.name), x.group) for x in e.bound if not x.is_single]
        scalars += [("a", g.name) for g in e.scalars if not g.is_state or g.name in used]
        scalars += [("lambda", x.group.name) for x in e.bound if x.is_single]
    scalars += [("sum", str(k)) for k in totals]
    motion = Motion(e, slots, used)
    pull = motion.pull()
    own = Stated({}, motion.total_rows(totals))
    if answered:
        rows = motion.balance(pull) | motion.constraint_rows()
        own = Stated(rows, motion.balances(pull) | motion.single_rows() | own.totals)
    if e.solved:
        mass, p_q = motion.unit(), nothing()
        pdot = motion.accelerations()
    else:
        mass, p_q = _symmetric(e.mass), derive.matrix(of_vector(e.momenta, "v"), BY_PLACE)
        pdot = motion.with_pull(of_vector(e.pdot, "v"), pull)
    closed = mass | derive.matrix(own, BY_RATE) | derive.matrix(own, BY_MORE)
    if totals and not e.solved:
        closed = closed | derive.matrix(of_vector(e.momenta, "v"), BY_TOTALS)
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
    """Returns the numbers of the sums over members (Total) that occur in the nodes and may vary
    with time."""
    found: set[int] = set()
    while nodes:
        below = {int(slot.name) for slot in slots.below(*nodes) if slot.kind == "sum"}
        new = below - found - e.fixed
        found |= new
        nodes = total_nodes([e.sums[k] for k in new])
    return sorted(found)


def _symmetric(mass: Band) -> Matrix:
    def of(*names: str) -> tuple[Unknown, ...]:
        return tuple(("v", name) for name in names)

    return Matrix(
        {(*of(own, other), shift): row for (own, other, shift), row in mass.entries.items()},
        {of(family, scalar): row for (scalar, family), row in mass.border.items()},
        {of(*key): row for key, row in mass.border.items()},
        {of(*key): total for key, total in mass.corner.items()},
    )
