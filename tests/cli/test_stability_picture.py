"""The pictures of `pkgen stability`: no text lies over another, whatever is predicted."""

from __future__ import annotations

import contextlib
import io
import random
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from conftest import ROOT, no_page, seeds, written
from pkgen.__main__ import main
from pkgen.analysis.stability import classes, draw, overlay
from pkgen.analysis.stability import map as maps
from pkgen.analysis.stability.map import StabilityMap
from pkgen.analysis.stability.predict import Prediction
from pkgen.plot.style import Look

LOOKS = [Look(width, dark=dark) for width, dark in ((90.0, False), (180.0, True))]
SMALLEST = 6.0  # points, of any text
LEAST = 0.5  # points by which two boxes must overlap to count: boxes are wider than their ink
PENDULUM = "model p\ncoord a\nkinetic a'^2/2\npotential -cos(a)\nstart a = 1\n"


def mapped(monkeypatch, *arguments: object) -> StabilityMap:
    kept = []
    real = maps.make
    monkeypatch.setattr(maps, "make", lambda *given: kept.append(real(*given)) or kept[-1])
    with contextlib.redirect_stdout(io.StringIO()):
        code = main(["stability", *map(str, arguments)])
    if not kept:
        pytest.skip("there is no map of this model")
    assert code == 0
    return kept[0]


def texts(made: StabilityMap, look: Look, monkeypatch) -> dict[str, list]:
    """Boxes of all that is really written, under its text."""
    boxes: list[tuple[str, object]] = []
    real = Text.draw

    def seen(self: Text, renderer: object) -> None:
        if self.get_visible() and self.get_text().strip():
            assert self.get_fontsize() >= SMALLEST, self.get_text()
            boxes.append((self.get_text(), self.get_window_extent(renderer)))
        real(self, renderer)

    def make(look: Look):
        figure = draw.figure(made, look)
        monkeypatch.setattr(Text, "draw", seen)
        figure.set_dpi(draw.style.DPI)
        figure.canvas.draw()
        monkeypatch.setattr(Text, "draw", real)
        page = figure.bbox.padded(1)
        assert not [text for text, b in boxes if page.count_contains(b.corners()) < 4]
        return figure

    monkeypatch.setattr(draw.style, "saved", lambda *_: [])
    draw.style.written(make, Path("none"), look)
    pyplot.close("all")
    return boxes


def overlapping(boxes: list[tuple[str, object]]) -> list[tuple[str, str]]:
    return [
        (a, b)
        for (a, of_a), (b, of_b) in combinations(boxes, 2)
        if min(of_a.x1, of_b.x1) - max(of_a.x0, of_b.x0) > LEAST
        and min(of_a.y1, of_b.y1) - max(of_a.y0, of_b.y0) > LEAST
    ]


def crowded(made: StabilityMap, seed: int) -> StabilityMap:
    """As many predictions as there may be, close together, upright and aslant."""
    chance = random.Random(seed)
    lines = []
    for name, steps in made.steps.items():
        middle = chance.uniform(0, steps[-1])
        for _ in range(chance.randrange(1, 25)):
            kind = chance.choice(list(overlay.LINES))
            other = chance.randrange(4, 40) if kind in overlay.PAIRS else None
            h = abs(middle + chance.gauss(0, 0.2) * steps[-1])
            slant = chance.choice((0.0, 0.0, chance.uniform(-0.5, 0.5)))
            lines.append((Prediction(kind, name, 0, chance.randrange(4), other, h, 1.0), slant))
    rows = tuple(
        replace(
            row, predictions=tuple(replace(p, h=p.h * (1 + slant * k / 4)) for p, slant in lines)
        )
        for k, row in enumerate(made.rows)
    )
    return replace(made, rows=rows)


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> StabilityMap:
    directory = tmp_path_factory.mktemp("picture")
    model = written(directory, PENDULUM)
    with pytest.MonkeyPatch.context() as patch:
        asked = ("--methods", "verlet,rk4,gauss1,gauss2", "--points", "6x5", "--until", "20")
        return mapped(patch, model, "-o", directory, "--quick", *asked)


@pytest.mark.parametrize("look", LOOKS, ids=("column", "page"))
@pytest.mark.parametrize("seed", seeds(range(2), 2))
def test_no_text_lies_over_another(small, look: Look, seed: int, monkeypatch) -> None:
    boxes = texts(crowded(small, seed), look, monkeypatch)
    said = [text for text, _ in boxes]
    assert any(text in said for text in ("limit", "branch", "1:3", "1:4")), said
    assert not overlapping(boxes)


def test_a_cell_like_none_around_it_is_marked() -> None:
    """A column of one cell's width is a region of its own, a single cell may be luck."""
    figure, axes = pyplot.subplots()
    kinds = [["bounded"] * 6 for _ in range(5)]
    for row in kinds:
        row[4] = "growing"
    ranges = np.arange(1.0, 7.0), np.arange(1.0, 6.0)
    assert classes.UNCONFIRMED not in classes.fill(axes, *ranges, kinds, Look())
    kinds[2][1] = "drifting"
    assert {classes.UNCONFIRMED, "drifting"} <= classes.fill(axes, *ranges, kinds, Look())
    (square,) = axes.collections[-1].get_paths()
    assert square.get_extents().width == square.get_extents().height == 0.5
    assert square.contains_point((2.0, 3.0))
    classes.glyphs(axes, *ranges, kinds, Look())
    assert {line.get_marker() for line in axes.lines} == {classes.CLASSES["growing"].glyph}
    pyplot.close(figure)


def test_lines_at_the_edge_and_lines_that_end_have_their_labels() -> None:
    figure, axes = pyplot.subplots(figsize=(2, 2))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    figure.canvas.draw()
    xs = np.linspace(0, 1, 21)
    ends = np.where(xs > 0.5, 0.3 + 0.1 * xs, np.nan)
    marked = [
        overlay.Marked("branch", np.full(21, 0.99), xs, 1),
        overlay.Marked("scale", ends, xs, 1),
    ]
    overlay.label(axes, marked, Look())
    assert {text.get_text() for text in axes.texts} == {"branch", "scale"}
    frame = axes.get_window_extent()
    assert all(frame.count_contains(t.get_window_extent().corners()) == 4 for t in axes.texts)
    pyplot.close(figure)


@pytest.mark.parametrize("dark", (False, True))
def test_classes_are_told_apart_in_grey(dark: bool) -> None:
    """By how bright they are, else by their glyphs."""
    for (one, a), (other, b) in combinations(classes.CLASSES.items(), 2):
        grey = [np.dot(to_rgb(x.dark if dark else x.colour), (0.3, 0.59, 0.11)) for x in (a, b)]
        assert abs(grey[0] - grey[1]) > 0.08 or a.glyph != b.glyph, (one, other)


def test_numbers_have_three_digits() -> None:
    assert [draw.three(x) for x in (1047.3, 116.2, 2.5, 0.0026541, 1234567.0)] == [
        "1050", "116", "2.5", "0.00265", "1.23e+06",
    ]  # fmt: skip
    assert [draw.three(x, True) for x in (2.5, 1047.3, 0.0)] == ["2.50", "1050", "0.00"]


def test_formats_and_widths(tmp_path: Path, capsys) -> None:
    model = written(tmp_path, PENDULUM)
    asked = ["--methods", "rk4", "--points", "2x2", "--until", "9", "-o", str(tmp_path), "--quick"]
    assert main(["stability", str(model), *asked, "--width", "90", "--format", "pdf"]) == 0
    page = [] if no_page() else [".html"]
    assert {f.suffix for f in tmp_path.glob("p_*")} == {".svg", ".pdf", ".csv", *page}
    assert 'width="255' in (tmp_path / "p_stability.svg").read_text()[:600]  # points
    assert main(["stability", str(model), *asked, "--format", "gif"]) == 2
    assert "--format" in capsys.readouterr().err


# Every third of them; a chain's modes take minutes.
MODELS = [m for m in sorted((ROOT / "models").rglob("*.lag")) if m.parent.name != "chains"][::3]


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.stem)
def test_no_text_lies_over_another_on_the_models_maps(model, tmp_path, monkeypatch) -> None:
    made = mapped(monkeypatch, model, "-o", tmp_path, "--quick", "--points", "6x4")
    for look in LOOKS:
        assert not overlapping(texts(made, look, monkeypatch)), look
