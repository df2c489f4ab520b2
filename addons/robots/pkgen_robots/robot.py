"""A robot of links and joints, from any file format, and its text as a .lag file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import count

from pkgen import limits
from pkgen.front.words import C_HEADERS, reserved, symbols_of

from .turns import Matrix, Turns, Vector, crossed, inner, right_angles, seen_from
from .xml import Element

TAKEN = ("g", "ground", "O", "energy", "T", "V", "L")
# Kinds of joints with additional coordinates, whose names are the joint's name and these suffixes.
SUFFIXES = {"free": ("_x", "_y", "_z"), "planar": ("_1", "_2")}


@dataclass
class Link:
    name: str
    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)
    inertia: Matrix | None = None  # about the centre of mass, along the link's axes
    meshes: list[str] = field(default_factory=list)


@dataclass
class Mimic:
    """The rule that the coordinate of a joint equals `factor` times the coordinate of the joint
    `of`, plus `offset`."""

    element: Element
    of: str
    factor: float
    offset: float


@dataclass
class Joint:
    name: str
    kind: str  # One of the KINDS of front/joints.py.
    parent: str  # name of the parent link; "" is the ground
    child: str
    at: Vector
    turn: Turns
    axis: Vector | None
    says: str = ""
    damping: float = 0.0
    # Inertia of the joint's rotor; it adds armature/2 rate^2 to the kinetic energy.
    armature: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0  # coordinate at which the joint's spring is relaxed
    # Least and greatest value of the coordinate, in rad or m.
    limits: tuple[float, float] | None = None
    mimic: Mimic | None = None
    zero: float = 0.0  # coordinate of the joint in the posture that the robot file describes
    pose: tuple[Vector, Turns] = ((), ())  # For a free joint: initial position, initial rotation.

    @property
    def start(self) -> float:
        """Returns the initial value of the coordinate: `zero` if it is within the limits, otherwise
        the middle of the limits."""
        low, high = self.limits or (self.zero, self.zero)
        return self.zero if low <= self.zero <= high else (low + high) / 2


@dataclass
class Robot:
    name: str
    links: list[Link]
    joints: list[Joint]  # parents precede children
    gravity: Vector = (0.0, 0.0, -9.81)
    left_out: dict[str, int] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)

    def inertia(self, link: Link, own: Matrix, turn: Turns, at: Element) -> None:
        """Sets the inertia of a link from the tensor `own`, whose axes are those of the link
        rotated by `turn`. Raises an error if a moment is negative; if only a principal moment is
        negative, adds a note."""
        if any(own[k][k] < 0 for k in range(3)):
            raise at.wrong(f"the inertia of '{link.name}' has a negative moment")
        if not _is_inertia(own):
            self.doubts.append(f"the inertia of '{link.name}' has a negative principal moment")
        # Smaller products of inertia are round-off.
        tiny = 1e-16 * max(own[k][k] for k in range(3))
        tensor = seen_from(turn, own)
        link.inertia = tuple(tuple(x if abs(x) > tiny else 0.0 for x in row) for row in tensor)

    def notes(self) -> list[str]:
        """Returns notes for the user on omitted and doubtful features."""
        left = [f"{what} ({count})" for what, count in self.left_out.items()]
        return (["left out: " + ", ".join(left)] if left else []) + self.doubts

    def leave_out(self, what: str, times: int = 1) -> None:
        self.left_out[what] = self.left_out.get(what, 0) + times


class Names:
    """Makes unique names, valid in .lag files, from the names in a robot file."""

    def __init__(self) -> None:
        self.taken = set(TAKEN)
        self.numbers: dict[str, count[int]] = {}  # next numeric suffix of each name

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
    """Returns the text of a .lag file, which compiles."""
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
    terms, starts, called = [], [], {}
    for joint in robot.joints:
        name = names.new(joint.name, _suffixes(joint), "joint")
        lines.append(_joint(joint, name, bodies))
        terms += _terms(joint, name)
        called[joint.name] = name, joint
    rows = []
    for name, joint in called.values():
        start, why = joint.start, "as drawn" if joint.start == joint.zero else "between its limits"
        if joint.mimic and joint.kind != "fixed":
            start, why = _mimicked(joint, called), "as it mimics"
            rows.append(_row(name, joint, called, names))
        if start:
            unit = " [m]" * (joint.kind == "prismatic")
            starts.append(f"start {name} = {start!r}{unit}  # {why}")
        starts += _pose(joint, name)
    more = [*terms, *rows, *starts]
    return "\n".join([*lines, *([""] if more else []), *more]) + "\n"


Called = dict[str, tuple[str, Joint]]


def _mimicked(joint: Joint, called: Called) -> float:
    """Returns the initial value of a joint that mimics another joint, computed from the other
    joint's initial value. Raises ModelError."""
    factor, offset, seen = 1.0, 0.0, {joint.name}
    while joint.mimic and joint.kind != "fixed":
        mimic = joint.mimic
        if mimic.of not in called:
            raise mimic.element.wrong(f"there is no joint '{mimic.of}'")
        joint = called[mimic.of][1]
        if joint.kind not in ("revolute", "prismatic", "fixed"):
            help = "one that turns about an axis or slides along one"
            raise mimic.element.wrong(f"a {joint.kind} joint cannot be mimicked", help)
        if joint.name in seen:
            raise mimic.element.wrong(f"the mimics go round in a circle at '{joint.name}'")
        seen.add(joint.name)
        factor, offset = factor * mimic.factor, factor * mimic.offset + offset
    return factor * joint.start + offset


def _row(name: str, joint: Joint, called: Called, names: Names) -> str:
    """Returns the constraint statement by which the coordinate `name` of a joint mimics another
    joint. A fixed joint counts as one whose coordinate is 0."""
    other, leader = called[joint.mimic.of]
    slides = joint.kind == "prismatic"
    unit = {(True, "revolute"): " [m]", (False, "prismatic"): " [1/m]"}.get((slides, leader.kind))
    product = f"({joint.mimic.factor!r}{unit or ''})*{other}" if leader.kind != "fixed" else ""
    offset = f"({joint.mimic.offset!r}{' [m]' * slides})" if joint.mimic.offset else ""
    right = " + ".join(filter(None, (product, offset))) or "0"
    return f"constraint {names.new(joint.name, (), 'mimic')}: {name} = {right}"


def _terms(joint: Joint, name: str) -> list[str]:
    """Returns statements for armature, spring and damping: energies and dissipation."""
    turns, slides = f"{name}'^2", f"{name}'^2"
    if joint.axis is None:
        turns = f"dot(omega({name}), omega({name}))"
        slides = f"({name}_x'^2 + {name}_y'^2 + {name}_z'^2)"
    rates = [(turns, "kg*m^2", "N*m*s")] * (joint.kind in ("revolute", "spherical", "free"))
    rates += [(slides, "kg", "N*s/m")] * (joint.kind in ("prismatic", "free"))
    lines = []
    for square, inertia, damping in rates:
        if joint.armature:
            lines.append(f"kinetic ({joint.armature!r} [{inertia}])/2*{square}")
        if joint.damping:
            lines.append(f"dissipation ({joint.damping!r} [{damping}])/2*{square}")
    if joint.stiffness:
        unit, length = ("N/m", " [m]") if joint.kind == "prismatic" else ("N*m", "")
        way = f"({name} - ({joint.rest!r}{length}))" if joint.rest else name
        lines.append(f"potential ({joint.stiffness!r} [{unit}])/2*{way}^2")
    return lines


def _pose(joint: Joint, name: str) -> list[str]:
    """Returns the `start` statement of a free joint, if any."""
    at, turns = joint.pose
    starts = [f"{name}_{axis} = {x!r} [m]" for axis, x in zip("xyz", at, strict=False) if x]
    starts += [f"{name} = {_turned(turns)}"] if turns else []
    return [f"start {', '.join(starts)}  # as drawn"] if starts and joint.kind == "free" else []


def _suffixes(joint: Joint) -> tuple[str, ...]:
    """Returns the suffixes of the additional names of a joint."""
    return SUFFIXES.get(joint.kind, ()) + ("_lower", "_upper") * bool(joint.limits)


def _hold_massless(robot: Robot) -> None:
    """Fixes joints that move no mass, and so have no equation of motion; adds a note."""
    links = {link.name: link for link in robot.links}
    heavy = {name for name, link in links.items() if link.mass or any(map(any, link.inertia or ()))}
    for joint in reversed(robot.joints):
        if joint.child in heavy:
            heavy.add(joint.parent)
        elif joint.kind != "fixed":
            joint.kind, joint.axis, joint.limits = "fixed", None, None
            joint.damping = joint.armature = joint.stiffness = joint.zero = 0.0
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
    if joint.turn:
        parts.append(f"turned {_turned(joint.turn)}")
    if joint.limits:
        low, high = (_angle(x) if joint.kind == "revolute" else repr(x) for x in joint.limits)
        parts.append(f"limits [{low}, {high}]" + " [m]" * (joint.kind == "prismatic"))
    return "  ".join(parts) + (f"  # {joint.says}" if joint.says else "")


def _turned(turns: Turns) -> str:
    return "*".join(f"rot({_vector(axis)}, {_angle(angle)})" for axis, angle in turns)


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
    """Whether no principal moment of inertia is negative, up to rounding."""
    tiny = 1e-9 * max(i[k][k] for k in range(3))
    minors = (i[a][a] * i[b][b] - i[a][b] ** 2 for a, b in ((0, 1), (0, 2), (1, 2)))
    determinant = inner(i[0], crossed(i[1], i[2]))
    return (
        all(i[k][k] >= 0 for k in range(3))
        and all(m >= -(tiny**2) for m in minors)
        and determinant >= -(tiny**3) * 1e9
    )
