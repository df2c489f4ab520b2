"""Policies of expansion: each function returns the sums that normal forms leave unexpanded."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from .differentiate import reachable, swept
from .graph import BIT, CONSTANT, ONE, VARIABLE, Graph, Kind, Node, Op

Policy = Callable[[Graph, Iterable[Node]], frozenset[Node]]


def shared(g: Graph, outputs: Iterable[Node]) -> frozenset[Node]:
    """Returns the sums used more than once, so that common subexpressions are kept, and sums raised
    to a power."""
    outputs = list(outputs)
    order = reachable(g, outputs)
    uses = dict.fromkeys(order, 0)
    for node in outputs:
        uses[node] += 1
    for node in order:
        for a in g.args[node]:
            uses[a] += 1
    # A use of the product scale * sum counts as a use of the sum.
    for node in reversed(order):
        rest = g.split(node)[1]
        if rest not in (node, ONE) and uses[node] > 1:
            uses[rest] += uses[node] - 1
    closed = {n for n in order if g.op[n] is Op.ADD and uses[n] > 1 and g.depends[n] & VARIABLE}
    return frozenset(closed | _squared(g, order))


def shifts(g: Graph, outputs: Iterable[Node]) -> frozenset[Node]:
    """Returns sums of parameters and coordinates without function calls, such as l0 + s, and sums
    raised to a power."""
    order = reachable(g, outputs)
    closed = _squared(g, order)

    def plain(node: Node, args: list[bool]) -> bool:
        still = not g.depends[node] & ~(CONSTANT | BIT[Kind.COORDINATE])
        return still and g.op[node] is not Op.CALL and all(args)

    return frozenset(closed | _sums(g, order, swept(g, order, plain)))


def linear(g: Graph, outputs: Iterable[Node]) -> frozenset[Node]:
    """Returns linear combinations of symbols, such as q_2 - q_1, and sums raised to a power. If
    they were expanded, nearly equal terms would cancel, with a loss of digits."""
    order = reachable(g, outputs)
    plain: dict[Node, bool] = {}
    for node in order:
        rest = g.split(node)[1]
        if rest not in (node, ONE):
            plain[node] = plain[rest]
        elif g.op[node] is Op.ADD:
            plain[node] = all(plain[a] for a in g.args[node])
        else:
            plain[node] = g.op[node] is Op.SYMBOL or not g.depends[node] & VARIABLE
    return frozenset(_squared(g, order) | _sums(g, order, plain.values()))


def _sums(g: Graph, order: list[Node], plain: Iterable[bool]) -> set[Node]:
    """Returns the sums among the nodes of `order` that depend on variables, and whose element of
    `plain` is true."""
    found = (node for node, is_plain in zip(order, plain, strict=True) if is_plain)
    return {n for n in found if g.op[n] is Op.ADD and g.depends[n] & VARIABLE}


def _squared(g: Graph, order: list[Node]) -> set[Node]:
    """Returns sums without rates that are bases of powers. If expanded, (a - b)^2 would lose digits
    where a is near b."""
    found = set()
    for node in order:
        if g.op[node] is Op.POWER and not g.depends[node] & BIT[Kind.RATE]:
            base = g.args[node][0]
            if g.op[base] is Op.ADD:
                found.add(base)
    return found
