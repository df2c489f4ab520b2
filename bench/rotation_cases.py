"""Motions that pkgen can have in several forms: in angles, what a reduction leaves of these, and by
`rotation` or `constraint`; and the same written by hand for the peers and for the reference.

A start is that of the angles, then of their rates. Each form makes its own of it, q, v,
quadratures and momenta, and of its end what all forms have: the matrix and body rates, or places
and velocities. By hand a rigid body is seven equations of the first order, u its quaternion:

    u' = u (0, w)/2,   I w' = I w x w + torque      (Euler)

and a pendulum that of its angle.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from math import acos, cos, pi, sin, sqrt
from pathlib import Path

import sympy as sp

from . import models
from .attitudes import Numbers, angles_to_quaternion, of_angles, of_quaternion

ROOT = Path(__file__).resolve().parent.parent
G = 9.81
ADAPTIVE = ("gauss", "dop853")
GROUP = ("rkmk4", "rkmk8", "lie_midpoint4", "lie_midpoint6")
PROJECTED = ("gauss4", "gauss8")


@dataclass(frozen=True)
class Form:
    """A model that pkgen compiles, whole or as a scene needs it, and its methods here."""

    name: str
    path: str
    n: int
    methods: tuple[str, ...]
    given: Callable[[Numbers], list[float]]  # q, v, parameters of the start
    seen: Callable[[list[float]], list[float]]
    words: tuple[str, ...] = ()  # a scene and what it records
    parameters: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """Also what bench.measure and bench.codegen want to know of a model."""

    name: str
    q: tuple[sp.Symbol, ...]
    v: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    values: tuple[float, ...]
    acceleration: tuple[sp.Expr, ...]
    start: tuple[float, ...]
    t_end: float
    steps: int  # of the reference, a second
    given: Callable[[Numbers], list[float]]  # the reference's q, v
    seen: Callable[[list[float]], list[float]]
    forms: tuple[Form, ...]
    by_quaternion: bool = False  # then v is that of the peers, of the first order

    @property
    def n(self) -> int:
        return len(self.q)

    def starts(self, count: int) -> list[tuple[float, ...]]:
        seeded = random.Random(2385)
        near = [
            tuple(x + models.SPREAD * max(1.0, abs(x)) * seeded.uniform(-1, 1) for x in self.start)
            for _ in range(count - 1)
        ]
        return [self.start, *near]


def _symbols(name: str, count: int) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(f"{name}{i}") for i in range(count))


def _euler(inertia, torque, state) -> tuple[sp.Expr, ...]:
    """u' and w' of a body."""
    w, x, y, z, *rates = state
    a, b, c = rates
    quaternion = (-x * a - y * b - z * c, w * a + y * c - z * b)
    quaternion += (w * b + z * a - x * c, w * c + x * b - y * a)
    turned = sp.Matrix([i * r for i, r in zip(inertia, rates, strict=True)]).cross(sp.Matrix(rates))
    change = [(t + m) / i for t, m, i in zip(turned, torque, inertia, strict=True)]
    return (*(e / 2 for e in quaternion), *change)


def _body(name, values, torque, inertia, start, t_end, steps, forms) -> Case:
    q, v, parameters = _symbols("q", 7), _symbols("v", 7), _symbols("p", len(values))
    rates = _euler(inertia(parameters), torque(parameters, v), v)
    return Case(
        name, q, v, parameters, values, rates, start, t_end, steps,
        given=lambda s: [0.0] * 7 + angles_to_quaternion(s),
        seen=lambda y: of_quaternion(y[7:14]),
        forms=forms,
        by_quaternion=True,
    )  # fmt: skip


def _rotation_given(start: Numbers) -> list[float]:
    """Nothing depends on the q of states; of v body rates are first."""
    state = angles_to_quaternion(start)
    return [0.0] * 7 + state[4:] + state[:4]


def _rotation_seen(y: list[float]) -> list[float]:
    return of_quaternion(y[10:14] + y[7:10])


def _rotation(path: str) -> Form:
    methods = (*ADAPTIVE, *PROJECTED, *GROUP)
    return Form("rotation", path, 7, methods, _rotation_given, _rotation_seen)


RECORD = ("--record", "phi,theta,psi,phi',theta',psi'")
TOP = {"I1": 1.0, "I3": 0.5, "Mgl": G}


def _top_given(start: Numbers) -> list[float]:
    """theta; theta', phi, psi; p_phi, p_psi: by Routh."""
    phi, theta, psi, precession, nutation, spin = start
    p_psi = TOP["I3"] * (spin + precession * cos(theta))
    p_phi = TOP["I1"] * precession * sin(theta) ** 2 + p_psi * cos(theta)
    return [theta, 0.0, 0.0, nutation, phi, psi, p_phi, p_psi]


def _top_seen(y: list[float]) -> list[float]:
    theta, _, _, nutation, phi, psi, p_phi, p_psi = y[:8]
    precession = (p_phi - p_psi * cos(theta)) / (TOP["I1"] * sin(theta) ** 2)
    spin = p_psi / TOP["I3"] - precession * cos(theta)
    return of_angles([phi, theta, psi, precession, nutation, spin])


def heavy_top() -> Case:
    path, methods = "models/heavy_top.lag", (*ADAPTIVE, "gauss4")
    reduced = ("--scene", "reference", *RECORD)
    return _body(
        "heavy top", tuple(TOP.values()),
        # The weight: l e3 x (-M g times the vertical in the body).
        lambda p, v: (
            p[2] * 2 * (v[2] * v[3] + v[0] * v[1]), -p[2] * 2 * (v[1] * v[3] - v[0] * v[2]), 0
        ),
        lambda p: (p[0], p[0], p[1]),
        (0.0, 0.6, 0.0, 0.4, 0.0, 18.0), 10.0, 48,
        (
            Form("angles", path, 3, methods, list, of_angles),
            Form("angles, reduced", path, 3, methods, _top_given, _top_seen, reduced,
                 ("p_phi", "p_psi")),
            _rotation("models/bodies/heavy_top_rotation.lag"),
        ),
    )  # fmt: skip


INERTIA = (1.0, 2.0, 3.0)


def free_body() -> Case:
    """It tumbles from w = (1, 0, 1.2), z along its angular momentum: the best place for angles.
    Of these phi is cyclic, but pkgen keeps it: without it the equations are longer."""
    path, methods = "bench/lag/free_body_angles.lag", (*ADAPTIVE, "gauss4")
    first, third = INERTIA[0] * 1.0, INERTIA[2] * 1.2
    theta = acos(third / sqrt(first**2 + third**2))
    start = (0.0, theta, pi / 2, 1 / sin(theta), 0.0, 1.2 - cos(theta) / sin(theta))
    return _body(
        "free body", INERTIA, lambda p, v: (0, 0, 0), lambda p: p, start, 20.0, 24,
        (
            Form("angles", path, 3, methods, list, of_angles),
            _rotation("models/bodies/free_body.lag"),
        ),
    )  # fmt: skip


def bobs(state: Numbers) -> list[float]:
    """Places and velocities, of angles and their rates; rods are 1 m long."""
    n = len(state) // 2
    places, velocities, x, y, vx, vy = [], [], 0.0, 0.0, 0.0, 0.0
    for angle, rate in zip(state[:n], state[n:], strict=True):
        x, y = x + sin(angle), y - cos(angle)
        vx, vy = vx + rate * cos(angle), vy + rate * sin(angle)
        places += [x, y]
        velocities += [vx, vy]
    return places + velocities


CONSTRAINED = (*ADAPTIVE, *PROJECTED, "rattle", "rattle4", "rattle6", "lie_midpoint6")
ANGLE = (*ADAPTIVE, *PROJECTED)


def _rods(name, angles, rods, q, v, parameters, values, rates, start, t_end, steps) -> Case:
    n = len(q)
    return Case(
        name, q, v, parameters, values, rates, start, t_end, steps,
        given=list,
        seen=bobs,
        forms=(
            Form("angles", angles, n, ANGLE, list, lambda y: bobs(y[: 2 * n])),
            Form("rods", rods, 2 * n, CONSTRAINED, bobs, lambda y: y[: 4 * n]),
        ),
    )  # fmt: skip


def pendulum() -> Case:
    q, v, (g,) = _symbols("q", 1), _symbols("v", 1), _symbols("p", 1)
    return _rods(
        "pendulum", "models/pendulums/pendulum.lag", "models/constrained/pendulum_rod.lag",
        q, v, (g,), (G,), (-g * sp.sin(q[0]),), (1.3, 0.2), 20.0, 24,
    )  # fmt: skip


def double_pendulum() -> Case:
    m = models.model("double_pendulum")
    return _rods(
        "double pendulum", "models/double_pendulum.lag",
        "models/constrained/double_pendulum_rods.lag", m.q, m.v, m.parameters, m.values,
        models.equations(m.name).acceleration, m.start, m.t_end, 80,
    )  # fmt: skip


CASES = (heavy_top, free_body, pendulum, double_pendulum)
