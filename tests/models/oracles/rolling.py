"""A body that rolls without slipping on a horizontal plane, by Newton's and Euler's laws.

In the body: g the vertical, r(g) from the centre of mass to the point of contact, which is at rest,
so v = r x w. With F the force there, m (v' + w x v) = F - m G g and I w' + w x I w = r x F - drag
w, so

    (I + m (r^2 - r r^T)) w' = -w x I w + m r x (r' x w + w x v + G g) - drag w,   g' = g x w

T. Kane, D. Levinson, Int. J. Non-Linear Mech. 17 (1982) 175; A. Borisov, I. Mamaev, Phys. Usp. 46
(2003) 393. Of a surface with curvature radii a1, a2 at the bottom, its centre of mass at height h,
inertia ((A, D), (D, B)), C about the vertical, small motions beside a spin n are, for u = g2, w =
-g1,

    J (u, w)'' + n S (u, w)' + K (u, w) + O(n^2) = 0
    J = ((A + m h^2, D), (D, B + m h^2)),   K = m G diag(a2 - h, a1 - h)
    (S + S^T)/2 = ((0, s), (s, 0)),   s = m h (a1 - a2)/2

so to first order in n the two oscillations of frequencies w1, w2 grow at s1, s2 with

    s1/w1^2 + s2/w2^2 = 0,   s1 + s2 = n m h (a1 - a2) D/(2 det J)

one sense feeds the faster one, the other the slower, at rates as the squares of their frequencies
(G. Walker, Quart. J. Pure Appl. Math. 28 (1896) 175; H. Bondi, Proc. R. Soc. A 405 (1986) 265; A.
Garcia, M. Hubbard, Proc. R. Soc. A 418 (1988) 165). `linear` is exact in n, by a complex step.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import attitude

Surface = Callable[[np.ndarray], np.ndarray]


def ellipsoid(a: float, b: float, c: float, below: float = 0.0) -> Surface:
    """Half axes, and by how much the centre of mass lies below the centre."""
    squares = np.array([a * a, b * b, c * c])
    centre = np.array([0, 0, below])
    return lambda g: centre - squares * g / np.sqrt(squares @ (g * g))


def disk(radius: float) -> Surface:
    """A thin one: a rim about the third axis."""
    rim = np.array([1.0, 1.0, 0.0])
    return lambda g: -radius * rim * g / np.sqrt(rim @ (g * g))


@dataclass(frozen=True)
class Rolling:
    surface: Surface
    inertia: np.ndarray
    mass: float = 1.0
    gravity: float = 9.81
    drag: float = 0.0

    def swept(self, g: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """r' of g': a derivative along, by a complex step, exact to round-off."""
        if np.iscomplexobj(g) or np.iscomplexobj(rate):
            h = 1e-5  # of the derivatives of derivatives below
            s = self.surface
            near = (s(g + h * rate) - s(g - h * rate)) / (2 * h)
            far = (s(g + 2 * h * rate) - s(g - 2 * h * rate)) / (4 * h)
            return (4 * near - far) / 3
        return self.surface(g + 1e-30j * rate).imag / 1e-30

    def spin(self, g: np.ndarray, w: np.ndarray) -> np.ndarray:
        """w'."""
        r = self.surface(g)
        v = np.cross(r, w)
        moved = np.cross(self.swept(g, np.cross(g, w)), w) + np.cross(w, v) + self.gravity * g
        whole = self.inertia + self.mass * (r @ r * np.eye(3) - np.outer(r, r))
        torque = -np.cross(w, self.inertia @ w) + self.mass * np.cross(r, moved) - self.drag * w
        return np.linalg.solve(whole, torque)

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        """Of (attitude, place in the plane, w)."""
        q, w = y[:4], y[6:]
        turned = attitude.matrix(q)
        v = turned @ np.cross(self.surface(turned[2]), w)
        return np.concatenate([attitude.rate(q, w), v[:2], self.spin(turned[2], w)])

    def energy(self, y: np.ndarray) -> float:
        g, w = attitude.matrix(y[:4])[2], y[6:]
        r = self.surface(g)
        v = np.cross(r, w)
        lifted = self.mass * self.gravity * -(r @ g)
        return float(self.mass * (v @ v) / 2 + w @ self.inertia @ w / 2 + lifted)

    def linear(self, g: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Eigenvalues of the equations of (g, w) beside a state."""
        start, h, columns = np.concatenate([g, w]), 1e-20, []
        for k in range(6):
            y = start.astype(complex)
            y[k] += 1j * h
            change = np.concatenate([np.cross(y[:3], y[3:]), self.spin(y[:3], y[3:])])
            columns.append(change.imag / h)
        return np.linalg.eigvals(np.array(columns).T)


def growth_to_first_order(
    body: Rolling, radii: tuple[float, float], height: float, n: float
) -> list[tuple[float, float]]:
    """(frequency, growth) of both oscillations of a body with spin n about the vertical."""
    level = body.mass * height**2
    moments = body.inertia[:2, :2] + level * np.eye(2)
    weight = body.mass * body.gravity
    stiff = weight * np.diag([radii[1] - height, radii[0] - height])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(moments, stiff)).real)
    total = n * body.mass * height * (radii[0] - radii[1]) * moments[0, 1]
    total /= 2 * np.linalg.det(moments)
    difference = squares[1] - squares[0]
    return [
        (float(np.sqrt(squares[0])), float(-total * squares[0] / difference)),
        (float(np.sqrt(squares[1])), float(total * squares[1] / difference)),
    ]
