"""Writes output files completely or not at all; makes scratch folders, which are always removed.

A file is written in the target's folder under another name and renamed at the end. The names of an
unfinished file and of its description end in `.partial`. Pipes, devices and `-` (standard output)
are written directly. Symbolic links are followed.
"""

from __future__ import annotations

import fcntl
import os
import re
import secrets
import shutil
import signal
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO

from .children import ENDS
from .exits import UsageError
from .progress import trace

STANDARD = Path("-")  # standard output
PARTIAL = ".partial"
ROWS = (".csv", ".npy")  # suffixes of files that contain rows of results
SCRATCH = "pkgen."
MARK = ".pkgen-scratch"  # Name of the marker file in scratch folders.


def partial(path: Path) -> Path:
    return path.with_name(path.name + PARTIAL)


def beside(path: Path) -> Path:
    """Returns the path of the JSON file that describes the file `path`: FILE.json for FILE."""
    return path.with_name(path.name + ".json")


def place(path: Path) -> Path | None:
    """Returns the path of a file with symbolic links followed, or None for a stream such as a pipe.
    Raises OSError or UsageError if the file cannot be written."""
    for _ in range(40):  # Linux follows at most 40 links.
        if not path.is_symlink():
            break
        to = os.readlink(path)
        if to.startswith(("/dev/fd/", "/dev/std", "/proc/")):  # This is a stream.
            return None
        path = path.parent / to
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return path
    if stat.S_ISDIR(mode):
        raise UsageError(f"{path}: this is a directory; give the name of a file")
    if stat.S_ISREG(mode) and not os.access(path, os.W_OK):
        raise PermissionError(13, "Permission denied", str(path))
    return path if stat.S_ISREG(mode) else None


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Blocks the signals ENDS within the context."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ENDS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Within the context, adds the file name to an OSError."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


def replace(
    contents: Mapping[Path, str | bytes], renamed: Mapping[Path, Path] | None = None
) -> None:
    """Writes `contents` (by path) and renames the keys of `renamed` to their values. If a file
    cannot be written, all files stay unchanged (but not streams)."""
    made: dict[Path, Path] = {}
    try:
        for path, content in contents.items():
            data = content.encode() if isinstance(content, str) else content
            if path == STANDARD:
                sys.stdout.flush()
                sys.stdout.buffer.write(data)
                sys.stdout.buffer.flush()
                continue
            end = place(path)
            if end is None:
                with _named(path):
                    path.write_bytes(data)
                continue
            # The name contains the number of the process, since two commands may write the same
            # file at the same time.
            scratch = end.with_name(f"{end.name}.{os.getpid()}{PARTIAL}")
            scratch.unlink(missing_ok=True)
            made[scratch] = end
            with _named(path), _opened(scratch, end, os.O_EXCL) as file:
                file.write(data)
        with uninterrupted():
            if renamed:  # An old FILE.json must never stand beside a new FILE.
                for end in made.values():
                    end.unlink(missing_ok=True)
            for scratch, end in ((renamed or {}) | made).items():
                os.replace(scratch, end)
        for path in contents:
            trace(f"wrote {path}")
    finally:
        for scratch in made:
            scratch.unlink(missing_ok=True)


def moved(files: Iterable[Path], directory: Path) -> list[Path]:
    """Copies files of a scratch folder to a directory; returns their new paths."""
    written = {directory / file.name: file.read_bytes() for file in files}
    directory.mkdir(parents=True, exist_ok=True)
    replace(written)
    return list(written)


def _opened(path: Path, end: Path, how: int = 0) -> IO[bytes]:
    """Opens the file `path` for writing. It gets the permissions of `end`, the file that it will
    replace."""
    fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | how, 0o666)
    with suppress(FileNotFoundError):
        os.fchmod(fd, stat.S_IMODE(end.stat().st_mode))
    return os.fdopen(fd, "r+b")


class Result:
    """A file that grows during a run, and FILE.json, which describes it.

    Until the run has finished, their names are FILE.partial and FILE.partial.json, and existing
    files stay unchanged. `kept` is set for runs with checkpoints: with "all", FILE.partial keeps
    even an incomplete last line if the run stops early; with "begun", the run also continues an
    existing FILE.partial."""

    def __init__(self, path: Path, description: str, kept: str = ""):
        self.path, self.end, self.kept = path, place(path), kept
        if self.end is None:
            self.file = open(path, "wb")  # noqa: SIM115
            return
        self.growing = partial(self.end)
        if kept == "begun" and not (self.growing.exists() and self.growing.stat().st_size):
            raise UsageError(f"{self.growing}: the rows so far are not there any more")
        self.file = _locked(self.growing, self.end)
        replace({beside(self.growing): description})
        if kept != "begun":
            self.file.truncate(0)

    def __enter__(self) -> Result:
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """If an error ends the block, keeps the rows and the description written at the start."""
        if kind is not None and self.end is not None:
            with suppress(OSError, ValueError):
                self._rows()

    def finish(self, description: str) -> None:
        """Closes the file, renames it to its final name and writes its description."""
        with _named(self.path):
            self.file.close()  # Raises OSError if the disk is full.
        done = {} if self.end is None else {self.growing: self.end}
        replace({beside(self.path): description}, done)
        if self.end is not None:
            beside(self.growing).unlink(missing_ok=True)

    def leave(self, description: str) -> Path | None:
        """Keeps an unfinished file, without an incomplete last line. Returns its path, or None if
        it has no rows and is removed."""
        if self.end is None:
            self.file.close()
            replace({beside(self.path): description})
            return self.path
        kept = self._rows()
        if kept:
            with suppress(OSError):  # If the disk is full, the description from the start stays.
                replace({beside(self.growing): description})
        with suppress(OSError):
            self.file.close()
        return self.growing if kept else None

    def _rows(self) -> bool:
        """Returns whether the file has rows; removes a file without rows."""
        self.file.flush()
        if self.kept:
            return True
        kept = cut(self.growing)
        if not kept:
            self.growing.unlink()
            beside(self.growing).unlink()
        return kept


def _locked(path: Path, end: Path) -> IO[bytes]:
    """Opens a file for writing and locks it. Raises UsageError if another command is writing it."""

    def busy() -> None:
        raise UsageError(f"{path}: another run is writing it")

    return locked(lambda: _opened(path, end), path, busy)


def locked(open_: Callable[[], IO[bytes]], path: Path, busy: Callable[[], None]) -> IO[bytes]:
    """Opens the file `path` by `open_` and locks it. If another process has the lock, calls `busy`
    and, if that returns, waits."""
    while True:
        file = open_()
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            busy()
            fcntl.flock(file, fcntl.LOCK_EX)
        except OSError:  # The file system has no locks.
            return file
        with suppress(FileNotFoundError):  # Another process may rename or remove the file.
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        file.close()


def cut(path: Path) -> bool:
    """Cuts off an incomplete last line of a table. Returns whether rows follow its header."""
    with open(path, "r+b") as file:
        if file.read(6) == b"\x93NUMPY":
            return True
        size = file.seek(0, os.SEEK_END)
        start = file.seek(max(0, size - (1 << 20)))
        tail = file.read()
        last = tail.rfind(b"\n")
        if 0 <= last < len(tail) - 1:
            file.truncate(start + last + 1)
        return start > 0 or tail.find(b"\n") < last


@contextmanager
def scratch(parent: Path | None = None, prefix: str = SCRATCH) -> Iterator[Path]:
    """Yields a new folder, removed at the end. It contains a marker file, and is locked while the
    process lives, so that other processes can remove the folders of killed processes."""
    if parent is None:
        parent = Path(tempfile.gettempdir())
        sweep(parent, prefix)
    path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
    try:
        lock = os.open(path, os.O_RDONLY)
        try:
            # In a file system without locks, no other process removes the folder.
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_EX)
            # The lock comes first: a folder with a mark and without a lock counts as abandoned.
            (path / MARK).write_text(f"{_marked(path.name)}{secrets.token_hex(16)}\n")
            yield path
        finally:
            os.close(lock)
    finally:
        shutil.rmtree(path, ignore_errors=True)


def _marked(name: str) -> str:
    return f"scratch folder of pkgen: {name} "


def _is_scratch(path: str, name: str) -> bool:
    """Whether a folder's marker file has the folder's name; a copied folder has another name."""
    fd = os.open(os.path.join(path, MARK), os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    with open(fd, "rb") as mark:
        if os.fstat(fd).st_uid != os.geteuid():
            return False
        token = mark.read(400).removeprefix(_marked(name).encode())
        return re.fullmatch(rb"[0-9a-f]{32}\n", token) is not None


@cache
def sweep(parent: Path, prefix: str, age: float = 0.0) -> None:
    """Removes scratch folders of processes that have ended; runs once per process and folder."""
    with suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            if not entry.name.startswith(prefix):
                continue
            with suppress(OSError):
                known = entry.stat(follow_symlinks=False)
                if known.st_uid != os.geteuid() or time.time() - known.st_mtime < age:
                    continue
                lock = os.open(entry.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    if _is_scratch(entry.path, entry.name):
                        shutil.rmtree(entry.path, ignore_errors=True)
                finally:
                    os.close(lock)
