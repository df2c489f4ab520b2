"""Makes self-contained HTML pages: style, tables, inline pictures. They load no other files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from html import escape

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; color: #1a1a1a;
  padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem }
svg { width: 100%; height: auto }
table { border-collapse: collapse; font-size: 0.86rem; font-variant-numeric: tabular-nums }
th, td { padding: 0.15rem 0.6rem; text-align: left; border-bottom: 1px solid #e2e2e2;
  vertical-align: top }
th { position: sticky; top: 0; background: #fff }
td.number { text-align: right }
tr.failed td { color: #8a3a10; background: #fbf4f0 }
math { font-family: "STIX Two Math", "Cambria Math", "Latin Modern Math", "Noto Sans Math", math }
.equation { overflow-x: auto }
math[display="block"] { margin: 0.7rem 0 0.7rem 1.5rem; padding: 0.3rem 0 }
mtable.matrix { border: solid currentcolor; border-width: 0 1px; border-radius: 0.4em;
  margin: 0 0.15em }
mtable.matrix mtd { padding: 0.25em 0.5em }
pre { background: #f6f6f6; padding: 0.8rem; overflow-x: auto; font-size: 0.84rem }
"""
NUMBER = re.compile(r"[-+]?\d[\d.,]*(e[-+]?\d+)?( %)?")


def document(title: str, sections: Iterable[str], style: str = "") -> str:
    """Returns an HTML page of the sections that are not empty. `style` is CSS added to STYLE."""
    body = "\n".join(section for section in sections if section)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<meta charset="utf-8">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}{style}</style>\n<h1>{escape(title)}</h1>\n"
        f"{body}\n</html>\n"
    )


def heading(text: str) -> str:
    return f"<h2>{escape(text)}</h2>"


def items(lines: Iterable[str]) -> str:
    return "<ul>" + "\n".join(f"<li>{escape(line)}</li>" for line in lines) + "</ul>"


def table(
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    failed: Callable[[Sequence[str]], bool] = lambda row: False,
) -> str:
    """Returns a table of plain text; rows for which `failed` is true are marked."""
    head = "".join(f"<th>{escape(text)}</th>" for text in headings)
    lines = [f"<table><tr>{head}</tr>"]
    for row in rows:
        kind = " class=failed" if failed(row) else ""
        lines.append(f"<tr{kind}>{''.join(map(_cell, row))}</tr>")
    return "\n".join(lines) + "</table>"


def _cell(text: str) -> str:
    kind = " class=number" if NUMBER.fullmatch(text) else ""
    return f"<td{kind}>{escape(text)}</td>"


def picture(svg: str, number: int = 0) -> str:
    """Returns an SVG element without metadata and namespaces; `number` makes its ids unique."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\sxmlns(:\w+)?="[^"]*"', "", svg)
    svg = svg.replace("xlink:href", "href")
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>p{number}-", svg)
