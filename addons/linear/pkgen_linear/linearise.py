"""The linear model dx/dt = A x + B u, y = C x + D u of small changes beside a state.

x has coordinates, first-order variables and rates. With constraints or rotations, x is a
well-conditioned choice of independent numbers, one for each degree of freedom. The columns of T
span the tangent space of the constraints.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy
from numpy import linalg

from pkgen.analysis.linear import modes
from pkgen.analysis.linear.equilibria import TRIES, of_system
from pkgen.analysis.linear.newton import least, shortened
from pkgen.analysis.linear.system import EXACT, System, floats, opened
from pkgen.compiler import Compilation
from pkgen.run import named
from pkgen.run.values import Values, assignment
from pkgen.system.exits import NumericsFailed, UsageError
from pkgen.system.near import near

from .plots import LinearModel

if TYPE_CHECKING:
    from numpy.typing import NDArray


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
) -> LinearModel:
    """Returns the linear model beside a state, at the inputs of the system; `moving` as in
    modes.modes(). Raises NumericsFailed."""
    n, m, e = system.n, system.m, compilation.equations
    count, outputs = len(e.inputs), [item.name for item in e.observed_names]

    def kernel(name: str, rows: int, columns: int) -> NDArray[Any]:
        if not rows or not columns:
            return numpy.zeros((rows, columns))
        return system.kernel(name, t, state)[0].reshape(rows, columns)

    A = modes.in_frame(system, system.linearised(t, state), moving)
    M, r_u = kernel("mass", n, n), kernel("r_u", n, count)
    C, D = kernel("out_x", len(outputs), 2 * n), kernel("out_u", len(outputs), count)
    C = C[:, system.unknowns_first]
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
    return LinearModel(
        *(A, B, C, D),
        *(tuple(item.name for item in kind) for kind in of.values()),
        units={kind: [item.unit for item in listed] for kind, listed in of.items()},
        state=dict(zip([x.name for x in (*q, *v)], floats(state[system.used]), strict=True)),
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
    at = found.nearest(system.q(system.begun), system.v(system.begun))
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
    z = numpy.array([*system.begun, *system.given["inputs"]])
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
        return numpy.concatenate([*parts, system.constraints(states)], 1)

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
    units = named.units(compilation)
    units.pop("energy", None)
    values, found = Values(compilation), {}
    for given in options.want:
        name, text = assignment("--want", given)
        if name not in units:
            raise UsageError(f"--want {given}: {near(name, [*units], 'state, input or output')}")
        found[name] = values.value("--want", text, units[name], name)
    return found


def of_model(options: argparse.Namespace, compilation: Compilation) -> LinearModel:
    """Returns the linear model at options.at, "equilibrium", "trim" or "t=…"; options.want has the
    wanted values of a trim. The compilation has all kernels but r_p and out_p. Raises UsageError,
    ModelError, BuildError, NumericsFailed."""
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
    if t < 0:
        raise UsageError(f"--at {at}: the motion begins at t = 0")
    motion = system.begin(EXACT, rtol=1e-12)
    if not motion.to(t):
        raise NumericsFailed(f"the motion ended at t = {motion.t:g} ({motion.status})")
    return linear(system, compilation, motion.state, t)
