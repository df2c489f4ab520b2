"""The derivative of the last value of a column: backwards if the method allows it, else forward."""

from __future__ import annotations

from collections.abc import Sequence

import numpy

from .forward import KERNELS, Sensitivities, column
from .tape import Tape


def gradient(tape: Tape, of: str, by: Sequence[str], t: float) -> dict[str, float]:
    """Returns the derivatives of the value at the end t of the run, by name. Raises UsageError,
    NumericsFailed."""
    slope = tape.backward(at_end(tape, of)) if len(tape.rows) else None
    if slope is None:
        found = Sensitivities(tape, by, numpy.array([t])).of(of)[-1]
    else:
        found = [tape.started(name) @ slope for name in by]
    return dict(zip(by, map(float, found), strict=True))


def at_end(tape: Tape, of: str) -> numpy.ndarray:
    """Returns the derivative of a column by the displacement before the end."""
    last, n = len(tape.rows) - 1, 2 * tape.n
    kind, k = column(tape, of)
    row = numpy.zeros(tape.width)  # by (q, v, t, u, p)
    if kind == "state":
        row[k] = 1
    elif kind == "t":
        row[n] = 1
    else:
        row = tape.kernel(KERNELS[kind][1], last, 1)[k]
    found = numpy.append(numpy.delete(row, n), 0.0)
    if tape.stopped:
        found += (row[:n] @ tape.ending(last) + row[n]) * tape.crossing(last)
    return found
