"""What reductions say: what went, and why."""

from __future__ import annotations

from dataclasses import dataclass, field

from .smaller import Start


@dataclass(frozen=True)
class Line:
    """What one reduction did, or why it did not."""

    reduction: str
    what: str
    why: str

    def __str__(self) -> str:
        return f"{self.what}: {self.why}"


@dataclass(frozen=True)
class Report:
    """`starts` are parameters that starts have become, `unused` coordinates whose starts have no
    effect; of `operations` and `coordinates` the number before and after."""

    lines: tuple[Line, ...] = ()
    starts: dict[Start, str] = field(default_factory=dict)
    unused: frozenset[str] = frozenset()
    operations: tuple[int, int] = (0, 0)  # of the accelerations and the quadratures
    coordinates: tuple[int, int] = (0, 0)
