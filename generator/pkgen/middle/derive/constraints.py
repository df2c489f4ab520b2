"""Expands the statements `constraint` and `rolling` into constraint rows."""

from __future__ import annotations

from ...equations import Constraints, Quantity, Rows
from ...graph.graph import BIT, Kind
from ...graph.normal import Normal
from ...indices import multiplied, multipliers, parted
from ...source import Diagnostic, ModelError
from ...tree import Expr, names
from ..expand.expand import Expander
from ..quantities import error, indexed
from .constrain import CannotConstrain

MOVES = BIT[Kind.COORDINATE] | BIT[Kind.RATE] | BIT[Kind.STATE]


def rows_of(x: Expander) -> tuple[Rows | None, tuple[Diagnostic, ...]]:
    """Returns the constraint rows and warnings. Rows of holonomic constraints come first; both
    kinds are in the order of declaration. A row that is identically 0 is left out with a
    warning."""
    found: dict[bool, list[tuple]] = {True: [], False: []}
    normal, vanished = Normal(x.graph), []
    for item in x.model.constraints:
        with x.statement(item.span):
            for index, loop in x.unrolled(item.index, item.range):
                node = x.scalar(item.value, loop)
                name = indexed(item.name, index)
                moves = x.graph.depends[node] & MOVES
                if normal(node) == {} and (moves or "." in name):
                    kind = "constraint" if item.holonomic else "rolling"
                    message = f"the {kind} '{name}' is 0 = 0 at every motion: it is left out"
                    vanished.append(Diagnostic(message, item.span, severity="warning"))
                    continue
                if not moves:
                    held = names(item.value) and not _of_the_free(x, item.value)
                    if held and normal(node) == {}:
                        # the scene holds all coordinates in the constraint, and their motion
                        # satisfies it
                        continue
                    message = f"the constraint '{name}' holds or fails whatever the motion"
                    help = (
                        "state its other components one by one" if "." in name else "leave it out"
                    )
                    help = "hold what it ties as it says" if held else help
                    raise error(x.model, message, item.span, help)
                rate = x.derivative(node) if item.holonomic else node
                quantity = Quantity(multipliers(name)[0], item.unit, item.description)
                found[item.holonomic].append((quantity, node, rate, item.span))
    rows = [*found[True], *found[False]]
    if not rows:
        return None, tuple(vanished)
    quantities, nodes, rates, spans = zip(*rows, strict=True)
    holonomic = len(found[True])
    return Rows(quantities, holonomic, nodes[:holonomic], rates, spans), tuple(vanished)


def _of_the_free(x: Expander, value: Expr) -> bool:
    """Whether an expression contains a coordinate or state, directly or through definitions."""
    definitions = {item.name: item.value for item in x.model.definitions}
    seen, waiting = set(), set(names(value))
    while waiting:
        name = waiting.pop()
        seen.add(name)
        if name in definitions:
            waiting |= names(definitions[name]) - seen
    return bool(seen & (x.coordinates.keys() | x.states.keys()))


def cannot_constrain(x: Expander, rows: Rows, wrong: CannotConstrain) -> ModelError:
    """Returns the error message for `wrong`, with the name and span of the row at fault. If no
    single row is at fault, the span is that of the first row."""
    if wrong.row is None:
        return error(x.model, wrong.message, rows.spans[0], wrong.help)
    message = f"the {rows.statement(wrong.row)} {wrong.message}"
    return error(x.model, message, rows.spans[wrong.row], wrong.help)


def define_multipliers(x: Expander, constraints: Constraints | None) -> None:
    """Defines names of multipliers, for outputs and events. A unique multiplier gets the names
    lambda_NAME and least_lambda_NAME. A multiplier that is not unique only gets the latter name,
    for its value in the solution of least norm. A constraint that is left out because the scene
    holds its coordinates gets neither name."""
    c = constraints
    if c is None:
        return
    names = (*c.names, *(c.redundant.names if c.redundant else ()))
    least = {q.name: node for q, node in zip(names, c.least, strict=False)}
    own = {
        q.name: node
        for k, (q, node) in enumerate(zip(c.names, c.multipliers, strict=True))
        if k not in c.shared
    }
    for item in (*x.model.contacts, *x.model.frictions):
        name = multipliers(item.name)[0]
        x.define(*parted(name), own[name])
    because = " and ".join(multiplied(q.name) for q in names[len(c.names) :])
    for item in x.model.constraints:
        for index, _ in x.unrolled(item.index, item.range):
            name, least_name = multipliers(item.name)
            full = indexed(name, index)
            if full in least:
                x.define(least_name, index, least[full])
            if full in own:
                x.define(name, index, own[full])
            elif any(q.name == full for q in names):
                x.refuse(
                    name,
                    index,
                    f"'{full}' is not unique: what other constraints say makes {because} follow",
                    f"least_{full} is that of least norm, of forces that do the same",
                )
