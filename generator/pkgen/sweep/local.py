"""The local engine: processes of this machine, each with a task at a time.

One that dies takes its task with it alone: another worker begins in its place, and the task is
given again, some times.
"""

from __future__ import annotations

import json
import os
import pickle
import selectors
import signal
import subprocess
import sys
from collections.abc import Callable

from ..system import children
from ..system.exits import NumericsFailed, UsageError
from .job import Job
from .shards import Folder, failed_shard

TRIES = 3  # of a shard, before it is left as failed
LOST = 30  # tasks one after the other, without one that is done: it is not the shards
Task = tuple[str, int]


class _Worker:
    def __init__(self, start: bytes):
        self.process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPATH": os.pathsep.join(sys.path)},
            **children.group(),
        )
        self.task: Task | None = None
        self.at = 0.0
        self.text = b""
        self._write(start)

    def _write(self, data: bytes) -> None:
        try:
            self.process.stdin.write(data)
            self.process.stdin.flush()
        except BrokenPipeError:
            pass  # it is dead, which is seen where it is heard

    def give(self, task: Task) -> None:
        self.task, self.at = task, 0.0
        self._write(f"{task[0]} {task[1]}\n".encode())

    def heard(self) -> list[dict] | None:
        """What it said since; None: it is dead."""
        data = os.read(self.process.stdout.fileno(), 1 << 16)
        *lines, self.text = (self.text + data).split(b"\n")
        return [json.loads(line) for line in lines] if data else None

    def how(self) -> str:
        code = self.process.wait()
        if code >= 0:
            return f"its worker ended with code {code}"
        return f"its worker was killed by {signal.Signals(-code).name}"

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


class Local:
    """Runs tasks until there are none. `next_task` gives one, or None while there is nothing to do;
    `done` is told of each; `tick` some times a second how much of shards is on its way."""

    def __init__(self, job: Job, folder: Folder, workers: int):
        folder.cleaned()
        self.start = pickle.dumps((job, folder))
        self.folder = folder
        self.most = workers
        self.workers: list[_Worker] = []
        self.lost = 0

    def run(
        self,
        next_task: Callable[[], Task | None],
        done: Callable[[Task, dict], None],
        tick: Callable[[float], None],
    ) -> list[int]:
        """The shards that could not be made. Raises UsageError where the disk is full."""
        failed: list[int] = []
        again: list[Task] = []
        selector = selectors.DefaultSelector()
        try:
            while True:
                for worker in [*self.workers]:
                    self._give(worker, again, next_task)
                while len(self.workers) < self.most and (task := self._task(again, next_task)):
                    worker = _Worker(self.start)
                    worker.give(task)
                    self.workers.append(worker)
                    selector.register(worker.process.stdout, selectors.EVENT_READ, worker)
                busy = [worker for worker in self.workers if worker.task]
                if not busy:
                    return failed
                for key, _ in selector.select(0.5):
                    worker = key.data
                    said = worker.heard()
                    if said is None:
                        selector.unregister(worker.process.stdout)
                        self.workers.remove(worker)
                        self._lost(worker.task, worker.how(), again, failed)
                        worker.end()
                    for one in said or ():
                        self._take(worker, one, done, again, failed)
                tick(sum(w.at * self._count(w.task) for w in self.workers if w.task))
        finally:
            selector.close()
            for worker in self.workers:
                worker.end()
            self.folder.cleaned()

    @staticmethod
    def _task(again: list[Task], next_task: Callable[[], Task | None]) -> Task | None:
        return again.pop() if again else next_task()

    def _give(self, worker: _Worker, again: list[Task], next_task) -> None:
        if worker.task is None and (task := self._task(again, next_task)):
            worker.give(task)

    def _count(self, task: Task) -> int:
        return self.folder.of_shard(task[1])[1] if task[0] == "shard" else 0

    def _take(self, worker: _Worker, said: dict, done, again, failed: list[int]) -> None:
        if "at" in said:
            worker.at = said["at"]
            return
        task, worker.task = worker.task, None
        if "disk" in said:
            raise UsageError(f"{said['disk']}; what is done stays: pkgen sweep --resume")
        if "wrong" in said:
            self._lost(task, said["wrong"], again, failed)
        else:
            self.lost = 0
            done(task, said["done"])

    def _lost(self, task: Task | None, why: str, again: list[Task], failed: list[int]) -> None:
        if task is None:
            return
        self.lost += 1
        if self.lost > LOST:
            raise NumericsFailed(f"workers fail one after the other: {why}")
        kind, k = task
        if kind == "part":
            first = self.folder.shards_of(k)[0]
            tried = failed_shard(self.folder, first, f"part {k}: {why}")
            k = first
        else:
            tried = failed_shard(self.folder, k, why)
        if tried < TRIES:
            again.append(task)
        elif k not in failed:
            failed.append(k)
