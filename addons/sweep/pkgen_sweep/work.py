"""The two tasks of a sweep, which an engine gives to any process: to make a shard, to merge a part.
Each may be done twice, and by two at once: both write the same.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from .job import Job
from .parts import merge
from .shards import Folder, Torn, head, part_is_whole, write_shard

Poll = Callable[[float], bool]


def shard(job: Job, folder: Folder, k: int, poll: Poll | None = None) -> dict:
    """What the shard says of itself. Raises OSError where it cannot be written."""
    first, count = folder.of_shard(k)
    batches = ((b.members, b.rows, b.report) for b in job.run(first, count, poll))
    return write_shard(folder, k, batches)


def part(job: Job, folder: Folder, k: int) -> dict | None:
    """Its shards go once all that they hold is in the data set. None: a shard is not as it was
    written, and is gone, to be made again."""
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
    """The shards that are missing and the parts, what is torn being removed; if `thorough`, by each
    byte of the data set."""
    parts = [k for k in folder.parts if not part_is_whole(folder, k, thorough)]
    for k in parts:
        for path in (folder.part_file(k), *folder.data_files(k)):
            with suppress(FileNotFoundError):
                path.unlink()
    wanted = sorted({k for part in parts for k in folder.shards_of(part)})
    missing = [k for k in wanted if head(folder, k) is None]
    return missing, parts
