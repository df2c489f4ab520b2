"""What engines share that hand tasks to a cluster: Dask, Ray. Its workers see what the sweep is in.

A worker that dies takes its tasks with it; they are given again.
"""

from __future__ import annotations

import pickle
import time
from abc import ABC, abstractmethod
from dataclasses import replace
from functools import lru_cache
from typing import Any

from pkgen.system.exits import BuildError, NumericsFailed, UsageError

from . import work
from .job import Job
from .remaining import Left, Task
from .shards import Folder

LOOK = 0.1  # seconds between looks at tasks
PATIENCE = 60.0  # seconds without any worker
AHEAD = 3  # tasks of a worker that the cluster knows at a time


@lru_cache(1)
def _taken(job: bytes) -> Job:
    """Once in a worker: its library is loaded once."""
    return pickle.loads(job)


def task(packed: bytes, folder: Folder, kind: str, k: int) -> dict:
    """On a worker. What cannot be done is told, not raised: its text is for a person."""
    job = _taken(packed)
    try:
        done = work.shard(job, folder, k) if kind == "shard" else work.part(job, folder, k)
        done = done or {"torn": True}
        return {"done": {"torn": bool(done.get("torn"))}}
    except OSError as error:
        return {"disk": f"{error.filename or folder.path}: {error.strerror}"}
    except (BuildError, NumericsFailed, UsageError) as error:
        return {"wrong": str(error)}


class Cluster(ABC):
    def __init__(self, job: Job, folder: Folder, most: int):
        self.folder = replace(folder, path=folder.path.absolute())
        self.packed = pickle.dumps(job)
        self.most = most * AHEAD
        self.asked = self.seen = time.monotonic()

    @abstractmethod
    def submit(self, one: Task) -> Any:
        """What the cluster calls it."""

    @abstractmethod
    def ended(self, flying: list) -> list:
        """Those that are done, or lost."""

    @abstractmethod
    def said(self, one: Any) -> dict:
        """What came of it; a worker may have died with it, or with its result."""

    @abstractmethod
    def workers(self) -> int: ...

    @abstractmethod
    def close(self) -> None: ...

    def _refuse_none(self) -> None:
        """Raises NumericsFailed where nobody is left: tasks would wait for ever."""
        now = time.monotonic()
        if now - self.asked < PATIENCE / 10:
            return
        self.asked = now
        self.seen = now if self.workers() else self.seen
        if now - self.seen > PATIENCE:
            raise NumericsFailed("the cluster has no workers any more; go on with --resume")

    def run(self, left: Left) -> None:
        flying: dict[object, Task] = {}
        try:
            while True:
                while len(flying) < self.most and (one := left.next()):
                    flying[self.submit(one)] = one
                if not flying:
                    return
                time.sleep(LOOK)
                for one in self.ended(list(flying)):
                    left.said(flying.pop(one), self.said(one))
                self._refuse_none()
                left.tick(0.0)
        finally:
            self.close()
