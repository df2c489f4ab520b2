"""A robot of links and joints, whatever it was written in, as text of the language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import count

from .. import limits
from ..front.words import C_HEADERS, reserved, symbols_of
from .turns import Matrix, Turns, Vector, inner, right_angles, seen_from
from .xml import Element

TAKEN = ("g", "ground", "O", "energy", "T", "V", "L")
UNITS = {"revolute": "rad", "prismatic": "m"}
# Names that a joint's coordinates take besides its own, by its kind.
SUFFIXES = {"free": ("_x", "_y", "_z"), "planar": ("_1", "_2")}


@dataclass
class Link:
    name: str
    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)
    inertia: Matrix | None = None  # about the centre of mass, along the link's axes
    meshes: list[str] = field(default_factory=list)


@dataclass
class Joint:
    name: str
    kind: str  # a key of front/joints.py KINDS
    parent: str  # "": the ground
    child: str
    at: Vector
    turn: Turns
    axis: Vector | None
    says: str = ""
    damping: float = 0.0
    limits: tuple[float, float] | None = None  # [rad] or [m]
    follows: tuple[str, float, float] | None = None  # it is x times this joint's place, plus y


@dataclass
class Robot:
    name: str
    links: list[Link]
    joints: list[Joint]  # a parent's before its children's
    gravity: Vector = (0.0, 0.0, -9.81)
    left_out: dict[str, int] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)

    def inertia(self, link: Link, own: Matrix, turn: Turns, at: Element) -> None:
        """The tensor of a link, in axes of its own. One that no rigid body has is kept and said."""
        if any(own[k][k] < 0 for k in range(3)):
            raise at.wrong(f"the inertia of '{link.name}' has a negative moment")
        if not _is_inertia(own):
            self.doubts.append(f"the inertia of '{link.name}' has a negative principal moment")
        link.inertia = seen_from(turn, own)

    def notes(self) -> list[str]:
        """For people: what was not taken along, and what is doubtful."""
        left = [f"{what} ({count})" for what, count in self.left_out.items()]
        return (["left out: " + ", ".join(left)] if left else []) + self.doubts

    def leave_out(self, what: str) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + 1


class Names:
    """Names of the language for those of a robot, each once."""

    def __init__(self) -> None:
        self.taken = set(TAKEN)
        self.numbers: dict[str, count[int]] = {}  # the next one behind a name that is taken

    def new(self, name: str, suffixes: Iterable[str] = (), other: str = "") -> str:
        base = re.sub(r"\W", "_", name, flags=re.ASCII)[: limits.NAME_LENGTH - 12] or "link"
        base = base if base[0].isalpha() and not base.startswith("p_") else f"x_{base}"
        form = base
        while True:
            all_ = {form, *(form + suffix for suffix in suffixes)}
            if not reserved(form) and not all_ & self.taken:
                self.taken |= all_
                return form
            form = f"{base}_{other or next(self.numbers.setdefault(base, count(2)))}"
            other = ""


def text(robot: Robot, file: str) -> str:
    """A .lag file that compiles."""
    _hold_massless(robot)
    names, model = Names(), re.sub(r"\W", "_", robot.name, flags=re.ASCII) or "robot"
    if not model[0].isalpha() or reserved(model) or symbols_of(model) or model in C_HEADERS:
        model = f"robot_{model}"
    bodies = {link.name: names.new(link.name) for link in robot.links}
    lines = [f"model {model[: limits.NAME_LENGTH - 12]}  # from {re.sub('[^ -~]', '?', file)}"]
    lines += [f"# {re.sub('[^ -~]', '?', note)}" for note in robot.notes()]
    lines += ["", f"gravity {_vector(robot.gravity)} [m/s^2]", ""]
    lines += [_body(link, bodies[link.name]) for link in robot.links]
    lines.append("")
    damped, starts, tied = [], [], []
    given = {j.name: names.new(j.name, _suffixes(j), "joint") for j in robot.joints}
    start = {j.name: sum(j.limits) / 2 if _apart_from_zero(j) else 0.0 for j in robot.joints}
    by_name = {joint.name: joint for joint in robot.joints}
    for joint in robot.joints:
        name = given[joint.name]
        lines.append(_joint(joint, name, bodies))
        if joint.damping:
            unit = "N*m*s" if joint.kind == "revolute" else "N*s/m"
            damped.append(f"dissipation ({joint.damping!r} [{unit}])/2*{name}'^2")
        if joint.follows:
            other, factor, offset = joint.follows
            of, unit = by_name[other], UNITS.get(joint.kind, "rad")
            terms = [f"({offset!r} [{unit}])"] if offset or of.kind == "fixed" else []
            if of.kind != "fixed":
                per = f" [{unit}/{UNITS[of.kind]}]" * (of.kind != joint.kind)
                terms.append(f"({factor!r}{per})*{given[other]}")
            tied.append(f"constraint {names.new(f'mimic_{name}')}: {name} = {' + '.join(terms)}")
            start[joint.name] = _followed(joint, by_name, start)
        if start[joint.name]:
            unit = " [m]" * (joint.kind == "prismatic")
            why = "as it follows another" if joint.follows else "between its limits"
            starts.append(f"start {name} = {start[joint.name]!r}{unit}  # {why}")
    more = [*tied, *damped, *starts]
    return "\n".join([*lines, *[""] * bool(more), *more]) + "\n"


def _apart_from_zero(joint: Joint) -> bool:
    low, high = joint.limits or (0.0, 0.0)
    return low > 0 or high < 0


def _followed(joint: Joint, joints: dict[str, Joint], start: dict[str, float]) -> float:
    """Where a joint starts that follows others."""
    if not joint.follows:
        return start[joint.name] if joint.kind != "fixed" else 0.0
    other, factor, offset = joint.follows
    return factor * _followed(joints[other], joints, start) + offset


def _suffixes(joint: Joint) -> tuple[str, ...]:
    """Of the names that the joint makes."""
    return SUFFIXES.get(joint.kind, ()) + ("_lower", "_upper") * bool(joint.limits)


def _hold_massless(robot: Robot) -> None:
    """Joints beyond which there is no mass have no equation of motion: fixed, and said to be."""
    links = {link.name: link for link in robot.links}
    heavy = {name for name, link in links.items() if link.mass or any(map(any, link.inertia or ()))}
    for joint in reversed(robot.joints):
        if joint.child in heavy:
            heavy.add(joint.parent)
        elif joint.kind != "fixed":
            joint.kind, joint.axis, joint.damping, joint.limits = "fixed", None, 0.0, None
            joint.follows = None
            robot.leave_out("joints that carry no mass: fixed")


def _body(link: Link, name: str) -> str:
    parts = [f"body {name} mass {link.mass!r}" + (" [kg]" if link.mass else "")]
    i = link.inertia
    if i is not None and any(map(any, i)):
        elements = [i[k][k] for k in range(3)]
        across = [i[0][1], i[0][2], i[1][2]]
        parts.append(f"inertia {_vector(elements + across * any(across))} [kg*m^2]")
    if any(link.com):
        parts.append(f"at {_vector(link.com)} [m]")
    seen = ", ".join(re.sub("[^ -~]", "?", mesh)[:60] for mesh in link.meshes[:2])
    return "  ".join(parts) + (f"  # mesh {seen}" if seen else "")


def _joint(joint: Joint, name: str, bodies: dict[str, str]) -> str:
    parent = bodies[joint.parent] if joint.parent else "ground"
    parts = [f"joint {name}: {parent} to {bodies[joint.child]}  {joint.kind}"]
    if joint.axis is not None:
        parts[0] += f" {_vector(joint.axis)}"
    if any(joint.at):
        parts.append(f"at {_vector(joint.at)} [m]")
    turns = [f"rot({_vector(axis)}, {_angle(angle)})" for axis, angle in joint.turn]
    if turns:
        parts.append(f"turned {'*'.join(turns)}")
    if joint.limits:
        low, high = (_angle(x) if joint.kind == "revolute" else repr(x) for x in joint.limits)
        parts.append(f"limits [{low}, {high}]" + " [m]" * (joint.kind == "prismatic"))
    return "  ".join(parts) + (f"  # {joint.says}" if joint.says else "")


def _angle(angle: float) -> str:
    right = right_angles(angle)
    if right is None:
        return repr(angle)
    return {0: "0", 1: "pi/2", -1: "-pi/2", 2: "pi", -2: "-pi"}.get(right, f"{right}*pi/2")


def _vector(v: Sequence[float]) -> str:
    return (
        "[" + ", ".join(f"{int(x)}" if x == int(x) and abs(x) < 1e6 else repr(x) for x in v) + "]"
    )


def _is_inertia(i: Matrix) -> bool:
    """Whether a rigid body may have it, but for rounding: no principal moment is negative."""
    tiny = 1e-9 * max(i[k][k] for k in range(3))
    minors = (i[a][a] * i[b][b] - i[a][b] ** 2 for a, b in ((0, 1), (0, 2), (1, 2)))
    determinant = inner(i[0], _crossed(i[1], i[2]))
    return (
        all(i[k][k] >= 0 for k in range(3))
        and all(m >= -(tiny**2) for m in minors)
        and determinant >= -(tiny**3) * 1e9
    )


def _crossed(a: Vector, b: Vector) -> Vector:
    return tuple(a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3))
