"""The table of the methods that are tried on a scene, with reasons. All methods were run on a set
of test scenes (docs/accuracy.md); each method of the table is among the cheapest on one of them.

The runtime knows which systems a method can integrate. The table adds conditions on the system: a
method is tried only if they hold, since elsewhere a trial would not be worth its time. If two
methods cost the same, the first in the table is chosen, so simpler methods come first.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...methods import provides
from ...record import record
from ..chart.chart import methods as all_methods
from ..chart.points import ChartedMethod
from .trials import DENSE, LAND


@record
class Row:
    """A row of TABLE. The method is tried on systems that have all facts of `if_` and no fact of
    `if_not` (names of enum pk_fact)."""

    method: str
    rows: str
    why: str
    if_: tuple[str, ...] = ()
    if_not: tuple[str, ...] = ()


KEEPS = "separable: its energy does not drift"
STIFF = "dissipative: where that is stiff, steps need not follow it"
TABLE = (
    Row("exponential", LAND, "the equations are linear: each step is exact"),
    Row("gauss", LAND, "smooth: its error falls with the 16th power of the step"),
    Row("taylor", LAND, "tight accuracies: its order follows from them"),
    Row("taylor", DENSE, "rows closer than its steps"),
    Row("dop853", LAND, "loose accuracies, and motions with kinks"),
    Row("dop853", DENSE, "rows closer than its steps"),
    Row("dopri5", DENSE, "rows closer than its steps, loose accuracies"),
    Row("dopri5", LAND, "loose accuracies"),
    Row("gauss", DENSE, "rows closer than its steps"),
    Row("rk4", LAND, "rows as close as its steps"),
    Row("mclachlan4", LAND, KEEPS, ("separable",)),
    Row("blanes_moan4", LAND, KEEPS, ("separable",)),
    Row("blanes_moan6", LAND, KEEPS, ("separable",)),
    Row("kahan_li8", LAND, KEEPS, ("separable",)),
    Row("gauss8", LAND, "Newton's iteration where that of gauss would shorten steps"),
    Row("gauss2", LAND, STIFF, if_not=("variational",)),
    Row("gauss4", LAND, STIFF, if_not=("variational",)),
    Row("radau5", LAND, STIFF, if_not=("variational",)),
    Row("radau", LAND, STIFF, if_not=("variational",)),
)


@record
class Candidate:
    method: ChartedMethod
    rows: str
    why: str

    @property
    def name(self) -> str:
        return self.method.name


def candidates(structure: object, methods: Iterable[ChartedMethod]) -> list[Candidate]:
    """Returns the candidates that apply to a system with the facts `structure`."""
    known = {m.name: m for m in methods}
    rows = [(known[row.method], row) for row in TABLE if row.method in known]
    return [
        Candidate(method, row.rows, row.why)
        for method, row in rows
        if all(provides(structure, fact.replace(" ", "_")) for fact in method.requires)
        and all(provides(structure, fact) for fact in row.if_)
        and not any(getattr(structure, fact, False) for fact in row.if_not)
    ]


def alone(name: str) -> Candidate:
    """Returns the candidate `name`, which need not be in the table."""
    return Candidate(all_methods([name])[0], LAND, "the reference itself")
