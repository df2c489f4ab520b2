"""Child processes of pkgen, none of which outlives it.

All are in one process group, led by a shell that waits at a pipe which only pkgen holds open.
However pkgen ends, even by SIGKILL, the system closes the pipe, and the shell kills the group. The
group includes children of gcc, which a signal to gcc alone (PR_SET_PDEATHSIG) would not reach.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from .exits import INTERRUPTED, NumericsFailed

# Ctrl-C in the terminal signals pkgen's own process group, not the group of the children.
KEEPER = "read nothing; kill -KILL 0"
ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# Signals before a time limit in batch systems: Slurm --signal, Grid Engine -notify, LSF limits.
ENDS += (signal.SIGUSR1, signal.SIGUSR2, signal.SIGXCPU)

_keeper: subprocess.Popen[bytes] | None = None
_ended = False  # If True, no new process may start.
_starting = threading.Lock()
_stops: list[Callable[[int], None]] = []


def _joined(group: int) -> dict[str, object]:
    if sys.version_info >= (3, 11):
        return {"process_group": group}
    return {"preexec_fn": lambda: os.setpgid(0, group)}


def group() -> dict[str, object]:
    """Returns the arguments of subprocess.Popen that put a process into the group."""
    global _keeper
    with _starting:
        if _ended:
            raise NumericsFailed("interrupted")
        if _keeper is None or _keeper.poll() is not None:
            if _keeper and _keeper.stdin:
                _keeper.stdin.close()
            none = subprocess.DEVNULL
            _keeper = subprocess.Popen(
                ["/bin/sh", "-c", KEEPER],
                stdin=subprocess.PIPE,
                stdout=none,
                stderr=none,
                **_joined(0),
            )
        return _joined(_keeper.pid)


def on_end(stop: Callable[[int], None]) -> None:
    """Registers the function `stop`. It is called with 1 when all work must stop, and with 0 when
    work may start again."""
    _stops.append(stop)


def kill() -> None:
    """Kills all child processes and calls the registered functions."""
    global _ended
    _ended = True
    for stop in _stops:
        stop(1)
    if _keeper is not None and _keeper.poll() is None:
        with suppress(ProcessLookupError):
            os.killpg(_keeper.pid, signal.SIGKILL)


def ended() -> bool:
    """Whether kill() was called, so that no new work must start."""
    return _ended


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Within the context, the signals ENDS kill the child processes and raise KeyboardInterrupt. A
    signal that was ignored before, as by nohup, stays ignored. SIGTSTP (Ctrl-Z) suspends pkgen and
    its child processes."""
    global _ended
    _ended = False
    for stop in _stops:
        stop(0)

    with _handled({**dict.fromkeys(ENDS, _end), signal.SIGTSTP: _stop}):
        yield


def _end(_signal: int, _frame: object) -> None:
    kill()
    raise KeyboardInterrupt


def finishing() -> None:
    """Ignores the signals ENDS from now on. A command calls this when all its results are
    written."""
    if threading.current_thread() is threading.main_thread():
        for number in ENDS:
            if signal.getsignal(number) is _end:
                signal.signal(number, signal.SIG_IGN)


@contextmanager
def _handled(handlers: dict[int, Callable[[int, object], None]]) -> Iterator[None]:
    left = {number: signal.getsignal(number) for number in handlers}
    late = None
    try:
        for number, handler in handlers.items():
            if left[number] != signal.SIG_IGN:
                signal.signal(number, handler)
        yield
    finally:
        while left:
            try:
                for number in [*left]:
                    signal.signal(number, left[number])
                    del left[number]
            except BaseException as error:  # The error is raised when all handlers are restored.
                late = error
        if late is not None:
            raise late


@contextmanager
def postponed(raised: list) -> Iterator[None]:
    """Within the context, an exception of a signal handler is appended to `raised` and does not
    interrupt the block. Otherwise it might interrupt C code that uses the block's memory, or
    Thread.join."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def noting(handler: Callable[[int, object], object]) -> Callable[[int, object], None]:
        def note(number: int, frame: object) -> None:
            try:
                handler(number, frame)
            except BaseException as error:
                raised.append(error)

        return note

    numbers = signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP}
    handlers = {n: h for n in numbers if callable(h := signal.getsignal(n))}
    with _handled({n: noting(h) for n, h in handlers.items() if h is not _stop}):
        yield


def _stop(_signal: int, _frame: object) -> None:
    for number, own in ((signal.SIGSTOP, True), (signal.SIGCONT, False)):
        if _keeper is not None and _keeper.poll() is None:
            os.killpg(_keeper.pid, number)
        if own:
            os.kill(os.getpid(), number)  # SIGSTOP suspends this process here, until SIGCONT.


@contextmanager
def stopping() -> Iterator[Callable[[], bool]]:
    """Yields a function that returns whether one of the signals ENDS has arrived. The run should
    then stop and keep its rows. A second signal ends pkgen at once. In threads other than the main
    thread the function returns False."""
    said: list[int] = []

    def note(number: int, _frame: object) -> None:
        if said:
            kill()
            os._exit(INTERRUPTED)
        said.append(number)

    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    with _handled(dict.fromkeys(ENDS, note)):
        yield lambda: bool(said)
