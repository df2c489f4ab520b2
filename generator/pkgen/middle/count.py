"""Operations that a set of outputs costs at run time."""

from __future__ import annotations

from collections.abc import Iterable

from .differentiate import reachable
from .graph import MINUS_ONE, VARIABLE, Graph, Node, Op


def operations(g: Graph, outputs: Iterable[Node]) -> int:
    """+ - * / and function calls, each shared value once, parameter expressions free.

    A sign in front of a term of a sum is free, and so is the inverse of what is divided by once.
    """
    outputs = [n for n in outputs if g.depends[n] & VARIABLE]
    order = reachable(g, outputs, VARIABLE)
    uses = dict.fromkeys(order, 0)
    for node in outputs:
        uses[node] += 2
    multiplied: dict[Node, int] = {}
    signs_needed: set[Node] = set(outputs)
    for node in order:
        for a in g.args[node]:
            if a in uses:
                uses[a] += 1
            if g.op[node] is not Op.ADD:
                signs_needed.add(a)
            if g.op[node] is Op.MULTIPLY:
                multiplied[a] = multiplied.get(a, 0) + 1
    total = 0
    for node in order:
        op = g.op[node]
        if op is Op.SYMBOL:
            continue
        if op is Op.MULTIPLY and g.args[node][0] == MINUS_ONE:
            total += node in signs_needed
        elif op is Op.POWER:
            exponent = g.data[node]
            if exponent.denominator != 1:
                total += 1
            elif exponent == -1:
                total += not (uses[node] == 1 and multiplied.get(node) == 1)
            else:
                n = abs(int(exponent))
                total += n.bit_length() + n.bit_count() - 2 + (exponent < 0)
        else:
            total += 1
    return total
