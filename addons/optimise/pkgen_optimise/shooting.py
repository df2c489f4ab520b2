"""Direct multiple shooting: the motion is integrated in pieces, whose ends must meet.

Unknowns are the states at the ends of the pieces, the inputs, parameters and the duration. Each
piece is a run from its state; derivatives are those of the very steps (pkgen.analysis.sensitivity).
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

from .wanted import INTEGRAL, Wanted

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Parameters of a linear input, by its number: its value where a piece begins, and its slope.
BEGIN, SLOPE = "begin_of_input_{}", "slope_of_input_{}"
Slopes = tuple[Any, Any, Any]  # values, derivatives by what a piece begins with, by its duration


@record
class Piece:
    """The states at the start and the end of a piece, and outputs at the end; each with its
    derivatives by (states, inputs and their slopes, parameters), and by the duration."""

    start: Slopes
    end: Slopes
    outputs: dict[str, Slopes]


class Shooting:
    """The unknowns in one vector z: `at` has the places of states (pieces + 1 rows), of inputs (a
    row for each piece, or each end of a piece if they are linear), of parameters, of the
    duration."""

    def __init__(self, prepared: Prepared, wanted: Wanted):
        self.prepared, self.wanted = prepared, wanted
        of = prepared.compilation
        self.q, self.v = (named.coordinates(of, rates=r) for r in (False, True))
        self.moving = [x for x in (*self.q.names(), *self.v.names()) if x != INTEGRAL]
        self.inputs, self.parameters = [*wanted.inputs], [*wanted.parameters]
        n, m, N = len(self.moving), len(self.inputs), wanted.pieces
        rows = N + 1 if wanted.linear else N
        places = iter(range(10**9))
        self.states = numpy.array([[next(places) for _ in range(n)] for _ in range(N + 1)])
        self.u = numpy.array([[next(places) for _ in range(m)] for _ in range(rows)], int)
        self.u = self.u.reshape(rows, m)
        self.p = numpy.array([next(places) for _ in self.parameters], int)
        self.T = next(places)
        self.size = self.T + 1
        self._kept: tuple[bytes, Any] = (b"", None)
        self.failed = ""
        self.runs = 0

    # -- one piece --------------------------------------------------------------------------------

    def _settings(self, z: NDArray[Any], k: int) -> Prepared:
        prepared, w = self.prepared, self.wanted
        of, h = prepared.compilation, z[self.T] / w.pieces
        parameters, inputs = named.parameters(of), named.inputs(of)
        values, held = dict(prepared.settings.parameters), dict(prepared.settings.inputs)
        for name, place in zip(self.parameters, self.p, strict=True):
            values[parameters[name][0]] = float(z[place])
        for j, name in enumerate(self.inputs):
            if w.linear:
                a, b = z[self.u[k, j]], z[self.u[k + 1, j]]
                values[parameters[BEGIN.format(j)][0]] = float(a)
                values[parameters[SLOPE.format(j)][0]] = float((b - a) / h)
            else:
                held[inputs[name][0]] = float(z[self.u[k, j]])
        starts = dict(prepared.settings.start_q), dict(prepared.settings.start_v)
        for name, place in zip(self.moving, self.states[k], strict=True):
            if k or name in w.starts:  # others have starts of the model, by its parameters
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

    def piece(self, z: NDArray[Any], k: int) -> Piece | None:
        """Integrates piece k; None if that fails."""
        w, run = self.wanted, self._settings(z, k)
        self.runs += 1
        inner = [x.format(j) for x in (BEGIN, SLOPE) for j in range(len(self.inputs))]
        by = [*self.moving, *(inner if w.linear else self.inputs), *self.parameters]
        h = run.settings.until
        try:
            tape = ran(run)
            found = Sensitivities(tape, by, numpy.array([h]))
            started = numpy.array([tape.started(name) for name in by])
            rates = tape.ending(len(tape.rows) - 1)
            names = {*w.end, *w.path, w.minimise, *w.periodic.values()} - {*self.moving, "t", ""}
            outputs = {x: self._output(tape, found, x, rates) for x in names}
            if w.integral:
                of_time = float(rates[-1])
                outputs[INTEGRAL] = found.values(INTEGRAL)[0], found.of(INTEGRAL)[0], of_time
        except NumericsFailed as error:
            self.failed = str(error)
            return None
        n, nq = len(self.moving), self.q.count
        places = [*range(nq), *range(tape.n, tape.n + n - nq)]
        states, moved, _ = found.moved
        start = numpy.concatenate(tape.state(0, 0)[1:3])
        return Piece(
            (start[places], started[:, places].T, numpy.zeros(n)),
            (states[0][places], moved[0][:, places].T, rates[places]),
            outputs,
        )

    @staticmethod
    def _output(
        tape: Tape, found: Sensitivities, name: str, rates: NDArray[Any]
    ) -> tuple[float, NDArray[Any], float]:
        """Returns an output at the end, and its derivatives by what begins and by the time."""
        e = tape.equations
        k = [x.name for x in e.observed_names].index(name)
        row = tape.kernel("out_d", len(tape.rows) - 1, 1)[k]
        n = 2 * tape.n
        return found.values(name)[0], found.of(name)[0], float(row[:n] @ rates + row[n])

    def spread(
        self, z: NDArray[Any], k: int, row: NDArray[Any], of_end: NDArray[Any]
    ) -> NDArray[Any]:
        """Returns a row of derivatives by z, from those by what piece k begins with and by its
        duration h."""
        w, found = self.wanted, numpy.zeros((len(row), self.size))
        n, m, N = len(self.moving), len(self.inputs), self.wanted.pieces
        found[:, self.states[k]] += row[:, :n]
        h = z[self.T] / N
        if w.linear:
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
        """Returns the aim with its gradient; equalities, and inequalities (>= 0), with their
        Jacobians. None if a piece fails."""
        key = z.tobytes()
        if self._kept[0] != key:
            self._kept = key, self._evaluated(z)
        return self._kept[1]

    def _evaluated(self, z: NDArray[Any]) -> dict[str, Any] | None:
        w, N = self.wanted, self.wanted.pieces
        equal, equal_by, above, above_by = [], [], [], []
        last: dict[str, tuple[float, NDArray[Any]]] = {}
        for k in range(N):
            piece = self.piece(z, k)
            if piece is None:
                return None
            end, *slopes = piece.end
            by = self.spread(z, k, *slopes)
            by[:, self.states[k + 1]] -= numpy.eye(len(self.moving))
            equal.append(end - z[self.states[k + 1]])
            equal_by.append(by)
            if not k:
                start, *slopes = piece.start
                start_by = self.spread(z, 0, *slopes)
            for name, (value, row, of_h) in piece.outputs.items():
                found = value, self.spread(z, k, row[None], numpy.array([of_h]))[0]
                if name == INTEGRAL and k:
                    found = last[name][0] + found[0], last[name][1] + found[1]
                last[name] = found
                if name in w.path:
                    self._limited(last[name], w.path[name], above, above_by)
        for name in self.moving:
            row = numpy.zeros(self.size)
            row[self.states[N, self.moving.index(name)]] = 1
            last[name] = z[self.states[N, self.moving.index(name)]], row
        row = numpy.zeros(self.size)
        row[self.T] = 1
        last["t"] = z[self.T], row
        for name, (low, high) in w.end.items():
            value, by = last[name]
            if low == high:
                equal.append(numpy.array([value - low]))
                equal_by.append(by[None])
            else:
                self._limited(last[name], (low, high), above, above_by)
        for name, column in w.periodic.items():
            i, (value, by) = self.moving.index(name), last[column]
            equal.append(numpy.array([value - start[i]]))
            equal_by.append((by - start_by[i])[None])
        names = [w.minimise] * bool(w.minimise) + [INTEGRAL] * w.integral
        aim = sum(last[name][0] for name in names)
        return {
            "start": start,
            "aim": w.sign * aim,
            "slope": w.sign * sum(last[name][1] for name in names),
            "equal": numpy.concatenate(equal),
            "equal_by": numpy.concatenate(equal_by),
            "above": numpy.array(above),
            "above_by": numpy.array(above_by).reshape(len(above), self.size),
        }

    @staticmethod
    def _limited(found: Any, ends: tuple[float, float], above: list, above_by: list) -> None:
        value, by = found
        for sign, end in zip((1, -1), ends, strict=True):
            if numpy.isfinite(end):
                above.append(sign * (value - end))
                above_by.append(sign * by)
