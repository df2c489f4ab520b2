"""The method and setting chosen for a scene, and the evidence."""

from __future__ import annotations

from dataclasses import replace

from ...record import record
from ...run.settings import PartSettings, Settings
from .reference import Check
from .search import Found


@record
class GivenUp:
    """A stopped trial of a whole scene: its time t after `seconds`, and its planned end."""

    t: float
    seconds: float
    until: float


@record
class Choice:
    """A choice. `expected` is the error of this same run relative to a tighter one."""

    accuracy: float
    method: str
    rows: str
    setting: float
    fixed: bool
    expected: float
    horizon: float | None  # time until which the accuracy is kept; None: to the end
    check: Check
    found: tuple[Found, ...]
    seconds: float  # CPU seconds of all trials
    run_seconds: float  # forecast CPU seconds of the run
    without: bool  # judged by start and end only: its event does not happen
    max_step: float | None = None
    given_up: GivenUp | None = None  # set if only a part was tried
    compiled_for: tuple[str, ...] = ()
    compile_seconds: float = 0.0
    left_out: tuple[str, ...] = ()  # columns that are zero up to errors
    unsure: tuple[str, ...] = ()  # expectations smaller than the errors
    sampled: int = 0  # number of members tried, of an ensemble
    of: tuple[str, ...] = ()  # the coordinates of a part; empty: all

    @property
    def kind(self) -> str:
        """Returns the name of its setting."""
        return "step" if self.fixed else "rtol"

    def settings(self, given: Settings) -> Settings:
        """Returns the settings of the run, by the same program as the trials."""
        given = replace(given, method=self.method, rows=self.rows, compiled_for=self.compiled_for)
        if self.fixed:
            return replace(given, step=self.setting)
        bounds = [x for x in (given.max_step, self.max_step) if x is not None]
        longest = min(bounds, default=None)
        return replace(given, step=None, rtol=self.setting, atol=None, max_step=longest)

    def of_part(self) -> PartSettings:
        """Returns the settings of a part, a block of coordinates integrated by itself."""
        if self.fixed:
            return PartSettings(self.method, self.setting, self.setting)
        return PartSettings(self.method, None, self.setting, self.max_step)
