"""Every kernel against SymPy, at seeded states, to 1e-12.

Each case states its Lagrangian a second time, in SymPy and by hand. The reference is
differentiated by SymPy and evaluated with 40 digits; for the classical systems SymPy's own
LagrangesMethod is asked as well. Nothing of pkgen is in the reference.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import mpmath
import pytest
import sympy as sp
from building import links, model
from pkgen.equations import Equations
from pkgen.middle.derive import derive
from pkgen.middle.evaluate import evaluate
from pkgen.middle.graph import Kind, Symbol
from pkgen.model import Model
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

RTOL = 1e-12
STATES = 4
t = sp.Symbol("t", real=True)


@dataclass(frozen=True)
class Case:
    """`lagrangian(q, v, u, **parameters)` gives L, or (L, D, Q); u[k] is a derivative's symbol."""

    model: Model
    lagrangian: Callable[..., object]
    classical: bool = False


def _energy(mass: object, *points: tuple[sp.Expr, ...]) -> sp.Expr:
    return sum(mass / 2 * sum(c**2 for c in point) for point in points)


def rate(expr: sp.Expr, q: list, v: list, u: list) -> sp.Expr:
    """The total time derivative."""
    result = sp.diff(expr, t) + sum(sp.diff(expr, a) * b for a, b in zip(q, v, strict=True))
    return result + sum(sp.diff(expr, a) * b for a, b in pairwise(u))


def double_pendulum(q, v, u, m1, m2, l1, l2, g):
    cross = m2 * l1 * l2 * v[0] * v[1] * sp.cos(q[0] - q[1])
    kinetic = (m1 + m2) / 2 * l1**2 * v[0] ** 2 + m2 / 2 * l2**2 * v[1] ** 2 + cross
    return kinetic + (m1 + m2) * g * l1 * sp.cos(q[0]) + m2 * g * l2 * sp.cos(q[1])


def oscillators(q, v, u, m, k, kc):
    springs = k / 2 * (q[0] ** 2 + q[2] ** 2)
    springs += kc / 2 * ((q[1] - q[0]) ** 2 + (q[2] - q[1]) ** 2)
    return _energy(m, tuple(v)) - springs


def bead(q, v, u, m, R, Omega, g):
    return m * R**2 / 2 * (v[0] ** 2 + Omega**2 * sp.sin(q[0]) ** 2) + m * g * R * sp.cos(q[0])


def elastic(q, v, u, m, l0, g, k):
    r = l0 + q[0]
    return m / 2 * (v[0] ** 2 + r**2 * v[1] ** 2) + m * g * r * sp.cos(q[1]) - k / 2 * q[0] ** 2


def top(q, v, u, I1, I3, M, length, g):
    spin = v[2] + v[0] * sp.cos(q[1])
    kinetic = I1 / 2 * (v[1] ** 2 + (v[0] * sp.sin(q[1])) ** 2) + I3 / 2 * spin**2
    return kinetic - M * g * length * sp.cos(q[1])


def charge(q, v, u, m, e, B, E):
    x, y, z = q
    potential = B * (x * v[1] - y * v[0]) / 2 + B * x**2 * v[2] / 3
    return _energy(m, tuple(v)) + e * potential + e * E * x * z


def shaken(q, v, u, m, length, g, a, w):
    x = a * sp.sin(w * t) + length * sp.sin(q[0])
    y = a * t**2 / 3 - length * sp.cos(q[0])
    return _energy(m, (rate(x, q, v, u), rate(y, q, v, u))) - m * g * y


def relativistic(q, v, u, m, c, k):
    return -m * c**2 * sp.sqrt(1 - (v[0] ** 2 + v[1] ** 2) / c**2) - k / 4 * (q[0] ** 2 + q[1]) ** 2


def driven(q, v, u, m, length, g):
    x, y = u[0] + length * sp.sin(q[0]), -length * sp.cos(q[0])
    return _energy(m, (rate(x, q, v, u), rate(y, q, v, u))) - m * g * y


def cart(q, v, u, M, m, length, g, c, d, F):
    x, y = q[0] + length * sp.sin(q[1]), -length * sp.cos(q[1])
    kinetic = M / 2 * v[0] ** 2 + _energy(m, (rate(x, q, v, u), rate(y, q, v, u)))
    drag = c / 2 * v[0] ** 2 + d / 4 * (v[1] - v[0]) ** 4 * (2 + sp.cos(q[1]))
    force = [F * sp.cos(3 * t) + u[0] * q[1], m * v[0] * v[1]]
    return kinetic - m * g * y, drag, force


def chain(q, v, u, m, k, a, w):
    ends = [a * sp.sin(w * t), *q, q[-1]]
    return _energy(m, tuple(v)) - sum(
        k / 2 * (ends[i + 1] - ends[i]) ** 2 + k / 4 * (ends[i + 1] - ends[i]) ** 4
        for i in range(len(ends) - 1)
    )


def moved_end(q, v, u, m, k, a, w):
    """The fixed end has inertia coupled to it, so its rate is needed too."""
    end = a * sp.sin(w * t)
    return _energy(m, tuple(v)) + m / 3 * v[0] * sp.diff(end, t) * q[0] - k / 2 * (q[0] - end) ** 2


def ring(q, v, u, m, k):
    return _energy(m, tuple(v)) - sum(
        k * (1 - sp.cos(q[(i + 1) % len(q)] - q[i])) for i in range(len(q))
    )


def kepler(q, v, u, m, k):
    r = sp.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2)
    return _energy(m, tuple(v)) + k / r + k * sp.exp(-r / 3) * sp.log(r) + k * (r - 2) ** 3


def functions(q, v, u, m, a):
    x, y = q
    inertia = m * (2 + sp.tanh(x * y) + sp.atan(x / 3) ** 2 + sp.sinh(x / 2) ** 2)
    potential = sp.tan(x / 4) + sp.asin(x / 5) * sp.acos(y / 5) + sp.atan2(y, 3 + x) + sp.cosh(y)
    potential += (4 + x) ** a + (5 + y) ** sp.Rational(5, 2) + (3 + x * y / 9) ** sp.Rational(1, 3)
    return inertia / 2 * (v[0] ** 2 + v[0] * v[1] + 3 * v[1] ** 2) - potential


def links_3(q, v, u, m, length, g):
    x = y = sp.Integer(0)
    result = sp.Integer(0)
    for angle in q:
        x, y = x + length * sp.sin(angle), y - length * sp.cos(angle)
        result += _energy(m, (rate(x, q, v, u), rate(y, q, v, u))) - m * g * y
    return result


PLANE = "m/2*(D(x)**2 + D(y)**2)"
CASES: dict[str, Case] = {
    "double_pendulum": Case(
        model(
            params={"m1": 1.21, "m2": 0.83, "l1": 1.37, "l2": 0.71, "g": 9.81},
            coords=("theta1", "theta2"),
            lets={
                "x1": "l1*sin(theta1)",
                "y1": "-l1*cos(theta1)",
                "x2": "x1 + l2*sin(theta2)",
                "y2": "y1 - l2*cos(theta2)",
            },
            kinetic="m1/2*(D(x1)**2 + D(y1)**2) + m2/2*(D(x2)**2 + D(y2)**2)",
            potential="m1*g*y1 + m2*g*y2",
        ),
        double_pendulum,
        classical=True,
    ),
    "coupled_oscillators": Case(
        model(
            sizes={"n": 3},
            params={"m": 1.21, "k": 2.3, "kc": "k*1.7"},
            coords=("q[1..n]",),
            kinetic="S('i', 1, n, m/2*D(q[i])**2)",
            potential="k/2*q[1]**2 + k/2*q[n]**2 + S('i', 1, n-1, kc/2*(q[i+1] - q[i])**2)",
        ),
        oscillators,
        classical=True,
    ),
    "bead_on_hoop": Case(
        model(
            params={"m": 1.3, "R": 0.9, "Omega": 4.3, "g": 9.81},
            coords=("theta",),
            lets={
                "x": "R*sin(theta)*cos(Omega*t)",
                "y": "R*sin(theta)*sin(Omega*t)",
                "z": "-R*cos(theta)",
            },
            kinetic="m/2*(D(x)**2 + D(y)**2 + D(z)**2)",
            potential="m*g*z",
        ),
        bead,
        classical=True,
    ),
    "elastic_pendulum": Case(
        model(
            params={"m": 1.3, "l0": 0.8, "g": 9.81, "k": "3*m*g/l0"},
            coords=("s", "theta"),
            lets={"x": "(l0 + s)*sin(theta)", "y": "-(l0 + s)*cos(theta)"},
            kinetic=PLANE,
            potential="m*g*y + k/2*s**2",
        ),
        elastic,
        classical=True,
    ),
    "heavy_top": Case(
        model(
            params={"I1": 1.3, "I3": 0.6, "M": 0.9, "l": 1.1, "g": 9.81},
            coords=("phi", "theta", "psi"),
            kinetic="I1/2*(D(theta)**2 + D(phi)**2*sin(theta)**2)"
            " + I3/2*(D(psi) + D(phi)*cos(theta))**2",
            potential="M*g*l*cos(theta)",
        ),
        top,
        classical=True,
    ),
    "charge": Case(
        model(
            params={"m": 1.3, "e": 0.7, "B": 2.1, "E": 0.4},
            coords=("x", "y", "z"),
            lagrangian=(
                "m/2*(D(x)**2 + D(y)**2 + D(z)**2)",
                "e*(dot([-B*y/2, B*x/2, B*x**2/3], [D(x), D(y), D(z)]) + E*x*z)",
            ),
        ),
        charge,
    ),
    "shaken": Case(
        model(
            params={"m": 1.3, "l": 0.7, "g": 9.81, "a": 0.2, "w": 3.1},
            coords=("theta",),
            lets={"x": "a*sin(w*t) + l*sin(theta)", "y": "a*t**2/3 - l*cos(theta)"},
            kinetic=PLANE,
            potential="m*g*y",
        ),
        shaken,
    ),
    "relativistic": Case(
        model(
            params={"m": 1.3, "c": 3.7, "k": 0.4},
            coords=("x", "y"),
            lagrangian="-m*c**2*sqrt(1 - (D(x)**2 + D(y)**2)/c**2)",
            potential="k/4*(x**2 + y)**2",
        ),
        relativistic,
    ),
    "driven": Case(
        model(
            params={"m": 1.3, "l": 0.7, "g": 9.81},
            coords=("theta",),
            inputs={"other": 0, "u": 1},
            lets={"x": "u + l*sin(theta)", "y": "-l*cos(theta)"},
            kinetic=PLANE,
            potential="m*g*y",
        ),
        driven,
    ),
    "cart": Case(
        model(
            params={"M": 2.3, "m": 1.3, "l": 0.7, "g": 9.81, "c": 0.3, "d": 0.2, "F": 1.7},
            coords=("s", "theta"),
            inputs={"u": 0},
            lets={"at": "[s + l*sin(theta), -l*cos(theta)]"},
            kinetic="M/2*D(s)**2 + m/2*dot(D(at), D(at))",
            potential="m*g*at.y",
            dissipation=("c/2*D(s)**2", "d/4*(D(theta) - D(s))**4*(2 + cos(theta))"),
            forces={"s": "F*cos(3*t) + u*theta", "theta": "m*D(s)*D(theta)"},
        ),
        cart,
    ),
    "chain": Case(
        model(
            sizes={"N": 4},
            params={"m": 1.3, "k": 2.1, "a": 0.3, "w": 1.9},
            coords=("q[1..N]",),
            ends=(("fixed", "q", 0, "a*sin(w*t)"), ("free", "q", 5, None)),
            kinetic="S('i', 1, N, m/2*D(q[i])**2)",
            potential="S('i', 0, N, k/2*(q[i+1]-q[i])**2 + k/4*(q[i+1]-q[i])**4)",
        ),
        chain,
    ),
    "moved_end": Case(
        model(
            sizes={"N": 2},
            params={"m": 1.3, "k": 2.1, "a": 0.3, "w": 1.9},
            coords=("q[1..N]",),
            ends=(("fixed", "q", 0, "a*sin(w*t)"),),
            lagrangian="S('i', 1, N, m/2*D(q[i])**2) + m/3*D(q[1])*D(q[0])*q[1]"
            " - k/2*(q[1] - q[0])**2",
        ),
        moved_end,
    ),
    "ring": Case(
        model(
            sizes={"N": 5},
            params={"m": 1.3, "k": 2.1},
            coords=("q[1..N]",),
            ends=(("periodic", "q", None, None),),
            kinetic="S('i', 1, N, m/2*D(q[i])**2)",
            potential="S('i', 1, N, k*(1 - cos(q[i+1] - q[i])))",
        ),
        ring,
    ),
    "kepler": Case(
        model(
            params={"m": 1.3, "k": 2.1},
            coords=("x", "y", "z"),
            lets={"r": "norm([x, y, z])"},
            kinetic="m/2*(D(x)**2 + D(y)**2 + D(z)**2)",
            potential="-k/r - k*exp(-r/3)*log(r) - k*(r - 2)**3",
        ),
        kepler,
    ),
    "functions": Case(
        model(
            params={"m": 1.3, "a": 1.7},
            coords=("x", "y"),
            kinetic="m/2*(2 + tanh(x*y) + atan(x/3)**2 + sinh(x/2)**2)"
            "*(D(x)**2 + D(x)*D(y) + 3*D(y)**2)",
            potential="tan(x/4) + asin(x/5)*acos(y/5) + atan2(y, 3+x) + cosh(y)"
            " + (4+x)**a + (5+y)**(5/2) + (3 + x*y/9)**(1/3)",
        ),
        functions,
    ),
    "links": Case(links(3), links_3),
}


def _renamed(parameters: dict[str, sp.Symbol]) -> dict[str, sp.Symbol]:
    return {"length" if name == "l" else name: x for name, x in parameters.items()}


@dataclass(frozen=True)
class Reference:
    """Expressions by name, over plain symbols."""

    symbols: list[sp.Symbol]
    q: list[sp.Symbol]
    v: list[sp.Symbol]
    kernels: dict[str, list[sp.Expr]]
    scales: dict[str, list[sp.Expr]]


def reference(case: Case) -> Reference:
    e = case.model
    n = len(derive(e, frozenset()).coordinates)
    names = [p.name for p in e.parameters]
    q = [sp.Symbol(f"q{i}", real=True) for i in range(n)]
    v = [sp.Symbol(f"v{i}", real=True) for i in range(n)]
    u = [sp.Symbol(f"u{i}", real=True) for i in range(3)]
    parameters = {name: sp.Symbol("P_" + name, positive=True) for name in names}
    made = case.lagrangian(q, v, u, **_renamed(parameters))
    L, drag, applied = made if isinstance(made, tuple) else (made, sp.Integer(0), [0] * n)
    p = [sp.diff(L, x) for x in v]
    gradient = [sp.diff(L, x) for x in q]
    pdot = [a + b - sp.diff(drag, x) for a, b, x in zip(gradient, applied, v, strict=True)]
    coasting = [
        sp.diff(x, t)
        + sum(sp.diff(x, a) * b for a, b in zip(q, v, strict=True))
        + sum(sp.diff(x, a) * b for a, b in pairwise(u))
        for x in p
    ]
    kernels = {
        "momenta": p,
        "gradient": gradient,
        "pdot": pdot,
        "mass": [sp.diff(a, b) for a in p for b in v],
        "force": [a - b for a, b in zip(pdot, coasting, strict=True)],
        "p_q": [sp.diff(a, b) for a in p for b in q],
        "pdot_q": [sp.diff(a, b) for a in pdot for b in q],
        "pdot_v": [sp.diff(a, b) for a in pdot for b in v],
        "energy": [sum(a * b for a, b in zip(v, p, strict=True)) - L],
        "lagrangian": [L],
    }
    return Reference([t, *q, *v, *u, *parameters.values()], q, v, kernels, {})


def flat(value: object) -> list[int]:
    if isinstance(value, int):
        return [value]
    return [node for part in value for node in flat(part)]


def state(case: Case, e: Equations, seed: int) -> tuple[dict[Symbol, float], list[float]]:
    """The same random numbers for both sides: by graph symbol, and in the reference's order."""
    draw = random.Random(seed)
    n = len(e.coordinates)
    time, *rest = (draw.uniform(0.31, 1.37) for _ in range(1 + 2 * n + 3))
    q, v, u = rest[:n], [0.9 * x - 0.2 for x in rest[n : 2 * n]], rest[2 * n :]
    values = {Symbol(Kind.TIME): time}
    values |= {Symbol(Kind.COORDINATE, i): x for i, x in enumerate(q)}
    values |= {Symbol(Kind.RATE, i): x for i, x in enumerate(v)}
    names = [i.name.rstrip("'") for i in e.inputs]
    for i, item in enumerate(e.inputs):
        used = item.name.startswith("u")
        values[Symbol(Kind.INPUT, i)] = u[item.name.count("'")] if used else 0.1 * len(names)
    parameters = [draw.uniform(1.1, 2.3) for _ in e.parameters]
    values |= {Symbol(Kind.PARAMETER, i): x for i, x in enumerate(parameters)}
    return values, [time, *q, *v, *u, *parameters]


@pytest.fixture(scope="module", params=list(CASES))
def made(request):
    case = CASES[request.param]
    return case, derive(case.model), reference(case)


def close(name: str, ours: list[float], theirs: list, scale: float) -> None:
    assert len(ours) == len(theirs), name
    for i, (a, b) in enumerate(zip(ours, theirs, strict=True)):
        assert abs(a - b) <= RTOL * (abs(b) + scale), (name, i, a, b)


def test_every_kernel(made):
    case, e, expected = made
    compiled = {
        name: sp.lambdify(expected.symbols, kernel, "mpmath")
        for name, kernel in expected.kernels.items()
    }
    moved = 0
    for seed in range(STATES):
        values, numbers = state(case, e, seed)
        with mpmath.workdps(40):
            exact = {n: k(*map(mpmath.mpf, numbers)) for n, k in compiled.items()}
        for name, theirs in exact.items():
            # The scale keeps an entry that cancels to nothing from asking for infinite digits.
            scale = 1e-2 * max(1, *(abs(x) for x in theirs))
            close(name, evaluate(e.graph, flat(getattr(e, name)), values), theirs, scale)
            moved += any(abs(x) > 1e-3 for x in theirs)
        n = len(expected.q)
        with mpmath.workdps(40):
            matrix = mpmath.matrix(n, n)
            for i in range(n):
                for j in range(n):
                    matrix[i, j] = exact["mass"][i * n + j]
            solved = mpmath.lu_solve(matrix, mpmath.matrix(exact["force"]))
            theirs = [solved[i] for i in range(n)]
        condition = float(mpmath.cond(matrix))
        close("acceleration", evaluate(e.graph, e.acceleration, values), theirs, condition)
    assert moved > 5 * STATES


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.classical])
def test_against_lagranges_method(name):
    case = CASES[name]
    e = derive(case.model)
    n = len(e.coordinates)
    q = dynamicsymbols(f"q0:{n}")
    v = [x.diff(dynamicsymbols._t) for x in q]
    plain = [sp.Symbol(f"x{i}") for i in range(2 * n)]
    parameters = {p.name: sp.Symbol("P_" + p.name, positive=True) for p in case.model.parameters}
    made = case.lagrangian(list(q), v, [], **_renamed(parameters))
    method = LagrangesMethod(made, list(q))
    method.form_lagranges_equations()
    swap = dict(zip(v, plain[n:], strict=True)) | dict(zip(q, plain[:n], strict=False))
    mass = method.mass_matrix.subs(swap)
    forcing = method.forcing.subs(swap)
    kernel = sp.lambdify([*plain, *parameters.values()], [list(mass), list(forcing)], "mpmath")
    for seed in range(STATES):
        values, numbers = state(case, e, seed)
        with mpmath.workdps(40):
            arguments = [*numbers[1 : 1 + 2 * n], *numbers[1 + 2 * n + 3 :]]
            M, f = kernel(*map(mpmath.mpf, arguments))
        close("mass", evaluate(e.graph, flat(e.mass), values), M, 1e-2)
        close("force", evaluate(e.graph, list(e.force), values), f, 1e-2 * max(map(abs, f)))
