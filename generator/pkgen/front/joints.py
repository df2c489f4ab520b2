"""The words of `body` and `joint`, and the kinds of joints.

These words are reserved only in these statements; a model may name a parameter `mass` or `ground`.
A joint has a position and a rotation in the parent body's frame, and a row of KINDS. The row of a
kind of joint contains expressions in the text of the language. The rotation Q turns vectors from
the child body's frame to the joint's frame; r is the child's origin in the joint's frame; w and v
are the joint's contributions to the child's angular velocity and to the velocity of the child's
origin, both in the child's frame. {a} stands for the axis, {u} for the unit vector along it, {e}
and {f} for unit vectors that span the plane normal to it, {1} for the joint's first coordinate.
Reference: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterable

from ..indices import OF_BODIES, parted
from ..record import record
from ..tree import Name

GROUND = "ground"
TO = "to"  # The word between the names of a joint's two bodies.
WORDS_TO_KIND = 2  # A joint has two words up to its kind: `to` and the kind.
CLAUSES = {"body": ("mass", "inertia", "at"), "joint": ("at", "turned", "coord", "limits")}
# Quantities of a body that a model may use, as in link.com (`point` takes a vector). All others
# are internal.
SHOWN = ("com", "origin", "R", "omega", "mass", "point")
# Internal quantities of a body that is fixed to another body.
HELD = ("held", "place", "e", "f", "g")
COLUMNS = ("X", "Y", "Z")  # Columns of R, which families of bodies use in place of R.
TURNING = ("R", "held", "turn")  # Quantities that are rotations.
# End of a joint's range -> direction in which the event crosses zero, sign of the infinity that
# means no limit.
LIMITS = {"lower": ("falling", -1), "upper": ("rising", 1)}
MEMBERS = frozenset(OF_BODIES.split())

# Columns: kind of joint, whether it has an axis, coordinates (suffix of the joint's name, a colon,
# kind of coordinate), Q, r, w, v.
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
    coordinates: tuple[tuple[str, str], ...]  # suffix of the joint's name; kind
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
    """Returns the bodies that no chain of joints connects to the ground, and the families that
    contain such bodies. Names.unknown() reports no further error about these names."""
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
    names = names if len(names) == len(own) else own
    return tuple((name, what) for name, (_, what) in zip(names, kind.coordinates, strict=True))
