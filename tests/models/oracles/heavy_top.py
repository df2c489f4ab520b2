"""A symmetric top with its tip fixed: effective potential, steady precession, nutation, T2 and T3.

Constant are p_psi = I3 w3 about the body's axis and p_phi about the vertical; the axis alone moves
as I1 theta'^2/2 + V(theta) does, V = (p_phi - p_psi cos theta)^2/(2 I1 sin^2 theta) + m g l cos
theta (Landau, Lifshitz, Mechanics, section 35; Klein, Sommerfeld, Theorie des Kreisels, chapter 4).
"""

from dataclasses import dataclass

import mpmath as mp
import numpy as np

from . import attitude


@dataclass(frozen=True)
class Top:
    i1: float = 1.0
    i3: float = 0.5
    mgl: float = 1.0

    def potential(self, theta: float, p_phi: float, p_psi: float) -> mp.mpf:
        """V_eff."""
        c, s = mp.cos(theta), mp.sin(theta)
        return (p_phi - p_psi * c) ** 2 / (2 * self.i1 * s**2) + self.mgl * c

    def equilibrium(self, p_phi: float, p_psi: float) -> mp.mpf:
        """The angle at which V_eff is least."""
        slope = lambda x: mp.diff(lambda y: self.potential(y, p_phi, p_psi), x)  # noqa: E731
        return mp.findroot(slope, (mp.mpf("0.05"), mp.pi - mp.mpf("0.05")), solver="anderson")

    def precessions(self, theta: float, p_psi: float) -> list[mp.mpf]:
        """phi' of steady precession, slow and fast: I1 cos(theta) W^2 - p_psi W + m g l = 0."""
        c = mp.cos(theta)
        root = mp.sqrt(mp.mpf(p_psi) ** 2 - 4 * self.i1 * self.mgl * c)
        return [2 * self.mgl / (p_psi + root), (p_psi + root) / (2 * self.i1 * c)]

    def nutation(self, theta: float, precession: float, p_psi: float) -> mp.mpf:
        """Frequency of small nutations about a steady precession; its square is V_eff''/I1."""
        inner = mp.mpf(p_psi) / self.i1 - 2 * precession * mp.cos(theta)
        return mp.sqrt((precession * mp.sin(theta)) ** 2 + inner**2)

    def released(self, theta: float, p_psi: float) -> tuple[mp.mpf, mp.mpf, mp.mpf]:
        """Let go with its axis at rest: nutation's period, phi gained in it, the largest theta.

        u = cos(theta) has u'^2 = b (u - u1)(u - u0)(u - u3), b = 2 m g l/I1, u0 at the start."""
        b, a, u0 = 2 * mp.mpf(self.mgl) / self.i1, mp.mpf(p_psi) / self.i1, mp.cos(theta)
        root = mp.sqrt(a**4 - 4 * b * (a**2 * u0 - b))
        u1, u3 = (a**2 - root) / (2 * b), (a**2 + root) / (2 * b)
        m = (u0 - u1) / (u3 - u1)
        k = mp.ellipk(m)
        period = 4 * k / mp.sqrt(b * (u3 - u1))

        def precession(x: mp.mpf) -> mp.mpf:
            u = u1 + (u0 - u1) * mp.ellipfun("sn", x, m=m) ** 2
            return a * (u0 - u) / (1 - u**2)

        turned = 2 * mp.quad(precession, [0, k / 2, k]) * 2 / mp.sqrt(b * (u3 - u1))
        return period, turned, mp.acos(u1)

    def sleeping_growth(self, p_psi: float) -> mp.mpc:
        """Of the upright top: real where it falls, imaginary where it sleeps."""
        return mp.sqrt(mp.mpc(self.mgl / self.i1 - (mp.mpf(p_psi) / (2 * self.i1)) ** 2))

    def excursion(self, p_psi: float) -> mp.mpf:
        """How far it falls from upright, where it does."""
        return mp.acos(mp.mpf(p_psi) ** 2 / (2 * self.i1 * self.mgl) - 1)

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        """Euler's equations: the torque of the weight, in the body."""
        q, w = y[:4], y[4:]
        inertia = np.array([self.i1, self.i1, self.i3])
        up = attitude.matrix(q)[2]
        torque = np.cross([0, 0, 1], -self.mgl * up)
        spin = (np.cross(inertia * w, w) + torque) / inertia
        return np.concatenate([attitude.rate(q, w), spin])

    def through_upright(self, p_psi: float, w: float) -> tuple[mp.mpf, mp.mpf]:
        """Thrown from upright with the rate w across: when it is so again, and how low it was.

        u'^2 = (1 - u) ((w^2 + b (1 - u)) (1 + u) - a^2 (1 - u))."""
        b, a, w = 2 * mp.mpf(self.mgl) / self.i1, mp.mpf(p_psi) / self.i1, mp.mpf(w)
        half = (w**2 + a**2) / (2 * b)
        root = mp.sqrt(half**2 + (w**2 + b - a**2) / b)
        u1, u3 = half - root, half + root
        return 4 * mp.ellipk((1 - u1) / (u3 - u1)) / mp.sqrt(b * (u3 - u1)), mp.acos(u1)
