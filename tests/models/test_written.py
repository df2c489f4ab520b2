"""Models written from docs/language.md alone, against their physics derived apart from pkgen.

Each is derived again here by SymPy's LagrangesMethod from Cartesian positions, integrated by a
Taylor-free classical method in this file, and compared with `pkgen run`; their invariants too.
"""

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from conftest import ran

HERE = Path(__file__).parent / "written"
t = dynamicsymbols._t


def spherical_pendulum_cart():
    X, th, ph = dynamicsymbols("X th ph")
    M, m, length, g = 3.0, 0.5, 0.8, 9.81
    x = X + length * sp.sin(th) * sp.cos(ph)
    y = length * sp.sin(th) * sp.sin(ph)
    z = -length * sp.cos(th)
    speed2 = sum(sp.diff(c, t) ** 2 for c in (x, y, z))
    L = M / 2 * sp.diff(X, t) ** 2 + m / 2 * speed2 - m * g * z
    return L, [X, th, ph], None, [0, np.deg2rad(40), 0.3, -0.2, 0, 2.1]


def magnetic_charge():
    x, y, z = dynamicsymbols("x y z")
    m, e, B, k = 2.385e-3, 0.7, 0.43, 0.11
    v = [sp.diff(c, t) for c in (x, y, z)]
    L = m / 2 * sum(c**2 for c in v) + e * B / 2 * (x * v[1] - y * v[0])
    L -= k / 2 * (x**2 + y**2 + z**2)
    return L, [x, y, z], None, [0.12, -0.05, 0.003, 0.4, 1.3, 0.2]


def shaken_pendulum():
    th = dynamicsymbols("th")
    m, length, g, a, w, c = 0.2, 0.3, 9.81, 0.02, 377.0, 1e-3
    x, y = length * sp.sin(th), a * sp.cos(w * t) - length * sp.cos(th)
    L = m / 2 * (sp.diff(x, t) ** 2 + sp.diff(y, t) ** 2) - m * g * y
    return L, [th], -c * sp.diff(th, t), [np.pi - 0.2, 0]


SLOW = {"spherical_pendulum_cart"}  # for SymPy
CASES = {f.__name__: f for f in (spherical_pendulum_cart, magnetic_charge, shaken_pendulum)}


def independent(case, until: float, steps: int) -> np.ndarray:
    """The final state by classical RK4, from SymPy's equations."""
    L, q, friction, start = case()
    v = [sp.diff(c, t) for c in q]
    method = LagrangesMethod(L, q)
    method.form_lagranges_equations()
    names = sp.symbols(f"q0:{len(q)} v0:{len(q)}")
    at = dict(zip([*v, *q], [*names[len(q) :], *names[: len(q)]], strict=True))
    force = method.forcing + sp.Matrix([friction or 0] * len(q))
    args = [t, *names]
    mass = sp.lambdify(args, method.mass_matrix.subs(at), "numpy")
    force = sp.lambdify(args, force.subs(at), "numpy")

    def rate(time: float, y: np.ndarray) -> np.ndarray:
        a = np.linalg.solve(np.array(mass(time, *y), float), np.array(force(time, *y), float))
        return np.concatenate([y[len(q) :], a[:, 0]])

    y, h = np.array(start, float), until / steps
    for k in range(steps):
        k1 = rate(k * h, y)
        k2 = rate((k + 0.5) * h, y + h / 2 * k1)
        k3 = rate((k + 0.5) * h, y + h / 2 * k2)
        k4 = rate((k + 1) * h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.long] if n in SLOW else []) for n in CASES]
)
def test_motion(name: str) -> None:
    until = 0.5
    model = HERE / f"{name}.lag"
    done = ran("run", model, "--until", until, "--every", until, "--rtol", "1e-12", "--json")
    result = json.loads(done.stdout)
    exact = independent(CASES[name], until, 16000)
    n = len(exact)
    assert result["rows"][-1][1 : n + 1] == pytest.approx(exact, rel=1e-8, abs=1e-9)
    for drift in result["report"]["drifts"]:
        assert drift["max"] < 1e-10, drift


def test_what_is_constant(pkgen) -> None:
    """Momenta found without being told, and the claims of the models, watched over the motion."""
    found = {}
    for name in CASES:
        done = pkgen("run", HERE / f"{name}.lag", "--until", "0.1", "--json")
        found[name] = [d["name"] for d in json.loads(done.stdout)["report"]["drifts"]]
    assert found == {
        "spherical_pendulum_cart": ["energy", "p_X", "px"],
        "magnetic_charge": ["energy", "Lz"],
        "shaken_pendulum": [],
    }
