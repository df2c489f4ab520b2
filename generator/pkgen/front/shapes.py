"""The shapes of `draw` and `view`, one row each. The subject is the value after a shape's word.

The words of shapes and clauses are special only in these statements, where a name after a complete
value starts a clause. Elsewhere a model may use them as names, such as `rod` or `radius`.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..record import record
from ..system.near import meant

# Kinds of values. Lengths have the dimension of the drawing's positions.
PLACE, LENGTH, VECTOR, SCALE, COUNT, TIME = "place", "length", "vector", "scale", "count", "time"
ROTATION, AXIS, PLANE, VALUE, COORDINATE = "rotation", "axis", "plane", "value", "coordinate"
NOTHING = ""

FORMS = {"box": 3, "cylinder": 2, "ellipsoid": 3, "disk": 2, "top": 2}  # number of sizes
PLANES = {"xy": ("x", "y"), "xz": ("x", "z"), "yz": ("y", "z")}


# Columns: shape, kind of its subject (- for none), clauses, each with the kind of its value (- for
# none), and syntax. A ? marks optional items.
_DRAW = """
rod    -         from:place,to:place                 from A to B
line   -         from:place,to:place                 from A to B
spring -         from:place,to:place,turns?:count    from A to B turns 8
bob    place     radius?:length                      P radius 0.1 [m]
circle place     radius:length                       P radius 1 [m]
trail  place     lasting?:time                       P lasting 5 [s]
arrow  vector    at:place,scale:scale                F at P scale 0.1 [m/N]
body   rotation? at:place,FORMS                      R at P box [a, b, c]
ground axis      -                                   y = 0
curve  place     -                                   P[i], i = 1..N
level  value     in:coordinate                       V in x, y
"""
_VIEW = """
plane  plane     width?:length                       xy width 2 [m]
space  -         width?:length                       width 2 [m]
"""


@record
class Shape:
    form: str  # The statement's syntax, for hints.
    subject: str  # Kind of the value after the shape's word; "" if there is none.
    subject_optional: bool
    parts: dict[str, str]  # Word of a clause -> kind of its value.
    optional: tuple[str, ...]
    view: bool


def _shapes() -> Iterator[tuple[str, Shape]]:
    forms = ",".join(f"{form}?:{LENGTH}" for form in FORMS)
    for word, rows in (("draw", _DRAW), ("view", _VIEW)):
        for row in rows.strip().split("\n"):
            name, subject, parts, form = row.replace("FORMS", forms).split(maxsplit=3)
            pairs = [part.split(":") for part in parts.strip("-").split(",") if part]
            parts = {part.rstrip("?"): what for part, what in pairs}
            optional = tuple(part[:-1] for part, _ in pairs if part.endswith("?"))
            said = f"{word} {name} {form}", subject.strip("-?"), subject.endswith("?")
            yield name, Shape(*said, parts, optional, word == "view")


SHAPES = dict(_shapes())


def shapes_of(word: str) -> dict[str, Shape]:
    """Returns the shapes of `draw` or of `view`."""
    return {name: shape for name, shape in SHAPES.items() if shape.view == (word == "view")}


def unknown_shape(word: str, name: str) -> str:
    """Returns the hint for an unknown shape."""
    shapes = shapes_of(word)
    return meant(name, shapes) or f"{word} takes: {', '.join(shapes)}"
