"""`python -m bench rotations [--quick] [--only TEXT] [--docs]`: cost of rotations and constraints.

Each motion of rotation_cases.py in all its forms, by pkgen's methods, and by the peers on
equations written by hand: time, steps and evaluations to a final error, as in `make bench`, all in
turns in one run; then the ratios of the best of each form; then what a million steps leave of
energy, angular momentum and unit length (rotation_drift.py). Errors are of the matrix and the body
rates, or of places and velocities, against the equations by hand in `__float128` (reference.py).
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from . import (
    codegen,
    environment,
    machine,
    matching,
    measure,
    reference,
    report,
    rotation_drift,
    tables,
)
from .attitudes import of_quaternion
from .builds import BUILDS, OUTPUT, Broken
from .chosen import chosen
from .measure import Comparison, Effort, Track
from .peers import forms, quaternion
from .rotation_cases import CASES, Case

ERRORS = (1e-6, 1e-9, 1e-12)
SMALL, ROUNDED = 1e-2, 1e-11  # between these errors an order shows
ALIKE = 0.1  # by these parts, of steps and of longer ones
FULL = Effort(starts=5, rounds=9, seconds=90, each=0.002, builds=BUILDS)
QUICK = Effort(starts=1, rounds=3, seconds=5, each=0.0005, builds=BUILDS)
HOW = """Written by `python -m bench rotations --docs`. Cells are µs (steps, evaluations) of one
integration to a final error of the matrix and the body rates, or of places and velocities,
medians of at most {rounds} rounds over {starts} starts; between two settings log-linear, "≤" where
the loosest is better already, "-" where none gets there. All of pkgen's are compiled as `pkgen run`
does it. "angles, reduced" is what a scene that records all angles leaves: cyclic ones are
states. "by hand": Euler's equations and a quaternion (heyoka's series have no evaluations).
Orders are those measured, "-" where no three steps show the same.

Then what many steps leave of a rigid body, µs a step and a second of its motion, and the largest
change of its energy (beside the largest kinetic energy), of its angular momentum (the vertical part
of the top's) and of its quaternion's length."""


def main(words: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m bench rotations", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one start, three rounds")
    parser.add_argument("--only", default="", help="motions whose name has this text")
    parser.add_argument("--docs", action="store_true", help="write docs/dev/results/benchmarks.md")
    arguments = parser.parse_args(words)
    if Path(sys.prefix) != environment.VENV:
        return environment.with_peers("rotations", words)
    OUTPUT.mkdir(parents=True, exist_ok=True)
    here = machine.describe()
    effort = QUICK if arguments.quick else FULL
    parts, failed = {}, []
    for case in chosen([made() for made in CASES], arguments.only, lambda case: case.name):
        parts[case.name.capitalize()], broken = part(case, effort)
        failed += broken
    sections = "\n\n".join(f"### {title}\n\n{text}" for title, text in parts.items())
    print(sections)
    if arguments.docs:
        how = HOW.format(rounds=effort.rounds, starts=effort.starts)
        said = "\n".join(here.lines())
        report.write_block(
            "rotations", f"## Rotations and constraints\n\n{how}\n\n{said}\n\n{sections}\n"
        )
    for why in failed:
        _say(f"bench: failed: {why}")
    return 1 if failed else 0


def part(case: Case, effort: Effort) -> tuple[str, list[str]]:
    """Its text, and what should have taken part and failed."""
    found = compared(case, effort)
    missing = "\n".join(f"- {name}: {why}" for name, why in found.refused.items())
    steps = rotation_drift.QUICK if effort is QUICK else rotation_drift.STEPS
    drifts = rotation_drift.drifts(case, steps) if case.by_quaternion else ""
    text = "\n\n".join(filter(None, (costs(found), ratios(found), missing, drifts)))
    refused = found.refused.items()
    return text, [f"{case.name}: {n}: {why}" for n, why in refused if isinstance(why, Broken)]


def compared(case: Case, effort: Effort) -> Comparison:
    contenders = [*forms.contenders(case), *by_hand(case)]
    return measure.compare(case, contenders, exact(case, effort.starts), effort, _say)


def exact(case: Case, starts: int) -> list[list[float]]:
    """What all forms have at the end, of each start."""
    text = codegen.written_out(case, list(case.acceleration), "real")
    given = [case.given(start) for start in case.starts(starts)]
    steps = round(case.steps * case.t_end)
    return [case.seen(y) for y in reference.finals_by(case, text, given, case.t_end, steps)]


def by_hand(case: Case) -> Iterator:
    """The peers, given a quaternion and body rates."""
    if not case.by_quaternion:
        return

    def given(start):
        return case.given(start)[case.n :]

    for peer in quaternion.contenders():

        def opened(_, builds, peer=peer):
            return [forms.Seen(s, given, of_quaternion) for s in peer.open(case, builds)]

        yield replace(peer, open=opened)


def costs(found: Comparison) -> str:
    rows = [(t.name, order(t), *(cost(t, error) for error in ERRORS)) for t in found.tracks]
    return tables.table(("µs (steps, evaluations) to", "order", *map(_power, ERRORS)), rows)


def order(track: Track) -> str:
    """Of a fixed step, by the shortest of steps half as long whose errors are no rounding, where
    longer ones show the same: the median over the starts."""
    if not track.contender.fixed_step:
        return ""
    pairs = zip(track.settings, track.errors, track.settings[1:], track.errors[1:], strict=False)
    slopes = [
        statistics.median(
            math.log(a / b) / math.log(long / short) for a, b in zip(coarse, fine, strict=True)
        )
        for long, coarse, short, fine in pairs
        if statistics.median(coarse) < SMALL and min(fine) > ROUNDED
    ]
    agree = len(slopes) > 1 and abs(slopes[-2] / slopes[-1] - 1) < ALIKE
    return f"{slopes[-1]:.1f}" if agree else "-"


def cost(track: Track, error: float) -> str:
    match = matching.seconds_at(track.curve(), error)
    if match is None:
        return "-"
    steps, evaluations = (taken(track, kind, error) for kind in (0, 1))
    bound = "≤ " if match.bound else ""
    shown = f"{1e6 * match.seconds:.3g}" if match.seconds < 1e-3 else f"{1e6 * match.seconds:.0f}"
    return f"{bound}{shown} ({steps:.0f}, {evaluations:.0f})".replace(", nan", "")


def taken(track: Track, kind: int, error: float) -> float:
    """Steps or evaluations, as time is found."""
    counts = [[track.session.took[s][kind]] for s in track.settings]
    match = matching.seconds_at(matching.curve(track.settings, track.errors, counts), error)
    return match.seconds if match else float("nan")


def ratios(found: Comparison) -> str:
    """Of the best of each form to the best by `rotation` or `constraint`, round by round."""
    groups: dict[str, list[Track]] = {}
    for track in found.tracks:
        form = track.name.partition(": ")[0]
        groups.setdefault(track.name if form == "by hand" else form, []).append(track)
    own = next((name for name in ("rotation", "rods") if name in groups), None)
    if own is None:
        return ""
    rows = [
        (f"{name} / {own}", *(ratio(groups[name], groups[own], error) for error in ERRORS))
        for name in groups
        if name != own
    ]
    return tables.table((f"times that of {own}, best method", *map(_power, ERRORS)), rows)


def ratio(tracks: list[Track], own: list[Track], error: float) -> str:
    """Round by round, median [quartiles]."""
    one, other = best(tracks, error), best(own, error)
    if one is None or other is None:
        return "-"
    pairs = list(zip(one.matched(error), other.matched(error), strict=False))
    a, b = zip(*((x.seconds, y.seconds) for x, y in pairs), strict=True)
    found = matching.ratio(a, b)
    methods = f"{one.name.rpartition(': ')[2]}, {other.name.rpartition(': ')[2]}"
    return f"{found.median:.3g} [{found.low:.3g}, {found.high:.3g}] {methods}"


def best(tracks: list[Track], error: float) -> Track | None:
    reached = [t for t in tracks if None not in t.matched(error)]
    return min(reached, key=lambda t: _typical(t, error), default=None)


def _typical(track: Track, error: float) -> float:
    return statistics.median(m.seconds for m in track.matched(error) if m)


def _power(x: float) -> str:
    return f"{x:.0e}".replace("e-0", "e-")


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
