"""What does not run a statement of the language: one table, and the error that it makes."""

from __future__ import annotations

from collections.abc import Iterable

from ..model import Model
from .quantities import error

AS_C = "the C of 'pkgen MODEL.lag' has NAME_BLOCK_sample(); 'pkgen build' makes a program"
AS_FORCE = "write the controller as a force for this: its motion goes on between the samples"
_NO_BLOCK, _NO_NOISE = "{} runs no sample block", "{} knows no noise"
_RUNS = "'pkgen run' and 'pkgen film' do"
_LEFT = "leave the noise out, or take averages over members of 'pkgen run --ensemble'"
OF_ROWS = frozenset(("spectrum", "area"))  # diagnostics that rows alone are needed for
_OF_ROWS = f"'spectrum' and 'area' alone are of its rows; {AS_FORCE}"
_BUILT = "'pkgen build' makes a program that does"
_SMOOTH = "leave it out, or write a smooth force in its place"


def _changes(message: str) -> dict[str, tuple[str, str]]:
    """Returns the row of statements that change the motion at once."""
    return {
        "pkgen export": (message, _BUILT),
        "pkgen stability": (message, _SMOOTH),
        "--enclose": (message, _SMOOTH),
        "--diagnose": (message, "'spectrum' and 'area' alone are of its rows"),
        "inputs": (
            "a function or a table is no input beside events that change the motion",
            "give it in the model: 'set d = sin(t)' in a scene, or --set \"d=sin(t)\"",
        ),
    }


# For each field of Model that has the statements, and each command that refuses them: the message,
# and what to do instead.
_REFUSED = {
    "samples": {
        "pkgen export": (_NO_BLOCK, AS_C),
        "pkgen show": (_NO_BLOCK, _RUNS),
        "pkgen stability": (_NO_BLOCK, AS_FORCE),
        "--enclose": (_NO_BLOCK, AS_FORCE),
        "--diagnose": (_NO_BLOCK, _OF_ROWS),
        "inputs": (
            "a function or a table is no input beside a sample block",
            "in a model with sample blocks: --set \"d=sin(t)\", or 'set d = sin(t)' in a scene",
        ),
        "sensitivity": ("runs with sample blocks have no derivatives", AS_FORCE),
    },
    "noises": {
        "pkgen export": (
            _NO_NOISE,
            "the C of 'pkgen MODEL.lag' has NAME_noise(); 'pkgen build' makes a program",
        ),
        "pkgen stability": (_NO_NOISE, _LEFT),
        "pkgen chart": (
            "{} measures errors of one motion, and noise has no reference",
            "methods with noise have weak order 2, of averages: compare them by a shorter step",
        ),
        "accuracy": (
            "an accuracy is of one motion, and noise has none",
            "choose a method and its step: method baoab step 0.01",
        ),
        "--enclose": (_NO_NOISE, _LEFT),
        "--diagnose": (_NO_NOISE, "'spectrum' and 'area' alone are of its rows"),
    },
    "resetting": _changes("{} knows no values after events"),
    "contacts": _changes("{} knows no contacts"),
    "frictions": _changes("{} knows no friction"),
    "modes": _changes("{} knows no modes"),
}


def refuse_statements(
    model: Model, what: str, but: Iterable[str] = (), named: str | None = None
) -> None:
    """Raises ModelError for the first statement that `what`, a command, does not run. It runs those
    in the fields `but`. Messages call the command `named`."""
    for field, refused in _REFUSED.items():
        for item in getattr(model, field) if what in refused and field not in but else ():
            message, instead = refused[what]
            span = item.head if field == "samples" else item.span
            raise error(model, message.format(named or what), span, instead)


def refuse_diagnostics(model: Model, names: Iterable[str]) -> None:
    left = {*names} - OF_ROWS
    if left:
        changes = ("contacts", "resetting")  # a neighbour shows how fast motions part at these
        refuse_statements(model, "--diagnose", changes if left == {"lyapunov"} else ())
