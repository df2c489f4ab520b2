"""Direct multiple shooting: continuity constraints join the intervals of a motion.

Unknowns are the states at the ends of the intervals, the inputs, parameters and the duration. Each
interval is a run from its state; derivatives are exact for the numerical solution
(pkgen.analysis.sensitivity).
Reference: H. G. Bock, K. J. Plitt, IFAC Proc. 17 (1984) 1603.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy

from pkgen.analysis.sensitivity.forward import Sensitivities
from pkgen.analysis.sensitivity.tape import Tape, ran
from pkgen.api.prepare import Prepared
from pkgen.record import record
from pkgen.run import named
from pkgen.system.exits import NumericsFailed

from .problem import INTEGRAL, Problem

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Parameters of a linear input, by its number: its value where an interval begins, and its slope.
BEGIN, SLOPE = "begin_of_input_{}", "slope_of_input_{}"
# A value and its derivatives by the initial data of the interval, and by its duration.
Slopes = tuple[Any, Any, Any]


@record
class Interval:
    """The states at the end of an interval, and outputs there; each with its derivatives by the
    initial data (states, inputs and their slopes, parameters), and by the duration. The first
    interval has the states at its start, too."""

    start: Slopes | None
    end: Slopes
    outputs: dict[str, Slopes]


class Shooting:
    """The unknowns in one vector z. Places in it: `states` has those of states (intervals + 1
    rows), `u` of inputs (a row for each interval, or each end of an interval if they are linear),
    `p` of parameters, `T` of the duration."""

    def __init__(self, prepared: Prepared, problem: Problem):
        self.prepared, self.problem = prepared, problem
        of = prepared.compilation
        self.q, self.v = (named.coordinates(of, rates=r) for r in (False, True))
        self.moving = [x for x in (*self.q.names(), *self.v.names()) if x != INTEGRAL]
        self.inputs, self.parameters = [*problem.inputs], [*problem.parameters]
        n, m, N = len(self.moving), len(self.inputs), problem.intervals
        rows = N + 1 if problem.linear else N
        ends = numpy.cumsum([(N + 1) * n, rows * m, len(self.parameters)])
        self.T = int(ends[-1])
        self.size = self.T + 1
        states, u, self.p, _ = numpy.split(numpy.arange(self.size), ends)
        self.states, self.u = states.reshape(N + 1, n), u.reshape(rows, m)
        self._kept: tuple[bytes, Any] = (b"", None)
        self.failed = ""
        self.runs = 0

    # -- one interval -----------------------------------------------------------------------------

    def _settings(self, z: NDArray[Any], k: int) -> Prepared:
        prepared, problem = self.prepared, self.problem
        of, h = prepared.compilation, z[self.T] / problem.intervals
        parameters, inputs = named.parameters(of), named.inputs(of)
        values, held = dict(prepared.settings.parameters), dict(prepared.settings.inputs)
        for name, place in zip(self.parameters, self.p, strict=True):
            values[parameters[name][0]] = float(z[place])
        for j, name in enumerate(self.inputs):
            if problem.linear:
                a, b = z[self.u[k, j]], z[self.u[k + 1, j]]
                values[parameters[BEGIN.format(j)][0]] = float(a)
                values[parameters[SLOPE.format(j)][0]] = float((b - a) / h)
            else:
                held[inputs[name][0]] = float(z[self.u[k, j]])
        starts = dict(prepared.settings.start_q), dict(prepared.settings.start_v)
        for name, place in zip(self.moving, self.states[k], strict=True):
            if k or name in problem.starts:  # others have starts of the model, by its parameters
                of_rate = name not in self.q
                starts[of_rate][(self.q, self.v)[of_rate][name][0]] = float(z[place])
        settings = replace(
            prepared.settings,
            until=float(h),
            every=float(h),
            parameters=tuple(values.items()),
            inputs=tuple(held.items()),
            start_q=tuple(starts[0].items()),
            start_v=tuple(starts[1].items()),
        )
        return replace(prepared, settings=settings)

    def interval(self, z: NDArray[Any], k: int) -> Interval | None:
        """Integrates interval k; None if that fails."""
        problem, run = self.problem, self._settings(z, k)
        self.runs += 1
        inner = [x.format(j) for x in (BEGIN, SLOPE) for j in range(len(self.inputs))]
        by = [*self.moving, *(inner if problem.linear else self.inputs), *self.parameters]
        h = run.settings.until
        try:
            tape = ran(run)
            found = Sensitivities(tape, by, numpy.array([h]))
            rates = tape.ending(len(tape.rows) - 1)
            names = {*problem.end, *problem.path, problem.column, *problem.periodic.values()}
            names -= {*self.moving, "t", ""}
            outputs = {x: self._output(tape, found, x, rates) for x in names}
            if problem.integral:
                of_time = float(rates[-1])
                outputs[INTEGRAL] = found.values(INTEGRAL)[0], found.of(INTEGRAL)[0], of_time
        except NumericsFailed as error:
            self.failed = str(error)
            return None
        n, nq = len(self.moving), self.q.count
        places = [*range(nq), *range(tape.n, tape.n + n - nq)]
        states, moved, _ = found.moved
        start = None
        if not k:
            started = numpy.array([tape.started(name) for name in by])[:, places].T
            start = numpy.concatenate(tape.state(0, 0)[1:3])[places], started, numpy.zeros(n)
        return Interval(start, (states[0][places], moved[0][:, places].T, rates[places]), outputs)

    @staticmethod
    def _output(
        tape: Tape, found: Sensitivities, name: str, rates: NDArray[Any]
    ) -> tuple[float, NDArray[Any], float]:
        """Returns an output at the end, and its derivatives by the initial data and by the time."""
        e = tape.equations
        k = [x.name for x in e.observed_names].index(name)
        row = tape.kernel("out_d", len(tape.rows) - 1, 1)[k]
        n = 2 * tape.n
        return found.values(name)[0], found.of(name)[0], float(row[:n] @ rates + row[n])

    def spread(
        self, z: NDArray[Any], k: int, row: NDArray[Any], of_end: NDArray[Any]
    ) -> NDArray[Any]:
        """Returns rows of derivatives by z, from those by the initial data of interval k and by its
        duration h."""
        problem, found = self.problem, numpy.zeros((len(row), self.size))
        n, m, N = len(self.moving), len(self.inputs), problem.intervals
        found[:, self.states[k]] += row[:, :n]
        h = z[self.T] / N
        if problem.linear:
            begin, slope = row[:, n : n + m], row[:, n + m : n + 2 * m]
            found[:, self.u[k]] += begin - slope / h
            found[:, self.u[k + 1]] += slope / h
            change = (z[self.u[k + 1]] - z[self.u[k]]) / h**2
            of_end = of_end - slope @ change
            rest = row[:, n + 2 * m :]
        else:
            found[:, self.u[k]] += row[:, n : n + m]
            rest = row[:, n + m :]
        found[:, self.p] += rest[:, : len(self.p)]
        found[:, self.T] += of_end / N
        return found

    # -- the programme ----------------------------------------------------------------------------

    def evaluated(self, z: NDArray[Any]) -> dict[str, Any] | None:
        """Returns the objective with its gradient; equalities, and inequalities (>= 0), with their
        Jacobians. None if an interval fails."""
        key = z.tobytes()
        if self._kept[0] != key:
            self._kept = key, self._evaluated(z)
        return self._kept[1]

    def _evaluated(self, z: NDArray[Any]) -> dict[str, Any] | None:
        problem, N = self.problem, self.problem.intervals
        equalities, equalities_by, inequalities, inequalities_by = [], [], [], []
        last: dict[str, tuple[float, NDArray[Any]]] = {}
        for k in range(N):
            interval = self.interval(z, k)
            if interval is None:
                return None
            end, *slopes = interval.end
            by = self.spread(z, k, *slopes)
            by[:, self.states[k + 1]] -= numpy.eye(len(self.moving))
            equalities.append(end - z[self.states[k + 1]])
            equalities_by.append(by)
            if interval.start:
                start, *slopes = interval.start
                start_by = self.spread(z, 0, *slopes)
            for name, (value, row, of_h) in interval.outputs.items():
                found = value, self.spread(z, k, row[None], numpy.array([of_h]))[0]
                if name == INTEGRAL and k:
                    found = last[name][0] + found[0], last[name][1] + found[1]
                last[name] = found
                if name in problem.path:
                    self._limited(found, problem.path[name], inequalities, inequalities_by)
        for name in self.moving:
            row = numpy.zeros(self.size)
            row[self.states[N, self.moving.index(name)]] = 1
            last[name] = z[self.states[N, self.moving.index(name)]], row
        row = numpy.zeros(self.size)
        row[self.T] = 1
        last["t"] = z[self.T], row
        for name, (low, high) in problem.end.items():
            value, by = last[name]
            if low == high:
                equalities.append(numpy.array([value - low]))
                equalities_by.append(by[None])
            else:
                self._limited(last[name], (low, high), inequalities, inequalities_by)
        for name, column in problem.periodic.items():
            i, (value, by) = self.moving.index(name), last[column]
            equalities.append(numpy.array([value - start[i]]))
            equalities_by.append((by - start_by[i])[None])
        names = [problem.column] * bool(problem.column) + [INTEGRAL] * problem.integral
        return {
            "start": start,
            "objective": problem.sign * sum(last[name][0] for name in names),
            "gradient": problem.sign * sum(last[name][1] for name in names),
            "equalities": numpy.concatenate(equalities),
            "equalities_by": numpy.concatenate(equalities_by),
            "inequalities": numpy.array(inequalities),
            "inequalities_by": numpy.array(inequalities_by).reshape(-1, self.size),
        }

    @staticmethod
    def _limited(found: Any, ends: tuple[float, float], values: list, slopes: list) -> None:
        """Appends the inequalities by which a value is within its range, and their derivatives."""
        value, by = found
        for sign, end in zip((1, -1), ends, strict=True):
            if numpy.isfinite(end):
                values.append(sign * (value - end))
                slopes.append(sign * by)
