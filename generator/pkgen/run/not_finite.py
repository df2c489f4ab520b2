"""Finds a constant of a model that is not finite for a run's parameters, such as 1/m for m = 0."""

from __future__ import annotations

import math

from ..compiler import Compilation
from ..graph.evaluate import evaluate, value_of
from ..graph.graph import VARIABLE, Kind, Op, Symbol
from ..graph.wording import wording


def constant(compilation: Compilation, given: dict[int, float]) -> str:
    """Returns a message that names the first constant that is not finite, and the parameters on
    which it depends; "" if all constants are finite."""
    e = compilation.equations
    g, slots, values = e.graph, e.parameters, {}

    def quantity(symbol: Symbol) -> str:
        return slots[symbol.index].quantity.name

    known: dict[int, float] = {}
    below: dict[int, frozenset[int]] = {}
    for index, slot in enumerate(slots):  # in order: a default may use earlier parameters
        values[Symbol(Kind.PARAMETER, index)] = given.get(index, 0.0)
        if index not in given:
            (values[Symbol(Kind.PARAMETER, index)],) = evaluate(g, [slot.default], values)
    for node in range(len(g)):
        if g.depends[node] & VARIABLE:
            continue
        known[node] = value_of(g, node, [known[a] for a in g.args[node]], values)
        below[node] = frozenset().union(*(below[a] for a in g.args[node]))
        if g.op[node] is Op.SYMBOL and g.data[node].kind is Kind.PARAMETER:
            below[node] = frozenset((g.data[node].index,))
        if not math.isfinite(known[node]) and below[node]:
            at = ", ".join(
                f"{slots[i].quantity.name} = {values[Symbol(Kind.PARAMETER, i)]:.12g}"
                + (f" [{slots[i].quantity.unit}]" if slots[i].quantity.unit else "")
                for i in sorted(below[node])
            )
            return f"{wording(g, node, quantity)} is not finite at {at}"
    return ""
