"""A linear model with the names of its states, inputs and outputs, and its exports."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy
from numpy import linalg

from pkgen.system.columns import aligned
from pkgen.system.exits import UsageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

Kind = TypeVar("Kind", bound="Linear")
NEAR = 1e-9  # a singular value below this part of the largest counts as 0


@dataclass(frozen=True)
class Linear:
    """A linear model in SI units, with matrices `A, B, C, D = linear`, as in
    `scipy.signal.StateSpace(*linear)`. `state` and `input` have the values of all quantities at the
    state, by name; `period` is that of a discrete model, or 0."""

    A: NDArray[Any]
    B: NDArray[Any]
    C: NDArray[Any]
    D: NDArray[Any]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, list[str]]
    state: dict[str, float]
    input: dict[str, float]
    t: float = 0.0
    period: float = 0.0

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return iter((self.A, self.B, self.C, self.D))

    @property
    def poles(self) -> NDArray[Any]:
        found = linalg.eigvals(self.A)
        return found[numpy.lexsort((found.imag, found.real))]

    def controllability(self) -> tuple[int, NDArray[Any]]:
        """Returns the dimension of the controllable subspace, and (B, A B, A^2 B, ...)."""
        return _reached(self.A, self.B)

    def observability(self) -> tuple[int, NDArray[Any]]:
        """Returns the dimension of the observable subspace, and (C; C A; C A^2; ...)."""
        rank, matrix = _reached(self.A.T, self.C.T)
        return rank, matrix.T

    def transfer(self, output: str, input: str) -> tuple[NDArray[Any], NDArray[Any]]:
        """Returns the coefficients of numerator and denominator, the highest power first."""
        from scipy.signal import ss2tf

        numerators, denominator = ss2tf(*self._single(output, input))
        return numerators[0], denominator

    def zeros(self, output: str, input: str) -> NDArray[Any]:
        """Returns the zeros of a transfer function, some of which may be poles too."""
        from scipy.linalg import eigvals

        A, b, c, d = self._single(output, input)
        # They are fewer than the poles by the order of the first derivative of the output that
        # depends on the input. The other eigenvalues are infinite, or large by rounding.
        count, x, first = len(A), b, d[0, 0] != 0
        while not first and count:
            count, first = count - 1, abs(c @ x) > NEAR * linalg.norm(c) * linalg.norm(x)
            x = A @ x
        unit = numpy.diag([1.0] * len(A) + [0.0])
        with numpy.errstate(all="ignore"):
            found = eigvals(numpy.block([[A, b], [c, d]]), unit)
        size = numpy.where(numpy.isfinite(found), abs(found), numpy.inf)
        return found[size.argsort()[:count]] if first else found[:0]

    def response(self, s: NDArray[Any]) -> NDArray[Any]:
        """Returns C (s - A)^-1 B + D for each s, of shape (len(s), outputs, inputs); NaN at a
        pole."""
        M = s[:, None, None] * numpy.eye(len(self.A)) - self.A
        M[linalg.slogdet(M)[0] == 0] = numpy.nan
        return (
            self.C @ linalg.solve(M, numpy.broadcast_to(self.B, (len(s), *self.B.shape))) + self.D
        )

    def frequency_response(self, w: NDArray[Any]) -> NDArray[Any]:
        """Returns the transfer functions at angular frequencies, of shape (len(w), outputs,
        inputs)."""
        w = numpy.asarray(w, float)
        return self.response(numpy.exp(1j * w * self.period) if self.period else 1j * w)

    def closed_poles(self, output: str, input: str, gains: NDArray[Any]) -> NDArray[Any]:
        """Returns the poles with the feedback u = -k y for each gain k, a row each."""
        A, b, c, d = self._single(output, input)
        k = numpy.asarray(gains, float)[:, None, None]
        return linalg.eigvals(A - k / (1 + k * d) * (b @ c))

    def places(self, output: str, input: str) -> tuple[int, int]:
        """Returns the indices of an output and an input. Raises UsageError."""
        for name, of, kind in ((output, self.outputs, "output"), (input, self.inputs, "input")):
            if name not in of:
                raise UsageError(f"{name}: no {kind}; there are {', '.join(of) or 'none'}")
        return self.outputs.index(output), self.inputs.index(input)

    def _single(self, output: str, input: str) -> tuple[NDArray[Any], ...]:
        i, j = self.places(output, input)
        return self.A, self.B[:, j : j + 1], self.C[i : i + 1], self.D[i : i + 1, j : j + 1]

    # -- export -------------------------------------------------------------------------------

    def discrete(self: Kind, period: float) -> Kind:
        """Returns the model of samples every `period` seconds, between which inputs are held."""
        from scipy.linalg import expm

        n, m = self.B.shape
        both = numpy.zeros((n + m, n + m))
        both[:n, :n], both[:n, n:] = self.A, self.B
        step = expm(both * period)
        rest_of = {k: x for k, x in vars(self).items() if k not in ("A", "B", "period")}
        return type(self)(step[:n, :n], step[:n, n:], **rest_of, period=period)

    def to_ss(self) -> Any:
        """Returns a StateSpace of python-control, with the names of states, inputs and outputs."""
        import control

        of = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
        more = {k: list(names) for k, names in of.items() if names}
        return control.ss(*self, self.period, **more) if self.period else control.ss(*self, **more)

    def matlab(self) -> str:
        """Returns the text of a MATLAB or Octave script that defines `sys`."""

        def rows(matrix: NDArray[Any]) -> str:
            text = "; ".join(" ".join(f"{x:.17g}" for x in row) for row in matrix)
            return f"[{text}]" if matrix.size else f"zeros({matrix.shape[0]}, {matrix.shape[1]})"

        lines = [f"{name} = {rows(matrix)};" for name, matrix in zip("ABCD", self, strict=True)]
        period = f", {self.period:.17g}" if self.period else ""
        lines.append(f"sys = ss(A, B, C, D{period});")
        kinds = {"StateName": self.states, "InputName": self.inputs, "OutputName": self.outputs}
        for kind, names in kinds.items():
            quoted = ", ".join("'" + name.replace("'", "''") + "'" for name in names)
            lines += [f"sys.{kind} = {{{quoted}}};"] if names else []
        return "\n".join(lines) + "\n"

    def text(self) -> str:
        """Returns the model as tables."""
        lines, x, u, y = [], self.states, self.inputs, self.outputs
        for name, matrix, rows, columns in zip(
            "ABCD", self, (x, x, y, y), (x, u, x, u), strict=True
        ):
            if matrix.size:
                cells = [[f"{x:.10g}" for x in values] for values in matrix]
                table = [[name, *columns], *([r, *c] for r, c in zip(rows, cells, strict=True))]
                lines += aligned(table, right=range(len(table[0])))
        lines.append("poles: " + ", ".join(f"{z:.10g}" for z in self.poles))
        lines.append("at " + ", ".join(f"{k} = {x:.10g}" for k, x in self.state.items()))
        if self.inputs:
            lines.append(f"controllable: {self.controllability()[0]} of {len(self.states)}")
            lines.append("inputs " + ", ".join(f"{k} = {x:.10g}" for k, x in self.input.items()))
        lines.append(f"observable: {self.observability()[0]} of {len(self.states)}")
        return "\n".join(lines) + "\n"

    def record(self) -> dict[str, Any]:
        """Returns the model as data for JSON: matrices are lists of rows."""
        of = {name: matrix.tolist() for name, matrix in zip("ABCD", self, strict=True)}
        names = {k: list(getattr(self, k)) for k in ("states", "inputs", "outputs")}
        poles = [[z.real, z.imag] for z in self.poles.tolist()]
        kept = ("units", "t", "state", "input", "period")
        return {**of, **names, "poles": poles, **{k: getattr(self, k) for k in kept}}


def _reached(A: NDArray[Any], B: NDArray[Any]) -> tuple[int, NDArray[Any]]:
    """Returns the dimension of the states that B reaches, and the matrix (B, A B, A^2 B, ...)."""
    columns = [B]
    for _ in range(len(A) - 1):
        columns.append(A @ columns[-1])
    return reached(A, B).shape[1], numpy.concatenate(columns, 1)


def reached(A: NDArray[Any], B: NDArray[Any]) -> NDArray[Any]:
    """Returns an orthonormal basis of the states that B reaches. It is grown by A: powers of A are
    ill-conditioned."""
    basis, new = numpy.zeros((len(A), 0)), B
    while new.size:
        new = new - basis @ (basis.T @ new)
        u, s, _ = linalg.svd(new, full_matrices=False)
        new = u[:, s > NEAR * max(1.0, abs(A).max(initial=0.0))]
        basis = numpy.concatenate([basis, new], 1)
        new = A @ new
    return basis
