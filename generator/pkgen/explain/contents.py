"""What `explain` shows of equations, as text and as HTML: what is declared, and named expressions.

Rows are names with their nodes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..equations import Equations, Quantity
from ..graph.graph import ZERO, Node

Rows = list[tuple[str, Node]]


def section(title: str, lines: Iterable[str]) -> str:
    """A section of the text; none where there is nothing in it."""
    shown = [f"  {line}".rstrip() for line in lines]
    return "\n".join([title, *shown]) if shown else ""


def declared(e: Equations) -> list[tuple[str, tuple[Quantity, ...]]]:
    """What moves, by kind."""
    return [
        ("Coordinates", e.seen),
        ("Body rates", e.rates[len(e.seen) :]),
        ("Attitudes", e.states[: e.quaternions]),
        ("States", e.states[e.quaternions :]),
    ]


def lagrangian_rows(e: Equations) -> Rows:
    if not e.coordinates:
        return []
    both = e.kinetic is not None and e.potential is not None
    return [("L", e.lagrangian), *([("T", e.kinetic), ("V", e.potential)] if both else [])]


def free_force(e: Equations) -> tuple[Node, ...]:
    """The forces but for those of constraints."""
    return e.force if e.constraints is None else e.constraints.free_force


def motion_rows(e: Equations) -> Rows:
    """The lower triangle of M, and f."""
    names = e.moving
    rows = [
        (f"M[{names[i]}, {names[j]}]", row[j])
        for i, row in enumerate(e.mass)
        for j in range(i + 1)
        if row[j] != ZERO
    ]
    return rows + [(f"f[{x}]", node) for x, node in zip(names, free_force(e), strict=True)]


def rate_rows(e: Equations) -> Rows:
    return [(f"{q.name}'", node) for q, node in zip(e.states, e.state_rates, strict=True)]


def canonical_rows(e: Equations) -> Rows:
    """H(q, p) and its gradients, if they were asked for."""
    h = e.hamiltonian
    if h is None:
        return []
    gradients = zip((*e.coordinates, *e.momenta_names), (*h.by_q, *h.by_p), strict=True)
    return [("H", h.energy), *((f"dH/d({q.name})", node) for q, node in gradients)]


def outputs(e: Equations) -> list[tuple[Quantity, Node]]:
    named = (*e.observed_names, *e.conserved_names)
    return list(zip(named, (*e.observed, *e.conserved), strict=True))


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
        more = len(e.constraints.redundant_rows)
        counts += [f"{more} redundant row{'s' if more != 1 else ''}"] if more else []
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


def redundant_names(equations: Equations) -> list[str]:
    c = equations.constraints
    names = c.redundant.names if c is not None and c.redundant else ()
    return [q.name.removeprefix("lambda_") for q in names]
