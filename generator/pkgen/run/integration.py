"""Steps of any method from any state of a compiled model (pk/stability.h), by ctypes.

A state is an array of 2 n numbers, q then v; in q first-order variables are 0.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from ctypes import Array, c_double, c_int, c_void_p

import numpy

from ..system.exits import UsageError
from .header import STATUSES
from .library import Run

TOO_MANY_STEPS = next(code for code, name in STATUSES.items() if name == "PK_TOO_MANY_STEPS")
CONSTANTS, CONDITION = 1, 2  # flags of `watch`: PK_WATCH_* in C
_CHUNK = 1 << 16  # most numbers that one call of C returns; look() runs between calls


def _pointer(x: numpy.ndarray) -> Array[c_double]:
    return (c_double * x.size).from_buffer(x)  # faster than x.ctypes.data_as()


class Integration:
    """An integration that starts from a state at t = 0. `h` is the fixed step size; it is 0 for an
    adaptive method, which has the tolerances `rtol` and `atol`. If `atol` is negative, a value is
    chosen from the motion. The function `look` is called every few thousand steps, and may raise an
    exception. Raises UsageError."""

    def __init__(
        self,
        run: Run,
        method: str,
        state: numpy.ndarray,
        h: float = 0.0,
        rtol: float = 0.0,
        atol: float = -1.0,
        watch: int = 0,
        look: Callable[[], None] = lambda: None,
    ):
        self._run, self._c, self._of, self._look = run, run._c, None, look
        self._status = c_int(0)
        if h < 0:
            raise UsageError("a step is positive")
        self.half = len(state) // 2
        self.t, self.state = 0.0, numpy.array(state, float)
        begin = run._c.pk_stability_begin
        given = method.encode(), h, rtol, atol, watch, _pointer(self.state)
        self._of = c_void_p(begin(run._run, *given, self._status))
        if self.status == "PK_BAD_ARGUMENT":
            raise UsageError(f"no method of {'a fixed step' if h else 'adaptive steps'}: {method}")

    @property
    def status(self) -> str:
        return STATUSES[self._status.value]

    @property
    def failed(self) -> bool:
        return self._status.value != 0

    def steps(self, until: float, count: int) -> numpy.ndarray:
        """Makes up to `count` steps, none beyond `until`; fewer if states are long. Returns a row
        (t, state) for each step."""
        wide = 1 + 2 * self.half
        count = max(min(count, _CHUNK // wide), 64) if count > 64 else count
        out = numpy.empty((count, wide))
        made = self._steps(until, count, True, out) if not self.failed else 0
        if made:
            self.t, self.state = float(out[made - 1, 0]), out[made - 1, 1:].copy()
        return out[:made]

    def to(self, t: float) -> bool:
        """Integrates from the present state to the time t. Returns False if a step fails."""
        out = numpy.empty(1 + 2 * self.half)
        while not self.failed and self.t < t:
            self._steps(t, _CHUNK, False, out)
            self.t, self.state = float(out[0]), out[1:].copy()
        return not self.failed

    def _steps(self, until: float, count: int, every: bool, out: numpy.ndarray) -> int:
        self._look()
        given = until, count, every, _pointer(out)
        return self._c.pk_stability_steps(self._of, *given, self._status)

    def give_up(self) -> None:
        self._status.value = TOO_MANY_STEPS

    def restart(self, state: numpy.ndarray, t: float = 0.0, h: float = 0.0) -> None:
        if not self._of:
            return
        self.t, self.state = t, numpy.array(state, float)
        restart = self._c.pk_stability_restart
        self._status.value = restart(self._of, t, h, _pointer(self.state))

    def mapped(self, states: numpy.ndarray, h: float, steps: int) -> numpy.ndarray:
        """Integrates from each of the states: by `steps` steps of size h or, if the method is
        adaptive, for the time `steps` * h. Returns the final states, with NaN where a step fails.
        """
        self._look()
        states = numpy.ascontiguousarray(states)
        out = numpy.empty_like(states)
        given = h, steps, len(states), _pointer(states), _pointer(out)
        self._c.pk_stability_map(self._of, *given)
        return out

    def projected(self, state: numpy.ndarray) -> tuple[str, numpy.ndarray]:
        """Projects a state onto the constraints. Returns the status and the projected state."""
        if self.failed:
            return self.status, numpy.array(state)
        on = numpy.array(state, float)
        return STATUSES[self._c.pk_stability_project(self._of, _pointer(on))], on

    def report(self) -> dict:
        return {} if not self._of else json.loads(self._c.pk_stability_report(self._of))

    def __del__(self) -> None:
        of, self._of = self._of, None
        if of:
            self._c.pk_stability_end(of)


def spring(
    run: Run, method: str, stiffness: float, damping: float, h: float
) -> tuple[float, float, float, float]:
    """Returns the matrix of a step of (q, v) on q'' = -stiffness q - damping q'; NaN on failure."""
    entries = (c_double * 4)(*4 * [numpy.nan])
    run._c.pk_stability_spring(run._model, method.encode(), stiffness, damping, h, entries)
    return tuple(entries)
