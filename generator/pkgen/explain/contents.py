"""What `explain` shows of a model, whether its families are loops (loops.py) or written out
(flat.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ..equations import Equations, ParameterSlot, Quantity
from ..graph.graph import Node
from ..middle.loops.loops import LoopEquations
from ..record import record

Shown = tuple[str, str, Node, str]  # a name, its unit, what it is, and for which indices
Section = tuple[str, Iterable[str]]  # its title, its lines


@record(kw_only=True)
class Contents:
    e: Equations | LoopEquations
    text: Callable[[Node], str]
    freedom: str  # what moves, counted
    declared: list[tuple[str, Sequence[Quantity]]]  # what moves, by kind
    parameters: Sequence[ParameterSlot]
    equations: list[Section]
    outputs: list[Shown]  # with what is claimed to be constant
    families: list[tuple[str, str]]  # how they are kept: facts
    costs: Section
    record: dict[str, object]  # of this alone, for `--json`


def section(title: str, lines: Iterable[str]) -> str:
    """A section of the text; none where there is nothing in it."""
    shown = [f"  {line}".rstrip() for line in lines]
    return "\n".join([title, *shown]) if shown else ""
