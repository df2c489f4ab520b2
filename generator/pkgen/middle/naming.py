"""Returns the names of symbols, for messages and output."""

from __future__ import annotations

from collections.abc import Callable

from ..equations import Equations, Named
from ..graph.graph import Kind, Symbol


def naming(e: Named | Equations) -> Callable[[Symbol], str]:
    rows = {
        Kind.PARAMETER: [slot.quantity for slot in e.parameters],
        Kind.COORDINATE: e.coordinates,
        Kind.RATE: e.rates,
        Kind.STATE: e.states,
        Kind.INPUT: e.inputs,
        Kind.MOMENTUM: e.momenta_names,
    }

    def name(symbol: Symbol) -> str:
        if symbol.kind is Kind.TIME:
            return "t"
        row = rows[symbol.kind]
        # the time derivative of an input, if it has no name of its own in `row`
        if symbol.index >= len(row):
            return name(Symbol(symbol.kind, symbol.index - len(row))) + "'"
        return row[symbol.index].name

    return name
