"""Elements of an HTML page. Cells and lines are given as HTML; other texts are escaped here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from . import mathml
from .shown import Where


def heading(text: str) -> str:
    return f"<h2>{escape(text)}</h2>"


def lead(text: str) -> str:
    return f'<p class="lead">{escape(text)}</p>'


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], kind: str = "") -> str:
    """Returns a table; columns whose cells are all empty are left out."""
    rows = [tuple(row) for row in rows]
    kept = [k for k, _ in enumerate(headings) if any(row[k] for row in rows)]
    head = "".join(f'<th scope="col">{escape(headings[k])}</th>' for k in kept)
    lines = ["".join(f"<td>{row[k]}</td>" for k in kept) for row in rows]
    body = "\n".join(f"<tr>{line}</tr>" for line in lines)
    named = f' class="{kind}"' if kind else ""
    content = f"<thead><tr>{head}</tr></thead>\n{body}"
    return f'<div class="wide"{_reached(rows)}><table{named}>{content}</table></div>'


def _reached(rows: Sequence[Sequence[str]]) -> str:
    """Returns the HTML attribute by which the keyboard can scroll a table, if the table may be too
    wide for the page; otherwise ""."""
    columns = zip(*rows, strict=True)
    wide = sum(max(mathml.width(cell) for cell in column) + 2 for column in columns)
    return ' tabindex="0"' if wide > mathml.NARROW else ""


def facts_table(rows: Iterable[tuple[str, str]]) -> str:
    """Returns a table whose first column has the row headings."""
    rows = list(rows)
    body = "\n".join(f'<tr><th scope="row">{name}</th><td>{text}</td></tr>' for name, text in rows)
    return f'<div class="wide"{_reached(rows)}><table class="facts">{body}</table></div>'


def listed(lines: Iterable[str]) -> str:
    return "<ul>" + "\n".join(f"<li>{line}</li>" for line in lines) + "</ul>"


def details(summary: str, *parts: str) -> str:
    inner = "\n".join(parts)
    return f"<details><summary>{escape(summary)}</summary>\n{inner}</details>"


def where(shown: Where) -> list[str]:
    """Returns formulas, followed by the definitions of the names in them."""
    if shown.operations:
        return [f"<p>Too long to be shown: {shown.operations:,} operations, written out.</p>"]
    return [*map(mathml.formula, shown.formulas), *named(shown.named)]


def named(formulas: Sequence[Sequence[str]], notes: Sequence[str] = ()) -> list[str]:
    if not formulas:
        return []
    notes = notes or [""] * len(formulas)
    inner = "\n".join(
        mathml.formula(chunks, escape(note)) for chunks, note in zip(formulas, notes, strict=True)
    )
    return [f'<div class="where"><p>where</p>\n{inner}</div>']
