"""Totals: sums over members inside expressions, as in `cos(sum(q[i], i = 1..N))`.

Totals are computed before the equations that contain them, in the order of their numbers. In an
expression, a total is a symbol S. The derivative of F(S) by a member is F'(S) dS/dq[m].
The sum of F'(S) over all terms with S is a total too, so that a gradient takes about as many
operations as the sums.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from ...graph.affine import LOOPS, Affine
from ...graph.differentiate import gradient
from ...graph.graph import BIT, CONSTANT, ONE, ZERO, Kind, Node, Op
from ...record import record
from ...tree import Sum
from .bodies import Bodies, Gathered
from .expand import LoopExpander, around, independent
from .indexed_ir import REACHED, PairPart, Part, Slot, Total, Unrolled
from .indices import Loop
from .pair_sums import pair_body
from .terms import Term, terms

FELT = BIT[Kind.INPUT]  # the kind of the symbols that stand for sums over members
FIXED = ("param", "size", "index")


class Gather(Protocol):
    """Adds terms to the equations of motion. Gather of rows.py implements this protocol."""

    found: Gathered
    bodies: Bodies

    def total(self, found: list[tuple[Term, int]]) -> Total: ...
    def with_(self, total: Total, term: Term, node: Node) -> Total: ...
    def inner(self, node: Node) -> Node: ...
    def of_total(self, term: Term, factor: Node, drag: bool) -> None: ...


@record
class _Member:
    """A term that consists of a single member, such as `q[1]`."""

    slot: Slot
    ranges: tuple = ()

    def at(self, x: LoopExpander) -> Node:
        return x.slots.node(self.slot.kind, self.slot.name, self.slot.at)


@record
class _Rate:
    """The time derivative of the term `of`. It can be used like a term."""

    of: Term

    @property
    def ranges(self) -> tuple[tuple[str, Affine, Affine], ...]:
        return self.of.ranges

    def at(self, x: LoopExpander, *values: Affine) -> Node:
        return x.derivative(self.of.at(x, *values))


class Totals:
    """The totals (sums over members inside expressions) of one model, collected while expressions
    are converted to nodes."""

    def __init__(self, x: LoopExpander, gather: Gather):
        self.x, self.g, self.gather = x, x.graph, gather
        self.all: list[Total] = []
        self._terms: list[list[Term]] = []
        self._numbers: dict[Total, int] = {}

    # -- conversion of sums -------------------------------------------------------------------

    def of(self, expr: Sum, loop: Loop) -> Node:
        """Returns a node with the value of a sum: a sum of nodes if all its terms are written out,
        else the symbol of a total."""
        same = independent(self.x, expr, loop)
        if same:
            loop = {name: loop[name] for name in loop.keys() - around(self.x, loop)}
        found = terms(self.x, expr, loop)
        if not any(term.ranges for term in found):
            return self.g.sum(term.at(self.x) for term in found)
        if not same:
            raise Unrolled("a sum over what depends on the index stands inside a function")
        return self._entered(found)

    def _entered(self, found: list[Term]) -> Node:
        """Returns the symbol of the total with the terms `found`. Members that are used while the
        total is made are not added to the record of members."""
        met, self.x.members = self.x.members, []
        total = self.gather.total([(term, 1) for term in found])
        self.x.members = met
        return self.node(total, found)

    def node(self, total: Total, found: Iterable[Term] = ()) -> Node:
        """Returns the symbol of a total. If the total is just a number or a scalar, returns the
        node of this number or scalar."""
        constant = total.constant
        if not (total.parts or total.pairs) and self._plain(constant):
            return constant
        if total not in self._numbers:
            self._numbers[total] = len(self.all)
            self.all.append(total)
            self._terms.append([])
        self._terms[self._numbers[total]] = self._terms[self._numbers[total]] or list(found)
        return self.x.slots.node("sum", str(self._numbers[total]))

    def throughout(self, body: Node) -> Node:
        """Returns the summand of a sum. A member with a fixed index, such as `q[1]`, is read before
        the loop: it is replaced by the symbol of a sum with this one term."""

        def swap(slot: Slot) -> Node | None:
            if slot.kind not in REACHED or slot.at is None or any(map(slot.at.factor, LOOPS)):
                return None
            member = _Member(slot)
            return self.node(Total(member.at(self.x)), [member])

        return self.x.slots.swapped(body, swap)

    def _plain(self, node: Node) -> bool:
        """Returns whether a node is a constant, or a symbol that is no member of a family."""
        if not self.g.depends[node] & ~CONSTANT:
            return True
        slot = self.x.slots.of(node)
        return self.g.op[node] is Op.SYMBOL and (slot is None or slot.at is None)

    def rate(self, slot: Slot) -> Node:
        """Returns the time derivative of the total with the symbol `slot`."""
        total, by, inner = self.all[int(slot.name)], self.x.derivative, self.gather.inner
        rates = [_Rate(term) for term in self._terms[int(slot.name)]]
        if rates:
            return self._entered(rates)
        parts = [Part(p.lo, p.hi, by(p.node), inner(by(p.node))) for p in total.parts]
        pairs = [PairPart(p.lo, p.hi, p.first, p.last, by(p.node)) for p in total.pairs]
        kept = (tuple(x for x in found if x.node != ZERO) for found in (parts, pairs))
        return self.node(Total(by(total.constant), *kept))

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

    def felt(self, found: dict[int, Total], term: Term, body: Node, factor: Node = ONE) -> None:
        """Adds to `found` the derivatives of a term's body (summand) by the totals in it, times
        `factor`. The keys of `found` are the numbers of totals."""
        for symbol, slope in gradient(self.g, body, FELT).items():
            slot = self.x.slots.of(symbol)
            if slot.kind != "sum" or slope == ZERO:
                continue
            k, node = int(slot.name), self.g.multiply(factor, slope)
            found[k] = self.gather.with_(found.get(k, Total()), term, node)

    def over(self, found: dict[int, Total], drag: bool) -> None:
        """Adds the forces due to totals S by the chain rule. `found` has the derivatives dL/dS for
        all S; with `drag`, the derivatives -dD/dS. At the end `found` is empty."""
        while found:
            k = max(found)
            slope = self.node(found.pop(k))
            if not self._of_rates(k) and drag:
                continue
            assert self._terms[k], "what L and D have is made of terms"
            for term in self._terms[k]:
                body = self.body(term)
                self.gather.of_total(term, slope, drag)
                self.felt(found, term, body, slope)

    def body(self, term: Term) -> Node:
        """Returns the body (summand) of a term with the index m, or m and j for a double sum."""
        if len(term.ranges) == 2:
            return pair_body(self.x, term, self.gather.found.limits)
        return self.gather.bodies.at_row(term)

    def check_rates(self, body: Node) -> None:
        """Raises Unrolled if a term of L contains a total with rates, which makes M dense."""
        if any(self._of_rates(int(s.name)) for s in self.below(body) if s.kind == "sum"):
            raise Unrolled("L has rates of all members inside a function: M would be dense")

    def _of_rates(self, k: int) -> bool:
        nodes = self.nodes(*nodes_of(self.all[k]))
        return any(self.g.depends[node] & BIT[Kind.RATE] for node in nodes)


def nodes_of(total: Total) -> list[Node]:
    return [total.constant, *(p.node for p in total.parts), *(p.node for p in total.pairs)]
