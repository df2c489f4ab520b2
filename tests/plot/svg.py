"""What an SVG of ours shows, read back: labels, curves in the numbers of their axes."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy

from pkgen.plot.style import PALETTE

NS = "{http://www.w3.org/2000/svg}"
COLOURS = [c.lower() for c in PALETTE]


class Svg:
    def __init__(self, text: str | Path):
        text = text.read_text(encoding="utf-8") if isinstance(text, Path) else text
        self.root = ElementTree.fromstring(text)
        self.texts = ["".join(e.itertext()).strip() for e in self.root.iter(f"{NS}text")]
        self.axes = [Axes(g) for g in self.root.iter(f"{NS}g") if _is(g, "axes")]
        for axes in self.axes:
            axes.lowest = self.axes[-1].group

    @property
    def size(self) -> tuple[float, float]:
        """In millimetres."""
        width, height = (float(self.root.get(k).removesuffix("pt")) for k in ("width", "height"))
        return 25.4 / 72 * width, 25.4 / 72 * height

    def images(self) -> int:
        return sum(1 for _ in self.root.iter(f"{NS}image"))


class Axes:
    def __init__(self, group: ElementTree.Element):
        self.group = self.lowest = group  # the lowest of those that share an axis has its numbers
        self.lines = [
            path
            for g in group.iter(f"{NS}g")
            if _is(g, "line2d")
            for path in g.findall(f"{NS}path")
            if _stroke(path) in COLOURS and path.get("clip-path")
        ]

    def colours(self) -> list[int]:
        return [COLOURS.index(_stroke(path)) for path in self.lines]

    def curve(self, k: int) -> numpy.ndarray:
        """Points of a curve in the numbers of the axes, as their ticks have them."""
        places = re.findall(r"[ML] (\S+) (\S+)", self.lines[k].get("d"))
        points = numpy.array(places, float)
        return numpy.column_stack([self.scaled(w, points[:, i]) for i, w in enumerate("xy")])

    def scaled(self, which: str, places: numpy.ndarray) -> numpy.ndarray:
        at, numbers = [], []
        shared = which == "x" and not any(_numbered(g, "x") for g in self.group.iter(f"{NS}g"))
        for g in (self.lowest if shared else self.group).iter(f"{NS}g"):
            text = _numbered(g, which)
            if text:
                at.append(float([*g.iter(f"{NS}use")][-1].get(which)))
                numbers.append(float(text.replace("−", "-")))
        slope, first = numpy.polyfit(at, numbers, 1)
        return first + slope * places

    def unit(self, which: str) -> float:
        """The length of a unit, in points."""
        first, second = self.scaled(which, numpy.array([0.0, 1.0]))
        return 1 / abs(second - first)


def _numbered(group: ElementTree.Element, which: str) -> str:
    """The number at a tick; "" of what is none, or has none."""
    if not re.fullmatch(rf"{which}tick_\d+", group.get("id") or ""):
        return ""
    return "".join("".join(e.itertext()) for e in group.iter(f"{NS}text")).strip()


def _is(group: ElementTree.Element, kind: str) -> bool:
    return bool(re.fullmatch(rf"{kind}_\d+", group.get("id") or ""))


def _stroke(path: ElementTree.Element) -> str:
    found = re.search(r"stroke: (#\w{6})", path.get("style") or "")
    return found[1] if found else ""
