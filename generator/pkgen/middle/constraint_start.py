"""Whether a model starts where its constraints hold, and whether there they say more than one
another.

The numbers are those of the model's own starts and defaults; what options give is checked by the
runtime (src/project.c). With an input nobody knows what holds before it is given.
"""

from __future__ import annotations

import math

from ..equations import ParameterSlot, Row
from ..source import Diagnostic
from .constrain import Rows
from .differentiate import gradient
from .evaluate import evaluate
from .graph import BIT, ZERO, Graph, Kind, Node, Symbol
from .guards import summands
from .samples import defaults

ALLOWED = 1e-9  # of the largest term: starts are written with as many digits as their author has
DEPENDENT = 1e-9  # what is left of a row without its parts along others, beside the row


def wrong_starts(
    g: Graph, c: Rows | None, parameters: tuple[ParameterSlot, ...], starts: tuple[Row, Row, Row]
) -> list[Diagnostic]:
    """Each constraint that the start breaks; if none, the first that others make superfluous.
    `starts` are of coordinates, their rates, and states."""
    if c is None or any(g.depends[node] & BIT[Kind.INPUT] for node in (*c.positions, *c.residual)):
        return []
    values = _start(g, parameters, starts)
    broken = [
        _broken(c, k, *found)
        for k in range(len(c.names))
        if (found := _residual(g, c, k, values)) is not None
    ]
    dependent = _dependent(g, c, values)
    if dependent is None:
        return broken
    k, others = dependent
    names = " and ".join(f"'{_name(c, i)}'" for i in others) or "nothing"
    if broken:
        message = f"'{_name(c, k)}' contradicts {names}: they leave the same rates no freedom"
        return [*broken, Diagnostic(f"the {_kind(c, k)} {message}", c.spans[k], "leave one out")]
    if not others:
        message = f"the {_kind(c, k)} '{_name(c, k)}' has no force at the start: its row is 0 there"
        return [Diagnostic(message, c.spans[k], "start elsewhere, or write it another way")]
    message = f"the {_kind(c, k)} '{_name(c, k)}' follows from {names} at the start: redundant"
    help = "leave it out: of forces that do the same, none is determined"
    return [Diagnostic(message, c.spans[k], help)]


def _start(
    g: Graph, parameters: tuple[ParameterSlot, ...], starts: tuple[Row, Row, Row]
) -> dict[Symbol, float]:
    values = defaults(g, parameters)
    kinds = (Kind.COORDINATE, Kind.RATE, Kind.STATE)
    found = {
        Symbol(kind, i): x
        for kind, row in zip(kinds, starts, strict=True)
        for i, x in enumerate(evaluate(g, row, values))
    }
    return values | found | {Symbol(Kind.TIME): 0.0}


def _residual(g: Graph, c: Rows, k: int, values: dict[Symbol, float]) -> tuple[float, bool] | None:
    """What is not 0, and whether it is of rates."""
    nodes = [(c.residual[k], True)]
    if k < c.holonomic:
        nodes.insert(0, (c.positions[k], False))
    for node, of_rates in nodes:
        found, allowed = _sum(g, node, values)
        if not abs(found) <= allowed:
            return found, of_rates
    return None


def _sum(g: Graph, node: Node, values: dict[Symbol, float]) -> tuple[float, float]:
    """The value, and how far from 0 rounding may take it: a part of the largest term."""
    total, *terms = evaluate(g, [node, *summands(g, node)], values)
    return total, ALLOWED * max(map(abs, terms))


def _broken(c: Rows, k: int, found: float, of_rates: bool) -> Diagnostic:
    name, kind = _name(c, k), _kind(c, k)
    what = "its rate is" if of_rates and k < c.holonomic else "left minus right is"
    return Diagnostic(
        f"the start breaks the {kind} '{name}': {what} {found:.6g}, not 0",
        c.spans[k],
        "start rates along it" if of_rates else "start where it holds",
    )


def _dependent(g: Graph, c: Rows, values: dict[Symbol, float]) -> tuple[int, list[int]] | None:
    """The first row that others before it make, and which; by Gram-Schmidt with each row's own
    combination of those before."""
    basis: list[tuple[list[float], dict[int, float]]] = []
    by = [gradient(g, node, BIT[Kind.RATE]) for node in c.residual]
    rates = sorted(set().union(*by))
    for k, row in enumerate(by):
        left, made = evaluate(g, [row.get(rate, ZERO) for rate in rates], values), {k: 1.0}
        size = math.hypot(*left)
        if not math.isfinite(size):
            return None
        for _ in range(2):  # twice is enough: Kahan and Parlett
            for other, of in basis:
                along = math.fsum(a * b for a, b in zip(left, other, strict=True))
                left = [a - along * b for a, b in zip(left, other, strict=True)]
                for i, x in of.items():
                    made[i] = made.get(i, 0.0) - along * x
        rest = math.hypot(*left)
        if rest <= DEPENDENT * size:
            largest = max((abs(x) for i, x in made.items() if i != k), default=0.0)
            return k, [i for i in sorted(made) if i != k and abs(made[i]) > DEPENDENT * largest]
        basis.append(([a / rest for a in left], {i: x / rest for i, x in made.items()}))
    return None


def _name(c: Rows, k: int) -> str:
    return c.names[k].name.removeprefix("lambda_")


def _kind(c: Rows, k: int) -> str:
    return "constraint" if k < c.holonomic else "rolling"
