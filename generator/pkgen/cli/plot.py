"""`pkgen plot`: runs models and draws their motions, or draws rows from files."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from ..plot import view as views
from ..plot.view import View
from ..run.rows import interval
from ..system import addons
from ..system.exits import DONE, UsageError
from ..system.files import PARTIAL, ROWS, STANDARD, scratch
from ..system.progress import say
from . import arguments as shared
from . import pictures
from .messages import needs, refuse_both
from .run import judge, prepared, table_of, tell, to_scratch

if TYPE_CHECKING:
    from ..api.prepare import Prepared
    from ..plot.picture import Picture
    from ..plot.table import Table
    from ..run.simulate import Outcome

CLOSEST = 20_000  # largest number of rows of a run made for a picture
A_STEP = 4  # rows per integration step, if a run is repeated with more rows
READ = (*ROWS, ".csv" + PARTIAL)

EXAMPLES = """
pkgen plot models/double_pendulum.lag
pkgen plot models/elastic_pendulum.lag --path x,y -o path.svg
pkgen plot flips --map theta1,theta2 -o flips.png
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="MODEL.lag|FILE.csv|FILE.npy|DIR")
    help_ = "FILE.svg, .png, .pdf, or - (SVG); default: in the terminal"
    parser.add_argument("-o", dest="output", metavar="FILE", help=help_)
    shared.of_a_picture(parser, "coordinates, rates, outputs")
    parser.add_argument("--map", metavar="a,b", help="a sweep's --columns over two axes")
    shared.of_a_model(parser)
    shared.of_an_integration(parser)


def run(options: argparse.Namespace) -> int:
    """Draw motions over time, in the phase plane or in space, and their sections, spectra and
    drifts. Models are run first; files have the rows of earlier runs."""
    needs("matplotlib")
    view, width = views.asked(options), pictures.width(options)
    folders = {name: addons.of_folder(name) for name in options.files}
    sweeps = [name for name in options.files if folders[name]]
    if not sweeps:
        options.files = _files(options.files)
    file = None
    if options.output is not None:
        refuse_both(options, options.output)
        file = STANDARD
        if options.output != "-":
            file = pictures.picture_file("-o", options.output)
    _refuse(options, sweeps)
    if sweeps:
        _show(options, _map(options, view, folders[sweeps[0]]), file, width)
        return DONE
    tables, codes = [], []
    names = [Path(file).name for file in options.files]
    labels = names if len({*names}) == len(names) else options.files
    for name, label in zip(options.files, labels, strict=True):
        if name.endswith(READ):
            from ..plot.table import read

            table, code = replace(read(name), label=label), DONE
        else:
            options.model = name
            table, code = _run(options, view, label)
        tables += [] if table is None else [table]
        codes.append(code)
    if not tables:
        say("no rows to draw")
        return max(codes)
    from ..plot import compose

    made = compose.picture(view, tables)
    _show(options, made, file, width)
    return max(codes)


def _map(options: argparse.Namespace, view: View, folder: ModuleType) -> Picture:
    """Returns a picture of a parameter sweep: a quantity over two axes. Raises UsageError."""
    if len(options.files) > 1:
        raise UsageError(f"{' and '.join(options.files)}: a sweep has a picture of its own")
    if view.kind:
        raise UsageError(f"--{view.kind} is of motions: a sweep has a map, of --columns NAME")
    if len(view.columns) > 1:
        raise UsageError(f"--columns {','.join(view.columns)}: a map is of one")
    axes = [] if options.map is None else views.split("--map", options.map)
    return folder.picture(options.files[0], axes, "".join(view.columns))


def _refuse(options: argparse.Namespace, swept: list[str]) -> None:
    """Raises UsageError for an option that has no effect on the given files."""
    if options.map is not None and not swept:
        raise UsageError("--map is of a sweep: give its folder")
    models = (f for f in options.files if not f.endswith(READ) and f not in swept)
    options.model = next(models, "")
    if options.model:
        return
    of_runs = argparse.ArgumentParser()
    shared.of_an_integration(of_runs)
    usual = vars(of_runs.parse_args([]))
    given = [name for name, value in usual.items() if getattr(options, name) != value]
    if given:
        option = given[0].replace("_", "-")
        raise UsageError(f"--{option} is of a run: {options.files[0]} has its rows already")


def _files(given: list[str]) -> list[str]:
    """Replaces each directory by its CSV files, sorted. Raises UsageError if it has none."""
    files: list[str] = []
    for name in given:
        if not Path(name).is_dir():
            files.append(name)
            continue
        found = sorted(str(file) for file in Path(name).glob("*.csv") if file.is_file())
        if not found:
            raise UsageError(f"{name}: no *.csv in this directory")
        files += found
    return files


def _run(options: argparse.Namespace, view: View, label: str) -> tuple[Table | None, int]:
    """Runs a model. If lines between its rows would mislead, runs it again with more rows. Returns
    the rows and the exit code."""
    what = prepared(options, view)
    with scratch() as folder:
        path = folder / "rows.csv"
        outcome = to_scratch(what, path)
        table = table_of(what, outcome, path, label)
        every = _closer(what, outcome, table)
        if every is not None:
            what = replace(what, settings=replace(what.settings, every=every))
            outcome = to_scratch(what, path)
            table = table_of(what, outcome, path, label)
    tell(options, what, outcome)
    return table, judge(options, what, outcome)


def _closer(what: Prepared, outcome: Outcome, table: Table | None) -> float | None:
    """Returns a shorter time between rows, if straight lines between the present rows would give a
    wrong picture of the motion. Returns None if they would not, or if an option or the scene sets
    the time between rows."""
    settings = what.settings
    if what.spaced or outcome.code:
        return None
    if table is None or settings.every is None or table.several or settings.at is not None:
        return None
    if table.sparse:
        most = min(CLOSEST, A_STEP * outcome.report["steps"])
    elif any(table.rough(table[q.name]) for q in table.quantities):
        most = CLOSEST
    else:
        return None
    return interval(settings.until, settings.step, len(table.columns), most)


def _show(
    options: argparse.Namespace, made: Picture, file: Path | None, width: float | None
) -> None:
    pictures.write(made, file, width)
    if options.json:
        print(json.dumps(_record(made, file), indent=1))
    elif file is None:
        from ..plot.terminal import show

        show(made)


def _record(made: Picture, file: Path | None) -> dict[str, object]:
    """Returns the labels and curves of a picture as data for JSON."""

    def panel(p) -> dict[str, object]:
        axes = {name: axis.label for name, axis in zip("xyz", (p.x, p.y, p.z), strict=True) if axis}
        lines = [
            {"label": line.label, "kind": line.kind, "points": len(line.x)} for line in p.lines
        ]
        return {**axes, "lines": lines, "image": p.image.label if p.image else None}

    return {
        "file": str(file) if file else None,
        "title": made.title,
        "panels": [panel(p) for p in made.panels],
        "notes": list(made.notes),
    }
