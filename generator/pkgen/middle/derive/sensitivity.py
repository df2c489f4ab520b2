"""Jacobians by inputs and parameters, and of outputs; each is made only if asked for by name.

The name is ROWS_SYMBOLS: the rows are r = f - M a with a held, or the outputs; the symbols are x =
(q, v), the inputs u, or the parameters p. Parameters count as independent, even if the default
value of one is a formula of others.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...equations import Equations, Matrix
from ...graph.collect import shortened
from ...graph.graph import BIT, Kind
from ..motion import STATE, Wanted, matrix, residual
from ..quantities import symbols

SENSITIVITIES = ("r_u", "r_p", "out_x", "out_u", "out_p")


def sensitivity_of(e: Equations, wanted: Wanted) -> Mapping[str, Matrix]:
    """Returns the Jacobians that are asked for, of equations without states (states.as_rates)."""
    g, n, found = e.graph, len(e.force), {}
    by = {
        "x": (symbols(g, Kind.COORDINATE, n) + symbols(g, Kind.RATE, n), STATE),
        "u": (symbols(g, Kind.INPUT, len(e.inputs)), BIT[Kind.INPUT]),
        "p": (symbols(g, Kind.PARAMETER, len(e.parameters)), BIT[Kind.PARAMETER]),
    }
    for name in filter(wanted.named, SENSITIVITIES):
        of, letter = name.split("_")
        rows = residual(g, e.force, e.mass) if of == "r" else e.observed
        symbol, mask = by[letter]
        if rows and symbol:
            made = matrix(g, rows, symbol, mask)
            entries = iter(shortened(g, (entry for row in made for entry in row)))
            found[name] = tuple(tuple(next(entries) for _ in row) for row in made)
    return found
