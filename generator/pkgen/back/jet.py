"""The kernel `jet` of Taylor coefficients: the models that have one, and its description."""

from __future__ import annotations

from ..equations import Equations
from ..graph.differentiate import reachable
from ..graph.graph import VARIABLE, Node, Op

SAYS = (
    "Writes the coefficients of the Taylor series of q and v in the time since t: those of order "
    "k, of all q, then of all v, behind those of order k - 1; k = 0 .. order <= 30. Returns 0, or "
    "a failure as NAME_acceleration does; 1 if the order is too large"
)
# The functions whose series back/c/jets.py writes.
SERIES = frozenset(
    ["sin", "cos", "tan", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "pow", "reciprocal"]
)
WITHOUT = (
    "Taylor coefficients are not written of a model with constraints, inputs, rotations or changes "
    f"at events, nor with functions other than {', '.join(sorted(SERIES - {'reciprocal'}))}"
)


def rows(e: Equations) -> list[Node] | None:
    """Returns the nodes of M, row by row, and of f; None if the model has no jet: with constraints,
    inputs, rotations, changes at events, or functions outside SERIES."""
    g, found = e.graph, [*sum(e.mass, ()), *e.force]
    calls = {g.data[n] for n in reachable(g, found, VARIABLE) if g.op[n] is Op.CALL}
    if e.constraints or e.inputs or e.attitudes or e.model.struck or calls - SERIES:
        return None
    return found
