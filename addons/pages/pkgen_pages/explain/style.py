"""The CSS of the pages of `html.py`, and the font of their formulas.

Formulas need a font with an OpenType MATH table, for stretching brackets, accents and roots.
Windows has Cambria Math, macOS STIX Two Math; plain Linux has none, so the page embeds a subset of
STIX (`fonts/README.md`).
"""

from __future__ import annotations

from base64 import b64encode
from functools import cache
from importlib.resources import files

_RULES = """
.explained { line-height: 1.5; max-width: 60rem }
.explained math { font-family: "pkgen math", "STIX Two Math", "Cambria Math", math;
  font-size: 1.12em }
.explained .equation { overflow-x: auto; overflow-y: hidden;
  margin: 0.55rem 0 0.55rem 1.5rem; padding: 0.25rem 0.2rem 0.25rem 2.2rem;
  text-indent: -2.2rem; line-height: 2.1; word-spacing: -0.12em }
.explained .equation > * { text-indent: 0; display: inline math }
.explained .equation > .note { display: inline; margin-left: 1.2rem; word-spacing: 0;
  font-size: 0.88em; opacity: 0.75; line-height: 1.4 }
.explained .where { margin: 0.2rem 0 0.8rem 1.5rem; padding-left: 0.8rem;
  border-left: 2px solid rgba(127, 127, 127, 0.35) }
.explained .where > p { margin: 0 0 0.1rem; font-size: 0.9em; opacity: 0.75 }
.explained .where .equation { margin: 0.1rem 0; font-size: 0.95em; line-height: 1.9 }
.explained .lead { margin: 0.9rem 0 0.2rem }
.explained .count { font-size: 0.93em; opacity: 0.75 }
.explained .wide { overflow-x: auto }
.explained table { border-collapse: collapse; font-size: 0.93em;
  font-variant-numeric: tabular-nums }
.explained th, .explained td { padding: 0.22rem 1.1rem 0.22rem 0; text-align: left;
  border-bottom: 1px solid rgba(127, 127, 127, 0.3); vertical-align: baseline }
.explained thead th, .explained .facts th { font-weight: 500; opacity: 0.75; position: static;
  background: none }
.explained .facts th { white-space: nowrap }
.explained details { margin: 0.8rem 0 }
.explained summary { cursor: pointer }
"""


@cache
def style() -> str:
    """Returns CSS for the head of a page that contains a fragment; a data: URL holds the font."""
    font = files(__package__).joinpath("fonts/math.woff2").read_bytes()
    data = b64encode(font).decode("ascii")
    face = f'@font-face {{ font-family: "pkgen math"; src: url(data:font/woff2;base64,{data}) }}'
    return f"{face}\n{_RULES}"
