"""Random trees of bodies as text, and their motion by another road: Newton's and Euler's equations
of each body, summed up along the directions in which the tree can move (Kane), in NumPy."""

import random
from dataclasses import dataclass, field

import numpy as np

GRAVITY = np.array([0.3, -0.2, -9.81])
KINDS = ("revolute", "prismatic", "planar", "spherical", "free", "fixed")
FREEDOMS = {"revolute": 1, "prismatic": 1, "planar": 3, "spherical": 3, "free": 6, "fixed": 0}


def turn(axis, angle: float) -> np.ndarray:
    """Rodrigues' matrix."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def of_quaternion(q) -> np.ndarray:
    w, v = q[0], np.asarray(q[1:])
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * k + 2 * k @ k


def across(axis) -> tuple[np.ndarray, np.ndarray]:
    """What spans the plane of a planar joint, as docs/bodies.md says."""
    n = np.asarray(axis, float) / np.linalg.norm(axis)
    start = np.eye(3)[(np.argmax(abs(n)) + 1) % 3]
    e = start - n * (start @ n)
    e /= np.linalg.norm(e)
    return e, np.cross(n, e)


@dataclass
class Link:
    name: str
    parent: int  # -1: the ground
    kind: str
    axis: np.ndarray
    at: np.ndarray
    turned: list  # of (axis, angle)
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    coordinates: list = field(default_factory=list)  # names of numbers
    rotation: str = ""


def vector(v) -> str:
    return "[" + ", ".join(f"{x:.17g}" for x in v) + "]"


def random_tree(draw: random.Random, kinds, units: bool = False) -> list[Link]:
    links = []
    pick = lambda n: np.array([round(draw.uniform(-1, 1), 3) for _ in range(n)])  # noqa: E731
    for k, kind in enumerate(kinds):
        axis = draw.choice([pick(3) + 0.05, np.eye(3)[draw.randrange(3)], -np.eye(3)[1]])
        a = pick(9).reshape(3, 3)
        inertia = a @ a.T + 0.3 * np.eye(3)
        if draw.random() < 0.4:
            inertia = np.diag(np.diag(inertia))
        turned = [(pick(3) + 0.07, draw.uniform(-2, 2)) for _ in range(draw.choice((0, 0, 1, 2)))]
        where = (pick(3), turned, draw.uniform(0.5, 2), draw.choice((0, 1)) * pick(3), inertia)
        link = Link(f"b{k}", draw.randint(max(-1, k - 3), k - 1), kind, axis, *where)
        suffixes = {"revolute": [""], "prismatic": [""], "planar": ["_1", "_2", ""]}
        suffixes |= {"free": ["_x", "_y", "_z"], "spherical": [], "fixed": []}
        link.coordinates = [f"j{k}{s}" for s in suffixes[kind]]
        link.rotation = f"j{k}" if kind in ("spherical", "free") else ""
        links.append(link)
    return links


def written(links: list[Link], draw: random.Random, shuffled: bool = True) -> str:
    """The model; statements in any order that a user might choose."""
    lines = [f"gravity {vector(GRAVITY)}"]
    for k, b in enumerate(links):
        i = b.inertia
        elements = [i[0, 0], i[1, 1], i[2, 2]]
        full = [*elements, i[0, 1], i[0, 2], i[1, 2]]
        form = vector(elements if np.allclose(i, np.diag(elements)) else full)
        if draw.random() < 0.2:
            form = "[" + ", ".join(vector(row) for row in i) + "]"
        at = f" at {vector(b.com)}" if b.com.any() else ""
        lines.append(f"body {b.name} mass {b.mass:.17g} inertia {form}{at}")
        parent = "ground" if b.parent < 0 else links[b.parent].name
        axis = f" {vector(b.axis)}" if b.kind in ("revolute", "prismatic", "planar") else ""
        turned = "*".join(f"rot({vector(n)}, {a:.17g})" for n, a in b.turned)
        turned = f" turned {turned}" if turned else ""
        lines.append(f"joint j{k}: {parent} to {b.name} {b.kind}{axis} at {vector(b.at)}{turned}")
    if shuffled:
        draw.shuffle(lines)
    return "model tree\n" + "\n".join(lines) + "\n"


class Motion:
    """`values` has by name a number, of rotations a unit quaternion; `rates` by name a number, of
    rotations three in the frame of the body."""

    def __init__(self, links: list[Link], values: dict, rates: dict, gravity=GRAVITY):
        self.gravity = gravity
        self.links, self.values, self.rates = links, values, rates
        self.speeds = [(b, c) for b in links for c in b.coordinates]
        self.speeds += [(b, k) for b in links if b.rotation for k in range(3)]

    def passed(self, rates: dict, quadratic: bool) -> list[tuple]:
        """By the body R, its centre, omega, the velocity of its centre, and with `quadratic` the
        accelerations of both where no rate changes; all in space."""
        found, frames = [], []
        rest = np.eye(3), *(np.zeros(3) for _ in range(5))
        for b in self.links:
            R, p, w, v, alpha, a = rest if b.parent < 0 else frames[b.parent]
            T = np.eye(3)
            for axis, angle in b.turned:
                T = T @ turn(axis, angle)
            q = [self.values[c] for c in b.coordinates]
            dq = [rates[c] for c in b.coordinates]
            unit = b.axis / np.linalg.norm(b.axis)
            Q, shift, spin, slide = np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3)
            if b.kind == "revolute":
                Q, spin = turn(unit, q[0]), unit * dq[0]
            elif b.kind == "prismatic":
                shift, slide = unit * q[0], unit * dq[0]
            elif b.kind == "planar":
                e, f = across(b.axis)
                shift, slide = e * q[0] + f * q[1], e * dq[0] + f * dq[1]
                Q, spin = turn(unit, q[2]), unit * dq[2]
            elif b.kind == "free":
                shift, slide = np.array(q), np.array(dq)
            if b.rotation:
                Q, spin = of_quaternion(self.values[b.rotation]), np.array(rates[b.rotation])
            r, slide = R @ (b.at + T @ shift), R @ T @ slide
            own = R @ T @ Q
            spin = own @ spin
            child = (
                own,
                p + r,
                w + spin,
                v + np.cross(w, r) + slide,
                alpha + np.cross(w, spin),
                a + np.cross(alpha, r) + np.cross(w, np.cross(w, r)) + 2 * np.cross(w, slide),
            )
            frames.append(child)
            R, p, w, v, alpha, a = child
            c = R @ b.com
            swung = a + np.cross(alpha, c) + np.cross(w, np.cross(w, c))
            found.append((R, p + c, w, v + np.cross(w, c), alpha, swung) if quadratic
                         else (R, p + c, w, v + np.cross(w, c)))  # fmt: skip
        return found

    def one(self, speed) -> list[tuple]:
        b, which = speed
        rates = {c: 0.0 for link in self.links for c in link.coordinates}
        rates |= {link.rotation: np.zeros(3) for link in self.links if link.rotation}
        if isinstance(which, str):
            rates[which] = 1.0
        else:
            rates[b.rotation] = np.eye(3)[which]
        return self.passed(rates, False)

    def accelerations(self, armature=0.0, force=0.0) -> np.ndarray:
        """Of coordinates, then of the body rates of rotations, with inertias and forces of each."""
        now = self.passed(self.rates, True)
        along = [self.one(speed) for speed in self.speeds]
        n = len(along)
        M, f = np.zeros((n, n)), np.zeros(n)
        for k, b in enumerate(self.links):
            R, _, w, _, alpha, a = now[k]
            inertia = R @ b.inertia @ R.T
            Jw = np.array([moved[k][2] for moved in along])
            Jv = np.array([moved[k][3] for moved in along])
            M += b.mass * Jv @ Jv.T + Jw @ inertia @ Jw.T
            f -= b.mass * Jv @ (a - self.gravity)
            f -= Jw @ (inertia @ alpha + np.cross(w, inertia @ w))
        return np.linalg.solve(M + armature * np.eye(n), f + force)

    def order(self, model) -> list[int]:
        """The places of `speeds` among the model's accelerations."""
        names = [c.name for c in model.coordinates]
        turns = {r.name: r.turns for r in model.rotations}
        return [
            names.index(which if isinstance(which, str) else turns[b.rotation][which])
            for b, which in self.speeds
        ]

    def energy(self) -> float:
        total = 0.0
        for b, (R, c, w, v) in zip(self.links, self.passed(self.rates, False), strict=True):
            total += b.mass / 2 * v @ v + (R.T @ w) @ b.inertia @ (R.T @ w) / 2
            total -= b.mass * self.gravity @ c
        return total
