"""The shapes of `draw` and `view`, a row each: what stands behind the word, and their parts.

Their words are words there alone. Whatever follows a complete value is the name of a part; where a
value is due stands a name of the model, which may have a `rod` or a `radius` of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches

from ..record import record

# What a part is; the dimension of lengths is that of the places of the whole drawing.
PLACE, LENGTH, VECTOR, SCALE, COUNT, TIME = "place", "length", "vector", "scale", "count", "time"
ROTATION, AXIS, PLANE, VALUE, COORDINATE = "rotation", "axis", "plane", "value", "coordinate"
NOTHING = ""

FORMS = {"box": 3, "cylinder": 2, "ellipsoid": 3, "disk": 2, "top": 2}  # sizes of each
PLANES = {"xy": ("x", "y"), "xz": ("x", "z"), "yz": ("y", "z")}


# shape  what stands behind its word  its parts, each with what it is  form
# A ? is behind what may be left out.
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
    form: str  # as a hint shows it
    subject: str  # what stands behind its word
    subject_optional: bool
    parts: dict[str, str]  # what each is
    optional: tuple[str, ...]
    view: bool


def _shapes() -> Iterator[tuple[str, Shape]]:
    forms = ",".join(f"{form}?:{LENGTH}" for form in FORMS)
    for word, rows in (("draw", _DRAW), ("view", _VIEW)):
        for row in rows.strip().split("\n"):
            name, subject, parts, form = row.replace("FORMS", forms).split(maxsplit=3)
            pairs = [part.split(":") for part in parts.strip("-").split(",") if part]
            yield (
                name,
                Shape(
                    f"{word} {name} {form}",
                    subject.strip("-?"),
                    subject.endswith("?"),
                    {part.rstrip("?"): what for part, what in pairs},
                    tuple(part[:-1] for part, _ in pairs if part.endswith("?")),
                    word == "view",
                ),
            )


SHAPES = dict(_shapes())


def shapes_of(word: str) -> dict[str, Shape]:
    """Those of `draw` or of `view`."""
    return {name: shape for name, shape in SHAPES.items() if shape.view == (word == "view")}


def unknown_shape(word: str, name: str) -> str:
    """What to write in place of it."""
    shapes = shapes_of(word)
    near = get_close_matches(name, shapes, 1, 0.6)
    return f"did you mean '{near[0]}'?" if near else f"{word} takes: {', '.join(shapes)}"
