"""Reads a subset of MJCF: bodies with <inertial>, their joints, positions and rotations. Unread
elements that would change the motion are refused; sensors, actuators and geoms are left out with a
note. Reference: mujoco.readthedocs.io, XML reference."""

from __future__ import annotations

import math

from .robot import Joint, Link, Robot
from .turns import UNIT, Turns, Vector, added, applied, matrix, of_angles, of_quaternion
from .xml import ANGLE, Element

KINDS = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "free"}
ZERO = (0.0, 0.0, 0.0)
SEEN = ("worldbody", "compiler", "option", "default", "asset", "visual", "size", "statistic")
# Read elements in <worldbody> and bodies, and those that have no effect without contacts.
IN_BODIES = ("body", "joint", "freejoint", "inertial", "geom", "site", "camera", "light")
NOT_READ = {  # unread attributes that would change the motion
    "compiler": ("settotalmass", "boundmass", "boundinertia", "inertiafromgeom"),
    "option": ("density", "viscosity", "wind"),
    "flag": ("gravity", "passive"),
    "body": ("gravcomp", "mocap"),
}
REFUSED = ("equality", "tendon", "include", "extension", "deformable")
# Attributes of a joint that change its motion and are not read: an error if they are not 0.
SPRINGS = ("stiffness", "armature", "frictionloss", "springdamper", "springref", "ref")


class _Reader:
    def __init__(self, root: Element):
        self.robot = Robot(root.attributes.get("model", ""), [], [])
        compiler = root.first("compiler")
        given = compiler.attributes if compiler else {}
        self.angle = 1.0 if given.get("angle", "degree") == "radian" else math.pi / 180
        self.auto_limits = given.get("autolimits", "true") != "false"
        self.sequence = given.get("eulerseq", "xyz")
        if len(self.sequence) != 3 or any(c not in "xyz" for c in self.sequence):
            raise compiler.wrong(f'eulerseq="{self.sequence[:10]}" is not read', "e.g. xyz")
        if given.get("coordinate", "local") != "local":
            raise compiler.wrong("global coordinates are not read", 'coordinate="local"')
        option = root.first("option")
        if option is not None:
            self.robot.gravity = option.numbers("gravity", 3, self.robot.gravity)
        self.names: set[tuple[str, str]] = set()

    def placed(self, element: Element) -> tuple[Vector, Turns]:
        ways = [w for w in ("quat", "euler", "axisangle", "xyaxes", "zaxis") if
                w in element.attributes]  # fmt: skip
        at = element.numbers("pos", 3, ZERO)
        turn: Turns | None = ()
        if ways == ["quat"]:
            turn = of_quaternion(element.numbers("quat", 4))
        elif ways == ["euler"]:
            angles = [angle * self.angle for angle in element.numbers("euler", 3, (), ANGLE)]
            turn = of_angles([UNIT["xyz".index(letter)] for letter in self.sequence], angles)
        elif ways == ["axisangle"]:
            *axis, angle = element.numbers("axisangle", 4)
            if abs(angle) > ANGLE:
                raise element.wrong(f"an angle of {angle:g} is too large")
            turn = of_angles([tuple(axis)], [angle * self.angle]) if any(axis) else None
        elif ways:
            raise element.wrong(f"'{ways[-1]}' is not read", "write a quat")
        if turn is None:
            raise element.wrong("a turn about the zero vector")
        return at, turn

    def name(self, element: Element | None, kind: str, other: str) -> str:
        """Returns the unique name of a body or a joint; `other` if it has none."""
        name = given = element.attributes.get("name", "") if element is not None else ""
        name = name or other
        while not given and (kind, name) in self.names:
            name += "_"
        if (kind, name) in self.names:
            raise element.wrong(f"there are two of the name '{name}'")
        self.names.add((kind, name))
        return name

    def body(self, element: Element, parent: str, before: Vector) -> tuple[str, Vector]:
        """Adds a body; returns its name and the position of its frame in MJCF's frame. The frame of
        a body is at its last joint; `before` is the same position of the parent."""
        if "childclass" in element.attributes:
            raise element.wrong("classes of defaults are not read", "write the values out")
        name = self.name(element, "body", f"body{len(self.robot.links) + 1}")
        at, turn = self.placed(element)
        at = added(at, before, -1.0)
        joints = [*element.all("joint"), *element.all("freejoint")]
        anchor = ZERO
        for k, joint in enumerate(joints):
            last = k == len(joints) - 1
            link = Link(name if last else self.name(None, "body", f"{name}_{k + 1}"))
            self.robot.links.append(link)
            own = self.joint(joint, f"{name}_joint" if last else f"{link.name}_joint")
            new = joint.numbers("pos", 3, ZERO) if own[0] != "free" else ZERO
            place = added(at, applied(matrix(turn), added(new, anchor, -1.0)))
            self.robot.joints.append(
                Joint(own[1], own[0], parent, link.name, place, turn, *own[2:])
            )
            parent, at, turn, anchor = link.name, ZERO, (), new
        if not joints:
            self.robot.links.append(Link(name))
            self.robot.joints.append(Joint(f"{name}_weld", "fixed", parent, name, at, turn, None))
        self.inertial(element, self.robot.links[-1], anchor)
        return name, anchor

    def joint(self, element: Element, other: str):
        """Returns its kind, name, axis, comment, damping and limits."""
        given = "free" if element.tag == "freejoint" else element.attributes.get("type", "hinge")
        if given not in KINDS:
            raise element.wrong(f"there is no joint type '{given}'", f"types: {', '.join(KINDS)}")
        if "class" in element.attributes:
            raise element.wrong("classes of defaults are not read", "write the values out")
        axis = element.numbers("axis", 3, (0.0, 0.0, 1.0)) if given in ("hinge", "slide") else None
        if axis is not None and not any(axis):
            raise element.wrong("the axis of a joint is the zero vector")
        for word in SPRINGS:
            if any(element.numbers(word, len(element.attributes.get(word, "0").split()), (0.0,))):
                raise element.wrong(
                    f"'{word}' of a joint is not read", "take it out, add it by hand"
                )
        damping = element.number("damping", 0.0)
        if damping < 0:
            raise element.wrong("the damping of a joint is negative")
        if damping and axis is None:
            raise element.wrong("the damping of a ball is not read", "add it by 'force'")
        name = self.name(element, "joint", other)
        return KINDS[given], name, axis, "", damping, self.limits(element, given, name)

    def limits(self, element: Element, given: str, name: str) -> tuple[float, float] | None:
        """Returns the limits by `limited`; its default, "auto", is whether there is a range
        (`autolimits`)."""
        low, high = element.numbers("range", 2, (0.0, 0.0))
        limited = element.attributes.get("limited", "auto")
        if limited not in ("auto", "true", "false"):
            raise element.wrong(f'limited="{limited[:10]}" is not auto, true or false')
        auto = self.auto_limits and "range" in element.attributes
        if limited == "false" or (limited == "auto" and not auto):
            return None
        if given not in ("hinge", "slide"):
            self.robot.leave_out("limits of a ball")
            return None
        if not low < high:
            raise element.wrong(
                f"the limits of '{name}' are [{low!r}, {high!r}]: none between them"
            )
        scale = self.angle if given == "hinge" else 1.0
        return low * scale, high * scale

    def inertial(self, element: Element, link: Link, anchor: Vector) -> None:
        found = element.first("inertial")
        geoms = [*element.all("geom")]
        if found is None and geoms:
            help = "write <inertial pos mass diaginertia>"
            raise element.wrong("masses are not taken from geoms: there is no <inertial>", help)
        for geom in geoms:
            mesh = geom.attributes.get("mesh")
            if mesh:
                link.meshes.append(mesh)
        if found is None:
            return
        at, turn = self.placed(found)
        link.mass, link.com = found.number("mass"), added(at, anchor, -1.0)
        if link.mass < 0:
            raise found.wrong("the mass is negative")
        if "fullinertia" in found.attributes:
            xx, yy, zz, xy, xz, yz = found.numbers("fullinertia", 6)
            own = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        else:
            x, y, z = found.numbers("diaginertia", 3, ZERO)
            own = ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
        self.robot.inertia(link, own, turn, found)


def _refuse_unread(root: Element) -> None:
    waiting = [root]
    while waiting:
        element = waiting.pop()
        for word in NOT_READ.get(element.tag, ()):
            if element.attributes.get(word, "0") not in ("0", "false", "enable"):
                raise element.wrong(
                    f"'{word}' of <{element.tag}> is not read, and would change the motion"
                )
        if element.tag in ("worldbody", "body"):
            for child in element.children:
                if child.tag not in IN_BODIES:
                    message = (
                        f"<{child.tag}> in <{element.tag}> is not read, and would change the motion"
                    )
                    raise child.wrong(message)
            if len([*element.all("inertial")]) > 1:
                raise element.wrong("a body has one <inertial>")
        waiting += element.children


def robot(root: Element, base: str) -> Robot:
    """Reads a robot. A body without joints is fixed to the world, or free if `base` is "free"."""
    for element in root.children:
        if element.tag in REFUSED:
            raise element.wrong(f"<{element.tag}> is not read, and would change the motion")
    _refuse_unread(root)
    reader = _Reader(root)
    for element in root.children:
        if element.tag not in SEEN:
            reader.robot.leave_out(f"<{element.tag}>")
    for default in root.all("default"):
        waiting = [default]
        while waiting:
            element = waiting.pop()
            if element.tag == "joint":
                raise element.wrong("defaults of joints are not read", "write the values out")
            waiting += element.children
    worlds = [*root.all("worldbody")]
    if not worlds or not any(world.first("body") for world in worlds):
        raise root.wrong("there is no body in <worldbody>")
    waiting = [(body, "", ZERO) for world in worlds for body in world.all("body")][::-1]
    while waiting:
        element, parent, before = waiting.pop()
        name, anchor = reader.body(element, parent, before)
        waiting += [(child, name, anchor) for child in element.all("body")][::-1]
    if base == "free":
        for joint in reader.robot.joints:
            if joint.kind == "fixed" and not joint.parent:
                joint.kind = "free"
    return reader.robot
