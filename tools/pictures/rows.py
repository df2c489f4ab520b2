"""What pictures are drawn with: rows of `pkgen run`, panels, the look of pkgen's own pictures."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

from pkgen.plot.style import DPI, LOOK, PAGE

ROOT = Path(__file__).resolve().parent.parent.parent
OUTPUT = ROOT / "docs" / "pictures"
MODELS = ROOT / "models"
COLOURS = 256  # of a file: half of the bytes


class Rows:
    """The rows of one run by the names of their columns, and its report."""

    def __init__(self, model: str, *words: object):
        with tempfile.TemporaryDirectory() as directory:
            path = Path(directory, "rows.npy")
            command = [sys.executable, "-m", "pkgen", "run", MODELS / model, *words, "-o", path]
            done = subprocess.run([str(w) for w in command], capture_output=True, text=True)
            if done.returncode not in (0, 4):  # 4: with other settings expectations may be missed
                raise SystemExit(f"pictures: {model}: {done.stderr}")
            self.data = np.load(path)
            told = json.loads(Path(f"{path}.json").read_text(encoding="utf-8"))
        self.report = told["report"]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.data[name]

    def family(self, name: str) -> np.ndarray:
        """A column a member."""
        members = [x for x in self.data.dtype.names if x.startswith(f"{name}[")]
        return np.stack([self.data[x] for x in members], axis=1)


def panels(count: int, width: float = 4.0, height: float = 4.0):
    """Side by side over a page, as high to their width."""
    high = PAGE / count * height / width
    figure, axes = plt.subplots(1, count, figsize=(PAGE, high), squeeze=False)
    return figure, list(axes[0])


def drawn(make: Callable[[], plt.Figure]) -> bytes:
    """As a PNG."""
    with plt.rc_context(LOOK):
        figure = make()
        figure.tight_layout()
        file, few = io.BytesIO(), io.BytesIO()
        figure.savefig(file, dpi=DPI)
        plt.close(figure)
    Image.open(file).convert("RGB").quantize(COLOURS).save(few, "png", optimize=True)
    return few.getvalue()
