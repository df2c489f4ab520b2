"""The kernels of a model, such as M and f, as functions of arrays."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy

from ..compiler import Compilation
from ..run import named
from ..run.library import Run, load
from ..run.simulate import build
from ..scenes import run_settings as parsing
from ..system.exits import UsageError
from ..system.near import near
from . import arguments
from .arguments import DEFAULTS
from .errors import ArrayError
from .parameters import Parameters

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    U = ArrayLike | Mapping[str, ArrayLike] | None


class Kernels:
    """The base class of Model that has its kernels. Model's docstring explains the arguments."""

    params: Parameters
    compilation: Compilation
    coordinates: tuple[str, ...]
    rates: tuple[str, ...]

    @cached_property
    def _handle(self) -> Run:
        """A run that is never started. It has the current parameters and evaluates kernels."""
        compilation = self.compilation
        values = [f"{name}={value!r}" for name, value in self.params._set.items()]
        options = argparse.Namespace(**DEFAULTS, scene=None, start=[], set=values)
        options.until, options.method, options.step = "1.0", "rk4", "1.0"
        settings = parsing.settings(options, compilation)
        library = load(build(compilation, settings, None))
        return library.run(replace(settings, every=None, show=()), bare=True, idle=True)

    @property
    def inputs(self) -> tuple[str, ...]:
        return tuple(named.inputs(self.compilation).names())

    def _inputs(self, u: U) -> NDArray[Any]:
        """Returns the inputs as an array of shape (..., inputs). Inputs that u lacks are 0."""
        names = self.inputs
        if not isinstance(u, Mapping):
            (given,) = arguments.arrays(u=u)
            if given.shape[-1:] != (len(names),):
                raise ArrayError(f"u must be of shape (..., {len(names)}): {', '.join(names)}")
            return given
        for name in u.keys() - {*names}:
            raise UsageError(f"u: {near(name, [*names], 'input')}")
        columns = arguments.arrays(**{name: u.get(name, 0.0) for name in names})
        return numpy.stack(numpy.broadcast_arrays(*columns), -1)

    def _kernel(self, what: str, q: ArrayLike, v: ArrayLike, t: ArrayLike, u: U) -> NDArray[Any]:
        n, m = len(self.coordinates), len(self.rates)
        places, rates, times = arguments.arrays(q=q, v=v, t=t)
        if places.shape[-1:] != (n,) or rates.shape[-1:] != (m,):
            raise ArrayError(f"q must be of shape (..., {n}), v of shape (..., {m})")
        inputs = None if u is None else self._inputs(u)
        others = [places.shape[:-1], rates.shape[:-1], times.shape]
        others += [] if inputs is None else [inputs.shape[:-1]]
        try:
            shape = numpy.broadcast_shapes(*others)
        except ValueError as error:
            raise ArrayError(f"q, v, t and u: {error}") from None
        count = math.prod(shape)  # for reshape: -1 fails if n = 0
        found = self._handle.evaluate(
            what,
            numpy.broadcast_to(times, shape).reshape(-1),
            numpy.broadcast_to(places, (*shape, n)).reshape(count, n),
            numpy.broadcast_to(rates, (*shape, m)).reshape(count, m),
            None
            if inputs is None
            else numpy.broadcast_to(inputs, (*shape, inputs.shape[-1])).reshape(count, -1),
        )
        if m and not found.shape[1]:
            raise UsageError(
                f"{what}: families of so many members ({m} rates) are kept as loops, which have no "
                "such array here; load the model with fewer: sizes={...}"
            )
        return found.reshape(*shape, found.shape[1])

    def acceleration(
        self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None
    ) -> NDArray[Any]:
        """q'' (and x' of first-order variables), of shape (..., n); NaN where M is singular."""
        return self._kernel("acceleration", q, v, t, u)

    def f(self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None) -> NDArray[Any]:
        """The force f of M a = f, of shape (..., n)."""
        return self._kernel("force", q, v, t, u)

    def M(self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None) -> NDArray[Any]:
        """The mass matrix, of shape (..., n, n)."""
        found = self._kernel("mass", q, v, t, u)
        n = len(self.rates)
        return found.reshape(*found.shape[:-1], n, found.shape[-1] // n)

    def momenta(self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None) -> NDArray[Any]:
        """dL/dv, of shape (..., n)."""
        return self._kernel("momenta", q, v, t, u)

    def energy(self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None) -> NDArray[Any]:
        """v.dL/dv - L, of shape (...)."""
        return self._kernel("energy", q, v, t, u)[..., 0]

    def jacobian(self, q: ArrayLike, v: ArrayLike, t: ArrayLike = 0.0, u: U = None) -> NDArray[Any]:
        """The derivatives of the acceleration by q and by v, of shape (..., 2, n, n)."""
        found = self._kernel("jacobian", q, v, t, u)
        n = len(self.rates)
        return found.reshape(*found.shape[:-1], 2, n, found.shape[-1] // (2 * n))

    @property
    def start(self) -> NDArray[Any]:
        """The initial coordinates, then the initial rates: the initial y for `rhs`."""
        given = self._handle.given()
        return numpy.array([*given["q"], *given["v"]])

    def rhs(self, t: float, y: ArrayLike) -> NDArray[Any]:
        """The time derivative of y = (q, v), for solvers such as `solve_ivp(m.rhs, ...)`. y has
        the shape (n,), or (n, count) for `vectorized=True`."""
        state, times = arguments.arrays(y=y, t=t)
        n, m = len(self.coordinates), len(self.rates)
        if state.shape[:1] != (n + m,) or state.ndim > 2 or times.ndim:
            raise ArrayError(f"y must be of shape ({n + m},) or ({n + m}, count), t a number")
        q, v = state[:n].T, state[n:].T
        return numpy.concatenate([state[n : 2 * n], self.acceleration(q, v, t).T])
