"""What is said on standard error while something takes long: lines, a progress bar."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Protocol


class Show(Protocol):
    """What part of the work is done, from 0 to 1, and what is being done."""

    def __call__(self, part: float, text: str = "") -> None: ...


def unseen(part: float, text: str = "") -> None:
    """Progress where nobody looks."""


def took(began: float) -> str:
    """Since then by time.monotonic(), in words."""
    own = time.process_time() + sum(os.times()[2:4])
    return f"took {time.monotonic() - began:.3g} s, {own:.3g} s of the processor's"


def say(text: str) -> None:
    print(f"pkgen: {text}\n", end="", file=sys.stderr, flush=True)  # lines of threads stay whole


_watched: float | None = None  # when `-v` began to tell what is done


@contextmanager
def watched() -> Iterator[None]:
    """Within it, what is done is said, with its time."""
    global _watched
    _watched = time.monotonic()
    try:
        yield
    finally:
        _watched = None


def trace(text: str) -> None:
    """What has been done, for who has asked."""
    if _watched is not None:
        say(f"{time.monotonic() - _watched:7.3f} s  {text}")


@contextmanager
def progress(title: str) -> Iterator[Show | None]:
    """Yields what to call, or None where standard error is no terminal."""
    if not sys.stderr.isatty() or find_spec("rich") is None:
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress, Task, TimeElapsedColumn, TimeRemainingColumn
    from rich.text import Text

    class Left(TimeRemainingColumn):
        def render(self, task: Task) -> Text:
            return super().render(task) + Text(" left,")

    # The time goes on where a part takes long: a sign of life.
    columns = (*Progress.get_default_columns()[:-1], Left(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)

        def show(part: float, text: str = "") -> None:
            bar.update(task, completed=part, description=f"{title}: {text}" if text else title)

        yield show
