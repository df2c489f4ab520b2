"""The kernel `jet` of Taylor coefficients: the models that have one, and its description."""

from __future__ import annotations

from ..equations import Equations
from ..functions import FUNCTIONS
from ..graph.graph import Node
from ..middle.analyze.analyze import has_series

SAYS = (
    "Writes the coefficients of the Taylor series of q and v in the time since t: those of order "
    "k, of all q, then of all v, behind those of order k - 1; k = 0 .. order <= 30. Returns 0, or "
    "a failure as NAME_acceleration does; 1 if the order is too large"
)
WITHOUT = (
    "Taylor coefficients are not written of a model with constraints, contacts, inputs or noise, "
    "nor with functions other than "
    f"{', '.join(name for name, row in FUNCTIONS.items() if row.series and not row.internal)}"
)


def rows(e: Equations) -> list[Node] | None:
    """Returns the nodes of M, row by row, and of f; None if the model has no jet."""
    return [*sum(e.mass, ()), *e.force] if has_series(e) else None
