"""Where an expression stands, and so what it may use."""

from __future__ import annotations

from dataclasses import field

from ...record import record
from .loops import Loop


@record
class Place:
    """`what` it is in messages, which kinds of names it takes, whether derivatives mean
    anything there."""

    what: str
    kinds: frozenset[str]
    may_use: str
    derivatives: bool = False
    missing: str = ""  # what to do where a name is not there; "": what helps anywhere
    accelerations: bool = False  # where the equations of motion are solved


DECLARED = "declare it: param {name} = 1"
_RECORDED = "what is recorded is declared above the scene: observe {name} = …"
_NUMBERS = frozenset(("loop variable", "size", "constant", "not compiled"))
_PARAMETERS = _NUMBERS | {"parameter"}
_DRIVEN = _PARAMETERS | {"time", "input", "definition"}
_MOTION = _DRIVEN | {"coordinate", "state", "rotation"}
_FOUND = _MOTION | {"built-in", "multiplier"}

_OUTPUT = Place("an output", _FOUND, "all but other outputs", True, accelerations=True)
PLACES: dict[str, Place] = {
    "size": Place("a size", frozenset(("size",)), "integers and earlier sizes"),
    "const": Place("a constant", _NUMBERS, "numbers, sizes and earlier constants"),
    "bound": Place("a bound", _NUMBERS, "numbers, sizes and constants"),
    "option": Place("an option", _NUMBERS, "numbers and sizes"),
    "param": Place(
        "a parameter's default", _PARAMETERS, "numbers, sizes, constants and earlier parameters"
    ),
    "start": Place(
        "a start", _PARAMETERS, "numbers, sizes, constants and parameters", missing=DECLARED
    ),
    "fixed": Place("a fixed end", _DRIVEN, "parameters, inputs and t", derivatives=True),
    "let": Place("a definition", _MOTION, "all but outputs", derivatives=True),
    "energy": Place("an energy", _MOTION, "all but outputs", derivatives=True),
    "force": Place("a force", _MOTION, "all but outputs", derivatives=True),
    "constraint": Place("a constraint", _MOTION, "all but outputs", derivatives=True),
    "rate": Place("a rate", _MOTION | {"built-in"}, "all but outputs", derivatives=True),
    "observe": _OUTPUT,
    "conserve": _OUTPUT,
    "event": Place(
        "an event", _FOUND | {"output"}, "names of the motion", True, accelerations=True
    ),
    "drawing": Place(
        "a drawing", _FOUND | {"output"}, "names of the motion", True, accelerations=True
    ),
    "setting": Place(
        "a scene", _PARAMETERS, "numbers, sizes, constants and parameters", missing=DECLARED
    ),
    "driving": Place(
        "an input",
        _PARAMETERS | {"time"},
        "numbers, sizes, constants, parameters and t",
        missing=DECLARED,
    ),
    "accuracy": Place("an accuracy", _NUMBERS, "numbers and constants"),
    "held": Place(
        "a held coordinate",
        _PARAMETERS | {"time"},
        "numbers, sizes, constants, parameters and t",
        missing=DECLARED,
    ),
    "expect": Place(
        "an expectation",
        _FOUND | {"output"},
        "names of the motion",
        derivatives=True,
        accelerations=True,
    ),
    "record": Place("a record", _FOUND | {"output"}, "names of the motion", True, _RECORDED, True),
}


@record
class Scope:
    """A place and the loops around it, outermost first. `name` is what is being defined."""

    place: Place
    loops: tuple[Loop, ...] = ()
    name: str = ""
    variables: frozenset[str] = field(default=frozenset())
    points: int = 1  # at most so many assignments of the loops' variables
