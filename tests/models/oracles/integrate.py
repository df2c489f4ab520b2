"""Extrapolated midpoint steps (Gragg, Bulirsch, Stoer): order 16 of a fixed step, in twenty lines.

E. Hairer, S. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.9.
"""

from collections.abc import Callable

import numpy as np

PARTS = (2, 4, 6, 8, 10, 12, 14, 16)
Rate = Callable[[float, np.ndarray], np.ndarray]


def step(rate: Rate, t: float, y: np.ndarray, h: float) -> np.ndarray:
    rows: list[np.ndarray] = []
    first = rate(t, y)
    for k, parts in enumerate(PARTS):
        s = h / parts
        before, now = y, y + s * first
        for j in range(1, parts):
            before, now = now, before + 2 * s * rate(t + j * s, now)
        now = (before + now + s * rate(t + h, now)) / 2
        row = [now]
        for j in range(1, k + 1):
            ratio = (parts / PARTS[k - j]) ** 2 - 1
            row.append(row[-1] + (row[-1] - rows[j - 1]) / ratio)
        rows = row
    return rows[-1]


def integrate(rate: Rate, y: np.ndarray, times: np.ndarray, h: float) -> np.ndarray:
    """The states at these times, the first of which is that of y, by steps of h at most."""
    y, t, found = np.array(y, float), float(times[0]), [np.array(y, float)]
    for end in times[1:]:
        many = max(1, int(np.ceil((end - t) / h - 1e-9)))
        part = (end - t) / many
        for k in range(many):
            y = step(rate, t + k * part, y, part)
        t = float(end)
        found.append(y)
    return np.array(found)


def crossing(rate: Rate, y: np.ndarray, h: float, of: Callable, until: float) -> tuple:
    """When `of(y)` first changes its sign after a step, by the secant rule, and the state then."""
    t, value = 0.0, of(y)
    while t < until:
        after = step(rate, t, y, h)
        if value * of(after) < 0:
            a, fa, b, fb = 0.0, value, h, of(after)
            for _ in range(60):
                c = b - fb * (b - a) / (fb - fa)
                state = step(rate, t, y, c)
                a, fa, b, fb = b, fb, c, of(state)
                if abs(b - a) < 1e-14 or fa == fb:
                    break
            return t + b, state
        y, t, value = after, t + h, of(after)
    return np.inf, y
