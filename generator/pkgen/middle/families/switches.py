"""Finds the switches of equations with loops (see derive/switches.py): expressions at whose zeros a
force, or the time derivative of a state, jumps.

A switch has a value for each member of a family. Expressions that are equal after shifting their
indices are one switch. For a member next to a fixed end, the expression may be constant; this
member then has no switch value.

An expression at whose zeros the equations only have a kink is no switch here. Each member of a
chain would have kinks of its own, and each kink would end a step; the error control of the
integrator handles them instead. At the zeros of a switch, functions with a kink are held on one
branch too.

NotKept is raised for a jump in a sum over pairs, in L or in a constraint.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...graph.affine import LOOPS, OTHER, ROW, Affine, extremes
from ...graph.calls import counts
from ...graph.differentiate import reachable
from ...graph.graph import VARIABLE, ZERO, Graph, Node
from ...graph.surfaces import Surfaces, argument_of
from ..derive.impulses import Across, arguments_of
from ..derive.switches import free
from .equations import FamilyEquations, FamilySwitch, Limit
from .expand import FamilyExpander
from .indexed_ir import NotKept, Over, Slot, nodes_of
from .indices import size_values
from .singularities import moves, outputs_of, shown
from .slots import Slots


class Members:
    """Shifts the indices in expressions so that the least index is m."""

    def __init__(self, g: Graph, slots: Slots):
        self.g, self.slots = g, slots

    def __call__(self, node: Node) -> tuple[Node, Affine | None]:
        """Returns the expression with all indices shifted so that the least one becomes m, and the
        index that became m. If the expression contains no members, or contains both members m and j
        of a pair, returns the expression itself and None."""
        slots = self.slots.below(node)
        found = [slot.at for slot in slots if slot.at is not None]
        loops = _loops(slots)
        if len(loops) > 1:
            return node, None
        if loops:
            [name] = loops
            own = Affine(0, ((name, 1),))
            shifts = [(at - own).constant for at in found if (at - own).is_constant]
            least = own + min(shifts, default=0)
        elif found and all((at - found[0]).is_constant for at in found):
            least = min(found, key=lambda at: (at - found[0]).constant)
        else:
            return node, None
        return self.about(node, least), least

    def about(self, node: Node, at: Affine) -> Node:
        """Returns the node with its indices shifted so that the index `at` becomes m."""
        own = Affine(0, ((ROW, 1),))
        name = next((v for v in (ROW, OTHER) if at.factor(v)), None)
        # `back` is the loop variable before the shift, as an expression in the new index m
        back = own - at.without(name or "")

        def swap(slot: Slot) -> Node | None:
            if slot.kind == "index":
                return self.slots.number(back)
            if slot.at is None:
                return None
            if name is None:
                there = slot.at - at + own
            elif slot.at.factor(name):
                there = slot.at.replaced({name: back})
            else:
                return None
            return self.slots.node(slot.kind, slot.name, there)

        return self.slots.swapped(node, swap)

    def has_both(self, node: Node) -> bool:
        return len(_loops(self.slots.below(node))) > 1


def _loops(slots: list[Slot]) -> set[str]:
    """Returns the loop variables on which symbols depend: through the index of a member, or because
    the symbol stands for the loop variable itself."""
    found = {v for s in slots if s.at is not None for v in LOOPS if s.at.factor(v)}
    return found | {s.name for s in slots if s.kind == "index"}


def switches_of(
    x: FamilyExpander, e: FamilyEquations, limits: list[Limit]
) -> tuple[tuple[FamilySwitch, ...], bool]:
    """Returns the switches, and whether the equations are smooth except at zeros of switches. Adds
    conditions on sizes to `limits`. Raises NotKept for a jump that loops do not support."""
    found = _Switches(x, e, limits)
    return tuple(found.all()), found.whole


class _Switches:
    def __init__(self, x: FamilyExpander, e: FamilyEquations, limits: list[Limit]):
        self.x, self.e, self.g, self.limits = x, e, x.graph, limits
        self.members = Members(x.graph, x.slots)
        self.whole = False

    def all(self) -> Iterator[FamilySwitch]:
        x, e, g = self.x, self.e, self.g
        ends = [node for values in e.given.values() for node in values[:2]]
        if arguments_of(g, ends):
            raise NotKept("the motion of a fixed end bends or jumps")
        if arguments_of(g, [node for rows in e.bound for node in rows.nodes]):
            raise NotKept("a constraint bends or jumps")
        within = x.totals.nodes
        bodies = within(*nodes_of(e.lagrangian), *(node for node, _ in x.primes))
        if self._jumping(bodies):
            raise NotKept("L jumps at a step, so that rates do")
        jumping = self._jumping(within(*nodes_of(e.force)))
        if not jumping:
            return
        if any(counts(g, argument) for argument in jumping):
            raise NotKept(
                "a force or a rate jumps at knots, or has floor, ceil, round or mod in it"
            )
        surfaces = Surfaces(g)
        keys: dict[object, Node] = {}
        for argument in jumping:
            if self.members.has_both(argument):
                raise NotKept("a force or a rate jumps in a sum over pairs")
            node, _ = self.members(argument)
            keys.setdefault(surfaces(node)[0], node)
        ranges, loose = self._ranges(surfaces, keys)
        self.whole &= not loose
        for key, node in keys.items():
            kept = [r for r in (self._moving(node, over) for over in ranges[key]) if r is not None]
            if kept:
                self._keep_apart(node)
                yield FamilySwitch(shown(x, node), node, tuple(kept), key not in loose)

    def _ranges(
        self, surfaces: Surfaces, keys: dict[object, Node]
    ) -> tuple[dict[object, dict[Over, None]], set[object]]:
        """Returns the index ranges of each switch, and the switches with a call that must not be
        held on one branch (see `free` in derive/switches.py)."""
        g, outputs = self.g, list(outputs_of(self.x, self.e))
        ranges: dict[object, dict[Over, None]] = {key: {} for key in keys}
        escaped = free(g, [node for _, node in outputs])
        self.whole, loose = True, set()
        for over, output in outputs:
            for call in reachable(g, [output], VARIABLE):
                argument = argument_of(g, call)
                if argument == ZERO or not moves(self.x, argument):
                    continue
                node, at = self.members(argument)
                key = surfaces(node)[0]
                if key not in ranges:
                    self.whole = False
                    continue
                ranges[key][self._range(over, at)] = None
                if call in escaped:
                    loose.add(key)
        return ranges, loose

    def _jumping(self, nodes: list[Node]) -> list[Node]:
        """Returns the arguments at whose zeros one of the nodes may jump, without arguments that do
        not vary with time."""
        found = [a for a in arguments_of(self.g, nodes) if moves(self.x, a)]
        if not found:
            return []
        across = Across(self.g)
        return [a for a in found if any(across.jump(node, a) != ZERO for node in nodes)]

    def _range(self, over: Over, at: Affine | None) -> Over:
        """Returns the range of the index `at` if loop variables have the ranges `over`."""
        if at is None:
            return ()
        if len(over) == 4:
            lo, hi, first, last = over
            return extremes(at, {OTHER: (first, last), ROW: (lo, hi)})
        return extremes(at, {ROW: over}) if over else (at, at)

    # -- ends ---------------------------------------------------------------------------------

    def _moving(self, node: Node, over: Over) -> Over | None:
        """Returns the range without the members at its ends for which the argument is constant;
        None if no member remains."""
        if not over:
            return over
        lo, hi = over
        still = self._still(node)
        while lo in still:
            lo = lo + 1
        while hi in still:
            hi = hi - 1
        if (hi - lo).is_constant and (hi - lo).constant < 0:
            return None
        sizes = size_values(self.x.model)
        for at in still:
            # `at` is outside lo..hi if one of these two numbers is not negative
            apart = [lo - at - 1, at - hi - 1]
            if any(d.is_constant and d.constant >= 0 for d in apart):
                continue
            met = [d for d in apart if d.value(sizes) >= 0]
            if not met:
                raise NotKept("what a force jumps with stands still at a member amid others")
            self.limits.append(Limit(met[0], hi - lo))
        return lo, hi

    def _still(self, node: Node) -> set[Affine]:
        """Returns the indices m for which the argument is constant because the members in it have
        given values."""
        x, found = self.x, set()
        slots = [s for s in x.slots.below(node) if s.name in x.coordinates and s.at is not None]
        own = Affine(0, ((ROW, 1),))
        for slot in slots:
            for end, _ in x.coordinates[slot.name].ends:
                if slot.at.factor(ROW):
                    found.add(end - (slot.at - own).constant)
        return {at for at in found if not moves(x, self._beyond(node, at))}

    def _beyond(self, node: Node, at: Affine) -> Node:
        """Returns the argument for m = `at`, with members beyond fixed ends replaced by their
        prescribed values."""
        x = self.x

        def swap(slot: Slot) -> Node | None:
            group = x.coordinates.get(slot.name)
            if group is None or slot.at is None:
                return None
            place = slot.at.replaced({ROW: at})
            for end, given in group.ends:
                if end != place:
                    continue
                if given.kind == "free":
                    home = group.lo if end == group.lo - 1 else group.hi
                    return x.slots.node(slot.kind, slot.name, home)
                order = {"q": 0, "s": 0, "v": 1, "a": 1, "w": 2}.get(slot.kind)
                return ZERO if order is None else self.e.given[slot.name, end][order]
            return x.slots.node(slot.kind, slot.name, place)

        return x.slots.swapped(node, swap)

    def _keep_apart(self, node: Node) -> None:
        """Adds conditions on sizes: each family is so long that symbols with different indices in
        `node` are different members."""
        x = self.x
        places: dict[str, list[int]] = {}
        for slot in x.slots.below(node):
            if slot.name in x.coordinates and slot.at is not None and slot.at.factor(ROW):
                places.setdefault(slot.name, []).append(slot.at.constant)
        for name, shifts in places.items():
            length = max(shifts) - min(shifts)
            if length:
                self.limits.append(Limit(x.coordinates[name].count - 1 - length, None))
