"""The default picture of a chart: a method looks the same in each, and everything can be read."""

from __future__ import annotations

import math
from itertools import combinations

import numpy
import pytest

from pkgen.analysis.chart import chart, draw, picture, reference, spectrum
from pkgen.analysis.chart.answer import Answer
from pkgen.analysis.chart.errors import KINDS
from pkgen.analysis.chart.panel import Curve
from pkgen.analysis.chart.points import ChartedMethod, Point, Track
from pkgen.analysis.chart.rows import Rows
from pkgen.plot import style
from pkgen.plot.methods import mark
from pkgen.plot.style import Look

SMALLEST = 6.0  # points
LOOKS = [Look(90.0), Look(180.0, dark=True)]
NAMES = ("gauss", "gsl_rk8pd", "dop853", "rkmk8", "blanes_moan6", "symplectic_euler")


def point(setting: float, error: float, seconds: float, lucky: bool = False) -> Point:
    told = "any", setting, "PK_DONE", "", False, 1.0, error, seconds
    return Point(*told, 1, 0, 1, 0, round(1e6 * seconds), 0.0, lucky=lucky)


def charted(names=NAMES) -> chart.Chart:
    """Of methods each of which is the cheapest somewhere."""
    tracks = []
    for k, name in enumerate(names):
        at = 0.5 + 1.2 * k  # where it is
        costs = [1e-5 * math.exp(1.5 * (0.05 * at**2 + (0.8 - 0.1 * at) * j)) for j in range(9)]
        made = [point(0.5**j, 10.0 ** -(1.5 * j + 1), cost) for j, cost in enumerate(costs)]
        tracks.append(Track(ChartedMethod(name, 4), tuple(made)))
    known = reference.Reference(Rows(*numpy.ones((3, 1))), numpy.ones(1), 1, 0, 0, 1.0, "double", 1)
    found = spectrum.Spectrum(omega=1.0, rho=0.0, until=1.0)
    about = "m", "", [], 1.0, KINDS["final"], 1, known, found, tracks, {}
    answers = [Answer(1e-3, axis, None, None, "none") for axis in ("seconds", "work")]
    return chart.Chart(*about, answers)


def drawn(of: chart.Chart, look: Look):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with pyplot.rc_context({**style.LOOK, **style.DARK} if look.dark else style.LOOK):
        figure = picture.picture(of, "seconds", look)
        figure.canvas.draw()
        pyplot.close(figure)
    return figure


def looks(axes) -> set[tuple[str, str]]:
    """Colours and markers of curves."""
    return {(x.get_color(), x.get_marker()) for x in axes.lines if x.get_linewidth() > 1}


@pytest.mark.parametrize("dark", (False, True))
def test_a_method_looks_the_same_in_all_pictures(dark: bool) -> None:
    for names in (NAMES, NAMES[::-1], NAMES[2:4]):
        figure = drawn(charted(names), Look(dark=dark))
        assert looks(figure.axes[0]) == {mark(name, dark) for name in names}
    import matplotlib.pyplot as pyplot

    for make in (draw._overview, draw._families):
        figure = make(charted())
        seen = {look for axes in figure.axes for look in looks(axes)}
        assert {mark(name) for name in NAMES} <= seen
        pyplot.close(figure)


@pytest.mark.parametrize("look", LOOKS, ids=("column", "page"))
def test_no_text_lies_over_another_or_is_too_small(look: Look) -> None:
    figure = drawn(charted(), look)
    (axes,) = figure.axes
    texts = [*axes.texts, *figure.texts, axes.xaxis.label, axes.yaxis.label]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    texts += [t for t in axes.get_xticklabels() if left <= t.get_position()[0] <= right]
    texts += [t for t in axes.get_yticklabels() if low <= t.get_position()[1] <= high]
    assert {*NAMES} <= {text.get_text() for text in texts}
    assert min(text.get_fontsize() for text in texts) >= SMALLEST
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts]
    assert not [(a, b) for (a, of_a), (b, of_b) in combinations(boxes, 2) if of_a.overlaps(of_b)]
    page = figure.bbox.padded(2)
    assert not [text for text, box in boxes if page.count_contains(box.corners()) < 4]


def test_the_axis_ends_where_errors_and_names_do() -> None:
    axes = drawn(charted(), Look()).axes[0]
    least = 10.0 ** -(1.5 * 8 + 1)
    assert 1e-5 * least < axes.get_xlim()[0] < least
    assert all(x >= 0.99 * least for x in axes.get_xticks())


def test_a_curve_joins_what_nothing_beats() -> None:
    """A run that is dearer and less accurate, and one by luck, are pale points beside it."""
    made = (
        point(1.0, 1e-2, 1.0), point(0.5, 5e-4, 1.5, lucky=True), point(0.4, 5e-3, 2.5),
        point(0.3, 1e-3, 2.0), point(0.2, 1e-4, 3.0),
    )  # fmt: skip
    curve = Curve(Track(ChartedMethod("any", 4), made), "seconds", lambda p: p.error, None)
    assert [x for x, _ in curve.best()] == [1e-2, 1e-3, 1e-4]
