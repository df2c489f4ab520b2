"""What a scene asks of a choice, and of what it may be made."""

from __future__ import annotations

from dataclasses import dataclass

from .candidates import Candidate
from .trials import Trials


@dataclass(frozen=True)
class Asked:
    trials: Trials
    able: tuple[Candidate, ...]  # what may be chosen
    exact: tuple[str, ...]  # methods whose tightest runs may be exact, in turns until one arrives
    damped: bool
    accuracy: float

    @property
    def until(self) -> float:
        return self.trials.settings.until

    @property
    def every(self) -> float:
        """Between rows, or until the end."""
        return min(self.trials.settings.every or self.until, self.until)
