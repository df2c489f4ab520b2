"""SciPy and heyoka on a rigid body's seven equations, written by hand: rotation_cases.py.

Of each: DOP853 of SciPy with Python's floats and with numba's machine code, and heyoka's Taylor
methods with the numbers of the model compiled in. State: quaternion, then body rates; what an
integration took is at its end, steps and evaluations (heyoka counts none: its series are no calls).
"""

from __future__ import annotations

import importlib.metadata
import math
import time
from functools import partial

import sympy as sp

from ..builds import Build, Unavailable
from ..contender import COARSE_TOLERANCES, Callback, Contender
from . import python


def bound(case) -> list[sp.Expr]:
    """The right-hand sides with their numbers."""
    numbers = dict(zip(case.parameters, case.values, strict=True))
    return [sp.sympify(rate).subs(numbers) for rate in case.acceleration]


def right_hand_side(case, jit: bool):
    """f(t, y), as solve_ivp() calls it."""
    t = sp.Symbol("t")
    if not jit:
        return sp.lambdify((t, case.v), bound(case), modules="math", cse=True)
    return python.returning(python.filling([t, *case.v], tuple(bound(case))), len(case.v))


def _scipy(jit: bool, case, _: tuple[Build, ...]) -> list[Callback]:
    try:
        from scipy.integrate import solve_ivp
    except ImportError:
        raise Unavailable("SciPy is not installed") from None
    f = right_hand_side(case, jit)

    def integrate(setting, y0, t_end):
        begin = time.perf_counter()
        found = solve_ivp(f, (0, t_end), list(y0), method="DOP853", rtol=setting, atol=setting)
        took = time.perf_counter() - begin
        return took, [*found.y[:, -1], found.t.size - 1, found.nfev]

    kind = "numba's machine code" if jit else "Python's floats"
    version = importlib.metadata.version("scipy")
    return [Callback(integrate, f"SciPy {version}, right-hand side in {kind}")]


def taylor(case, y0, tolerance: float):
    import heyoka

    names = [heyoka.expression(str(v)) for v in case.v]
    rates = [heyoka.from_sympy(rate) for rate in bound(case)]
    system = list(zip(names, rates, strict=True))
    return heyoka.taylor_adaptive(system, list(y0), tol=tolerance)


def _heyoka(case, _: tuple[Build, ...]) -> list[Callback]:
    try:
        import heyoka  # noqa: F401
    except ImportError:
        raise Unavailable("heyoka is not installed") from None
    compiled = {}

    def integrate(setting, y0, t_end):
        if setting not in compiled:
            compiled[setting] = taylor(case, y0, setting)
        integrator = compiled[setting]
        integrator.time = 0.0
        integrator.state[:] = y0
        begin = time.perf_counter()
        steps = integrator.propagate_until(t_end)[3]
        return time.perf_counter() - begin, [*integrator.state, steps, math.nan]

    version = importlib.metadata.version("heyoka")
    return [Callback(integrate, f"heyoka {version}, its LLVM for this CPU, default mode")]


def contenders() -> list[Contender]:
    slow = {"ladder": COARSE_TOLERANCES, "slow": True}
    tight = (*COARSE_TOLERANCES, 1e-15)
    return [
        Contender("by hand: heyoka", "C", False, _heyoka, ladder=tight),
        Contender("by hand: SciPy DOP853", "Python", False, partial(_scipy, False), **slow),
        Contender("by hand: SciPy DOP853 + numba", "Python", False, partial(_scipy, True), **slow),
    ]
