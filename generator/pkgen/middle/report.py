"""The report of reductions: removed coordinates and parameters, with the reasons."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import field, replace

from ..equations import ParameterSlot
from ..record import record
from .drop_coordinates import Start


@record
class ReportLine:
    """The effect of one reduction, or the reason why it has none."""

    reduction: str
    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.what}: {self.why}"


@record
class Report:
    """`starts`: parameters that replace starts. `unused`: coordinates whose starts have no effect,
    and parameters that nothing reads. `operations`, `coordinates`: numbers before and after."""

    lines: tuple[ReportLine, ...] = ()
    starts: dict[Start, str] = field(default_factory=dict)
    unused: frozenset[str] = frozenset()
    operations: tuple[int, int] = (0, 0)  # of the accelerations and the rates of states
    coordinates: tuple[int, int] = (0, 0)

    def unread(self, slots: tuple[ParameterSlot, ...], kept: Collection[int]) -> Report:
        """Returns the report with a line for the parameters that are not kept."""
        gone = [slot for k, slot in enumerate(slots) if k not in kept]
        if not gone:
            return self
        families = ", ".join(dict.fromkeys(slot.family for slot in gone))
        line = ReportLine("unread", families, "nothing that is left reads it")
        unused = self.unused | {slot.quantity.name for slot in gone}
        return replace(self, lines=(*self.lines, line), unused=unused)
