"""Messages of commands on standard error: verbosity and colours."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import sys
from collections.abc import Callable
from importlib.util import find_spec
from typing import TextIO

from ..system import progress
from ..system.exits import DONE, UsageError

_RED, _MAGENTA, _CYAN, _GREEN = "1;31", "1;35", "36", "1;32"
# Coloured parts of a message: error, warning, help, and the carets below source text.
_PAINTED = (
    (re.compile(r"(?<=: )error(?=: )"), _RED),
    (re.compile(r"(?<=: )warning(?=: )"), _MAGENTA),
    (re.compile(r"^ +help(?=: )", re.MULTILINE), _CYAN),
    (re.compile(r"(?<=^      \| )( *)(\^+)$", re.MULTILINE), _GREEN),
)


def coloured(stream: TextIO) -> bool:
    """Whether text to a stream is coloured: no if NO_COLOR is set, yes if FORCE_COLOR is set, else
    if it is a terminal. See https://no-color.org and https://force-color.org."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def findings(text: str) -> None:
    """Prints the text of errors and warnings to standard error, with colours."""
    if coloured(sys.stderr):
        for what, colour in _PAINTED:
            text = what.sub(lambda found, c=colour: f"\x1b[{c}m{found[0]}\x1b[0m", text)
    print(text, file=sys.stderr)


def refuse_both(options: argparse.Namespace, output: str | None) -> None:
    """Raises UsageError if the result and --json would both go to standard output."""
    if options.json and output == "-":
        raise UsageError("-o - and --json both write to standard output; take one of them")


def needs(module: str) -> None:
    """Raises ModuleNotFoundError if a package is missing. Called before long computations."""
    if find_spec(module) is None:
        raise ModuleNotFoundError(name=module)


def told(command: Callable[[argparse.Namespace], int | None], options: argparse.Namespace) -> int:
    """Runs a command; returns its exit code, DONE for None. -q hides messages on success, -v shows
    progress."""
    if options.verbose:
        with progress.watched():
            return command(options) or DONE
    if not options.quiet:
        return command(options) or DONE
    kept = io.StringIO()
    with contextlib.redirect_stderr(kept):
        code = command(options) or DONE
    if code != DONE:
        sys.stderr.write(kept.getvalue())
    return code
