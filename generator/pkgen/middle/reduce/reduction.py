"""What a reduction is given: what is wanted of a motion, and what earlier ones have left of it."""

from __future__ import annotations

from dataclasses import replace

from ...equations import Equations, Structure
from ...graph.count import operations
from ...graph.graph import Graph
from ...record import record
from ..analyze.analyze import analyze
from ..derive.lagrange import derived_again
from ..report import Report, ReportLine

# What must be known of equations to reduce them.
ENOUGH = frozenset({"acceleration"})


@record
class Needs:
    """What is wanted of a motion. Columns are names as in the head of a CSV: "theta", "phi'"."""

    columns: frozenset[str]
    events: frozenset[str] = frozenset()
    facts: tuple[str, ...] = ()  # that its method requires
    apart: bool = True  # blocks may be integrated apart
    off: frozenset[str] = frozenset()  # reductions that are not to be made


@record
class State:
    """What one reduction hands to the next."""

    equations: Equations
    structure: Structure
    report: Report

    def after(self, equations: Equations, *lines: ReportLine, **more: object) -> State:
        """With other equations, derived again if their coordinates are others."""
        before = self.equations
        if (equations.coordinates, equations.states) != (before.coordinates, before.states):
            equations = derived_again(equations, ENOUGH)
        report = replace(self.report, lines=(*self.report.lines, *lines), **more)
        return State(equations, analyze(equations), report)


def cost(g: Graph, equations: Equations) -> int:
    motion = equations.acceleration or (*equations.force, *sum(equations.mass, ()))
    return operations(g, [*motion, *equations.state_rates])
