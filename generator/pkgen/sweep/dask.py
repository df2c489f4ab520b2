"""The Dask engine: shards as tasks of a cluster, which is given by its address or made here.

The folder is one that all its workers see. A worker that dies takes its tasks with it; Dask gives
them to another.
"""

from __future__ import annotations

import logging
import pickle
import time
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

from ..system.exits import BuildError, NumericsFailed, UsageError
from . import work
from .job import Job
from .left import Left, Task
from .shards import Folder

if TYPE_CHECKING:
    from distributed import Future

LOOK = 0.1  # seconds between looks at tasks
PATIENCE = 60.0  # seconds without any worker
AHEAD = 3  # tasks of a worker that the cluster knows at a time


@lru_cache(1)
def _taken(job: bytes) -> Job:
    """Once in a worker: its library is loaded once."""
    return pickle.loads(job)


def _task(packed: bytes, folder: Folder, kind: str, k: int) -> dict:
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


def _said(one: Future) -> dict:
    """What came of a task; a worker may have died with it, or with its result."""
    if one.status not in ("finished", "error"):
        return {"wrong": f"its task is {one.status}"}
    try:
        return one.result(timeout="60s")
    except Exception as error:
        return {"wrong": f"{type(error).__name__}: {error}"}


class Dask:
    """A cluster of Dask, given or made here."""

    def __init__(self, job: Job, folder: Folder, workers: int, address: str | None = None):
        try:
            from distributed import Client, LocalCluster
        except ImportError:
            raise UsageError("--engine dask: pip install dask distributed") from None
        self.job, self.folder = job, replace(folder, path=folder.path.absolute())
        self.cluster = None
        if address is None:
            self.cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=None,
                silence_logs=logging.CRITICAL,  # deaths of workers are mended
            )
        try:
            self.client = Client(self.cluster or address, timeout="10s")
        except (OSError, ValueError) as error:
            raise UsageError(f"--scheduler {address}: no cluster answers: {error}") from None
        self.asked = self.seen = time.monotonic()
        self.most = AHEAD * (workers if address is None else max(1, self._workers()))

    def _workers(self) -> int:
        return len(self.client.scheduler_info(n_workers=-1)["workers"])

    def _refuse_none(self) -> None:
        """Raises NumericsFailed where nobody is left: tasks would wait for ever."""
        now = time.monotonic()
        if now - self.asked < PATIENCE / 10:
            return
        self.asked = now
        self.seen = now if self._workers() else self.seen
        if now - self.seen > PATIENCE:
            raise NumericsFailed("the cluster has no workers any more; go on with --resume")

    def run(self, left: Left) -> None:
        flying: dict[object, Task] = {}
        try:
            job = pickle.dumps(self.job)  # what is scattered goes with the workers that have it
            while True:
                while len(flying) < self.most and (task := left.next()):
                    one = self.client.submit(_task, job, self.folder, *task, pure=False)
                    flying[one] = task
                if not flying:
                    return
                time.sleep(LOOK)
                for one in [one for one in flying if one.status != "pending"]:
                    left.said(flying.pop(one), _said(one))
                self._refuse_none()
                left.tick(0.0)
        finally:
            self.client.close()
            if self.cluster is not None:
                self.cluster.close()
                self.folder.cleaned()
