"""Jacobians of the momenta p and of p' for models with loops, as banded matrices with a border.

An unknown is (kind, name), such as ("v", "q") for the rates of q; cells of matrices have unknowns
in place of names. The Jacobians by coordinates and rates would be dense if p' contains constraint
forces or time derivatives of states, or if the equations are in solved form (see `solved` of
FamilyEquations). Then the accelerations a, these time derivatives and the multipliers lambda are
additional unknowns, whose equations have banded Jacobians:

    M a - f - J^T lambda = 0,   J a + gamma = 0,  where gamma is (J v + j0)' at a = 0.

Each sum S over members that occurs in the equations of members is an additional unknown too, with
the equation S - (sum over members) = 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ...graph.differentiate import gradient
from ...graph.graph import BIT, ONE, ZERO, Kind, Node
from ...record import record
from .equations import FamilyEquations
from .indexed_ir import Addend, Bound, Cell, Group, NotKept, Sum, merged, nodes_of
from .rows import all_of
from .slots import Slots

Unknown = tuple[str, str]
# The kinds of symbols (see Slot) by which derivatives are taken: positions, rates, additional
# unknowns (including those of recurrences), and sums over members.
BY_PLACE, BY_RATE = ("q",), ("v", "s", "d")
BY_MORE = ("a", "lambda", "sum", "hung_p", "hung_f")
BY_TOTALS = ("sum",)
_OF = {**dict.fromkeys((*BY_PLACE, *BY_RATE), "v"), **{kind: kind for kind in BY_MORE}}
_OF_CARRIED = {"q": "place", **dict.fromkeys(BY_RATE, "rate"), **{kind: kind for kind in BY_MORE}}
_MASKS = {
    BY_PLACE: BIT[Kind.COORDINATE],
    BY_RATE: BIT[Kind.RATE] | BIT[Kind.STATE],
    BY_MORE: BIT[Kind.INPUT] | BIT[Kind.COORDINATE] | BIT[Kind.RATE],
    BY_TOTALS: BIT[Kind.INPUT],
}


@record
class Slopes:
    # The unknowns that have a value for each index of a family, each with its family.
    families: tuple[tuple[Unknown, Group], ...]
    scalars: tuple[Unknown, ...]
    mass: Sum
    # The matrix M, extended by rows for the additional equations and by columns for the additional
    # unknowns (see the module). None if there are no additional unknowns.
    closed: Sum | None
    p_q: Sum
    pdot_q: Sum
    pdot_v: Sum
    # The constraint forces J^T lambda, if p' contains them.
    pull: Sum | None

    @property
    def answered(self) -> bool:
        """Whether accelerations or multipliers are additional unknowns."""
        unknowns = [*(unknown for unknown, _ in self.families), *self.scalars]
        return any(kind in ("a", "lambda") for kind, _ in unknowns)

    @property
    def all(self) -> tuple[Sum, ...]:
        return (
            self.mass,
            *((self.closed,) if self.closed else ()),
            self.p_q,
            self.pdot_q,
            self.pdot_v,
        )


def read_of(e: FamilyEquations, slots: Slots) -> tuple[list[int], set[str]]:
    """Returns the numbers of the sums that the equations read and that may vary with time, and the
    states whose time derivatives they read. Raises NotKept if the Jacobians are dense."""
    nodes = nodes_of(e.momenta, e.pdot, e.force, e.mass)
    totals = _totals(e, slots, nodes)
    nodes += nodes_of(*(e.sums[k] for k in totals))
    if any(len(x.over) == 4 for of in (e.pdot, e.force, *(e.sums[k] for k in totals)) for x in of):
        raise NotKept("a sum over all members makes the derivatives dense")
    return totals, {s.name for s in slots.below(*nodes) if s.kind == "a"}


def slopes_of(e: FamilyEquations, slots: Slots) -> Slopes:
    """Returns the Jacobians of a model without recurrences. Raises NotKept if they are not
    banded."""
    totals, used = read_of(e, slots)
    motion = Motion(e, slots, used)
    families = [(("v", g.name), g) for g in e.families]
    scalars = [("v", g.name) for g in e.scalars]
    answered = bool(e.bound or e.solved or used)  # whether a and lambda are unknowns
    own: Sum = motion.total_rows(totals)
    pull = motion.pull()
    if answered:
        families += [(("a", g.name), g) for g in e.families if motion.has_acceleration(g)]
        families += [(("lambda", x.group.name), x.group) for x in e.bound if not x.is_single]
        scalars += [("a", g.name) for g in e.scalars if motion.has_acceleration(g)]
        scalars += [("lambda", x.group.name) for x in e.bound if x.is_single]
        own = (*motion.balance(pull), *motion.constraint_rows(), *own)
    scalars += [("sum", str(k)) for k in totals]
    by = motion.slopes
    if e.solved:
        mass, p_q, pdot = motion.unit(), (), motion.accelerations()
    else:
        mass, p_q = motion.inertia(), by(rates(e.momenta), BY_PLACE)
        pdot = (*rates(e.pdot), *rates(pull))
    closed = None
    if answered or totals:
        closed = (*mass, *by(own, BY_RATE), *by(own, BY_MORE))
        closed += by(rates(e.momenta), BY_TOTALS) if totals and not e.solved else ()
    return Slopes(
        tuple(families),
        tuple(scalars),
        mass,
        closed,
        (*p_q, *by(own, BY_PLACE)),
        by(pdot, BY_PLACE),
        (*by(pdot, BY_RATE), *by(pdot, BY_MORE)),
        None if e.solved or not e.bound else pull,
    )


def rates(of: Iterable[Addend], kind: str = "v") -> Sum:
    """Returns addends to unknowns of a kind, in place of addends to cells of the same names."""
    return tuple(Addend(x.over, x.node, tuple(((kind, name), at) for name, at in x.to)) for x in of)


def _totals(e: FamilyEquations, slots: Slots, nodes: list[Node]) -> list[int]:
    """Returns the numbers of the sums over members that occur in the nodes and may vary with
    time."""
    found: set[int] = set()
    while nodes:
        below = {int(slot.name) for slot in slots.below(*nodes) if slot.kind == "sum"}
        new = below - found - e.fixed
        found |= new
        nodes = nodes_of(*(e.sums[k] for k in new))
    return sorted(found)


class Motion:
    """Makes the equations in which the accelerations a and the multipliers lambda are unknowns.
    `used` has the states whose time derivatives are unknowns."""

    def __init__(self, e: FamilyEquations, slots: Slots, used: set[str]):
        self.e, self.slots, self.g, self.used = e, slots, slots.graph, used
        self.names = frozenset(g.name for g in e.carried_groups)

    def has_acceleration(self, group: Group) -> bool:
        return not group.is_state or group.name in self.used

    def times(self, x: Addend, factor: Node, *to: Cell) -> Addend:
        return Addend(x.over, self.g.multiply(x.node, factor), to)

    def minus(self, of: Iterable[Addend]) -> Sum:
        return tuple(Addend(x.over, self.g.negate(x.node), x.to) for x in of)

    def a(self, cell: Cell) -> Node:
        return self.slots.node("a", *cell)

    # -- equations ----------------------------------------------------------------------------

    def pull(self) -> Sum:
        """Returns the constraint forces J^T lambda."""
        return tuple(
            self.times(x, self.slots.node("lambda", *x.to[0]), x.to[1])
            for bound in self.e.bound
            for x in bound.jacobian
        )

    def balance(self, pull: Sum) -> Sum:
        """Returns the rows M a - f - J^T lambda."""
        rows = [self.times(x, self.a(x.to[1]), x.to[0]) for x in self.e.mass]
        rows += self.minus((*self.e.force, *pull))
        states = {g.name for g in self.e.states} - self.used
        return rates((x for x in rows if x.to[0][0] not in states), "a")

    def constraint_rows(self) -> Sum:
        rows = [x for bound in self.e.bound for x in (*bound.coasting, *self._moved(bound))]
        return rates(rows, "lambda")

    def _moved(self, bound: Bound) -> Iterator[Addend]:
        return (self.times(x, self.a(x.to[1]), x.to[0]) for x in bound.jacobian)

    def total_rows(self, totals: Iterable[int]) -> Sum:
        """Returns for each sum S over members the equation S - (sum over members) = 0, where S is
        an unknown."""
        found: list[Addend] = []
        for k in totals:
            to = ((("sum", str(k)), None),)
            found.append(Addend((), self.slots.node("sum", str(k)), to))
            found += (Addend(x.over, self.g.negate(x.node), to) for x in self.e.sums[k])
        return tuple(found)

    def accelerations(self) -> Sum:
        """Returns p' for equations in solved form: there p = v, and p' = a."""
        states = {g.name for g in self.e.states}
        found = [x for x in self.e.force if x.to[0][0] in states]
        for g in (g for g in self.e.coordinates if not g.is_state):
            over, at = all_of(g)
            found.append(Addend(over, self.a((g.name, at)), ((g.name, at),)))
        return rates(found)

    def unit(self) -> Sum:
        found = (
            ((("v", g.name), at), over) for g in self.e.coordinates for over, at in [all_of(g)]
        )
        return tuple(Addend(over, ONE, (cell, cell)) for cell, over in found)

    def inertia(self) -> Sum:
        return rates(self.e.mass)

    # -- derivatives --------------------------------------------------------------------------

    def slopes(self, of: Sum, kinds: tuple[str, ...]) -> Sum:
        """Returns the derivatives of the quantities `of` by the unknowns with symbols of these
        kinds. Raises NotKept if they are not banded."""
        return merged((new for x in of for new in self._by(x, kinds)), self.g)

    def _by(self, x: Addend, kinds: tuple[str, ...]) -> Iterator[Addend]:
        for symbol, slope in gradient(self.g, x.node, _MASKS[kinds]).items():
            slot = self.slots.of(symbol)
            if slope == ZERO or slot is None:
                continue
            if slot.kind == "sum" and int(slot.name) in self.e.fixed:
                continue
            own = slot.name in self.names
            if kinds == BY_MORE if own else slot.kind in kinds:
                unknown = (_OF_CARRIED if own else _OF)[slot.kind], slot.name
                at = x.to[0][1]
                if None not in (at, slot.at) and not (slot.at - at).is_constant:
                    raise NotKept("two members far apart feel each other")
                yield Addend(x.over, slope, (x.to[0], (unknown, slot.at)))
