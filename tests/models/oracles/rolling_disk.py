"""A thin disk that rolls on a plane, by the angles of its axis: steady motions, stability.

theta is the angle of its axis from the vertical (0: flat), W the precession, w the spin about the
axis (the psi' + W cos theta); A about a diameter, C about the axis:

    (A + m a^2) theta'' = A W^2 sin cos - (C + m a^2) w W sin - m g a cos
    (C + m a^2) w' = m a^2 W theta' sin
    A (W sin)' = C w theta' - A W theta' cos

(E. Routh, Advanced Rigid Dynamics, art. 244; Y. Neimark, N. Fufaev, Dynamics of Nonholonomic
Systems, 1972; O. O'Reilly, Nonlinear Dynamics 10 (1996) 287). Steady where the first right side
vanishes: the centre then goes round a circle of radius a w/W. Upright, rolling straight is stable
where C (C + m a^2) w^2 > A m g a (uniform: w^2 > g/(3 a)) and spinning on the spot where (A + m
a^2) W^2 > m g a (W^2 > 4 g/(5 a)).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Disk:
    a: float = 1.0
    g: float = 9.81
    A: float = 0.25  # of a uniform one, in m a^2
    C: float = 0.5

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        """Of (theta, theta', W, w)."""
        theta, nod, W, w = y
        return np.array([nod, self.nod(theta, W, w), *self.turned(theta, nod, W, w)])

    def nod(self, theta: float, W: float, w: float) -> float:
        s, c = np.sin(theta), np.cos(theta)
        force = self.A * W**2 * s * c - (self.C + 1) * w * W * s - self.g / self.a * c
        return force / (self.A + 1)

    def turned(self, theta: float, nod: float, W: float, w: float) -> tuple[float, float]:
        s, c = np.sin(theta), np.cos(theta)
        return nod * (self.C * w / self.A - 2 * W * c) / s, W * nod * s / (self.C + 1)

    def steady_spin(self, theta: float, W: float) -> float:
        s, c = np.sin(theta), np.cos(theta)
        return (self.A * W**2 * s * c - self.g / self.a * c) / ((self.C + 1) * W * s)

    def frequency_squared(self, theta: float, W: float, w: float) -> float:
        """Of small nods beside a steady motion; W and w follow them as `turned` says."""
        h = 1e-6
        dW, dw = self.turned(theta, 1.0, W, w)
        ahead = self.nod(theta + h, W + h * dW, w + h * dw)
        behind = self.nod(theta - h, W - h * dW, w - h * dw)
        return -(ahead - behind) / (2 * h)
