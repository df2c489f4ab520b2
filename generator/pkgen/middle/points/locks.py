"""Finds names for singularities of the functions euler() and tait_bryan(), which give the angles of
a rotation. Their divisors vanish at gimbal lock."""

from __future__ import annotations

import random
from collections.abc import Callable

from ...equations import Attitude
from ...graph.differentiate import symbols_in
from ...graph.evaluate import evaluate
from ...graph.graph import Graph, Kind, Node, Symbol


def lock(
    g: Graph, node: Node, attitudes: tuple[Attitude, ...], name: Callable[[Symbol], str]
) -> str:
    """Returns the name of a divisor that vanishes at gimbal lock, such as "cos(pitch)^2 of
    tait_bryan(R)"; "" for any other node. The divisor is recognized by its values at two
    quaternions."""
    found = set(symbols_in(g, [node]))
    for at in attitudes:
        own = [Symbol(Kind.STATE, k) for k in at.numbers]
        if not found or not found <= set(own):
            continue
        draw = random.Random(1)
        shares = []
        for _ in range(2):
            w, x, y, z = (draw.uniform(0.5, 1) for _ in range(4))
            value = evaluate(g, [node], dict(zip(own, (w, x, y, z), strict=True)))[0]
            square = (w * w + x * x + y * y + z * z) ** 2
            pitch, tilt = 2 * (w * y - x * z), w * w - x * x - y * y + z * z
            shares.append((value / (square - pitch**2), value / (square - tilt**2)))
        rotation = name(own[0]).removesuffix(".w")
        angles = f"cos(pitch)^2 of tait_bryan({rotation})", f"sin(theta)^2 of euler({rotation})"
        for words, one, other in zip(angles, *shares, strict=True):
            if abs(one - other) < 1e-12 * abs(one):
                return words
    return ""
