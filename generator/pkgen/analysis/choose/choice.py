"""What was chosen for a scene, and why."""

from __future__ import annotations

from dataclasses import replace

from ...record import record
from ...run.settings import PartSettings, Settings
from .reference import Check
from .search import Found


@record
class GivenUp:
    """A trial of a whole scene: how far it came in how many seconds, and where it would end."""

    t: float
    seconds: float
    until: float


@record
class Choice:
    """`expected` is the error of this very run beside a tighter one."""

    accuracy: float
    method: str
    rows: str
    setting: float
    fixed: bool
    expected: float
    horizon: float | None  # None: it is kept to the end
    check: Check
    found: tuple[Found, ...]
    seconds: float  # of the processor, for all trials
    run_seconds: float  # foreseen
    without: bool  # what it is judged by is the start and the end: its event does not happen
    max_step: float | None = None
    given_up: GivenUp | None = None  # it was tried in part alone
    compiled_for: tuple[str, ...] = ()
    compile_seconds: float = 0.0
    left_out: tuple[str, ...] = ()  # columns that are zero but for errors
    unsure: tuple[str, ...] = ()  # expectations beside which errors are too large
    sampled: int = 0  # members that were tried, of an ensemble
    of: tuple[str, ...] = ()  # the coordinates of a part; none: it is of all

    @property
    def kind(self) -> str:
        """Of its setting."""
        return "step" if self.fixed else "rtol"

    def settings(self, given: Settings) -> Settings:
        """What is run, by the program that the trials were made with."""
        given = replace(given, method=self.method, rows=self.rows, compiled_for=self.compiled_for)
        if self.fixed:
            return replace(given, step=self.setting)
        bounds = [x for x in (given.max_step, self.max_step) if x is not None]
        longest = min(bounds, default=None)
        return replace(given, step=None, rtol=self.setting, atol=None, max_step=longest)

    def of_part(self) -> PartSettings:
        """What is run of a block of coordinates by itself."""
        if self.fixed:
            return PartSettings(self.method, self.setting, self.setting)
        return PartSettings(self.method, None, self.setting, self.max_step)
