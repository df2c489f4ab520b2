"""The derivatives of the columns of a run, at all its rows, by forward differentiation."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy

from ...run import named
from ...system.exits import UsageError
from ...system.near import near
from .tape import Tape

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Sensitivities:
    """s["theta1", "m1"] has the derivatives of a column by a parameter, a start or an input, of
    shape (rows,). Each row is held at its time; if an event ended the run, the last row moves with
    the event, and "t" is a column too."""

    def __init__(self, tape: Tape, by: Sequence[str], times: NDArray[Any]):
        """Raises UsageError, NumericsFailed."""
        self._tape, self._by, self._t = tape, list(by), numpy.ascontiguousarray(times)
        D = numpy.array([tape.started(name) for name in by]).reshape(len(by), tape.width)
        self._states, self._D = tape.forward(D, self._t)
        self._of_t = numpy.zeros((len(times), len(by)))
        if tape.stopped and len(tape.rows) and len(times):
            n, last = 2 * tape.n, self._D[-1]
            self._of_t[-1] = last @ tape.crossing(len(tape.rows) - 1)
            last[:, :n] += numpy.outer(self._of_t[-1], tape.ending(len(tape.rows) - 1))

    @property
    def by(self) -> tuple[str, ...]:
        return tuple(self._by)

    @cached_property
    def _inputs(self) -> NDArray[Any]:
        ends = self._tape.rows[:, 1]
        row = numpy.minimum(numpy.searchsorted(ends, self._t), len(ends) - 1)
        return self._tape.rows[row, 3 + 4 * self._tape.n :]

    def _kernel(self, name: str) -> NDArray[Any]:
        """Returns the derivatives that a kernel of one state writes, by rows and by `by`, of shape
        (rows, quantities, by)."""
        n = self._tape.n
        q, v = self._states[:, :n], self._states[:, n:]
        found = self._tape.run.evaluate(name, self._t, q, v, self._inputs)
        J = found.reshape(len(self._t), -1, self._tape.width)
        by_t = J[:, :, 2 * n, None] * self._of_t[:, None, :]
        return numpy.delete(J, 2 * n, axis=2) @ self._D[:, :, :-1].transpose(0, 2, 1) + by_t

    @cached_property
    def _outputs(self) -> NDArray[Any]:
        return self._kernel("out_d")

    @cached_property
    def _energy(self) -> NDArray[Any]:
        return self._kernel("energy_d")[:, 0]

    def of(self, name: str) -> NDArray[Any]:
        """Returns the derivatives of a column by all of `by`, of shape (rows, by)."""
        kinds, n = named.kinds(self._tape.compilation), self._tape.n
        if name == "t":
            return self._of_t
        for kind, of in kinds.items():
            if name not in of:
                continue
            k = of[name][0]
            if kind == "observed":
                return self._outputs[:, k]
            return self._energy if kind == "energy" else self._D[:, :, k + n * (kind == "v")]
        known = ["t", *(x for of in kinds.values() for x in of)]
        raise UsageError(f"of {name}: {near(name, known, 'column')}")

    def __getitem__(self, key: tuple[str, str]) -> NDArray[Any]:
        of, by = key
        if by not in self._by:
            raise KeyError(f"{by}: the derivatives are by {', '.join(self._by)}")
        return self.of(of)[:, self._by.index(by)]
