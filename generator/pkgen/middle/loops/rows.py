"""Makes the equations of motion (rows) from the terms of L, D and the forces, by differentiating
the body (summand) of each term by each member in it."""

from __future__ import annotations

from dataclasses import replace

from ...graph.affine import LOOPS, Affine
from ...graph.differentiate import Forward, gradient
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Kind, Node
from ...model import Rotation
from ..motion import degree
from .bodies import Bodies, Gathered
from .expand import LoopExpander
from .indexed_ir import Group, PairPart, Part, Slot, Total, Unrolled
from .pair_sums import ATTITUDES, RATES, STATE, M, pair_force, pair_ranges, pair_row, scaled, signed
from .terms import Term
from .totals import Totals

APPLIED = ("pdot", "force")  # the quantities to which a generalized force is added


class Gather:
    """Adds the contributions of terms to the equations of motion in `found`, term by term."""

    def __init__(self, x: LoopExpander):
        self.x = x
        self.g = x.graph
        self.found = Gathered()
        self.bodies = Bodies(x, self.found)
        self.totals = x.totals = Totals(x, self)
        # The derivatives of L by the sums over members in it. The keys are the numbers of the sums.
        self.felt: dict[int, Total] = {}
        # The derivatives of -D by the sums over members in it.
        self.drag: dict[int, Total] = {}
        self.moving = {
            name
            for name, group in x.coordinates.items()
            for at, end in group.ends
            if end.kind == "fixed" and self._moves(name, at)
        }
        self.coast = Forward(x.graph, VARIABLE, self._coasting)
        self.applied = False  # whether there are generalized forces besides those from L

    # -- terms --------------------------------------------------------------------------------

    def lagrangian(self, term: Term, sign: int) -> None:
        """Adds the contributions of sign * term, a term of L."""
        body = signed(self.g, self.totals.body(term), sign)
        self.totals.check_rates(body)
        self.totals.felt(self.felt, term, body)
        if len(term.ranges) == 2:
            self.found.pairs.append(pair_force(self.x, term, body, False))
            return
        for family, shift, body in self.bodies.views(term):
            momentum = self._enter_motion(family, shift, body, term, sign)
            self._mass(term, family, shift, momentum)
        body = self.bodies.at_row(term)
        for name in self.bodies.scalars(body):
            momentum = self._enter_motion(name, None, body, term, sign)
            tangents = gradient(self.g, momentum, RATES)
            for other in self.bodies.scalars(body):
                node = self._by(tangents, "v", other, None)
                if node != ZERO:
                    total = self.found.corner[name, other]
                    self.found.corner[name, other] = self.with_(total, term, node)

    def _enter_motion(
        self, name: str, shift: Affine | None, body: Node, term: Term, sign: int
    ) -> Node:
        """Adds the contributions of a term of L with this body to the equations of one family, or
        of a scalar coordinate if `shift` is None. Returns the contribution to the momentum of the
        family or coordinate."""
        at = M if term.ranges and shift is not None else shift
        by = gradient(self.g, signed(self.g, body, sign), STATE | ATTITUDES)
        slope, momentum = self.x.rotations.slope(by, name, at, True), self._by(by, "v", name, at)
        force = self.g.subtract(slope, self.coast(momentum))
        self._enter(("gradient", "pdot"), name, term, shift, slope)
        self._enter(("momenta",), name, term, shift, momentum)
        self._enter(("force",), name, term, shift, force)
        return momentum

    def dissipation(self, term: Term) -> None:
        """Adds the force -dD/dv of a term of D."""
        body = signed(self.g, self.totals.body(term), -1)
        self.totals.felt(self.drag, term, body)
        if len(term.ranges) == 2:
            self.applied = True
            self.found.drags.append(pair_force(self.x, term, body, True))
            return
        for family, shift, body in self.bodies.views(term):
            at = M if term.ranges else shift
            node = self._by(gradient(self.g, signed(self.g, body, -1), RATES), "v", family, at)
            self._enter(APPLIED, family, term, shift, node)
        body = self.bodies.at_row(term)
        self.applied |= body != ZERO
        by = gradient(self.g, signed(self.g, body, -1), RATES)
        for name in self.bodies.scalars(body):
            self._enter(APPLIED, name, term, None, self._by(by, "v", name, None))

    def felt_through(self) -> None:
        """Adds the forces due to sums over members (totals) inside functions in L and D, by the
        chain rule. To be called after all terms have been added."""
        self.totals.over(self.felt, False)
        self.totals.over(self.drag, True)

    def of_total(self, term: Term, factor: Node, drag: bool) -> None:
        """Adds the force due to one term of a sum S over members (total). `factor` is the
        derivative dL/dS; with `drag`, it is -dD/dS."""
        x, g = self.x, self.g
        if len(term.ranges) == 2:
            force = scaled(g, factor, pair_force(x, term, self.totals.body(term), drag))
            (self.found.drags if drag else self.found.pairs).append(force)
            return
        whats = APPLIED if drag else ("gradient", *APPLIED)

        def slope(body: Node, name: str, at: Affine | None) -> Node:
            by = gradient(g, body, RATES if drag else STATE | ATTITUDES)
            found = self._by(by, "v", name, at) if drag else x.rotations.slope(by, name, at, False)
            return g.multiply(factor, found)

        for family, shift, body in self.bodies.views(term):
            at = M if term.ranges else shift
            self._enter(whats, family, term, shift, slope(body, family, at))
        body = self.bodies.at_row(term)
        for name in self.bodies.scalars(body):
            self._enter(whats, name, term, None, slope(body, name, None))

    def applied_term(self, group: Group, lo: Affine | None, hi: Affine | None, term: Term) -> None:
        """Adds a term of a generalized force on members lo..hi, or of the time derivative of states
        lo..hi."""
        x, found, name = self.x, self.found, group.name
        if term.ranges and lo is not None:
            if len(term.ranges) == 2:
                raise Unrolled("a sum over two indices stands in what each member is given")
            found.drags.append(pair_row(x, name, lo, hi, term, found.limits))
            self.applied |= not group.is_state
            return
        if term.ranges:
            node = self.bodies.at_row(term)
            for what in APPLIED:
                found.totals[what, name] = self.with_(found.totals[what, name], term, node)
        else:
            node = term.at(x)
            found.limits += x.limits_over(lo, hi)
            self._add_over(APPLIED, name, lo, hi, node)
        self.applied |= node != ZERO and not group.is_state

    def _add_over(
        self, whats: tuple[str, ...], name: str, lo: Affine | None, hi: Affine | None, node: Node
    ) -> None:
        """Adds a node to the quantities named `whats` of the members lo..hi of a family, or of a
        scalar coordinate if `lo` is None."""
        for slot in self.x.slots.below(node):
            self.bodies.in_reach(slot, lo, hi)
        for what in whats:
            if lo is None:
                total = self.found.totals[what, name]
                constant = self.g.add(total.constant, node)
                self.found.totals[what, name] = replace(total, constant=constant)
            else:
                self.append(self.found.rows[what, name], Part(lo, hi, node))

    def attitude(self, rotation: Rotation) -> None:
        """Adds the time derivatives of the components of a rotation's quaternion, which are
        states."""
        own = self.x.coordinates[rotation.quaternion[0]]
        at = M if own.is_family else None
        rates = self.x.rotations.moving(rotation, at)
        for name, rate in zip(rotation.quaternion, rates, strict=True):
            self._add_over(APPLIED, name, own.lo, own.hi, rate)

    def state(self, group: Group) -> None:
        """Adds the momentum and the inertia of a state, which in C is a rate with inertia 1."""
        at = M if group.is_family else None
        own = self.x.slots.node("s", group.name, at)
        self._add_over(("momenta",), group.name, group.lo, group.hi, own)
        if group.is_family:
            self.found.entries[group.name, group.name, 0].append(Part(group.lo, group.hi, ONE, ONE))
        else:
            self.found.corner[group.name, group.name] = Total(ONE)

    def energy(self, found: list[tuple[Term, int]]) -> Total:
        """Returns the energy h = v.p - L. `found` has the terms of L, each with its sign 1 or
        -1."""
        result = Total()
        for term, sign in found:
            if len(term.ranges) == 2:
                body = signed(self.g, self.totals.body(term), -sign)
                result = self.with_(result, term, body)
            else:
                result = self.with_(result, term, *self._energy_of(term, sign))
        return result

    def _energy_of(self, term: Term, sign: int) -> tuple[Node, Node]:
        """Returns the contribution of a term of L to h, in two forms: for members near the ends,
        and for the interior."""
        body = signed(self.g, self.bodies.at_row(term), sign)
        if self.g.depends[body] & RATES == 0:
            node = self.g.negate(body)
            return node, node
        by = gradient(self.g, body, RATES)
        work = self.g.negate(body)
        moving = carried = False
        for symbol, node in by.items():
            slot = self.x.slots.of(symbol)
            throughout = self._carried(slot)
            near = slot.at is not None and (throughout or bool(term.ranges))
            given = slot.name in self.moving and near
            moving |= given
            carried |= given and throughout
            rate = self.x.slots.node("d", slot.name, slot.at) if given else symbol
            work = self.g.add(work, self.g.multiply(rate, node))
        inner = body if degree(self.g, body) == 2 and not carried else self.inner(work)
        return (work if moving else inner), inner

    def total(self, found: list[tuple[Term, int]]) -> Total:
        """Returns the sum of the terms, each multiplied by its sign."""
        result = Total()
        for term, sign in found:
            result = self.with_(result, term, signed(self.g, self.totals.body(term), sign))
        return result

    # -- parts --------------------------------------------------------------------------------

    def inner(self, node: Node) -> Node:
        """Returns the node for an index m far from the ends of families (in the interior): there it
        contains no members with prescribed values."""
        carried = [g.name for g in self.x.coordinates.values() if g.is_carried]
        return self.x.slots.inside(node, carried)

    def append(self, parts: list[Part], part: Part) -> None:
        if part.node != ZERO:
            inner = self.inner(part.node) if part.inner is None else part.inner
            parts.append(replace(part, inner=inner))

    def _enter(
        self, whats: tuple[str, ...], name: str, term: Term, shift: Affine | None, node: Node
    ) -> None:
        for what in whats:
            if shift is None:
                self.found.totals[what, name] = self.with_(
                    self.found.totals[what, name], term, node
                )
            else:
                self.add(self.found.rows[what, name], term, shift, node)

    def add(self, parts: list[Part], term: Term, shift: Affine, node: Node) -> None:
        if term.ranges:
            (_, lo, hi) = term.ranges[0]
            self.append(parts, Part(lo + shift, hi + shift, node))
        else:
            self.append(parts, Part(shift, shift, self.seen_from(node, shift)))

    def seen_from(self, node: Node, place: Affine) -> Node:
        """Returns the node with indices shifted so that `place` becomes m. Indices whose distance
        from `place` is not constant are kept."""

        def swap(slot: Slot) -> Node | None:
            if slot.at is None or not (slot.at - place).is_constant:
                return None
            return self.x.slots.node(slot.kind, slot.name, M + (slot.at - place))

        return self.x.slots.swapped(node, swap)

    def with_(self, total: Total, term: Term, node: Node, inner: Node | None = None) -> Total:
        if not term.ranges:
            return replace(total, constant=self.g.add(total.constant, node))
        if len(term.ranges) == 2:
            return replace(total, pairs=(*total.pairs, PairPart(*pair_ranges(term), node)))
        parts = list(total.parts)
        (_, lo, hi) = term.ranges[0]
        self.append(parts, Part(lo, hi, node, inner))
        return replace(total, parts=tuple(parts))

    def _mass(self, term: Term, family: str, shift: Affine, momentum: Node) -> None:
        if momentum == ZERO:
            return
        for symbol, node in gradient(self.g, momentum, RATES).items():
            slot = self.x.slots.of(symbol)
            if node == ZERO:
                continue
            if slot.at is None:
                self.add(self.found.border[slot.name, family], term, shift, node)
                continue
            distance = slot.at - (M if term.ranges else shift)
            if not distance.is_constant:
                raise Unrolled("the inertia of two members far apart is coupled")
            key = (family, slot.name, distance.constant)
            self.add(self.found.entries[key], term, shift, node)

    def _moves(self, name: str, at: Affine) -> bool:
        """Returns whether the prescribed value of a member beyond a fixed end depends on t or an
        input."""
        turning = self.x.rotations.turns.get(name)
        nodes = [self.x.given(n, at) for n in (turning[0].quaternion if turning else (name,))]
        driven = BIT[Kind.TIME] | BIT[Kind.INPUT]
        return any(self.g.depends[node] & driven for node in nodes)

    def _by(self, by: dict[Node, Node], kind: str, name: str, at: Affine | None) -> Node:
        return by.get(self.x.slots.node(kind, name, at), ZERO)

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
