"""Limits on the CPU time and memory that compiling a model may use; see limits.py."""

from __future__ import annotations

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager


class ResourcesExceeded(BaseException):
    """Compiling exceeded a limit; the text names the limit and how to raise it.

    A signal handler raises it anywhere in the program. It is a BaseException, since libraries may
    catch every Exception, as lark does while it reads its tables."""


@contextmanager
def bounded(cpu_seconds: float, memory_bytes: int) -> Iterator[None]:
    """Within the context, using more CPU time or memory raises ResourcesExceeded.

    The time is that of this process without children, measured by a timer signal. The memory is
    address space beyond that already in use. The context works in the main thread only.
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
    """Returns the address space in use, in bytes, from /proc; 4 GiB if there is no /proc."""
    try:
        with open("/proc/self/statm", encoding="ascii") as f:
            return int(f.read().split()[0]) * resource.getpagesize()
    except OSError:
        return 4 << 30
