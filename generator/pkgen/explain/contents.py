"""The contents of `explain`, for models whose families are loops (loops.py) or unrolled
(flat.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ..equations import Equations, ParameterSlot, Quantity
from ..graph.graph import Node
from ..middle.loops.loops import LoopEquations
from ..record import record

Shown = tuple[str, str, Node, str]  # a name, its unit, its node, its index range
Section = tuple[str, Iterable[str]]  # its title, its lines


@record(kw_only=True)
class Contents:
    e: Equations | LoopEquations
    text: Callable[[Node], str]
    freedom: str  # counts of degrees of freedom, rotations and states
    declared: list[tuple[str, Sequence[Quantity]]]  # coordinates, body rates, states, by kind
    parameters: Sequence[ParameterSlot]
    equations: list[Section]
    outputs: list[Shown]  # with the quantities claimed to be constant
    families: list[tuple[str, str]]  # facts on families: loops or unrolled
    costs: Section
    record: dict[str, object]  # the entries of `--json` that depend on this kind of model


def section(title: str, lines: Iterable[str]) -> str:
    """Returns a section of the text, "" if it has no lines."""
    shown = [f"  {line}".rstrip() for line in lines]
    return "\n".join([title, *shown]) if shown else ""
