"""The local engine: processes of this machine, each with one task at a time.

If a process dies, only its task is lost: a new worker is started, and the task is retried.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import selectors
import signal
import subprocess
import sys

from pkgen.system import children

from .job import Job
from .remaining import Left, Task
from .shards import Folder


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
            pass  # the worker is dead; heard() detects that

    def give(self, task: Task) -> None:
        self.task, self.at = task, 0.0
        self._write(f"{task[0]} {task[1]}\n".encode())

    def heard(self) -> list[dict] | None:
        """Returns the new messages of the worker; None if it is dead."""
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
    """The local engine: a pool of worker processes."""

    def __init__(self, job: Job, folder: Folder, options: argparse.Namespace):
        folder.cleaned()
        self.start = pickle.dumps((job, folder))
        self.folder = folder
        self.most = options.workers
        self.workers: list[_Worker] = []

    def run(self, left: Left) -> None:
        selector = selectors.DefaultSelector()
        try:
            while True:
                for worker in self.workers:
                    if worker.task is None and (task := left.next()):
                        worker.give(task)
                while len(self.workers) < self.most and (task := left.next()):
                    worker = _Worker(self.start)
                    worker.give(task)
                    self.workers.append(worker)
                    selector.register(worker.process.stdout, selectors.EVENT_READ, worker)
                if not any(worker.task for worker in self.workers):
                    return
                for key, _ in selector.select(0.5):
                    worker = key.data
                    said = worker.heard()
                    if said is None:
                        selector.unregister(worker.process.stdout)
                        self.workers.remove(worker)
                        if worker.task is not None:
                            left.lost(worker.task, worker.how())
                        worker.end()
                    for one in said or ():
                        self._take(worker, one, left)
                left.tick(sum(w.at * self._count(w.task) for w in self.workers if w.task))
        finally:
            selector.close()
            for worker in self.workers:
                worker.end()
            self.folder.cleaned()

    def _count(self, task: Task) -> int:
        return self.folder.of_shard(task[1])[1] if task[0] == "shard" else 0

    @staticmethod
    def _take(worker: _Worker, said: dict, left: Left) -> None:
        if "at" in said:
            worker.at = said["at"]
            return
        task, worker.task = worker.task, None
        left.said(task, said)


engine = Local
