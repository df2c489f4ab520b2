"""One self-contained HTML page: the pictures inline, the answers, every point, the settings. It
asks for nothing from anywhere."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path

from .. import __version__
from . import table
from .chart import Chart
from .text import HEADINGS, answer_rows, preamble

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; color: #1a1a1a }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem }
svg { width: 100%; height: auto }
table { border-collapse: collapse; font-size: 0.86rem; font-variant-numeric: tabular-nums }
th, td { padding: 0.15rem 0.6rem; text-align: right; border-bottom: 1px solid #e2e2e2 }
th { position: sticky; top: 0; background: #fff }
td:first-child, th:first-child, td.text { text-align: left }
tr.failed td { color: #8a3a10; background: #fbf4f0 }
pre { background: #f6f6f6; padding: 0.8rem; overflow-x: auto; font-size: 0.84rem }
"""

POINTS = ("method", "step", "rtol", "outcome", "error", "seconds", "work", "evaluations", "steps")


def html(chart: Chart, report: str, pictures: list[Path]) -> str:
    name = escape(chart.model.replace("_", " "))
    texts = [path.read_text(encoding="utf-8") for path in pictures]
    drawn = "\n".join(_inline(svg, k) for k, svg in enumerate(texts))
    refused = "".join(
        f"<tr><td>{escape(method)}</td><td class=text>{escape(why)}</td></tr>"
        for method, why in chart.refused.items()
    )
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<meta charset="utf-8">\n<title>{name}: accuracy '
        f"against cost</title>\n<style>{STYLE}</style>",
        f"<h1>{name}: accuracy against cost</h1>",
        "".join(f"<p>{escape(line)}</p>" for line in preamble(chart)),
        "<h2>The cheapest here</h2>",
        _table(HEADINGS, [[escape(c) for c in row] for row in answer_rows(chart)]),
        f"<details><summary>as commands</summary><pre>{escape(report)}</pre></details>",
        "<h2>Work and precision</h2>",
        drawn,
        "<h2>Predicted limits of stability</h2>",
        _limits(chart),
        "<h2>Methods that do not apply</h2>" if refused else "",
        f"<table>{refused}</table>" if refused else "",
        "<h2>Every point</h2>",
        _points(chart),
        f"<p>pkgen {__version__}</p>\n</html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _inline(svg: str, number: int) -> str:
    """An SVG without its prologue and without addresses, its ids its own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", svg)
    svg = svg.replace("xlink:href", "href")
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>p{number}-", svg)


def _table(headings: tuple[str, ...], rows: list[list[str]]) -> str:
    head = "".join(f"<th>{escape(h)}</th>" for h in headings)
    body = "\n".join("<tr>" + "".join(f"<td>{c}</td>" for c in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _limits(chart: Chart) -> str:
    """The step that was foreseen as the last stable one beside the longest that went well."""
    rows = []
    for track in chart.tracks:
        limit = chart.spectrum.limit(track.method)
        if limit is None:
            continue
        longest = max((p.setting for p in track.good), default=None)
        failed = min((p.setting for p in track.points if p.failed), default=None)
        measured = [f"{x:.4g}" if x is not None else "" for x in (longest, failed)]
        rows.append([escape(track.method.name), f"{limit:.4g}", *measured])
    if not rows:
        return "<p>No method here has one.</p>"
    headings = ("method", "step predicted", "longest that arrived", "shortest that failed")
    return _table(headings, rows)


def _points(chart: Chart) -> str:
    kept = table.invariants(chart.tracks)
    columns = (*POINTS, *(f"drift({name})" for name in kept), "reason")
    head = "".join(f"<th>{escape(c)}</th>" for c in columns)
    lines = []
    for row in table.rows(chart.tracks):
        cells = "".join(f"<td>{_cell(row.get(c))}</td>" for c in columns)
        kind = "" if row["outcome"] == "done" else " class=failed"
        lines.append(f"<tr{kind}>{cells}</tr>")
    return f"<table><tr>{head}</tr>\n" + "\n".join(lines) + "</table>"


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else escape(str(value))
