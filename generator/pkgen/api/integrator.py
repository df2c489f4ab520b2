"""Step by step integration, for example for a controller in Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy

from ..run import named
from ..run.header import STATUSES
from ..run.library import Run
from .errors import RunError
from .prepare import Prepared

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Integrator:
    """A motion that calls of `to(t)` and `step()` advance. `t` is the time. The arrays `q` and `v`
    have the coordinates and rates in the order of the model; each call changes them. The caller
    sets the inputs `u`, which are constant during a call. `stopped` is true after an event of the
    model has stopped the motion."""

    def __init__(self, prepared: Prepared, run: Run):
        compilation, self._run = prepared.compilation, run
        n = named.coordinates(compilation).count
        m = named.coordinates(compilation, rates=True).count
        self.u: NDArray[Any] = numpy.zeros(named.inputs(compilation).count)
        for i, x in prepared.settings.inputs:
            self.u[i] = x
        self._state = numpy.zeros(1 + n + m)
        self.q, self.v = self._state[1 : 1 + n], self._state[1 + n :]
        self.stopped = False
        self._advance = run.begin(self._state, self.u)
        self._advance(0.0, 0)

    @property
    def t(self) -> float:
        return float(self._state[0])

    def to(self, t: float) -> None:
        """Integrates to the time t. Raises RunError if the numerics fail."""
        status = self._advance(t, 0)
        if status:
            self._told(status)

    def step(self, limit: float = float("inf")) -> None:
        """Makes one step of the method, not beyond the time `limit`. Raises RunError."""
        status = self._advance(min(limit, 1e300), 1)
        if status:
            self._told(status)

    def _told(self, status: int) -> None:
        if status < 0:
            raise RunError(self._run.said().strip(), STATUSES[status], self.t, None)
        self.stopped = True
