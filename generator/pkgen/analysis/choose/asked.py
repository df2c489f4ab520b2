"""What a scene asks of a choice, and of what it may be made."""

from __future__ import annotations

from ...record import record
from .candidates import Candidate
from .trials import Trials

STEPS = 1000  # at least, of what is to be exact, where the equations have the time in them


@record
class Task:
    trials: Trials
    able: tuple[Candidate, ...]  # what may be chosen
    exact: tuple[str, ...]  # methods whose tightest runs may be exact, in turns until one arrives
    damped: bool
    accuracy: float
    timed: bool = False  # the equations have the time in them

    @property
    def until(self) -> float:
        return self.trials.settings.until

    @property
    def every(self) -> float:
        """Between rows, or until the end."""
        return min(self.trials.settings.every or self.until, self.until)

    @property
    def max_step(self) -> float | None:
        """The longest step of the exact run: error control does not see what lies within a step if
        nothing announces it. None: no bound."""
        return self.until / STEPS if self.timed else None
