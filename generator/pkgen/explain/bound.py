"""What `explain` says of rotations and constraints: freedoms counted, rows and multipliers."""

from __future__ import annotations

from collections.abc import Iterator

from ..equations import Equations
from ..graph.graph import Node


def rates_title(e: Equations) -> str:
    """Over the rows of x' = g: "Rates of the attitudes and states"."""
    what = ["attitudes"] if e.quaternions else []
    what += ["states"] if len(e.states) > e.quaternions or not what else []
    return f"Rates of the {' and '.join(what)}"


def freedom(e: Equations) -> list[str]:
    """What moves, counted: "2 rates", "1 constraint", "1 degree of freedom"."""
    n, states = len(e.coordinates), len(e.states) - e.quaternions
    counts = []
    if e.constraints is not None:
        rows, holonomic = len(e.constraints.names), e.constraints.holonomic
        counts = [f"{n} rates"]
        counts += [f"{holonomic} constraint{'s' if holonomic != 1 else ''}"] if holonomic else []
        counts += [f"{rows - holonomic} rolling"] if rows > holonomic else []
        n -= rows
    counts += [f"{n} degree{'s' if n != 1 else ''} of freedom"] if n or not states else []
    turning = len(e.attitudes)
    counts += [f"{turning} rotation{'s' if turning != 1 else ''}"] if turning else []
    counts += [f"{states} state{'s' if states != 1 else ''}"] if states else []
    return counts


def constraint_rows(equations: Equations) -> Iterator[tuple[str, Node]]:
    """What is kept at zero, then the multipliers."""
    c = equations.constraints
    if c is None:
        return
    names = [q.name.removeprefix("lambda_") for q in c.names]
    for name, node in zip(names, (*c.positions, *c.residual[c.holonomic :]), strict=True):
        yield name, node
    for name, node in zip(names[: c.holonomic], c.residual, strict=False):
        yield f"{name}'", node
    for q, node in zip(c.names, c.multipliers, strict=True):
        yield q.name, node
