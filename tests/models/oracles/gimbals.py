"""A gyroscope in gimbals by its angles: alpha of the outer ring, beta of the inner, and spin.

With p = C (spin' + alpha' cos beta), Ja = J + (K2 + A) sin^2 beta + K3 cos^2 beta, Jb = K1 + A,

    Jb beta'' = (K2 + A - K3) alpha'^2 sin cos - p alpha' sin
    Ja alpha'' = -2 (K2 + A - K3) alpha' beta' sin cos + p beta' sin
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Gimbals:
    A: float = 0.02
    C: float = 0.03
    J: float = 0.01
    K1: float = 0.004
    K2: float = 0.003
    K3: float = 0.002

    def rate(self, p: float, y: np.ndarray) -> np.ndarray:
        """Of (alpha, beta, alpha', beta')."""
        s, c = np.sin(y[1]), np.cos(y[1])
        across = self.K2 + self.A - self.K3
        outer = self.J + (self.K2 + self.A) * s**2 + self.K3 * c**2
        return np.array(
            [
                y[2],
                y[3],
                (p * y[3] * s - 2 * across * y[2] * y[3] * s * c) / outer,
                (across * y[2] ** 2 * s * c - p * y[2] * s) / (self.K1 + self.A),
            ]
        )
