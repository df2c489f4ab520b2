"""The queue of a sweep's remaining tasks, and the report of its progress.

An engine, which runs the tasks, has a method run(left), where `left` is a Left. The engine takes
tasks by left.next() until there are none, reports each result by left.said() or left.lost(), and
calls left.tick() several times per second.
"""

from __future__ import annotations

import os
import platform
import time

from pkgen.system.exits import NumericsFailed, UsageError

from . import work
from .job import Job
from .shards import Folder, failed_shard
from .store import NOW, is_folder, listed, write_json

TRIES = 3  # A shard counts as failed after this many attempts.
LOST = 30  # The sweep is stopped after this many lost tasks in a row.
Task = tuple[str, int]  # "shard" or "part", and its number.


class Left:
    """The queue of remaining tasks, from which an engine takes them."""

    def __init__(self, job: Job, folder: Folder, engine: str, workers: int, on_progress=None):
        self.job, self.folder, self.on_progress = job, folder, on_progress
        folder.made()
        for path in listed(folder.path / "failed"):
            path.unlink()  # failed shards are tried again
        missing, parts = work.survey(folder, True)
        self.shards = missing[::-1]
        self.waiting = {part: 0 for part in parts}
        for k in missing:
            for part in folder.parts_of(k):
                if part in self.waiting:
                    self.waiting[part] += 1
        self.ready = [part for part in parts if not self.waiting[part]][::-1]
        left = sum(folder.of_shard(k)[1] for k in missing)
        self.done_before = self.done = self.job.members - left
        self.lost_in_a_row = 0
        self.began, self.told = time.time(), 0.0
        self.often = 1 if is_folder(folder.path) else 10  # seconds between reports
        self.about = {"engine": engine, "workers": workers, "host": platform.node()}
        before = self.job.before + self.done_before
        self.about |= {"pid": os.getpid(), "began": self.began, "before": before}
        self.tick(0.0)

    def next(self) -> Task | None:
        """Returns the next task; None if there is none, or none that can start yet."""
        if self.ready:
            return "part", self.ready.pop()
        return ("shard", self.shards.pop()) if self.shards else None

    def said(self, task: Task, said: dict) -> None:
        """Records the result of a task. Raises UsageError if its files could not be written."""
        if "disk" in said:
            raise UsageError(f"{said['disk']}; what is done stays: pkgen sweep --resume")
        if "wrong" in said:
            self.lost(task, said["wrong"])
        else:
            self.finished(task, said["done"])

    def lost(self, task: Task, why: str) -> None:
        """Records a task that failed or whose worker died; queues it again, up to TRIES
        attempts."""
        self.lost_in_a_row += 1
        if self.lost_in_a_row > LOST:
            raise NumericsFailed(f"workers fail one after the other: {why}")
        kind, k = task
        if kind == "shard":
            waiting, tried = self.shards, failed_shard(self.folder, k, why)
        else:
            first = self.folder.shards_of(k)[0]
            waiting, tried = self.ready, failed_shard(self.folder, first, f"part {k}: {why}")
        if tried < TRIES:
            waiting.append(k)

    def finished(self, task: Task, said: dict) -> None:
        self.lost_in_a_row = 0
        kind, k = task
        if kind == "part":
            if said.get("torn"):
                self._torn(k)
            return
        self.done += self.folder.of_shard(k)[1]
        self.folder.failed_file(k).unlink(missing_ok=True)
        for part in self.folder.parts_of(k):
            self.waiting[part] -= 1
            if not self.waiting[part]:
                self.ready.append(part)

    def _torn(self, part: int) -> None:
        gone = [k for k in self.folder.shards_of(part) if not self.folder.shard_file(k).exists()]
        for k in gone:
            self.shards.append(k)
            self.done -= self.folder.of_shard(k)[1]
            for other in self.folder.parts_of(k):
                if other in self.waiting:
                    self.waiting[other] += 1

    def tick(self, flying: float) -> None:
        """Reports the progress: here, and in a file that other processes read."""
        now = time.time()
        if now - self.told < self.often:
            return
        self.told = now
        if self.on_progress:
            self.on_progress((self.done + flying) / self.job.members)
        write_json(self.folder.path / NOW, {**self.about, "at": now, "flying": int(flying)})
