"""`pkgen run`: compiles a model, integrates it, and reports the result.

Rows go to standard output, or to a file, which FILE.json describes. Messages go to standard error.
"""

from __future__ import annotations

import argparse
import csv
import json
import shutil
import sys
from pathlib import Path
from typing import IO, TYPE_CHECKING

from ..api.prepare import Prepared, prepare
from ..run import diagnostics, diagnostics_text
from ..run.library import load
from ..run.simulate import Outcome, sidecar, simulate
from ..scenes import run_settings as parsing
from ..system import addons, children
from ..system.columns import aligned
from ..system.exits import DONE, INTERRUPTED, LEFT, NUMERICS_FAILED
from ..system.files import PARTIAL, Result, cut, scratch
from ..system.progress import progress, say
from . import arguments as shared
from . import checkpoints, pictures
from .compilation import compile_within_limits
from .pictures import Wanted

if TYPE_CHECKING:
    from ..plot.table import Table
    from ..plot.view import View

# If the method's iteration, not its error, limits more than this fraction of the steps, a message
# is printed.
HELD = 0.75

EXAMPLES = """
pkgen run models/double_pendulum.lag --until 5 --every 0.1
pkgen run models/double_pendulum.lag --set m2=2 --start "theta1=90 [deg]" -o rows.csv
pkgen run models/heavy_top.lag --scene nutation --method gauss4 --step 0.01
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.of_a_run(parser)
    checkpoints.arguments(parser)
    parser.set_defaults(instead=None)  # set by add-ons


def run(options: argparse.Namespace) -> int:
    """Compile a model and integrate it; the rows go to standard output."""
    if options.instead is not None:  # an add-on replaces this function
        return options.instead(options)
    output = parsing.output(options.output)
    wanted = pictures.wanted(options)
    checkpoints.refuse(options, output, wanted is not None)
    what = prepared(options, wanted.view if wanted else None)
    more = checkpoints.settings(options, what)
    alone = output is None and not options.json and wanted is None
    shown = alone and not more and options.output is None and sys.stdout.isatty()
    left = None
    if output is not None:
        outcome, left = _to_file(options, what, output, wanted is None, more)
        if wanted:
            _pictures(wanted, what, outcome, left or output)
    elif alone and not shown:
        sys.stdout.flush()
        outcome = _simulate(what, sys.stdout.fileno(), **more)
        _finishing(outcome)
    else:
        with scratch() as folder:
            path = folder / "rows.csv"
            outcome = to_scratch(what, path)
            if shown:
                print(_some_rows(path))
            elif options.json:
                found = _describe(what, outcome, "rows")
                with open(path, newline="", encoding="utf-8") as file:
                    rows = list(csv.reader(file))[1:]
                found["rows"] = [[float(x) for x in row] for row in rows]
                print(json.dumps(found, indent=1))
            elif options.output == "-":
                with open(path, "rb") as file:
                    shutil.copyfileobj(file, sys.stdout.buffer)
            if wanted:
                _pictures(wanted, what, outcome, path)
    checkpoints.over(options, outcome)
    if outcome.code == DONE and not outcome.whole:  # e.g. in `pkgen run MODEL | head`
        return DONE
    tell(options, what, outcome)
    if left is not None and not options.json:
        say(f"rows as far as they came: {left}")
    names = ", ".join(item.name for item in what.compilation.declared.scenes if item.listed)
    plain = options.scene is None and not (options.json or options.diagnose)
    if outcome.code == DONE and plain and names:
        print(f"scenes of this model, by --scene: {names}", file=sys.stderr)
    return LEFT if outcome.code == LEFT else judge(options, what, outcome)


def prepared(options: argparse.Namespace, view: View | None = None) -> Prepared:
    """Compiles the model and builds its library; the run also records the columns of `view`."""

    def made(options: argparse.Namespace) -> Prepared:
        return prepare(options, compile_within_limits, None, checkpoints.chosen(options))

    what = made(options) if view is None else pictures.recorded(options, view, made)
    for note in what.notes:
        print(note, file=sys.stderr)
    return what.built()


def to_scratch(what: Prepared, path: Path) -> Outcome:
    """Runs a model with the rows written to `path`; removes an incomplete last row."""
    with open(path, "wb") as file:
        outcome = _simulate(what, file)
    cut(path)
    return outcome


def table_of(what: Prepared, outcome: Outcome, path: Path, label: str) -> Table | None:
    """Returns the rows of a finished run as a table, or None if it has less than two rows."""
    from ..plot.table import rows

    if not path.exists() or not path.stat().st_size:
        return None
    return rows(path, label, json.loads(json.dumps(_describe(what, outcome, path.name))))


def _some_rows(path: Path) -> str:
    """Returns a text for the terminal: the first and last five rows of a run, and the options that
    would save or draw all rows."""
    with open(path, newline="", encoding="utf-8") as file:
        head, *rows = list(csv.reader(file)) or [[]]
    some = rows if len(rows) <= 10 else [*rows[:5], ["…"] * len(head), *rows[-5:]]
    cells = [head, *([x if x == "…" else f"{float(x):.6g}" for x in row] for row in some)]
    lines = aligned(cells, right=range(len(head)))
    if len(rows) > 10:
        lines.append(f"({len(rows):,} rows: -o rows.csv keeps them, --plot motion.svg draws them)")
    return "\n".join(lines)


def _pictures(wanted: Wanted, what: Prepared, outcome: Outcome, path: Path) -> None:
    """Writes the files of --plot and --report after a run, even if the run failed."""
    table = table_of(what, outcome, path, what.compilation.model.name)
    if wanted.plot is not None and table is None:
        say(f"{wanted.plot}: not written: there are no rows")
    elif wanted.plot is not None:
        from ..plot import compose

        pictures.write(compose.picture(wanted.view, [table]), wanted.plot, wanted.width)
    if wanted.report is not None:
        from ..system.files import replace

        given = load(what.library).run(what.settings, idle=True, bare=True).given()
        told = _describe(what, outcome, path.name)
        html = addons.load("pages", "run.report").html
        text = html(what.compilation, told, table, outcome.messages, wanted.view, given)
        replace({wanted.report: text})


def _to_file(
    options: argparse.Namespace, asked: Prepared, output: Path, alone: bool, more: dict[str, object]
) -> tuple[Outcome, Path | None]:
    """Runs a model with the rows written to `output`, and the settings `more`. Returns the outcome,
    and the path of the rows if the run did not finish, else None."""
    left = None
    unfinished = Outcome(INTERRUPTED, {}, "")  # what the JSON file says if pkgen is killed
    npy = output.suffix == ".npy"
    kept = "begun" if options.resume else "all" if more else ""
    description = _text(_describe(asked, unfinished, output.name))
    with Result(output, description, kept if not npy else kept and "all") as result:
        outcome = _simulate(asked, result.file, npy, **more)
        if alone:
            _finishing(outcome)
        description = _describe(asked, outcome, output.name)
        if outcome.whole:
            result.finish(_text(description))
        else:
            left = result.leave(_text(description))
    if options.json:
        print(json.dumps(description, indent=1))
    return outcome, left


def _finishing(outcome: Outcome) -> None:
    """Ignores signals such as SIGINT from now on, if all rows are written."""
    if outcome.whole and outcome.code == DONE:
        children.finishing()


def _text(description: dict[str, object]) -> str:
    return json.dumps(description, indent=1) + "\n"


def _describe(asked: Prepared, outcome: Outcome, data: str) -> dict[str, object]:
    data += "" if outcome.whole or data == "rows" else PARTIAL
    found = sidecar(asked, outcome, data)
    if asked.scene is not None:
        found["scene"] = asked.scene.name
    if asked.scene is not None and outcome.report:
        found["expects"] = [verdict.record() for verdict in asked.verdicts(outcome.report)]
    if asked.chosen is not None:
        made = asked.chosen["said"]
        found["accuracy"] = made[0] if len(made) == 1 else {"parts": made}
    return found


def judge(options: argparse.Namespace, asked: Prepared, outcome: Outcome) -> int:
    """Prints missed expectations of the scene and how many are met; returns the exit code."""
    verdicts = asked.verdicts(outcome.report)
    missed = [verdict for verdict in verdicts if not verdict.met]
    if not options.json:
        source = asked.compilation.model.source
        for verdict in missed:
            print(verdict.diagnostic().text(source), file=sys.stderr)
        if verdicts:
            met = f"{len(verdicts) - len(missed)} of {len(verdicts)} met"
            far = "" if _whole(outcome) else ", as far as it came"
            print(f"expected: {met}{far}", file=sys.stderr)
    return NUMERICS_FAILED if missed and outcome.code == DONE else outcome.code


def _simulate(
    asked: Prepared, output: IO[bytes] | int, npy: bool = False, **more: object
) -> Outcome:
    with progress(asked.compilation.model.name) as on_progress:
        outcome = simulate(asked, output, on_progress, npy, **more)
    diagnostics.name_places(outcome.report, asked.compilation)
    return outcome


def _length(report: dict) -> str:
    """Returns text for the summary: the fixed step size, or the shortest and longest step."""
    if report["step"] is not None:
        return f" of {report['step']:.6g}"
    shortest, longest = (f"{report[name]:.3g}" for name in ("step_min", "step_max"))
    if not report["step_max"]:
        return ""
    return f" of up to {longest}" if shortest == longest else f" of {shortest} to {longest}"


def tell(options: argparse.Namespace, what: Prepared, outcome: Outcome) -> None:
    """Prints messages and a summary of the run."""
    lines = outcome.messages.splitlines()
    if not options.json and _whole(outcome):
        report = outcome.report
        if "members" in report:
            lines.append(
                f"{report['method']}: {report['done']} members by {report['threads']} threads, "
                f"{1000 * report['seconds']:.3g} ms with their rows"
            )
        else:
            lines += _summary(report, options.verbose)
        time = "" if what.compilation.model.dimensionless else "s"
        lines += diagnostics_text.lines(report.get("diagnostics", {}), time)
    for line in lines:
        print(line, file=sys.stderr)


def _summary(report: dict, verbose: bool) -> list[str]:
    method, evaluations = report["method"], report["evaluations"]
    lines = [
        f"{method}: t = {report['t']:g} after {report['steps']} steps{_length(report)}, "
        f"{report['rejections']} rejected, {evaluations} evaluation{'s' * (evaluations != 1)}, "
        f"{1000 * report['seconds']:.3g} ms"
        + (f", seed {report['seed']}" if "seed" in report else "")
    ]
    if report["held"] > HELD * report["steps"]:
        lines.append(
            f"{method}: its iteration, not its error, kept {report['held']} of {report['steps']} "
            "steps short: the model is stiff at this tolerance; --method gauss4 (fixed steps, "
            "Newton) or dop853 may take less time"
        )
    far = [event for event in report["events"] if "limit" in event and not event["count"]]
    met = [event for event in report["events"] if event not in far]
    lines += [f"event {event['name']}: {_crossings(event)}" for event in met]
    lines += [f"limits not met: {len(far)}"] if far else []
    rests = [x for x in report["contacts"] if x["rests"] is not None]
    lines += [f"contact {x['name']}: at rest from t = {x['rests']:.9g} on" for x in rests]
    grazes = [x for x in report["contacts"] if x["grazes"] is not None]
    touched = "touched without a normal force"
    doubt = "rounding decides whether it strikes"
    lines += [f"contact {x['name']}: {touched} at t = {x['grazes']:.9g}: {doubt}" for x in grazes]
    drifts = diagnostics_text.drift_lines if verbose else diagnostics_text.kept_line
    return lines + drifts(report["drifts"])


def _whole(outcome: Outcome) -> bool:
    """Whether the motion was integrated to its end. This is also true if a diagnostic, computed
    after the integration, has failed."""
    return outcome.code == DONE or "diagnostics" in outcome.report


def _crossings(event: dict) -> str:
    """Returns text for the summary: how often an event occurred, and when first and last."""
    times, count = event["times"], event["count"]
    if count < 2:
        return f"once, at t = {times[0]:.12g}" if count else "never"
    last = f", last at {times[-1]:.12g}" if len(times) == count else ""
    return f"{count} times, first at t = {times[0]:.12g}{last}"
