"""What Python users have: SciPy's DOP853 and LSODA, numba, physicskit."""

from __future__ import annotations

import importlib.metadata
import time
from functools import partial

import sympy as sp

from ..builds import Build, Unavailable
from ..contender import COARSE_TOLERANCES, HALVINGS, Callback, Contender
from ..models import Model, equations


def _right_hand_side(model: Model, jit: bool):
    """f(t, y) -> list, the parameters bound; with numba f(t, y, out), compiled."""
    derived = equations(model.name).acceleration
    arguments = (model.t, (*model.q, *model.v))
    numbers = dict(zip(model.parameters, model.values, strict=True))
    rates = [*model.v, *(sp.sympify(a).subs(numbers) for a in derived)]
    if not jit:
        return sp.lambdify(arguments, rates, modules="math", cse=True)
    return filling([model.t, *model.q, *model.v], tuple(rates))


def filling(arguments, rates: tuple):
    """f(t, y, out) by numba, of t and the numbers of y."""
    try:
        import numba
    except ImportError:
        raise Unavailable("numba is not installed") from None

    inner = numba.njit(sp.lambdify(arguments, rates, modules="math", cse=True))
    names = ", ".join(f"y[{i}]" for i in range(len(rates)))
    filled = "\n".join(f"    out[{i}] = r[{i}]" for i in range(len(rates)))
    scope = {"inner": inner}
    exec(f"def f(t, y, out):\n    r = inner(t, {names})\n{filled}\n", scope)
    return numba.njit(scope["f"])


def returning(f, length: int):
    """f(t, y) -> array, as solve_ivp() calls it."""
    import numba
    import numpy

    @numba.njit
    def right_hand_side(t, y):
        out = numpy.empty(length)
        f(t, y, out)
        return out

    return right_hand_side


def _timed(function, *arguments, **named):
    begin = time.perf_counter()
    result = function(*arguments, **named)
    return time.perf_counter() - begin, result


def _scipy(method: str, jit: bool, model: Model, _: tuple[Build, ...]) -> list[Callback]:
    try:
        from scipy.integrate import solve_ivp
    except ImportError:
        raise Unavailable("SciPy is not installed") from None
    f = _right_hand_side(model, jit)
    if jit:
        f = returning(f, 2 * model.n)

    def integrate(setting, y0, t_end):
        seconds, solution = _timed(
            solve_ivp, f, (0, t_end), list(y0), method=method, rtol=setting, atol=setting
        )
        return seconds, solution.y[:, -1]

    kind = "numba's machine code" if jit else "Python's floats"
    version = importlib.metadata.version("scipy")
    return [Callback(integrate, f"SciPy {version}, right-hand side in {kind}")]


def _numba_rk4(model: Model, _: tuple[Build, ...]) -> list[Callback]:
    f = _right_hand_side(model, True)
    import numba
    import numpy

    @numba.njit
    def run(y0, h, steps):
        n = len(y0)
        y, at = y0.copy(), y0.copy()
        k1, k2, k3, k4 = numpy.empty(n), numpy.empty(n), numpy.empty(n), numpy.empty(n)
        for step in range(steps):
            t = step * h
            f(t, y, k1)
            for i in range(n):
                at[i] = y[i] + h / 2 * k1[i]
            f(t + h / 2, at, k2)
            for i in range(n):
                at[i] = y[i] + h / 2 * k2[i]
            f(t + h / 2, at, k3)
            for i in range(n):
                at[i] = y[i] + h * k3[i]
            f(t + h, at, k4)
            for i in range(n):
                y[i] += h / 6 * (k1[i] + 2 * (k2[i] + k3[i]) + k4[i])
        return y

    def integrate(setting, y0, t_end):
        steps = round(t_end / setting)
        return _timed(run, numpy.array(y0), t_end / steps, steps)

    run(numpy.array(model.start), 1e-3, 1)
    version = importlib.metadata.version("numba")
    return [Callback(integrate, f"numba {version}, njit")]


def _physicskit_system(model: Model):
    try:
        from physicskit.classical.systems import lagrangian, rotations
    except ImportError:
        raise Unavailable("physicskit is not installed") from None
    numbers = {
        str(p).removeprefix("p_"): x for p, x in zip(model.parameters, model.values, strict=True)
    }
    makers = {
        "double_pendulum": (lagrangian.DoublePendulum, ("m1", "m2", "l1", "l2", "g"), {}),
        "coupled_oscillators": (lagrangian.CoupledOscillators, ("m", "k"), {"n": 3}),
        "bead_on_hoop": (lagrangian.BeadOnRotatingHoop, ("R", "Omega", "g"), {}),
        "elastic_pendulum": (lagrangian.ElasticPendulum, ("m", "k", "l0", "g"), {}),
        "heavy_top": (rotations.HeavySymmetricTop, ("I1", "I3", "M", "l", "g"), {}),
    }
    theirs = {"Omega": "omega", "l0": "L0"}
    make, names, more = makers[model.name]
    if model.n == 1:
        start = model.start
    else:
        start = (list(model.start[: model.n]), list(model.start[model.n :]))
    return make(*start, **{theirs.get(n, n): numbers[n] for n in names}, **more)


def _physicskit_rk4(model: Model, _: tuple[Build, ...]) -> list[Callback]:
    """Its compiled loop alone; integrate() would add an energy a step, computed in Python."""
    f = _physicskit_system(model)._deriv_njit
    import numpy
    from physicskit.classical.core.integrators import rk4_integrate

    def integrate(setting, y0, t_end):
        steps = round(t_end / setting)
        seconds, (_, y) = _timed(rk4_integrate, f, numpy.array(y0), 0.0, steps, t_end / steps)
        return seconds, y[-1]

    rk4_integrate(f, numpy.array(model.start), 0.0, 1, 1e-3)
    version = importlib.metadata.version("physicskit")
    return [Callback(integrate, f"physicskit {version}, its compiled rk4_integrate() alone")]


def contenders() -> list[Contender]:
    slow = {"ladder": COARSE_TOLERANCES, "slow": True}
    fixed = {"ladder": HALVINGS[:10], "slow": True}
    return [
        Contender("SciPy DOP853", "Python", False, partial(_scipy, "DOP853", False), **slow),
        Contender("SciPy DOP853 + numba", "Python", False, partial(_scipy, "DOP853", True), **slow),
        Contender("SciPy LSODA", "Python", False, partial(_scipy, "LSODA", False), **slow),
        Contender("numba RK4", "Python", True, _numba_rk4, **fixed),
        Contender("physicskit RK4", "Python", True, _physicskit_rk4, **fixed),
    ]
