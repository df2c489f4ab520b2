"""The exceptions of the Python API. All can be imported from `pkgen`."""

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
    """The integration failed. `status` is the status of the runtime, such as PK_STEP_UNDERFLOW;
    `last_valid` is the time up to which rows are valid; `result` has these rows, or is None if an
    Integrator failed."""

    def __init__(self, message: str, status: str, last_valid: float, result: Result | None):
        super().__init__(message)
        self.status, self.last_valid, self.result = status, last_valid, result
