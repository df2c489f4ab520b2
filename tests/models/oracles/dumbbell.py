"""Two bodies with a ball joint: Newton's and Euler's laws, the joint's force an unknown.

On body k acts +-F at d_k (in the body): m v' = +-F, I w' = -w x I w +- d x R^T F; that both have
the same acceleration at the joint, v' + R (w' x d + w x (w x d)), are three linear equations for F.
"""

from dataclasses import dataclass

import numpy as np

from . import attitude


def hat(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


@dataclass(frozen=True)
class Body:
    mass: float
    inertia: np.ndarray  # of the axes
    joint: np.ndarray

    def free(self, turned: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """w', the acceleration at the joint without its force, and what a force adds there."""
        spin = -np.cross(w, self.inertia * w) / self.inertia
        drawn = np.cross(spin, self.joint) + np.cross(w, np.cross(w, self.joint))
        lever = hat(self.joint)
        yields = np.eye(3) / self.mass - turned @ lever @ (lever / self.inertia[:, None]) @ turned.T
        return spin, turned @ drawn, yields


@dataclass(frozen=True)
class Dumbbell:
    one: Body
    two: Body

    def rate(self, t: float, y: np.ndarray) -> np.ndarray:
        """Of (q1, q2, w1, w2, r1, v1), the second body's place following from the joint."""
        q1, q2, w1, w2, v1 = y[:4], y[4:8], y[8:11], y[11:14], y[17:20]
        turned1, turned2 = attitude.matrix(q1), attitude.matrix(q2)
        spin1, drawn1, yields1 = self.one.free(turned1, w1)
        spin2, drawn2, yields2 = self.two.free(turned2, w2)
        force = np.linalg.solve(yields1 + yields2, drawn2 - drawn1)
        spin1 = spin1 + np.cross(self.one.joint, turned1.T @ force) / self.one.inertia
        spin2 = spin2 - np.cross(self.two.joint, turned2.T @ force) / self.two.inertia
        turning = [attitude.rate(q1, w1), attitude.rate(q2, w2), spin1, spin2]
        return np.concatenate([*turning, v1, force / self.one.mass])
