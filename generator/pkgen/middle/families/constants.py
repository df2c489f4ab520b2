"""Proves for families of any length that a quantity A is constant.

dA/dt is written as a sum of terms over ranges of the index m, by the chain rule and M a = f for a
diagonal M. Each term is a monomial. The index of a monomial is shifted so that its least index is
m. Two sums of one monomial then differ only in their ranges. Their difference is a few terms at the
ends; members beyond an end of a family have known values there. dA/dt = 0 if the coefficients of
all monomials vanish. The steps are valid for all sizes for which no range is empty.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

from ...functions import FUNCTIONS
from ...graph.affine import ROW, Affine
from ...graph.calls import jumps
from ...graph.differentiate import gradient, reachable
from ...graph.graph import BIT, ONE, VARIABLE, ZERO, Kind, Node, Op
from ...graph.normal import Monomial, Normal
from .equations import FamilyEquations
from .indexed_ir import CELLS, Addend, Cell, Group, Over, Slot, nodes_of, of_name
from .indices import size_values
from .slots import J, M, Slots

# The largest distance of two ends of ranges whose difference is written out.
ENDS = 40


class Unknown(Exception):
    """dA/dt cannot be written as a sum of terms. The text is the reason."""


class TimeDerivative:
    """The time derivative of one quantity, as addends over ranges of indices."""

    def __init__(self, e: FamilyEquations):
        self.e, self.g, self.slots = e, e.graph, Slots(e.graph, e.slots)
        self.groups = {g.name: g for g in e.coordinates}
        self.sizes = size_values(e.model)

    def vanishes(self, node: Node) -> bool:
        """Returns whether the time derivative of the quantity `node` is 0 at every length."""
        self._check(node)
        return _Collected(self, self.of(node, (), ONE)).is_zero()

    def _check(self, node: Node) -> None:
        e, g = self.e, self.g
        if (
            e.carried
            or e.bound
            or not e.mass_diagonal
            or e.model.struck
            or any(g.is_turn for g in e.coordinates)
        ):
            raise Unknown("M is not diagonal, or its rates follow constraints, rotations or events")
        own = [*self._whole(node)]
        below = reachable(g, own, VARIABLE)
        calls = [FUNCTIONS[g.data[n]] for n in below if g.op[n] is Op.CALL]
        if any(row.jump for row in calls) or any(
            jumps(g, n) for n in reachable(g, nodes_of(e.lagrangian), VARIABLE)
        ):
            raise Unknown("it may jump")
        roots = any(g.op[n] is Op.POWER and g.data[n].denominator > 1 for n in below)
        motion = self._divisors(nodes_of(e.lagrangian, e.force, e.mass))
        if (roots or any(row.branched for row in calls)) and self._divisors(own) - motion:
            raise Unknown("it may jump where it divides by zero")

    def _whole(self, node: Node) -> Iterator[Node]:
        """Yields the node, and the nodes of the totals in it."""
        yield node
        for slot in self.slots.below(node):
            if slot.kind == "sum":
                for x in self.e.sums[int(slot.name)]:
                    yield from self._whole(x.node)

    def _divisors(self, nodes: list[Node]) -> set[Node]:
        g = self.g
        return {
            g.args[n][0]
            for n in reachable(g, nodes, VARIABLE)
            if g.op[n] is Op.POWER and g.data[n] < 0
        }

    # -- the chain rule -----------------------------------------------------------------------

    def of(self, node: Node, over: Over, factor: Node) -> Iterator[Addend]:
        """Yields the addends of the time derivative of a node, times `factor`."""
        g = self.g
        for symbol, slope in gradient(g, node, VARIABLE | BIT[Kind.INPUT]).items():
            slope, slot = g.multiply(factor, slope), self.slots.of(symbol)
            if slope == ZERO:
                continue
            if slot is None:
                yield Addend(over, slope)
            elif slot.kind == "q":
                yield Addend(over, g.multiply(slope, self.slots.node("v", slot.name, slot.at)))
            elif slot.kind in CELLS:
                yield from self._accelerated((slot.name, slot.at), over, slope)
            elif slot.kind == "sum" and not over:
                for body in self.e.sums[int(slot.name)]:
                    yield from self.of(body.node, body.over, slope)
            elif slot.kind not in ("param", "size", "index"):
                raise Unknown("it contains inputs, or sums inside sums")

    def _accelerated(self, cell: Cell, over: Over, slope: Node) -> Iterator[Addend]:
        """Yields the addends of `slope` times the acceleration of a cell: force over mass."""
        e, g, (name, at), group = self.e, self.g, cell, self.groups[cell[0]]
        mass = [x for x in e.mass if x.to[0][0] == name]
        whole = (group.lo, group.hi) if group.is_family else ()
        if at is not None and len(over) == 2 and (at - M).is_constant:
            shift = (at - M).constant
            slope = self.slots.shifted(slope, -shift)
            over = tuple(end + shift for end in over)
            if self.goes_round(group, over, slope):
                over = whole
        if over != whole or (at is not None and not over):
            raise Unknown("it has rates of some members of a family, not of all")
        if len(mass) != 1 or mass[0].over != whole or mass[0].to[0][1] not in (None, M):
            raise Unknown("M is a sum of several terms")
        slope = g.divide(slope, mass[0].node)
        for x in of_name(e.force, name):
            at = x.to[0][1]
            if at in (None, M):
                there = slope
            elif at == J:
                there = self.at_index(slope, J)
            elif (at - M).is_constant:
                there = self.slots.shifted(slope, (at - M).constant)
            elif not x.over:
                there = self.at_index(slope, at)
            else:
                raise Unknown("a force on one member is a sum")
            if len(x.over) == 2 and at is not None:
                yield from self._on_members(x, group, slope, there)
            elif not self._is_given(x, group):
                yield Addend(x.over, g.multiply(x.node, there))

    def _on_members(self, x: Addend, group: Group, slope: Node, there: Node) -> Iterator[Addend]:
        """Yields the addends of a force on members m + c of a family: those for which the member
        exists, and single ones for members beyond an end that stand for others."""
        g, kinds = self.g, {index: end.kind for index, end in group.ends}
        shift, over = (x.to[0][1] - M).constant, list(x.over)
        for side, end, step in ((0, group.lo, -1), (1, group.hi, 1)):
            beyond = (over[side] + shift - end).times(step)
            if not beyond.is_constant:
                raise Unknown("a range begins or ends at no fixed distance from an end")
            for k in range(1, beyond.constant + 1):
                member, kind = end + step * k, kinds.get(end + step * k)
                over[side] = over[side] - step
                if kind == "fixed":
                    continue
                if not (kind == "free" or group.periodic) or k > ENDS:
                    raise Unknown("a force acts beyond an end")
                own = end if kind == "free" else member - group.count.times(step)
                node = self.at_index(x.node, member - shift)
                yield Addend((), g.multiply(node, self.at_index(slope, own)))
        yield Addend(tuple(over), g.multiply(x.node, there))

    def goes_round(self, group: Group, over: Over, node: Node) -> bool:
        """Returns whether a range goes once around a periodic family, and the node depends on m by
        members of such families alone."""
        return over[1] - over[0] == group.hi - group.lo and self._is_round(group, node)

    def _is_round(self, group: Group, node: Node) -> bool:
        own = [x for x in self.slots.below(node) if of_row(x)]
        rings = [self.groups[x.name] if x.kind in CELLS else None for x in own]
        ends = group.lo, group.hi
        same = all(x is not None and x.periodic and (x.lo, x.hi) == ends for x in rings)
        return group.periodic and same

    def _is_given(self, x: Addend, group: Group) -> bool:
        """Returns whether a force on a single member acts on a given member."""
        at = x.to[0][1]
        if x.over or at is None:
            return False
        if any(index == at and end.kind == "fixed" for index, end in group.ends):
            return True
        if not group.lo.value(self.sizes) <= at.value(self.sizes) <= group.hi.value(self.sizes):
            raise Unknown("a force acts beyond a free or periodic end")
        return False

    def at_index(self, node: Node, at: Affine) -> Node:
        """Returns a node with m replaced by an index."""

        def swap(slot: Slot) -> Node | None:
            if slot.kind == "index" and slot.name == ROW:
                return self.slots.number(at)
            if slot.at is None or not slot.at.factor(ROW):
                return None
            return self.slots.node(slot.kind, slot.name, slot.at.replaced({ROW: at}))

        return self.slots.swapped(node, swap)


class _Collected:
    """Addends, added up for each monomial."""

    def __init__(self, rate: TimeDerivative, found: Iterable[Addend]):
        self.rate, self.g, self.slots = rate, rate.g, rate.slots
        self.normal = Normal(self.g)
        self.single: list[Node] = []
        # `upto[monomial][k]` has the factors of the sum of a monomial over all m <= k.
        self.upto: dict[Monomial, dict[Affine, list[Node]]] = {}
        self.pairs: dict[Over, list[Node]] = {}
        for x in found:
            node = self._opened(x.node)
            if not x.over:
                self.single.append(node)
            elif len(x.over) == 2:
                self._sum(node, *x.over)
            else:
                self.pairs.setdefault(x.over, []).append(node)

    def _opened(self, node: Node) -> Node:
        """Returns the node with totals that are no sums over members written out."""

        def swap(slot: Slot) -> Node | None:
            total = self.rate.e.sums[int(slot.name)] if slot.kind == "sum" else None
            if total is None or any(x.over for x in total):
                return None
            return self._opened(self.g.sum(x.node for x in total))

        return self.slots.swapped(node, swap)

    def is_zero(self) -> bool:
        self._totals()
        ends = all(self._ends(key, found) for key, found in self.upto.items())
        return ends and all(
            map(self._zero, (*self.pairs.values(), map(self._with_ends, self.single)))
        )

    def _zero(self, nodes: Iterable[Node]) -> bool:
        return self.normal(self.g.sum(nodes)) == {}

    def _monomials(self, node: Node) -> Iterator[tuple[Monomial, Node]]:
        """Yields the atoms of each monomial that depend on m, and the product of the others."""
        found = self.normal(node)
        if found is None:
            raise Unknown("its time derivative has too many terms")
        for monomial, coefficient in found.items():
            own = tuple(x for x in monomial if any(map(of_row, self.slots.below(x[0]))))
            rest = self._product(x for x in monomial if x not in own)
            yield own, self.g.multiply(self.g.number(coefficient), rest)

    def _product(self, monomial: Iterable[tuple[Node, int]]) -> Node:
        return self.g.product(self.g.power(x, k) for x, k in monomial)

    def _sum(self, node: Node, lo: Affine, hi: Affine) -> None:
        """Adds a sum over m = lo..hi."""
        if (hi - lo).value(self.rate.sizes) < -1:
            raise Unknown("one of its ranges is empty")
        for found, least in self._shifted(node):
            for key, factor in found:
                first, last = lo + least, hi + least
                if not key:
                    count = self.slots.number(last - first + 1)
                    self.single.append(self.g.multiply(factor, count))
                    continue
                first, last = self._ring(key, first, last)
                found = self.upto.setdefault(key, {})
                found.setdefault(last, []).append(factor)
                found.setdefault(first - 1, []).append(self.g.negate(factor))

    def _shifted(self, node: Node) -> Iterator[tuple[list[tuple[Monomial, Node]], int]]:
        """Yields each monomial with its indices shifted so that the least is m, and the shift."""
        for own, factor in self._monomials(node):
            slots = self.slots.below(*(x for x, _ in own))
            places = [x.at for x in slots if of_row(x) and x.kind != "index"]
            if any(not (at - M).is_constant for at in places):
                raise Unknown("an index is not m plus a number")
            moves = not any(x.kind == "index" for x in slots)
            least = min(((at - M).constant for at in places), default=0) if moves else 0
            product = self.g.multiply(factor, self._product(own))
            yield list(self._monomials(self.slots.shifted(product, -least))), least

    def _ring(self, key: Monomial, lo: Affine, hi: Affine) -> tuple[Affine, Affine]:
        """Returns the range lo..hi; the range of the family if lo..hi goes once around it."""
        product = self._product(key)
        own = (x for x in self.slots.below(product) if of_row(x) and x.kind in CELLS)
        group = next((self.rate.groups[x.name] for x in own), None)
        if group is None or not self.rate.goes_round(group, (lo, hi), product):
            return lo, hi
        return group.lo, group.hi

    def _totals(self) -> None:
        """Replaces a sum by the symbol of the total with the same terms."""
        for k, total in enumerate(self.rate.e.sums):
            if len(total) != 1 or len(total[0].over) != 2:
                continue
            found = list(self._monomials(total[0].node))
            lo, hi = total[0].over
            for key, factor in found if len(found) == 1 else ():
                if hi in self.upto.get(key, {}):
                    times = self.g.sum(self.upto[key][hi])
                    symbol = self.slots.node("sum", str(k))
                    self.single.append(self.g.divide(self.g.multiply(times, symbol), factor))
                    self.upto[key][hi] = []
                    self.upto[key].setdefault(lo - 1, []).append(times)

    def _ends(self, key: Monomial, found: dict[Affine, list[Node]]) -> bool:
        """Moves the terms at the ends of ranges to `single`; returns whether no sum is left."""
        by_end: dict[tuple, dict[int, list[Node]]] = {}
        for at, factors in found.items():
            if not self._zero(factors):
                by_end.setdefault(at.terms, {})[at.constant] = factors
        for terms, each in by_end.items():
            least, most = min(each), max(each)
            if most - least > ENDS or not self._zero(chain(*each.values())):
                return False
            for k in range(least + 1, most + 1):
                factors = self.g.sum(chain(*(x for at, x in each.items() if at >= k)))
                term = self.rate.at_index(self._product(key), Affine(k, terms))
                self.single.append(self.g.multiply(factors, term))
        return True

    def _with_ends(self, node: Node) -> Node:
        """Returns the node with the values of members beyond the ends of their families."""
        e = self.rate.e

        def swap(slot: Slot) -> Node | None:
            if slot.kind not in CELLS or slot.at is None:
                return None
            given = e.given.get((slot.name, slot.at))
            if given is not None:
                if self.g.depends[given[0]] & (BIT[Kind.TIME] | BIT[Kind.INPUT]):
                    raise Unknown("an end moves")
                return ZERO if slot.kind == "v" else given[0]
            group = self.rate.groups[slot.name]
            kinds = {index: end.kind for index, end in group.ends}
            if kinds.get(slot.at) == "free":
                at = group.lo if slot.at == group.lo - 1 else group.hi
                return self.slots.node(slot.kind, slot.name, at)
            below, above = group.lo - slot.at, slot.at - group.hi
            if group.periodic and below.is_constant and below.constant > 0:
                return self.slots.node(slot.kind, slot.name, group.hi + 1 - below)
            if group.periodic and above.is_constant and above.constant > 0:
                return self.slots.node(slot.kind, slot.name, group.lo - 1 + above)
            return None

        return self.slots.swapped(node, swap)


def of_row(slot: Slot) -> bool:
    return (slot.kind == "index" and slot.name == ROW) or (
        slot.at is not None and bool(slot.at.factor(ROW))
    )
