"""Describes a chart in words: how it was measured, and its answers."""

from __future__ import annotations

import shlex

from ...system.columns import aligned
from .answer import Answer
from .chart import Chart
from .points import Track

EXACT = 1e-13
AXIS = {"seconds": "time", "work": "evaluations"}


def seconds(value: float) -> str:
    """Formats seconds with three significant digits and an SI prefix."""
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e9:.3g} ns"


def setting(answer: Answer) -> str:
    assert answer.method is not None and answer.point is not None
    return f"{answer.method.setting} {answer.point.setting:.4g}"


def preamble(chart: Chart) -> list[str]:
    lines = [
        f"{chart.model}: {chart.subtitle()}; {chart.time}",
        f"reference: {chart.reference.text(chart.unit)}",
        chart.spectrum.text(chart.unit),
        f"error: {chart.kind.said}"
        + (f"; the median of {chart.starts} starts" if chart.starts > 1 else ""),
        "time: one integration, one core to itself; evaluations: a Jacobian counts as 2n of them",
    ]
    lines += how_beside(chart)
    if chart.interrupted:
        lines.append(interrupted(chart))
    if chart.refused:
        lines.append(f"do not apply: {', '.join(chart.refused)}")
    arrived = [track for track in chart.tracks if track.good]
    exact = [track.method.name for track in arrived if _exact(track)]
    if exact and len(exact) == len(arrived):
        lines.append(
            "every method is exact here, up to round-off, at any step: the answers tell what a "
            "step costs, not what is accurate"
        )
    elif exact:
        lines.append(f"exact here, up to round-off, at any step: {', '.join(exact)}")
    return lines


def interrupted(chart: Chart) -> str:
    missing = ", ".join(chart.unmeasured)
    return "interrupted: the answers are of what was measured until then" + (
        f", without {missing}" if missing else ""
    )


def unmeasured(chart: Chart) -> list[str]:
    """Lists methods that may have been an answer but were not measured in time."""
    late: dict[str, list[str]] = {}
    for a in chart.answers:
        for name in a.unmeasured:
            late.setdefault(name, []).append(f"{a.accuracy:.0e} by {AXIS[a.axis]}")
    told = [f"{name} at {', '.join(at)}" for name, at in late.items()]
    return told and [f"not measured, and perhaps cheaper (--seconds): {'; '.join(told)}"]


def _exact(track: Track) -> bool:
    """Whether the method is exact up to round-off on the motion of the chart. Many methods are
    exact on a uniform motion, for example."""
    return all(p.error is not None and p.error < EXACT for p in track.good)


def answer_rows(chart: Chart) -> list[tuple[str, ...]]:
    """Returns a row for each answer: accuracy, measure of cost, method, setting, time, evaluations,
    error."""
    return [_row(a, AXIS[a.axis], a.point and f"{a.point.work:,}") for a in chart.answers]


def _row(a: Answer, beside: str, cost: str | None) -> tuple[str, ...]:
    head = f"{a.accuracy:.0e}", beside
    if a.point is None or a.method is None:
        return (*head, a.reason, "", "", "", "")
    time, error = seconds(a.point.seconds or 0.0), f"{a.point.error:.1e}"
    return (*head, a.method.name, setting(a), time, cost or "", error)


BESIDE = ("accuracy", "package", "method", "", "time", "beside pkgen's", "error")


def beside_rows(chart: Chart) -> list[tuple[str, ...]]:
    """Returns a row for each answer of another package: accuracy, package, method, setting, time,
    this time relative to pkgen's, error."""
    rows = []
    for b in chart.beside:
        if b.why:
            rows.append(("", b.version, b.why, "", "", "", ""))
        times = [chart.times(a) for a in b.answers]
        said = [f"{ratio:.3g}×" if ratio else "" for ratio in times]
        rows += [_row(a, b.version, x) for a, x in zip(b.answers, said, strict=True)]
    return rows


def how_beside(chart: Chart) -> list[str]:
    """Describes which function each other package calls to evaluate the model."""
    given = [f"{b.name} calls {b.takes}" for b in chart.beside if b.takes]
    return given and [
        "other packages: one call of each one's Python API, what it compiles compiled before; "
        + "; ".join(given)
    ]


HEADINGS = ("accuracy", "cheapest in", "method", "", "time", "evaluations", "error")


def command(chart: Chart, answer: Answer, model: str, given: list[str]) -> str:
    """Returns the `pkgen run` command for an answer."""
    assert answer.method is not None and answer.point is not None
    until = repr(chart.until)
    words = ["pkgen", "run", model, "--method", answer.method.name]
    words += [f"--{answer.method.setting}", repr(answer.point.setting)]
    words += ["--until", until, "--every", until, *given]
    return shlex.join(words)


def report(chart: Chart, model: str, given: list[str]) -> str:
    lines = [*preamble(chart), "", *_lined(HEADINGS, answer_rows(chart))]
    if late := unmeasured(chart):
        lines += ["", *late]
    if chart.beside:
        lines += ["", *_lined(BESIDE, beside_rows(chart))]
    runs = [command(chart, a, model, given) for a in chart.answers if a.point]
    if runs:
        lines += ["", *dict.fromkeys(runs)]
    return "\n".join(lines) + "\n"


def _lined(headings: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """Returns the rows as lines with aligned columns. A row whose setting, the fourth cell, is ""
    has a sentence in the third cell and no further cells."""
    rows = [row if row[3] else row[:3] for row in rows]
    return aligned([headings, *rows], right=(4, 5, 6))
