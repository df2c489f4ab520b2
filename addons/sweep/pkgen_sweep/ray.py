"""The Ray engine: runs shards as tasks of a given cluster, or of one started on this machine."""

from __future__ import annotations

import argparse
import logging
import os
from typing import TYPE_CHECKING

from pkgen.system.exits import UsageError

from .cluster import Cluster, task
from .job import Job
from .remaining import Task
from .shards import Folder

if TYPE_CHECKING:
    from ray import ObjectRef


class Ray(Cluster):
    """A Ray cluster: a given one, or one started on this machine. Ray itself does not retry a lost
    task; the queue of the sweep (remaining.Left) does."""

    def __init__(self, job: Job, folder: Folder, options: argparse.Namespace):
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")  # suppresses a warning
        try:
            import ray
        except ImportError:
            raise UsageError("--engine ray: pip install ray") from None
        self.ray, self.own = ray, options.scheduler is None
        how = {"num_cpus": options.workers, "include_dashboard": False} if self.own else {}
        try:
            ray.init(
                address="local" if self.own else options.scheduler,
                logging_level=logging.CRITICAL,
                log_to_driver=False,
                **how,
            )
        except (ConnectionError, OSError, RuntimeError, ValueError) as error:
            raise UsageError(f"--scheduler {options.scheduler}: {error}") from None
        super().__init__(job, folder, options.workers if self.own else self.workers() or 1)
        self.task = ray.remote(max_retries=0)(task)
        self.job, self.place = ray.put(self.packed), ray.put(self.folder)

    def workers(self) -> int:
        return int(self.ray.cluster_resources().get("CPU", 0))

    def submit(self, one: Task) -> ObjectRef:
        return self.task.remote(self.job, self.place, *one)

    def ended(self, flying: list) -> list:
        return self.ray.wait(flying, num_returns=len(flying), timeout=0)[0]

    def said(self, one: ObjectRef) -> dict:
        try:
            return self.ray.get(one)
        except self.ray.exceptions.RayError as error:
            return {"wrong": str(error).partition("\n")[0] or type(error).__name__}

    def close(self) -> None:
        self.ray.shutdown()
        if self.own:
            self.folder.cleaned()


engine = Ray
