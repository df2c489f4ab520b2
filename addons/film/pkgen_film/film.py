"""Makes a film from a described model: integrates, draws, and writes the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy

from pkgen.compiler import Compilation
from pkgen.describe.page_data import Described
from pkgen.record import record
from pkgen.run import named
from pkgen.run.simulate import Outcome
from pkgen.run.values import Values
from pkgen.system.progress import Show

from . import write
from .graph import SCENE, graph
from .motion import moved
from .svg import film as svg_film
from .tracks import Track, tracks

if TYPE_CHECKING:
    from pkgen.api.prepare import Prepared

    from .raster import Label

KINDS = (".mp4", ".webm", ".gif", ".svg")
TICKS = 50  # Approximate number of times that the clock of an SVG shows.
SAMPLES = 6  # Number of frames from which the colours of a GIF are computed.
INTEGRATED = 0.3  # Part of the progress bar that is filled when the integration ends.
HELD = 0.5  # Seconds that the last frame is shown if the motion ended early.


@record
class Asked:
    """Options of a film: frames per second, (width, height) in pixels, duration in seconds."""

    fps: float
    size: tuple[int, int]
    seconds: float
    labels: bool = True  # Whether title, time and names of bobs are shown.
    # Name of a column that is drawn as a growing graph next to the motion; "" for none.
    beside: str = ""

    @property
    def frames(self) -> int:
        return max(2, round(self.fps * self.seconds))


@record(eq=False)
class Film:
    """The number of frames of a film, and how the integration ended, perhaps before the film's
    end."""

    frames: int
    outcome: Outcome


def film(described: Described, asked: Asked, path: Path, show: Show) -> Film:
    """Writes a film to `path`, in a temporary folder; writes none if the motion has no rows."""
    compilation, settings = described.compilation, described.settings
    found = described.description
    shown = Values(compilation).shown(asked.beside, "--beside") if asked.beside else None
    motion = moved(
        compilation,
        described.library,
        settings,
        asked.frames,
        asked.fps,
        lambda part: show(INTEGRATED * part, "integrated"),
        shown,
    )
    if not len(motion.t):
        return Film(0, motion.outcome)
    width, height = asked.size
    size = (round(SCENE * width), height) if shown else asked.size
    made, _ = tracks(found["drawing"], motion, size)  # type: ignore[arg-type]
    texts = []
    if shown is not None:
        _, quantity = named.kinds(compilation)[shown.kind][shown.name]
        more, texts = graph(motion, quantity, asked.size)
        made += more
    times = motion.t[:: motion.fine]
    title = _title(str(found["model"]), str(found["scene"] or ""))
    _written(made, texts, times, title, compilation, asked, path, show)
    return Film(len(times), motion.outcome)


def of_swarm(prepared: Prepared, asked: Asked, path: Path, show: Show) -> Film:
    """Makes a film of a swarm (many motions of one model); each motion is a point of a cloud."""
    from . import swarm

    assert prepared.ensemble is not None and prepared.library is not None
    vectors = path.suffix == ".svg"
    cloud = swarm.moved(
        prepared.compilation,
        prepared.library,
        prepared.settings,
        prepared.ensemble,
        asked.frames,
        swarm.MOST_OF_VECTORS if vectors else swarm.MOST,
        lambda part: show(INTEGRATED * part, "integrated"),
    )
    if not numpy.isfinite(cloud.places).any():
        return Film(0, cloud.outcome)
    made, labels = swarm.tracks(cloud, asked.size, vectors)
    scene = prepared.scene.name if prepared.scene else ""
    title = _title(prepared.compilation.declared.name, scene)
    _written(made, labels, cloud.t, title, prepared.compilation, asked, path, show)
    return Film(len(cloud.t), cloud.outcome)


def _title(model: str, scene: str) -> str:
    return ", ".join(word for word in (model, scene) if word).replace("_", " ")


def _clock(times: numpy.ndarray, of: str) -> list[tuple[str, float]]:
    """Returns about TICKS round times of the motion as text, each with the relative time of the
    film (0 to 1) at which it appears."""
    span = float(times[-1] - times[0])
    if not span > 0:
        return []
    size = 10.0 ** numpy.floor(numpy.log10(span / TICKS))
    step = next(k * size for k in (1, 2, 5, 10) if k * size >= span / TICKS)
    digits = max(0, int(-numpy.floor(numpy.log10(step) + 1e-9)))
    ticks = step * numpy.arange(int(span / step + 1e-9) + 1)
    return [(f"t = {t:.{digits}f}{of}", float(t / span)) for t in ticks if t < span]


def _written(
    made: list[Track],
    labels: list[Label],
    times: numpy.ndarray,
    title: str,
    compilation: Compilation,
    asked: Asked,
    path: Path,
    show: Show,
) -> None:
    """Draws the tracks, and writes the film."""
    unit = min(asked.size) / 720
    texts = [(title, 20 * unit, asked.size[1] - 36 * unit)] if asked.labels else []
    texts += labels
    if not asked.labels:
        made = [replace(track, label="") for track in made]
    of = "" if compilation.model.dimensionless else " s"
    if path.suffix == ".svg":
        seconds = asked.seconds * len(times) / asked.frames
        clock = _clock(times, of) if asked.labels else []
        text = svg_film(made, asked.size, seconds, title, texts, clock)
        path.write_text(text, encoding="utf-8")
        return
    from .raster import Raster

    raster = Raster(made, asked.size, texts)
    digits = max(0, int(numpy.ceil(-numpy.log10(max(float(times[-1]), 1e-12) / 100))))

    def drawn() -> Iterator[numpy.ndarray]:
        for k, t in enumerate(times):
            part = INTEGRATED + (1 - INTEGRATED) * k / len(times)
            show(part, f"frame {k + 1} of {len(times)}")
            frame = raster.frame(k, f"t = {t:.{digits}f}{of}" if asked.labels else "")
            yield frame
        if len(times) < asked.frames:
            for _ in range(round(HELD * asked.fps)):
                yield frame

    if path.suffix == ".gif":
        some = numpy.linspace(0, len(times) - 1, SAMPLES).round().astype(int)
        seen = [raster.frame(int(k), "t = 0" if asked.labels else "") for k in some]
        write.gif(drawn(), seen, asked.fps, path)
    else:
        write.video(drawn(), asked.size, asked.fps, path)
