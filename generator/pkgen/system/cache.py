"""Where pkgen keeps what it need not make again: compiled runtimes and programs, parser tables.

What is kept is run as code. So an entry, a folder with the digests of its files, is used only where
all of it is this user's, nobody else can write it, and it is as it was made; else it is made again.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from .exits import BuildError
from .files import MARK, scratch, sweep
from .progress import say, trace

DIGESTS = "digests"
KEPT = 100  # entries of a kind, the newest, and any that were used in the last
RECENT = 3600.0  # seconds: another process may be about to run one
STALE = 600.0  # seconds, of a folder that nobody fills any more


def cache_directory() -> Path:
    """`PKGEN_CACHE`, else `$XDG_CACHE_HOME/pkgen`, else `~/.cache/pkgen`; it may not exist."""
    named = os.environ.get("PKGEN_CACHE")
    if named:
        return Path(named)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "pkgen"


def cached(kind: str, name: str, make: Callable[[Path], None]) -> Path:
    """The folder `name` among those of its kind; where it is missing, or not as it was made, `make`
    fills one, once for all processes that ask. Raises BuildError where none can be kept."""
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
    with suppress(OSError):  # a cache that is only read
        os.utime(folder)
    return folder


def _fill(folder: Path, make: Callable[[Path], None]) -> None:
    with scratch(folder.parent, ".new-") as new:
        make(new)
        (new / MARK).unlink(missing_ok=True)  # an entry is no scratch folder any more
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
    """Whether it is of that kind, this user's, and nobody else's to write."""
    known = path.lstat()
    mine = known.st_uid == os.geteuid() and not known.st_mode & 0o022
    return mine and kind(known.st_mode)


def _sound(folder: Path) -> bool:
    """Whether an entry is there, this user's, and as it was made."""
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
    """Another user who can replace an entry could put his own program between its check and its
    start. In a sticky folder, as /tmp is, he can not. No mode is changed: it may be on purpose."""
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
    """One process at a time."""
    while True:
        fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
        with suppress(OSError):  # a file system without locks
            try:
                fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if path.parent.name == "runtime":
                    say("waiting for another pkgen, which compiles the runtime")
                fcntl.flock(fd, fcntl.LOCK_EX)
        with suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(fd), path.stat()):
                break
        os.close(fd)  # who held it has removed it
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
        os.close(fd)


def _prune(kinds: Path) -> None:
    """Keep the newest entries; the rest can be made again."""
    found = []
    for path in kinds.iterdir():
        with suppress(FileNotFoundError):  # another process prunes as well
            found.append((path.stat().st_mtime, path))
    entries = sorted(entry for entry in found if not entry[1].name.startswith("."))
    for used, old in entries[:-KEPT]:
        if time.time() - used > RECENT:
            shutil.rmtree(old, ignore_errors=True)
