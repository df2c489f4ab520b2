"""Expands the values after events: `event NAME: … then a = EXPR`."""

from __future__ import annotations

from collections.abc import Callable

from ...equations import Row
from ...graph.graph import Kind, Node
from ...indices import of_made
from ..expand.expand import Expander
from ..quantities import error, input_index, input_quantities, symbols


def resets_of(x: Expander, solved: Callable[..., Node]) -> tuple[Row, ...]:
    """Returns for each event with values after it the new values of all coordinates, rates, states
    and inputs, as functions of those before. `solved(node, span=...)` replaces accelerations by
    their expressions."""
    return tuple(_reset(x, event.then, solved) for event in x.model.events if event.then)


def _reset(x: Expander, then: tuple, solved: Callable[..., Node]) -> Row:
    g, n, states = x.graph, x.count, x.state_count
    inputs = len(input_quantities(x.model, x.orders))
    kinds = (Kind.COORDINATE, n), (Kind.RATE, n), (Kind.STATE, states), (Kind.INPUT, inputs)
    values = [symbol for kind, count in kinds for symbol in symbols(g, kind, count)]
    for item, index, value in x.members_of(then):
        with x.statement(item.span):
            node = solved(value, span=item.span)
        if item.name in x.inputs:
            values[2 * n + states + input_index(x.orders, x.inputs[item.name])] = node
            continue
        is_state = item.name in x.states
        family = (x.states if is_state else x.coordinates).get(item.name)
        if family is None:
            help = "with energies in place of a Hamiltonian, rates are given"
            message = f"an event gives no momentum '{of_made('', item.name) or item.name}'"
            raise error(x.model, message, item.span, help)
        if not family.has(index):
            raise error(x.model, f"'{item.name}[{index}]' does not move", item.span)
        values[2 * n * is_state + n * item.order + family.flat(index)] = node
    return tuple(values)
