"""The Slurm engine: an array of tasks; each makes a subset of the shards by a static program.

Nodes need a shell, sha256sum and the folder, but no Python. A task skips existing shards, so that
it may run again. Files of the data set are merged here, when shards appear. sbatch takes partition,
account and time limit from its environment (SBATCH_PARTITION, ...).
"""

from __future__ import annotations

import argparse
import re
import shlex
import shutil
import subprocess
import time

from pkgen.back.c.render import is_portable
from pkgen.run.build import build_program
from pkgen.run.library import column, initializer
from pkgen.system.exits import NumericsFailed, UsageError
from pkgen.system.progress import say

from . import work
from .job import Job
from .remaining import TRIES, Left
from .shards import Folder, failed_shard, head
from .store import is_folder, read_json, write_json, written

TASKS = 1000  # Most tasks of an array: Slurm's default limit is 1001.
POLL = 2.0  # Seconds between checks of the sweep's folder for new shards.
ASKED = 10.0  # Seconds between queries of Slurm's queue.
STARTS = 1 << 16  # Starts are written for this many members at a time.

SCRIPT = r"""#!/bin/sh
#SBATCH --job-name=pkgen-NAME
#SBATCH --array=1-TASKS
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=FOLDER/slurm/task-%a.txt
# Made by pkgen sweep. A shard that is there is left alone, so a task may run again.
cd FOLDER || exit 2
made() { # number, file, first member, count, members before the level
    new=shards/$2.$(hostname).$$.partial
    head="\"sweep\": \"DIGEST\", \"level\": LEVEL, \"shard\": $1, \"first\": $3, \"count\": $4"
    ./slurm/program --starts "slurm/starts-$2" --first $(($3 + $5)) --to "$new" --shard "$head" \
        2> "slurm/said-$2" &&
        sum=$(sha256sum < "$new") && echo "${sum%% *}" >> "$new" && mv "$new" "shards/$2" &&
        rm -f "slurm/said-$2" "slurm/starts-$2"
}
failed() {
    why=$(head -n 1 "slurm/said-$2" | tr -d '"\\' | tr -c '[:print:]' ' ')
    rm -f "$new"
    echo "{\"shard\": $1, \"tried\": 1, \"why\": \"${why:-the program was ended}\"}" > "failed/$2"
}
task=${SLURM_ARRAY_TASK_ID:-$((JOB_COMPLETION_INDEX + 1))} # or that of an indexed Job
awk -v t="$task" -v n=EACH 'NR % n == t % n' slurm/shards.txt |
while read -r k file first count before; do
    [ -s "shards/$file" ] || made "$k" "$file" "$first" "$count" "$before" || failed "$k" "$file"
done
"""


class Slurm:
    """The Slurm engine. If an earlier process of the same sweep has queued an array of tasks, the
    engine waits for that array."""

    def __init__(self, job: Job, folder: Folder, options: argparse.Namespace):
        if shutil.which("sbatch") is None:
            raise UsageError("--engine slurm: there is no sbatch here; start it where Slurm is")
        if not is_folder(folder.path):
            raise UsageError(f"--engine slurm: its nodes need a folder; {folder.path} is none")
        if job.settings.method.startswith("gsl_"):
            raise UsageError(
                f"--engine slurm: its program is without GSL: no {job.settings.method}"
            )
        self.job, self.folder, self.at_once = job, folder, options.at_once
        self.place = folder.path.absolute() / "slurm"

    def run(self, left: Left) -> None:
        waiting: set[int] = set()
        tried: dict[int, int] = {}
        number = self._queued()
        asked = time.monotonic()
        while True:
            while task := left.next():
                if task[0] == "part":
                    left.finished(task, {"torn": work.part(self.job, self.folder, task[1]) is None})
                elif tried.get(task[1], 0) < TRIES:
                    waiting.add(task[1])
            come = [k for k in sorted(waiting) if head(self.folder, k) is not None]
            for k in come:
                waiting.remove(k)
                left.finished(("shard", k), {})
            left.tick(0.0)
            if come:
                continue
            if not waiting:
                if number is None or not self._is_queued(number):
                    self.folder.cleaned()
                return
            if number is None:
                for k in waiting:
                    tried[k] = tried.get(k, 0) + 1
                number, asked = self._submitted(sorted(waiting)), time.monotonic()
            elif time.monotonic() - asked > ASKED:
                asked = time.monotonic()
                if not self._is_queued(number):
                    number = None
                    self._ended(waiting, tried)
            time.sleep(POLL)

    def _ended(self, waiting: set[int], tried: dict[int, int]) -> None:
        """Records a failed attempt at each shard that an array of tasks has not made. Removes
        shards from `waiting` that were tried TRIES times."""
        for k in [k for k in waiting if head(self.folder, k) is None]:
            known = read_json(self.folder.failed_file(k)) or {}
            failed_shard(self.folder, k, known.get("why") or "its task ended; see slurm/task-*.txt")
            if tried.get(k, 1) >= TRIES:
                waiting.remove(k)

    def _program(self) -> None:
        job = self.job
        settings = job.library.settings(
            job.settings,
            reduced=job.kept.reduced,
            member_columns=tuple(map(column, job.starts.columns)),
            no_rows=not job.kept.rows,
            lenient=1,
            threads=1,
        )
        build_program(
            job.files,
            job.name,
            initializer(settings),
            self.place / "program",
            *job.methods,
            static=True,
            native=not is_portable(job.files),
            **job.build,
        )

    def _submitted(self, shards: list[int]) -> str:
        """Submits an array of tasks for the shards; returns the array's number."""
        self.place.mkdir(exist_ok=True)
        if not (self.place / "program").exists():
            self._program()
        lines = []
        for k in shards:
            file, (first, count) = self.folder.shard_file(k).name, self.folder.of_shard(k)
            lines.append(f"{k} {file} {first} {count} {self.job.before}\n")
            starts = self.place / f"starts-{file}"
            if starts.exists():
                continue
            with written(starts) as out:
                for begin in range(first, first + count, STARTS):
                    some = min(STARTS, first + count - begin)
                    out.write(self.job.starts.values(begin, some).tobytes())
        with written(self.place / "shards.txt") as out:
            out.write("".join(lines).encode())
        tasks = min(len(shards), TASKS)
        words = {
            "NAME": self.job.name,
            "TASKS": f"{tasks}%{self.at_once}" if self.at_once else str(tasks),
            "EACH": str(tasks),
            "FOLDER": shlex.quote(str(self.folder.path.absolute())),
            "DIGEST": self.folder.digest,
            "LEVEL": str(self.folder.level),
        }
        text = re.sub("|".join(rf"\b{word}\b" for word in words), lambda w: words[w[0]], SCRIPT)
        script = self.place / "job.sh"
        with written(script) as out:
            out.write(text.encode())
        said = _asked("sbatch", "--parsable", str(script))
        number = said.stdout.strip().partition(";")[0]
        if said.returncode or not number:
            raise NumericsFailed(f"sbatch: {said.stderr.strip() or 'it gave no number'}")
        write_json(self.place / "array.json", {"sweep": self.folder.digest, "number": number})
        say(f"submitted as array {number}, {len(shards)} shards")
        return number

    def _queued(self) -> str | None:
        known = read_json(self.place / "array.json") or {}
        number = known.get("number")
        ours = known.get("sweep") == self.folder.digest and isinstance(number, str)
        return number if ours and self._is_queued(number) else None

    @staticmethod
    def _is_queued(number: str) -> bool:
        """Whether the array has waiting or running tasks; true if Slurm's controller does not
        answer."""
        said = _asked("squeue", "--noheader", "--jobs", number)
        if said.returncode:
            return "Invalid job id" not in said.stderr
        return bool(said.stdout.strip())


engine = Slurm


def _asked(*command: str) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=60)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", "no answer in 60 s")
