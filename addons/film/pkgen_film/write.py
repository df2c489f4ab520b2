"""Writes frames to files: MP4 and WebM by ffmpeg, if installed; GIF by Pillow."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy

from pkgen.system import children
from pkgen.system.exits import BuildError, UsageError

CODECS = {
    ".mp4": (
        *("-c:v", "libx264", "-preset", "medium", "-crf", "20", "-pix_fmt", "yuv420p"),
        *("-movflags", "+faststart"),
    ),
    ".webm": (
        *("-c:v", "libvpx-vp9", "-crf", "32", "-b:v", "0", "-deadline", "good", "-cpu-used", "5"),
        *("-row-mt", "1", "-pix_fmt", "yuv420p"),
    ),
}
COLOURS = 128  # Number of colours of a GIF.
INK = 225  # A pixel is ink, not background, if its darkest channel is below this.
SAID = 3  # Number of lines of ffmpeg's messages that an error quotes.


def refuse(kind: str) -> None:
    """Raises UsageError if a film of this kind needs ffmpeg, which is not installed."""
    if kind in CODECS and shutil.which("ffmpeg") is None:
        raise UsageError(
            f"a {kind} is made by ffmpeg, which is not here (apt-get install ffmpeg); "
            ".gif and .svg need nothing"
        )


def video(frames: Iterable[numpy.ndarray], size: tuple[int, int], fps: float, path: Path) -> None:
    """Writes a video by ffmpeg, which reads raw frames. Raises BuildError with ffmpeg's
    messages."""
    width, height = size
    command = ["ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y"]
    command += ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", f"{width}x{height}"]
    command += ["-r", f"{fps:g}", "-i", "pipe:0", "-an", *CODECS[path.suffix]]
    command += ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", str(path)]
    said_in = path.with_name("ffmpeg.txt")
    with open(said_in, "wb") as said:
        child = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=said, stderr=said, **children.group()
        )
        try:
            for frame in frames:
                child.stdin.write(frame.tobytes())
            child.stdin.close()
        except BrokenPipeError:
            pass  # ffmpeg reports why
        except BaseException:
            child.kill()
            raise
        finally:
            code = child.wait()
    if code:
        lines = said_in.read_text(errors="replace").strip().splitlines()[-SAID:]
        raise BuildError("ffmpeg: " + " / ".join(lines or [f"ended with {code}"]))


def gif(frames: Iterable[numpy.ndarray], some: list[numpy.ndarray], fps: float, path: Path) -> None:
    """Writes a GIF. All frames have one palette, computed from the frames `some`, so that static
    parts of the picture compress well."""
    from PIL import Image

    pictures = (Image.fromarray(frame[..., :3]) for frame in frames)
    # The palette is computed from pixels that are ink, and white is added to it. Pillow merges near
    # colours, so no other colour of the palette may be near white.
    ink = numpy.concatenate([frame[frame[..., :3].min(axis=2) < INK] for frame in some])[:, :3]
    sample = Image.fromarray(numpy.ascontiguousarray(ink.reshape(-1, 1, 3)))
    found = sample.quantize(COLOURS - 1, method=Image.Quantize.MEDIANCUT).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *found[: 3 * (COLOURS - 1)]])

    def quantized() -> Iterator[Image.Image]:
        for picture in pictures:
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)

    made = quantized()
    first = next(made)
    # Durations in a GIF are in hundredths of a second.
    duration = 10 * max(2, round(100 / fps))
    first.save(
        path, save_all=True, append_images=made, duration=duration, loop=0, optimize=False,
        disposal=1,
    )  # fmt: skip
