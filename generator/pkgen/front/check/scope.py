"""The kinds of place where a model has expressions, and the names that each allows."""

from __future__ import annotations

from dataclasses import field

from ...record import record
from ...tree import Range

Interval = tuple[int, int]


@record
class Loop:
    """A loop over an integer range, and the interval that contains all values of its variable."""

    range: Range
    interval: Interval

    @property
    def length(self) -> int:
        return self.interval[1] - self.interval[0] + 1


@record
class Place:
    """A kind of place in a model that has an expression, such as a force. Messages describe the
    place by `what` and its allowed names by `may_use`. `kinds` are the kinds of these names.
    `derivatives` says if derivatives are allowed."""

    what: str
    kinds: frozenset[str]
    may_use: str
    derivatives: bool = False
    missing: str = ""  # Hint for an unknown name; "" means the default hint.
    accelerations: bool = False  # Whether accelerations are allowed.


DECLARED = "declare it: param {name} = 1"
_RECORDED = "what is recorded is declared above the scene: observe {name} = …"
_NUMBERS = frozenset(("loop variable", "size", "constant"))
_PARAMETERS = _NUMBERS | {"parameter"}
_DRIVEN = _PARAMETERS | {"time", "input", "memory cell", "definition"}
_MOTION = _DRIVEN | {"coordinate", "state", "rotation"}
_FOUND = _MOTION | {"built-in", "multiplier"}

_OUTPUTS = _FOUND | {"output"}
_IN_RUN = "numbers, sizes, constants and parameters"
_IN_TIME = "numbers, sizes, constants, parameters and t"
_BESIDE = "numbers, sizes, constants and earlier parameters"
_STILL = "numbers, parameters, coordinates and t"
_ALL, _NAMES = "all but outputs", "names of the motion"
_OUTPUT = Place("an output", _FOUND, "all but other outputs", True, "", True)

PLACES: dict[str, Place] = {
    "size": Place("a size", frozenset(("size",)), "integers and earlier sizes"),
    "const": Place("a constant", _NUMBERS, "numbers, sizes and earlier constants"),
    "bound": Place("a bound", _NUMBERS, "numbers, sizes and constants"),
    "option": Place("an option", _NUMBERS, "numbers and sizes"),
    "accuracy": Place("an accuracy", _NUMBERS, "numbers and constants"),
    "param": Place("a parameter's default", _PARAMETERS, _BESIDE),
    "start": Place("a start", _PARAMETERS, _IN_RUN, missing=DECLARED),
    "setting": Place("a scene", _PARAMETERS, _IN_RUN, missing=DECLARED),
    "driving": Place("an input", _PARAMETERS | {"time"}, _IN_TIME, missing=DECLARED),
    "held": Place("a held coordinate", _PARAMETERS | {"time"}, _IN_TIME, missing=DECLARED),
    "exact": Place("a closed form", _PARAMETERS | {"time"}, _IN_TIME, missing=DECLARED),
    "fixed": Place("a fixed end", _DRIVEN, "parameters, inputs and t", derivatives=True),
    "let": Place("a definition", _MOTION, _ALL, derivatives=True),
    "energy": Place("an energy", _MOTION, _ALL, derivatives=True),
    "hamiltonian": Place("a Hamiltonian", _MOTION | {"built-in"}, "all but rates and outputs"),
    "force": Place("a force", _MOTION, _ALL, derivatives=True),
    "noise": Place("a noise", _MOTION - {"input", "memory cell", "state"}, _STILL),
    "body": Place("a body", _PARAMETERS | {"definition"}, "numbers, constants and parameters"),
    "joint": Place("a joint", _DRIVEN, "numbers, constants, parameters and t", derivatives=True),
    "constraint": Place("a constraint", _MOTION, _ALL, derivatives=True),
    "friction": Place("a friction", _MOTION | {"multiplier"}, _ALL, derivatives=True),
    "sample": Place("a sample block", _FOUND, "all but outputs", True, "", True),
    "then": Place("a value after an event", _FOUND, "all but outputs", True, "", True),
    "rate": Place("a rate", _MOTION | {"built-in"}, _ALL, derivatives=True),
    "observe": _OUTPUT,
    "conserve": _OUTPUT,
    "event": Place("an event", _OUTPUTS, _NAMES, True, "", True),
    "drawing": Place("a drawing", _OUTPUTS, _NAMES, True, "", True),
    "expect": Place("an expectation", _OUTPUTS, _NAMES, True, "", True),
    "record": Place("a record", _OUTPUTS, _NAMES, True, _RECORDED, True),
}


@record
class Scope:
    """A Place and the loops around it, the outermost loop first; `name` is the name whose
    definition is being checked."""

    place: Place
    loops: tuple[Loop, ...] = ()
    name: str = ""
    variables: frozenset[str] = field(default=frozenset())
    points: int = 1  # Upper bound of the number of iterations of all loops together.
