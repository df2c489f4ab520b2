"""The arguments of a reduction: Needs, the requested results, and State, the equations so far."""

from __future__ import annotations

from dataclasses import replace

from ...equations import Equations, Structure
from ...graph.count import operations
from ...graph.graph import Graph
from ...record import record
from ..analyze.analyze import analyze
from ..derive.lagrange import derived_again
from ..report import Report, ReportLine

# The kernels that reductions need.
ENOUGH = frozenset({"acceleration"})


@record
class Needs:
    """The requested results. Columns are names as in the header of a CSV: "theta", "phi'"."""

    columns: frozenset[str]
    events: frozenset[str] = frozenset()
    facts: tuple[str, ...] = ()  # facts that the method requires
    apart: bool = True  # whether blocks may be integrated separately
    off: frozenset[str] = frozenset()  # reductions that are switched off


@record
class State:
    """The state of the reduced system between reductions."""

    equations: Equations
    structure: Structure
    report: Report

    def after(self, equations: Equations, *lines: ReportLine, **more: object) -> State:
        """Returns a State with other equations, derived again if coordinates or states changed."""
        before = self.equations
        if (equations.coordinates, equations.states) != (before.coordinates, before.states):
            equations = derived_again(equations, ENOUGH)
        report = replace(self.report, lines=(*self.report.lines, *lines), **more)
        return State(equations, analyze(equations), report)


def cost(g: Graph, equations: Equations) -> int:
    motion = equations.acceleration or (*equations.force, *sum(equations.mass, ()))
    return operations(g, [*motion, *equations.state_rates])
