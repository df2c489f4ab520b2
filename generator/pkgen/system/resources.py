"""Bounds on the time and memory that compiling a model may take; see limits.py."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager


class ResourcesExceeded(BaseException):
    """Compiling took more than its share; the text says what and how to allow more.

    It comes from a signal, wherever the program is; so libraries that catch every Exception, as
    lark does while it reads its tables, must not swallow it."""


@contextmanager
def bounded(cpu_seconds: float, memory_bytes: int) -> Iterator[None]:
    """Within it, more CPU time or address space raises ResourcesExceeded.

    The time is that of this process alone, counted by a timer signal; the memory is what is
    added to what the process has already. Works in the main thread of a process.
    """

    def out_of_time(_signal: int, _frame: object) -> None:
        raise ResourcesExceeded(
            f"compiling the model took more than {cpu_seconds:g} s of CPU time; "
            "if it is meant to be this large, allow more with --max-seconds"
        )

    old_handler = signal.signal(signal.SIGPROF, out_of_time)
    old_limits = resource.getrlimit(resource.RLIMIT_AS)
    ceiling = _address_space() + memory_bytes
    if old_limits[1] != resource.RLIM_INFINITY:
        ceiling = min(ceiling, old_limits[1])
    resource.setrlimit(resource.RLIMIT_AS, (ceiling, old_limits[1]))
    signal.setitimer(signal.ITIMER_PROF, cpu_seconds)
    try:
        yield
    except MemoryError:
        raise ResourcesExceeded(
            f"compiling the model took more than {memory_bytes >> 20} MiB of memory"
        ) from None
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, old_handler)
        resource.setrlimit(resource.RLIMIT_AS, old_limits)


def _address_space() -> int:
    """Bytes of address space in use, from /proc; where there is none, a guess that is ample."""
    try:
        with open("/proc/self/statm", encoding="ascii") as f:
            return int(f.read().split()[0]) * resource.getpagesize()
    except OSError:
        return 4 << 30
