"""Philox4x32-10 and the three methods of noise, written anew with NumPy, of one coordinate.

The drift is a = g(t, q) - c v, the noise sqrt(S(t, q)) dW. A step takes the increment `dw` of W, or
for baoab the exact increment `ou` of dv = -c v dt + dW, both for S = 1.
"""

from __future__ import annotations

import numpy as np


def philox(counter: np.ndarray, key: np.ndarray) -> np.ndarray:
    """Returns the random words of counters and keys, arrays of uint64 below 2^32 with 4 and 2 along
    their last axis."""
    c, k, low = counter.astype(np.uint64).copy(), key.astype(np.uint64).copy(), 0xFFFFFFFF
    for _ in range(10):
        a, b = 0xD2511F53 * c[..., 0], 0xCD9E8D57 * c[..., 2]
        c = np.stack(
            [b >> 32 ^ c[..., 1] ^ k[..., 0], b & low, a >> 32 ^ c[..., 3] ^ k[..., 1], a & low], -1
        )
        k = k + np.array([0x9E3779B9, 0xBB67AE85], np.uint64) & low
    return c


def normal(seed: int, member: np.ndarray, step: int, index: int) -> np.ndarray:
    """Returns the normal number `index` of a step, of each member."""
    member = np.asarray(member, np.uint64)
    high = np.uint64(step >> 32 << 16) | member >> np.uint64(32)
    words = [np.full(member.shape, x, np.uint64) for x in (step & 0xFFFFFFFF, index // 2)]
    key = np.array([seed & 0xFFFFFFFF, seed >> 32], np.uint64)
    x = philox(np.stack([*words, member & np.uint64(0xFFFFFFFF), high], -1), key)
    u = [((x[..., j] << np.uint64(32) | x[..., j + 1]) >> np.uint64(11)) for j in (0, 2)]
    u, angle = ((k.astype(float) + 0.5) * 2.0**-53 for k in u)
    turn = np.sin if index % 2 else np.cos
    return np.sqrt(-2 * np.log(u)) * turn(2 * np.pi * angle)


def heun(q, v, t, h, g, c, S, dw):
    a, b = g(t, q) - c * v, np.sqrt(S(t, q)) * dw
    q1, v1 = q + h * v, v + h * a + b
    a1, b1 = g(t + h, q1) - c * v1, np.sqrt(S(t + h, q1)) * dw
    return q + h * (v + v1) / 2, v + (h * (a + a1) + b + b1) / 2


def stochastic_verlet(q, v, t, h, g, c, S, dw):
    b = np.sqrt(S(t + h / 2, q + h / 2 * v)) * dw
    d = (h * v + h * h / 2 * g(t, q) + h / 2 * b) / (1 + c * h / 2)
    return q + d, v + h / 2 * (g(t, q) + g(t + h, q + d)) - c * d + b


def baoab(q, v, t, h, g, c, S, ou):
    v = v + h / 2 * g(t, q)
    q = q + h / 2 * v
    v = np.exp(-c * h) * v + np.sqrt(S(t + h / 2, q)) * ou
    q = q + h / 2 * v
    return q, v + h / 2 * g(t + h, q)


METHODS = {"heun": heun, "stochastic_verlet": stochastic_verlet, "baoab": baoab}


def spread(method: str, c: float, h: float) -> float:
    """Returns the standard deviation of a step's increment."""
    return np.sqrt(-np.expm1(-2 * c * h) / (2 * c)) if method == "baoab" else np.sqrt(h)
