"""The arguments of a reduction: the requested results (Needs), and the equations after the
reductions before (State)."""

from __future__ import annotations

from dataclasses import replace

from ...equations import Equations
from ...graph.count import operations
from ...graph.graph import Graph
from ...record import record
from ..analyze.analyze import analyze
from ..derive.lagrange import derived_again
from ..report import Report, ReportLine
from ..structure import Structure

# The kernels that are derived for the equations between two reductions.
ENOUGH = frozenset({"acceleration"})


@record
class Needs:
    """The requested results. `columns` are the names of recorded quantities, such as "theta" or
    "phi'"."""

    columns: frozenset[str]
    events: frozenset[str] = frozenset()
    # Structure about the equations without which the integrator cannot be used.
    facts: tuple[str, ...] = ()
    apart: bool = True  # Whether parts of the system may be integrated separately.
    off: frozenset[str] = frozenset()  # The names of the reductions that the user switched off.


@record
class Subsystem:
    """A block as a separate system. `coordinates` are the indices of its coordinates and states in
    the whole system, where states are numbered after all coordinates."""

    equations: Equations
    structure: Structure
    coordinates: tuple[int, ...]


@record
class State:
    """The equations after some reductions, with their proved facts and the report. If there are
    `parts`, they are integrated separately."""

    equations: Equations
    structure: Structure
    report: Report = Report()
    parts: tuple[Subsystem, ...] = ()

    def noting(self, *lines: ReportLine) -> State:
        """Returns the State with further lines in the report."""
        return replace(self, report=replace(self.report, lines=(*self.report.lines, *lines)))

    def after(self, equations: Equations, *lines: ReportLine, **more: object) -> State:
        """Returns a State with the given equations, and with further lines in the report. The
        motion is derived again if coordinates or states were removed."""
        before = self.equations
        if (equations.coordinates, equations.states) != (before.coordinates, before.states):
            equations = derived_again(equations, ENOUGH)
        report = replace(self.noting(*lines).report, **more)
        return State(equations, analyze(equations), report)


def cost(g: Graph, equations: Equations) -> int:
    motion = equations.acceleration or (*equations.force, *sum(equations.mass, ()))
    return operations(g, [*motion, *equations.state_rates])
