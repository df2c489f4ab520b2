"""Equations, Structure -> Equations, Report: leave out what is not needed, and say so.

A reduction is a function from equations and structure to equations and the lines of the report
that say what went and why. It stands in REDUCTIONS under the name by which it is switched off.
There is none yet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..equations import Equations, Structure


@dataclass(frozen=True)
class Report:
    lines: tuple[str, ...] = ()


Reduction = Callable[[Equations, Structure], tuple[Equations, tuple[str, ...]]]
REDUCTIONS: dict[str, Reduction] = {}


def reduce(
    equations: Equations, structure: Structure, off: frozenset[str] = frozenset()
) -> tuple[Equations, Report]:
    lines: list[str] = []
    for name, reduction in REDUCTIONS.items():
        if name not in off:
            equations, said = reduction(equations, structure)
            lines.extend(said)
    return equations, Report(tuple(lines))
