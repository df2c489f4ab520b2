"""Rigid-body rotations: the attitude R in SO(3) is represented by a unit quaternion
Q = (w, x, y, z), which transforms body axes to space.

The rates are the angular velocities w_i about the body axes (body rates): Q' = Q (0, w)/2. A
function f of the attitude has a derivative X_i f along each body axis: its rate if w_i is 1 and the
other body rates are 0. With p = dL/dw, Hamilton's principle gives

    dp/dt = X L + p x w + torque

(Poincare 1901; Marsden and Ratiu, Introduction to Mechanics and Symmetry, section 13.5). The
transformation Q v Q* of a vector v is a polynomial of degree 2 in Q. The equations and their
conservation laws therefore hold for a Q of any length, such as in the stages of an integrator."""

from __future__ import annotations

import random
from collections.abc import Callable

from ..equations import Attitude, Row
from ..graph.differentiate import symbols_in
from ..graph.evaluate import evaluate
from ..graph.frames import cross
from ..graph.graph import ZERO, Graph, Kind, Node, Symbol

# For each body axis i, the quaternion product Q e_i. Each of its four components equals a component
# of Q or its negative, which is given as (index of the component of Q, sign).
_TURNED = (
    ((1, -1), (0, 1), (3, 1), (2, -1)),
    ((2, -1), (3, -1), (0, 1), (1, 1)),
    ((3, -1), (2, 1), (1, -1), (0, 1)),
)


def numbers(g: Graph, at: Attitude) -> Row:
    """Returns the symbols of the quaternion Q = (w, x, y, z) of the rotation `at`; () if a
    reduction has removed Q."""
    return tuple(g.symbol(Symbol(Kind.STATE, k)) for k in at.numbers)


def rates(g: Graph, at: Attitude) -> Row:
    """Returns the symbols of the body rates about the axes x, y, z."""
    return tuple(g.symbol(Symbol(Kind.RATE, i)) for i in at.rates)


def turned(g: Graph, quaternion: Row, axis: int) -> Row:
    """Returns the four components of Q e_i/2 for the body axis i = `axis` (0, 1 or 2)."""
    half = g.power(g.number(2), -1)
    return tuple(
        g.multiply(g.multiply(half, g.number(sign)), quaternion[k]) for k, sign in _TURNED[axis]
    )


def quaternion_rates(g: Graph, quaternion: Row, w: Row) -> Row:
    """Returns the four components of Q' = Q (0, w)/2."""
    along = [turned(g, quaternion, axis) for axis in range(3)]
    return tuple(g.dot(w, each) for each in zip(*along, strict=True))


def body_rates(g: Graph, quaternion: Row, rates: Row) -> Row:
    """Returns the body rates w for a quaternion Q of length 1 and its rates Q' = Q (0, w)/2."""
    return tuple(g.multiply(g.number(4), x) for x in along_axes(g, quaternion, rates))


def rate_of_quaternion(g: Graph, at: Attitude, state: int) -> Node:
    """Returns the time derivative of one component of the quaternion of the rotation `at`. `state`
    is the index of the state that stands for this component."""
    return quaternion_rates(g, numbers(g, at), rates(g, at))[at.numbers.index(state)]


def along_axes(g: Graph, quaternion: Row, by: Row) -> Row:
    """Returns the derivatives X_i f of a function f; `by` are its derivatives by the components of
    Q."""
    axes = (turned(g, quaternion, axis) for axis in range(3))
    return tuple(g.dot(by, to) for to in axes)


def slopes(g: Graph, attitudes: tuple[Attitude, ...], by: dict[Node, Node]) -> dict[int, Node]:
    """Returns the derivatives X_i f of a function f for all attitudes, by the index of the
    coordinate whose rate is w_i. `by` maps symbols, including components of quaternions, to
    derivatives of f."""
    found = {}
    for at in attitudes:
        quaternion = numbers(g, at)
        if not quaternion:
            found |= dict.fromkeys(at.rates, ZERO)
            continue
        own = tuple(by.get(q, ZERO) for q in quaternion)
        found |= zip(at.rates, along_axes(g, quaternion, own), strict=True)
    return found


def gyroscopic(g: Graph, attitudes: tuple[Attitude, ...], momenta: Row) -> dict[int, Node]:
    """Returns the components of p x w for all attitudes, by the index of the coordinate whose rate
    is w_i. `momenta` has the momenta of all coordinates."""
    found = {}
    for at in attitudes:
        p = tuple(momenta[i] for i in at.rates)
        found |= zip(at.rates, cross(g, p, rates(g, at)), strict=True)
    return found


def on_sphere(g: Graph, attitudes: tuple[Attitude, ...]) -> dict[Node, Node]:
    """Returns substitutions that give each quaternion the length 1, by stereographic projection.
    The symbols x, y, z become independent numbers a, b, c: w = (1 - s)/(1 + s), x = 2 a/(1 + s),
    ... with s = a^2 + b^2 + c^2."""
    found: dict[Node, Node] = {}
    for at in attitudes:
        w, *vector = numbers(g, at)
        square = g.sum(g.power(a, 2) for a in vector)
        below = g.power(g.add(g.number(1), square), -1)
        found[w] = g.multiply(g.subtract(g.number(1), square), below)
        found |= {a: g.multiply(g.number(2), g.multiply(a, below)) for a in vector}
    return found


def rotated(g: Graph, quaternion: Row, a: Row) -> Row:
    """Returns the vector Q a Q* (three components) for a vector a."""
    w, x, y, z = quaternion

    def twice(*terms: tuple[int, Node, Node]) -> Node:
        return g.multiply(
            g.number(2),
            g.sum(g.multiply(g.number(sign), g.multiply(b, c)) for sign, b, c in terms),
        )

    def squares(sign_x: int, sign_y: int, sign_z: int) -> Node:
        signed = ((1, w), (sign_x, x), (sign_y, y), (sign_z, z))
        return g.sum(g.multiply(g.number(s), g.power(b, 2)) for s, b in signed)

    rows = (
        (squares(1, -1, -1), twice((1, x, y), (-1, w, z)), twice((1, x, z), (1, w, y))),
        (twice((1, x, y), (1, w, z)), squares(-1, 1, -1), twice((1, y, z), (-1, w, x))),
        (twice((1, x, z), (-1, w, y)), twice((1, y, z), (1, w, x)), squares(-1, -1, 1)),
    )
    return tuple(g.dot(row, a) for row in rows)


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
