"""The files of a sweep, in a folder or in an object store (s3://bucket/dir).

Paths are of pathlib or universal_pathlib, with the same methods for reading. This module has the
operations that differ: atomic writes, locks, free space. In a folder a file is written under a
temporary name and renamed; in an object store it is uploaded as one object.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from pkgen.system.exits import UsageError
from pkgen.system.files import PARTIAL, scratch

NOW = "now.json"
# An engine in an object store counts as stopped after this many seconds without a progress report.
SILENT = 60.0


def place(text: str) -> Path:
    """Returns the path of an address. Raises UsageError if an object store does not answer."""
    scheme, found, rest = text.partition("://")
    if not found:
        return Path(text)
    if scheme in ("file", "local"):
        return Path(rest)
    try:
        from upath import UPath
    except ImportError:
        raise UsageError(
            f"{text}: pip install universal-pathlib, and what fsspec needs for {scheme} "
            "(s3fs for s3, gcsfs for gs, adlfs for az)"
        ) from None
    try:
        # Listings of the object store are not cached, since other processes write to it.
        path = UPath(text, use_listings_cache=False)
        path.exists()
    except Exception as error:  # each kind of store has its own exceptions
        raise UsageError(f"{text}: {error or type(error).__name__}") from None
    return path


def is_folder(path: Path) -> bool:
    """Whether the path is in a file system, not in an object store."""
    return isinstance(path, Path)


def made(path: Path) -> None:
    """Makes a folder; object stores need none."""
    if is_folder(path):
        path.mkdir(parents=True, exist_ok=True)


def listed(folder: Path, pattern: str = "*") -> list[Path]:
    try:
        return sorted(folder.glob(pattern))
    except FileNotFoundError:
        return []


def cleaned(path: Path) -> None:
    """Removes partial files of killed processes; no other process may be writing."""
    for folder in path.iterdir() if is_folder(path) else ():
        if folder.is_dir() and not folder.is_symlink():
            for one in folder.glob(f"*{PARTIAL}"):
                one.unlink(missing_ok=True)


@contextmanager
def written(path: Path) -> Iterator[IO[bytes]]:
    """Opens a file for writing, which appears at `path` when it is complete. Two processes may
    write the same content at once."""
    try:
        with (_renamed if is_folder(path) else _put)(path) as file:
            yield file
    except OSError as error:
        error.filename = str(path)
        raise


@contextmanager
def _renamed(path: Path) -> Iterator[IO[bytes]]:
    new = path.with_name(f"{path.name}.{os.uname().nodename}.{os.getpid()}{PARTIAL}")
    try:
        with open(new, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, path)
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


@contextmanager
def _put(path) -> Iterator[IO[bytes]]:
    with scratch() as folder:
        with open(folder / path.name, "wb") as file:
            yield file
        try:
            path.fs.put_file(str(folder / path.name), path.path)
        except OSError as error:
            raise OSError(error.errno or errno.EIO, str(error)) from None
        except Exception as error:  # each kind of store has its own exceptions
            raise OSError(errno.EIO, str(error)) from None


def write_json(path: Path, content: object) -> None:
    with written(path) as file:
        file.write(json.dumps(content, indent=1).encode() + b"\n")


def read_json(path: Path) -> dict | None:
    """Returns the content of a JSON file; None if it is missing or invalid."""
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def of_kinds(path: Path, found: dict, kinds: Mapping[str, type | tuple[type, ...]]) -> dict:
    """Checks that the value of each key is of its type; returns `found`. Raises UsageError."""
    for key, kind in kinds.items():
        value = found.get(key)
        if not isinstance(value, kind) or (kind is int and not 0 < value < 1 << 63):
            raise UsageError(f"{path}: it is not as it was written: '{key}'")
    return found


def free_bytes(path: Path) -> int | None:
    """Returns the free bytes of the disk of a path; None for an object store."""
    if not is_folder(path):
        return None
    there = next(p for p in (path.absolute(), *path.absolute().parents) if p.is_dir())
    return shutil.disk_usage(there).free


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Locks the sweep for one engine. Raises UsageError if another engine has the lock. An object
    store has no locks; if two engines run a sweep in an object store, each does all of the work."""
    if not is_folder(path):
        try:
            yield
        finally:
            with suppress(OSError):
                (path / NOW).unlink(missing_ok=True)
        return
    fd = os.open(path / "lock", os.O_RDWR | os.O_CREAT, 0o666)
    try:
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UsageError(f"{path}: another pkgen sweeps here") from None
        except OSError:  # the file system does not support locks
            pass
        yield
    finally:
        os.close(fd)


def at_work(path: Path) -> bool:
    if not is_folder(path):
        at = (read_json(path / NOW) or {}).get("at")
        return isinstance(at, int | float) and time.time() - at < SILENT
    try:
        fd = os.open(path / "lock", os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(fd, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(fd)
    return False
