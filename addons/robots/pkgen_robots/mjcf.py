"""Reads MJCF: bodies with their masses, joints and default classes. An unread element that would
change the motion is an error; all errors in a file are reported together. Sensors, actuators and
contacts are left out with a note. Reference: mujoco.readthedocs.io, XML reference."""

from __future__ import annotations

from dataclasses import replace

from .include import spliced
from .mjcf_file import MAIN, ZERO, Defaults, Settings, check_known, leave_out_sections
from .robot import Joint, Link, Robot
from .shapes import Lump, balanced, bounded, lump, together
from .turns import Turns, Vector, added, applied, matrix, of_angles, seen_from
from .xml import ANGLE, Element, Errors

KINDS = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "free"}
SHOWN = ("site", "camera", "light")  # elements left out with a note
IN_BODIES = ("body", "joint", "freejoint", "inertial", "geom")


class _Reader:
    def __init__(self, root: Element, errors: Errors):
        self.robot = Robot(root.attributes.get("model", ""), [], [])
        self.errors = errors
        self.settings = Settings(root, errors)
        self.robot.gravity = self.settings.gravity
        self.defaults = Defaults(root)
        self.given, self.names = _names(root), set()

    def name(self, element: Element | None, kind: str, other: str) -> str:
        """Returns the unique name of a body or a joint. An unnamed element is called `other`,
        followed by as many underscores as make the name unique."""
        name = element.attributes.get("name", "") if element is not None else ""
        if not name:
            name = other
            while (kind, name) in self.names or (kind, name) in self.given:
                name += "_"
        elif (kind, name) in self.names:
            raise element.wrong(f"there are two of the name '{name}'")
        self.names.add((kind, name))
        return name

    def body(
        self, element: Element, parent: str, before: Vector, around: str
    ) -> tuple[str, Vector, str]:
        """Adds a body. Returns the name of the body, the position of its frame as MJCF defines it,
        and the default class of its children. In the model, the frame of a body is at its last
        joint; `before` is the position of the parent's frame in the parent's frame as MJCF defines
        it."""
        self.check_body(element)
        around = element.attributes.get("childclass", around)
        name = self.name(element, "body", f"body{len(self.robot.links) + 1}")
        at, turn = self.settings.placed(element)
        at = added(at, before, -1.0)
        joints = [child for child in element.children if child.tag in ("joint", "freejoint")]
        anchor = ZERO
        for k, found in enumerate(joints):
            last = k == len(joints) - 1
            link = Link(name if last else self.name(None, "body", f"{name}_{k + 1}"))
            self.robot.links.append(link)
            other = f"{name}_joint" if last else f"{link.name}_joint"
            with self.errors.collecting():
                joint = self.joint(found, other, parent, link.name, around)
                new = joint.at
                place = added(at, applied(matrix(turn), added(new, anchor, -1.0)))
                self.robot.joints.append(_placed(joint, place, turn))
                at, turn, anchor = ZERO, (), new
            parent = link.name
        if not joints:
            self.robot.links.append(Link(name))
            weld = self.name(None, "joint", f"{name}_weld")
            self.robot.joints.append(Joint(weld, "fixed", parent, name, at, turn, None))
        self.mass(element, self.robot.links[-1], anchor, around)
        return name, anchor, around

    def check_body(self, element: Element) -> None:
        with self.errors.collecting():
            check_known(element)
            if element.number("gravcomp", 0.0):
                raise element.wrong("'gravcomp' of <body> is not read, and would change the motion")
            if element.flag("mocap"):
                self.robot.leave_out("motions of a mocap <body>")
            if len([*element.all("inertial")]) > 1:
                raise element.wrong("a body has one <inertial>")

    def joint(self, found: Element, other: str, parent: str, child: str, around: str) -> Joint:
        """Returns a joint, with its position in MJCF's frame of the body."""
        free = found.tag == "freejoint"
        element = found if free else self.defaults.of(found, around)
        check_known(element)
        given = "free" if free else element.attributes.get("type", "hinge")
        if given not in KINDS:
            raise element.wrong(f"there is no joint type '{given}'", f"types: {', '.join(KINDS)}")
        if element.attributes.get("align", "false") == "true":
            raise element.wrong("'align' moves the frame of a free body, and is not read")
        if any(element.numbers("springdamper", 0, (0.0,))):
            help = "write stiffness and damping, as jnt_stiffness and dof_damping of MuJoCo's model"
            raise element.wrong("'springdamper' of a joint is not read", help)
        scale = self.settings.angle if given == "hinge" else 1.0
        axis = element.numbers("axis", 3, (0.0, 0.0, 1.0)) if given in ("hinge", "slide") else None
        if axis is not None and not any(axis):
            raise element.wrong("the axis of a joint is the zero vector")
        at = element.numbers("pos", 3, ZERO) if given != "free" else ZERO
        name = self.name(element, "joint", other)
        joint = Joint(name, KINDS[given], parent, child, at, (), axis)
        joint.zero = scale * element.numbers("ref", 1, (0.0,), ANGLE)[0] if axis else 0.0
        self.passive(element, joint, scale)
        joint.limits = self.limits(element, given, joint.name)
        return joint

    def passive(self, element: Element, joint: Joint, scale: float) -> None:
        """Sets armature, damping and spring of a joint. `scale` is the file's unit of angles in
        radians, for the rest position of the spring."""
        joint.armature = _positive(element, "armature")
        if self.settings.on("passive", "damper"):
            joint.damping = _positive(element, "damping")
        if self.settings.on("passive", "spring"):
            joint.stiffness = _positive(element, "stiffness")
            joint.rest = scale * element.numbers("springref", 1, (0.0,), ANGLE)[0]
        if joint.stiffness and joint.axis is None:
            message = f"'stiffness' of a {element.attributes['type']} joint is not read"
            raise element.wrong(message, "take it out")
        if element.number("frictionloss", 0.0) and self.settings.on("frictionloss", "constraint"):
            self.robot.leave_out("frictionloss of a joint")

    def limits(self, element: Element, given: str, name: str) -> tuple[float, float] | None:
        """Returns the limits, or None if `limited` excludes them. "auto", the default, means that
        they apply if there is a range and `autolimits`."""
        low, high = element.numbers("range", 2, (0.0, 0.0))
        limited = element.attributes.get("limited", "auto")
        if limited not in ("auto", "true", "false"):
            raise element.wrong(f'limited="{limited[:10]}" is not auto, true or false')
        auto = self.settings.auto_limits and (low or high)
        if limited == "false" or (limited == "auto" and not auto):
            return None
        if not self.settings.on("limit", "constraint"):
            return None
        if given not in ("hinge", "slide"):
            self.robot.leave_out("limits of a ball")
            return None
        if not low < high:
            raise element.wrong(
                f"the limits of '{name}' are [{low!r}, {high!r}]: none between them"
            )
        scale = self.settings.angle if given == "hinge" else 1.0
        return low * scale, high * scale

    def mass(self, element: Element, link: Link, anchor: Vector, around: str) -> None:
        """Sets mass, centre and inertia, from <inertial> or from geoms (`inertiafromgeom`)."""
        settings, found, lumps = self.settings, element.first("inertial"), []
        by_geoms = settings.from_geoms == "true" or (
            settings.from_geoms == "auto" and found is None
        )
        for geom in element.all("geom"):
            with self.errors.collecting():
                part = self.geom(geom, around, link, by_geoms)
                lumps += [part] if part else []
        with self.errors.collecting():
            least = settings.least_mass or settings.least_moment
            # If a body has no mass but that of `boundmass`, MuJoCo takes the attribute `pos` as the
            # position of the mass in the body's frame.
            at = element.numbers("pos", 3, ZERO) if least else ZERO
            whole = Lump(0.0, at, (ZERO,) * 3)
            if lumps:
                whole = together(lumps)
            elif found is not None:
                whole = self.inertial(found, link)
            if least:
                whole = bounded(whole, settings.least_mass, settings.least_moment)
            whole = balanced(whole) if settings.balance else whole
            link.mass, link.com = whole.mass, added(whole.com, anchor, -1.0)
            self.robot.inertia(link, whole.inertia, (), element)

    def geom(self, geom: Element, around: str, link: Link | None, by_geoms: bool) -> Lump | None:
        """Returns the mass of a geom, or None if the body's mass is not computed from geoms. Notes
        that contacts and meshes are left out."""
        own = self.defaults.of(geom, around)
        check_known(own)
        if self.settings.on("contact", "constraint") and any(
            own.number(word, 1.0) for word in ("contype", "conaffinity")
        ):
            self.robot.leave_out("contacts of <geom>")
        if link is None:
            return None
        if "mesh" in own.attributes:
            link.meshes.append(own.attributes["mesh"])
        low, high = self.settings.groups
        if not by_geoms or not low <= own.number("group", 0.0) <= high:
            return None
        return lump(own, *self.settings.placed(own))

    def inertial(self, found: Element, link: Link) -> Lump:
        check_known(found)
        at, turn = self.settings.placed(found)
        mass = found.number("mass")
        if mass < 0:
            raise found.wrong("the mass is negative")
        if "fullinertia" in found.attributes:
            xx, yy, zz, xy, xz, yz = found.numbers("fullinertia", 6)
            own = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        else:
            x, y, z = found.numbers("diaginertia", 3, ZERO)
            own = ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
        return Lump(mass, at, seen_from(turn, own))

    def children(self, element: Element) -> None:
        """Notes sites, cameras and lights; adds an error for each other unread element."""
        for child in element.children:
            if child.tag in SHOWN:
                self.robot.leave_out(f"<{child.tag}>")
            elif child.tag not in IN_BODIES:
                message = (
                    f"<{child.tag}> in <{element.tag}> is not read, and would change the motion"
                )
                self.errors.add(child.wrong(message))

    def scale(self) -> None:
        """Scales masses and inertias to the total mass `settotalmass`."""
        whole = sum(link.mass for link in self.robot.links)
        if self.settings.total <= 0 or not whole:
            return
        factor = self.settings.total / whole
        for link in self.robot.links:
            link.mass *= factor
            link.inertia = tuple(tuple(factor * x for x in row) for row in link.inertia or ())


def _names(root: Element) -> set[tuple[str, str]]:
    """Returns the names of all bodies and joints, with their kinds."""
    names, waiting = set(), [*root.all("worldbody")]
    while waiting:
        element = waiting.pop()
        waiting += element.children
        kind = "joint" if element.tag == "freejoint" else element.tag
        names.add((kind, element.attributes.get("name", "")))
    return names


def _placed(joint: Joint, at: Vector, turn: Turns) -> Joint:
    """Places a joint so that its coordinates equal those in MuJoCo. The coordinates of a free joint
    are its position in space. The attribute `ref` of another joint is the value of its coordinate
    in the posture of the file."""
    if joint.kind == "free":
        return replace(joint, pose=(at, turn))
    if joint.zero and joint.kind == "revolute":
        turn = (*turn, *of_angles([joint.axis], [-joint.zero]))
    elif joint.zero:
        size = sum(x * x for x in joint.axis) ** 0.5
        way = tuple(-joint.zero * x / size for x in joint.axis)
        at = added(at, applied(matrix(turn), way))
    return replace(joint, at=at, turn=turn)


def _positive(element: Element, word: str) -> float:
    """Returns a coefficient of a joint, which must not be negative. Raises ModelError."""
    first, *higher = element.numbers(word, 0, (0.0,))
    if any(higher):
        raise element.wrong(f"'{word}' of a joint that is a polynomial is not read")
    if first < 0:
        raise element.wrong(f"the {word} of a joint is negative")
    return first


def robot(root: Element, base: str) -> Robot:
    """Reads a robot. A body without joints is fixed to the world, or free if `base` is "free"."""
    errors = Errors()
    spliced(root, errors)
    reader = _Reader(root, errors)
    leave_out_sections(root, reader.robot, reader.settings, reader.defaults, errors)
    worlds = [*root.all("worldbody")]
    if not any(world.first("body") for world in worlds):
        errors.add(root.wrong("there is no body in <worldbody>"))
    waiting = []
    for world in worlds:
        reader.children(world)
        for geom in world.all("geom"):
            with errors.collecting():
                reader.geom(geom, MAIN, None, False)
        waiting += [(body, "", ZERO, MAIN) for body in world.all("body")]
    waiting.reverse()
    while waiting:
        element, *around = waiting.pop()
        reader.children(element)
        with errors.collecting():
            inside = reader.body(element, *around)
            waiting += [(child, *inside) for child in element.all("body")][::-1]
    errors.stop(root.source)
    reader.scale()
    if base == "free":
        for joint in reader.robot.joints:
            if joint.kind == "fixed" and not joint.parent:
                joint.kind = "free"
    return reader.robot
