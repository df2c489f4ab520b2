"""The cache of compiled runtimes and programs, and of parser tables.

Entries are run as code. An entry is a folder with the digests of its files. It is used only if it
belongs to this user, no one else can write it, and the digests match; otherwise it is made
again.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from .exits import BuildError
from .files import MARK, locked, scratch, sweep
from .progress import say, trace

DIGESTS = "digests"
KEPT = 100  # Number of entries of each kind that are kept.
RECENT = 3600.0  # Entries used within this many seconds are kept as well.
STALE = 600.0  # Unfinished folders older than this many seconds are removed.


def cache_directory() -> Path:
    """Returns $PKGEN_CACHE, else $XDG_CACHE_HOME/pkgen, else ~/.cache/pkgen; it may not exist."""
    named = os.environ.get("PKGEN_CACHE")
    if named:
        return Path(named)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "pkgen"


def cached(kind: str, name: str, make: Callable[[Path], None]) -> Path:
    """Returns the folder of the entry `name`. If it is missing or damaged, one of the concurrent
    processes calls `make` to fill it. Raises BuildError if the cache cannot be written."""
    kinds = cache_directory() / kind
    folder = kinds / name
    try:
        if not _sound(folder):
            kinds.parent.parent.mkdir(parents=True, exist_ok=True)
            for one in (kinds.parent, kinds):
                one.mkdir(mode=0o700, exist_ok=True)
                _refuse_foreign(one)
            with _alone(kinds / f".lock-{name}"):
                if not _sound(folder):
                    _fill(folder, make)
                    trace(f"kept {folder}")
            sweep(kinds, ".new-", STALE)
            _prune(kinds)
    except OSError as error:
        raise BuildError(
            f"cannot write to the cache {kinds}: {error.strerror}; "
            "name another directory with the environment variable PKGEN_CACHE"
        ) from None
    with suppress(OSError):  # The cache may be read-only.
        os.utime(folder)
    return folder


def _fill(folder: Path, make: Callable[[Path], None]) -> None:
    with scratch(folder.parent, ".new-") as new:
        make(new)
        # The marker is removed, since other processes may remove folders that have one.
        (new / MARK).unlink(missing_ok=True)
        files = sorted(path for path in new.iterdir() if path.is_file())
        lines = [f"{folder.name}", *(f"{_digest(path)} {path.name}" for path in files)]
        (new / DIGESTS).write_text("\n".join(lines), encoding="utf-8")
        for path in (*files, new / DIGESTS):
            path.chmod(stat.S_IMODE(path.stat().st_mode) & ~0o022)
        if folder.is_symlink() or folder.is_file():
            folder.unlink()
        shutil.rmtree(folder, ignore_errors=True)
        os.rename(new, folder)


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _own(path: Path, kind: Callable[[int], bool]) -> bool:
    """Whether the function `kind`, such as stat.S_ISDIR, accepts the mode of a path, and whether
    only this user owns and can write the path."""
    known = path.lstat()
    mine = known.st_uid == os.geteuid() and not known.st_mode & 0o022
    return mine and kind(known.st_mode)


def _sound(folder: Path) -> bool:
    """Whether an entry exists, belongs to this user only, and matches its digests."""
    try:
        if not (_own(folder, stat.S_ISDIR) and _own(folder / DIGESTS, stat.S_ISREG)):
            return False
        name, *files = (folder / DIGESTS).read_text(encoding="utf-8").split("\n")
        for line in files:
            digest, _, file = line.partition(" ")
            if not _own(folder / file, stat.S_ISREG) or _digest(folder / file) != digest:
                return False
    except (OSError, ValueError):
        return False
    return name == folder.name


def _refuse_foreign(folder: Path) -> None:
    """Raises BuildError if another user could replace an entry after it is checked and before it is
    used. In a sticky folder, such as /tmp, that is impossible. The folder's mode is not changed."""
    known = folder.stat()
    why = ""
    if known.st_uid != os.geteuid():
        why = "belongs to another user"
    elif known.st_mode & 0o022 and not known.st_mode & stat.S_ISVTX:
        why = "can be written by other users: chmod go-w"
    if why:
        name = "name another directory with the environment variable PKGEN_CACHE"
        raise BuildError(f"the cache {folder} {why}; {name}")


@contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Holds an exclusive lock, the file `path`."""

    def open_() -> IO[bytes]:
        return os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600), "r+b")

    def busy() -> None:
        if path.parent.name == "runtime":
            say("waiting for another pkgen, which compiles the runtime")

    with locked(open_, path, busy):
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def _prune(kinds: Path) -> None:
    """Removes entries, except the KEPT newest and those used within RECENT."""
    found = []
    for path in kinds.iterdir():
        with suppress(FileNotFoundError):  # Another process may remove entries too.
            found.append((path.stat().st_mtime, path))
    entries = sorted(entry for entry in found if not entry[1].name.startswith("."))
    for used, old in entries[:-KEPT]:
        if time.time() - used > RECENT:
            shutil.rmtree(old, ignore_errors=True)
