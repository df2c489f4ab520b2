"""The HTML page of a work-precision chart: pictures, cheapest methods, all points, settings."""

from __future__ import annotations

from html import escape
from pathlib import Path

from pkgen.analysis.chart import table
from pkgen.analysis.chart.chart import Chart
from pkgen.analysis.chart.text import (
    BESIDE,
    HEADINGS,
    answer_rows,
    beside_rows,
    preamble,
    unmeasured,
)
from pkgen.version import __version__

from . import page

POINTS = ("method", "step", "rtol", "outcome", "error", "seconds", "work", "evaluations", "steps")


def html(chart: Chart, report: str, pictures: list[Path]) -> str:
    texts = [path.read_text(encoding="utf-8") for path in pictures]
    refused = list(chart.refused.items())
    return page.document(
        f"{chart.model.replace('_', ' ')}: accuracy against cost",
        [
            "".join(f"<p>{escape(line)}</p>" for line in preamble(chart)),
            page.heading("The cheapest here"),
            page.table(HEADINGS, answer_rows(chart)),
            "".join(f"<p>{escape(line)}</p>" for line in unmeasured(chart)),
            f"<details><summary>as commands</summary><pre>{escape(report)}</pre></details>",
            page.heading("Other packages") if chart.beside else "",
            page.table(BESIDE, beside_rows(chart)) if chart.beside else "",
            page.heading("Work and precision"),
            *(page.picture(svg, k) for k, svg in enumerate(texts)),
            page.heading("Predicted limits of stability"),
            _limits(chart),
            page.heading("Methods that do not apply") if refused else "",
            page.table(("method", "why"), refused) if refused else "",
            page.heading("Every point"),
            _points(chart),
            f"<p>pkgen {__version__}</p>",
        ],
    )


def _limits(chart: Chart) -> str:
    """Returns a table of methods: predicted step limit, longest successful and shortest failed
    step."""
    rows = []
    for track in chart.tracks:
        limit = chart.spectrum.limit(track.method)
        if limit is None:
            continue
        longest = max((p.setting for p in track.good), default=None)
        failed = min((p.setting for p in track.points if p.failed), default=None)
        measured = [f"{x:.4g}" if x is not None else "" for x in (longest, failed)]
        rows.append([track.method.name, f"{limit:.4g}", *measured])
    if not rows:
        return "<p>No method here has one.</p>"
    headings = ("method", "step predicted", "longest that arrived", "shortest that failed")
    return page.table(headings, rows)


def _points(chart: Chart) -> str:
    kept = table.invariants(chart.tracks)
    columns = (*POINTS, *(f"drift({name})" for name in kept), "reason")
    outcome = columns.index("outcome")
    rows = [[_text(row.get(c)) for c in columns] for row in table.rows(chart.tracks)]
    return page.table(columns, rows, lambda row: row[outcome] != "done")


def _text(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)
