"""The parts of an MJCF file other than bodies: settings, default classes, and sections that are
left out or whose omission is an error."""

from __future__ import annotations

import math
from dataclasses import replace

from .robot import Robot
from .turns import UNIT, Turns, Vector, of_angles, of_axes, of_direction, of_quaternion
from .xml import ANGLE, Element, Errors

ZERO = (0.0, 0.0, 0.0)
TURNS = ("quat", "euler", "axisangle", "xyaxes", "zaxis")
READ = ("worldbody", "compiler", "option", "default")
# For these sections, notes list the tags of the elements left out; for other sections they give
# only the number of elements.
BY_KIND = ("actuator", "tendon", "contact", "equality", "deformable")
# Known attributes: first those that are read, then those that have no effect without contacts,
# actuators, friction in joints and pictures. Other attributes may change the motion and are errors.
KNOWN = {
    "compiler": "angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq"
    " inertiafromgeom inertiagrouprange settotalmass alignfree"
    " assetdir conflict convexhull discardvisual exactmeshinertia fitaabb fusestatic meshdir"
    " passthrough savecanonical savecompiled saveinertial strippath texturedir usethread",
    "option": "density gravity viscosity"
    " actuatorgroupdisable apirate ccd_iterations ccd_tolerance collision cone impratio integrator"
    " iterations jacobian ls_iterations ls_tolerance magnetic mpr_iterations mpr_tolerance"
    " noslip_iterations noslip_tolerance o_friction o_margin o_solimp o_solref sdf_initpoints"
    " sdf_iterations sleep_tolerance solver timestep tolerance wind",
    "body": "name pos quat euler axisangle xyaxes zaxis childclass gravcomp mocap"
    " fuse simple sleep user",
    "inertial": "pos quat euler axisangle xyaxes zaxis mass diaginertia fullinertia",
    "freejoint": "name align group",
    "joint": "name class type pos axis ref stiffness springref damping armature frictionloss range"
    " limited springdamper"
    " actuatorfrclimited actuatorfrcrange actuatorgravcomp group margin solimp solimpfriction"
    " solimplimit solref solreffriction solreflimit user",
    "geom": "name class type size fromto pos quat euler axisangle xyaxes zaxis mass density mesh"
    " shellinertia group contype conaffinity"
    " adhesion castshadow condim fitscale fluidcoef fluidshape friction gap hfield margin material"
    " priority rgba solimp solmix solref surfacevel user",
}
MAIN = "main"  # class of the outermost defaults


def check_known(element: Element) -> None:
    """Raises ModelError at an attribute that is not in KNOWN."""
    known = KNOWN[element.tag].split()
    for name in element.attributes:
        if name not in known:
            message = f"'{name}' of <{element.tag}> is not read, and may change the motion"
            raise element.wrong(message)


class Settings:
    """The settings of <compiler> and <option>; a later element overrides an earlier one."""

    angle, sequence, auto_limits = math.pi / 180, "xyz", True
    # the body's mass comes from the geoms whose group number is in this range
    from_geoms, groups = "auto", (0.0, 5.0)
    balance, least_mass, least_moment, total = False, 0.0, 0.0, -1.0
    gravity = (0.0, 0.0, -9.81)

    def __init__(self, root: Element, errors: Errors) -> None:
        self.flags: dict[str, str] = {}
        for flag in (flag for option in root.all("option") for flag in option.all("flag")):
            self.flags |= flag.attributes
        with errors.collecting():
            self._read_compiler(_merged(root, "compiler", errors))
        with errors.collecting():
            self._read_option(_merged(root, "option", errors))

    def _read_option(self, option: Element) -> None:
        self.gravity = option.numbers("gravity", 3, self.gravity) if self.on("gravity") else ZERO
        fluid = [f"'{word}'" for word in ("density", "viscosity") if option.number(word, 0.0)]
        if fluid:
            message = f"{' and '.join(fluid)} of <option>: a fluid is not read, and drags bodies"
            raise option.wrong(message)

    def _read_compiler(self, compiler: Element) -> None:
        given = compiler.attributes
        self.angle = 1.0 if given.get("angle", "degree") == "radian" else math.pi / 180
        self.sequence = given.get("eulerseq", "xyz")
        self.from_geoms = given.get("inertiafromgeom", "auto")
        self.groups = compiler.numbers("inertiagrouprange", 2, self.groups)
        self.auto_limits = compiler.flag("autolimits", True)
        self.balance = compiler.flag("balanceinertia")
        self.least_mass = compiler.number("boundmass", 0.0)
        self.least_moment = compiler.number("boundinertia", 0.0)
        self.total = compiler.number("settotalmass", -1.0)
        if len(self.sequence) != 3 or any(c not in "xyz" for c in self.sequence.lower()):
            raise compiler.wrong(f'eulerseq="{self.sequence[:10]}" is not read', "e.g. xyz")
        if self.from_geoms not in ("auto", "true", "false"):
            raise compiler.wrong(f'inertiafromgeom="{self.from_geoms[:10]}" is not read')
        if given.get("coordinate", "local") != "local":
            raise compiler.wrong("global coordinates are not read", 'coordinate="local"')
        if given.get("alignfree", "false") != "false":
            raise compiler.wrong("'alignfree' moves the frames of free bodies, and is not read")

    def on(self, *flags: str) -> bool:
        return all(self.flags.get(flag, "enable") != "disable" for flag in flags)

    def placed(self, element: Element) -> tuple[Vector, Turns]:
        """Returns the position and the rotation of an element. Raises ModelError."""
        ways = [way for way in TURNS if way in element.attributes]
        at = element.numbers("pos", 3, ZERO)
        turn: Turns | None = ()
        if len(ways) > 1:
            raise element.wrong(f"'{ways[0]}' and '{ways[1]}' both turn it", "write one of them")
        if ways == ["quat"]:
            turn = of_quaternion(element.numbers("quat", 4))
        elif ways == ["euler"]:
            turn = self._euler(element.numbers("euler", 3, (), ANGLE))
        elif ways == ["axisangle"]:
            *axis, angle = element.numbers("axisangle", 4)
            if abs(angle) > ANGLE:
                raise element.wrong(f"an angle of {angle:g} is too large")
            turn = of_angles([tuple(axis)], [angle * self.angle]) if any(axis) else None
        elif ways == ["xyaxes"]:
            axes = element.numbers("xyaxes", 6)
            turn = of_axes(axes[:3], axes[3:])
        elif ways:
            axis = element.numbers("zaxis", 3)
            turn = of_direction(axis) if any(axis) else None
        if turn is None:
            raise element.wrong("a turn about the zero vector")
        return at, turn

    def _euler(self, angles: Vector) -> Turns:
        """Returns the rotations of Euler angles by `eulerseq`: a small letter is an axis of the
        rotated frame, a capital letter an axis of the fixed frame."""
        order: list[tuple[str, float]] = []
        for letter, angle in zip(self.sequence, angles, strict=True):
            turn = [(letter.lower(), angle * self.angle)]
            order = order + turn if letter.islower() else turn + order
        return of_angles([UNIT["xyz".index(axis)] for axis, _ in order], [a for _, a in order])


def _merged(root: Element, tag: str, errors: Errors) -> Element:
    merged = Element(root.source, tag, {}, root.span)
    for element in root.all(tag):
        with errors.collecting():
            check_known(element)
        merged = replace(element, attributes=merged.attributes | element.attributes, children=[])
    return merged


class Defaults:
    """Default attributes, by class and tag of an element."""

    def __init__(self, root: Element) -> None:
        self.classes: dict[str, dict[str, dict[str, str]]] = {MAIN: {}}
        waiting = [(element, MAIN) for element in root.all("default")][::-1]
        while waiting:
            element, parent = waiting.pop()
            name = element.attributes.get("class", MAIN)
            if name == MAIN:
                values = self.classes[MAIN]
            else:
                values = self.classes[name] = dict(self.classes[parent])
            for child in element.children:
                if child.tag != "default":
                    values[child.tag] = _over(values.get(child.tag, {}), child.attributes)
            waiting += [(child, name) for child in element.all("default")][::-1]

    def of(self, element: Element, around: str) -> Element:
        """Returns an element with the default attributes of its class; if it names no class, of the
        class `around` of the body that contains it. Raises ModelError."""
        name = element.attributes.get("class", around)
        if name not in self.classes:
            raise element.wrong(f"there is no default class '{name}'")
        values = self.classes[name].get(element.tag, {})
        return replace(element, attributes=_over(values, element.attributes))


def _over(values: dict[str, str], own: dict[str, str]) -> dict[str, str]:
    """Returns the default attributes `values`, overridden by an element's own. A rotation in `own`
    replaces the default rotation, even if both are given in different forms. If `size` in `own` has
    fewer numbers than the default, the default's other numbers are kept."""
    turned = any(way in own for way in TURNS)
    both = {k: v for k, v in values.items() if not (turned and k in TURNS)} | own
    if "size" in own and "size" in values:
        size = own["size"].split()
        both["size"] = " ".join(size + values["size"].split()[len(size) :])
    return both


def leave_out_sections(
    root: Element, robot: Robot, settings: Settings, defaults: Defaults, errors: Errors
) -> None:
    """Notes sections that are left out; adds an error for each part that the motion needs."""
    for section in root.children:
        if section.tag not in READ and section.tag not in BY_KIND:
            robot.leave_out(f"<{section.tag}>", max(1, len(section.children)))
        for part in section.children if section.tag in BY_KIND else ():
            with errors.collecting():
                part_of = f"<{part.tag}> of <{section.tag}>"
                _check_part(section.tag, part, part_of, settings, defaults)
                robot.leave_out(part_of)


def _check_part(
    section: str, part: Element, part_of: str, settings: Settings, defaults: Defaults
) -> None:
    """Raises ModelError if the motion needs an element of an unread section."""
    if section == "equality" and settings.on("equality", "constraint"):
        if part.attributes.get("active", "true") != "false":
            help = "take it out, and write a 'constraint' into the .lag file"
            raise part.wrong(f"{part_of} is not read, and would change the motion", help)
    elif section == "deformable" and part.tag != "skin":
        raise part.wrong(f"{part_of} is not read: a flexible part")
    elif section == "tendon":
        whole = replace(part, tag="tendon")
        given = defaults.of(whole, MAIN)
        for word in ("stiffness", "damping", "armature"):
            if any(given.numbers(word, 0, (0.0,))):
                help = "take it out, and write a 'potential' or a 'force' into the .lag file"
                raise part.wrong(f"'{word}' of {part_of} is not read, and would change the motion",
                                 help)  # fmt: skip
    elif section == "actuator":
        given = defaults.of(replace(part, tag="general"), MAIN).attributes
        kinds = {given.get(word) for word in ("dyntype", "gaintype", "biastype")}
        if part.tag == "muscle" or "muscle" in kinds:
            raise part.wrong(f"{part_of} is not read: a muscle pulls when it is not driven",
                             "take it out")  # fmt: skip
