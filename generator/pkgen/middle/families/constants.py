"""Proves for every length of the families that a quantity A is constant.

dA/dt is written as a sum of terms over ranges of the index m, by the chain rule and M a = f for a
diagonal M. Each term is a monomial. The index of a monomial is shifted so that its least index is
m: sums of the same monomial then differ in their ranges only, so that their difference is a few
terms at the ends of the ranges, where given members have their values. dA/dt = 0 if the
coefficients of all monomials vanish. None of these steps uses the value of a size.
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
from .slots import J, M, Slots

# The largest number of terms that remain at one end of a range.
ENDS = 40


class Unknown(Exception):
    """dA/dt cannot be written as a sum of terms. The text is the reason."""


class Rate:
    """The time derivative of one quantity, as addends over ranges of indices."""

    def __init__(self, e: FamilyEquations):
        self.e, self.g, self.slots = e, e.graph, Slots(e.graph, e.slots)
        self.groups = {g.name: g for g in e.coordinates}

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
            raise Unknown("M is not diagonal, or constraints, rotations or events change rates")
        below = reachable(g, [node, *nodes_of(*e.sums)], VARIABLE)
        calls = [FUNCTIONS[g.data[n]] for n in below if g.op[n] is Op.CALL]
        if any(row.jump or row.branched for row in calls) or any(
            jumps(g, n) for n in reachable(g, nodes_of(e.lagrangian), VARIABLE)
        ):
            raise Unknown("it may jump")

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
            slope = self._moved(slope, -shift)
            over = tuple(end + shift for end in over)
            if group.periodic and over[1] - over[0] == group.hi - group.lo:
                over = whole
        if over != whole or (at is not None and not over):
            raise Unknown("it contains rates of single members")
        if len(mass) != 1 or mass[0].over != whole or mass[0].to[0][1] not in (None, M):
            raise Unknown("M is a sum of several terms")
        slope = g.divide(slope, mass[0].node)
        for x in of_name(e.force, name):
            at = x.to[0][1]
            if at in (None, M):
                there = slope
            elif at == J:
                there = self.at(slope, J)
            elif (at - M).is_constant:
                there = self._moved(slope, (at - M).constant)
            elif not x.over:
                there = self.at(slope, at)
            else:
                raise Unknown("a force on one member is a sum")
            yield Addend(self._inside(x.over, at, group, slope), g.multiply(x.node, there))

    def _inside(self, over: Over, at: Affine | None, group: Group, slope: Node) -> Over:
        """Returns the part of a range for which the member `at` of a family exists, or is another
        member beyond a free or periodic end."""
        if len(over) != 2 or at is None:
            return over
        lo, hi = group.lo - (at - M), group.hi - (at - M)
        beyond = lo - over[0], over[1] - hi
        if not all(x.is_constant for x in beyond):
            raise Unknown("its ranges have no fixed distance")
        below, above = (max(x.constant, 0) for x in beyond)
        if (below or above) and (group.periodic or any(x.kind == "free" for _, x in group.ends)):
            self._moved(slope, 1)
        given = {index for index, end in group.ends if end.kind == "fixed"}
        return (
            over[0] + (below if group.lo - 1 in given else 0),
            over[1] - (above if group.hi + 1 in given else 0),
        )

    def _moved(self, node: Node, shift: int) -> Node:
        """Returns a node with m replaced by m + shift, where cells alone depend on m."""
        below = self.slots.below(node)
        if shift and any(x.kind == "index" or (x.kind == "param" and x.at) for x in below):
            raise Unknown("its terms differ from member to member")
        return self.slots.shifted(node, shift)

    def at(self, node: Node, at: Affine) -> Node:
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

    def __init__(self, rate: Rate, found: Iterable[Addend]):
        self.rate, self.g, self.slots = rate, rate.g, rate.slots
        self.normal = Normal(self.g)
        self.single: list[Node] = []
        # For each product of atoms that depend on m: the factors of its sums over all m up to an
        # index.
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
        """Returns the node with the values of symbols for sums without a range."""

        def swap(slot: Slot) -> Node | None:
            total = self.rate.e.sums[int(slot.name)] if slot.kind == "sum" else None
            if total is None or any(x.over for x in total):
                return None
            return self._opened(self.g.sum(x.node for x in total))

        return self.slots.swapped(node, swap)

    def is_zero(self) -> bool:
        self._totals()
        ends = all(self._ends(key, found) for key, found in self.upto.items())
        return ends and all(map(self._zero, (*self.pairs.values(), map(self._there, self.single))))

    def _zero(self, nodes: Iterable[Node]) -> bool:
        return self.normal(self.g.sum(nodes)) == {}

    def _monomials(self, node: Node) -> Iterator[tuple[Monomial, Node]]:
        """Yields the atoms of each monomial that depend on m, and the product of the others."""
        found = self.normal(node)
        if found is None:
            raise Unknown("its time derivative has too many terms")
        for monomial, coefficient in found.items():
            own = tuple(x for x in monomial if any(map(_of_row, self.slots.below(x[0]))))
            rest = self._product(x for x in monomial if x not in own)
            yield own, self.g.multiply(self.g.number(coefficient), rest)

    def _product(self, monomial: Iterable[tuple[Node, int]]) -> Node:
        return self.g.product(self.g.power(x, k) for x, k in monomial)

    def _sum(self, node: Node, lo: Affine, hi: Affine) -> None:
        """Adds a sum over m = lo..hi."""
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
            places = [x.at for x in slots if _of_row(x) and x.kind != "index"]
            if any(not (at - M).is_constant for at in places):
                raise Unknown("its members stand at sums of indices")
            moves = not any(x.kind == "index" for x in slots)
            least = min(((at - M).constant for at in places), default=0) if moves else 0
            product = self.g.multiply(factor, self._product(own))
            yield list(self._monomials(self.slots.shifted(product, -least))), least

    def _ring(self, key: Monomial, lo: Affine, hi: Affine) -> tuple[Affine, Affine]:
        """Returns the range lo..hi, or 1..N if it goes once around a periodic family and the
        monomial contains its members alone."""
        slots = [x for x in self.slots.below(*(x for x, _ in key)) if _of_row(x)]
        groups = [self.rate.groups[x.name] if x.kind in CELLS else None for x in slots]
        first = groups[0]
        if first is None or any(x is None or not x.periodic for x in groups):
            return lo, hi
        same = all((x.lo, x.hi) == (first.lo, first.hi) for x in groups)
        return (first.lo, first.hi) if same and hi - lo == first.hi - first.lo else (lo, hi)

    def _totals(self) -> None:
        """Replaces sums over members that have a symbol of their own."""
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
                term = self.rate.at(self._product(key), Affine(k, terms))
                self.single.append(self.g.multiply(factors, term))
        return True

    def _there(self, node: Node) -> Node:
        """Returns the node with the values of members beyond the ends of their families."""
        e = self.rate.e

        def swap(slot: Slot) -> Node | None:
            if slot.kind not in CELLS or slot.at is None:
                return None
            given = e.given.get((slot.name, slot.at))
            if given is not None and slot.kind in ("q", "v"):
                return given[slot.kind == "v"]
            group = self.rate.groups[slot.name]
            below, above = group.lo - slot.at, slot.at - group.hi
            if any(x.is_constant and x.constant > 0 for x in (below, above)):
                is_low = below.is_constant and below.constant > 0
                other = group.hi + 1 - below if is_low else group.lo - 1 + above
                end = group.lo if is_low else group.hi
                at = other if group.periodic else end
                return self.slots.node(slot.kind, slot.name, at)
            return None

        return self.slots.swapped(node, swap)


def _of_row(slot: Slot) -> bool:
    return (slot.kind == "index" and slot.name == ROW) or (
        slot.at is not None and bool(slot.at.factor(ROW))
    )
