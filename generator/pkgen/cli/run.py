"""`pkgen run`: compile a model, integrate it, say how it went.

Rows go to standard output or to a file with its settings beside it; what is said to a person
goes to standard error.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO

from ..analysis import choose
from ..analysis.choose import Choice
from ..compiler import Compilation
from ..indices import hidden
from ..model import Model, Scene
from ..run import diagnostics, diagnostics_text, rows
from ..run import ensemble as members
from ..run.ensemble import Ensemble
from ..run.settings import Settings
from ..run.simulate import Outcome, build, csv_to_npy, sidecar, simulate
from ..scenes import asked as parsing
from ..scenes import check as scene_check
from ..scenes import run as scene_run
from ..scenes import scene
from ..scenes import use as scene_use
from ..scenes.judge import Verdict
from ..system.exits import DONE, INTERRUPTED, NUMERICS_FAILED
from ..system.files import PARTIAL, Result, cut, scratch
from ..system.progress import progress
from .commands import compile_within_limits

# The share of steps that an iteration may hold back before it is worth a word.
HELD = 0.75


@dataclass(frozen=True)
class _Run:
    """What is run: a model, its settings, and the members of an ensemble if it is one."""

    compilation: Compilation
    settings: Settings
    ensemble: Ensemble | None
    threads: int | None
    scene: Scene | None
    program: Path | None = None
    choices: tuple[Choice, ...] = ()  # where the scene promises an accuracy, one of each part


def run(options: argparse.Namespace) -> int:
    """Compile a model and integrate it; the rows go to standard output."""
    output = parsing.output(options.output)
    swarm = scene_run.is_swarm(options)
    several = swarm or options.ensemble is not None
    # Members of an ensemble run in lanes, which loops do not have.
    unroll = None if several else parsing.UNROLL
    asked = diagnostics.asked(options.diagnose, options.ensemble)
    kernels = diagnostics.kernels(asked)
    compilation = compile_within_limits(
        options,
        libm=options.libm,
        portable=options.portable,
        unroll=unroll,
        kernels=kernels,
        use=scene_use.of_run(options),
    )
    diagnostics.refuse(asked, compilation, several)
    chosen = scene.chosen(compilation.declared, options.scene) if options.scene else None
    if chosen is not None:
        scene_check.refuse(options, compilation, chosen)
    threads = parsing.threads(options, several)
    if swarm:
        scene_run.refuse_swarm(options, compilation.declared, chosen)
    ensemble = members.read(options.ensemble, compilation) if options.ensemble else None
    count = scene_run.count(compilation.declared, chosen) if swarm else None
    settings = parsing.settings(
        options, compilation, len(ensemble.lines) if ensemble else count, chosen
    )
    if swarm:
        ensemble = scene_run.members(options, compilation, chosen, settings)
    if chosen is not None:
        expected = scene_run.watched(compilation, chosen, settings, several)
        settings = replace(settings, watched=expected)
    if several:
        settings = replace(settings, watch=scene_run.watch(compilation, chosen, settings))
    if chosen is not None and chosen.accuracy is not None and settings.accuracy is None:
        print(f"pkgen: {choose.NOT_PROMISED}", file=sys.stderr)
    choices = choose.chosen(compilation, settings, ensemble)
    settings = choose.with_choices(settings, choices)
    what = _Run(compilation, settings, ensemble, threads, chosen, choices=choices)
    time = "" if compilation.model.dimensionless else "s"
    for choice in choices:
        for line in choose.lines(choice, time, options.json):
            print(line, file=sys.stderr)
    for note in (rows.note(options, settings, compilation), parsing.unread(options, compilation)):
        if note:
            print(f"pkgen: {note}", file=sys.stderr)
    what = replace(what, program=build(compilation, settings, ensemble))
    if output is None and not options.json:
        sys.stdout.flush()
        outcome, left = _simulate(what, sys.stdout.fileno()), None
    else:
        outcome, left = _to_file(options, what, output)
    if outcome.code == DONE and not outcome.whole:  # who read the rows has gone
        return DONE
    _tell(options, outcome, time)
    if left is not None and not options.json:
        print(f"pkgen: rows as far as they came: {left}", file=sys.stderr)
    if outcome.code == DONE and not options.diagnose:
        _hint(options, compilation.declared)
    return _judge(options, what, outcome)


def _hint(options: argparse.Namespace, model: Model) -> None:
    """Which scenes there are, to who has chosen none."""
    names = ", ".join(item.name for item in model.scenes if not hidden(item.name))
    if options.scene is None and names and not options.json:
        print(f"scenes of this model, by --scene: {names}", file=sys.stderr)


def _to_file(
    options: argparse.Namespace, asked: _Run, output: Path | None
) -> tuple[Outcome, Path | None]:
    """Run with the rows in a file: the one asked for, or a scratch file to read them from; where
    they are if they are not all."""
    left = None
    if output is None:
        with scratch() as folder:
            with open(folder / "rows.csv", "wb") as file:
                outcome = _simulate(asked, file)
            print(json.dumps(_result(asked, outcome, folder / "rows.csv"), indent=1))
        return outcome, None
    unfinished = Outcome(INTERRUPTED, {}, "")  # should nobody be there to say more
    with Result(output, _text(_describe(asked, unfinished, output.name))) as result:
        if output.suffix == ".csv":
            outcome = _simulate(asked, result.file)
        else:
            with scratch() as folder:
                with open(folder / "rows.csv", "wb") as file:
                    outcome = _simulate(asked, file)
                if cut(folder / "rows.csv"):
                    csv_to_npy(folder / "rows.csv", result.file)
        description = _describe(asked, outcome, output.name)
        if outcome.whole:
            result.finish(_text(description))
        else:
            left = result.leave(_text(description))
    if options.json:
        print(json.dumps(description, indent=1))
    return outcome, left


def _text(description: dict[str, object]) -> str:
    return json.dumps(description, indent=1) + "\n"


def _describe(asked: _Run, outcome: Outcome, data: str) -> dict[str, object]:
    data += "" if outcome.whole or data == "rows" else PARTIAL
    found = sidecar(asked.compilation, asked.settings, outcome, data, asked.ensemble)
    if asked.scene is not None:
        found["scene"] = asked.scene.name
    if asked.scene is not None and outcome.report:
        found["expects"] = [verdict.record() for verdict in _verdicts(asked, outcome)]
    if asked.choices:
        made = [choose.record(choice) for choice in asked.choices]
        found["accuracy"] = made[0] if len(made) == 1 else {"parts": made}
    return found


def _verdicts(asked: _Run, outcome: Outcome) -> list[Verdict]:
    if asked.scene is None:
        return []
    return scene_run.verdicts(
        asked.compilation, asked.scene, asked.settings, outcome.report, asked.ensemble
    )


def _judge(options: argparse.Namespace, asked: _Run, outcome: Outcome) -> int:
    """Say what was expected and missed, and that the rest was met; the exit code."""
    verdicts = _verdicts(asked, outcome)
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


def _result(asked: _Run, outcome: Outcome, table: Path) -> dict[str, object]:
    """Everything of a run in one JSON object, its rows included."""
    result = _describe(asked, outcome, "rows")
    with open(table, newline="", encoding="utf-8") as file:
        result["rows"] = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    return result


def _simulate(asked: _Run, output: IO[bytes] | int) -> Outcome:
    with progress(asked.compilation.model.name) as on_progress:
        outcome = simulate(
            asked.compilation,
            asked.program,
            asked.settings,
            output,
            on_progress,
            asked.ensemble,
            asked.threads,
        )
    diagnostics.name_places(outcome.report, asked.compilation)
    return outcome


def _length(report: dict) -> str:
    """Of the steps: the one asked for, or from the shortest to the longest of those that vary."""
    if report["step"] is not None:
        return f" of {report['step']:.6g}"
    longest = report["step_max"]
    return f" of {report['step_min']:.3g} to {longest:.3g}" if longest else ""


def _tell(options: argparse.Namespace, outcome: Outcome, time: str) -> None:
    """Say to a person how the run went."""
    if outcome.messages:
        print(outcome.messages.rstrip("\n"), file=sys.stderr)
    report = outcome.report
    if options.json or not _whole(outcome):
        return
    if "members" in report:
        print(
            f"{report['method']}: {report['done']} members by {report['threads']} threads, "
            f"{1000 * report['seconds']:.3g} ms with their rows",
            file=sys.stderr,
        )
        for line in diagnostics_text.lines(report.get("diagnostics", {}), time):
            print(line, file=sys.stderr)
        return
    print(
        f"{report['method']}: t = {report['t']:g} after {report['steps']} steps{_length(report)}, "
        f"{report['rejections']} rejected, {report['evaluations']} evaluations, "
        f"{1000 * report['seconds']:.3g} ms",
        file=sys.stderr,
    )
    if report["held"] > HELD * report["steps"]:
        print(
            f"{report['method']}: its iteration, not its error, kept {report['held']} of "
            f"{report['steps']} steps short: the model is stiff at this tolerance; --method gauss4 "
            "(fixed steps, Newton) or dop853 may take less time",
            file=sys.stderr,
        )
    for event in report["events"]:
        print(f"event {event['name']}: {_crossings(event)}", file=sys.stderr)
    said = diagnostics_text.drift_lines(report["drifts"])
    said += diagnostics_text.lines(report.get("diagnostics", {}), time)
    for line in said:
        print(line, file=sys.stderr)


def _whole(outcome: Outcome) -> bool:
    """Whether the motion was integrated to its end; a diagnostic, made after it, may fail."""
    return outcome.code == DONE or "diagnostics" in outcome.report


def _crossings(event: dict) -> str:
    """How often, and when for the first and the last time."""
    times, count = event["times"], event["count"]
    if count < 2:
        return f"once, at t = {times[0]:.12g}" if count else "never"
    last = f", last at {times[-1]:.12g}" if len(times) == count else ""
    return f"{count} times, first at t = {times[0]:.12g}{last}"
