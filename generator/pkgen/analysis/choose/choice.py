"""The method and setting chosen for a scene, and the evidence for them."""

from __future__ import annotations

from dataclasses import replace

from ...record import record
from ...run.settings import PartSettings, Settings
from .reference import Check
from .search import Found


@record
class GivenUp:
    """A trial of a whole scene that took `seconds` and was stopped. It had reached the time t of
    the motion, and should have reached `until`."""

    t: float
    seconds: float
    until: float


@record
class Choice:
    """A choice. `expected` is the expected error of the run with the chosen method and setting, as
    measured against a tighter run."""

    accuracy: float
    method: str
    rows: str
    setting: float
    fixed: bool
    expected: float
    horizon: float | None  # the accuracy is kept until this time; None: to the end
    check: Check
    found: tuple[Found, ...]
    seconds: float  # CPU seconds of all trials
    run_seconds: float  # CPU seconds that the run is expected to take
    without: bool  # rows are at an event that never occurs: only start and end are compared
    max_step: float | None = None
    given_up: GivenUp | None = None  # set if only the first part of the scene was tried
    compiled_for: tuple[str, ...] = ()
    compile_seconds: float = 0.0
    left_out: tuple[str, ...] = ()  # columns not compared: exactly 0 but for numerical errors
    unsure: tuple[str, ...] = ()  # expected quantities smaller than their errors
    sampled: int = 0  # number of ensemble members that were tried
    of: tuple[str, ...] = ()  # the coordinates of a block; empty: all coordinates

    @property
    def kind(self) -> str:
        """Returns the name of the option that the setting is for: "step" or "rtol"."""
        return "step" if self.fixed else "rtol"

    def settings(self, given: Settings) -> Settings:
        """Returns `given` with the chosen method and setting, for a run by the same program that
        ran the trials."""
        given = replace(given, method=self.method, rows=self.rows, compiled_for=self.compiled_for)
        if self.fixed:
            return replace(given, step=self.setting)
        bounds = [x for x in (given.max_step, self.max_step) if x is not None]
        longest = min(bounds, default=None)
        return replace(given, step=None, rtol=self.setting, atol=None, max_step=longest)

    def of_part(self) -> PartSettings:
        """Returns the settings for a block of coordinates that is integrated separately."""
        if self.fixed:
            return PartSettings(self.method, self.setting, self.setting)
        return PartSettings(self.method, None, self.setting, self.max_step)
