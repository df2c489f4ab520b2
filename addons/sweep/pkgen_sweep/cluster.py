"""Common code of the engines that submit tasks to a cluster: Dask, Ray.

Workers need access to the sweep's folder. The tasks of a worker that dies are submitted again.
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

LOOK = 0.1  # Seconds between two queries whether tasks have ended.
PATIENCE = 60.0  # Seconds without any worker after which the sweep fails.
AHEAD = 3  # Tasks per worker that are submitted and have not ended.


@lru_cache(1)
def _taken(job: bytes) -> Job:
    """Unpickles the job once per worker, so that its library is loaded once."""
    return pickle.loads(job)


def task(packed: bytes, folder: Folder, kind: str, k: int) -> dict:
    """Runs a task on a worker. Expected errors are returned as text for the user, not raised."""
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
        """Submits a task; returns the cluster's handle of it."""

    @abstractmethod
    def ended(self, flying: list) -> list:
        """Returns the handles of tasks that have ended or are lost."""

    @abstractmethod
    def said(self, one: Any) -> dict:
        """Returns the result of a finished task; {"wrong": reason} if the task's worker died."""

    @abstractmethod
    def workers(self) -> int: ...

    @abstractmethod
    def close(self) -> None: ...

    def _refuse_none(self) -> None:
        """Raises NumericsFailed if the cluster has had no worker for PATIENCE seconds, since the
        tasks would wait forever."""
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
