"""Lagrangians of the systems in `kernel_cases.py`, a second time: in SymPy, by hand.

Each takes the symbols q, v, u and the parameters, and gives L, or (L, D, Q). Nothing of pkgen
is in here.
"""

from itertools import pairwise

import sympy as sp

t = sp.Symbol("t", real=True)


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
