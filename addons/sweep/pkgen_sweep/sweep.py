"""Begins a sweep, resumes it, and makes its levels of refinement."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import numpy as np

from pkgen.compiler import Compilation
from pkgen.front.read import from_text, inside, read
from pkgen.record import record
from pkgen.source import ModelError, Source
from pkgen.system.exits import NumericsFailed, UsageError
from pkgen.version import __version__

from . import job as jobs
from . import shards
from .job import Job
from .parts import arrow, classes, names
from .plan import Plan, of_text, read_plan
from .refine import begun as begun_grid
from .sampling import Starts
from .shards import PLAN, Folder, foreign, part_is_whole
from .store import free_bytes, place, write_json, written

SECONDS = 10.0  # A shard takes at least this many seconds, unless the sweep is shorter.
# Members are integrated for at least this many seconds to determine the size of shards.
TIMED = 0.3
LEVELS, TOML = "levels.json", "plan.toml"
Compiled = Callable[..., Compilation]


@record
class Sweep:
    job: Job
    folder: Folder
    notes: tuple[str, ...] = ()  # messages for the user, shown before the sweep runs


def begun(options: argparse.Namespace, compiled: Compiled) -> Sweep:
    """Returns a new sweep, or the one in the folder if its plan is the same. Raises UsageError if
    the folder has a different sweep, or for an error in the plan."""
    arrow()
    path = place(options.directory)
    known = shards.known(path)
    plan, source = read_plan(options.plan), read(options.model)
    if source.parts:
        raise UsageError(
            f"{options.model}: a sweep keeps its model in one file, and this one has parts; write"
            " them out in one file, or run members by: pkgen run --ensemble"
        )
    made = _made(plan, source, options, compiled, known)
    job, _ = made
    if known is None:
        if wrong := foreign(path, f"{job.name}.lag"):
            raise wrong
        return _new(path, plan, source, options, made)
    if known.get("digest") != job.digest:
        raise UsageError(f"-o {path}: {_other(path, known, plan, source)}; take another folder")
    if options.shard not in (None, known.get("shard")):
        have = known.get("shard")
        raise UsageError(f"--shard {options.shard}: the sweep that is begun has shards of {have}")
    return Sweep(job, _folder(path, known, job))


def lying(path: Path, options: argparse.Namespace) -> tuple[dict, Plan, Source]:
    """Reads plan.json, the plan and the model from the folder of a sweep. Sets the model and the
    sizes in `options`. Raises UsageError."""
    known = shards.known(path)
    if known is None:
        raise UsageError(f"{path}: no sweep lies there: it has no {PLAN}")
    try:
        file = path / Path(known["file"]).name
        if not all(inside(x, path) for x in (file, path / TOML)):
            raise TypeError("a link leads out of it")
        options.model, options.size = str(file), known["size"]
        plan = of_text(from_text(str(path / TOML), (path / TOML).read_text("utf-8")))
        text, name = file.read_text("utf-8"), known["model"]
        # Messages name the model's original path if the file there still has the same text.
        with suppress(ModelError):
            return known, plan, from_text(name if read(name).text == text else str(file), text)
        return known, plan, from_text(str(file), text)
    except (OSError, KeyError, TypeError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: it is not as it was begun: {error}") from None


def resumed(path: Path, options: argparse.Namespace, compiled: Compiled) -> Sweep:
    """Returns the sweep in a folder, to continue it. Raises UsageError if it has changed."""
    arrow()
    known, plan, source = lying(path, options)
    job, _ = _made(plan, source, options, compiled, known)
    if known.get("digest") != job.digest:
        why = _other(path, known, plan, source)
        raise UsageError(f"--resume {path}: {why}; begin it anew in another folder")
    return Sweep(job, _folder(path, known, job))


def _made(plan: Plan, source: Source, options: argparse.Namespace, compiled, known: dict | None):
    plan.refuse_foreign(source.path)
    chosen = known and known.get("chosen")
    return jobs.make(plan, options, partial(compiled, source=source), chosen)


def _other(path: Path, known: dict, plan: Plan, source: Source) -> str:
    """Describes how the sweep in the folder differs from the requested one."""
    if known.get("pkgen") != __version__:
        return f"the sweep there is of pkgen {known.get('pkgen')}, and this is {__version__}"
    with suppress(OSError):
        if (path / TOML).read_text("utf-8") != plan.source.text:
            return "the sweep there is of another plan"
    with suppress(OSError):
        if (path / str(known.get("file"))).read_text("utf-8") != source.text:
            return "the sweep there is of another model"
    return "the sweep there is not of this plan and model"


def _folder(path: Path, known: dict, job: Job) -> Folder:
    shard, part = known.get("shard"), known.get("part")
    if not (isinstance(shard, int) and shard > 0 and part == job.part):
        raise UsageError(f"{path / PLAN}: it is not as it was written")
    return Folder(path, job.digest, job.members, shard, job.part, bool(job.kept.rows))


def _new(path: Path, plan: Plan, source: Source, options: argparse.Namespace, made) -> Sweep:
    job, prepared = made
    need, free = job.number_bytes * job.members, free_bytes(path)
    if free is not None and need > free:
        raise UsageError(
            f"{plan.source.path}: {job.members:,} members of {job.number_bytes:,} bytes are some "
            f"{_size(need)}, and {path} has {_size(free)} left; keep less, or fewer"
        )
    pace = _pace(job)
    shard = options.shard or _shard(job.members, pace)
    folder = Folder(path, job.digest, job.members, shard, job.part, bool(job.kept.rows))
    folder.made()
    file = f"{job.name}.lag"
    for name, text in ((file, source.text), (TOML, plan.source.text)):
        with written(path / name) as out:
            out.write(text.encode())
    write_json(
        path / PLAN,
        {
            "pkgen": __version__,
            "digest": job.digest,
            "name": job.name,
            "model": os.path.abspath(source.path),
            "file": file,
            "size": options.size,
            "members": job.members,
            "shard": shard,
            "part": job.part,
            "rows": folder.rows,
            "seconds": pace,  # seconds per member, by _pace
            "chosen": prepared.chosen,
            "columns": [asdict(c) for c in names(job)],
        },
    )
    return Sweep(job, folder, prepared.notes)


def _size(n: float) -> str:
    units = ["bytes", "kB", "MB", "GB", "TB", "PB"]
    while n >= 1000 and len(units) > 1:
        n /= 1000
        units.pop(0)
    return f"{n:.3g} {units[0]}"


def _pace(job: Job) -> float:
    """Measures CPU seconds per member on samples of the members. Raises NumericsFailed if the
    method refuses the system."""
    count = 1
    exponents = [2 + k for k, (what, _) in enumerate(job.kept.reduced) if what == b"l"]
    job.library  # noqa: B018 (compiled now, so that the timing below excludes the compilation)
    while True:
        began = time.process_time()
        firsts = sorted({min(job.members - count, k * job.members // 4) for k in range(4)})
        refused, some, known = 0, 0, 0
        for first in firsts:
            for batch in job.run(first, count):
                ended = batch.members[batch.members[:, 0] >= 0]
                some += len(ended)
                known += np.isfinite(ended[:, exponents]).all(axis=1).sum()
                for one in batch.report["failures"]:
                    if one["status"] in ("PK_REFUSED", "PK_BAD_ARGUMENT"):
                        refused += one["count"]
                        why = one["reason"]
        if refused == count * len(firsts):
            raise NumericsFailed(why)
        if some and not known:
            raise NumericsFailed(
                "lyapunov: this method and model have none: see pkgen run --diagnose lyapunov"
            )
        took = time.process_time() - began
        if took > TIMED or count * len(firsts) >= job.members:
            return took / (count * len(firsts))
        count = min(job.members, count * 8)


def _shard(members: int, pace: float) -> int:
    """Returns the number of members of a shard: as many as take SECONDS, or all members if they
    take less."""
    size = max(1, min(int(SECONDS / max(pace, 1e-9)) + 1, members))
    return size if size < 64 else -(-size // 64) * 64


def levels(sweep: Sweep) -> Iterator[Sweep]:
    """Yields the sweep of the plan's grid, then the sweep of each refinement of the grid. The
    caller takes the next sweep when the previous one is done. Raises Unfinished if a level is
    incomplete."""
    job, folder = sweep.job, sweep.folder
    yield sweep
    if job.refine is None:
        return
    known = begun_grid(tuple(x.points for x in job.starts.axes), _classes(job, folder))
    made = [folder.members]
    for number in range(1, job.refine.levels + 1):
        finer, new = known.next()
        write_json(folder.path / LEVELS, {"sweep": job.digest, "members": [*made, len(new)]})
        if not len(new):
            return
        axes = tuple(
            replace(axis, points=n) for axis, n in zip(job.starts.axes, finer.shape, strict=True)
        )
        starts = Starts("points", axes, len(new), job.starts.seed, new)
        level = replace(job, starts=starts, before=sum(made))
        of_level = replace(folder, members=len(new), level=number)
        yield Sweep(level, of_level)
        known = finer.known(new, _classes(level, of_level))
        made.append(len(new))


def _classes(job: Job, folder: Folder):
    if any(not part_is_whole(folder, k, False) for k in folder.parts):
        raise Unfinished
    return classes(job, folder)


class Unfinished(Exception):
    """The next level cannot be computed, since the present one is incomplete."""
