"""The words of `body` and `joint`, and the kinds of joints.

These words are reserved only in these statements; a model may name a parameter `mass` or `ground`.
A joint has a position and a rotation in the parent's frame, and a row of KINDS. A row contains
expressions in the text of the language: Q rotates vectors from the child's frame to the joint's, r
is the child's origin in the joint's frame, w and v are the joint's contributions to the angular
velocity and to the velocity of the origin, both in the child's frame. {a} is the axis, {u} the unit
vector along it, {1} the first coordinate; {e} and {f} are unit vectors that span the plane normal
to the axis. Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..indices import parted
from ..record import record
from ..tree import Name

GROUND = "ground"
TO = "to"  # The word between the names of a joint's two bodies.
WORDS_TO_KIND = 2  # `to` and the kind
CLAUSES = {"body": ("mass", "inertia", "at"), "joint": ("at", "turned", "coord", "limits")}
# Members of a body that a model may use (`point` takes a vector). All others are internal.
SHOWN = ("com", "origin", "R", "omega", "mass", "point")
HELD = ("held", "place", "e", "f", "g")  # Members of a body that is fixed to another one.
COLUMNS = ("X", "Y", "Z")  # Columns of R, for families indexed by a loop variable.
TURNING = ("R", "held", "turn")  # Members that are rotations.
LIMITS = {"lower": ("falling", -1), "upper": ("rising", 1)}  # Event's direction, sign of inf.
_OWN = (*LIMITS, "at", "axis", "inertia", "products", "turn", "velocity", "speed", "field")
MEMBERS = frozenset((*SHOWN, *HELD, *COLUMNS, *_OWN))

# kind | axis | coordinates (suffix of the joint's name, and kind) | Q | r | w | v
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
    coordinates: tuple[tuple[str, str], ...]  # Suffix; angle, length or rotation.
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
    """Returns the bodies that no chain of joints connects to the ground, and the families with such
    members. Names.unknown() reports no further error about them."""
    held, left = {GROUND}, list(joints)
    names = {*bodies}
    while more := [j for j in left if j.parent[0] in held and j.child[0] in names]:
        held |= {j.child[0] for j in more}
        left = [j for j in left if j not in more]
    found = (names | {j.child[0] for j in left}) - held
    return frozenset(found | {parted(name)[0] for name in found})


def joint_names(joint) -> tuple[tuple[str, str], ...]:
    """Returns the coordinates of a joint statement, as (name, kind). The names come from the clause
    `coord`, or from the joint's name; for a member of a family they are the family's names."""
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
