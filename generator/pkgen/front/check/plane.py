"""Unit vectors that span the plane normal to an axis."""

from __future__ import annotations

import math
from collections.abc import Sequence


def across(axis: Sequence[float]) -> tuple[str, str]:
    """Returns two orthogonal unit vectors e and f, as text, with e x f along the axis: for z they
    are x, y; for x they are y, z; for y they are z, x."""
    length = math.hypot(*map(float, axis))
    n = [float(part) / length for part in axis]
    k = max(range(3), key=lambda i: abs(n[i]))
    start = [float(i == (k + 1) % 3) for i in range(3)]
    along = sum(a * b for a, b in zip(start, n, strict=True))
    e = [a - along * b for a, b in zip(start, n, strict=True)]
    size = math.hypot(*e)
    e = [part / size for part in e]
    f = [n[i - 2] * e[i - 1] - n[i - 1] * e[i - 2] for i in range(3)]
    return _text(e), _text(f)


def _text(vector: Sequence[float]) -> str:
    return "[" + ", ".join(f"{part + 0.0:.17g}" for part in vector) + "]"
