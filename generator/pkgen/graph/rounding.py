"""First-order bounds of the rounding errors of expressions, here called sizes, in units of the
machine epsilon.

They show whether a sum that should vanish differs from 0 by more than rounding. A symbol x,
rounded to half a unit in the last place, has the size |x|. Sizes propagate like errors:

    size(a + b) = size(a) + size(b)
    size(a b) = |a| size(b) + |b| size(a)
    size(f(a)) = |f'(a)| size(a) + |f(a)|

This running error bound includes the rounding of symbols, constants and function calls, but not
that of + and *. A constant expression counts as a symbol: it has the same rounding error at every
evaluation.
Reference: N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, section 3.3.
"""

from __future__ import annotations

from collections.abc import Iterable

from .differentiate import partials, reachable
from .graph import VARIABLE, ZERO, Graph, Node, Op


def sizes(g: Graph, nodes: Iterable[Node]) -> tuple[Node, ...]:
    """Returns the sizes (error bounds) of the nodes, as nonnegative nodes of the same graph."""
    nodes = tuple(nodes)
    known: dict[Node, Node] = {}

    def of(node: Node) -> Node:
        return known[node] if g.depends[node] & VARIABLE else _absolute(g, node)

    for node in reachable(g, nodes, VARIABLE):
        op, args = g.op[node], g.args[node]
        if op is Op.SYMBOL:
            known[node] = _absolute(g, node)
            continue
        own = _absolute(g, node) if op is Op.CALL else ZERO
        parts = (
            g.multiply(_absolute(g, d), of(a))
            for d, a in zip(partials(g, node), args, strict=True)
            if op is Op.ADD or g.depends[a] & VARIABLE
        )
        known[node] = g.sum((own, *parts))
    return tuple(map(of, nodes))


def _absolute(g: Graph, node: Node) -> Node:
    """Returns |node| as the product of the absolute values of its factors, so that products with
    common factors share these."""
    return g.product(_of_factor(g, base, exponent) for base, exponent in g.factors(node))


def _of_factor(g: Graph, base: Node, exponent) -> Node:
    value = g.value(base)
    if value is not None:
        return g.power(g.number(abs(value)), exponent)
    if exponent % 2 == 0:
        return g.power(base, exponent)
    return g.power(g.call("abs", base), exponent)
