"""Derivatives of runs, linear models, fits and optima beside other packages, in one run.

    python -m bench derivatives [--docs]      docs/dev/results/derivatives.md

Each row: the largest difference from pkgen's numbers, relative to their size, and CPU seconds after
compilation, the least of some turns.
"""

from __future__ import annotations

import os
import sys
import sysconfig
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy

from .environment import with_peers
from .machine import describe

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/dev/results/derivatives.md"
TURNS = 5
UNTIL, RTOL = 10.0, 1e-10
BY = ("m1", "m2", "l1", "l2", "g", "theta1", "theta2")


def timed(call: Callable[[], Any], turns: int = TURNS) -> tuple[Any, float]:
    """Returns the result, and the least CPU time, of several calls."""
    best, found = numpy.inf, None
    for _ in range(turns):
        begin = time.process_time()
        found = call()
        best = min(best, time.process_time() - begin)
    return found, best


def pendulum() -> tuple[Any, Any, Any, list[float]]:
    """The double pendulum in SymPy: state, right-hand side, parameters, their values."""
    import sympy

    q = sympy.symbols("a b")
    v = sympy.symbols("va vb")
    p = sympy.symbols("m1 m2 l1 l2 g")
    m1, m2, l1, l2, g = p
    (a, b), (va, vb) = q, v
    T = (m1 + m2) * l1**2 * va**2 / 2 + m2 * l2**2 * vb**2 / 2
    T += m2 * l1 * l2 * va * vb * sympy.cos(a - b)
    L = T + (m1 + m2) * g * l1 * sympy.cos(a) + m2 * g * l2 * sympy.cos(b)
    M = sympy.hessian(L, v)
    f = sympy.Matrix([L.diff(x) for x in q]) - sympy.Matrix([L.diff(x) for x in v]).jacobian(
        q
    ) * sympy.Matrix(v)
    return (*q, *v), [*v, *M.LUsolve(f)], p, [1.0, 1.0, 1.0, 1.0, 9.81]


def gradients() -> list[tuple[str, float, float]]:
    import pkgen

    m = pkgen.load(ROOT / "models/double_pendulum.lag")
    how = {"until": UNTIL, "every": UNTIL, "method": "dop853", "rtol": RTOL}
    mine, seconds = timed(lambda: m.gradient("theta1", BY, **how))
    _, of_run = timed(lambda: m.run(**how))
    mine = numpy.array([*mine.values()])
    start = [float(x) for x in m.start]
    rows = [("pkgen, the run alone", 0.0, of_run), ("pkgen gradient", 0.0, seconds)]
    x, rate, p, values = pendulum()
    for name, other in (
        ("SciPy DOP853 + SymPy", scipy_gradient),
        ("heyoka", heyoka_gradient),
        ("CasADi CVODES", casadi_gradient),
    ):
        call = other(x, rate, p, values, start)
        found, seconds = timed(call)
        rows.append((name, float(abs(found - mine).max() / abs(mine).max()), seconds))
    return rows


def scipy_gradient(x: Any, rate: Any, p: Any, values: Any, start: Any) -> Callable[[], Any]:
    import sympy
    from scipy.integrate import solve_ivp

    f = sympy.Matrix(rate)
    code = sympy.lambdify([x, p], [f, f.jacobian(x), f.jacobian(p)], cse=True)

    def slope(t: float, y: numpy.ndarray) -> numpy.ndarray:
        rates, by_x, by_p = code(y[:4], values)
        D = y[4:].reshape(4, 7)
        by = by_x @ D
        by[:, :5] += by_p
        return numpy.concatenate([numpy.ravel(rates), by.ravel()])

    D = numpy.zeros((4, 7))
    D[0, 5] = D[1, 6] = 1
    y0 = numpy.concatenate([start, D.ravel()])
    how = {"method": "DOP853", "rtol": RTOL, "atol": RTOL}
    return lambda: solve_ivp(slope, (0, UNTIL), y0, **how).y[4:11, -1]


def heyoka_gradient(x: Any, rate: Any, p: Any, values: Any, start: Any) -> Callable[[], Any]:
    import heyoka
    import sympy

    names = heyoka.make_vars(*map(str, x))
    swap = {str(s): heyoka.par[k] for k, s in enumerate(p)}
    known = dict(zip(map(str, x), names, strict=True)) | swap
    known |= {"sin": heyoka.sin, "cos": heyoka.cos}
    rates = [eval(sympy.sstr(sympy.simplify(r)), {}, known) for r in rate]
    system = list(zip(names, rates, strict=True))
    by = [*(heyoka.par[k] for k in range(5)), names[0], names[1]]
    var = heyoka.var_ode_sys(system, by, order=1)
    first = [*start, *numpy.zeros(var.n_orig_sv * 0)]
    ta = heyoka.taylor_adaptive(var, first, tol=RTOL, pars=values, compact_mode=True)
    begin = ta.state.copy()

    def run() -> numpy.ndarray:
        ta.time = 0.0
        ta.state[:] = begin
        ta.propagate_until(UNTIL)
        places = ta.get_vslice(component=0, order=1)
        return ta.state[places]

    return run


def casadi_gradient(x: Any, rate: Any, p: Any, values: Any, start: Any) -> Callable[[], Any]:
    import casadi
    import sympy

    X, P = casadi.SX.sym("x", 4), casadi.SX.sym("p", 5)
    code = sympy.lambdify(
        [x, p], list(rate), modules=[{"sin": casadi.sin, "cos": casadi.cos}], cse=True
    )
    ode = {"x": X, "p": P, "ode": casadi.vertcat(*code(casadi.vertsplit(X), casadi.vertsplit(P)))}
    how = {"reltol": RTOL, "abstol": RTOL, "max_num_steps": 100000}
    flow = casadi.integrator("flow", "cvodes", ode, 0, UNTIL, how)
    x0, p0 = casadi.MX.sym("x0", 4), casadi.MX.sym("p0", 5)
    end = flow(x0=x0, p=p0)["xf"][0]
    by = casadi.horzcat(casadi.jacobian(end, p0), casadi.jacobian(end, x0)[:, :2])
    of = casadi.Function("of", [x0, p0], [by])
    return lambda: numpy.array(of(start, values)).ravel()


FIT = """model swing
param l = 1
param c = 0.05
coord theta
kinetic l^2/2*theta'^2
potential -9.81*l*cos(theta)
force theta = -c*theta'
start theta = 0.7
"""


def fits(folder: Path) -> list[tuple[str, float, float]]:
    from scipy.optimize import least_squares

    import pkgen

    (folder / "swing.lag").write_text(FIT)
    m = pkgen.load(folder / "swing.lag")
    m.params.update(l=0.8, c=0.02)
    run = m.run(6, every=0.05)
    t, theta = run.t, run["theta"] + numpy.random.default_rng(0).normal(0, 0.01, len(run))
    m.params.update(l=1.0, c=0.05)
    of_fit = {"tries": 0, "sigma": {"theta": 0.01}}
    mine, seconds = timed(lambda: m.fit({"t": t, "theta": theta}, ["l", "c"], **of_fit))
    first = numpy.array([*mine.values.values()])

    def residual(x: numpy.ndarray) -> numpy.ndarray:
        m.params.update(l=float(x[0]), c=float(x[1]))
        return (m.run(6, every=0.05)["theta"] - theta) / 0.01

    other, by_scipy = timed(lambda: least_squares(residual, [1.0, 0.05], xtol=1e-12, ftol=1e-12).x)
    rows = [("pkgen fit", 0.0, seconds)]
    rows.append(("SciPy least_squares over m.run", float(abs(other / first - 1).max()), by_scipy))
    call = casadi_fit(t, theta)
    other, by_casadi = timed(call)
    rows.append(("CasADi CVODES + IPOPT", float(abs(other / first - 1).max()), by_casadi))
    return rows


def casadi_fit(t: Any, theta: Any) -> Callable[[], Any]:
    import casadi

    x, p = casadi.SX.sym("x", 2), casadi.SX.sym("p", 2)
    length, c = p[0], p[1]
    ode = casadi.vertcat(x[1], -9.81 / length * casadi.sin(x[0]) - c / length**2 * x[1])
    how = {"reltol": 1e-9, "abstol": 1e-9}
    flow = casadi.integrator("f", "cvodes", {"x": x, "p": p, "ode": ode}, 0, list(t[1:]), how)
    unknown = casadi.MX.sym("p", 2)
    found = flow(x0=[0.7, 0], p=unknown)["xf"][0, :]
    gap = (found - casadi.DM(theta[1:]).T) / 0.01
    nlp = {"x": unknown, "f": casadi.dot(gap, gap) / 2}
    quiet = {"ipopt.print_level": 0, "print_time": 0, "ipopt.sb": "yes"}
    quiet |= {"ipopt.hessian_approximation": "limited-memory", "ipopt.tol": 1e-9}
    solver = casadi.nlpsol("s", "ipopt", nlp, quiet)
    return lambda: numpy.array(solver(x0=[1.0, 0.05], lbx=1e-3)["x"]).ravel()


def linear_models() -> list[tuple[str, float, float]]:
    import control
    import sympy

    import pkgen

    m = pkgen.load(ROOT / "models/controlled/cart_pole_swing_up.lag")
    mine, seconds = timed(lambda: m.linearise("trim", want={"theta": 0}))
    M, mp, length, g = (m.params[x] for x in ("M", "m", "l", "g"))
    y = x, a, vx, va, u = sympy.symbols("x a vx va u")

    def other() -> Any:
        T = (
            M * vx**2 / 2
            + mp * (vx**2 + 2 * length * vx * va * sympy.cos(a) + length**2 * va**2) / 2
        )
        L = T - mp * g * length * sympy.cos(a)
        H = sympy.hessian(L, (vx, va))
        momenta = sympy.Matrix([L.diff(vx), L.diff(va)])
        f = sympy.Matrix([L.diff(x) + u, L.diff(a)]) - momenta.jacobian((x, a)) * sympy.Matrix(
            [vx, va]
        )
        rates = sympy.Matrix([vx, va, *H.LUsolve(f)])
        J = numpy.array(rates.jacobian(y).subs(dict.fromkeys(y, 0)), float)
        return control.ss(J[:, :4], J[:, 4:], numpy.eye(4), 0)

    found, by_sympy = timed(other, 2)
    off = max(abs(found.A - mine.A).max(), abs(found.B - mine.B).max())
    return [("pkgen linearise", 0.0, seconds), ("SymPy + python-control", float(off), by_sympy)]


def main(words: list[str]) -> int:
    if "--here" not in words:  # pkgen and the libraries that it needs, behind those of the peers
        libraries = [sysconfig.get_path("purelib"), str(ROOT / "generator")]
        os.environ["PYTHONPATH"] = os.pathsep.join(libraries)
        return with_peers("derivatives", [*words, "--here"])
    warnings.simplefilter("ignore")
    parts = {}
    with tempfile.TemporaryDirectory() as folder:
        parts["Seven derivatives of an angle of the double pendulum after 10 s, at 1e-10"] = (
            gradients()
        )
        parts["Two parameters of a pendulum from 121 samples"] = fits(Path(folder))
        parts["A and B of a cart with a pole, derivation included"] = linear_models()
    text = [
        "# Derivatives beside other packages\n",
        "Written by `python -m bench derivatives --docs`.\n",
    ]
    text += [*describe().lines(), f"load average {os.getloadavg()[0]:.2f}\n"]
    for title, rows in parts.items():
        text += [f"## {title}\n", "| | differs by | CPU s |", "|---|---|---|"]
        text += [f"| {name} | {off:.1e} | {seconds:.2g} |" for name, off, seconds in rows]
        text.append("")
    print("\n".join(text))
    if "--docs" in words:
        PAGE.write_text("\n".join(text))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
