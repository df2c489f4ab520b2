"""Trees of bodies in the form that each package reads, and serial arms of revolute joints in space.

Link k hangs on link k - 1 by a joint about one of the three axes, is .3 m long, has its centre of
mass in its middle and one moment of inertia, as a ball has. Robots are read by robots.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

LENGTH, CENTRE, GRAVITY = 0.3, 0.15, 9.81
TURNS = "zyyxyxy"  # of a robot of seven joints, over and over
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]
UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Link:
    """What hangs on link `parent`, -1 for the ground, by a joint at a place of that one's frame,
    which is turned; its own frame is at the joint. kg, m, kg m^2, the tensor about the centre."""

    parent: int
    kind: str  # revolute or prismatic
    axis: Vector
    at: Vector
    turn: Matrix
    mass: float
    centre: Vector
    inertia: Matrix


def links(count: int) -> list[Link]:
    """Of the serial arm."""
    return [_link(k) for k in range(count)]


def _link(k: int) -> Link:
    moment, at = 0.021 + k / 1000, (0.0, 0.0, LENGTH if k else 0.0)
    inertia = tuple(tuple(moment * x for x in row) for row in UNIT)
    axis = AXES[TURNS[k % len(TURNS)]]
    return Link(k - 1, "revolute", axis, at, UNIT, 1.1 + k / 10, (0.0, 0.0, CENTRE), inertia)


def lag(name: str, arm: Sequence[Link]) -> str:
    """pkgen's. Masses, moments of inertia and g are parameters, lengths and axes numbers."""
    count = len(arm)
    angles = ", ".join(f"q{k}" for k in range(1, count + 1))
    lines = [f"model {name}", f"param g = {GRAVITY} [m/s^2]", f"coord {angles} [rad]"]
    turns, spin, joint = "", "", ""
    for k, link in enumerate(arm, 1):
        axis = list(link.axis)
        lines += [
            f"param m{k} = {link.mass!r} [kg] in (0, inf)",
            f"param I{k} = {link.inertia[0][0]!r} [kg*m^2] in (0, inf)",
            f"let axis{k} = {turns}{axis}",
        ]
        turns += f"rot({axis}, q{k})*"
        lines += [
            f"let spin{k} = {spin}q{k}'*axis{k}",
            f"let along{k} = {turns}[0, 0, 1]",
            f"let centre{k} = {joint}({CENTRE} [m])*along{k}",
            f"kinetic m{k}/2*dot(centre{k}', centre{k}') + I{k}/2*dot(spin{k}, spin{k})",
            f"potential m{k}*g*centre{k}.z",
        ]
        if k < count:
            lines.append(f"let joint{k} = {joint}({LENGTH} [m])*along{k}")
        spin, joint = f"spin{k} + ", f"joint{k} + "
    starts = ", ".join(f"q{k} = 0.3" for k in range(1, count + 1))
    return "\n".join([*lines, f"start {starts}"]) + "\n"


def rows(tree: Sequence[Link]) -> str:
    """Pinocchio's: a line a link, all its numbers."""

    def line(x: Link) -> str:
        numbers = (*x.axis, *sum(x.turn, ()), *x.at, x.mass, *x.centre, *sum(x.inertia, ()))
        return " ".join([str(x.parent), x.kind[0], *(repr(float(n)) for n in numbers)])

    return "".join(f"{line(x)}\n" for x in tree)


def mjcf(tree: Sequence[Link]) -> str:
    """MuJoCo's, without all that is not a body."""
    inside = {k: "" for k in range(-1, len(tree))}
    for k, x in reversed(list(enumerate(tree))):
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = x.inertia
        joint = "hinge" if x.kind == "revolute" else "slide"
        inside[x.parent] = (
            f'<body pos="{_said(x.at)}" quat="{_said(quaternion(x.turn))}">'
            f'<joint type="{joint}" axis="{_said(x.axis)}"/>'
            f'<inertial pos="{_said(x.centre)}" mass="{x.mass!r}"'
            f' fullinertia="{_said((xx, yy, zz, xy, xz, yz))}"/>\n'
            f"{inside[k]}</body>{inside[x.parent]}"
        )
    return f"""<mujoco>
<option gravity="0 0 -{GRAVITY}"><flag constraint="disable" contact="disable"/></option>
<worldbody>{inside[-1]}</worldbody>
</mujoco>
"""


def _said(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(x)) for x in numbers)


def quaternion(m: Matrix) -> Vector:
    """w, x, y, z of a matrix; from its largest number, so that none is lost (S. W. Shepperd)."""
    trace = m[0][0] + m[1][1] + m[2][2]
    squares = [1 + trace, *(1 + 2 * m[k][k] - trace for k in range(3))]
    i = max(range(4), key=squares.__getitem__)
    if i == 0:
        q = [squares[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]
    else:
        a, b, c = (i - 1) % 3, i % 3, (i + 1) % 3
        q = [m[c][b] - m[b][c], 0.0, 0.0, 0.0]
        q[1 + a], q[1 + b], q[1 + c] = squares[i], m[a][b] + m[b][a], m[a][c] + m[c][a]
    size = sum(x * x for x in q) ** 0.5
    return tuple(x / size for x in q)
