"""The two tasks of a sweep: make a shard, merge shards to a file. Any process may run them, even
twice at the same time: the output is the same.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from .job import Job
from .parts import merge
from .shards import Folder, Torn, head, part_is_whole, write_shard

Poll = Callable[[float], bool]


def shard(job: Job, folder: Folder, k: int, poll: Poll | None = None) -> dict:
    """Computes and writes a shard; returns its description. Raises OSError if writing fails."""
    first, count = folder.of_shard(k)
    batches = ((b.members, b.rows, b.report) for b in job.run(first, count, poll))
    return write_shard(folder, k, batches)


def part(job: Job, folder: Folder, k: int) -> dict | None:
    """Merges shards to a file of the data set, and removes shards that are completely merged.
    Returns None if a shard is damaged; that shard is removed, and will be made again."""
    try:
        said = merge(job, folder, k)
    except Torn as torn:
        for one in folder.shards_of(k):
            if one in torn.args or head(folder, one) is None:
                folder.shard_file(one).unlink(missing_ok=True)
        return None
    for one in folder.shards_of(k):
        if all(part_is_whole(folder, other, False) for other in folder.parts_of(one)):
            folder.shard_file(one).unlink(missing_ok=True)
    return said


def survey(folder: Folder, thorough: bool) -> tuple[list[int], list[int]]:
    """Returns the missing shards, and the files of the data set that are incomplete; removes
    damaged files. If `thorough`, hashes are checked."""
    parts = [k for k in folder.parts if not part_is_whole(folder, k, thorough)]
    for k in parts:
        for path in (folder.part_file(k), *folder.data_files(k)):
            with suppress(FileNotFoundError):
                path.unlink()
    wanted = sorted({k for part in parts for k in folder.shards_of(part)})
    missing = [k for k in wanted if head(folder, k) is None]
    return missing, parts
