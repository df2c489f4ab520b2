"""Mass, centre of mass and inertia of bodies from geoms, the primitive shapes of MJCF."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .turns import Matrix, Turns, Vector, of_direction, seen_from
from .xml import Element

WATER = 1000.0  # default density of a geom [kg/m^3]
MASSLESS = ("plane", "hfield")
SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}  # length of `size`
HELP = "give its body an <inertial>: MuJoCo writes them if <compiler saveinertial> is true"


@dataclass
class Lump:
    """A mass, its centre, and its inertia about its centre, along the axes of its body."""

    mass: float
    com: Vector
    inertia: Matrix


def lump(geom: Element, at: Vector, turn: Turns) -> Lump | None:
    """Returns mass and inertia of a geom at the position `at`, rotated by `turn`; None if the geom
    has no mass. Raises ModelError."""
    kind = geom.attributes.get("type", "sphere")
    own = geom.number("mass") if "mass" in geom.attributes else None
    density = geom.number("density", WATER)
    if min(own or 0.0, density) < 0:
        raise geom.wrong("the mass or the density of a geom is negative")
    if kind in MASSLESS or own == 0 or (own is None and density == 0):
        return None
    if kind not in SIZES or "mesh" in geom.attributes:
        raise geom.wrong("masses are not taken from meshes", HELP)
    if geom.attributes.get("shellinertia", "false") != "false":
        raise geom.wrong("'shellinertia' of a geom is not read", HELP)
    size = geom.numbers("size", 0, (0.0,))
    if "fromto" in geom.attributes:
        at, turn, half = from_to(geom, kind)
        size = (size[0], half) if SIZES[kind] == 2 else (size[0], size[0], half)
    size = size[: SIZES[kind]]
    if len(size) < SIZES[kind] or min(size) <= 0:
        raise geom.wrong(f"the size of a {kind} is {SIZES[kind]} positive numbers")
    volume, moments = volume_and_moments(kind, size)
    mass = density * volume if own is None else own
    x, y, z = (mass * moment for moment in moments)
    return Lump(mass, at, seen_from(turn, ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))))


def from_to(geom: Element, kind: str) -> tuple[Vector, Turns, float]:
    """Returns centre, rotation and half length of a geom between two points (`fromto`)."""
    if SIZES[kind] == 1:
        raise geom.wrong(f"a {kind} has no 'fromto'")
    ends = geom.numbers("fromto", 6)
    along = tuple(a - b for a, b in zip(ends[:3], ends[3:], strict=True))
    if not any(along):
        raise geom.wrong("the ends of a geom are one point")
    middle = tuple((a + b) / 2 for a, b in zip(ends[:3], ends[3:], strict=True))
    return middle, of_direction(along), math.hypot(*along) / 2


def volume_and_moments(kind: str, size: Sequence[float]) -> tuple[float, Vector]:
    """Returns the volume of a shape, and its moments of inertia if its mass is 1."""
    a, b, c = (*size, 0.0, 0.0)[:3]
    if kind == "sphere":
        return 4 / 3 * math.pi * a**3, (0.4 * a**2,) * 3
    if kind in ("ellipsoid", "box"):
        volume, part = (4 / 3 * math.pi, 5) if kind == "ellipsoid" else (8, 3)
        return volume * a * b * c, ((b**2 + c**2) / part, (a**2 + c**2) / part,
                                    (a**2 + b**2) / part)  # fmt: skip
    tube, across, along = 2 * math.pi * a**2 * b, (3 * a**2 + 4 * b**2) / 12, a**2 / 2
    if kind == "cylinder":
        return tube, (across, across, along)
    caps = 4 / 3 * math.pi * a**3
    volume = tube + caps
    across = (tube * across + caps * (0.4 * a**2 + b**2 + 0.75 * a * b)) / volume
    along = (tube * along + caps * 0.4 * a**2) / volume
    return volume, (across, across, along)


def together(lumps: Sequence[Lump]) -> Lump:
    if len(lumps) == 1:
        return lumps[0]
    mass = sum(part.mass for part in lumps)
    com = sum(part.mass * np.array(part.com) for part in lumps) / mass
    inertia = np.zeros((3, 3))
    for part in lumps:
        d = np.array(part.com) - com
        inertia += np.array(part.inertia) + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Lump(mass, tuple(com.tolist()), _matrix(inertia))


def bounded(body: Lump, mass: float, moment: float) -> Lump:
    """Returns a body with at least this mass and principal moments of at least `moment`."""
    body = replace(body, mass=max(body.mass, mass))
    values, axes = np.linalg.eigh(np.array(body.inertia))
    if values[0] >= moment:
        return body
    return replace(body, inertia=_matrix(axes @ np.diag(np.maximum(values, moment)) @ axes.T))


def balanced(body: Lump) -> Lump:
    """Returns the body unchanged if no principal moment of inertia exceeds the sum of the other
    two; otherwise, all three moments are replaced by their mean."""
    values = np.linalg.eigvalsh(np.array(body.inertia))
    if values[0] + values[1] >= values[2]:
        return body
    return replace(body, inertia=_matrix(np.eye(3) * values.mean()))


def _matrix(m: np.ndarray) -> Matrix:
    return tuple(tuple(row) for row in ((m + m.T) / 2).tolist())
