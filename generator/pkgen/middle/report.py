"""The report of the reductions: which coordinates and parameters were removed, and why."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import field, replace

from ..equations import ParameterSlot
from ..record import record
from .drop_coordinates import Start


@record
class ReportLine:
    """A line of the report: the effect of one reduction, or the reason why it has no effect."""

    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.what}: {self.why}"


@record
class Report:
    """The report of all reductions.

    `starts` maps initial values that became parameters to the names of these parameters. `unused`
    has the coordinates whose initial values have no effect, and the parameters that nothing uses.
    `operations` and `coordinates` are pairs of numbers: one before and one after the reductions.
    """

    lines: tuple[ReportLine, ...] = ()
    starts: dict[Start, str] = field(default_factory=dict)
    unused: frozenset[str] = frozenset()
    # numbers of operations that compute accelerations and rates of states
    operations: tuple[int, int] = (0, 0)
    coordinates: tuple[int, int] = (0, 0)

    def unread(self, slots: tuple[ParameterSlot, ...], kept: Collection[int]) -> Report:
        """Returns the report with a further line, about the parameters that nothing uses any more.
        `kept` has the indices of the other parameters."""
        gone = [slot for k, slot in enumerate(slots) if k not in kept]
        if not gone:
            return self
        families = ", ".join(dict.fromkeys(slot.family for slot in gone))
        line = ReportLine(families, "nothing that is left reads it")
        unused = self.unused | {slot.quantity.name for slot in gone}
        return replace(self, lines=(*self.lines, line), unused=unused)
