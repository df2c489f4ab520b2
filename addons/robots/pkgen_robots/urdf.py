"""Reads URDF: links, joints, inertias, origins, limits, mimics. The names of meshes are kept;
transmissions, sensors and other elements are left out with a note. Reference:
wiki.ros.org/urdf/XML."""

from __future__ import annotations

from .robot import Joint, Link, Mimic, Robot
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
# Attributes and child elements that are read or only affect the appearance; * marks repeatable
# elements.
READ = {
    "robot": ("name version", "link* joint* material*"),
    "link": ("name", "inertial visual* collision*"),
    "inertial": ("", "origin mass inertia"),
    "mass": ("value", ""),
    "inertia": ("ixx iyy izz ixy ixz iyz", ""),
    "origin": ("xyz rpy", ""),
    **dict.fromkeys(("visual", "collision"), ("name", "origin geometry material")),
    "geometry": ("", "mesh box cylinder sphere capsule"),
    "mesh": ("filename scale", ""),
    "box": ("size", ""),
    **dict.fromkeys(("cylinder", "capsule"), ("radius length", "")),
    "sphere": ("radius", ""),
    "material": ("name", "color texture"),
    "color": ("rgba", ""),
    "texture": ("filename", ""),
    "joint": ("name type", "parent child origin axis limit dynamics mimic"),
    **dict.fromkeys(("parent", "child"), ("link", "")),
    "axis": ("xyz", ""),
    "limit": ("lower upper effort velocity", ""),
    "dynamics": ("damping friction", ""),
    "mimic": ("joint multiplier offset", ""),
}
ZERO = (0.0, 0.0, 0.0)


def robot(root: Element, base: str) -> Robot:
    """Reads a robot. `base` is the kind of the joint between the ground and the root link."""
    links = {}
    found = Robot(root.attributes.get("name", ""), [], [])
    _leave_out_unread(root, found)
    for element in root.children:
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
    return found


def _leave_out_unread(root: Element, robot: Robot) -> None:
    """Notes every unread attribute and child element; skips the content of unread elements."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        attributes, children = (words.split() for words in READ[element.tag])
        for name in element.attributes:
            if name not in attributes and name.partition(":")[0] != "xmlns":
                robot.leave_out(f"'{name}' of <{element.tag}>")
        seen: set[str] = set()
        for child in element.children:
            if ":" in child.tag:
                raise child.wrong(f"<{child.tag}> is xacro", "run xacro first")
            within = f" of <{element.tag}>" if element is not root else ""
            if child.tag in children and child.tag in seen:
                robot.leave_out(f"another <{child.tag}>{within}")
            elif child.tag in children or f"{child.tag}*" in children:
                waiting.append(child)
            else:
                robot.leave_out(f"<{child.tag}>{within}")
            seen.add(child.tag)


def _mimic(element: Element, joint: Joint, robot: Robot) -> Mimic | None:
    """Returns the mimic, q = multiplier * (q of another joint) + offset."""
    factor, offset = element.number("multiplier", 1.0), element.number("offset", 0.0)
    if joint.kind not in ("revolute", "prismatic"):
        robot.leave_out(f"<mimic> of a {joint.kind} joint")
        return None
    return Mimic(element, element.text("joint"), factor, offset)


def _link(element: Element, name: str, robot: Robot) -> Link:
    link = Link(name)
    for shape in (*element.all("visual"), *element.all("collision")):
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
        elif any(limit.number(word, 0.0) for word in ("lower", "upper")):
            robot.leave_out(f"limits of a {given} joint")
    if dynamics is not None and axis is not None and kind != "planar":
        joint.damping = dynamics.number("damping", 0.0)
        if joint.damping < 0:
            raise dynamics.wrong(f"the damping of '{name}' is negative")
    elif dynamics is not None and dynamics.number("damping", 0.0):
        robot.leave_out(f"damping of a {kind} joint")
    if dynamics is not None and dynamics.number("friction", 0.0):
        robot.leave_out("friction of a joint")
    mimic = element.first("mimic")
    joint.mimic = _mimic(mimic, joint, robot) if mimic is not None else None
    return joint
