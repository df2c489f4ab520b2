"""Every kernel against SymPy, at seeded states, to 1e-12.

The parts of each case (see `kernel_cases.py`) are read a second time by `sympy_reading.py`. The
reference is differentiated by SymPy and evaluated with 40 digits; for the classical systems
SymPy's own LagrangesMethod is asked as well. Nothing of pkgen is in the reference.
"""

import random
from dataclasses import dataclass
from itertools import pairwise

import mpmath
import pytest
import sympy as sp
from building import model
from kernel_cases import CASES, CLASSICAL
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols
from sympy_reading import Reading, t

from pkgen.equations import Equations
from pkgen.graph.evaluate import evaluate
from pkgen.graph.graph import Kind, Symbol
from pkgen.middle.derive.derive import derive

RTOL = 1e-12
STATES = 4


@dataclass(frozen=True)
class Reference:
    """Expressions by name, over plain symbols."""

    symbols: list[sp.Symbol]
    q: list[sp.Symbol]
    v: list[sp.Symbol]
    kernels: dict[str, list[sp.Expr]]


def reference(parts: dict, n: int) -> Reference:
    q, v = ([sp.Symbol(f"{x}{i}", real=True) for i in range(n)] for x in "qv")
    u = [sp.Symbol(f"u{i}", real=True) for i in range(3)]
    parameters = {name: sp.Symbol("P_" + name, positive=True) for name in parts["params"]}
    read = Reading(parts, q, v, u, parameters)
    L, drag = read.lagrangian(), read.energy("dissipation")
    applied = read.forces() or [sp.Integer(0)] * n
    p = [sp.diff(L, x) for x in v]
    gradient = [sp.diff(L, x) for x in q]
    pdot = [a + b - sp.diff(drag, x) for a, b, x in zip(gradient, applied, v, strict=True)]
    coasting = [
        sp.diff(x, t)
        + sum(sp.diff(x, a) * b for a, b in zip(q, v, strict=True))
        + sum(sp.diff(x, a) * b for a, b in pairwise(u))
        for x in p
    ]
    force = [a - b for a, b in zip(pdot, coasting, strict=True)]
    a = [sp.Symbol(f"a{i}", real=True) for i in range(n)]
    rest = [
        f - sum(sp.diff(x, w) * b for w, b in zip(v, a, strict=True))
        for f, x in zip(force, p, strict=True)
    ]
    kernels = {
        "momenta": p,
        "gradient": gradient,
        "pdot": pdot,
        "mass": [sp.diff(a, b) for a in p for b in v],
        "force": force,
        "p_q": [sp.diff(a, b) for a in p for b in q],
        "pdot_q": [sp.diff(a, b) for a in pdot for b in q],
        "pdot_v": [sp.diff(a, b) for a in pdot for b in v],
        "r_q": [sp.diff(r, b) for r in rest for b in q],
        "r_v": [sp.diff(r, b) for r in rest for b in v],
        "r_t": [sp.diff(r, t) for r in rest],
        "energy": [sum(a * b for a, b in zip(v, p, strict=True)) - L],
        "lagrangian": [L],
    }
    return Reference([t, *q, *v, *u, *parameters.values(), *a], q, v, kernels)


def flat(value: object) -> list[int]:
    if isinstance(value, int):
        return [value]
    return [node for part in value for node in flat(part)]


def state(e: Equations, seed: int) -> tuple[dict[Symbol, float], list[float]]:
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
    a = [draw.uniform(-1.3, 1.7) for _ in range(n)]
    values |= {Symbol(Kind.ACCELERATION, i): x for i, x in enumerate(a)}
    return values, [time, *q, *v, *u, *parameters, *a]


def outputs(e: Equations, name: str) -> list[int]:
    return flat(getattr(e.linear if name.startswith("r_") else e, name))


@pytest.fixture(scope="module", params=list(CASES))
def made(request):
    e = derive(model(**CASES[request.param]))
    return e, reference(CASES[request.param], len(e.coordinates))


def close(name: str, ours: list[float], theirs: list, scale: float) -> None:
    assert len(ours) == len(theirs), name
    for i, (a, b) in enumerate(zip(ours, theirs, strict=True)):
        assert abs(a - b) <= RTOL * (abs(b) + scale), (name, i, a, b)


def test_every_kernel(made):
    e, expected = made
    compiled = {
        name: sp.lambdify(expected.symbols, kernel, "mpmath")
        for name, kernel in expected.kernels.items()
    }
    moved = 0
    for seed in range(STATES):
        values, numbers = state(e, seed)
        with mpmath.workdps(40):
            exact = {n: k(*map(mpmath.mpf, numbers)) for n, k in compiled.items()}
        for name, theirs in exact.items():
            # The scale keeps an entry that cancels to nothing from asking for infinite digits.
            scale = 1e-2 * max(1, *(abs(x) for x in theirs))
            close(name, evaluate(e.graph, outputs(e, name), values), theirs, scale)
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


@pytest.mark.parametrize("name", CLASSICAL)
def test_against_lagranges_method(name):
    e = derive(model(**CASES[name]))
    n = len(e.coordinates)
    q = dynamicsymbols(f"q0:{n}")
    v = [x.diff(dynamicsymbols._t) for x in q]
    plain = [sp.Symbol(f"x{i}") for i in range(2 * n)]
    parameters = {x: sp.Symbol("P_" + x, positive=True) for x in CASES[name]["params"]}
    swap = dict(zip(plain, [*q, *v], strict=True))
    L = Reading(CASES[name], plain[:n], plain[n:], [t, t], parameters).lagrangian()
    made = L.subs(t, 0).subs(swap)  # which does not know the time
    method = LagrangesMethod(made, list(q))
    method.form_lagranges_equations()
    swap = dict(zip(v, plain[n:], strict=True)) | dict(zip(q, plain[:n], strict=False))
    both = [list(m.subs(swap)) for m in (method.mass_matrix, method.forcing)]
    kernel = sp.lambdify([*plain, *parameters.values()], both, "mpmath")
    for seed in range(STATES):
        values, numbers = state(e, seed)
        with mpmath.workdps(40):
            arguments = [*numbers[1 : 1 + 2 * n], *numbers[1 + 2 * n + 3 : -n]]
            M, f = kernel(*map(mpmath.mpf, arguments))
        close("mass", evaluate(e.graph, flat(e.mass), values), M, 1e-2)
        close("force", evaluate(e.graph, list(e.force), values), f, 1e-2 * max(map(abs, f)))
