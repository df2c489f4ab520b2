"""Runs of one scene, made and measured by the driver (runtime/run/choose.c)."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from ..chart.measure import Program

LAND, DENSE = "land", "dense"


@dataclass(frozen=True)
class Trial:
    """One method at one setting. `error` is relative to each column's largest magnitude, infinite
    where there is none."""

    method: str
    rows: str  # LAND or DENSE
    setting: float
    able: bool  # the method applies
    status: str
    reason: str
    arrived: bool
    slow: bool  # given up at its cap
    t: float  # how far it came
    seconds: float
    took: float
    steps: int
    evaluations: int
    held: int
    compared: int  # rows
    error: float
    holds: float  # until when it held the accuracy
    max_step: float | None = None  # that its adaptive steps were bounded by
    columns: tuple[float, ...] = field(default=(), repr=False)

    @property
    def refused(self) -> bool:
        return not self.able


class Trials(Program):
    """A context manager."""

    mode = "--choose"
    spent = 0.0  # seconds of the processor, for all so far
    without = False  # the exact rows are the start and the end: there were no crossings to be at

    def attempt(
        self,
        method: str,
        setting: float,
        rows: str,
        span: float,
        *,
        accuracy: float = 1.0,
        laps: float = 0.0,
        cap: float = 0.0,
        every: float = 0.0,
        max_step: float | None = None,
    ) -> Trial:
        """One run up to `span`, and laps of it for so many seconds; `cap` 0: never given up;
        `every` 0: rows as in the scene."""
        found = self.ask(
            "try", method, setting, rows, span, laps, cap, accuracy, every, max_step or 0.0
        )
        self.spent += found["took"]
        arrived = found["arrived"]
        return Trial(
            method=method,
            rows=rows,
            setting=_number(found["setting"]),
            able=found["able"],
            status=found["status"],
            reason=found["reason"] or ("" if found["able"] else "does not apply"),
            arrived=arrived,
            slow=found["slow"],
            t=_number(found["t"]),
            seconds=found["seconds"] if arrived else math.inf,
            took=found["took"],
            steps=found["steps"],
            evaluations=found["evaluations"],
            held=found["held"],
            compared=found.get("compared", 0),
            error=_number(found.get("error")) if arrived else math.inf,
            holds=_number(found.get("holds", 0.0)),
            max_step=max_step,
            columns=_numbers(found.get("columns", ())),
        )

    def keep_as_exact(self) -> tuple[float, ...]:
        """The rows of the last run; the largest magnitude of each column."""
        found = self.ask("exact")
        self.without = found["without"]
        return _numbers(found["scales"])

    def ignore(self, column: int) -> None:
        self.ask("ignore", column)

    def save(self, path: Path) -> None:
        self.ask("save", path)

    def load(self, path: Path) -> None:
        self.ask("load", path)


def _number(x: float | None) -> float:
    return math.inf if x is None else float(x)


def _numbers(xs: Iterable[float | None]) -> tuple[float, ...]:
    return tuple(map(_number, xs))
