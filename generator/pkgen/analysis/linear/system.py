"""A compiled model with the settings of a run: its properties, kernels and integrations."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy

from ...compiler import Compilation
from ...middle.refused import refuse_statements
from ...run.build import build_library
from ...run.integration import Integration
from ...run.library import load
from ...run.settings import Settings
from ...scenes import run_settings, scene
from ...system.exits import UsageError

MOST_STEPS = 4_000_000
RTOL = 1e-10  # relative tolerance of the reference motion
EXACT = "dop853"


class TimeUp(Exception):
    """Raised when the time budget is used up."""


def floats(xs: numpy.ndarray) -> tuple[float, ...]:
    return tuple(map(float, xs))


class System:
    """States are arrays of q, then v. Unknown i is q_i, or v_i for a first-order variable. Kernels
    take `inputs`, of shape (inputs,) or (states, inputs); None: those of the settings."""

    inputs: numpy.ndarray | None = None

    def __init__(
        self, program: Path, settings: Settings, left: Callable[[], float] = lambda: math.inf
    ):
        """Raises UsageError if the settings are wrong. Computations raise TimeUp if left() returns
        no more seconds."""
        self.program, self.settings, self.left = program, settings, left
        self.run = load(program).run(settings, idle=True, bare=1)
        if self.run.messages.strip():
            raise UsageError(self.run.messages.strip().splitlines()[-1])
        given = self.run.given()
        self.given = given
        self.n, self.m = len(given["v"]), len(given["q"])  # numbers of unknowns and of coordinates
        self.turning = 3 * given["rotations"]  # number of body rates in v, before quaternions
        self.bound = bool(given["rotations"] or given["constraints"])
        unread = [0.0] * (self.n - self.m)
        self.start = numpy.array([*given["q"], *unread, *given["v"]], float)  # None becomes NaN
        self.begun = numpy.where(numpy.isnan(self.start), 0.0, self.start)
        n, m = self.n, self.m
        # Indices of the entries of a state in use, in the order (q, v), and (unknowns, rates).
        self.used = numpy.array([*range(m), *range(n, 2 * n)])
        self.unknowns_first = numpy.array([*range(m), *range(n + m, 2 * n), *range(n, n + m)])
        self.until = settings.until
        self.idle = numpy.zeros(self.n, bool)  # unknowns on which no rate depends
        self.idle[given["cyclic"]] = True
        others = self.m + 7 * given["rotations"]
        if self.n > others:
            self.idle[self.m :] = self._unread()
        # If rates depend on first-order variables, methods are judged by the distance of the motion
        # from its start instead of the energy.
        self.by_norm = not self.idle[others:].all()
        self.reach: numpy.ndarray | None = None  # largest distance of each unknown from its start
        self.middle = self.box = numpy.zeros(0)  # set by cover(): arrays like a state

    def look(self) -> None:
        """Raises TimeUp if the time is used up; called between calls of the runtime."""
        if self.left() <= 0:
            raise TimeUp

    def q(self, states: numpy.ndarray) -> numpy.ndarray:
        return states[..., : self.n]

    def v(self, states: numpy.ndarray) -> numpy.ndarray:
        return states[..., self.n :]

    def kernel(self, name: str, t: numpy.ndarray | float, states: numpy.ndarray) -> numpy.ndarray:
        states = numpy.atleast_2d(states)
        u = self.inputs
        given = None if u is None else numpy.broadcast_to(u, (len(states), u.shape[-1]))
        return self.run.evaluate(name, t, self.q(states), self.v(states), given)

    def constraints(self, states: numpy.ndarray) -> numpy.ndarray:
        """Returns what the constraints keep at 0, phi and then J v + j0."""
        names = ["constraint"] * bool(self.given["holonomic"])
        names += ["constraint rates"] * bool(self.given["constraints"])
        none = numpy.zeros((len(numpy.atleast_2d(states)), 0))
        return numpy.concatenate([none, *(self.kernel(x, 0.0, states) for x in names)], 1)

    def begin(self, method: str, state: numpy.ndarray | None = None, **more: float) -> Integration:
        return Integration(
            self.run, method, self.start if state is None else state, look=self.look, **more
        )

    def reference(self, looser: float = 1.0, watch: int = 0) -> Integration:
        """Begins the reference motion, with its rtol multiplied by `looser`."""
        return self.begin(EXACT, rtol=looser * RTOL, watch=watch)

    def apart(self, states: numpy.ndarray) -> numpy.ndarray:
        """Returns for each state the displacement of each unknown from its initial value."""
        m, moved = self.m, states - self.start
        return numpy.concatenate([self.q(moved)[..., :m], self.v(moved)[..., m:]], -1)

    def energies(
        self, t: numpy.ndarray | float, states: numpy.ndarray
    ) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray, numpy.ndarray]:
        """Returns four arrays, by which methods are judged: the energy of each state; v.p (rates
        times momenta), whose range is the scale of energy errors; |v.p| + |L|, to which the
        round-off of the energy is relative; |v_i p_i| of each coordinate. If `by_norm` is set, the
        first three are half the squared displacement from the start, in units of `reach`. They are
        0 before cover() is called."""
        if self.by_norm:
            norm = numpy.zeros(len(states))
            if self.reach is not None:
                far = ~self.idle & (self.reach > 0)
                norm = ((self.apart(states)[:, far] / self.reach[far]) ** 2).sum(1) / 2
            return norm, norm, norm, numpy.zeros((len(states), 0))
        parts = self.v(states) * self.kernel("free momenta", t, states)
        energy = self.kernel("energy", t, states)[:, 0]
        vp = parts[:, : self.m + self.turning].sum(1)
        return energy, vp, abs(vp) + abs(vp - energy), abs(parts[:, : self.m])

    def linearised(self, t: float, state: numpy.ndarray) -> numpy.ndarray:
        """Returns the matrix A of the linearised equations z' = A z. The vector z holds the
        displacements of the unknowns, then those of the coordinates' rates. A is NaN if the mass
        matrix is singular."""
        n, m = self.n, self.m
        a_q, a_v = self.kernel("jacobian", t, state).reshape(2, n, n)
        columns = [*range(n, n + m), *range(m, n)]  # for each number in v: its index in z
        full = numpy.zeros((n, n + m))
        full[:, :m] = a_q[:, :m]
        full[:, columns] = a_v
        above = numpy.eye(m, n + m, n)
        return numpy.concatenate([above, full[m:], full[:m]])

    def _unread(self) -> numpy.ndarray:
        """Returns for each first-order variable whether no rate depends on it. The derivatives of
        all rates are computed at three test states."""
        unread = numpy.ones(self.n - self.m, bool)
        number = numpy.arange(self.n)
        by = numpy.concatenate([0.01 + 0.013 * number, 0.02 + 0.011 * number])
        for k in range(3):
            jacobian = self.kernel("jacobian", 0.0, self.start + k * by * (1 + abs(self.start)))
            unread &= (jacobian.reshape(2, self.n, self.n)[1][:, self.m :] == 0).all(0)
        return unread

    def is_steady(self) -> bool:
        """Returns whether nothing depends on time, with constant inputs."""
        if self.given["autonomous"]:
            return True
        t = numpy.array([0.0, 0.37, 1.91, 5.3])
        shifts = numpy.array([0.0, 0.13, 0.29])[:, None] * (1 + abs(self.start))
        found = [self.kernel("acceleration", t, numpy.tile(self.start + d, (4, 1))) for d in shifts]
        return all((a[1:] == a[0]).all() for a in found if numpy.isfinite(a).all())

    def kinds(self) -> list[range]:
        """Returns the index ranges, in a state, of coordinates, integrals of first-order variables,
        rates, body rates, quaternions, other first-order variables."""
        n, m, r = self.n, self.m, self.given["rotations"]
        ends = (0, m, n, n + m, n + m + 3 * r, n + m + 7 * r, 2 * n)
        return [range(a, b) for a, b in pairwise(ends)]

    def cover(self) -> None:
        """Integrates the motion. Sets the centre `middle` and the width `box` of the region that
        the motion covers, and `reach`. If a number of the state is constant, its magnitude is the
        width; if it stays 0, the largest width of a number of its kind (see kinds())."""
        if self.reach is not None:
            return
        low, high = self.start.copy(), self.start.copy()
        motion = self.reference()
        while not motion.failed and motion.t < self.until:
            states = motion.steps(self.until, MOST_STEPS)[:, 1:]
            low = numpy.fmin(low, states.min(0, initial=math.inf))
            high = numpy.fmax(high, states.max(0, initial=-math.inf))
        n, m = self.n, self.m
        unknown = [*range(m), *range(n + m, 2 * n)]
        self.reach = numpy.fmax(high - self.start, self.start - low)[unknown]
        sum_, width = low + high, high - low
        self.middle = sum_ / 2
        box = numpy.where(width > 1e-9 * abs(sum_), width, abs(sum_) / 2)
        integrals = range(m, n)
        most = max((x for i, x in enumerate(box) if i not in integrals), default=0.0)
        for kind in self.kinds():
            part = box[kind.start : kind.stop]
            part[~(part > 0)] = max(part, default=0.0) or most or 1.0
        self.box = box

    def turning_rate(self, state: numpy.ndarray) -> float:
        """Returns the rotation rate of the fastest rotating body. It is twice an eigenvalue of the
        linear equation that the body's quaternion obeys."""
        rates = self.v(state)[self.m : self.m + self.turning].reshape(-1, 3)
        return float(numpy.sqrt((rates**2).sum(1)).max(initial=0.0))


def opened(
    options: argparse.Namespace,
    compilation: Compilation,
    command: str,
    but: Sequence[str] = ("samples", "noises"),
) -> System:
    """Returns the system of a compiled model, at the start and with the parameters of `options` and
    their scene. `command` is its name in messages; it takes statements of the kinds `but`. Raises
    UsageError, ModelError, BuildError."""
    refuse_statements(compilation.declared, "pkgen stability", but, command)
    if not compilation.equations.dense:
        raise UsageError(f"{command} is of single coordinates, and the families are kept as loops")
    whole = settled(options, compilation)
    model = compilation.model
    return System(build_library(compilation.files, model.name, own=model.methods), whole)


def settled(options: argparse.Namespace, compilation: Compilation) -> Settings:
    """Returns the settings of a system: the start and the parameters alone. Raises UsageError."""
    given = argparse.Namespace(**{**vars(options), "until": "1"})
    chosen = scene.of(given, compilation.declared)
    whole = run_settings.settings(given, compilation, chosen=chosen)
    return replace(whole, every=None, method="rk4", step=None, show=(), at=None)
