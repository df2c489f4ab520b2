"""Bounds on the time and memory that compiling a model may take; see limits.py."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager


class ResourcesExceeded(BaseException):
    """Compiling exceeded its limits; the text says which limit, and how to allow more.

    A signal handler raises it anywhere in the program. It is a BaseException, since libraries may
    catch every Exception, as lark does while it reads its tables."""


@contextmanager
def bounded(cpu_seconds: float, memory_bytes: int) -> Iterator[None]:
    """Within it, use of more CPU time or address space raises ResourcesExceeded.

    The time is that of this process alone, measured by a timer signal; the memory is an addition
    to the current address space. It works in the main thread only.
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
    """Returns the bytes of address space in use, from /proc; without /proc, a generous guess."""
    try:
        with open("/proc/self/statm", encoding="ascii") as f:
            return int(f.read().split()[0]) * resource.getpagesize()
    except OSError:
        return 4 << 30
