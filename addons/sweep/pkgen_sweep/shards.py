"""A sweep's folder: its plan, the completed shards, the data set, and the failures.

    plan.json    description of the sweep; written once
    model.lag, plan.toml
    shards/K     S members from number K*S on; removed when all of them are in the data set
    data/        the data set, a row per member, in Parquet: part-K.parquet has P members from
                 number K*P on; level-L-part-K.parquet has members of level L of a refined grid
    rows/        if the plan keeps rows over time: these rows, in files with the names of data/
    parts/K      hashes of the files of part K, and the failures of its members
    failed/K     number of attempts at shard K, and why it failed
    levels.json  number of members of each level that has been begun
    now.json     the running engine and its progress

A file appears under its name only when it is complete (`store.py`). A shard has blocks of numbers
(little-endian doubles), a line of JSON that describes them, and the SHA-256 of both.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pkgen.record import record
from pkgen.system.exits import UsageError
from pkgen.system.files import PARTIAL
from pkgen.version import __version__

from . import store
from .store import of_kinds, read_json, write_json, written

if TYPE_CHECKING:
    import numpy

# Bytes read from the end of a shard for its description; usually the description is shorter.
TAIL = 1 << 16
DIGEST = 65  # Bytes of a shard's last line: its SHA-256 in hexadecimal.
PLAN, DATA = "plan.json", "data"
_FOLDERS = ("shards", "parts", "failed", DATA)


KINDS = {
    **dict.fromkeys(("digest", "name", "model", "file"), str),
    **dict.fromkeys(("members", "shard", "part"), int),
    "size": list,
    "rows": bool,
}


def known(path: Path) -> dict | None:
    """Returns plan.json of a sweep; None if it is missing. Raises UsageError."""
    found = read_json(path / PLAN)
    if found is None or found.get("pkgen", __version__) != __version__:
        return found
    of_kinds(path / PLAN, found, KINDS)
    if not all(isinstance(x, str) for x in found["size"]):
        raise UsageError(f"{path / PLAN}: it is not as it was written: 'size'")
    return found


def is_sweep(path: Path) -> bool:
    return "digest" in (read_json(path / PLAN) or {})


@record
class Folder:
    """The folder of a sweep, and the division of its members into shards and files ("parts")."""

    path: Path
    digest: str
    members: int
    shard: int  # members per shard
    part: int
    rows: bool
    level: int = 0  # level of the refined grid; names of files contain it

    def _name(self, k: int, digits: int) -> str:
        return f"{f'level-{self.level}-' if self.level else ''}{k:0{digits}d}"

    @property
    def shards(self) -> range:
        return range(-(-self.members // self.shard))

    @property
    def parts(self) -> range:
        return range(-(-self.members // self.part))

    def of_shard(self, k: int) -> tuple[int, int]:
        """Returns a shard's first member and its number of members."""
        return k * self.shard, min(self.shard, self.members - k * self.shard)

    def of_part(self, k: int) -> tuple[int, int]:
        return k * self.part, min(self.part, self.members - k * self.part)

    def shards_of(self, part: int) -> range:
        first, count = self.of_part(part)
        return range(first // self.shard, (first + count - 1) // self.shard + 1)

    def parts_of(self, shard: int) -> range:
        first, count = self.of_shard(shard)
        return range(first // self.part, (first + count - 1) // self.part + 1)

    def shard_file(self, k: int) -> Path:
        return self.path / "shards" / self._name(k, 8)

    def failed_file(self, k: int) -> Path:
        return self.path / "failed" / self._name(k, 8)

    def part_file(self, k: int) -> Path:
        return self.path / "parts" / self._name(k, 6)

    def data_files(self, k: int) -> list[Path]:
        """Returns the files of a part of the data set: two if rows are kept."""
        folders = (DATA, "rows") if self.rows else (DATA,)
        name = f"level-{self.level}-part" if self.level else "part"
        return [self.path / folder / f"{name}-{k:06d}.parquet" for folder in folders]

    def made(self) -> None:
        for name in (*_FOLDERS, *(["rows"] if self.rows else [])):
            store.made(self.path / name)

    def cleaned(self) -> None:
        """Removes partial files of killed processes; no other process may be writing."""
        store.cleaned(self.path)


def shard_head(folder: Folder, k: int) -> dict:
    """Returns the identity of a shard, which is part of its description."""
    first, count = folder.of_shard(k)
    at = {"level": folder.level, "shard": k}
    return {"sweep": folder.digest, **at, "first": first, "count": count}


def write_shard(
    folder: Folder, k: int, blocks: Iterable[tuple[numpy.ndarray, numpy.ndarray | None, dict]]
) -> dict:
    """Writes shard k from blocks (members, rows, report of the run), and returns its description.
    The C program runtime/program/shard.c writes the same format."""
    digest = hashlib.sha256()
    said = {**shard_head(folder, k), "blocks": [], "reports": []}
    with written(folder.shard_file(k)) as file:

        def write(data: bytes) -> None:
            digest.update(data)
            file.write(data)

        for members, rows, report in blocks:
            for numbers in (members, rows):
                if numbers is not None:
                    write(numbers.astype("<f8", copy=False).tobytes())
            said["blocks"].append((*members.shape, *(rows.shape if rows is not None else (0, 0))))
            said["reports"].append({"failures": report["failures"]})
        write(b"\n" + json.dumps(said).encode() + b"\n")
        file.write(digest.hexdigest().encode() + b"\n")
    return said


def failures_of(said: dict) -> list[dict]:
    """Returns the failures of a shard's members, one entry per status."""
    found: dict[str, dict] = {}
    for report in said["reports"]:
        added(found, report["failures"])
    return list(found.values())


def added(to: dict[str, dict], failures: Iterable[dict]) -> None:
    """Adds failures to `to`, one entry per status: their number, and the first failed member."""
    for one in failures:
        known = to.setdefault(one["status"], {**one, "count": 0})
        count = known["count"] + one["count"]
        if one["member"] < known["member"]:
            known.update(one)
        known["count"] = count


def head(folder: Folder, k: int) -> dict | None:
    """Returns a shard's description; None if it is missing, incomplete or another sweep's."""
    path = folder.shard_file(k)
    try:
        with path.open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - TAIL))
            tail = file.read()
            if tail[:-DIGEST].count(b"\n") < 2:  # the description is longer than TAIL
                file.seek(0)
                tail = file.read()
        line = tail[: -DIGEST - 1].rpartition(b"\n")[2]
        said = json.loads(line)
        numbers = sum(8 * (a * b + c * d) for a, b, c, d in said["blocks"])
        whole = size == numbers + len(line) + 2 + DIGEST
        ours = all(said[key] == x for key, x in shard_head(folder, k).items())
        failures_of(said)
        return said if ours and whole else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class Torn(Exception):
    """A shard is damaged: it does not match its hash. The argument is the shard's number."""


def blocks(folder: Folder, k: int) -> Iterator[tuple[numpy.ndarray, numpy.ndarray | None]]:
    """Yields the blocks of a shard. Raises Torn if it is damaged; a wrong hash is found only at the
    end, and then all results from the blocks must be discarded."""
    import numpy

    said = head(folder, k)
    if said is None:
        raise Torn(k)
    digest = hashlib.sha256()
    with folder.shard_file(k).open("rb") as file:
        for a, b, c, d in said["blocks"]:
            found = []
            for shape in ((a, b), (c, d)):
                data = file.read(8 * shape[0] * shape[1])
                digest.update(data)
                if len(data) != 8 * shape[0] * shape[1]:
                    raise Torn(k)
                found.append(numpy.frombuffer(data, "<f8").reshape(shape))
            yield found[0], found[1] if d else None
        rest = file.read()
    digest.update(rest[:-DIGEST])
    if digest.hexdigest().encode() + b"\n" != rest[-DIGEST:]:
        raise Torn(k)


def digest_of(path: Path) -> str | None:
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while data := file.read(1 << 20):
                digest.update(data)
    except OSError:
        return None
    return digest.hexdigest()


def part_is_whole(folder: Folder, k: int, thorough: bool) -> bool:
    """Whether file `k` of the data set is complete; if `thorough`, its hashes are checked."""
    said = read_json(folder.part_file(k))
    files = folder.data_files(k)
    if said is None or said.get("sweep") != folder.digest:
        return False
    sums = said.get("sha256")
    if not isinstance(sums, list) or len(sums) != len(files):
        return False
    if not thorough:
        return all(path.is_file() for path in files)
    return all(digest_of(path) == found for path, found in zip(files, sums, strict=True))


def failed_shard(folder: Folder, k: int, why: str) -> int:
    """Records a failed attempt at a shard; returns the number of attempts."""
    known = read_json(folder.failed_file(k)) or {}
    tried = int(known.get("tried", 0)) + 1
    write_json(folder.failed_file(k), {"shard": k, "tried": tried, "why": why})
    return tried


def foreign(path: Path, own: str) -> UsageError | None:
    """Returns an error if the folder has files that no sweep writes; `own` is the name of the
    model's file. Files of a sweep that was killed before it wrote plan.json are no error."""
    if path.exists() and not path.is_dir():
        return UsageError(f"-o {path}: it is a file; a sweep needs a folder")
    ours = {*_FOLDERS, "rows", "plan.toml", own}
    for one in path.iterdir() if path.is_dir() else ():
        if one.name not in ours and not one.name.endswith(PARTIAL):
            return UsageError(f"-o {path}: it has {one.name} in it, and is no sweep's")
    return None
