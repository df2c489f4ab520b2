"""URDF: links, joints, inertias, origins, limits, joints that follow others. Meshes are named; all
else is left out, and said to be. Reference: wiki.ros.org/urdf/XML."""

from __future__ import annotations

from .robot import Joint, Link, Robot
from .turns import of_roll_pitch_yaw
from .xml import ANGLE, Element

KINDS = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
}
ZERO = (0.0, 0.0, 0.0)
DRAWN = ("visual", "collision")  # of these the meshes are named


def robot(root: Element, base: str) -> Robot:
    """`base` is the kind of the joint that the root link hangs on the ground by."""
    links = {}
    found = Robot(root.attributes.get("name", ""), [], [])
    for element in root.children:
        if element.tag not in ("link", "joint", "material"):
            if ":" in element.tag:
                raise element.wrong(f"<{element.tag}> is xacro", "run xacro first")
            found.leave_out(f"<{element.tag}>")
        if element.tag == "link":
            name = element.text("name")
            if name in links:
                raise element.wrong(f"there are two links '{name}'")
            links[name] = element
            found.links.append(_link(element, name, found))
    hung: dict[str, Joint] = {}
    names: set[str] = set()
    for element in root.all("joint"):
        joint = _joint(element, found, links)
        if joint.child in hung:
            other = hung[joint.child].name
            message = f"the link '{joint.child}' hangs on the joint '{other}' already"
            raise element.wrong(message, "close the loop by a 'constraint' in the .lag file")
        if joint.name in names:
            raise element.wrong(f"there are two joints '{joint.name}'")
        names.add(joint.name)
        hung[joint.child] = joint
    _check_followed(root, hung)
    roots = [name for name in links if name not in hung]
    if not links:
        raise root.wrong("the robot has no link")
    if len(roots) > 1:
        message = f"{len(roots)} links hang on no joint: {', '.join(roots[:5])}"
        raise links[roots[1]].wrong(message, "a robot has one root")
    children: dict[str, list[Joint]] = {}
    for joint in hung.values():
        children.setdefault(joint.parent, []).append(joint)
    waiting = [Joint("base", base, "", name, ZERO, (), None) for name in roots]
    while waiting:
        joint = waiting.pop()
        found.joints.append(joint)
        waiting += reversed(children.get(joint.child, []))
    if len(found.joints) < len(links):
        placed = {joint.child for joint in found.joints}
        left = next(name for name in links if name not in placed)
        raise links[left].wrong(f"the joints go round in a circle at the link '{left}'")
    for element in (*root.all("link"), *root.all("joint")):
        for what in element.unread(DRAWN):
            found.leave_out(what)
    return found


def _check_followed(root: Element, hung: dict[str, Joint]) -> None:
    joints = {joint.name: joint for joint in hung.values()}
    for element in root.all("joint"):
        joint, seen = joints[element.text("name")], set()
        while joint.follows:
            seen.add(joint.name)
            other = joint.follows[0]
            if other not in joints:
                raise element.wrong(f"there is no joint '{other}' to mimic")
            if other in seen:
                raise element.wrong(f"the joint '{other}' mimics itself")
            joint = joints[other]


def _link(element: Element, name: str, robot: Robot) -> Link:
    link = Link(name)
    for shape in [shape for tag in DRAWN for shape in element.all(tag)]:
        geometry = shape.first("geometry")
        mesh = geometry.first("mesh") if geometry else None
        file = mesh.attributes.get("filename", "") if mesh else ""
        if file and file not in link.meshes:
            link.meshes.append(file)
    inertial = element.first("inertial")
    if inertial is None:
        return link
    mass, tensor = inertial.first("mass"), inertial.first("inertia")
    if mass is None:
        raise inertial.wrong(f"the link '{name}' has no mass")
    link.mass = mass.number("value")
    if link.mass < 0:
        raise mass.wrong(f"the mass of '{name}' is negative")
    link.com, turn = _origin(inertial)
    if tensor is not None:
        xx, yy, zz = (tensor.number(key) for key in ("ixx", "iyy", "izz"))
        xy, xz, yz = (tensor.number(key, 0.0) for key in ("ixy", "ixz", "iyz"))
        own = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
        robot.inertia(link, own, turn, tensor)
    return link


def _origin(element: Element):
    origin = element.first("origin")
    if origin is None:
        return ZERO, ()
    return origin.numbers("xyz", 3, ZERO), of_roll_pitch_yaw(origin.numbers("rpy", 3, ZERO, ANGLE))


def _joint(element: Element, robot: Robot, links: dict[str, Element]) -> Joint:
    name, given = element.text("name"), element.text("type")
    if given not in KINDS:
        raise element.wrong(f"there is no joint type '{given}'", f"types: {', '.join(KINDS)}")
    kind, ends = KINDS[given], []
    for end in ("parent", "child"):
        part = element.first(end)
        if part is None:
            raise element.wrong(f"the joint '{name}' has no <{end}>")
        link = part.text("link")
        if link not in links:
            raise part.wrong(f"there is no link '{link}'")
        ends.append(link)
    axis = None
    if kind in ("revolute", "prismatic", "planar"):
        part = element.first("axis")
        axis = part.numbers("xyz", 3, (1.0, 0.0, 0.0)) if part else (1.0, 0.0, 0.0)
        if not any(axis):
            raise part.wrong(f"the axis of the joint '{name}' is the zero vector")
    joint = Joint(name, kind, *ends, *_origin(element), axis)
    limit, dynamics = element.first("limit"), element.first("dynamics")
    mimic = element.first("mimic")
    if mimic is not None and kind in ("revolute", "prismatic"):
        by = mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)
        joint.follows = (mimic.text("joint"), *by)
    elif mimic is not None:
        robot.leave_out(f"<mimic> of a {kind} joint")
    if limit is not None:
        shown = [
            f"{w} {limit.number(w)!r}" for w in ("effort", "velocity") if w in limit.attributes
        ]
        joint.says = "limits: " + ", ".join(shown) if shown else ""
        if given in ("revolute", "prismatic"):
            low, high = (limit.number(word, 0.0) for word in ("lower", "upper"))
            joint.limits = (low, high) if low < high else None
            if low > high or (not joint.limits and {"lower", "upper"} & {*limit.attributes}):
                robot.doubts.append(f"limits of '{name}' left out: {low!r} is not below {high!r}")
    if dynamics is not None and axis is not None and kind != "planar":
        joint.damping = dynamics.number("damping", 0.0)
        if joint.damping < 0:
            raise dynamics.wrong(f"the damping of '{name}' is negative")
    elif dynamics is not None and dynamics.number("damping", 0.0):
        robot.leave_out(f"damping of a {kind} joint")
    if dynamics is not None and dynamics.number("friction", 0.0):
        robot.leave_out("friction of a joint")
    return joint
