"""Pictures of --plot and --report: checks options before a run, writes files after the run."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ..api.prepare import Prepared
from ..back.facts import found
from ..plot import style
from ..plot import view as views
from ..plot.view import View
from ..record import record
from ..run import named
from ..scenes.run_settings import unknown
from ..system import addons
from ..system.exits import UsageError
from ..system.files import moved, place, replace
from ..system.near import near
from ..system.progress import say, took
from .messages import needs

if TYPE_CHECKING:
    from ..plot.picture import Picture

MILLIMETRES = 25.4
WIDTHS = (40.0, 1000.0)  # smallest and largest --width in mm
ENDS = tuple(f".{kind}" for kind in style.FORMATS)


@record
class Wanted:
    """The picture files to write, and the columns and kind of plot to draw."""

    view: View
    width: float | None  # inches
    plot: Path | None = None
    report: Path | None = None


def wanted(options: argparse.Namespace) -> Wanted | None:
    """Returns the pictures that options of `pkgen run` request, or None. Raises UsageError."""
    given = [name for name in (*views.KINDS, "columns", "width") if getattr(options, name)]
    if options.plot is None and options.report is None:
        if given:
            said = f"--{given[0]} is of a picture: --plot FILE.svg makes one, or pkgen plot"
            raise UsageError(said)
        return None
    plot = picture_file("--plot", options.plot) if options.plot is not None else None
    report = None
    if options.report is not None:
        if not options.report.endswith(".html"):
            raise UsageError(f"--report {options.report}: the file's name must end in .html")
        addons.load("pages", "run.report")  # A missing add-on raises UsageError before the run.
        report = Path(options.report)
    files = [options.output, options.plot, options.report]
    if options.output not in (None, "-") and place(Path(options.output)) is None:
        raise UsageError(f"-o {options.output}: pictures are made from a file of rows, not a pipe")
    for file in (plot, report):
        if file is not None:
            place(file)
            if files.count(str(file)) > 1:
                raise UsageError(f"{file}: two files of one name")
    return Wanted(views.asked(options), width(options), plot, report)


def picture_file(option: str, name: str) -> Path:
    if not name.endswith(ENDS):
        raise UsageError(f"{option} {name}: the file's name must end in .svg, .png or .pdf")
    return Path(name)


def width(options: argparse.Namespace) -> float | None:
    """Returns the value of --width in inches, or None if it is not set. Raises UsageError."""
    if options.width is None:
        return None
    if not WIDTHS[0] <= options.width <= WIDTHS[1]:
        raise UsageError(f"--width {options.width:g}: from {WIDTHS[0]:g} to {WIDTHS[1]:g} mm")
    return options.width / MILLIMETRES


def look_of(options: argparse.Namespace) -> style.Look:
    """Returns the requested width, formats and light or dark colours. Raises UsageError."""
    needs("matplotlib")
    formats = tuple(kind.strip() for kind in options.format.split(",") if kind.strip())
    known = (*style.FORMATS, style.OF_LATEX)
    for kind in formats:
        if kind not in known:
            raise UsageError(unknown("--format", kind, known, "kind of picture"))
    millimetres = (width(options) or style.PAGE) * MILLIMETRES
    return style.Look(millimetres, formats, options.dark)


def page_of(command: str) -> Callable[..., str] | None:
    """Returns a function that writes a command's HTML page. If the add-on with the function is
    missing, prints a message and returns None."""
    if where := addons.missing(addons.points("pages").get(command)):
        say(f"no page: it is {where}")
        return None
    return addons.load("pages", command).html


def with_texts(files: list[Path], directory: Path, stem: Path, texts: dict[str, str]) -> list[Path]:
    """Writes texts beside pictures in a scratch folder, by suffix, and copies all files to a
    directory; returns their new paths."""
    for suffix, content in texts.items():
        stem.with_suffix(suffix).write_text(content, encoding="utf-8")
    return moved([*files, *map(stem.with_suffix, texts)], directory)


def show_result(
    options: argparse.Namespace,
    record: dict[str, object],
    text: str,
    files: list[Path],
    began: float,
) -> None:
    """Prints the result of a chart or a map as text, or as JSON, with the written files."""
    if options.json:
        print(json.dumps({**record, "files": [str(file) for file in files]}, indent=1))
    else:
        print(f"{text}\nwritten: {', '.join(map(str, files))}; {took(began)}")


def recorded(
    options: argparse.Namespace, view: View, prepared: Callable[[argparse.Namespace], Prepared]
) -> Prepared:
    """Prepares a run that also records the columns to be drawn. Raises UsageError if this is not
    possible."""
    made = prepared(options)
    names = [c.name for c in made.columns()]
    missing = [name for name in view.columns if not _has(names, name)]
    rows = names[1 + (made.ensemble is not None) :]
    if view.kind == "drift" and not view.names and options.scene is None:
        of = made.compilation
        constants = [name for name, _ in found(of.equations, of.structure)]
        more = [n for n in constants if not _has(names, n)]
        with suppress(UsageError):  # Not every constant can be a column.
            return _with(options, [*rows, *more], prepared) if more else made
    if not missing:
        return made
    if options.record is not None:
        said = near(missing[0], names, "column")
        raise UsageError(f"{view.option} {missing[0]}: --record leaves it out; {said}")
    try:
        more = [member for name in missing for member in _members(made, name)]
        return _with(options, [*rows, *more], prepared)
    except UsageError as error:
        raise UsageError(str(error).replace("--record", view.option, 1)) from None


def _has(names: list[str], name: str) -> bool:
    from ..plot.table import part_of

    return name in names or any(part_of(n, name) for n in names)


def _members(made: Prepared, name: str) -> list[str]:
    """Returns the names of all members if `name` is a family of quantities, else [name]."""
    stem, primes = name.rstrip("'"), "'" * name.count("'")
    for item in named.declared(made.compilation).declared:
        if item.lo is not None and item.quantity.name == stem:
            return [quantity.name + primes for quantity in item.members()]
    return [name]


def _with(
    options: argparse.Namespace, rows: list[str], prepared: Callable[..., Prepared]
) -> Prepared:
    return prepared(argparse.Namespace(**{**vars(options), "record": ",".join(rows)}))


def write(made: Picture, file: Path | None, width: float | None) -> None:
    """Prints messages about a picture, and writes it to a file, if there is one."""
    for note in made.notes:
        say(note)
    if file is not None:
        from ..plot.draw import encoded

        replace({file: encoded(made, file.suffix[1:] or "svg", width)})
