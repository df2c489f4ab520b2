"""Progress messages and a progress bar, on standard error."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Protocol


class Show(Protocol):
    """Shows the fraction `part` of the work that is done, and a text about the current step."""

    def __call__(self, part: float, text: str = "") -> None: ...


def unseen(part: float, text: str = "") -> None:
    """Ignores progress."""


def took(began: float) -> str:
    """Returns a text with the time elapsed since `began`, a value of time.monotonic(), and with the
    CPU time used by the process and its children."""
    own = time.process_time() + sum(os.times()[2:4])
    return f"took {time.monotonic() - began:.3g} s, {own:.3g} s of the processor's"


def say(text: str) -> None:
    # The text contains the line break, so that lines of several threads do not mix.
    print(f"pkgen: {text}\n", end="", file=sys.stderr, flush=True)


_watched: float | None = None  # Start time for the messages of the option -v.


@contextmanager
def watched() -> Iterator[None]:
    """Within the context, trace() prints messages, each with the time since the start."""
    global _watched
    _watched = time.monotonic()
    try:
        yield
    finally:
        _watched = None


def trace(text: str) -> None:
    """Prints a message if the context watched() is active."""
    if _watched is not None:
        say(f"{time.monotonic() - _watched:7.3f} s  {text}")


@contextmanager
def progress(title: str) -> Iterator[Show | None]:
    """Yields a function that shows progress, or None if standard error is not a terminal."""
    if not sys.stderr.isatty() or find_spec("rich") is None:
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress, Task, TimeElapsedColumn, TimeRemainingColumn
    from rich.text import Text

    class Left(TimeRemainingColumn):
        def render(self, task: Task) -> Text:
            return super().render(task) + Text(" left,")

    # The elapsed time changes also during long steps, which shows that the program is alive.
    columns = (*Progress.get_default_columns()[:-1], Left(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)

        def show(part: float, text: str = "") -> None:
            bar.update(task, completed=part, description=f"{title}: {text}" if text else title)

        yield show
