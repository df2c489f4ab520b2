"""`pkgen film`: a film of a motion, by the drawing of its model."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from pathlib import Path

from pkgen.api.prepare import prepare
from pkgen.cli import arguments as shared
from pkgen.cli.compilation import compile_within_limits
from pkgen.describe.page_data import describe
from pkgen.scenes import run as scene_run
from pkgen.system.exits import UsageError
from pkgen.system.files import place, replace, scratch
from pkgen.system.progress import progress, unseen

# Equal to film.KINDS, which cannot be imported without matplotlib.
KINDS = (".mp4", ".webm", ".gif", ".svg")
SIZES = {".gif": (480, 270), ".svg": (960, 540)}
FPS = {".gif": 20.0, ".svg": 20.0}
# A film of a motion that lasts between these numbers of seconds has the speed of the motion.
SHORTEST, LONGEST = 2.0, 20.0
USUAL = 10.0
MOST = 100_000  # most frames

EXAMPLES = """
pkgen film models/heavy_top.lag -o heavy_top.svg --seconds 2
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    add = parser.add_argument
    add("-o", dest="output", required=True, metavar="FILE", help="FILE.mp4, .webm, .gif or .svg")
    add("--fps", type=float, metavar="N", help="frames a second (default 30; .gif, .svg: 20)")
    add("--pixels", metavar="1280x720", help="width and height (default; .gif: 480x270)")
    add("--seconds", type=float, metavar="S", help="of the film (default: the motion's, or 10)")
    add("--no-labels", action="store_true", help="no title, no time, no names of bobs")
    add("--beside", metavar="COLUMN", help="draw its graph, which grows, beside the motion")
    shared.of_a_motion(parser)
    add("--method", metavar="NAME", help="see pkgen methods")
    add("--step", metavar="H", help="of a method with fixed steps")
    shared.tolerance(parser)


def run(options: argparse.Namespace) -> int:
    """Make a film of a motion, by the drawing of its model (draw, view)."""
    path = _file(options)
    kind = path.suffix
    from . import write

    write.refuse(kind)
    size = _size(options, kind)
    fps = _positive("--fps", options.fps, FPS.get(kind, 30.0))
    if options.seconds is not None:
        _positive("--seconds", options.seconds, 1.0)
    from .film import Asked, film, of_swarm

    swarm = scene_run.is_swarm(options)
    if swarm:
        of = prepare(options, compile_within_limits).built()
    else:
        of = describe(options, lambda o, **how: compile_within_limits(o, **how))
    until = of.settings.until
    usual = until if SHORTEST <= until <= LONGEST else USUAL
    labels, beside = not options.no_labels, options.beside or ""
    if swarm and beside:
        raise UsageError("--beside: a swarm has no graph of one motion")
    asked = Asked(fps, size, options.seconds or usual, labels, beside)
    if asked.frames > MOST:
        raise UsageError(
            f"{asked.frames:,} frames: {MOST:,} at most; take fewer --seconds or --fps"
        )
    begun = _processor()
    with scratch() as folder, progress(of.compilation.model.name) as show:
        make = of_swarm if swarm else film
        made = make(of, asked, folder / f"film{kind}", show or unseen)
        data = (folder / f"film{kind}").read_bytes() if made.frames else b""
    outcome = made.outcome
    if outcome.messages:
        print(outcome.messages.rstrip("\n"), file=sys.stderr)
    if data:
        replace({path: data})
    _tell(options, path, made.frames, asked, len(data), _processor() - begun)
    return outcome.code


def _processor() -> float:
    """Returns CPU seconds, including the time of ffmpeg."""
    return sum(os.times()[:4])


def _tell(
    options: argparse.Namespace, path: Path, frames: int, asked, size: int, cpu: float
) -> None:
    seconds = frames / asked.fps
    if options.json:
        keys = ("file", "frames", "fps", "width", "height", "seconds", "bytes", "cpu")
        values = (str(path), frames, asked.fps, *asked.size, seconds, size, round(cpu, 3))
        print(json.dumps(dict(zip(keys, values, strict=True)), indent=1))
    elif not size:
        print(f"pkgen: {path}: not written: there is no motion", file=sys.stderr)
    else:
        print(
            f"{path}: {frames} frames of {asked.size[0]}x{asked.size[1]}, {seconds:.3g} s, "
            f"{size / 1000:,.0f} kB, in {cpu:.2g} s of the processor",
            file=sys.stderr,
        )


def _file(options: argparse.Namespace) -> Path:
    if not options.output.endswith(KINDS):
        ends = "its name must end in .mp4, .webm, .gif or .svg"
        raise UsageError(f"-o {options.output}: {ends}")
    path = Path(options.output)
    place(path)
    return path


def _size(options: argparse.Namespace, kind: str) -> tuple[int, int]:
    if options.pixels is None:
        return SIZES.get(kind, (1280, 720))
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", options.pixels)
    width, height = (int(found[1]), int(found[2])) if found else (0, 0)
    if not (64 <= width <= 4096 and 64 <= height <= 4096) or width % 2 or height % 2:
        raise UsageError(
            f"--pixels {options.pixels}: width and height, even, from 64 to 4096: 1280x720"
        )
    return width, height


def _positive(option: str, value: float | None, usual: float) -> float:
    if value is None:
        return usual
    if not 0 < value < 1e6:
        raise UsageError(f"{option} {value:g}: must be positive and finite")
    return value
