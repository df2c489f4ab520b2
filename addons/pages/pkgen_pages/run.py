"""The HTML report of a run: status, pictures, drifts, diagnostics, events, expectations, settings.

The page loads no other files and has no scripts. Names of a model are escaped.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from pkgen.compiler import Compilation
from pkgen.plot import compose, style
from pkgen.plot.draw import encoded
from pkgen.plot.names import unit as printed
from pkgen.plot.table import Table
from pkgen.plot.view import View
from pkgen.run import diagnostics_text, named
from pkgen.system.exits import UsageError
from pkgen.version import __version__

from . import page

Rows = list[tuple[str, ...]]
TIMES = 6  # If an event has more times, only the first ones are listed.
DPI = 110  # Resolution of rasterized parts; low, since the page has many pictures.
MANY = 40  # A table with more rows is collapsed.
# The pictures of the page; a kind that does not apply to the rows is left out.
PICTURES = (("Over time", View("time")), ("Phase plane", View("")), ("Drift", View("drift")))
LOOK = """
:root { color-scheme: light dark; --blue: #0072b2 }
body { background: #fff }
svg text { fill: currentcolor }
.status { padding: 0.7rem 1rem; border-left: 5px solid #00664c; background: #eaf6f1 }
.status.failed { border-color: #b3420a; background: #fdf0e8 }
.status b { font-size: 1.15rem }
.scroll { overflow-x: auto }
figure { margin: 1rem 0 } figcaption { font-size: 0.86rem; margin-bottom: 0.3rem }
pre { white-space: pre-wrap }
caption { text-align: left; padding: 0.2rem 0.6rem }
summary { cursor: pointer; margin: 0.5rem 0 }
@media (prefers-color-scheme: dark) {
  :root { --blue: #4aa3df }
  body { background: #15181c; color: #e6e6e6 }
  th { background: #15181c } th, td { border-color: #3a3f45 }
  tr.failed td { color: #ffb48a; background: #2c1f18 }
  pre { background: #1e2227 }
  .status { background: #14261f; border-color: #3ecf9f }
  .status.failed { background: #2c1c12; border-color: #ff8a4c }
}
"""
POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def html(
    compilation: Compilation,
    told: dict[str, object],
    table: Table | None,
    messages: str,
    view: View,
    given: dict[str, list[float]],
) -> str:
    """Returns the page. `told` is the metadata of the run (the content of FILE.csv.json). `table`
    has the rows of the run; it is None if there are no rows. `given` has the parameters and the
    start, from Run.given()."""
    time = "" if compilation.model.dimensionless else "s"
    model = compilation.declared
    found: dict = told["report"]  # type: ignore[assignment]
    scene = told.get("scene")
    title = model.name.replace("_", " ") + (f", scene {scene}" if scene else "")
    sections = [
        f"<p>{escape(model.description)}</p>" if model.description else "",
        _status(told, found, messages, time),
        *_expectations(told),
        *_pictures(table, view),
        *_drifts(found, time),
        *_diagnostics(found, time),
        *_events(found, time),
        *_settings(compilation, told, given, time),
        f"<p>pkgen {escape(__version__)}; {escape(str(told['source']))}, SHA-256 "
        f"{escape(str(told['source_sha256']))}</p>",
    ]
    text = page.document(title, sections)
    head = f'<meta name="viewport" content="width=device-width">\n<style>{LOOK}</style>\n<h1>'
    policy = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n<title>'
    return text.replace("<h1>", head, 1).replace("<title>", policy, 1)


# -- the status ------------------------------------------------------------------------------------


def _status(told: dict, found: dict, messages: str, time: str) -> str:
    missed = [e for e in told.get("expects", ()) if not e["met"]]
    bad = bool(missed) or found.get("code", 0) != 0 or told["partial"] or found.get("failed")
    lines = [*_way(found, time)]
    if missed:
        count = len(told["expects"])
        lines.append(f"{count - len(missed)} of {count} expectations met")
    said = _text(lines)
    words = f"<pre>{escape(messages.strip())}</pre>" if messages.strip() else ""
    kind = "status failed" if bad else "status"
    word = escape(_word(told, found, missed))
    return f'<div class="{kind}" role="status"><b>{word}</b>{said}{words}</div>'


def _word(told: dict, found: dict, missed: Sequence) -> str:
    if found.get("interrupted"):
        return "Interrupted"
    if not found:
        return "The run failed before its first step"
    if "members" in found:
        failed = found.get("failed", 0)
        return f"{failed} of {found['members']} members failed" if failed else "Done"
    if found.get("status") not in (None, "PK_DONE"):
        return f"Failed: {found.get('text') or found['status']}"
    if told["partial"]:
        return "Not finished"
    if missed:
        return "Done, but expectations are missed"
    return "Done"


def _way(found: dict, time: str) -> Iterable[str]:
    unit = f" {time}" if time else ""
    if not found:
        return
    if "members" in found:
        yield (
            f"{found['method']}: {found['done']} of {found['members']} members done, "
            f"{found.get('rows', 0)} rows, {1000 * found['seconds']:.3g} ms"
        )
        return
    if found.get("reason") and found["reason"] not in ("", f"done at t = {found['t']:g}"):
        yield str(found["reason"])
    yield (
        f"{found['method']}: t = {found['t']:.12g}{unit} after {found['steps']} steps, "
        f"{found['rejections']} rejected, {found['evaluations']} evaluations, "
        f"{1000 * found['seconds']:.3g} ms"
    )
    if found.get("last_valid") is not None and found["last_valid"] != found["t"]:
        yield f"valid until t = {found['last_valid']:.12g}{unit}"
    if found.get("warning"):
        yield str(found["warning"])


def _text(lines: Iterable[str]) -> str:
    return "".join(f"<p>{escape(line)}</p>" for line in lines)


# -- pictures --------------------------------------------------------------------------------------


def _pictures(table: Table | None, view: View) -> Iterable[str]:
    if table is None:
        yield _text(["There are no rows, and so no pictures."])
        return
    asked = [("As asked", view)] if view.kind or view.names else []
    drawn: list[str] = []
    yield page.heading("Pictures")
    for name, kind in (*asked, *PICTURES):
        try:
            made = compose.picture(kind if kind.kind else View("varying"), [table])
        except UsageError:
            continue
        svg = encoded(made, "svg", dpi=DPI).decode()
        if svg in drawn:
            continue
        drawn.append(svg)
        shape = "max-width: 26rem" if not made.wide else ""
        label = escape(f"{name}: {table.told.get('model', '')}", quote=True)
        inner = page.picture(on_page(svg), len(drawn))
        inner = inner.replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
        notes = "".join(f" {escape(note)}." for note in made.notes)
        yield (
            f'<figure style="{shape}"><figcaption>{escape(name)}.{notes}</figcaption>'
            f"{inner}</figure>"
        )


def on_page(svg: str) -> str:
    """Adapts an SVG to a light or dark page: lines get the colour of text, backgrounds no fill."""
    for ink in (style.INK, style.BLACK):
        svg = svg.replace(ink.lower(), "currentcolor")
    svg = svg.replace("fill: #ffffff", "fill: none").replace(style.BLUE.lower(), "var(--blue)")
    return svg.replace(style.PALE.lower(), "#88888844").replace(style.GREY.lower(), "#7f7f7f")


# -- tables ----------------------------------------------------------------------------------------


def _table(title: str, headings: Sequence[str], rows: Rows, failed=lambda row: False) -> str:
    if not rows:
        return ""
    made = f'<div class="scroll">{page.table(headings, rows, failed)}</div>'
    if len(rows) > MANY:
        made = f"<details><summary>{len(rows)} rows</summary>{made}</details>"
    return page.heading(title) + made


def _expectations(told: dict) -> Iterable[str]:
    rows: Rows = [
        (
            "met" if e["met"] else "missed",
            str(e["text"]),
            _number(e["value"]),
            _number(e["bound"]),
            _number(e["within"]),
            _number(e["t"]),
            str(e["said"]),
        )
        for e in told.get("expects", ())
    ]
    headings = ("", "expectation", "value", "bound", "within", "at t", "why")
    yield _table("Expectations", headings, rows, lambda row: row[0] == "missed")


def _drifts(found: dict, time: str) -> Iterable[str]:
    rows: Rows = [
        (
            str(d["name"]),
            _number(d["max"], 3),
            _number(d["final"], 3),
            _number(d["slope"], 3),
            _number(d["scale"], 3),
            str(d["growth"]),
        )
        for d in found.get("drifts") or ()
    ]
    slope = f"slope per {time}" if time else "slope per unit of time"
    yield _table("Drifts", ("of", "largest", "final", slope, "relative to", "growth"), rows)


def _diagnostics(found: dict, time: str) -> Iterable[str]:
    lines = diagnostics_text.lines(found.get("diagnostics") or {}, time)
    failed = [
        f"{name}: {result.get('reason') or result['status']}"
        for name, result in (found.get("diagnostics") or {}).items()
        if result.get("status") != "PK_DONE"
    ]
    if lines or failed:
        yield page.heading("Diagnostics") + page.items([*lines, *failed])


def _events(found: dict, time: str) -> Iterable[str]:
    rows: Rows = []
    for e in found.get("events") or ():
        times = [f"{t:.12g}" for t in e.get("times", ())[:TIMES]]
        more = ", …" if len(e.get("times", ())) > TIMES else ""
        rows.append((str(e["name"]), str(e["count"]), ", ".join(times) + more))
    yield _table("Events", ("event", "crossings", f"at t{f' [{time}]' if time else ''}"), rows)


def _settings(
    compilation: Compilation, told: dict, given: dict[str, list[float]], time: str
) -> Iterable[str]:
    settings: dict = told["settings"]
    unit = f" {time}" if time else ""
    kept = (
        ("method", settings["method"]),
        ("until", f"{settings['until']:.12g}{unit}"),
        ("rows every", "" if settings["every"] is None else f"{settings['every']:.12g}{unit}"),
        ("step", "" if settings["step"] is None else f"{settings['step']:.12g}{unit}"),
        ("rtol", _number(settings["rtol"])),
        ("atol", "of the motion" if settings["atol"] is None else _number(settings["atol"])),
        ("iteration", str(settings["iteration"])),
        ("members", str(settings.get("ensemble", ""))),
    )
    yield _table("Settings", ("", ""), [(name, value) for name, value in kept if value])
    yield from _given(compilation, given)
    yield _table("Columns", ("column", "unit", "what"), _columns(told))


def _given(compilation: Compilation, given: dict[str, list[float]]) -> Iterable[str]:
    """Yields the tables of parameters and of initial values."""
    headings = ("", "value", "unit", "what")
    names = named.parameters(compilation)
    yield _table("Parameters", headings, _values(names, given["parameters"]))
    places, rates = (named.coordinates(compilation, rates=r) for r in (False, True))
    start = [*_values(places, given["q"]), *_values(rates, given["v"])]
    yield _table("Start", headings, start)


def _values(names: named.Named, values: list[float]) -> Rows:
    flat = [q for declared in names.declared for q in _members(declared)]
    return [
        (q.name, _number(x), printed(q.unit), q.description)
        for q, x in zip(flat, values, strict=False)
    ]


def _members(declared: named.Declared) -> list:
    if declared.lo is None or declared.hi is None:
        return [declared.quantity]
    return [declared.member(k) for k in range(declared.lo, declared.hi + 1)]


def _columns(told: dict) -> Rows:
    return [(c["name"], printed(c["unit"]), c["description"]) for c in told["columns"]]


def _number(x: float | None, digits: int = 12) -> str:
    return "" if x is None else f"{x:.{digits}g}"
