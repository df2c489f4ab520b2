"""Evaluates closed forms of the motion (`exact x = EXPR`) at many times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..front.check.scene_numbers import Values
from ..indices import assignments, indexed, integer
from ..model import Exact, Model
from ..tree import Expr, Name, replaced
from .swarm import Arrays


def closed_forms(
    model: Model, exacts: Sequence[Exact], values: Values, times: np.ndarray
) -> dict[str, np.ndarray]:
    """Returns the values of closed forms at the times, by name."""
    lets = {x.name: x for x in model.definitions if x.range is None and x.index is None}
    arrays = Arrays(values.values, "t", times)
    found = {}

    def opened(part: Expr) -> Expr | None:
        """Replaces the names of definitions that depend on t, which have no single value."""
        if isinstance(part, Name) and part.id in lets and part.id not in values.values:
            return replaced(lets[part.id].value, opened)
        return None

    for item in exacts:
        index = None if item.index is None else integer(item.index, values.sizes)
        for loop in assignments((item.range,) if item.range else (), values.sizes):
            at = loop[item.range.variable] if item.range else index
            with np.errstate(all="ignore"):
                value = arrays.value(replaced(item.value, opened), loop)
            found[indexed(item.name, at)] = np.broadcast_to(value, times.shape).copy()
    return found
