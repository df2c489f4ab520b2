"""Checkpoints of `pkgen run`: checks the options, makes and reads the JSON note in a checkpoint.

The note has the command line of the run. The runtime writes the file
(`runtime/run/base/checkpoint.c`); docs/dev/checkpoints.md explains it.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import struct
import zlib
from pathlib import Path
from typing import Any

from ..api.prepare import Prepared
from ..front.read import STANDARD
from ..run.simulate import Outcome
from ..system.exits import DONE, NUMERICS_FAILED, UsageError
from ..system.files import beside, partial
from ..version import __version__

USUAL = 60.0  # default seconds between checkpoints
MAGIC, VERSION = b"pkgen checkpoint", 2  # as in runtime/run/base/checkpoint.c
# Magic, version, CRC, byte-order mark, file size, sizeof(pk_real), size of the note.
HEAD = struct.Struct("=16sIIQQII")
SUMMED = 24  # offset in bytes at which the data for the CRC begin
ORDER = 0x0102030405060708  # byte order mark


def arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--checkpoint", metavar="FILE", help="where the run is kept, for pkgen resume FILE")
    add("--checkpoint-every", metavar="S", help=f"seconds between two (default: {USUAL:g})")
    parser.set_defaults(resume=False)


def refuse(options: argparse.Namespace, output: Path | None, drawn: bool) -> None:
    """Raises UsageError if the run cannot have checkpoints, or if the checkpoint file exists and
    the run is not resumed."""
    if options.checkpoint is None:
        if options.checkpoint_every is not None:
            raise UsageError("--checkpoint-every is for --checkpoint FILE")
        return
    path = Path(options.checkpoint)
    if options.model == STANDARD:
        raise UsageError("--checkpoint: give the model as a file, which pkgen resume can read")
    if output is None and (options.json or drawn or options.output == "-"):
        raise UsageError("--checkpoint: give the rows a file too, -o FILE.csv")
    if output is not None and path.resolve() in {p.resolve() for p in written(output)}:
        raise UsageError(f"--checkpoint {path}: rows and what describes them are written there")
    if not os.access(path.parent, os.W_OK):
        raise UsageError(f"--checkpoint {path}: there is no folder {path.parent} to write in")
    if path.exists() and not options.resume:
        raise UsageError(
            f"--checkpoint {path}: it is there already; `pkgen resume {path}` goes on from it, "
            "remove it to begin anew"
        )


def written(output: Path) -> set[Path]:
    """Returns all files of a run with rows in `output`: table and JSON file, also if unfinished."""
    growing = partial(output)
    return {output, beside(output), growing, beside(growing)}


def _seconds(options: argparse.Namespace) -> float:
    text = options.checkpoint_every
    try:
        seconds = USUAL if text is None else float(text)
    except ValueError:
        seconds = -1
    if not 0 <= seconds < math.inf:
        raise UsageError(f"--checkpoint-every {text}: give a number of seconds, 0: only at the end")
    return seconds


def chosen(options: argparse.Namespace) -> dict[str, Any] | None:
    """Returns the method and settings that a resumed run had chosen for its accuracy before it was
    interrupted; None if the run is not resumed or has no accuracy."""
    resume = getattr(options, "resume", None)  # `pkgen plot` has no attribute `resume`
    return resume["chosen"] if resume else None


def settings(options: argparse.Namespace, what: Prepared) -> dict[str, object]:
    """Returns the members of the C struct pk_run_settings for checkpoints. Raises UsageError."""
    if options.checkpoint is None:
        return {}
    assert what.library is not None
    note = {
        "pkgen": __version__,
        "words": options.words,
        "folder": os.getcwd(),
        "built": what.library.parent.name,
        "chosen": what.chosen,
    }
    if options.resume and options.resume["built"] != note["built"]:
        raise UsageError(
            f"{options.checkpoint}: its run was compiled otherwise: the model, the C compiler, "
            "its flags or pkgen are others now, and so would the last bits be"
        )
    return {
        "checkpoint": os.fsencode(options.checkpoint),
        "checkpoint_every": _seconds(options),
        "checkpoint_note": json.dumps(note).encode(),
        "resume": int(bool(options.resume)),
    }


def over(options: argparse.Namespace, outcome: Outcome) -> None:
    """Removes the checkpoint of a run that is complete or whose numerics failed."""
    if (
        options.checkpoint is not None
        and outcome.report
        and outcome.code in (DONE, NUMERICS_FAILED)
    ):
        Path(options.checkpoint).unlink(missing_ok=True)


def note(path: Path) -> dict[str, object]:
    """Reads the JSON note of a checkpoint. Raises UsageError if the file is invalid."""
    bytes_ = path.read_bytes()
    if len(bytes_) < HEAD.size or not bytes_.startswith(MAGIC):
        raise UsageError(f"{path}: it is no checkpoint of pkgen")
    _, version, sum_, order, size, _real, length = HEAD.unpack_from(bytes_)
    if version != VERSION or order != ORDER:
        raise UsageError(f"{path}: it is of another version of pkgen, or another kind of machine")
    if size != len(bytes_) or zlib.crc32(memoryview(bytes_)[SUMMED:]) != sum_:
        raise UsageError(f"{path}: it is damaged: its sum is not that of its bytes")
    is_ = path.stat()
    if is_.st_uid not in (os.geteuid(), 0) or is_.st_mode & 0o022:
        raise UsageError(
            f"{path}: others can write it, and what is in it is believed: take a copy of your own"
        )
    try:
        found = json.loads(bytes_[HEAD.size : HEAD.size + length])
        words, built, chosen = found["words"], found["built"], found.get("chosen")
        folder = Path(found["folder"])
    except (ValueError, KeyError, TypeError):
        raise UsageError(f"{path}: it is of a program that pkgen has built: run that") from None
    good = isinstance(words, list) and all(isinstance(word, str) for word in words)
    of_choice = chosen.get("said") if isinstance(chosen, dict) else None
    if not good or (chosen is not None and not (isinstance(of_choice, list) and of_choice)):
        raise UsageError(f"{path}: it says nothing that pkgen run understands")
    return {"words": words, "built": built, "folder": folder, "chosen": chosen}
