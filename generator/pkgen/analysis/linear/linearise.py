"""The linear model dx/dt = A x + B u, y = C x + D u of small changes beside a state.

x has coordinates, first-order variables and rates. With constraints or rotations there are as many
x as the motion has freedoms: a choice of these numbers on which the others depend well. T has the
dependence of all on x, a basis of the tangent space of what the constraints allow.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy
from numpy import linalg

from ...compiler import Compilation
from ...middle.motion import PARTICLES
from ...run import named
from ...run.values import Values, assignment
from ...system.exits import NumericsFailed, UsageError
from ...system.near import near
from . import modes
from .equilibria import TRIES, of_system
from .newton import least, shortened
from .rest import Equilibrium
from .system import EXACT, System, floats, opened

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
        """Returns the number of controllable freedoms, and the matrix (B, A B, A^2 B, ...)."""
        return _reached(self.A, self.B)

    def observability(self) -> tuple[int, NDArray[Any]]:
        """Returns the number of observable freedoms, and the matrix (C; C A; C A^2; ...)."""
        rank, matrix = _reached(self.A.T, self.C.T)
        return rank, matrix.T

    def transfer(self, output: str, input: str) -> tuple[NDArray[Any], NDArray[Any]]:
        """Returns the coefficients of numerator and denominator, the highest power first."""
        for name, of, kind in ((output, self.outputs, "output"), (input, self.inputs, "input")):
            if name not in of:
                raise UsageError(f"{name}: no {kind}; there are {', '.join(of) or 'none'}")
        i, j = self.outputs.index(output), self.inputs.index(input)
        from scipy.signal import ss2tf

        b, c, d = self.B[:, j : j + 1], self.C[i : i + 1], self.D[i : i + 1, j : j + 1]
        numerators, denominator = ss2tf(self.A, b, c, d)
        return numerators[0], denominator

    def discrete(self, period: float) -> Linear:
        """Returns the model of samples every `period` seconds, between which inputs are held."""
        from scipy.linalg import expm

        n, m = self.B.shape
        both = numpy.zeros((n + m, n + m))
        both[:n, :n], both[:n, n:] = self.A, self.B
        step = expm(both * period)
        rest_of = {k: x for k, x in vars(self).items() if k not in ("A", "B", "period")}
        return Linear(step[:n, :n], step[:n, n:], **rest_of, period=period)

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
        lines = []
        for name, matrix, rows, columns in (
            ("A", self.A, self.states, self.states),
            ("B", self.B, self.states, self.inputs),
            ("C", self.C, self.outputs, self.states),
            ("D", self.D, self.outputs, self.inputs),
        ):
            if matrix.size:
                table = [[name, *columns]]
                table += [
                    [row, *(f"{x:.10g}" for x in values)]
                    for row, values in zip(rows, matrix, strict=True)
                ]
                widths = [max(map(len, column)) for column in zip(*table, strict=True)]
                lines += [
                    "  ".join(x.rjust(w) for x, w in zip(row, widths, strict=True)) for row in table
                ]
        lines.append("poles: " + ", ".join(f"{z:.10g}" for z in self.poles))
        lines.append("at " + ", ".join(f"{k} = {x:.10g}" for k, x in self.state.items()))
        if self.inputs:
            reached = self.controllability()[0]
            lines.append(f"controllable: {reached} of {len(self.states)}")
            lines.append("inputs " + ", ".join(f"{k} = {x:.10g}" for k, x in self.input.items()))
        lines.append(f"observable: {self.observability()[0]} of {len(self.states)}")
        return "\n".join(lines) + "\n"

    def record(self) -> dict[str, Any]:
        """Returns the model as data for JSON: matrices are lists of rows."""
        of = {name: matrix.tolist() for name, matrix in zip("ABCD", self, strict=True)}
        names = {k: list(getattr(self, k)) for k in ("states", "inputs", "outputs")}
        poles = [[z.real, z.imag] for z in self.poles.tolist()]
        at = {"t": self.t, "state": self.state, "input": self.input, "period": self.period}
        return {**of, **names, "units": self.units, "poles": poles, **at}


def _reached(A: NDArray[Any], B: NDArray[Any]) -> tuple[int, NDArray[Any]]:
    columns = [B]
    for _ in range(len(A) - 1):
        columns.append(A @ columns[-1])
    matrix = numpy.concatenate(columns, 1)
    # The rank is that of a basis grown by A: powers of A are ill-conditioned.
    basis, new = numpy.zeros((len(A), 0)), B
    while new.size:
        new = new - basis @ (basis.T @ new)
        u, s, _ = linalg.svd(new, full_matrices=False)
        new = u[:, s > NEAR * max(1.0, abs(A).max(initial=0.0))]
        basis = numpy.concatenate([basis, new], 1)
        new = A @ new
    return basis.shape[1], matrix


def _chosen(T: NDArray[Any], first: Sequence[int]) -> list[int]:
    """Returns the rows of T that the others are expressed by: those in `first` if they can be, by
    elimination with the largest pivots."""
    left, rows = T.copy(), []
    for group in (first, [k for k in range(len(T)) if k not in first]):
        group = list(group)
        while len(rows) < T.shape[1] and group:
            sizes = linalg.norm(left[group], axis=1)
            at = group.pop(int(sizes.argmax()))
            if sizes.max() < 1e-3:
                break
            along = left[at] / linalg.norm(left[at])
            left = left - numpy.outer(left @ along, along)
            rows.append(at)
    return sorted(rows)


def linear(
    system: System,
    compilation: Compilation,
    state: NDArray[Any],
    t: float = 0.0,
    moving: Sequence[modes.Moving] = (),
) -> Linear:
    """Returns the linear model beside a state, at the inputs of the system; `moving` as in
    modes.modes(). Raises NumericsFailed."""
    n, m, e = system.n, system.m, compilation.equations
    count, outputs = len(e.inputs), [item.name for item in e.observed_names]

    def kernel(name: str, rows: int, columns: int) -> NDArray[Any]:
        if not rows or not columns:
            return numpy.zeros((rows, columns))
        return system.kernel(name, t, state)[0].reshape(rows, columns)

    order = [*range(m), *range(2 * m, m + n), *range(m, 2 * m)]
    A = system.linearised(t, state) - sum(x * s.G[numpy.ix_(order, order)] for x, s in moving)
    M, r_u = kernel("mass", n, n), kernel("r_u", n, count)
    numbers = [*range(m), *range(n + m, 2 * n), *range(n, n + m)]  # of a state those in use
    C, D = kernel("out_x", len(outputs), 2 * n)[:, numbers], kernel("out_u", len(outputs), count)
    if not all(numpy.isfinite(x).all() for x in (A, M, r_u, C, D)):
        raise NumericsFailed(f"at t = {t:g} a derivative is not finite: M may be singular there")
    by_u = linalg.solve(M, r_u)
    B = numpy.concatenate([numpy.zeros((m, count)), by_u[m:], by_u[:m]])
    q, v = (named.coordinates(compilation, rates=x).columns(sys.maxsize) for x in (False, True))
    items, chosen = [*q, *v[m:], *v[:m]], list(range(n + m))
    if system.bound:
        T = modes.null_space(modes.kept(system, state))
        chosen = _chosen(T, [k for k in chosen if not items[k].name.endswith(".w")])
        T = T @ linalg.inv(T[chosen])
        A, B, C = (A @ T)[chosen], B[chosen], C @ T
    states = [items[k] for k in chosen]
    if not outputs:
        C, D = numpy.eye(len(chosen)), numpy.zeros((len(chosen), count))
    u = numpy.array(system.given["inputs"] if system.inputs is None else system.inputs, float)
    # Memory cells of sample blocks are inputs too; the motion reads none of them.
    held = {item.name for item in compilation.model.inputs if item.by}
    reads = B.any(0) | D.any(0)
    kept = [k for k, item in enumerate(e.inputs) if reads[k] or item.name not in held]
    B, D, u, inputs = B[:, kept], D[:, kept], u[kept], [e.inputs[k] for k in kept]
    of = {"states": states, "inputs": inputs, "outputs": e.observed_names if outputs else states}
    return Linear(
        *(A, B, C, D),
        *(tuple(item.name for item in kind) for kind in of.values()),
        units={kind: [item.unit for item in listed] for kind, listed in of.items()},
        state=dict(zip([x.name for x in (*q, *v)], floats([*state[:m], *state[n:]]), strict=True)),
        input=dict(zip([x.name for x in inputs], floats(u), strict=True)),
        t=t,
    )


def _nearest(system: System, compilation: Compilation) -> tuple[NDArray[Any], list[modes.Moving]]:
    """Returns the equilibrium nearest to the start, and the symmetries along which it moves."""
    found = of_system(system, compilation, TRIES)
    if not found.equilibria:
        raise NumericsFailed(
            f"no equilibrium was found from {TRIES + 1} starts: --at t=0 is of the start itself"
        )
    by_rate = numpy.arange(system.n) >= system.m
    by_rate[system.given["cyclic"]] = True
    start = numpy.where(numpy.isnan(system.start), 0.0, system.start)

    def distance(at: Equilibrium) -> float:
        d = numpy.where(by_rate, at.v - system.v(start), at.q - system.q(start))
        turns = numpy.array(found.turns[: system.n])
        d = numpy.where(turns, numpy.remainder(d + math.pi, 2 * math.pi) - math.pi, d)
        return float(abs(d / numpy.array(found.box)).max(initial=0.0))

    at = min(found.equilibria, key=distance)
    return numpy.array([*at.q, *at.v]), list(zip(at.speeds, found.moving, strict=True))


def _trim(system: System, compilation: Compilation, wanted: Mapping[str, float]) -> NDArray[Any]:
    """Returns a steady state near the start, at which the quantities `wanted` have their values;
    sets the inputs of the system. Coordinates move where their rates are wanted. Raises
    UsageError."""
    n, m, e = system.n, system.m, compilation.equations
    q, v = (list(named.coordinates(compilation, rates=x).names()) for x in (False, True))
    inputs, outputs = [x.name for x in e.inputs], [x.name for x in e.observed_names]
    places = {x: i for i, x in enumerate(q)} | {x: n + i for i, x in enumerate(v)}
    places |= {x: 2 * n + i for i, x in enumerate(inputs)}
    start = numpy.where(numpy.isnan(system.start), 0.0, system.start)
    z = numpy.array([*start, *system.given["inputs"]])
    for name in wanted.keys() & places.keys():
        z[places[name]] = wanted[name]
    fixed = {places.get(name) for name in wanted}
    free = [i for i in (*range(m), *range(n, len(z))) if i not in fixed]
    size = numpy.fmax(abs(z), 1.0)

    def equations(z: NDArray[Any]) -> NDArray[Any]:
        states, system.inputs = z[:, : 2 * n], z[:, 2 * n :]
        rates = [i for i in range(m + system.turning) if v[i] not in wanted]
        parts = [states[:, n:][:, rates], system.kernel("acceleration", 0.0, states)]
        for name, value in wanted.items():
            if name not in places:
                out = system.kernel("outputs", 0.0, states)
                parts.append(out[:, outputs.index(name), None] - value)
        if system.given["holonomic"]:
            parts.append(system.kernel("constraint", 0.0, states))
        if system.given["constraints"]:
            parts.append(system.kernel("constraint rates", 0.0, states))
        return numpy.concatenate(parts, 1)

    for _ in range(60):
        by = 1e-6 * numpy.diag(size)[free]
        gap = equations(numpy.concatenate([z + by, z - by, z[None]]))
        slopes = (gap[: len(free)] - gap[len(free) : -1]).T / 2e-6
        if not numpy.isfinite(gap).all():
            break
        (step,), _, _ = least(gap[-1:], slopes[None])
        step = shortened(step[None], abs(step).max(keepdims=True))[0]
        z[free] += step * size[free]
        if abs(step).max() < 1e-13:
            break
    (off,) = equations(z[None])
    scale = numpy.fmax(1.0, abs(slopes).max(1))
    system.inputs = z[2 * n :]
    if not (abs(off) <= 1e-9 * scale).all():
        said = ", ".join(f"{name} = {x:g}" for name, x in wanted.items()) or "the inputs free"
        raise UsageError(
            f"--at trim: no steady state was found with {said}: want less, or start nearer"
        )
    return z[: 2 * n]


def _wanted(options: argparse.Namespace, compilation: Compilation) -> dict[str, float]:
    e = compilation.equations
    units = {x.name: x.unit for x in (*e.coordinates, *e.rates, *e.states)}
    units |= {x.name: x.unit for x in (*e.inputs, *e.observed_names)}
    values, found = Values(compilation), {}
    for given in options.want:
        name, text = assignment("--want", given)
        if name not in units:
            raise UsageError(f"--want {given}: {near(name, [*units], 'state, input or output')}")
        found[name] = values.value("--want", text, units[name], name)
    return found


def kernels() -> frozenset[str]:
    """Returns the kernels with which a model is compiled for its linear models."""
    from ...back.kernels import CANONICAL
    from ...back.kernels import KERNELS as ALL

    return frozenset(ALL) - CANONICAL - {PARTICLES, "r_p", "out_p"}


def of_model(options: argparse.Namespace, compilation: Compilation) -> Linear:
    """Returns the linear model at options.at, "equilibrium", "trim" or "t=…"; options.want has what
    a trim is asked for. The compilation has kernels(). Raises UsageError, ModelError, BuildError,
    NumericsFailed."""
    at, wanted = options.at_state, _wanted(options, compilation)
    system = opened(options, compilation, "pkgen linearise")
    if wanted and at != "trim":
        raise UsageError("--want is for --at trim")
    if at in ("equilibrium", "trim") and not system.is_steady():
        raise UsageError(f"--at {at}: the equations depend on time; give --at t=…")
    if at == "equilibrium":
        state, moving = _nearest(system, compilation)
        return linear(system, compilation, state, 0.0, moving)
    if at == "trim":
        return linear(system, compilation, _trim(system, compilation, wanted))
    if not at.startswith("t="):
        raise UsageError(f"--at {at}: give equilibrium, trim, or a time as t=2")
    values = Values(compilation)
    t = values.value("--at", at.removeprefix("t="), values.time, "t")
    motion = system.begin(EXACT, rtol=1e-12)
    if not motion.to(t):
        raise NumericsFailed(f"the motion ended at t = {motion.t:g} ({motion.status})")
    return linear(system, compilation, motion.state, t)
