"""A run whose steps are kept, and small displacements of it.

A displacement is a vector (dq, dv, du, dp, dt): n numbers each of coordinates and rates, then
inputs, parameters, and the shift of the fixed steps after an event. C propagates it through the
steps (runtime/run/diagnose/tangent.c); here it passes the jumps between them, by the saltation
matrix.

Reference: P. C. Müller, Chaos, Solitons and Fractals 5 (1995) 1671 (saltation).
"""

from __future__ import annotations

from collections.abc import Iterator
from ctypes import POINTER, c_double
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from ...methods import known
from ...middle.refused import refuse_statements
from ...run import named
from ...run.build import build_library
from ...run.header import STATUSES
from ...run.library import Run, load
from ...run.simulate import Runnable
from ...system.exits import NumericsFailed, UsageError
from ...system.near import near

if TYPE_CHECKING:
    from numpy.typing import NDArray

MULTISTEP = ("gsl_msadams", "gsl_msbdf")  # a single step of these cannot be repeated
GRAZES = 1e-6  # a crossing at a rate below this, relative to the motion, grazes


def refuse(prepared: Runnable) -> None:
    """Raises UsageError or ModelError if there are no derivatives of the run."""
    refuse_statements(prepared.compilation.declared, "sensitivity")
    if not prepared.compilation.equations.dense:
        raise UsageError("sensitivity: there are no derivatives of families kept as loops")
    if prepared.settings.at is not None:
        raise UsageError("sensitivity: rows at events have no derivatives: leave 'at' out")
    if (method := prepared.settings.method) in MULTISTEP:
        raise UsageError(
            f"sensitivity: {method} has no derivatives, since its steps depend on those before: "
            "choose another method"
        )


def library(prepared: Runnable) -> Path:
    """Builds the library of a model whose runs keep their steps. Raises BuildError."""
    of, methods = prepared.compilation, prepared.settings.methods
    return build_library(of.files, of.model.name, *methods, diagnose=True, own=of.model.methods)


def ran(prepared: Runnable) -> Tape:
    """Makes the run of a model that was built by library(). Raises NumericsFailed if the run fails,
    or an event ends it: fits and optima need the whole run."""
    assert prepared.library is not None
    done = load(prepared.library).run(prepared.settings, tape=1)
    if done.code or done.report.get("status") != "PK_DONE":
        raise NumericsFailed(done.messages.strip() or str(done.report.get("reason", "")))
    return Tape(prepared, done)


class Tape:
    """A run that has ended, with its steps. `rows` has a row for each step: t at its start and end,
    the mark of pk_run_tape(), q0, v0, q1, v1, u."""

    def __init__(self, prepared: Runnable, run: Run):
        """`run` was made with the setting `tape`, by library()."""
        of = prepared.compilation
        self.compilation, self.settings, self.run = of, prepared.settings, run
        self.equations = e = of.program.equations  # with first-order variables as rates
        self.n, self.m, self.p = len(e.force), len(e.inputs), len(e.parameters)
        self.width = 2 * self.n + self.m + self.p + 1
        width = 3 + 4 * self.n + self.m
        self.rows = numpy.zeros((run._c.pk_run_tape(run._run, None), width))
        run._c.pk_run_tape(run._run, _pointer(self.rows))
        self.begun, self.ended, self.inputs = numpy.split(
            self.rows[:, 3:], [2 * self.n, 4 * self.n], axis=1
        )
        held = self.inputs[:, [j - 2 * self.n for j in self._flags]].any(axis=1)
        if held.any():
            t = self.rows[held.argmax(), 0]
            raise NumericsFailed(
                f"at t = {t:.10g} a contact holds: derivatives pass impacts, and no lasting contact"
            )
        method = known(of.model.methods)[prepared.settings.method]
        self.fixed = "adaptive" not in method.traits

    def state(self, k: int, end: int) -> tuple[float, NDArray[Any], NDArray[Any], NDArray[Any]]:
        """Returns t, q, v and u at the start or the end of a row."""
        q, v = (self.ended if end else self.begun)[k].reshape(2, -1)
        return self.rows[k, end], q, v, self.inputs[k]

    def kernel(self, name: str, k: int, end: int, columns: int = 0) -> NDArray[Any]:
        """Returns a Jacobian at the start or the end of a row, by (q, v, t, u, p)."""
        t, *of = self.state(k, end)
        found = self.run.evaluate(name, t, *map(numpy.atleast_2d, of))
        return found.reshape(-1, columns or self.width)

    def rates(self, k: int, end: int) -> NDArray[Any]:
        """Returns (q', v') at the start or the end of a row."""
        found = numpy.zeros(2 * self.n)
        self._done(self.run._c.pk_run_tape_rates(self.run._run, k, end, _pointer(found)))
        return found

    def ending(self, k: int) -> NDArray[Any]:
        """Returns the derivative of the state at the end of a row by the time of this end."""
        return self.rates(k, 2 if self.fixed else 1)

    # -- displacements at the start -----------------------------------------------------------

    def started(self, name: str) -> NDArray[Any]:
        """Returns the displacement at the start by a parameter, an input, or the start value of a
        coordinate, a rate or a first-order variable. Raises UsageError."""
        n, d = self.n, numpy.zeros(self.width)
        q, v = (named.coordinates(self.compilation, rates=x) for x in (False, True))
        inputs, parameters = named.inputs(self.compilation), named.parameters(self.compilation)
        for first, of in ((0, q), (n, v), (2 * n, inputs), (2 * n + self.m, parameters)):
            if name in of:
                d[first + of[name][0]] = 1
                break
        else:
            known = [*q, *v, *inputs, *parameters]
            raise UsageError(f"by {name}: {near(name, known, 'parameter, start or input')}")
        if name in parameters:
            dp = d[2 * n + self.m : -1]
            given = {i for i, _ in self.settings.parameters}
            for i, slot in enumerate(self.equations.parameters):
                if slot.follows and i not in given and not dp[i]:
                    dp[i] = self._defaults[i] @ dp  # a default depends on earlier parameters only
            start = self._starts @ dp
            start[[i for i, _ in self.settings.start_q]] = 0
            start[[n + i for i, _ in self.settings.start_v]] = 0
            d[: 2 * n] = start
        return d

    @cached_property
    def _defaults(self) -> NDArray[Any]:
        return self.kernel("default_p", 0, 0, self.p)

    @cached_property
    def _starts(self) -> NDArray[Any]:
        return self.kernel("start_p", 0, 0, self.p)

    # -- jumps ----------------------------------------------------------------------------------

    def pieces(self) -> Iterator[tuple[int, int]]:
        """Yields the first row and the row after the last one of each part without a jump."""
        ends = [*(k + 1 for k in self._jumps), len(self.rows)]
        yield from zip([0, *ends[:-1]], ends, strict=True)

    @cached_property
    def _jumps(self) -> list[int]:
        """The rows that end with a jump. Rows at a switch that depends on t alone are left out, as
        at the knots of a table: neighbours cross at the same time."""
        e, n = self.equations, self.n
        found = numpy.flatnonzero(self.rows[:-1, 2])
        switch = self.rows[found, 2].astype(int) - 1 - len(e.events)
        if (switch < 0).all():
            return found.tolist()
        at = self.rows[found, 1], *numpy.split(self.ended[found], 2, axis=1), self.inputs[found]
        slopes = self.run.evaluate("switch_d", *at)
        rows = slopes.reshape(len(found), len(e.switches), -1)[numpy.arange(len(found)), switch]
        rows[:, 2 * n] = 0
        return found[(switch < 0) | rows.any(axis=1)].tolist()

    @cached_property
    def _rate_scale(self) -> NDArray[Any]:
        """The largest size of each of (q', v') in the motion."""
        took = numpy.maximum(self.rows[:, 1] - self.rows[:, 0], 1e-300)[:, None]
        return abs((self.ended - self.begun) / took).max(axis=0, initial=0.0)

    def crossing(self, k: int) -> NDArray[Any]:
        """Returns the derivative of the time of the crossing at the end of a row, by a displacement
        there. Raises NumericsFailed at a grazing."""
        e, (_, t, mark) = self.equations, self.rows[k, :3]
        events = len(e.events)
        if mark < 0:
            raise NumericsFailed(
                f"at t = {t:.10g} several events come at once: the motion has no derivative "
                "there, since another start parts them"
            )
        is_event = mark <= events
        of = e.event_names if is_event else [x.quantity for x in e.switches]
        which = int(mark) - 1 - (0 if is_event else events)
        row = self.kernel("event_d" if is_event else "switch_d", k, 1)[which]
        f = self.ending(k)
        n = 2 * self.n
        rate = row[:n] @ f + row[n]
        size = abs(row[:n]) @ self._rate_scale + abs(row[n])
        if not abs(rate) > GRAZES * size:
            raise NumericsFailed(
                f"at t = {t:.10g} the motion grazes {of[which].name}: it has no derivative "
                "there, since a neighbour may not cross"
            )
        return numpy.append(-numpy.delete(row, n) / rate, 0.0)

    def saltation(self, k: int) -> NDArray[Any]:
        """Returns the derivative of the jump at the end of a row, by the displacement before it."""
        e, n = self.equations, 2 * self.n
        of_time, mark = self.crossing(k), int(self.rows[k][2])
        jump = numpy.eye(self.width)
        shift = numpy.append(self.ending(k), numpy.zeros(self.m))  # of (q, v, u) by the time
        if mark <= len(e.events):
            found = numpy.zeros((n + self.m, self.width))
            for j in {*range(self.width)} - self._flags:
                found[:, j] = self._jump(k, numpy.eye(self.width)[j])
            jump[: n + self.m, :-1] = found[:, :-1]
            shift = found[:, :n] @ shift[:n] + found[:, -1]
        elif not numpy.array_equal(*(numpy.hstack(self.state(*at)) for at in ((k, 1), (k + 1, 0)))):
            raise NumericsFailed(
                f"at t = {self.rows[k][1]:.10g} rates jump at a switch of "
                f"{e.switches[mark - 1 - len(e.events)].quantity.name}: no derivative is known"
            )
        if self.fixed:
            jump[-1] = of_time
        else:
            shift[:n] -= self.rates(k + 1, 0)
        jump[: n + self.m] += numpy.outer(shift, of_time)
        return jump

    @cached_property
    def _flags(self) -> set[int]:
        """The places of inputs that are 1 while a contact holds, or 0."""
        c, g = self.equations.constraints, self.equations.graph
        first = [g.data[m.mode].index for m in (c.meetings if c else ())]
        return {2 * self.n + k + i for k in first for i in (0, 2)}

    def _jump(self, k: int, displacement: NDArray[Any]) -> NDArray[Any]:
        """Returns the derivative of (q, v, u) after the event at the end of a row. Raises
        NumericsFailed."""
        found, d = numpy.zeros(2 * self.n + self.m), numpy.ascontiguousarray(displacement)
        given = self.run._run, k, _pointer(d), _pointer(found)
        status = STATUSES[self.run._c.pk_run_tape_jump(*given)]
        if status != "PK_DONE":
            raise NumericsFailed(
                f"at t = {self.rows[k][1]:.10g} neighbours of the motion go on otherwise "
                f"({status}): it has no derivative there"
            )
        return found

    # -- forward --------------------------------------------------------------------------------

    def forward(self, D: NDArray[Any], times: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Propagates the displacements D, of shape (columns, width), from the start. Returns the
        states (q, v) at the ascending times, and the displacements there, of shape (times, columns,
        width). A time of a jump is that before it. D becomes the displacement at the end."""
        states = numpy.zeros((len(times), 2 * self.n))
        found = numpy.zeros((len(times), *D.shape))
        for begin, end in self.pieces():
            last = end == len(self.rows)
            inside = times <= self.rows[end - 1][1] if not last else times < numpy.inf
            if begin:
                inside &= times > self.rows[begin - 1][1]
            which = numpy.flatnonzero(inside)
            out = numpy.zeros((len(which), 1 + len(D), 2 * self.n))
            at = numpy.minimum(times[which], self.rows[end - 1][1])
            self._tangent(begin, end, D, at, out)
            states[which] = out[:, 0]
            found[which] = D
            found[which, :, : 2 * self.n] = out[:, 1:]
            if not last:
                D[:] = D @ self.saltation(end - 1).T
        return states, found

    def backward(self, slope: NDArray[Any]) -> NDArray[Any] | None:
        """Returns the derivative of a number by the displacement at the start, from that by the
        displacement at the end, in one pass; None if the method does not go backwards."""
        found, pieces = numpy.array(slope, float), [*self.pieces()]
        shifts = self.fixed and len(pieces) > 1
        for begin, end in reversed(pieces):
            if end < len(self.rows):
                found = found @ self.saltation(end - 1)
            given = self.run._run, begin, end, shifts, _pointer(found)
            status = self.run._c.pk_run_adjoint(*given)
            if STATUSES[status] == "PK_REFUSED":
                return None
            self._done(status)
        return found

    @property
    def stopped(self) -> bool:
        """Whether an event ended the run."""
        return self.run.report.get("status") == "PK_STOPPED_EVENT"

    def _tangent(
        self, begin: int, end: int, D: NDArray[Any], times: NDArray[Any], out: NDArray[Any]
    ) -> None:
        given = len(D), _pointer(D), len(times), _pointer(times), _pointer(out)
        self._done(self.run._c.pk_run_tangent(self.run._run, begin, end, *given))

    def _done(self, code: int) -> None:
        status = STATUSES[code]
        if status == "PK_STOPPED_USER":
            raise KeyboardInterrupt
        if status != "PK_DONE":
            raise NumericsFailed(f"the derivatives by method {self.settings.method}: {status}")


def _pointer(x: NDArray[Any]) -> Any:
    return x.ctypes.data_as(POINTER(c_double))
