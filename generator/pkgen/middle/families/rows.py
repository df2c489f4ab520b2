"""Makes the equations of motion from the terms of L, D and the forces: each body (summand) is
differentiated by all the cells in it at once."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from ...graph.affine import LOOPS, OTHER, ROW, Affine, extremes
from ...graph.differentiate import Forward, gradient
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Kind, Node
from ...model import Rotation
from ..motion import degree
from .equations import Limit
from .expand import FamilyExpander
from .indexed_ir import CELLS, REACHED, Addend, Cell, Group, NotKept, Over, Slot, Sum, merged
from .slots import J, M
from .terms import Term
from .totals import Totals

STATE = BIT[Kind.COORDINATE] | BIT[Kind.RATE]
RATES = BIT[Kind.RATE]
ATTITUDES = BIT[Kind.STATE]
# The quantities to which generalized forces, -dD/dv and rates of states are added.
APPLIED = ("pdot", "force")


class Assembler:
    """Adds the contributions of terms to the equations of motion in `found`."""

    def __init__(self, x: FamilyExpander):
        self.x = x
        self.g = x.graph
        self.found: dict[str, list[Addend]] = defaultdict(list)
        # Conditions on the model's sizes, such as N in q[1..N].
        self.limits: list[Limit] = []
        # For each periodic family, the largest distance of an index beyond its ends.
        self.wraps: dict[str, int] = {}
        self.totals = x.totals = Totals(x, self)
        # The derivatives of L, and of -D, by the sums over members in them, by number of the sum.
        self.felt: dict[int, list[Addend]] = {}
        self.drag: dict[int, list[Addend]] = {}
        self.moving = {
            name
            for name, group in x.coordinates.items()
            for at, end in group.ends
            if end.kind == "fixed" and self._moves(name, at)
        }
        self.coast = Forward(x.graph, VARIABLE, self._coasting)
        self.applied = False  # whether there are generalized forces besides those from L

    def quantity(self, name: str) -> Sum:
        return merged(self.found[name], self.g)

    # -- bodies -------------------------------------------------------------------------------

    def bodies(self, found: Iterable[Term]) -> Sum:
        """Returns the bodies of terms. Those with the same range are added up."""
        return merged([self._body(term) for term in found], self.g)

    def _body(self, term: Term) -> Addend:
        """Returns the body of a term at i = m, or i = m and j. Records the conditions on sizes
        under which its members exist."""
        over = over_of(term)
        self.x.members.clear()
        node = term.at(self.x, *(M, J)[: len(term.ranges)])
        if over:
            node = self.totals.throughout(node)
        self.reach(over, node)
        return Addend(over, node)

    def reach(self, over: Over, node: Node) -> None:
        """Records the conditions on sizes under which all members in a body exist. Raises NotKept
        if their indices are not m, or m and j, plus constants."""
        slots = self.x.slots.below(node)
        if len(over) == 4:
            self._pairs_in_reach(over, slots)
            return
        self.limits += self.x.limits_over(*over or (None, None))
        for slot in slots if over else ():
            self.member(slot, *over)

    def member(self, slot: Slot, lo: Affine, hi: Affine) -> None:
        """Raises NotKept if a member's index is not m plus a constant. Records the conditions on
        sizes under which the member exists for m = lo..hi."""
        if slot.kind in REACHED and slot.at is not None:
            if slot.at.factor(ROW) != 1 or not (slot.at - M).is_constant:
                reached = f"{slot.name}[{slot.at.text({ROW: 'i'})}]"
                raise NotKept(f"a sum reaches {reached} from its index i")
            self.in_reach(slot, lo, hi)

    def in_reach(self, slot: Slot, lo: Affine | None, hi: Affine | None) -> None:
        """Records the conditions on the sizes of the model under which a member exists for all m =
        lo..hi, where the value of a member beyond a fixed end is given. For a periodic family,
        records instead how far the index goes beyond the ends."""
        if slot.kind not in REACHED or slot.at is None or lo is None:
            return
        group = self.x.coordinates[slot.name]
        first, last = extremes(slot.at, {ROW: (lo, hi)})
        below, above = first - group.lo, group.hi - last
        if group.periodic:
            for beyond in (-below, -above):
                if beyond.is_constant:
                    for name in (slot.name, *self.x.rotations.moved(slot)):
                        self.wraps[name] = max(self.wraps.get(name, 0), beyond.constant)
                else:
                    self.limits.append(Limit(-beyond, hi - lo))
            return
        self.limits.append(Limit(below + _given(group, -1), hi - lo))
        self.limits.append(Limit(above + _given(group, 1), hi - lo))

    def _pairs_in_reach(self, over: Over, slots: list[Slot]) -> None:
        lo, hi, first, last = over
        # The least and greatest values of indices are valid only if both ranges are not empty.
        self.limits += self.x.limits_of(hi - lo, {OTHER: (first, last), ROW: (lo, hi)})
        for slot in slots:
            if slot.kind not in REACHED or slot.at is None:
                continue
            if slot.at not in (M, J):
                raise NotKept("a pair sum reaches beside its own members")
            group = self.x.coordinates[slot.name]
            low, high = (lo, hi) if slot.at == M else (first, last)
            for needs in (low - group.lo, group.hi - high):
                self.limits.append(Limit(extremes(needs, {ROW: (lo, hi)})[0], hi - lo))

    def cells(self, node: Node) -> list[Cell]:
        """Returns the coordinates on which a node depends. A quaternion counts as the three
        coordinates of its rotation."""
        slots = [slot for slot in self.x.slots.below(node) if slot.kind in CELLS]
        moved = [(name, slot.at) for slot in slots for name in self.x.rotations.moved(slot)]
        return list(dict.fromkeys(moved))

    def add(self, names: Iterable[str], over: Over, node: Node, *to: Cell) -> None:
        if node != ZERO:
            for name in names:
                self.found[name].append(Addend(over, node, to))

    # -- terms --------------------------------------------------------------------------------

    def lagrangian(self, bodies: Sum) -> None:
        """Adds the contributions of L."""
        for body in bodies:
            self.totals.check_rates(body.node)
            self.totals.felt(self.felt, body)
            if len(body.over) == 4 and self.g.depends[body.node] & RATES:
                raise NotKept("a pair sum has rates in it: M would be dense")
            self._motion(body.over, body.node)

    def _motion(self, over: Over, body: Node) -> None:
        by = gradient(self.g, body, STATE | ATTITUDES)
        for cell in self.cells(body):
            momentum = by.get(self.x.slots.node("v", *cell), ZERO)
            slope = self.x.rotations.slope(by, *cell, True)
            self.add(("gradient", "pdot"), over, slope, cell)
            self.add(("momenta",), over, momentum, cell)
            self.add(("force",), over, self.g.subtract(slope, self.coast(momentum)), cell)
            for symbol, node in gradient(self.g, momentum, RATES).items():
                slot = self.x.slots.of(symbol)
                self._inertia(over, node, cell, (slot.name, slot.at))

    def _inertia(self, over: Over, node: Node, row: Cell, column: Cell) -> None:
        if node == ZERO:
            return
        if None not in (row[1], column[1]) and not (row[1] - column[1]).is_constant:
            raise NotKept("the inertia of two members far apart is coupled")
        self.add(("mass",), over, node, row, column)

    def dissipation(self, bodies: Sum) -> None:
        """Adds the force -dD/dv."""
        for body in bodies:
            self.totals.felt(self.drag, Addend(body.over, self.g.negate(body.node)))
            self.applied |= body.node != ZERO
            by = gradient(self.g, self.g.negate(body.node), RATES)
            for cell in self.cells(body.node):
                node = by.get(self.x.slots.node("v", *cell), ZERO)
                self.add(APPLIED, body.over, node, cell)

    def felt_through(self) -> None:
        """Adds the forces due to sums over members (totals) inside functions in L and D, by the
        chain rule. To be called after all terms have been added."""
        self.totals.over(self.felt, False)
        self.totals.over(self.drag, True)

    def of_total(self, body: Addend, factor: Node, drag: bool) -> None:
        """Adds the forces due to one body of a sum S over members (total). `factor` is the
        derivative dL/dS; with `drag`, it is -dD/dS."""
        by = gradient(self.g, body.node, RATES if drag else STATE | ATTITUDES)
        for cell in self.cells(body.node):
            if drag:
                slope = by.get(self.x.slots.node("v", *cell), ZERO)
            else:
                slope = self.x.rotations.slope(by, *cell, False)
            names = APPLIED if drag else ("gradient", *APPLIED)
            self.add(names, body.over, self.g.multiply(factor, slope), cell)

    def applied_term(self, group: Group, lo: Affine | None, hi: Affine | None, term: Term) -> None:
        """Adds a term of a generalized force on members lo..hi, or of the time derivative of states
        lo..hi."""
        x, cell = self.x, (group.name, None if lo is None else M)
        if lo is None or not term.ranges:
            if term.ranges:
                body = self._body(term)
                over, node = body.over, body.node
            else:
                over, node = () if lo is None else (lo, hi), term.at(x)
                self.limits += x.limits_over(lo, hi)
                for slot in x.slots.below(node):
                    self.in_reach(slot, lo, hi)
        else:
            if len(term.ranges) == 2:
                raise NotKept("a sum over two indices stands in what each member is given")
            over = (lo, hi, *term.ranges[0][1:])
            x.members.clear()
            node = self.totals.throughout(term.at(x, J))
            self.reach(over, node)
        if len(over) == 2 and lo is not None and lo == hi:
            over, node, cell = (), self._at_index(node, lo), (group.name, lo)
        self.add(APPLIED, over, node, cell)
        self.applied |= node != ZERO and not group.is_state

    def load(
        self, lo: Affine | None, hi: Affine | None, force: tuple[Node, ...], v: tuple[Node, ...]
    ) -> None:
        """Adds forces at points with the velocities `v`, or torques, on members lo..hi: the
        derivatives of v by the rates, times the force."""
        if any(slot.kind == "sum" for slot in self.x.slots.below(*v)):
            raise NotKept("a force acts at a point that is a sum over members")
        over = () if lo is None or lo == hi else (lo, hi)
        self.x.members.clear()
        for value, velocity in zip(force, v, strict=True):
            if over:
                value = self.totals.throughout(value)
                self.reach(over, self.g.multiply(value, velocity))
            elif lo is not None:
                value, velocity = self._at_index(value, lo), self._at_index(velocity, lo)
                for slot in self.x.slots.below(value, velocity):
                    self.in_reach(slot, lo, hi)
            for symbol, slope in gradient(self.g, velocity, RATES).items():
                slot, node = self.x.slots.of(symbol), self.g.multiply(value, slope)
                self.add(APPLIED, over, node, (slot.name, slot.at))
                self.applied |= node != ZERO

    def _at_index(self, node: Node, at: Affine) -> Node:
        """Returns the node for the index m = at."""

        def swap(slot: Slot) -> Node | None:
            if slot.kind == "index" and slot.name == ROW:
                return self.x.slots.number(at)
            if slot.at is None or not slot.at.factor(ROW):
                return None
            return self.x.slots.node(slot.kind, slot.name, slot.at.replaced({ROW: at}))

        return self.x.slots.swapped(node, swap)

    def attitude(self, rotation: Rotation) -> None:
        """Adds the time derivatives of the components of a rotation's quaternion, which are
        states."""
        over, at = all_of(self.x.coordinates[rotation.quaternion[0]])
        rates = self.x.rotations.moving(rotation, at)
        for name, rate in zip(rotation.quaternion, rates, strict=True):
            self.add(APPLIED, over, rate, (name, at))

    def state(self, group: Group) -> None:
        """Adds the momentum and the inertia of a state, which in C is a rate with inertia 1."""
        over, at = all_of(group)
        cell = group.name, at
        self.add(("momenta",), over, self.x.slots.node("s", *cell), cell)
        self.add(("mass",), over, ONE, cell, cell)

    def energy(self, bodies: Sum) -> Sum:
        """Returns the energy h = v.p - L, for the bodies of L."""
        return merged([Addend(x.over, self._energy_of(x)) for x in bodies], self.g)

    def _energy_of(self, body: Addend) -> Node:
        """Returns the contribution of a body of L to h. The rates of given members are left out of
        v.p."""
        work = self.g.negate(body.node)
        by = gradient(self.g, body.node, RATES) if len(body.over) < 4 else {}
        left = False
        for symbol, node in by.items():
            slot = self.x.slots.of(symbol)
            if node == ZERO:
                continue
            near = slot.at is not None and (self._carried(slot) or bool(body.over))
            given = slot.name in self.moving and near
            left |= given
            rate = self.x.slots.node("d", slot.name, slot.at) if given else symbol
            work = self.g.add(work, self.g.multiply(rate, node))
        return body.node if by and degree(self.g, body.node) == 2 and not left else work

    # -- given members ------------------------------------------------------------------------

    def seen_from(self, node: Node, place: Affine) -> Node:
        """Returns the node with indices shifted so that `place` becomes m. Indices whose distance
        from `place` is not constant are kept."""

        def swap(slot: Slot) -> Node | None:
            if slot.at is None or not (slot.at - place).is_constant:
                return None
            return self.x.slots.node(slot.kind, slot.name, M + (slot.at - place))

        return self.x.slots.swapped(node, swap)

    def _moves(self, name: str, at: Affine) -> bool:
        """Returns whether the prescribed value of a member beyond a fixed end depends on t or an
        input."""
        turning = self.x.rotations.turns.get(name)
        nodes = [self.x.given(n, at) for n in (turning[0].quaternion if turning else (name,))]
        driven = BIT[Kind.TIME] | BIT[Kind.INPUT]
        return any(self.g.depends[node] & driven for node in nodes)

    def _coasting(self, node: Node) -> Node:
        """Returns the time derivative of a symbol if all coordinates have the acceleration 0."""
        slot = self.x.slots.of(node)
        if slot is not None and slot.kind == "v":
            if self._carried(slot):
                return self.x.slots.node("w", slot.name, slot.at)
            relative = slot.at is not None and any(slot.at.factor(v) for v in LOOPS)
            if relative and slot.name in self.moving:
                return self.x.slots.node("w", slot.name, slot.at)
            return ZERO
        return self.x.derivative(node)

    def _carried(self, slot: Slot) -> bool:
        return self.x.coordinates[slot.name].is_carried


def over_of(term: Term) -> Over:
    """Returns the ranges of a term, with m for the first index in the range of the second."""
    if not term.ranges:
        return ()
    (own, lo, hi), *more = term.ranges
    return (lo, hi, *(end.replaced({own: M}) for _, *ends in more for end in ends))


def all_of(group: Group) -> tuple[Over, Affine | None]:
    """Returns the range of a family and the index m, or of a scalar () and None."""
    return ((group.lo, group.hi), M) if group.is_family else ((), None)


def _given(group: Group, side: int) -> int:
    """Returns the number of consecutive indices beyond the lower (side -1) or upper end of a family
    for which the model gives values."""
    at = {index for index, _ in group.ends}
    count = 0
    while (group.lo - (count + 1) if side < 0 else group.hi + (count + 1)) in at:
        count += 1
    return count
