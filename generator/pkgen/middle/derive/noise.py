"""Derives the accelerations by white noises, the random forces of `noise` statements.

A noise at a point is three noises, along x, y and z; the generalized forces of a unit force along
an axis are the derivatives of that component of the point's velocity by the rates. A noise changes
the rates alone, and M and the directions have no rates in them, so the integrals of Ito and
Stratonovich agree. Reference: G. A. Pavliotis, Stochastic Processes and Applications, Springer
2014, sections 3.2 and 6.1.
"""

from __future__ import annotations

from ... import model
from ...equations import Noise, Row
from ...graph.differentiate import gradient
from ...graph.graph import ONE, ZERO
from ...graph.solve import solve
from ..expand.expand import Expander
from ..expand.names import Loop
from ..motion import RATES
from ..quantities import error, indexed
from .lagrange import Derived


def noise_of(x: Expander, found: Derived) -> Noise | None:
    """Returns the noises of the model. Raises ModelError for one that no method takes."""
    names, intensities, accelerations = [], [], []
    for item in x.model.noises:
        if found.constraints is not None:
            message = "a noise acts on what constraints hold, and no method keeps both"
            raise error(x.model, message, item.span, "choose coordinates without constraints")
        for index, loop in x.unrolled(item.index, item.range):
            with x.statement(item.span):
                values, directions = x.value(item.value, loop), _directions(x, item, index, loop)
                values = values if isinstance(values, tuple) else (values,)
            label = indexed(item.label, index)
            axes = [f"{label}.{axis}" for axis in "xyz"] if item.velocity else [label]
            for name, value, direction in zip(axes, values, directions, strict=True):
                if value == ZERO or set(direction) == {ZERO}:
                    continue
                solution = solve(x.graph, found.motion.mass, direction)
                if solution is None or _of_rates(x, solution.accelerations):
                    message = "a noise needs an M of few coupled coordinates, without rates in it"
                    raise error(x.model, message, item.span)
                names.append(name)
                intensities.append(value)
                accelerations.append(solution.accelerations)
    return Noise(tuple(names), tuple(intensities), tuple(accelerations)) if names else None


def _directions(x: Expander, item: model.Noise, index: int | None, loop: Loop) -> list[Row]:
    """Returns the generalized forces of a unit force, or of unit forces along x, y and z."""
    if item.velocity is None:
        place = x.coordinates[item.name].flat(index)
        return [tuple(ONE if i == place else ZERO for i in range(x.count))]
    g, found = x.graph, []
    for along in x.value(item.velocity, loop):
        slopes = {g.data[rate].index: node for rate, node in gradient(g, along, RATES).items()}
        found.append(tuple(slopes.get(i, ZERO) for i in range(x.count)))
    return found


def _of_rates(x: Expander, row: Row) -> bool:
    return any(x.graph.depends[node] & RATES for node in row)
