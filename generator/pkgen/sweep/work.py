"""The two tasks of a sweep, which an engine gives to any process: to make a shard, to merge a part.
Each may be done twice, and by two at once: both write the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress

from .job import Job
from .parts import merge
from .shards import Folder, Torn, head, part_is_whole, write_shard

Poll = Callable[[float], bool]


def shard(job: Job, folder: Folder, k: int, poll: Poll | None = None) -> dict:
    """What the shard says of itself, and the seconds that it took. Raises OSError where it cannot
    be written."""
    began = time.monotonic()
    first, count = folder.of_shard(k)
    batches = ((b.members, b.rows, b.report) for b in job.run(first, count, poll))
    said = write_shard(folder, k, batches)
    return {**said, "seconds": time.monotonic() - began}


def part(job: Job, folder: Folder, k: int) -> dict | None:
    """Its shards go once all that they hold is in the data set. None: a shard is not as it was
    written, and is gone, to be made again."""
    try:
        said = merge(job, folder, k)
    except Torn as torn:
        _drop_torn(folder, k, str(torn))
        return None
    for one in folder.shards_of(k):
        if all(part_is_whole(folder, other, False) for other in folder.parts_of(one)):
            folder.shard_file(one).unlink(missing_ok=True)
    return said


def _drop_torn(folder: Folder, part: int, torn: str) -> None:
    for k in folder.shards_of(part):
        if torn == f"shard {k}" or head(folder, k) is None:
            folder.shard_file(k).unlink(missing_ok=True)


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
