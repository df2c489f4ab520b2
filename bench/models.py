"""The five models as peers meet them: Lagrangians written here in SymPy, never by pkgen.

Each Lagrangian is that of its models/NAME.lag, written down a second time; parameters, start, end
time and the final state to 25 digits are those of tests/models/references.json. `equations()`
derives M(q) and f(q, q', t), with M a = f, and the accelerations a in closed form.
"""

from __future__ import annotations

import json
import random
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import sympy as sp

ROOT = Path(__file__).resolve().parent.parent
REFERENCES = json.loads((ROOT / "tests/models/references.json").read_text())
# Ten starts, the first that of the references: one start alone would let a method be lucky.
STARTS = 10
SPREAD = 0.05


@dataclass(frozen=True)
class Model:
    """A Lagrangian with numbers; all lists in the order of the coordinates and parameters."""

    name: str
    t: sp.Symbol
    q: tuple[sp.Symbol, ...]
    v: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    values: tuple[float, ...]
    lagrangian: sp.Expr
    start: tuple[float, ...]  # q, then v
    t_end: float
    final: tuple[str, ...]  # of that start, 25 digits

    @property
    def n(self) -> int:
        return len(self.q)

    def starts(self, count: int = STARTS) -> list[tuple[float, ...]]:
        """The reference's, then seeded neighbours of it."""
        seeded = random.Random(2385)
        found = [self.start]
        for _ in range(count - 1):
            found.append(
                tuple(x + SPREAD * max(1.0, abs(x)) * seeded.uniform(-1, 1) for x in self.start)
            )
        return found


@dataclass(frozen=True)
class Equations:
    """M a = f, and a itself."""

    mass: sp.Matrix
    force: sp.Matrix
    acceleration: tuple[sp.Expr, ...]


def _double_pendulum(q, v, p, t):
    m1, m2, l1, l2, g = p
    kinetic = m1 / 2 * l1**2 * v[0] ** 2 + m2 / 2 * (
        l1**2 * v[0] ** 2 + l2**2 * v[1] ** 2 + 2 * l1 * l2 * v[0] * v[1] * sp.cos(q[0] - q[1])
    )
    return kinetic + (m1 + m2) * g * l1 * sp.cos(q[0]) + m2 * g * l2 * sp.cos(q[1])


def _coupled_oscillators(q, v, p, t):
    m, k, kc = p
    springs = k / 2 * (q[0] ** 2 + q[2] ** 2)
    springs += kc / 2 * ((q[1] - q[0]) ** 2 + (q[2] - q[1]) ** 2)
    return m / 2 * sum(x**2 for x in v) - springs


def _bead_on_hoop(q, v, p, t):
    m, radius, rate, g = p
    kinetic = m / 2 * radius**2 * (v[0] ** 2 + rate**2 * sp.sin(q[0]) ** 2)
    return kinetic + m * g * radius * sp.cos(q[0])


def _elastic_pendulum(q, v, p, t):
    m, k, l0, g = p
    length = l0 + q[0]
    kinetic = m / 2 * (v[0] ** 2 + length**2 * v[1] ** 2)
    return kinetic + m * g * length * sp.cos(q[1]) - k / 2 * q[0] ** 2


def _heavy_top(q, v, p, t):
    i1, i3, mass, length, g = p
    across = i1 / 2 * (v[1] ** 2 + v[0] ** 2 * sp.sin(q[1]) ** 2)
    along = i3 / 2 * (v[2] + v[0] * sp.cos(q[1])) ** 2
    return across + along - mass * g * length * sp.cos(q[1])


LAGRANGIANS = {
    "double_pendulum": _double_pendulum,
    "coupled_oscillators": _coupled_oscillators,
    "bead_on_hoop": _bead_on_hoop,
    "elastic_pendulum": _elastic_pendulum,
    "heavy_top": _heavy_top,
}


@cache
def model(name: str) -> Model:
    reference = REFERENCES[name]
    n = len(reference["coords"])
    t = sp.Symbol("t")
    q = tuple(sp.Symbol(f"q{i}") for i in range(n))
    v = tuple(sp.Symbol(f"v{i}") for i in range(n))
    parameters = tuple(sp.Symbol(f"p_{name}") for name in reference["params"])
    return Model(
        name=name,
        t=t,
        q=q,
        v=v,
        parameters=parameters,
        values=tuple(float(x) for x in reference["params"].values()),
        lagrangian=LAGRANGIANS[name](q, v, parameters, t),
        start=tuple(float(x) for x in reference["y0"]),
        t_end=float(reference["t_end"]),
        final=tuple(reference["y"]),
    )


@cache
def equations(name: str) -> Equations:
    """By d/dt(dL/dv) - dL/dq = 0. The closed form is simplified, as a person would write it."""
    m = model(name)
    momenta = [sp.diff(m.lagrangian, v) for v in m.v]
    mass = sp.Matrix(m.n, m.n, lambda i, j: sp.diff(momenta[i], m.v[j])).applyfunc(sp.trigsimp)
    force = sp.Matrix(
        [
            sp.diff(m.lagrangian, m.q[i])
            - sum(sp.diff(momenta[i], m.q[j]) * m.v[j] for j in range(m.n))
            - sp.diff(momenta[i], m.t)
            for i in range(m.n)
        ]
    )
    candidates = [mass.LUsolve(force), mass.adjugate() * force / mass.det()]
    candidates += [c.applyfunc(simpler) for c in candidates for simpler in (sp.cancel, sp.simplify)]
    return Equations(mass, force, tuple(min(candidates, key=_cost)))


def _cost(expressions: sp.Matrix) -> int:
    """Roughly cycles, after sharing; SymPy's shortest form may have more sines than its input."""
    shared, reduced = sp.cse(list(expressions))
    text = [e for _, e in shared] + list(reduced)
    calls = sum(e.count(sp.sin) + e.count(sp.cos) for e in text)
    divisions = sum(1 for e in text for p in e.atoms(sp.Pow) if p.exp.is_negative)
    return 30 * calls + 5 * divisions + sum(int(sp.count_ops(e)) for e in text)


def error(state, exact) -> float:
    """Largest error of a final state, each component relative to max(1, its size)."""
    worst = 0.0
    for a, b in zip(state, exact, strict=True):
        distance = abs(a - b) / max(1.0, abs(b))
        if not distance < float("inf"):  # NaN as well
            return float("inf")
        worst = max(worst, distance)
    return worst
