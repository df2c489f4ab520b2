"""The contents of `explain`: by flat.py, or by families.py for families of any length."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ..equations import AnyEquations, ParameterSlot, Quantity
from ..graph.graph import Node
from ..record import record

# An output: its name, its unit, its graph node, and the range of its index as text.
Shown = tuple[str, str, Node, str]
Section = tuple[str, Iterable[str]]  # A section of the report: title, lines.


@record(kw_only=True)
class Contents:
    e: AnyEquations
    text: Callable[[Node], str]
    # Text with the numbers of degrees of freedom, rotations and first-order variables.
    freedom: str
    # Pairs of a heading and quantities: coordinates, angular velocities, states.
    declared: list[tuple[str, Sequence[Quantity]]]
    parameters: Sequence[ParameterSlot]
    equations: list[Section]
    outputs: list[Shown]  # Outputs, and quantities claimed to be constant.
    # Pairs of a heading and a text: how families are compiled: written out, or not.
    families: list[tuple[str, str]]
    costs: Section
    # entries of the `--json` output that differ between families.py and flat.py
    record: dict[str, object]


def section(title: str, lines: Iterable[str]) -> str:
    """Returns a section of the text; "" if it has no lines."""
    shown = [f"  {line}".rstrip() for line in lines]
    return "\n".join([title, *shown]) if shown else ""
