"""Jacobians by the state, time, inputs and parameters; each is made only if asked for by name.

The name is ROWS_SYMBOLS. The rows are those of _rows(); the symbols are x = (q, v), the inputs u,
the parameters p, or d = (x, t, u, p). Parameters count as independent, even if the default value of
one is a formula of others; the rows `default` are these formulas. `adjoint` has one row, mu.r_d by
a reverse sweep; mu follows a in the argument a.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...equations import Equations, Matrix, Row
from ...graph.collect import shortened
from ...graph.differentiate import gradient
from ...graph.graph import BIT, ZERO, Kind
from ..motion import STATE, TIME, Wanted, matrix, residual
from ..quantities import symbols

ADJOINT = "adjoint"
MOVING = ("r_u", "r_p", ADJOINT)  # these take an acceleration a
# The kernels, with their rows and columns in words. Each parameter counts for itself.
JACOBIANS = {
    "r_u": "of r = f - M a by the inputs, at constant a: M da/du = r_u",
    "r_p": "of r = f - M a by the parameters, at constant a: M da/dp = r_p",
    "out_x": "of the outputs by q, then by v",
    "out_u": "of the outputs by the inputs",
    "out_p": "of the outputs by the parameters",
    "out_d": "of the outputs by q, v, t, the inputs, the parameters",
    "energy_d": "of the energy by q, v, t, the inputs, the parameters",
    "event_d": "of the functions of events by q, v, t, the inputs, the parameters",
    "switch_d": "of the functions of switches by q, v, t, the inputs, the parameters",
    "start_p": "of the start values of q and v by the parameters",
    "default_p": "of the default values of parameters by the parameters",
    "canonical_d": "of p and pdot by q, v, t, the inputs, the parameters",
    ADJOINT: "of mu.(f - M a) by q, v, t, the inputs, the parameters; mu follows a in a",
}


def _rows(e: Equations, name: str) -> Row:
    """Returns the rows: r = f - M a with a held, the outputs, p and
    pdot, ..."""
    of = {
        "r": lambda: residual(e.graph, e.force, e.mass),
        "out": lambda: e.observed,
        "energy": lambda: () if e.energy is None else (e.energy,),
        "event": lambda: e.events,
        "switch": lambda: tuple(x.node for x in e.switches),
        "start": lambda: (*e.start_q, *e.start_v),
        "default": lambda: tuple(x.default for x in e.parameters),
        "canonical": lambda: (*e.momenta, *e.pdot),
    }
    return of[name]() or ()


def sensitivity_of(e: Equations, wanted: Wanted) -> Mapping[str, Matrix]:
    """Returns the Jacobians that are asked for, of equations without states (states.as_rates)."""
    g, n, found = e.graph, len(e.force), {}
    by = {
        "x": (symbols(g, Kind.COORDINATE, n) + symbols(g, Kind.RATE, n), STATE),
        "t": (symbols(g, Kind.TIME, 1), TIME),
        "u": (symbols(g, Kind.INPUT, len(e.inputs)), BIT[Kind.INPUT]),
        "p": (symbols(g, Kind.PARAMETER, len(e.parameters)), BIT[Kind.PARAMETER]),
    }
    by["d"] = sum((x for x, _ in by.values()), ()), sum(mask for _, mask in by.values())
    for name in filter(wanted.named, JACOBIANS):
        of, _, letter = name.partition("_")
        symbol, mask = by[letter or "d"]
        if name == ADJOINT:
            mu = symbols(g, Kind.ACCELERATION, 2 * n)[n:]
            slope = gradient(g, g.dot(mu, _rows(e, "r")), mask)
            made = (tuple(slope.get(x, ZERO) for x in symbol),)
        else:
            made = matrix(g, _rows(e, of), symbol, mask)
        if made and symbol:
            entries = iter(shortened(g, (entry for row in made for entry in row)))
            found[name] = tuple(tuple(next(entries) for _ in row) for row in made)
    return found
