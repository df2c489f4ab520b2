"""The exceptions of the Python API. All are also names in `pkgen`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..source import ModelError
from ..system.exits import BuildError, NumericsFailed, UsageError

if TYPE_CHECKING:
    from .result import Result

__all__ = ["BuildError", "ModelError", "NumericsFailed", "RunError", "UsageError"]


class ArrayError(UsageError, ValueError):
    """An array has a wrong shape, or is not an array of numbers."""


class RunError(NumericsFailed):
    """The numerics of a run failed. `status` is the runtime's (PK_STEP_UNDERFLOW, ...),
    `last_valid` the time up to which its rows are valid, `result` the rows up to there; None for an
    integrator."""

    def __init__(self, message: str, status: str, last_valid: float, result: Result | None):
        super().__init__(message)
        self.status, self.last_valid, self.result = status, last_valid, result
