"""The contents of `explain`: by loops.py if families q[1..N] are loops, else by flat.py."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ..equations import Equations, ParameterSlot, Quantity
from ..graph.graph import Node
from ..middle.loops.loops import LoopEquations
from ..record import record

Shown = tuple[str, str, Node, str]  # An output: name, unit, node, range of its index.
Section = tuple[str, Iterable[str]]  # A section: title, lines.


@record(kw_only=True)
class Contents:
    e: Equations | LoopEquations
    text: Callable[[Node], str]
    freedom: str  # Numbers of degrees of freedom, rotations and first-order variables.
    declared: list[tuple[str, Sequence[Quantity]]]  # Coordinates, angular velocities, states.
    parameters: Sequence[ParameterSlot]
    equations: list[Section]
    outputs: list[Shown]  # Outputs, and quantities claimed to be constant.
    families: list[tuple[str, str]]  # Statement whether families are loops or unrolled.
    costs: Section
    record: dict[str, object]  # entries of `--json` that only loops.py or only flat.py makes


def section(title: str, lines: Iterable[str]) -> str:
    """Returns a section of the text; "" if it has no lines."""
    shown = [f"  {line}".rstrip() for line in lines]
    return "\n".join([title, *shown]) if shown else ""
