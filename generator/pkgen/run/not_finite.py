"""Finds a constant of a model that is not finite for a run's parameters, such as 1/m for m = 0."""

from __future__ import annotations

import math

from ..compiler import Compilation
from ..graph.differentiate import symbols_in
from ..graph.evaluate import evaluate, value_of
from ..graph.graph import VARIABLE, Kind, Symbol
from ..graph.wording import wording


def constant(compilation: Compilation, given: dict[int, float]) -> str:
    """Returns a message that names the first constant that is not finite, and the parameters on
    which it depends; "" if all constants are finite."""
    e = compilation.equations
    g, slots, values = e.graph, e.parameters, {}

    def quantity(symbol: Symbol) -> str:
        return slots[symbol.index].quantity.name

    def written(symbol: Symbol) -> str:
        unit = slots[symbol.index].quantity.unit
        return f"{quantity(symbol)} = {values[symbol]:.12g}" + (f" [{unit}]" if unit else "")

    for index, slot in enumerate(slots):  # in order: a default may use earlier parameters
        (default,) = evaluate(g, [slot.default], values) if index not in given else (0.0,)
        values[Symbol(Kind.PARAMETER, index)] = given.get(index, default)
    known: dict[int, float] = {}
    for node in range(len(g)):
        if g.depends[node] & VARIABLE:
            continue
        known[node] = value_of(g, node, [known[a] for a in g.args[node]], values)
        of = () if math.isfinite(known[node]) else symbols_in(g, [node])
        if at := ", ".join(written(symbol) for symbol in of if symbol in values):
            return f"{wording(g, node, quantity)} is not finite at {at}"
    return ""
