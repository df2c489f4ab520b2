"""The view of a table that command-line options request."""

from __future__ import annotations

import argparse
import re

from ..record import record
from ..system.exits import UsageError

KINDS = ("phase", "path", "spectrum", "drift")
# The most names along the axes of a curve, and what is said of more.
_MOST = {
    "phase": (2, "two names, or one, which is drawn against its rate"),
    "path": (3, "two or three names, or that of a vector"),
}
_LIST = re.compile(r",(?![^\[\]()]*[\])])")  # not within q[1,2]


@record
class View:
    """The requested curves. `names` has the names of their columns; `kind` is the kind of picture.
    If `kind` is "", the kind is chosen by the rows."""

    kind: str = ""
    names: tuple[tuple[str, ...], ...] = ()

    @property
    def option(self) -> str:
        return "--columns" if self.kind in ("", "drift") else f"--{self.kind}"

    @property
    def columns(self) -> list[str]:
        """All column names, each once."""
        return [*dict.fromkeys(name for names in self.names for name in names)]


def asked(options: argparse.Namespace) -> View:
    """Returns the view that the options request. Raises UsageError."""
    given = [kind for kind in KINDS if getattr(options, kind)]
    if len(given) > 1:
        raise UsageError(f"--{given[0]} and --{given[1]}: one picture at a time")
    kind = given[0] if given else ""
    if options.columns is not None and kind in ("phase", "path", "spectrum"):
        raise UsageError(f"--columns and --{kind}: one picture at a time")
    if kind in _MOST:
        return View(kind, tuple(_curve(kind, text) for text in getattr(options, kind)))
    text = options.spectrum if kind == "spectrum" else options.columns
    option = "--spectrum" if kind == "spectrum" else "--columns"
    names = [] if text is None else split(option, text)
    return View(kind, tuple((name,) for name in names))


def split(option: str, text: str) -> list[str]:
    names = ["".join(name.split()) for name in _LIST.split(text)]
    if not all(names):
        raise UsageError(f"{option} {text}: give names, with a comma between them")
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{option} {name}: it is given twice")
    return names


def _curve(kind: str, text: str) -> tuple[str, ...]:
    names, (most, what) = split(f"--{kind}", text), _MOST[kind]
    if len(names) > most:
        raise UsageError(f"--{kind} {text}: {what}")
    return (names[0], f"{names[0]}'") if kind == "phase" and len(names) == 1 else tuple(names)
