"""From a described model to the file of its film."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy

from ..describe.made import Described
from ..plot.names import unit
from ..record import record
from ..system.progress import Show
from . import write
from .motion import Motion, moved
from .svg import film as svg_film
from .tracks import tracks

KINDS = (".mp4", ".webm", ".gif", ".svg")
SAMPLES = 6  # frames of which the colours of a GIF are found
HELD = 0.5  # seconds that the last frame of a motion that ended early stays


@record
class Asked:
    """Of a film: frames a second, pixels, how long it takes."""

    fps: float
    size: tuple[int, int]
    seconds: float

    @property
    def frames(self) -> int:
        return max(2, round(self.fps * self.seconds))


@record(eq=False)
class Film:
    """`frames` that it has, of a motion that may have ended before."""

    frames: int
    motion: Motion


def film(described: Described, asked: Asked, path: Path, show: Show) -> Film:
    """Made at `path`, a file of a scratch folder. A motion without rows makes none."""
    settings, found = described.settings, described.description
    motion = moved(
        described.compilation, described.library, settings, asked.frames, asked.fps,
        lambda part: show(0.3 * part, "integrated"),
    )  # fmt: skip
    if not len(motion.t):
        return Film(0, motion)
    made, _ = tracks(found["drawing"], motion, asked.size)  # type: ignore[arg-type]
    title = str(found["model"]).replace("_", " ")
    title += f", {found['scene']}".replace("_", " ") if found["scene"] else ""
    times = motion.t[:: motion.fine]
    if path.suffix == ".svg":
        seconds = asked.seconds * len(times) / asked.frames
        path.write_text(svg_film(made, asked.size, seconds, title), encoding="utf-8")
        show(1.0, "")
        return Film(len(times), motion)
    from .raster import Raster

    raster = Raster(made, asked.size, title)
    of = "" if described.compilation.model.dimensionless else f" {unit('s')}"
    digits = max(0, int(numpy.ceil(-numpy.log10(max(float(settings.until), 1e-12) / 100))))

    def drawn() -> Iterator[numpy.ndarray]:
        for k, t in enumerate(times):
            show(0.3 + 0.7 * k / len(times), f"frame {k + 1} of {len(times)}")
            frame = raster.frame(k, f"t = {t:.{digits}f}{of}")
            yield frame
        if len(times) < asked.frames:
            for _ in range(round(HELD * asked.fps)):
                yield frame

    if path.suffix == ".gif":
        some = numpy.linspace(0, len(times) - 1, SAMPLES).round().astype(int)
        seen = [raster.frame(int(k), "t = 0") for k in some]
        write.gif(drawn(), seen, asked.fps, path)
    else:
        write.video(drawn(), asked.size, asked.fps, path)
    return Film(len(times), motion)
