"""The map of a sweep for a live page: an image, and for each pixel a member and its start."""

from __future__ import annotations

import base64
import io

import numpy
from matplotlib import colormaps
from matplotlib.image import imsave

from pkgen.plot.draw import coloured

from .map import Map

PIXELS = 300  # pixels along an axis; the page then has about 3 MB


def described(found: Map, keys: dict[str, str]) -> dict[str, object]:
    """Returns the page's data. `keys` maps each column of a sampled quantity to its name in the
    page's address."""
    name, low, high = coloured(found.values)
    colours = colormaps[name]
    rows, columns = found.values.shape
    pixels = colours((found.values - low) / ((high - low) or 1.0))
    pixels[~numpy.isfinite(found.values)] = 0  # transparent
    bar = colours(numpy.linspace(0, 1, 256))[None, :]
    return {
        "title": found.title,
        "value": found.value,
        "x": {"label": found.x.label, "ends": list(found.x.limits)},
        "y": {"label": found.y.label, "ends": list(found.y.limits)},
        "columns": columns,
        "rows": rows,
        "image": _image(pixels[::-1]),
        "scale": {"low": low, "high": high, "image": _image(bar)},
        "members": _numbers(found.first),
        "values": _numbers(found.values),
        "drawn": [{"key": keys[name], "of": _numbers(x)} for name, x in found.drawn.items()],
    }


def _image(pixels: numpy.ndarray) -> str:
    file = io.BytesIO()
    imsave(file, pixels, format="png", metadata={"Software": None})
    return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"


def _numbers(values: numpy.ndarray) -> str:
    return base64.b64encode(values.astype("<f8").tobytes()).decode()
