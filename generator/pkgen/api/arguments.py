"""Arguments of the Python API: their types, and their conversion to options of `pkgen run`."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from numbers import Integral, Real
from typing import Any

import numpy

from ..defaults import ITERATIONS, OPTIONS
from ..source import ModelError
from ..system.exits import BuildError, NumericsFailed, UsageError
from .errors import ArrayError

Value = str | float  # a text such as "2 [kg]", or a number in SI units
Files = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]
Names = str | Sequence[str]
Weights = str | Sequence[str] | Sequence[float]
NUMBERS = ("until", "every", "step", "max_step", "rtol", "atol")
# Options that a call may leave out, with their defaults.
DEFAULTS = {**OPTIONS, "tableau": (), "composition": (), "output": None, "json": True}
Check = Callable[[object], bool]


def _is(*types: type) -> Check:
    return lambda x: isinstance(x, types) and not isinstance(x, bool)


_is_number, _is_value, _is_whole, _is_text = _is(Real), _is(str, Real), _is(Integral), _is(str)


def is_path(x: object) -> bool:
    return isinstance(x, str | os.PathLike) and "\0" not in os.fspath(x)


def _some(one: Check) -> Check:
    """Returns a check that accepts a value that passes the check `one`, or a sequence of such
    values."""

    def check(x: object) -> bool:
        if one(x) or not isinstance(x, Collection) or isinstance(x, Mapping | bytes):
            return one(x)
        return getattr(x, "ndim", 1) == 1 and all(map(one, x))

    return check


def _named(one: Check) -> Check:
    return lambda x: isinstance(x, Mapping) and all(map(_is_text, x)) and all(map(one, x.values()))


def is_computed(x: object) -> bool:
    """Whether the value of an input is a function or a table, not a number."""
    return callable(x) or (isinstance(x, tuple) and len(x) in (2, 3))


_VALUE = "a number in SI, or a text with a unit, as '2 [kg]'"
# For each argument: the check of its type, and the name of the type in messages.
ALLOWED: dict[str, tuple[Check, str]] = {
    "path": (is_path, "a text or a path"),
    "sizes": (_named(_is_whole), "a dictionary of whole numbers by name, as {'N': 64}"),
    "allow_path": (_some(is_path), "a folder, or a list of folders"),
    "params": (_named(_is_value), _VALUE),
    "start": (_named(_is_value), "a dictionary of values by name, as {'theta1': 0.5}"),
    "inputs": (
        _named(lambda x: _is_value(x) or is_computed(x)),
        "a dictionary by name: {'u': 2.5}, {'u': f}, {'u': (t, values)}",
    ),
    "controllers": (_named(callable), "a dictionary of functions by name: {'ctrl': f}"),
    "iteration": (lambda x: _is_text(x) and x in ITERATIONS, " or ".join(map(repr, ITERATIONS))),
    "tableau": (_some(is_path), "a path, or a list of paths"),
    "composition": (_some(_is_value), "a text of weights, or a list of numbers"),
    **dict.fromkeys(NUMBERS, (_is_value, _VALUE)),
    **dict.fromkeys(("hold", "linear"), (_is_number, "a number, in the model's unit of time")),
    **dict.fromkeys(("scene", "method", "at", "of"), (_is_text, "a text")),
    **dict.fromkeys(
        ("record", "diagnose", "sensitivity", "by", "free", "free_start"),
        (_some(_is_text), "a name, or a list of names"),
    ),
    **dict.fromkeys(("max_steps", "threads", "seed", "tries"), (_is_whole, "a whole number")),
}
REQUIRED = ("path", "iteration", "max_steps")  # arguments that must not be None


def checked(**given: object) -> None:
    """Raises UsageError for an argument that has a wrong type."""
    for name, x in given.items():
        if name in ALLOWED and (x is not None or name in REQUIRED):
            allows, words = ALLOWED[name]
            if not allows(x):
                raise UsageError(f"{name}={brief(x)}: give {words}")


def brief(x: object) -> str:
    shown = repr(x)
    return shown if len(shown) <= 40 else f"{shown[:37]}..."


def text(value: Value) -> str:
    """Returns a value as the text of an option. Raises UsageError if it exceeds a double."""
    try:
        return value if isinstance(value, str) else repr(float(value))
    except OverflowError:
        raise UsageError(f"{brief(value)}: no double is that large") from None


def arrays(**given: object) -> list[numpy.ndarray]:
    """Returns the arguments as arrays of floats. Raises ArrayError."""
    made = []
    for name, x in given.items():
        try:
            made.append(numpy.asarray(x, float))
        except (TypeError, ValueError, OverflowError):
            raise ArrayError(f"{name}={brief(x)}: give an array of numbers") from None
    return made


def several(given: Any) -> list[Any]:
    one = isinstance(given, str | os.PathLike) or _is_number(given)
    return [given] if one else list(() if given is None else given)


def options(model: Any, given: dict[str, Any]) -> argparse.Namespace:
    """Converts arguments of Model.run() to options of `pkgen run`. Raises UsageError, or TypeError
    for an unknown argument."""
    start, inputs = given.pop("start", None), given.pop("inputs", None)
    unknown = given.keys() - DEFAULTS.keys()
    if unknown:
        raise TypeError(f"there is no argument {sorted(unknown)[0]!r} here")
    checked(start=start, inputs=inputs, **given)
    constants = inputs or {}
    for name in filter(lambda k: is_computed(constants[k]), constants):
        raise UsageError(f"inputs: {name}: run() alone takes functions and arrays of an input")
    texts = {k: text(given[k]) for k in NUMBERS if given.get(k) is not None}
    made = argparse.Namespace(**{**DEFAULTS, **given, **texts})
    made.model, made.scene = model.path, model.scene
    made.size = [f"{name}={length}" for name, length in model._sizes.items()]
    made.set = [f"{k}={text(x)}" for k, x in {**model.params._set, **constants}.items()]
    made.start = [f"{name}={text(value)}" for name, value in (start or {}).items()]
    made.record = None if made.record is None else ",".join(several(made.record))
    made.diagnose = ",".join(several(made.diagnose)) or None
    made.tableau = [os.fspath(path) for path in several(made.tableau)]
    weights = several(made.composition)
    made.composition = [",".join(map(text, weights))] if any(map(_is_number, weights)) else weights
    return made


# Command-line options whose argument in Python has another name -> the argument's name.
_CALLS = {"ensemble": "ensemble()", "set": "params and inputs", "size": "sizes", "output": "rows"}
# Dictionary arguments whose items are values of an option.
_ITEMS = {"set": "inputs", "size": "sizes", "start": "start"}
_ITEM = re.compile(r"--(set|start|size) ([A-Za-z_][\w.\[\]']*)")
_OPTION = re.compile(r"--([a-z]+(?:-[a-z]+)*)(?: (?=[^\s:]+(?: \[[^\]]*\])?(?::|$)))?")


def worded(said: str) -> str:
    """Rewrites a message about options so that it names arguments: `until=` for `--until`."""
    said = _ITEM.sub(lambda found: f"{_ITEMS[found[1]]}[{found[2]!r}]", said)
    return _OPTION.sub(lambda x: _CALLS.get(x[1], x[1].replace("-", "_") + "="), said)


@contextmanager
def in_words() -> Iterator[None]:
    """A context manager. Errors that are raised in its block have messages that name arguments of
    the Python API instead of command-line options."""
    try:
        yield
    except ModelError as error:
        error.source = error.source.with_words(worded(error.source.path), "arguments")
        error.diagnostics = [
            replace(d, message=worded(d.message), help=worded(d.help)) for d in error.diagnostics
        ]
        raise
    except (BuildError, NumericsFailed, UsageError) as error:
        error.args = tuple(worded(x) if isinstance(x, str) else x for x in error.args)
        raise
    except OSError as error:
        raise UsageError(f"{error.filename}: {error.strerror}") from None
