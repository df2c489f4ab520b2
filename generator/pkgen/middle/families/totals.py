"""Totals: sums over members inside expressions, as in `cos(sum(q[i], i = 1..N))`.

Totals are computed before the equations that contain them, in the order of their numbers. In an
expression, a total is a symbol S. The derivative of F(S) by a member is F'(S) dS/dq[m].
The sum of F'(S) over all terms with S is a total too, so that a gradient takes about as many
operations as the sums.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from ...graph.affine import LOOPS
from ...graph.differentiate import gradient
from ...graph.graph import BIT, CONSTANT, ONE, ZERO, Kind, Node, Op
from ...tree import Sum as SumExpr
from .expand import FamilyExpander, around, independent
from .indexed_ir import REACHED, Addend, NotKept, Slot, Sum, merged, nodes_of
from .indices import Loop
from .terms import Term, terms

FELT = BIT[Kind.INPUT]  # the kind of the symbols that stand for sums over members
FIXED = ("param", "size", "index")


class Assembler(Protocol):
    """Adds terms to the equations of motion. Assembler of rows.py implements this protocol."""

    def bodies(self, found: Iterable[Term]) -> Sum: ...
    def of_total(self, body: Addend, factor: Node, drag: bool) -> None: ...


class Totals:
    """The totals (sums over members inside expressions) of one model, collected while expressions
    are converted to nodes."""

    def __init__(self, x: FamilyExpander, assembler: Assembler):
        self.x, self.g, self.assembler = x, x.graph, assembler
        self.all: list[Sum] = []
        self._numbers: dict[Sum, int] = {}

    # -- conversion of sums -------------------------------------------------------------------

    def of(self, expr: SumExpr, loop: Loop) -> Node:
        """Returns a node with the value of a sum: a sum of nodes if all its terms are written out,
        else the symbol of a total."""
        same = independent(self.x, expr, loop)
        if same:
            loop = {name: loop[name] for name in loop.keys() - around(self.x, loop)}
        found = terms(self.x, expr, loop)
        if not any(term.ranges for term in found):
            return self.g.sum(term.at(self.x) for term in found)
        if not same:
            raise NotKept("a sum over what depends on the index stands inside a function")
        # Members that are used while the total is made are not added to the record of members.
        met, self.x.members = self.x.members, []
        total = self.assembler.bodies(found)
        self.x.members = met
        return self.node(total)

    def node(self, total: Sum) -> Node:
        """Returns the symbol of a total. If the total is just a number or a scalar, returns the
        node of this number or scalar."""
        total = merged(total, self.g)
        if not any(x.over for x in total):
            constant = self.g.sum(x.node for x in total)
            if self._plain(constant):
                return constant
        if total not in self._numbers:
            self._numbers[total] = len(self.all)
            self.all.append(total)
        return self.x.slots.node("sum", str(self._numbers[total]))

    def throughout(self, body: Node) -> Node:
        """Returns the summand of a sum. A member with a fixed index, such as `q[1]`, is read before
        the loop: it is replaced by the symbol of a sum with this one term."""

        def swap(slot: Slot) -> Node | None:
            if slot.kind not in REACHED or slot.at is None or any(map(slot.at.factor, LOOPS)):
                return None
            return self.node((Addend((), self.x.slots.node(slot.kind, slot.name, slot.at)),))

        return self.x.slots.swapped(body, swap)

    def _plain(self, node: Node) -> bool:
        """Returns whether a node is a constant, or a symbol that is no member of a family."""
        if not self.g.depends[node] & ~CONSTANT:
            return True
        slot = self.x.slots.of(node)
        return self.g.op[node] is Op.SYMBOL and (slot is None or slot.at is None)

    def rate(self, slot: Slot) -> Node:
        """Returns the time derivative of the total with the symbol `slot`."""
        by = self.x.derivative
        return self.node(tuple(Addend(x.over, by(x.node)) for x in self.all[int(slot.name)]))

    # -- contents of totals -------------------------------------------------------------------

    def below(self, *nodes: Node) -> Iterator[Slot]:
        """Yields the meanings of the symbols in the given nodes, and of the symbols in totals that
        occur in them."""
        waiting, seen = list(nodes), set()
        while waiting:
            for slot in self.x.slots.below(waiting.pop()):
                if slot in seen:
                    continue
                seen.add(slot)
                yield slot
                if slot.kind == "sum":
                    waiting += nodes_of(self.all[int(slot.name)])

    def nodes(self, *nodes: Node) -> list[Node]:
        """Returns the given nodes, followed by the nodes of all totals that occur in them."""
        inside = [s for s in self.below(*nodes) if s.kind == "sum"]
        return [*nodes, *(node for s in inside for node in nodes_of(self.all[int(s.name)]))]

    def depends(self, node: Node) -> int:
        """Returns the kinds of symbols on which a node depends, directly or through totals, as a
        bit mask."""
        found = 0
        for each in self.nodes(node):
            found |= self.g.depends[each]
        return found

    def is_fixed(self, slot: Slot) -> bool:
        """Returns whether the total with the symbol `slot` depends only on parameters, sizes and
        indices."""
        nodes = nodes_of(self.all[int(slot.name)])
        if any(self.g.depends[node] & BIT[Kind.TIME] for node in self.nodes(*nodes)):
            return False
        return all(s.kind in (*FIXED, "sum") for s in self.below(*nodes))

    @property
    def fixed(self) -> frozenset[int]:
        slots = (Slot("sum", str(k)) for k in range(len(self.all)))
        return frozenset(int(slot.name) for slot in slots if self.is_fixed(slot))

    def moving(self, *nodes: Node) -> list[Slot]:
        """Returns the totals in the given nodes that may vary with time. Each is returned as the
        Slot of its symbol."""
        return [s for s in self.below(*nodes) if s.kind == "sum" and not self.is_fixed(s)]

    # -- derivatives --------------------------------------------------------------------------

    def felt(self, found: dict[int, list[Addend]], body: Addend, factor: Node = ONE) -> None:
        """Adds to `found` the derivatives of a body (summand) by the totals in it, times `factor`.
        The keys of `found` are the numbers of totals."""
        for symbol, slope in gradient(self.g, body.node, FELT).items():
            slot = self.x.slots.of(symbol)
            if slot.kind == "sum" and slope != ZERO:
                node = self.g.multiply(factor, slope)
                found.setdefault(int(slot.name), []).append(Addend(body.over, node))

    def over(self, found: dict[int, list[Addend]], drag: bool) -> None:
        """Adds the forces due to totals S by the chain rule. `found` has the derivatives dL/dS for
        all S; with `drag`, the derivatives -dD/dS. At the end `found` is empty."""
        while found:
            k = max(found)
            slope = self.node(tuple(found.pop(k)))
            if not self._of_rates(k) and drag:
                continue
            for body in self.all[k]:
                self.assembler.of_total(body, slope, drag)
                self.felt(found, body, slope)

    def check_rates(self, body: Node) -> None:
        """Raises NotKept if a term of L contains a total with rates, which makes M dense."""
        if any(self._of_rates(int(s.name)) for s in self.below(body) if s.kind == "sum"):
            raise NotKept("L has rates of all members inside a function: M would be dense")

    def _of_rates(self, k: int) -> bool:
        nodes = self.nodes(*nodes_of(self.all[k]))
        return any(self.g.depends[node] & BIT[Kind.RATE] for node in nodes)
