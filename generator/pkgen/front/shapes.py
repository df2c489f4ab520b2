"""The shapes of `draw` and `view`, a row each: what stands behind the word, and their parts.

Their words are words there alone. Whatever follows a complete value is the name of a part; where a
value is due stands a name of the model, which may have a `rod` or a `radius` of its own.
"""

from __future__ import annotations

from difflib import get_close_matches

from ..record import record

# What a part is; the dimension of lengths is that of the places of the whole drawing.
PLACE, LENGTH, VECTOR, SCALE, COUNT, TIME = "place", "length", "vector", "scale", "count", "time"
ROTATION, AXIS, PLANE, VALUE, COORDINATE = "rotation", "axis", "plane", "value", "coordinate"
NOTHING = ""

FORMS = {"box": 3, "cylinder": 2, "ellipsoid": 3, "disk": 2, "top": 2}  # sizes of each
PLANES = {"xy": ("x", "y"), "xz": ("x", "z"), "yz": ("y", "z")}


@record(kw_only=True)
class Shape:
    form: str  # as a hint shows it
    subject: str = NOTHING  # what stands behind its word
    parts: dict[str, str]  # what each is
    optional: tuple[str, ...] = ()
    subject_optional: bool = False
    view: bool = False


_ENDS = {"from": PLACE, "to": PLACE}

SHAPES: dict[str, Shape] = {
    "rod": Shape(form="draw rod from A to B", parts=_ENDS),
    "line": Shape(form="draw line from A to B", parts=_ENDS),
    "spring": Shape(
        form="draw spring from A to B turns 8",
        parts={**_ENDS, "turns": COUNT},
        optional=("turns",),
    ),
    "bob": Shape(
        form="draw bob P radius 0.1 [m]",
        subject=PLACE,
        parts={"radius": LENGTH},
        optional=("radius",),
    ),
    "circle": Shape(form="draw circle P radius 1 [m]", subject=PLACE, parts={"radius": LENGTH}),
    "trail": Shape(
        form="draw trail P lasting 5 [s]",
        subject=PLACE,
        parts={"lasting": TIME},
        optional=("lasting",),
    ),
    "arrow": Shape(
        form="draw arrow F at P scale 0.1 [m/N]",
        subject=VECTOR,
        parts={"at": PLACE, "scale": SCALE},
    ),
    "body": Shape(
        form="draw body R at P box [a, b, c]",
        subject=ROTATION,
        subject_optional=True,
        parts={"at": PLACE, **dict.fromkeys(FORMS, LENGTH)},
        optional=tuple(FORMS),
    ),
    "ground": Shape(form="draw ground y = 0", subject=AXIS, parts={}),
    "curve": Shape(form="draw curve P[i], i = 1..N", subject=PLACE, parts={}),
    "level": Shape(form="draw level V in x, y", subject=VALUE, parts={"in": COORDINATE}),
    "plane": Shape(
        form="view plane xy width 2 [m]",
        subject=PLANE,
        parts={"width": LENGTH},
        optional=("width",),
        view=True,
    ),
    "space": Shape(
        form="view space width 2 [m]", parts={"width": LENGTH}, optional=("width",), view=True
    ),
}


def shapes_of(word: str) -> dict[str, Shape]:
    """Those of `draw` or of `view`."""
    return {name: shape for name, shape in SHAPES.items() if shape.view == (word == "view")}


def unknown_shape(word: str, name: str) -> str:
    """What to write in place of it."""
    shapes = shapes_of(word)
    near = get_close_matches(name, shapes, 1, 0.6)
    return f"did you mean '{near[0]}'?" if near else f"{word} takes: {', '.join(shapes)}"
