"""Serial arms of revolute joints in space, in the form that each package reads.

Link k hangs on link k - 1 by a joint about one of the three axes, is .3 m long, has its centre of
mass in its middle and one moment of inertia, as a ball has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

LENGTH, CENTRE, GRAVITY = 0.3, 0.15, 9.81
TURNS = "zyyxyxy"  # of a robot of seven joints, over and over
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


@dataclass(frozen=True)
class Link:
    """kg and kg m^2."""

    axis: tuple[int, int, int]
    mass: float
    inertia: float


def links(count: int) -> list[Link]:
    return [Link(AXES[TURNS[k % len(TURNS)]], 1.1 + k / 10, 0.021 + k / 1000) for k in range(count)]


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
            f"param I{k} = {link.inertia!r} [kg*m^2] in (0, inf)",
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


def rows(arm: Sequence[Link]) -> str:
    """A line a link: axis, mass, moment of inertia, centre, length."""
    return "".join(
        f"{' '.join(map(str, x.axis))} {x.mass!r} {x.inertia!r} {CENTRE} {LENGTH}\n" for x in arm
    )


def mjcf(arm: Sequence[Link]) -> str:
    """MuJoCo's, without all that is not a body."""
    text = ""
    for k, link in reversed(list(enumerate(arm))):
        axis, inertia = " ".join(map(str, link.axis)), " ".join([repr(link.inertia)] * 3)
        text = (
            f'<body pos="0 0 {LENGTH if k else 0}"><joint axis="{axis}"/>'
            f'<inertial pos="0 0 {CENTRE}" mass="{link.mass!r}" diaginertia="{inertia}"/>\n'
            f"{text}</body>"
        )
    return f"""<mujoco>
<option gravity="0 0 -{GRAVITY}"><flag constraint="disable" contact="disable"/></option>
<worldbody>{text}</worldbody>
</mujoco>
"""
