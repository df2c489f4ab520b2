"""`pkgen chart`: charts the accuracy of integration methods against their cost."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

from ..analysis.chart import chart as charts
from ..analysis.chart import table
from ..analysis.chart.answer import Answer
from ..analysis.chart.chart import Chart
from ..analysis.chart.errors import KINDS
from ..analysis.chart.points import ChartedMethod
from ..analysis.chart.sweep import FULL, QUICK, Effort
from ..analysis.chart.text import interrupted, report
from ..compiler import Compilation
from ..middle.refused import refuse_statements
from ..own.given import given
from ..plot.style import Look
from ..run.build import runtime_methods
from ..run.settings import Settings
from ..scenes import run_settings as parsing
from ..scenes import scene
from ..scenes.compile_plan import whole
from ..system import children
from ..system.exits import DONE, INTERRUPTED, NumericsFailed, UsageError
from ..system.files import scratch
from ..system.progress import progress, say, unseen
from . import arguments as shared
from .compilation import compile_within_limits
from .pictures import look_of, page_of, show_result, with_texts

STARTS = 99
COSTS = {"time": "seconds", "evaluations": "work", "steps": "steps"}
# Options that cannot be combined with --long, with their defaults.
OF_CHART = {
    "points": None,
    "error": "final",
    "starts": 1,
    "cost": "time",
    "full": False,
    "against": None,
}

EXAMPLES = """
pkgen chart models/double_pendulum.lag -o charts
pkgen chart models/heavy_top.lag --methods rk4,gauss --quick
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    shared.as_of_a_run(parser)
    add = parser.add_argument
    shared.directory(parser)
    shared.own_methods(parser)
    shared.of_a_motion(parser)
    add("--methods", metavar="LIST", help="only these, e.g. rk4,gauss (default: all that apply)")
    add("--points", type=int, metavar="N", help=f"of a method, at most (default {FULL[0]})")
    add("--error", choices=tuple(KINDS), help="of what (default: the final state)")
    add("--starts", type=int, metavar="N", help="medians of N starts beside each other")
    add("--cost", choices=tuple(COSTS), help="of the picture (default: time)")
    add("--full", action="store_true", help="pictures of all methods too, and of each family")
    shared.of_a_look(parser)
    text = f"""
        --long     -        drifts over 1e1 to 1e7 fixed steps instead
        --step     H        of --long (default: 1/32 of the fastest period)
        --quick    -        fewer points, shorter laps, {QUICK[2]:g} s of processor time
        --seconds  float:S  processor time of all but drawing (default {FULL[2]:g})
    """
    shared.rows(parser, text)
    parser.set_defaults(others=None, **OF_CHART)  # An add-on may replace `others`.


def run(options: argparse.Namespace) -> int:
    """Chart accuracy against cost, for every integration method that can run the model."""
    began, effort, look = time.monotonic(), _effort(options), look_of(options)
    directory = parsing.directory(options.directory)
    compilation = compile_within_limits(options, unroll=None, use=whole(options), jets=True)
    refuse_statements(compilation.model, "pkgen chart")
    others = options.others and options.others(options)  # solvers of other packages
    chosen = _methods(options, compilation, others.methods if others else [])
    chosen_scene = scene.of(options, compilation.declared)
    settings = parsing.settings(options, compilation, chosen=chosen_scene)
    stops = [event.name for event in compilation.model.events if event.stop]
    if stops:
        shown = ", ".join(stops[:3]) + f" and {len(stops) - 3} more" * (len(stops) > 3)
        say(f"event {shown} would stop a run; a chart goes on until {settings.until:g}")
    if options.long:
        return _long(options, compilation, settings, chosen, look, directory, began)
    with progress(compilation.model.name) as show:
        how = effort, show or unseen, KINDS[options.error], options.starts, others
        chart = charts.measure(compilation, settings, chosen, *how)
    if not any(track.good for track in chart.tracks):
        if chart.interrupted:
            raise KeyboardInterrupt
        raise NumericsFailed("no method arrived with an error below that of no motion at all")
    files = _write(directory, chart, options, look)
    text = report(chart, options.model, _given(options))
    show_result(options, _record(chart), text, files, began)
    if chart.interrupted:
        say(interrupted(chart))
    return INTERRUPTED if chart.interrupted else DONE


def _long(
    options: argparse.Namespace,
    compilation: Compilation,
    settings: Settings,
    chosen: list[ChartedMethod],
    look: Look,
    directory: Path,
    began: float,
) -> int:
    from ..analysis.chart import long, long_report

    effort = _effort(options)
    with progress(compilation.model.name) as show:
        found = long.measure(compilation, settings, chosen, effort, settings.step, show or unseen)
    with scratch() as folder:
        stem = folder / f"{found.model}_long"
        files = long_report.write(found, stem, look)
        files = with_texts(files, directory, stem, {".csv": long_report.as_csv(found)})
    show_result(options, long_report.record(found), long_report.text(found), files, began)
    if children.ended():
        say("interrupted: drifts are of the methods measured until then")
    return INTERRUPTED if children.ended() else DONE


def _methods(
    options: argparse.Namespace, compilation: Compilation, more: list[str]
) -> list[ChartedMethod]:
    """Returns the methods that --methods, --tableau and --composition name, and the methods `more`.
    Without these options, returns all methods."""
    wanted, own = None, compilation.model.methods
    if options.methods is not None:
        wanted = [name.strip() for name in options.methods.split(",") if name.strip()]
        wanted += [method.name for method in given(options)]
        wanted += more
    try:
        found = charts.methods(wanted, own)
    except KeyError as missing:
        known = [*(m.name for m in own), *(str(m["name"]) for m in runtime_methods())]
        raise UsageError(parsing.unknown("--methods", missing.args[0], known, "method")) from None
    if not found:
        raise UsageError("--methods: name one at least")
    return found


def _effort(options: argparse.Namespace) -> Effort:
    if options.points is not None and options.points < 2:
        raise UsageError(f"--points {options.points}: 2 at least")
    if not 1 <= options.starts <= STARTS:
        raise UsageError(f"--starts {options.starts}: from 1 to {STARTS}")
    for name, usual in OF_CHART.items():
        if options.long and getattr(options, name, usual) != usual:
            raise UsageError(f"--{name} is of a chart: --long has one step and drifts alone")
    if options.step is not None and not options.long:
        raise UsageError("--step is of --long; in a chart each method has its own steps")
    if options.seconds is not None and not 0 < options.seconds < math.inf:
        raise UsageError(f"--seconds {options.seconds:g}: must be positive and finite")
    return Effort.usual(options.points, options.seconds, options.quick)


def _given(options: argparse.Namespace) -> list[str]:
    """Returns the options by which `pkgen run` repeats a run of the chart."""
    words = [("--scene", options.scene)] if options.scene else []
    for name in ("set", "start", "tableau", "composition", "size"):
        words += [(f"--{name}", text) for text in getattr(options, name)]
    return [word for pair in words for word in pair]


def _write(directory: Path, chart: Chart, options: argparse.Namespace, look: Look) -> list[Path]:
    from ..analysis.chart import draw, picture

    html = page_of("chart")
    with scratch() as folder:
        stem = folder / f"{chart.model}_chart"
        files = picture.write(chart, stem, look, COSTS[options.cost])
        files += draw.pictures(chart, stem) if options.full else []
        contents = {".csv": table.as_csv(chart.tracks)}
        if html:
            text = report(chart, options.model, _given(options))
            contents[".html"] = html(chart, text, [f for f in files if f.suffix == ".svg"])
        return with_texts(files, directory, stem, contents)


def _answer(a: Answer) -> dict[str, object]:
    point = table.record(a.method, a.point) if a.method and a.point else {"method": None}
    return {"accuracy": a.accuracy, "reason": a.reason, **point}


def _record(chart: Chart) -> dict[str, object]:
    """Returns the chart as data for JSON."""
    reference = chart.reference
    return {
        "model": chart.model,
        "until": chart.until,
        "error": chart.kind.name,
        "starts": chart.starts,
        "values": {name: value for name, value, _ in chart.values},
        "reference": {
            **{name: getattr(reference, name) for name in ("error", "holds", "scalar")},
            "final": reference.exact.x[-1].tolist(),
            "scales": reference.scales.tolist(),
        },
        "omega": chart.spectrum.omega,
        "limits": {
            track.method.name: limit
            for track in chart.tracks
            if (limit := chart.spectrum.limit(track.method)) is not None
        },
        "answers": [
            {"cheapest_in": a.axis, "unmeasured": a.unmeasured, **_answer(a)} for a in chart.answers
        ],
        "against": [
            {"package": b.version, "times": chart.times(a), **_answer(a)}
            for b in chart.beside
            for a in b.answers
        ],
        "refused": chart.refused | {b.name: b.why for b in chart.beside if b.why},
        "interrupted": chart.interrupted,
        "unmeasured": chart.unmeasured,
        "points": table.rows(chart.tracks),
    }
