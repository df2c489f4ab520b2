"""Writes the files of the data set, in Parquet, from shards.

Files are divided by member numbers and row groups by rows, so that the bytes do not depend on the
shards. A missing number (of a failed member, or the time of an event that did not occur) is null.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING

import numpy as np

from pkgen.equations import Quantity
from pkgen.run.header import STATUSES
from pkgen.system.exits import UsageError
from pkgen.version import __version__

from .job import AT_START, Job
from .shards import Folder, added, blocks, digest_of, failures_of, head
from .store import write_json, written

if TYPE_CHECKING:
    import pyarrow

GROUP = 1 << 16  # rows of a row group
STATUS = "status"
DRAWN = "drawn by the plan"


def arrow():
    """Imports pyarrow with its Parquet module. Raises UsageError if it is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise UsageError("a sweep's data set needs pyarrow: pip install pyarrow scipy") from None
    return pyarrow


def names(job: Job) -> list[Quantity]:
    """Returns the columns of the data set, which has one row per member."""
    starts = []
    for column in job.starts.columns:
        at_start = column.name + AT_START if column.kind in "qv" else column.name
        starts.append(Quantity(at_start, column.unit, DRAWN))
    ended = Quantity(STATUS, "", "how the member ended")
    time = Quantity("t", job.time_unit, "its last valid time")
    return [job.counts, *starts, ended, time, *job.kept.numbers]


def schema(job: Job, columns: list[Quantity]) -> pyarrow.Schema:
    pa = arrow()
    kinds = {"member": pa.int64(), STATUS: pa.dictionary(pa.int8(), pa.string())}
    fields = []
    for c in columns:
        about = {"unit": c.unit, "description": c.description}
        about = {key: value for key, value in about.items() if value}
        fields.append(pa.field(c.name, kinds.get(c.name, pa.float64()), metadata=about or None))
    units = {c.name: c.unit for c in columns if c.unit}
    of = {"pkgen": __version__, "model": job.name, "sweep": job.digest, "units": units}
    return pa.schema(fields, metadata={"pkgen": json.dumps(of)})


class _Writer:
    """Writes a Parquet file in row groups of GROUP rows, however the rows are divided into calls of
    add()."""

    def __init__(self, file, job: Job, columns: list[Quantity]):
        pa = arrow()
        self.pa, self.schema = pa, schema(job, columns)
        self.writer = pa.parquet.ParquetWriter(
            file, self.schema, compression="zstd", compression_level=1, use_dictionary=[STATUS]
        )
        self.waiting: list[list[np.ndarray]] = []
        self.count = 0

    def add(self, columns: list[np.ndarray]) -> None:
        while len(columns[0]):
            some = GROUP - self.count
            self.waiting.append([x[:some] for x in columns])
            self.count += len(self.waiting[-1][0])
            columns = [x[some:] for x in columns]
            if self.count == GROUP:
                self.flush()

    def flush(self) -> None:
        if not self.count:
            return
        pieces = zip(*self.waiting, strict=True)
        columns = [np.concatenate(each) if len(each) > 1 else each[0] for each in pieces]
        made = [self._array(f, x) for f, x in zip(self.schema, columns, strict=True)]
        table = self.pa.Table.from_arrays(made, schema=self.schema)
        self.writer.write_table(table, row_group_size=GROUP)
        self.waiting, self.count = [], 0

    def __enter__(self) -> _Writer:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                self.flush()
            self.writer.close()
        finally:
            self.writer.is_open = False  # prevents a second close() in the destructor

    def _array(self, field: pyarrow.Field, x: np.ndarray) -> pyarrow.Array:
        if self.pa.types.is_dictionary(field.type):
            codes = sorted(STATUSES, reverse=True)
            names = self.pa.array([STATUSES[code] for code in codes])
            return self.pa.DictionaryArray.from_arrays(codes[0] - x.astype(np.int8), names)
        if self.pa.types.is_integer(field.type):
            return self.pa.array(x.astype(np.int64))
        return self.pa.array(x, mask=np.isnan(x))


def merge(job: Job, folder: Folder, part: int) -> dict:
    """Writes a file of the data set, and its description, from shards. Raises Torn if a shard is
    damaged; then nothing is written."""
    first, count = folder.of_part(part)
    failures: dict[str, dict] = {}
    with ExitStack() as stack:
        files = [stack.enter_context(written(path)) for path in folder.data_files(part)]
        data = stack.enter_context(_Writer(files[0], job, names(job)))
        rows = None
        if folder.rows:
            rows = stack.enter_context(_Writer(files[1], job, [job.counts, *job.kept.rows]))
        for begin, members, moved in _members(job, folder, part):
            starts = job.starts.values(begin, len(members)).T
            numbers = np.arange(begin + 1, begin + 1 + len(members)) + job.before
            data.add([numbers, *starts, *members.T])
            if rows is not None and len(moved):
                rows.add(list(moved.T))
            _failed(members, job.before + begin, failures)
    heads = [h for k in folder.shards_of(part) if (h := head(folder, k))]
    for one in (one for h in heads for one in failures_of(h)):
        if one["status"] in failures and failures[one["status"]]["member"] == one["member"]:
            failures[one["status"]]["reason"] = one["reason"]
    said = {
        "sweep": folder.digest,
        "part": part,
        "first": first,
        "count": count,
        "failures": list(failures.values()),
        "sha256": [digest_of(path) for path in folder.data_files(part)],
    }
    write_json(folder.part_file(part), said)
    return said


def _failed(members: np.ndarray, begin: int, failures: dict[str, dict]) -> None:
    ended = members[:, 0]
    for code in np.unique(ended[ended < 0]):
        which = np.flatnonzero(ended == code)
        name = STATUSES[int(code)]
        one = {"status": name, "count": len(which), "member": begin + 1 + int(which[0])}
        added(failures, [{**one, "t": float(members[which[0], 1]), "reason": ""}])


def _members(job: Job, folder: Folder, part: int) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yields blocks (index of the first member, members, rows) of a file of the data set, from
    shards. A block has no members of other files."""
    first, count = folder.of_part(part)
    for k in folder.shards_of(part):
        at = folder.of_shard(k)[0]
        for members, moved in blocks(folder, k):
            lo, hi = max(first, at), min(first + count, at + len(members))
            if lo < hi:
                rows = np.empty((0, 0))
                if moved is not None:
                    ends = [job.before + lo + 1, job.before + hi + 1]
                    a, b = np.searchsorted(moved[:, 0], ends)
                    rows = moved[a:b]
                yield lo, members[lo - at : hi - at], rows
            at += len(members)


def classes(job: Job, folder: Folder) -> np.ndarray:
    """Returns the class of each member of a level of the grid. The grid is refined between members
    of different classes."""
    pa, found = arrow(), []
    for k in folder.parts:
        with folder.data_files(k)[0].open("rb") as file:
            table = pa.parquet.read_table(file, columns=[job.refine.column])
        x = table.column(0).combine_chunks()
        if pa.types.is_dictionary(x.type):
            x = x.indices
        numbers = x.to_numpy(zero_copy_only=False).astype(float)
        found.append(np.where(np.isnan(numbers), -1, numbers).astype(np.int64))
    return np.concatenate(found)
