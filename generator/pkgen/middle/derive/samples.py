"""Expands sample blocks: the values that a block gives to all inputs, its memory cells among them,
as functions of the state and of the values until then."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from ...equations import Row
from ...graph.graph import ZERO, Node
from ...model import Sample
from ...source import Span
from ..expand.expand import Expander
from ..expand.names import Value
from ..quantities import input_index


def sampled(x: Expander, solved: Callable[..., Node]) -> dict[str, Row]:
    """Returns the fields of Equations for sample blocks. `solved(node, span=...)` replaces
    accelerations by their expressions. To be called after the outputs are defined."""
    blocks, inputs = x.model.samples, x.model.inputs
    if not blocks:
        return dict.fromkeys(("sampled", "sample_times", "held_start"), ())
    times = [t for b in blocks for t in (b.every, b.offset)]
    start = [*x.input_nodes()]
    for k, item in enumerate(inputs):
        if item.by:
            begins = ZERO if item.start is None else x.scalar(item.start)
            start[input_index(x.orders, k)] = begins
    return {
        "sampled": tuple(node for b in blocks for node in _next(x, b, solved)),
        "sample_times": tuple(ZERO if t is None else x.scalar(t) for t in times),
        "held_start": tuple(start),
    }


def _next(x: Expander, block: Sample, solved: Callable[..., Node]) -> list[Node]:
    """Returns the next values of all inputs. An input with a delay takes the first of the values in
    waiting; in the block, its name is the value that was set last."""
    before = x.input_nodes()
    values = [*before]
    place = {name: input_index(x.orders, k) for name, k in x.inputs.items()}
    queues = {
        item.name: [place[f"{item.name}.{k + 1}"] for k in range(block.delay)]
        for item in x.model.inputs
        if item.by == block.name and f"{item.name}.1" in place
    }
    x.assigned = {name: before[queue[-1]] for name, queue in queues.items()}
    for step in block.steps:
        with x.statement(step.span):
            found = x.value(step.value, x.sizes)
            x.assigned[step.name] = _each(found, solved, step.span)
    own = {item.name for item in x.model.inputs if item.by == block.name}
    for name in own & x.assigned.keys():
        queue = [place[name], *queues.get(name, ())]
        for k, after in pairwise(queue):
            values[k] = before[after]
        values[queue[-1]] = x.assigned[name]
    x.assigned = {}
    return values


def _each(value: Value, solved: Callable[..., Node], span: Span) -> Value:
    if isinstance(value, tuple):
        return tuple(solved(node, span=span) for node in value)
    return solved(value, span=span)
