"""Counts the run-time operations that compute a set of expressions."""

from __future__ import annotations

from collections.abc import Iterable

from .differentiate import reachable
from .graph import MINUS_ONE, VARIABLE, Graph, Node, Op


def operations(g: Graph, outputs: Iterable[Node]) -> int:
    """Returns the number of additions, subtractions, multiplications, divisions and function calls.

    A shared node counts once. Expressions of parameters alone do not count: they are computed once
    per run. A sign in front of a term of a sum does not count. An inverse whose only use is in one
    product does not count: the product is a division.
    """
    outputs = [n for n in outputs if g.depends[n] & VARIABLE]
    order = reachable(g, outputs, VARIABLE)
    total = 0
    # For each negation -x, whether it is an argument of a node other than a sum.
    signs: dict[Node, bool] = {}
    # For each inverse 1/x, the operations of the nodes that have it as an argument.
    inverses: dict[Node, list[str | None]] = {}
    for node in order:
        op = g.op[node]
        if op is Op.SYMBOL:
            continue
        if op is Op.MULTIPLY and g.args[node][0] == MINUS_ONE:
            signs[node] = False
        elif op is Op.POWER:
            exponent = g.data[node]
            if exponent == -1:
                inverses[node] = []
            elif exponent.denominator != 1:
                total += 1
            else:
                n = abs(int(exponent))
                total += n.bit_length() + n.bit_count() - 2 + (exponent < 0)
        else:
            total += 1
    users = [(g.op[node], g.args[node]) for node in order] if signs or inverses else []
    users += [(None, outputs)]
    for op, used in users:
        for a in used:
            if a in signs and op is not Op.ADD:
                signs[a] = True
            elif a in inverses:
                inverses[a].append(op)
    return total + sum(signs.values()) + sum(x != [Op.MULTIPLY] for x in inverses.values())
