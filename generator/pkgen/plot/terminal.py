"""Renders pictures in a terminal, with eight Braille dots per character.

Without colours or Unicode, lines are drawn by characters such as * and +, one per cell.
"""

from __future__ import annotations

import math
import sys
import unicodedata
from collections.abc import Sequence
from dataclasses import replace

import numpy
from rich.console import Console
from rich.text import Text

from ..front.words import greek
from .picture import Axis, Image, Line, Panel, Picture

COLOURS = ("bright_blue", "red", "green", "magenta", "yellow", "cyan", "white")
MARKS = "*+ox#%@"
SHADES = " .:-=+*#%@"
# Bits of the dots of a Braille character, by row and column.
DOTS = numpy.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_ASCII = {
    "′": "'",
    "·": "*",
    "²": "^2",
    "³": "^3",
    "│": "|",
    "└": "+",
    "─": "-",
    "┤": "|",
    "━": "=",
}
HIGH, LOW = 22, 8  # most and fewest lines of text per panel
MARGIN = 10
FINE = 4000  # most interpolated points between two rows


def show(picture: Picture, console: Console | None = None) -> None:
    console = console or Console(file=sys.stdout, highlight=False)
    for line in lines(picture, console):
        console.print(line, no_wrap=True, overflow="crop", crop=True)


def lines(picture: Picture, console: Console) -> list[Text]:
    coloured = console.color_system is not None
    plain = not (console.encoding or "").lower().startswith("utf")
    width = max(40, min(console.width, 160))
    count = len(picture.panels)
    height = max(LOW, min(HIGH, (max(24, console.height) - 4) // count - 3))
    found = [Text(_ascii(picture.title) if plain else picture.title, "bold")]
    for panel in picture.panels:
        found += _panel(_spelt(panel) if plain else panel, width, height, coloured, plain)
    if plain:
        found = [Text(_ascii(text.plain)) for text in found]
    return found if picture.title else found[1:]


def _spelt(panel: Panel) -> Panel:
    """Returns the panel with ASCII labels, before widths are measured."""

    def axis(one: Axis | None) -> Axis | None:
        return one and replace(one, label=_ascii(one.label))

    named = tuple(replace(line, label=_ascii(line.label)) for line in panel.lines)
    image = panel.image and replace(panel.image, label=_ascii(panel.image.label))
    axes = {"x": axis(panel.x), "y": axis(panel.y), "z": axis(panel.z)}
    return replace(panel, lines=named, image=image, **axes)


def _ascii(text: str) -> str:
    """Returns the text in ASCII."""
    text = "".join(_ASCII.get(c) or greek(c) or c for c in text)
    return unicodedata.normalize("NFKD", text).encode("ascii", "replace").decode()


def _panel(panel: Panel, width: int, height: int, coloured: bool, plain: bool) -> list[Text]:
    if panel.z is not None:
        panel = _seen(panel)
    columns = width - MARGIN - 2
    head = Text(panel.y.label, "bold")
    if panel.image is not None:
        body, x, y = _image(panel.image, columns, height)
        head = Text(f"{panel.image.label}: {_range(panel.image)}", "bold")
    else:
        x, y = _span(panel, "x"), _span(panel, "y")
        if panel.equal:
            x, y = _equal(x, y, columns * 2, height * 4)
        marks = plain or (not coloured and _several(panel))
        draw = _marked if marks else _dotted
        body = draw(panel, x, y, columns, height)
        head.append_text(_legend(panel, coloured, marks))
    found = [head]
    ticks = {0: y[1], height // 2: (y[0] + y[1]) / 2, height - 1: y[0]}
    for row, text in enumerate(body):
        mark = _number(ticks[row], panel.y) if row in ticks else ""
        edge = "┤" if row in ticks else "│"
        found.append(Text.assemble((f"{mark:>{MARGIN}}{edge}", "dim"), text))
    found.append(Text(" " * MARGIN + "└" + "─" * columns, "dim"))
    low, high = _number(x[0], panel.x), _number(x[1], panel.x)
    middle = panel.x.label.center(max(0, columns - len(low) - len(high)))
    found.append(Text(" " * MARGIN + f" {low}{middle}{high}", "dim"))
    return found


def _several(panel: Panel) -> bool:
    return len({line.colour for line in panel.lines}) > 1


def _legend(panel: Panel, coloured: bool, marks: bool) -> Text:
    found = Text()
    named = [line for line in panel.lines if line.label and line.kind != "back"]
    for line in named if len(named) > 1 else []:
        sign = MARKS[line.colour % len(MARKS)] if marks else "━"
        found.append("   ")
        found.append(sign, COLOURS[line.colour % len(COLOURS)] if coloured else "")
        found.append(f" {line.label}")
    return found


def _on(axis: Axis, values: numpy.ndarray) -> numpy.ndarray:
    if not axis.log:
        return values
    with numpy.errstate(all="ignore"):
        return numpy.where(values > 0, numpy.log10(numpy.where(values > 0, values, 1)), numpy.nan)


def _number(x: float, axis: Axis) -> str:
    return f"{10**x if axis.log else x:.3g}"


def _span(panel: Panel, which: str) -> tuple[float, float]:
    axis: Axis = getattr(panel, which)
    if axis.limits is not None:
        low, high = _on(axis, numpy.array(axis.limits, float))
        return float(low), float(high)
    values = numpy.concatenate([_on(axis, getattr(line, which)) for line in panel.lines] or [[]])
    values = values[numpy.isfinite(values)]
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if not high > low:
        pad = abs(low) * 0.05 or 0.5
        return low - pad, high + pad
    return low, high


def _equal(
    x: tuple[float, float], y: tuple[float, float], across: int, up: int
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Widens the ranges of x and y so that both axes have equal scales. The dots of Braille
    characters in a terminal are about square."""
    size = max((x[1] - x[0]) / across, (y[1] - y[0]) / up)

    def wide(span: tuple[float, float], dots: int) -> tuple[float, float]:
        middle = (span[0] + span[1]) / 2
        return middle - size * dots / 2, middle + size * dots / 2

    return wide(x, across), wide(y, up)


def _dotted(
    panel: Panel, x: tuple[float, float], y: tuple[float, float], columns: int, height: int
) -> list[Text]:
    bits = numpy.zeros((height, columns), int)
    colours = numpy.full((height, columns), -1)
    # The first line is drawn last, so that it is above the others.
    for line in reversed(panel.lines):
        i, j = _places(panel, line, x, y, 2 * columns, 4 * height)
        numpy.bitwise_or.at(bits, (j // 4, i // 2), DOTS[j % 4, i % 2])
        colours[j // 4, i // 2] = line.colour
    found = []
    for row, own in zip(bits, colours, strict=True):
        text = Text()
        for bit, colour in zip(row, own, strict=True):
            sign = chr(0x2800 + int(bit)) if bit else " "
            text.append(sign, COLOURS[colour % len(COLOURS)] if colour >= 0 else "")
        found.append(text)
    return found


def _marked(
    panel: Panel, x: tuple[float, float], y: tuple[float, float], columns: int, height: int
) -> list[Text]:
    rows = numpy.full((height, columns), " ")
    for line in reversed(panel.lines):
        i, j = _places(panel, line, x, y, columns, height)
        rows[j, i] = "." if line.kind == "back" else MARKS[line.colour % len(MARKS)]
    return [Text("".join(row)) for row in rows]


def _places(
    panel: Panel,
    line: Line,
    x: tuple[float, float],
    y: tuple[float, float],
    across: int,
    up: int,
) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns the column and row indices of the dots of a line; row 0 is at the top."""
    a = (_on(panel.x, line.x) - x[0]) / (x[1] - x[0]) * (across - 1)
    b = (_on(panel.y, line.y) - y[0]) / (y[1] - y[0]) * (up - 1)
    if line.kind != "points" and len(a) > 1:
        a, b = _filled(a, b, line.strands)
    with numpy.errstate(invalid="ignore"):
        good = (a > -0.5) & (a < across - 0.5) & (b > -0.5) & (b < up - 0.5)
    i, j = numpy.rint(a[good]).astype(int), numpy.rint(b[good]).astype(int)
    return i, up - 1 - j


def _filled(
    a: numpy.ndarray, b: numpy.ndarray, strands: numpy.ndarray | None
) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Interpolates between points, so that lines have no gaps."""
    gaps = numpy.maximum(numpy.abs(numpy.diff(a)), numpy.abs(numpy.diff(b)))
    gaps = numpy.where(numpy.isfinite(gaps), gaps, 0)
    if strands is not None:
        gaps[strands[1:] - 1] = 0  # trajectories are not joined to each other
    counts = numpy.minimum(numpy.ceil(gaps).astype(int) + 1, FINE)
    begin = numpy.repeat(numpy.arange(len(counts)), counts)
    part = numpy.arange(len(begin)) - numpy.repeat(numpy.cumsum(counts) - counts, counts)
    part = part / numpy.repeat(counts, counts)
    if strands is not None:
        part[numpy.isin(begin, strands[1:] - 1)] = 0
    with numpy.errstate(invalid="ignore"):
        more = (v[begin] + part * (v[begin + 1] - v[begin]) for v in (a, b))
        x, y = (numpy.append(m, v[-1]) for m, v in zip(more, (a, b), strict=True))
    return x, y


def _seen(panel: Panel) -> Panel:
    """Projects a panel in space to a plane, seen from the side and above, as in matplotlib."""
    turn, lift = math.radians(-60), math.radians(25)

    def flat(line: Line) -> Line:
        z = numpy.zeros(len(line.x)) if line.z is None else line.z
        right = -math.sin(turn) * line.x + math.cos(turn) * line.y
        depth = math.cos(turn) * line.x + math.sin(turn) * line.y
        up = math.cos(lift) * z - math.sin(lift) * depth
        return Line(line.label, right, up, line.colour, line.kind, None, line.strands)

    names = f"{panel.x.label}, {panel.y.label}, {panel.z.label} seen from the side"
    flat_lines: Sequence[Line] = [flat(line) for line in panel.lines]
    return Panel(Axis(""), Axis(names), tuple(flat_lines), equal=True)


def _image(
    image: Image, columns: int, height: int
) -> tuple[list[Text], tuple[float, float], tuple[float, float]]:
    rows = numpy.linspace(0, len(image.y) - 1, min(height, len(image.y))).round().astype(int)[::-1]
    times = numpy.linspace(0, len(image.x) - 1, columns).round().astype(int)
    values = image.values[rows][:, times]
    finite = values[numpy.isfinite(values)]
    low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 1.0)
    scaled = numpy.nan_to_num((values - low) / ((high - low) or 1.0)) * (len(SHADES) - 1)
    found = [Text("".join(SHADES[int(k)] for k in row)) for row in scaled]
    found += [Text(" " * columns)] * (height - len(found))
    return found, (float(image.x[0]), float(image.x[-1])), (float(image.y[0]), float(image.y[-1]))


def _range(image: Image) -> str:
    finite = image.values[numpy.isfinite(image.values)]
    if not len(finite):
        return "no number"
    return f"{finite.min():.3g} ({SHADES[1]!r}) to {finite.max():.3g} ({SHADES[-1]!r})"
