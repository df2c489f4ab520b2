"""Inputs of a run that are functions or tables: `inputs={"u": f}`, `inputs={"u": (t, values)}`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from ctypes import POINTER, c_double
from typing import Any

import numpy

from ..front.data import KINDS, WrongData, of_arrays
from ..methods import known
from ..record import record
from ..run import named
from ..run.library import COMPUTE
from ..system.exits import UsageError
from . import arguments
from .prepare import Prepared

Function = Callable[[float, Any, Any], float]
Table = tuple[Any, ...]  # (t, values) or (t, values, kind), kind as of the statement `table`
SMALL = 1e-12  # relative rounding error of times at which steps end
MOST = 10_000_000  # largest number of times at which an input with `hold` or `linear` is evaluated


@record(eq=False)
class Law:
    """An input as a function of time and state. Steps end at the times `stops`, at which it jumps
    or has a kink. If `held` is true, it is evaluated only at these times."""

    at: Function
    stops: numpy.ndarray
    held: bool = False


# Families of methods that call inputs f(t, q, v) at every stage, and so keep their order.
EXPLICIT = {"ERK", "EMBEDDED", "RKMK"}


class Computed:
    """Inputs that are functions f(t, q, v) or tables (t, values, kind), linear by default. With
    `hold`, functions are called at its multiples, and inputs are constant in between. With
    `linear`, f(t, None, None) is called at multiples of `linear`, and inputs are interpolated
    linearly."""

    def __init__(self, given: Mapping[str, Any], hold: float | None, linear: float | None):
        if hold is not None and linear is not None:
            raise UsageError("hold= and linear=: give one of them")
        self.given, self.hold, self.linear = given, hold, linear
        functions = any(map(callable, given.values()))
        for name, step in (("hold", hold), ("linear", linear)):
            if step is not None and not (functions and step > 0):
                raise UsageError(f"{name}={step!r}: a time between samples of an input's function")
        # Whether functions are called with the current state at each evaluation of the forces. Only
        # methods of the families EXPLICIT allow this.
        self.needs_explicit = functions and hold is None and linear is None

    def settings(self, prepared: Prepared, errors: list[BaseException]) -> dict[str, Any]:
        """Returns members of pk_run_settings for inputs. Exceptions in functions are appended to
        `errors`. Raises UsageError."""
        compilation, settings = prepared.compilation, prepared.settings
        index = {name: i for i, name in enumerate(named.inputs(compilation).names())}
        for name in self.given.keys() - index.keys():
            known_as = ", ".join(index) or "none"
            raise UsageError(f"inputs[{name!r}]: the model has no such input; it has: {known_as}")
        method = known(compilation.model.methods).get(settings.method)
        if self.needs_explicit and (method is None or method.family not in EXPLICIT):
            raise UsageError(
                f"method={settings.method!r}: an input that is a function of the state is for "
                "explicit methods, as dop853 or rk4; or give hold="
            )
        laws = [(index[name], self._law(name, settings.until)) for name in self.given]
        fixed = method is not None and method.fixed
        held = [law.stops for _, law in laws if law.held]
        step = settings.step if fixed else None
        parts = numpy.concatenate([[0.0], *held]) / (step or 1.0)
        if step and (abs(parts - parts.round()) > 1e-9 * abs(parts)).any():
            raise UsageError(f"step={settings.step!r}: inputs are held for a whole number of steps")
        stops = held if fixed else [law.stops for _, law in laws]
        times = numpy.unique(numpy.concatenate([*stops, [0.0]]))
        n = named.coordinates(compilation).count
        seen = numpy.zeros(n + named.coordinates(compilation, rates=True).count)
        q, v, values = seen[:n], seen[n:], numpy.zeros(len(index))
        for i, x in settings.inputs:
            values[i] = x

        def compute(_context: object, t: float, stop: int) -> int:
            try:
                for i, law in laws:
                    if stop or not law.held:
                        values[i] = law.at(t, q, v)
            except BaseException as error:  # no exception may pass through C
                errors.append(error)
            return len(errors)

        pointer = POINTER(c_double)
        return {
            "compute": COMPUTE(compute),
            "only_stops": all(law.held for _, law in laws),
            "n_stops": len(times),
            "stops": times.ctypes.data_as(pointer),
            "seen": seen.ctypes.data_as(pointer),
            "computed": values.ctypes.data_as(pointer),
        }

    def _law(self, name: str, until: float) -> Law:
        """Returns the input `name` as a Law. Raises UsageError."""
        x = self.given[name]
        if callable(x):
            every = self.hold or self.linear
            if every and until / every > MOST:
                raise UsageError(f"inputs[{name!r}]: more than {MOST:,} samples")
            if self.hold is not None:
                return Law(x, numpy.arange(0.0, until, self.hold), held=True)
            if self.linear is None:
                return Law(x, numpy.zeros(0))
            t = numpy.arange(0.0, until + self.linear, self.linear)
            values = numpy.array([x(float(at), None, None) for at in t])
            return Law(lambda at, _q, _v: numpy.interp(at, t, values), t)
        t, values = arguments.arrays(**{f"inputs[{name!r}]": x[0], "values": x[1]})
        if t.ndim != 1 or t.shape != values.shape or not len(t) or (numpy.diff(t) <= 0).any():
            raise UsageError(f"inputs[{name!r}]: times in order, and as many values")
        if t[0] > 0 or t[-1] < until:
            raise UsageError(
                f"inputs[{name!r}]: the table goes from {t[0]:g} to {t[-1]:g}, the run from 0 to "
                f"{until:g}"
            )
        kind = x[2] if len(x) == 3 else "linear"
        if len(x) > 3 or kind not in KINDS:
            raise UsageError(f"inputs[{name!r}]: (t, values, kind), kind one of {', '.join(KINDS)}")
        if kind == "hold":
            places = t * (1 - SMALL)  # The times of steps have rounding errors.
            return Law(lambda at, _q, _v: values[places.searchsorted(at, "right") - 1], t, True)
        try:
            data = of_arrays([t], values, kind, "linear", f"inputs[{name!r}]")
        except WrongData as wrong:
            raise UsageError(str(wrong)) from None
        return Law(lambda at, _q, _v: float(data.value((0,), at)), t)
