"""Many double pendulums in Python: NumPy's arrays, numba's loops, heyoka's batch mode."""

from __future__ import annotations

import importlib.metadata
import time
from collections.abc import Callable

import sympy as sp

from ..builds import Unavailable
from ..models import Model, equations
from .taylor import system


def starts(members: int):
    """As c/ensembles/main.c sets them: a row a member, q then q'."""
    import numpy

    i = numpy.arange(members)
    columns = (
        1.3 + 0.002 * (i % 101),
        -0.9 + 0.003 * (i % 89),
        0.2 + 0.004 * (i % 83),
        0.4 - 0.005 * (i % 79),
    )
    return numpy.stack(columns, axis=1)


def _accelerations(model: Model, modules: str):
    numbers = dict(zip(model.parameters, model.values, strict=True))
    found = [sp.sympify(a).subs(numbers) for a in equations(model.name).acceleration]
    return sp.lambdify((*model.q, *model.v), tuple(found), modules=modules, cse=True)


def numpy_step(model: Model) -> tuple[Callable, str]:
    try:
        import numpy
    except ImportError:
        raise Unavailable("NumPy is not installed") from None
    f = _accelerations(model, "numpy")

    def slope(y):
        return numpy.stack((y[2], y[3], *f(*y)))

    def run(members: int, steps: int, h: float):
        y = numpy.ascontiguousarray(starts(members).T)
        for _ in range(steps):
            k1 = slope(y)
            k2 = slope(y + h / 2 * k1)
            k3 = slope(y + h / 2 * k2)
            k4 = slope(y + h * k3)
            y += h / 6 * (k1 + 2 * (k2 + k3) + k4)
        return y.T

    return run, f"NumPy {importlib.metadata.version('numpy')}, all members in one array"


def numba_step(model: Model) -> tuple[Callable, str]:
    try:
        import numba
    except ImportError:
        raise Unavailable("numba is not installed") from None
    f = numba.njit(_accelerations(model, "math"))

    @numba.njit
    def advance(y, steps, h):
        for m in range(len(y)):
            a, b, c, d = y[m, 0], y[m, 1], y[m, 2], y[m, 3]
            for _ in range(steps):
                e1, g1 = f(a, b, c, d)
                c2, d2 = c + h / 2 * e1, d + h / 2 * g1
                e2, g2 = f(a + h / 2 * c, b + h / 2 * d, c2, d2)
                c3, d3 = c + h / 2 * e2, d + h / 2 * g2
                e3, g3 = f(a + h / 2 * c2, b + h / 2 * d2, c3, d3)
                c4, d4 = c + h * e3, d + h * g3
                e4, g4 = f(a + h * c3, b + h * d3, c4, d4)
                a += h / 6 * (c + 2 * (c2 + c3) + c4)
                b += h / 6 * (d + 2 * (d2 + d3) + d4)
                c += h / 6 * (e1 + 2 * (e2 + e3) + e4)
                d += h / 6 * (g1 + 2 * (g2 + g3) + g4)
            y[m, 0], y[m, 1], y[m, 2], y[m, 3] = a, b, c, d
        return y

    def run(members: int, steps: int, h: float):
        return advance(starts(members), steps, h)

    run(1, 1, 0.01)
    return run, f"numba {importlib.metadata.version('numba')}, njit, one thread"


def heyoka_batch(model: Model, members: int, t_end: float) -> Callable:
    """run(tolerance) -> seconds a member, final states; batches as wide as heyoka advises."""
    try:
        import heyoka
    except ImportError:
        raise Unavailable("heyoka is not installed") from None
    import numpy

    width = heyoka.recommended_simd_size()
    members -= members % width
    first = starts(members)
    compiled = {}

    def run(tolerance: float):
        if tolerance not in compiled:
            compiled[tolerance] = heyoka.taylor_adaptive_batch(
                system(model, True), numpy.ascontiguousarray(first[:width].T), tol=tolerance
            )
        integrator = compiled[tolerance]
        final = numpy.empty_like(first)
        begin = time.perf_counter()
        for k in range(0, members, width):
            integrator.set_time(0.0)
            integrator.state[:] = first[k : k + width].T
            integrator.propagate_until(t_end)
            final[k : k + width] = integrator.state.T
        return (time.perf_counter() - begin) / members, final

    return run
