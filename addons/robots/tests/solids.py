"""Shapes as points with weights, whose sums are their masses and moments."""

from __future__ import annotations

import numpy as np


def ball(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights that integrate polynomials over a ball exactly."""
    x, w = np.polynomial.legendre.leggauss(8)
    phi = 2 * np.pi * np.arange(12) / 12
    r, c, p = (a.ravel() for a in np.meshgrid(radius * (x + 1) / 2, x, phi))
    wr, wc, _ = (a.ravel() for a in np.meshgrid(radius * w / 2, w, phi))
    s = np.sqrt(1 - c**2)
    points = np.array([r * s * np.cos(p), r * s * np.sin(p), r * c]).T
    return points, wr * wc * r**2 * 2 * np.pi / 12


def tube(radius: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    x, w = np.polynomial.legendre.leggauss(8)
    phi = 2 * np.pi * np.arange(12) / 12
    r, z, p = (a.ravel() for a in np.meshgrid(radius * (x + 1) / 2, half * x, phi))
    wr, wz, _ = (a.ravel() for a in np.meshgrid(radius * w / 2, half * w, phi))
    return np.array([r * np.cos(p), r * np.sin(p), z]).T, wr * wz * r * 2 * np.pi / 12


def half_ball(radius: float, at: float) -> tuple[np.ndarray, np.ndarray]:
    """The half of a ball away from 0, in discs along z."""
    x, w = np.polynomial.legendre.leggauss(12)
    phi = 2 * np.pi * np.arange(12) / 12
    z, s, p = (a.ravel() for a in np.meshgrid(radius * (x + 1) / 2, (x + 1) / 2, phi))
    wz, ws, _ = (a.ravel() for a in np.meshgrid(radius * w / 2, w / 2, phi))
    wide = np.sqrt(radius**2 - z**2)
    points = np.array([wide * s * np.cos(p), wide * s * np.sin(p), at + np.sign(at) * z]).T
    return points, wz * ws * s * wide**2 * 2 * np.pi / 12


def cloud(kind: str, size) -> tuple[np.ndarray, np.ndarray]:
    if kind == "box":
        x, w = np.polynomial.legendre.leggauss(3)
        points = np.array([a.ravel() for a in np.meshgrid(*(s * x for s in size))]).T
        return points, np.prod([a.ravel() for a in np.meshgrid(*(s * w for s in size))], axis=0)
    if kind == "sphere":
        return ball(size[0])
    if kind == "ellipsoid":
        points, weights = ball(1)
        return points * size, weights * np.prod(size)
    parts = [tube(*size)]
    if kind == "capsule":
        parts += [half_ball(size[0], size[1]), half_ball(size[0], -size[1])]
    return tuple(np.concatenate(a) for a in zip(*parts, strict=True))


def moved(kind: str, size, scale: float, at=(0, 0, 0), R=None) -> tuple[np.ndarray, np.ndarray]:
    points, weights = cloud(kind, size)
    return points @ (np.eye(3) if R is None else R).T + at, scale * weights


def summed(*clouds) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre, and inertia about it, of clouds of points."""
    points, weights = (np.concatenate(a) for a in zip(*clouds, strict=True))
    mass, com = weights.sum(), weights @ points / weights.sum()
    d = points - com
    return mass, com, (weights @ (d * d).sum(1)) * np.eye(3) - np.einsum("k,ki,kj", weights, d, d)
