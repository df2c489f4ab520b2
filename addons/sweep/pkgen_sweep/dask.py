"""The Dask engine: runs shards as tasks of a given cluster, or of one started on this machine."""

from __future__ import annotations

import argparse
import logging
from typing import TYPE_CHECKING

from pkgen.system.exits import UsageError

from .cluster import Cluster, task
from .job import Job
from .remaining import Task
from .shards import Folder

if TYPE_CHECKING:
    from distributed import Future


class Dask(Cluster):
    """A Dask cluster: a given one, or one started on this machine."""

    def __init__(self, job: Job, folder: Folder, options: argparse.Namespace):
        try:
            from distributed import Client, LocalCluster
        except ImportError:
            raise UsageError("--engine dask: pip install dask distributed") from None
        address = options.scheduler
        self.cluster = None
        if address is None:
            self.cluster = LocalCluster(
                n_workers=options.workers,
                threads_per_worker=1,
                dashboard_address=None,
                silence_logs=logging.CRITICAL,  # the tasks of dead workers are retried
            )
        try:
            self.client = Client(self.cluster or address, timeout="10s")
        except (OSError, ValueError) as error:
            raise UsageError(f"--scheduler {address}: no cluster answers: {error}") from None
        super().__init__(job, folder, options.workers if address is None else self.workers() or 1)

    def workers(self) -> int:
        return len(self.client.scheduler_info(n_workers=-1)["workers"])

    def submit(self, one: Task) -> Future:
        return self.client.submit(task, self.packed, self.folder, *one, pure=False)

    def ended(self, flying: list) -> list:
        return [one for one in flying if one.status != "pending"]

    def said(self, one: Future) -> dict:
        if one.status not in ("finished", "error"):
            return {"wrong": f"its task is {one.status}"}
        try:
            return one.result(timeout="60s")
        except Exception as error:
            return {"wrong": f"{type(error).__name__}: {error}"}

    def close(self) -> None:
        self.client.close()
        if self.cluster is not None:
            self.cluster.close()
            self.folder.cleaned()


engine = Dask
