"""Words of `body` and `joint`, and what each kind of joint is made of.

They are words in these statements alone; a model may have a `mass` or a `ground` of its own. A
joint is its place and turning in the parent's frame, and a row of KINDS, as text of the language: Q
turns vectors of the child's frame to that of the joint, r is the child's origin there, w and v are
what the joint adds to the angular velocity and to the velocity of the origin, both in the child's
frame. In these {a} is the axis, {u} the unit vector along it, {1} the first coordinate, {e} and {f}
what spans the plane across the axis.
Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..indices import parted
from ..record import record
from ..tree import Name

GROUND = "ground"
TO = "to"  # between the two bodies of a joint
WORDS_TO_KIND = 2  # `to` and the kind are words before what stands behind the kind of a joint
CLAUSES = {"body": ("mass", "inertia", "at"), "joint": ("at", "turned", "coord", "limits")}
# What a body has, `point` of a vector. The other members are of what is made of it.
SHOWN = ("com", "origin", "R", "omega", "mass", "point")
HELD = ("held", "place", "e", "f", "g")  # of a body that is fixed to another: body_parts.py
COLUMNS = ("X", "Y", "Z")  # of R, of families where the index is a loop's
TURNING = ("R", "held", "turn")  # rotations
LIMITS = {"lower": ("falling", -1), "upper": ("rising", 1)}  # how each is passed
_OWN = (*LIMITS, "at", "axis", "inertia", "products", "turn", "velocity", "speed", "field")
MEMBERS = frozenset((*SHOWN, *HELD, *COLUMNS, *_OWN))

# kind | axis | coordinates: what stands behind the joint's name, and what it is | Q | r | w | v
_KINDS = """
revolute  | axis | :angle                               | rot({a}, {1}) |         | {1}'*{u}   |
prismatic | axis | :length                              |               | {1}*{u} |            | {1}'*{u}
planar    | axis | _1:length _2:length :angle           | rot({a}, {3}) | {1}*{e} + {2}*{f} | {3}'*{u} | inverse(rot({a}, {3}))*({1}'*{e} + {2}'*{f})
spherical |      | :rotation                            | {1}           |         | omega({1}) |
free      |      | _x:length _y:length _z:length :rotation | {4} | [{1}, {2}, {3}] | omega({4}) | inverse({4})*[{1}', {2}', {3}']
fixed     |      |                                      |               |         |            |
"""  # noqa: E501


@record
class Kind:
    axis: bool
    coordinates: tuple[tuple[str, str], ...]  # suffix, and "angle", "length" or "rotation"
    turn: str
    shift: str
    rates: str
    velocity: str


def _kinds():
    for line in _KINDS.strip().split("\n"):
        name, axis, coordinates, *texts = (part.strip() for part in line.split("|"))
        pairs = tuple(tuple(item.split(":")) for item in coordinates.split())
        yield name, Kind(bool(axis), pairs, *texts)


KINDS = dict(_kinds())


def loose(bodies: Iterable[str], joints: Iterable) -> frozenset[str]:
    """Bodies that no joints join to the ground, and families with such members: they have no
    places, and that is said once."""
    held, left = {GROUND}, list(joints)
    names = {*bodies}
    while more := [j for j in left if j.parent[0] in held and j.child[0] in names]:
        held |= {j.child[0] for j in more}
        left = [j for j in left if j not in more]
    found = (names | {j.child[0] for j in left}) - held
    return frozenset(found | {parted(name)[0] for name in found})


def joint_names(joint) -> tuple[tuple[str, str], ...]:
    """Names and what each is, of a statement; those that `coord` gives, else by the joint's. Of a
    member of a family they are the families'."""
    kind = KINDS.get(joint.kind[0])
    if kind is None:
        return ()
    given = [e for word, _, items in joint.clauses if word == "coord" for e in items]
    names = [e.id for e in given if isinstance(e, Name)]
    own = [joint.left.name + suffix for suffix, _ in kind.coordinates]
    return tuple(
        (name, what)
        for name, (_, what) in zip(
            names if len(names) == len(own) else own, kind.coordinates, strict=True
        )
    )
