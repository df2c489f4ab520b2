"""One self-contained HTML page: the picture, the tables, the misses."""

from __future__ import annotations

from html import escape
from pathlib import Path

from . import text
from .map import StabilityMap

STYLE = """body { font: 15px/1.45 system-ui, sans-serif; max-width: 75em; margin: 2em auto;
  padding: 0 1em }
table { border-collapse: collapse; margin: .5em 0 1.5em }
th, td { text-align: left; padding: .15em .9em .15em 0; border-bottom: 1px solid #ddd;
  font-variant-numeric: tabular-nums; vertical-align: top }
.missed { color: #B00020; font-weight: bold } svg { max-width: 100%; height: auto }
h2 { margin-top: 1.6em }"""

CLASSES = """<p>With E the method's energy, S the range of v·p over the motion itself (twice the
kinetic energy that comes and goes), and [a, b] the energies of the last quarter of a run:
<b>growing</b>: E rises by more than S and goes on rising, does not come back, or rises by more
than 10<sup>4</sup> S; <b>drifting</b>: it has left where it began by more than a quarter of b − a
(symplectic and symmetric methods: and by a fifth more after four times as long);
<b>bounded</b>: neither. <b>not converged</b>, <b>wrong branch</b>, <b>not finite</b>,
<b>singular</b> are what the runtime reports. A triangle is a limit measured: 4000 steps from
10<sup>−6</sup> beside the equilibrium go no further than 10<sup>−3</sup> below it.</p>"""


def html(made: StabilityMap, svg: Path) -> str:
    name = escape(made.compilation.model.name)
    sections = [
        f"<h1>{name}: where each method fails</h1>",
        _inline(svg),
        CLASSES,
        "<h2>Misses</h2><ul>",
        *(f"<li>{escape(line)}</li>" for line in text.sentences(made)),
        "</ul>",
    ]
    for title, table in (
        ("Equilibria and their modes", text.equilibria(made)),
        ("Predicted and measured", text.predicted(made)),
        ("Growth rates at unstable equilibria", text.rates(made)),
        ("Points of each class", text.counts(made)),
    ):
        if table[1]:
            sections += [f"<h2>{title}</h2>", _table(table)]
    if text.remarks(made):
        sections += ["<h2>Remarks</h2><ul>"]
        sections += [f"<li>{escape(line)}</li>" for line in text.remarks(made)] + ["</ul>"]
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{name}: stability'
        f"</title>\n<style>{STYLE}</style></head>\n<body>\n"
        + "\n".join(sections)
        + "\n</body></html>\n"
    )


def _inline(svg: Path) -> str:
    """The picture without what a page of its own needs."""
    whole = svg.read_text(encoding="utf-8")
    return whole[whole.index("<svg") :]


def _table(table: text.Table) -> str:
    heads, rows = table
    out = ["<table><tr>", *(f"<th>{escape(h)}</th>" for h in heads), "</tr>"]
    for row in rows:
        cells = [
            f'<td class="missed">{escape(c)}</td>' if c == "MISSED" else f"<td>{escape(c)}</td>"
            for c in row
        ]
        out += ["<tr>", *cells, "</tr>"]
    return "".join(out) + "</table>"
