"""`pkgen sweep`: integrates the members of a plan in shards, and writes a data set."""

from __future__ import annotations

import argparse
import json
import os
import sys
from importlib import import_module

from pkgen.cli import arguments as shared
from pkgen.cli.compilation import compile_within_limits
from pkgen.system.exits import DONE, NUMERICS_FAILED, UsageError
from pkgen.system.progress import progress

EXAMPLES = """
pkgen sweep models/double_pendulum.lag --plan models/flips.toml -o flips
pkgen sweep --resume flips
pkgen sweep --status flips
"""
ENGINES = ("local", "dask", "ray", "slurm")  # names of modules of this package
CLUSTERS = ("dask", "ray")


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    add = parser.add_argument
    add("model", nargs="?", metavar="MODEL.lag", help="- is the standard input")
    shared.of_a_model(parser)
    add("--plan", metavar="FILE", help="members and what is kept of them, in TOML")
    add("-o", dest="directory", metavar="DIR", help="where it lies; s3://BUCKET/DIR is a store")
    add("--resume", metavar="DIR", help="go on with the sweep that lies there")
    add("--status", metavar="DIR", help="how far the sweep is that lies there")
    add("--engine", choices=ENGINES, default="local", help="who runs it (default: local)")
    add("--scheduler", metavar="ADDRESS", help="of a cluster (default: one is made here)")
    add("--workers", type=int, metavar="N", help="how many at once (default: all cores)")
    add("--shard", type=int, metavar="N", help="members of a shard (default: 10 s of work)")


def run(options: argparse.Namespace) -> int:
    """Integrate the members that a plan draws, and write a Parquet data set; resumable."""
    from . import status, store, sweep

    if options.status is not None:
        if options.model or options.plan or options.directory or options.resume:
            raise UsageError("--status DIR stands alone")
        return _tell(options, status.status(store.place(options.status)))
    for option in ("workers", "shard"):
        value = getattr(options, option)
        if value is not None and value < 1:
            raise UsageError(f"--{option} {value}: must be positive")
    if options.scheduler is not None and options.engine not in CLUSTERS:
        raise UsageError(f"--scheduler is for --engine {' or '.join(CLUSTERS)}")
    options.at_once = options.workers
    options.workers = options.workers or len(os.sched_getaffinity(0))
    if options.workers > 1024:
        raise UsageError(f"--workers {options.workers}: 1024 at most")
    if options.resume is not None:
        if options.model or options.plan or options.directory or options.shard:
            raise UsageError("--resume DIR takes no model, --plan, -o or --shard: they are in DIR")
        begun = sweep.resumed(store.place(options.resume), options, compile_within_limits)
    else:
        for value, name in ((options.model, "MODEL.lag"), (options.plan, "--plan FILE")):
            if value is None:
                raise UsageError(f"a sweep needs {name}: pkgen sweep MODEL.lag --plan FILE -o DIR")
        if options.directory is None or options.directory == "-":
            raise UsageError("a sweep needs a folder: -o DIR")
        begun = sweep.begun(options, compile_within_limits)
    for note in begun.notes:
        print(note, file=sys.stderr)
    with store.alone(begun.folder.path), progress(begun.job.name) as on_progress:
        _go(begun, options, on_progress)
    return _tell(options, status.status(begun.folder.path), sys.stderr)


def _go(begun, options: argparse.Namespace, on_progress) -> None:
    from . import remaining as left
    from . import sweep

    try:
        for level in sweep.levels(begun):
            of = level.job, level.folder, options.engine, options.workers
            module = import_module(f".{options.engine}", __package__)
            made = module.engine(level.job, level.folder, options)
            made.run(left.Left(*of, on_progress))
    except sweep.Unfinished:
        pass  # The status of the sweep, printed below, says which members are missing.
    except KeyboardInterrupt:
        print(
            f"pkgen: what is done stays: pkgen sweep --resume {begun.folder.path}", file=sys.stderr
        )
        raise


def _tell(options: argparse.Namespace, found: dict, stream=None) -> int:
    from . import status

    if options.json:
        print(json.dumps(found, indent=1))
    else:
        print("\n".join(status.lines(found)), file=stream or sys.stdout)
    if stream is None:
        return DONE
    whole = found["parts_done"] == found["parts"]
    return DONE if whole and found["failed"] < found["members"] else NUMERICS_FAILED
