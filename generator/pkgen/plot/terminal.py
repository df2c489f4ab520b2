"""Renders pictures in a terminal, with eight Braille dots per character.

Without colours or Unicode, lines are drawn by characters such as * and +, one per cell.
"""

from __future__ import annotations

import math
import sys
import unicodedata
from collections.abc import Callable, Iterator

import numpy
from rich.console import Console
from rich.text import Text

from ..front.words import greek
from .picture import Axis, Image, Line, Panel, Picture
from .table import ends

COLOURS = ("bright_blue", "red", "green", "magenta", "yellow", "cyan", "white")
MARKS = "*+ox#%@"
SHADES = " .:-=+*#%@"
# Braille characters with one dot, by row and column.
DOTS = 0x2800 | numpy.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
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
Ends = tuple[float, float]
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
    found = [Text(picture.title, "bold")]
    for panel in picture.panels:
        marks = plain or (not coloured and len({line.colour for line in panel.lines}) > 1)
        # ASCII labels come first, since widths are measured.
        found += _panel(panel, width, height, marks, _ascii if plain else str)
    if plain:
        found = [Text(_ascii(text.plain)) for text in found]
    return found if picture.title else found[1:]


def _ascii(text: str) -> str:
    """Returns the text in ASCII."""
    text = "".join(_ASCII.get(c) or greek(c) or c for c in text)
    return unicodedata.normalize("NFKD", text).encode("ascii", "replace").decode()


def _panel(
    panel: Panel, width: int, height: int, marks: bool, spelt: Callable[[str], str]
) -> list[Text]:
    if panel.z is not None:
        panel = _seen(panel)
    columns = width - MARGIN - 2
    if panel.image is not None:
        head, body, x, y = _image(panel.image, columns, height)
        found = [Text(spelt(head), "bold")]
    else:
        x, y = _span(panel, "x"), _span(panel, "y")
        if panel.equal:
            x, y = _equal(x, y, columns * 2, height * 4)
        body = _drawn(panel, x, y, columns, height, marks)
        found = [Text(spelt(panel.y.label), "bold").append_text(_legend(panel, marks, spelt))]
    ticks = {0: y[1], height // 2: (y[0] + y[1]) / 2, height - 1: y[0]}
    for row, text in enumerate(body):
        mark = _number(ticks[row], panel.y) if row in ticks else ""
        edge = "┤" if row in ticks else "│"
        found.append(Text.assemble((f"{mark:>{MARGIN}}{edge}", "dim"), text))
    found.append(Text(" " * MARGIN + "└" + "─" * columns, "dim"))
    low, high = _number(x[0], panel.x), _number(x[1], panel.x)
    middle = spelt(panel.x.label).center(max(0, columns - len(low) - len(high)))
    found.append(Text(" " * MARGIN + f" {low}{middle}{high}", "dim"))
    return found


def _legend(panel: Panel, marks: bool, spelt: Callable[[str], str]) -> Text:
    found = Text()
    for line in panel.named if len(panel.named) > 1 else []:
        sign = MARKS[line.colour % len(MARKS)] if marks else "━"
        found.append("   ").append(sign, COLOURS[line.colour % len(COLOURS)])
        found.append(f" {spelt(line.label)}")
    return found


def _on(axis: Axis, values: numpy.ndarray) -> numpy.ndarray:
    if not axis.log:
        return values
    with numpy.errstate(all="ignore"):
        return numpy.where(values > 0, numpy.log10(numpy.where(values > 0, values, 1)), numpy.nan)


def _number(x: float, axis: Axis) -> str:
    return f"{10**x if axis.log else x:.3g}"


def _span(panel: Panel, which: str) -> Ends:
    axis: Axis = getattr(panel, which)
    if axis.limits is not None:
        low, high = _on(axis, numpy.array(axis.limits, float))
        return float(low), float(high)
    values = numpy.concatenate([_on(axis, getattr(line, which)) for line in panel.lines] or [[]])
    low, high = ends(values)
    if not high > low:
        pad = abs(low) * 0.05 or 0.5
        return low - pad, high + pad
    return low, high


def _equal(x: Ends, y: Ends, across: int, up: int) -> tuple[Ends, Ends]:
    """Widens the ranges of x and y so that both axes have equal scales. The dots of Braille
    characters in a terminal are about square."""
    size = max((x[1] - x[0]) / across, (y[1] - y[0]) / up)

    def wide(span: Ends, dots: int) -> Ends:
        middle = (span[0] + span[1]) / 2
        return middle - size * dots / 2, middle + size * dots / 2

    return wide(x, across), wide(y, up)


def _drawn(panel: Panel, x: Ends, y: Ends, columns: int, height: int, marks: bool) -> list[Text]:
    """Returns the lines of a panel as Braille dots, or as marks."""
    across, up = (1, 1) if marks else DOTS.shape[::-1]
    codes, colours = numpy.zeros((height, columns), int), numpy.zeros((height, columns), int)
    for line in reversed(panel.lines):  # the first line is above the others
        i, j = _places(panel, line, x, y, across * columns, up * height)
        cells = j // up, i // across
        colours[cells] = line.colour % len(COLOURS)
        if marks:
            codes[cells] = ord("." if line.kind == "back" else MARKS[line.colour % len(MARKS)])
        else:
            numpy.bitwise_or.at(codes, cells, DOTS[j % up, i % across])
    return [
        Text.assemble(*((chr(c), COLOURS[k]) if c else " " for c, k in zip(*row, strict=True)))
        for row in zip(codes, colours, strict=True)
    ]


def _places(
    panel: Panel, line: Line, x: Ends, y: Ends, across: int, up: int
) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns the column and row indices of the dots of a line; row 0 is at the top."""
    a = (_on(panel.x, line.x) - x[0]) / (x[1] - x[0]) * (across - 1)
    b = (_on(panel.y, line.y) - y[0]) / (y[1] - y[0]) * (up - 1)
    if line.kind != "points" and len(a):
        a, b = _filled(a, b, line.strands)
    with numpy.errstate(invalid="ignore"):
        good = (a > -0.5) & (a < across - 0.5) & (b > -0.5) & (b < up - 0.5)
    i, j = numpy.rint(a[good]).astype(int), numpy.rint(b[good]).astype(int)
    return i, up - 1 - j


def _filled(
    a: numpy.ndarray, b: numpy.ndarray, strands: numpy.ndarray | None
) -> Iterator[numpy.ndarray]:
    """Interpolates between points, so that lines have no gaps, but for those between strands."""
    ends = () if strands is None else strands[1:]
    a, b = numpy.insert(a, ends, numpy.nan), numpy.insert(b, ends, numpy.nan)
    with numpy.errstate(invalid="ignore"):
        gaps = numpy.maximum(abs(numpy.diff(a)), abs(numpy.diff(b)))
    counts = numpy.clip(numpy.ceil(numpy.nan_to_num(gaps)), 1, FINE)
    places = numpy.append(0, numpy.cumsum(counts))
    return (numpy.interp(numpy.arange(places[-1] + 1), places, v) for v in (a, b))


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
    return Panel(Axis(""), Axis(names), tuple(map(flat, panel.lines)), equal=True)


def _image(image: Image, columns: int, height: int) -> tuple[str, list[Text], Ends, Ends]:
    rows = numpy.linspace(0, len(image.y) - 1, min(height, len(image.y))).round().astype(int)[::-1]
    times = numpy.linspace(0, len(image.x) - 1, columns).round().astype(int)
    low, high = ends(image.values)
    scaled = (image.values[rows][:, times] - low) / ((high - low) or 1.0)
    shades = numpy.clip(numpy.nan_to_num(scaled), 0, 1) * (len(SHADES) - 1)
    found = [Text("".join(SHADES[int(k)] for k in row)) for row in shades]
    found += [Text(" " * columns)] * (height - len(found))
    head = f"{image.label}: {low:.3g} ({SHADES[1]!r}) to {high:.3g} ({SHADES[-1]!r})"
    x, y = ((float(of[0]), float(of[-1])) for of in (image.x, image.y))
    return head, found, x, y
