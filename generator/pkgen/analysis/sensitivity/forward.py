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


# For each kind of column that a kernel computes: the kernel, and that of its derivatives.
KERNELS = {"observed": ("outputs", "out_d"), "energy": ("energy", "energy_d")}


def column(tape: Tape, name: str) -> tuple[str, int]:
    """Returns the kind of a column, one of KERNELS, "t" or "state", and its index; a state is
    (q, v). Raises UsageError."""
    kinds = named.kinds(tape.compilation)
    for kind, of in kinds.items():
        if name in of:
            k = of[name][0]
            return (kind, k) if kind in KERNELS else ("state", k + (tape.n if kind == "v" else 0))
    if name == "t":
        return "t", 0
    known = ["t", *(x for of in kinds.values() for x in of)]
    raise UsageError(f"of {name}: {near(name, known, 'column')}")


class Sensitivities:
    """s["theta1", "m1"] has the derivatives of a column by a parameter, a start or an input, of
    shape (rows,). Each row is held at its time; if an event ended the run, the last row moves with
    the event, and "t" is a column too."""

    def __init__(self, tape: Tape, by: Sequence[str], times: NDArray[Any]):
        """Raises UsageError."""
        self.tape, self.by = tape, tuple(by)
        self._t = numpy.ascontiguousarray(times)
        self._known: dict[str, NDArray[Any]] = {}
        self._starts = [tape.started(name) for name in by]

    @cached_property
    def moved(self) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        """The states at the rows; the displacements there, of shape (rows, by, width); and the
        derivatives of the times of the rows."""
        tape = self.tape
        D = numpy.array(self._starts).reshape(len(self.by), tape.width)
        states, D = tape.forward(D, self._t)
        of_t = numpy.zeros((len(self._t), len(self.by)))
        if tape.stopped and len(tape.rows) and len(self._t):
            last = len(tape.rows) - 1
            of_t[-1] = D[-1] @ tape.crossing(last)
            D[-1, :, : 2 * tape.n] += numpy.outer(of_t[-1], tape.ending(last))
        return states, D, of_t

    @cached_property
    def _inputs(self) -> NDArray[Any]:
        """The inputs at the rows; events may set them."""
        ends = self.tape.rows[:, 1]
        return self.tape.inputs[numpy.minimum(ends.searchsorted(self._t), len(ends) - 1)]

    def _by_kernel(self, name: str) -> NDArray[Any]:
        """Returns the derivatives of what a kernel writes, of shape (rows, quantities, by)."""
        if name in self._known:
            return self._known[name]
        n = self.tape.n
        states, D, of_t = self.moved
        q, v = states[:, :n], states[:, n:]
        found = self.tape.run.evaluate(name, self._t, q, v, self._inputs)
        J = found.reshape(len(self._t), -1, self.tape.width)
        by_t = J[:, :, 2 * n, None] * of_t[:, None, :]
        self._known[name] = numpy.delete(J, 2 * n, axis=2) @ D[:, :, :-1].transpose(0, 2, 1) + by_t
        return self._known[name]

    def of(self, name: str) -> NDArray[Any]:
        """Returns the derivatives of a column by all of `by`, of shape (rows, by)."""
        kind, k = column(self.tape, name)
        if kind == "t":
            return self.moved[2]
        if kind in KERNELS:
            return self._by_kernel(KERNELS[kind][1])[:, k]
        return self.moved[1][:, :, k]

    def values(self, name: str) -> NDArray[Any]:
        """Returns a column but t at the rows, of shape (rows,)."""
        kind, k = column(self.tape, name)
        n, states = self.tape.n, self.moved[0]
        if kind == "state":
            return states[:, k]
        given = self._t, states[:, :n], states[:, n:], self._inputs
        return self.tape.run.evaluate(KERNELS[kind][0], *given)[:, k]

    def __getitem__(self, key: tuple[str, str]) -> NDArray[Any]:
        of, by = key
        if by not in self.by:
            raise KeyError(f"{by}: the derivatives are by {', '.join(self.by)}")
        return self.of(of)[:, self.by.index(by)]
